//! Forms of models that jump: random sets and random true solutions; none may be lost.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod common;

use common::hybrid::{Events, Sim};
use common::jumping::{ALL, Jumping};
use common::stem::VALVE;
use common::{Rng, Trials, interval, number, read};
use veribound_flow::form::{Effort, Flow, FormOptions, Stretch};
use veribound_interval::Interval;

/// How far true solutions are wrong, at most.
const SLACK: f64 = 2e-6;

fn inside(b: &[Interval], x: &[f64]) -> bool {
    let near = interval(-SLACK, SLACK);
    b.iter().zip(x).all(|(b, x)| (*b + near).contains(*x))
}

#[derive(Debug, Default)]
struct Seen {
    proved: u64,
    stopped: u64,
    events: Events,
    trials: Trials,
}

fn attack(model: &Jumping, flow: &Flow, seed: u64, seen: &mut Seen) {
    let mut rng = Rng(seed);
    let width = rng.pick(&[0.0, 1e-6, 1e-3, 0.02, 0.1, 1.0]) * model.widest;
    let (start, params) = model.draw(&mut rng, width);
    let step = rng.pick(model.steps);
    let mut inputs: Vec<Interval> = Vec::new();
    let mut stretches = Vec::new();
    for k in 0..1 + rng.below(24) {
        if k == 0 || rng.chance(0.3) {
            inputs.clear();
            for range in model.inputs {
                let lo = rng.between(range.0, range.1);
                inputs.push(interval(lo, lo + rng.pick(&[0.0, 0.0, 0.3]) * width));
            }
        }
        stretches.push(Stretch {
            inputs: inputs.clone(),
            dt: Interval::point(step),
        });
    }
    let options = FormOptions {
        degree: rng.pick(&[None, Some(1), Some(2), Some(3)]),
        order: rng.pick(&[None, None, Some(6), Some(15)]),
        ..FormOptions::default()
    };
    let effort = Effort {
        parts: 1 + rng.below(2),
        ..Effort::default()
    };
    let found = flow.enclose(&start, &params, &stretches, options, effort);
    seen.proved += found.ends.len() as u64;
    seen.stopped += u64::from(found.stopped.is_some());
    for _ in 0..8 {
        let x: Vec<f64> = start.iter().map(|x| rng.inside(*x)).collect();
        let p: Vec<f64> = params.iter().map(|p| rng.inside(*p)).collect();
        let mut truth = Sim::new(model.hybrid, &x, &p, &[]);
        for (k, (end, tube)) in found.ends.iter().zip(&found.tubes).enumerate() {
            let say = |what: &str, x: &[f64], set: &[Interval]| {
                panic!(
                    "{} {seed}, {what} stretch {k} of {step}: {x:?} not in {set:?}; from {start:?}, {params:?}, \
                     {stretches:?} with {options:?}",
                    model.name
                );
            };
            for part in [0.37, 0.63] {
                truth.u = stretches[k].inputs.iter().map(|u| rng.inside(*u)).collect();
                truth.advance(part * step, &mut rng);
                if !inside(tube, &truth.x) {
                    say("on the way in", &truth.x, tube);
                }
            }
            if !inside(end, &truth.x) {
                say("at the end of", &truth.x, end);
            }
            seen.trials.checks += 3;
        }
        seen.trials.solutions += 1;
        seen.events.add(truth.events);
    }
}

#[test]
fn no_form_loses_a_solution_that_jumps() {
    let first = number("VERIBOUND_SEED", 0);
    let rounds = number("VERIBOUND_ROUNDS", 12);
    let mut trials = Trials::default();
    for model in ALL {
        let flow = Flow::new(&read(model.name, model.text));
        let mut seen = Seen::default();
        for seed in first..first + rounds {
            attack(model, &flow, seed, &mut seen);
        }
        println!("{}: {seen:?}", model.name);
        trials.add(seen.trials);
        assert!(seen.events.jumps > 0 && seen.proved > rounds, "{seen:?}");
    }
    trials.told("forms of models that jump");
}

/// A stem that stands on a stop, and reaches the other one, while boxes go on for all times: what rounding moves behind
/// the stop must not keep images of jumps from closing, or steps become ever shorter.
#[test]
fn what_stands_on_a_stop_takes_no_more_steps() {
    let flow = Flow::new(&read("valve", VALVE));
    let stretches = (0..60).map(|k: i32| Stretch {
        inputs: vec![Interval::point(f64::from(k.min(59 - k)) / 3.0)],
        dt: Interval::point(0.1),
    });
    let stretches: Vec<Stretch> = stretches.collect();
    let params = [interval(30.0, 90.0), interval(0.0, 3.0)];
    let start = [Interval::ZERO; 2];
    let effort = Effort {
        parts: 1,
        ..Effort::default()
    };
    let found = flow.enclose(&start, &params, &stretches, FormOptions::default(), effort);
    assert!(found.stopped.is_none(), "{:?}", found.stopped);
    assert!(found.steps < 1500, "{} steps", found.steps);
    let stem = interval(0.0, 0.05).inflate(1e-9);
    assert!(found.tubes.iter().all(|tube| tube[0].is_subset_of(stem)));
}
