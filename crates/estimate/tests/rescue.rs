//! Boxes that cannot be integrated whole: their halves go on, and nothing is lost on the way.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

#[path = "../../flow/tests/common/mod.rs"]
mod common;

use common::read;
use veribound_estimate::{Observer, ObserverOptions, Verdict};
use veribound_interval::{Decimal, Interval};
use veribound_model::Sample;

/// The root is defined for every speed, but evaluated on a wide box its argument seems to be
/// negative somewhere: boxes half as wide as the first one, too, cannot be integrated.
const WAVY: &str = r#"
format = 1
name = "wavy"
[states]
x = { unit = "m", init = [-0.1, 0.1] }
v = { unit = "m/s", init = [0, 2] }
[der]
x = "v"
v = "0.1*sqrt(v*v - 2*v + 2.2)"
[outputs]
y = { expr = "x", unit = "m", error = { absolute = 0.02 } }
"#;

fn sample(k: i64, x: f64) -> Sample {
    Sample {
        time: Decimal::parse(&format!("{}e-2", 5 * k)).unwrap(),
        line: k as usize + 2,
        inputs: Vec::new(),
        outputs: vec![Interval::new(x - 0.02, x + 0.02)],
        signals: Vec::new(),
    }
}

fn options(windows: &[u64]) -> ObserverOptions {
    ObserverOptions {
        boxes: 12,
        bisections: 0,
        windows: windows.to_vec(),
        ..ObserverOptions::default()
    }
}

/// One step of the fourth-order Runge-Kutta method, far finer than the tolerance of the test.
fn advance((x, v): (f64, f64)) -> (f64, f64) {
    let slope = |v: f64| 0.1 * (v * v - 2.0 * v + 2.2).sqrt();
    let (mut x, mut v) = (x, v);
    let h = 0.05 / 100.0;
    for _ in 0..100 {
        let k1 = slope(v);
        let k2 = slope(v + 0.5 * h * k1);
        let k3 = slope(v + 0.5 * h * k2);
        let k4 = slope(v + h * k3);
        x += h * (v + h * (k1 + k2 + k3) / 6.0);
        v += h * (k1 + 2.0 * k2 + 2.0 * k3 + k4) / 6.0;
    }
    (x, v)
}

#[test]
fn halves_of_a_box_that_failed_remember_their_past() {
    let model = read("wavy", WAVY);
    for windows in [&[][..], &[2, 5], &[1, 8]] {
        for v0 in [0.01, 0.7, 1.0, 1.3, 1.99] {
            let mut observer = Observer::new(&model, options(windows));
            let mut truth = (0.03, v0);
            for k in 0..40 {
                let before = observer.box_steps();
                let boxes = observer.cells().len() as u64;
                let noise = if k % 2 == 0 { 0.0199 } else { -0.0199 };
                let verdict = observer.step(&sample(k, truth.0 + noise)).unwrap();
                let story = format!("windows {windows:?} v0 {v0} sample {k}");
                assert!(
                    matches!(verdict, Verdict::Consistent(_)),
                    "{story}: {verdict:?}"
                );
                let inside = observer.cells().iter().any(|cell| {
                    let near =
                        |x: Interval, value: f64| x.lo() - 1e-7 <= value && value <= x.hi() + 1e-7;
                    near(cell.z[0], truth.0) && near(cell.z[1], truth.1)
                });
                assert!(inside, "{story}: {truth:?} is in no box");
                if k == 1 {
                    let steps = observer.box_steps() - before;
                    assert!(steps > boxes, "{story}: nothing was halved");
                }
                truth = advance(truth);
            }
        }
    }
}

#[test]
fn an_undecided_step_leaves_the_boxes_of_the_last_sample() {
    // Below -0.25 the root does not exist: no half helps.
    let text = WAVY.replace("v*v - 2*v + 2.2", "v + 0.25");
    let text = text.replace("init = [0, 2]", "init = [-1, 2]");
    let model = read("rootless", &text);
    let mut observer = Observer::new(&model, options(&[2, 5]));
    observer.step(&sample(0, 0.0)).unwrap();
    let before = observer.cells().to_vec();
    let verdict = observer.step(&sample(1, 0.0)).unwrap();
    assert!(matches!(verdict, Verdict::Undecided(_)), "{verdict:?}");
    assert_eq!(observer.cells(), before);
}
