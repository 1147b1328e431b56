//! No step loses a solution that jumps: random models, starts, inputs and steps against true solutions.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod common;

use common::hybrid::{Events, Sim};
use common::jumping::{ALL, Jumping};
use common::{Rng, Trials, interval, number, read};
use veribound_flow::{StepOptions, System, Workspace, reduced};
use veribound_interval::Interval;

/// How far true solutions are wrong, at most.
const SLACK: f64 = 2e-6;

struct Follower {
    system: System,
    workspace: Workspace,
    boxes: Vec<Vec<Interval>>,
    tube: Vec<Interval>,
    velocity: Vec<Interval>,
    params: Vec<Interval>,
}

impl Follower {
    fn step(&mut self, inputs: &[Interval], h: f64) -> bool {
        let mut next = Vec::new();
        let hull = |all: &mut Vec<Interval>, more: &[Interval]| {
            for (all, more) in all.iter_mut().zip(more) {
                *all = all.hull(*more);
            }
        };
        self.tube.fill(Interval::EMPTY);
        self.velocity.fill(Interval::EMPTY);
        for states in &self.boxes {
            let w = &mut self.workspace;
            let dt = Interval::point(h);
            let Ok((ends, _)) = self.system.step_apart(states, &self.params, inputs, dt, w) else {
                return false;
            };
            next.extend(ends);
            hull(&mut self.tube, w.tube());
            hull(&mut self.velocity, w.velocity());
        }
        self.boxes = reduced(next);
        true
    }

    fn width(&self) -> f64 {
        let all = self.boxes.iter().flatten();
        all.map(|x| x.width()).fold(0.0, f64::max)
    }
}

fn inside(b: &[Interval], x: &[f64], slack: f64) -> bool {
    let near = interval(-slack, slack);
    b.iter().zip(x).all(|(b, x)| (*b + near).contains(*x))
}

#[derive(Debug, Default)]
struct Seen {
    steps: u64,
    failed: u64,
    events: Events,
    trials: Trials,
}

/// Follows one set of starts and true solutions from it.
fn attack(model: &Jumping, seed: u64, seen: &mut Seen) {
    let mut rng = Rng(seed);
    let width = rng.pick(&[0.0, 1e-6, 0.1, 1.0]) * model.widest;
    let (start, params) = model.draw(&mut rng, width);
    let step = rng.pick(model.steps);
    let system = System::new(&read(model.name, model.text));
    let options = StepOptions {
        longest: step / rng.pick(&[1.0, 1.0, 4.0]),
        order: rng.pick(&[1, 2, 3]),
        ..StepOptions::default()
    };
    let mut follower = Follower {
        workspace: Workspace::new(&system, options),
        system,
        tube: start.clone(),
        velocity: start.clone(),
        boxes: vec![start.clone()],
        params: params.clone(),
    };
    let mut inputs: Vec<Interval> = Vec::new();
    let mut truths: Vec<Sim> = (0..8)
        .map(|_| {
            let x: Vec<f64> = start.iter().map(|x| rng.inside(*x)).collect();
            let p: Vec<f64> = params.iter().map(|p| rng.inside(*p)).collect();
            Sim::new(model.hybrid, &x, &p, &[])
        })
        .collect();
    for k in 0..12 {
        if k == 0 || rng.chance(0.3) {
            inputs.clear();
            for range in model.inputs {
                let lo = rng.between(range.0, range.1);
                inputs.push(interval(lo, lo + rng.pick(&[0.0, 0.3]) * width));
            }
        }
        if !follower.step(&inputs, step) {
            seen.failed += 1;
            break;
        }
        seen.steps += 1;
        for truth in &mut truths {
            for part in [0.37, 0.63] {
                truth.u = inputs.iter().map(|u| rng.inside(*u)).collect();
                truth.advance(part * step, &mut rng);
                let say = |what: &str, set: &[Interval]| {
                    panic!(
                        "{} {seed}, step {k} of {step}: {what} {:?} not in {set:?} (boxes {:?})",
                        model.name, truth.x, follower.boxes
                    );
                };
                if !inside(&follower.tube, &truth.x, SLACK) {
                    say("on the way", &follower.tube);
                }
                // A velocity may be asked where it does not jump.
                let velocity = truth.velocity(&truth.x);
                if !inside(&follower.velocity, &velocity, 1e-3) {
                    say(&format!("velocity {velocity:?} at"), &follower.velocity);
                }
            }
            let found = follower.boxes.iter().any(|b| inside(b, &truth.x, SLACK));
            assert!(
                found,
                "{} {seed}, step {k} of {step}: {:?} not in {:?}; from {start:?}, {params:?}, \
                 {inputs:?}",
                model.name, truth.x, follower.boxes
            );
            seen.trials.checks += 3;
        }
        if follower.width() > 10.0 {
            break;
        }
    }
    seen.trials.solutions += truths.len() as u64;
    for truth in truths {
        seen.events.add(truth.events);
    }
}

