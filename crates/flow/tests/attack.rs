//! Random boxes, random models, random true solutions: no step may lose one.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod common;

use common::models::{self, Target};
use common::truth::{Events, Sim};
use common::{Rng, Trials, interval, number, read};
use veribound_flow::{StepFailure, StepOptions, System, Workspace};
use veribound_interval::Interval;

/// Error of the simulator in `common::truth`: Runge-Kutta steps of a few milliseconds, events
/// located to rounding, over at most a second.
const SLACK: f64 = 2e-9;

/// A random box edge: sometimes a point, sometimes thin, sometimes wide, often at `special`.
fn draw(rng: &mut Rng, lo: f64, hi: f64, special: &[f64]) -> Interval {
    let at = if !special.is_empty() && rng.chance(0.45) {
        rng.pick(special)
    } else if rng.chance(0.1) {
        rng.pick(&[lo, hi])
    } else {
        rng.between(lo, hi)
    };
    let width = match rng.below(6) {
        0 | 1 => 0.0,
        2 => 1e-9,
        3 => 0.02 * (hi - lo),
        4 => rng.unit() * 0.1 * (hi - lo),
        _ => rng.unit() * rng.unit() * (hi - lo),
    };
    let share = rng.pick(&[0.0, 0.0, 0.5, 1.0, 1.0, rng.clone().unit()]);
    interval(
        (at - share * width).max(lo),
        (at + (1.0 - share) * width).min(hi),
    )
}

fn assert_inside(what: &str, target: &Target, sim: &Sim, boxes: &[Interval], story: &str) {
    for (i, (x, b)) in sim.x.iter().zip(boxes).enumerate() {
        let slack = SLACK * (1.0 + x.abs());
        assert!(
            *x >= b.lo() - slack && *x <= b.hi() + slack,
            "{}: {what}: state {i} is {x:?}, outside {b:?} by {:e}; {story}",
            target.name,
            (b.lo() - x).max(x - b.hi())
        );
    }
}

/// What happened, the steps proved, those given up, and how often solutions were compared.
#[derive(Default)]
struct Tally {
    events: Events,
    proved: u64,
    given_up: u64,
    trials: Trials,
}

fn attack(target: &Target, seed: u64, cases: u64) -> Tally {
    let model = read(target.name, target.text);
    let system = System::new(&model);
    let mut rng = Rng(seed);
    let mut tally = Tally::default();
    for case in 0..cases {
        let options = StepOptions {
            order: 1 + rng.below(6),
            halvings: 6,
            longest: rng.pick(&[0.05, 0.05, 1.0, 0.004]),
        };
        let mut workspace = Workspace::new(&system, options);
        let params: Vec<Interval> = target
            .params
            .iter()
            .map(|(lo, hi)| draw(&mut rng, *lo, *hi, &[]))
            .collect();
        let start: Vec<Interval> = target
            .states
            .iter()
            .map(|(lo, hi, special)| draw(&mut rng, *lo, *hi, special))
            .collect();
        let point = |rng: &mut Rng, list: &[Interval]| -> Vec<f64> {
            list.iter().map(|x| rng.inside(*x)).collect()
        };
        let mut sims: Vec<Sim> = (0..14)
            .map(|_| {
                let mut x = point(&mut rng, &start);
                for (x, (b, (_, _, special))) in x.iter_mut().zip(start.iter().zip(target.states)) {
                    if !special.is_empty() && rng.chance(0.3) {
                        let level = rng.pick(special);
                        if b.contains(level) {
                            *x = level;
                        }
                    }
                }
                let p = point(&mut rng, &params);
                Sim::new(target.truth, &x, &p)
            })
            .collect();
        let mut states = start.clone();
        for step in 0..1 + rng.below(3) {
            let inputs: Vec<Interval> = target
                .inputs
                .iter()
                .map(|(lo, hi, special)| draw(&mut rng, *lo, *hi, special))
                .collect();
            let spread = rng.between(0.001, 0.1);
            let h = rng.pick(&[0.01, 0.01, 0.001, 1e-6, 0.05, 0.1, 0.2, spread]);
            let before = states.clone();
            match system.step(
                &mut states,
                &params,
                &inputs,
                Interval::point(h),
                &mut workspace,
            ) {
                Ok(_) => tally.proved += 1,
                Err(StepFailure::Unbounded) => panic!(
                    "{}: bounds crossed: {before:?} {params:?} {inputs:?} h {h} {options:?}",
                    target.name
                ),
                Err(_) => {
                    assert_eq!(states, before, "a failure changes nothing");
                    tally.given_up += 1;
                    break;
                }
            }
            for sim in &mut sims {
                let story = format!(
                    "case {case} step {step}: h {h} from {:?} in {before:?} params {params:?} \
                     inputs {inputs:?} {options:?}",
                    sim.x
                );
                let pieces = 1 + rng.below(3);
                let mut cuts: Vec<f64> = (1..pieces).map(|_| rng.unit() * h).collect();
                cuts.sort_by(f64::total_cmp);
                cuts.push(h);
                let mut now = 0.0;
                for cut in cuts {
                    let u = point(&mut rng, &inputs);
                    sim.advance(&u, cut - now, &mut rng);
                    now = cut;
                    assert_inside("tube", target, sim, workspace.tube(), &story);
                    tally.trials.checks += 1;
                }
                assert_inside("end", target, sim, &states, &story);
                tally.trials.checks += 1;
            }
        }
        for sim in &sims {
            tally.events.add(sim.events);
        }
        tally.trials.solutions += sims.len() as u64;
    }
    tally
}

#[test]
fn no_step_loses_a_solution() {
    let list = models::ALL.into_iter().chain([&models::RIG_EXPLICIT]);
    let (cases, seed) = (number("VERIBOUND_ROUNDS", 250), number("VERIBOUND_SEED", 1));
    let (mut failures, mut trials) = (Vec::new(), Trials::default());
    for (k, target) in list.enumerate() {
        let seed = seed * 1000 + k as u64;
        let run = std::panic::catch_unwind(|| attack(target, seed, cases));
        match run {
            Ok(tally) => {
                let Tally {
                    events,
                    proved,
                    given_up,
                    ..
                } = tally;
                trials.add(tally.trials);
                println!(
                    "{}: {proved} steps, {given_up} given up, {events:?}",
                    target.name
                );
                let met = events.captures + events.crossings + events.kinks;
                assert!(met > cases / 4, "{} meets no event", target.name);
                assert!(
                    given_up * 50 < proved,
                    "{} is given up too often",
                    target.name
                );
            }
            Err(_) => failures.push(target.name),
        }
    }
    trials.told("single steps");
    assert!(failures.is_empty(), "solutions lost: {failures:?}");
}
