//! Fifty masses between springs, each with dry friction: modes in groups, not their product.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod common;

use common::{Rng, read};
use veribound_flow::form::{Effort, Flow, FormOptions, Stretch};
use veribound_flow::{StepOptions, System, Workspace};
use veribound_interval::Interval;

const MASSES: usize = 50;

const CHAIN: &str = r#"
    format = 1
    states = ["x{i=1..n}", "v{i=1..n}"]
    inputs = ["F"]
    params = { k = [50, 200], T = [0.5, 2] }
    outputs.y = "x1 +- 1"

    [sizes]
    n = 50

    [init]
    "x{i=1..n}" = 0
    "v{i=1..n}" = 0

    [let]
    x0 = "0"
    x51 = "x50"
    "pull1" = "F + k*(x2 - x1)"
    "pull{i=2..n}" = "k*(x{i-1} - 2*x{i} + x{i+1})"

    [der]
    "x{i=1..n}" = "v{i}"
    "v{i=1..n}" = "pull{i} - friction(v{i}, pull{i}, T)"
"#;

#[test]
fn fifty_masses_with_friction() {
    let model = read("chain", CHAIN);
    assert_eq!((model.groups.len(), model.modes.len()), (51, 151));
    let system = System::new(&model);
    let mut workspace = Workspace::new(&system, StepOptions::default());
    let params = [Interval::point(100.0), Interval::point(1.0)];
    let mut states = vec![Interval::ZERO; 2 * MASSES];
    let mut step = |states: &mut [Interval], force: f64, h: f64| {
        let (inputs, h) = ([Interval::point(force)], Interval::point(h));
        let report = system.step(states, &params, &inputs, h, &mut workspace);
        report.unwrap_or_else(|failure| panic!("{failure:?}"));
    };
    // Less than the friction holds all of them, exactly.
    step(&mut states, 0.9, 0.01);
    assert!(states.iter().all(|x| *x == Interval::ZERO));
    // More pulls the first one off, then the second; the far ones never feel it.
    let (mut x, mut v) = (vec![0.0; MASSES + 2], vec![0.0; MASSES + 2]);
    for k in 0..40 {
        step(&mut states, 3.0, 0.005);
        let parts = 2000;
        for _ in 0..parts {
            pull(&mut x, &mut v, [3.0, 100.0, 1.0], 0.005 / f64::from(parts));
        }
        for i in 1..=MASSES {
            let near = Interval::new(-1e-4, 1e-4).unwrap();
            let inside = (states[i - 1] + near).contains(x[i]);
            assert!(
                inside,
                "step {k}, mass {i}: {} not in {}",
                x[i],
                states[i - 1]
            );
        }
        assert_eq!(states[MASSES + 49], Interval::ZERO);
    }
    assert!(states[0].lo() > 0.0 && x[2] > 0.0);
}

/// Pulled off, let go, and at rest again: what moves depends on what is held, and is held itself later.
#[test]
fn forms_of_chains_contain_the_solutions() {
    let bounds = [(99.0, 101.0), (0.98, 1.02)];
    let params = bounds.map(|(lo, hi)| common::interval(lo, hi));
    let force = |k: usize| if k < 15 { 3.0 } else { 0.0 };
    for masses in [2, 4, 7] {
        let text = CHAIN
            .replace("n = 50", &format!("n = {masses}"))
            .replace("x51 = \"x50\"", &format!("x{} = \"x{masses}\"", masses + 1));
        let flow = Flow::new(&read("chain", &text));
        let stretches = (0..40).map(|k| Stretch {
            inputs: vec![Interval::point(force(k))],
            dt: Interval::point(0.0078125),
        });
        let stretches: Vec<Stretch> = stretches.collect();
        let start = vec![Interval::ZERO; 2 * masses];
        let effort = Effort {
            parts: 1,
            ..Effort::default()
        };
        let found = flow.enclose(&start, &params, &stretches, FormOptions::default(), effort);
        assert_eq!(found.ends.len(), 40, "{:?}", found.stopped);
        let mut rng = Rng(7);
        for round in 0..12 {
            let at = |corner: usize, x: Interval| {
                if round >> corner & 1 == 1 {
                    x.hi()
                } else {
                    x.lo()
                }
            };
            let point: Vec<f64> = if round < 4 {
                params.iter().enumerate().map(|(i, x)| at(i, *x)).collect()
            } else {
                params.iter().map(|x| rng.inside(*x)).collect()
            };
            let (mut x, mut v) = (vec![0.0; masses + 2], vec![0.0; masses + 2]);
            for (k, end) in found.ends.iter().enumerate() {
                let parts = 1000;
                for _ in 0..parts {
                    let law = [force(k), point[0], point[1]];
                    pull(&mut x, &mut v, law, 0.0078125 / f64::from(parts));
                }
                for i in 1..=masses {
                    for (exact, found) in [(x[i], end[i - 1]), (v[i], end[masses + i - 1])] {
                        let inside = exact >= found.lo() - 1e-4 && exact <= found.hi() + 1e-4;
                        assert!(
                            inside,
                            "{masses}: step {k}, mass {i}: {exact} not in {found}"
                        );
                    }
                }
            }
        }
        // What never felt it is where it was.
        let last = &found.ends[39];
        let untouched = last[..masses].iter().filter(|x| x.mag() < 1e-12);
        assert_eq!(untouched.count(), masses - 2);
        assert!(last[0].lo() > 0.0 && last[masses..].iter().all(|v| v.width() < 0.03));
    }
}

/// A small step of the chain by Euler's method, plain numbers: the pull, the springs and the friction.
fn pull(x: &mut [f64], v: &mut [f64], [force, k, friction]: [f64; 3], h: f64) {
    let (old, masses) = (x.to_vec(), x.len() - 2);
    for i in 1..=masses {
        let spring = match i {
            1 => force + k * (old[2] - old[1]),
            _ if i == masses => k * (old[i - 1] - old[i]),
            _ => k * (old[i - 1] - 2.0 * old[i] + old[i + 1]),
        };
        let free = v[i] + h * spring;
        // Friction takes away at most `h` times its level of the speed.
        v[i] = free - free.clamp(-h * friction, h * friction);
        x[i] += h * v[i];
    }
}