#[test]
fn no_step_loses_a_solution_that_jumps() {
    let (first, cases) = (number("VERIBOUND_SEED", 0), number("VERIBOUND_ROUNDS", 60));
    let mut trials = Trials::default();
    for model in ALL {
        let mut seen = Seen::default();
        for seed in first..first + cases {
            attack(model, seed, &mut seen);
        }
        println!("{}: {seen:?}", model.name);
        trials.add(seen.trials);
        assert!(seen.events.jumps >= cases, "{}: {seen:?}", model.name);
        assert!(seen.steps >= 3 * cases, "{}: {seen:?}", model.name);
    }
    trials.told("single steps of models that jump");
}

fn follow(model: &Jumping, start: &[f64], params: &[f64], step: f64) -> Follower {
    let points = |list: &[f64]| -> Vec<Interval> {
        let list = list.iter();
        list.map(|x| Interval::point(*x)).collect()
    };
    let system = System::new(&read(model.name, model.text));
    let options = StepOptions {
        longest: step,
        ..StepOptions::default()
    };
    Follower {
        workspace: Workspace::new(&system, options),
        system,
        tube: points(start),
        velocity: points(start),
        boxes: vec![points(start)],
        params: points(params),
    }
}

/// Touched with no speed at all, a border lets a solution pass or makes it jump.
#[test]
fn what_is_grazed_may_jump_or_not() {
    let model = &ALL.iter().find(|model| model.name == "latch").unwrap();
    for step in [0.125, 0.25, 0.5] {
        let mut follower = follow(model, &[0.125, -1.0, 0.0, 0.0], &[4.0], step);
        let mut time = 0.0;
        while time < 0.5 {
            assert!(follower.step(&[], step), "after {time} s");
            time += step;
        }
        let jumped = 1.0 - (-0.25_f64).exp();
        for end in [[0.125, 1.0, 0.0, 0.0], [0.125, 1.0, 1.0, jumped]] {
            let found = follower.boxes.iter().any(|b| inside(b, &end, 1e-12));
            assert!(found, "{end:?} not in {:?}", follower.boxes);
        }
    }
}

/// A jump at the instant at which a step ends is before the end or after it.
#[test]
fn a_jump_at_a_sample_is_before_it_or_after_it() {
    let model = &ALL.iter().find(|model| model.name == "clock").unwrap();
    for step in [0.125, 0.25, 0.5] {
        let mut follower = follow(model, &[0.0, 0.0, 0.0], &[1.0], step);
        let mut time = 0.0;
        while time < 1.0 {
            assert!(follower.step(&[], step), "after {time} s");
            time += step;
            let x = 1.0 - (-(time - 0.5).max(0.0)).exp();
            let n = if time > 0.5 { 1.0 } else { 0.0 };
            let mut wanted = vec![[time % 0.5, x, n]];
            if time % 0.5 == 0.0 {
                wanted = vec![[0.5, x, time / 0.5 - 1.0], [0.0, x, 2.0 - time / 0.5]];
                if time == 0.5 {
                    wanted[1][2] = 1.0;
                }
            }
            for end in wanted {
                let found = follower.boxes.iter().any(|b| inside(b, &end, 1e-9));
                assert!(found, "{time} s: {end:?} not in {:?}", follower.boxes);
            }
            assert!(follower.boxes.len() <= 3, "{:?}", follower.boxes);
        }
    }
}
