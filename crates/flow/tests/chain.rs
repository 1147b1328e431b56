//! Fifty masses between springs, each with dry friction: modes in groups, not their product.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod common;

use common::read;
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
    let (mut x, mut v) = ([0.0_f64; MASSES + 2], [0.0_f64; MASSES + 2]);
    for k in 0..40 {
        step(&mut states, 3.0, 0.005);
        let parts = 2000;
        for _ in 0..parts {
            pull(&mut x, &mut v, 3.0, 0.005 / f64::from(parts));
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

/// A small step of the chain by Euler's method, plain numbers.
fn pull(x: &mut [f64; MASSES + 2], v: &mut [f64; MASSES + 2], force: f64, h: f64) {
    let old = *x;
    for i in 1..=MASSES {
        let spring = match i {
            1 => force + 100.0 * (old[2] - old[1]),
            MASSES => 100.0 * (old[i - 1] - old[i]),
            _ => 100.0 * (old[i - 1] - 2.0 * old[i] + old[i + 1]),
        };
        let free = v[i] + h * spring;
        // Friction takes away at most `h` times its level of the speed.
        v[i] = free - free.clamp(-h, h);
        x[i] += h * v[i];
    }
}
