//! The drive-train rig: boxes against its exact closed form.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that fails stops"
)]

mod common;

use common::{Rng, rig_model, rig_step};
use veribound_flow::{StepOptions, System, Workspace};
use veribound_interval::Interval;
use veribound_interval::lanes::{Interval8, Mask};

fn interval(lo: f64, hi: f64) -> Interval {
    Interval::new(lo, hi).unwrap()
}

/// Modes of the rig, in the order of its file.
const FORWARD: usize = 0;
const STICK: usize = 1;
const BACKWARD: usize = 2;

/// Rounding of the closed form in `common`, which is plain floating point.
const SLACK: f64 = 1e-10;

#[test]
fn exact_trajectories_stay_inside_and_the_hull_is_tight() {
    let model = rig_model();
    let system = System::new(&model);
    let mut workspace = Workspace::new(&system, StepOptions::default());
    let mut rng = Rng(7);
    let mut excess_sum = [0.0; 2];
    let mut trials = 0.0;
    let mut pruned = 0;
    for _ in 0..2000 {
        let w = rng.between(-1.0, 1.0) * if rng.unit() < 0.3 { 0.0 } else { 1.5 };
        let w_width = if rng.unit() < 0.3 {
            0.0
        } else {
            rng.between(0.0, 0.6)
        };
        let omega = interval(w, w + w_width);
        let phi = interval(0.0, 0.1);
        let a = rng.between(-6.0, -0.05);
        let alpha = interval(a, (a + rng.between(0.0, 2.0)).min(-0.01));
        let b = rng.between(1.0, 300.0);
        let beta = interval(b, b + rng.between(0.0, 100.0));
        let t = rng.between(0.0, 0.3);
        let level = interval(t, t + rng.between(0.0, 0.1));
        let u = rng.between(-0.35, 0.35);
        let input = interval(u, u);
        let mut states = [phi, omega];
        let params = [alpha, beta, level];
        let report = system.step(
            &mut states,
            &params,
            &[input],
            Interval::point(0.01),
            &mut workspace,
        );
        let during = report.unwrap().modes_during;
        let mut hull = [Interval::EMPTY; 2];
        for trial in 0..200 {
            // Corners first: the extremes of a monotone map.
            let pick = |rng: &mut Rng, x: Interval, bit: u32| {
                if trial < 32 {
                    if trial >> bit & 1 == 0 {
                        x.lo()
                    } else {
                        x.hi()
                    }
                } else {
                    rng.between(x.lo(), x.hi())
                }
            };
            let phi0 = if trial % 2 == 0 { phi.lo() } else { phi.hi() };
            let w0 = pick(&mut rng, omega, 0);
            let p = [
                pick(&mut rng, alpha, 1),
                pick(&mut rng, beta, 2),
                pick(&mut rng, level, 3),
            ];
            let (phi1, w1) = rig_step(phi0, w0, u, p, 0.01);
            for (state, x) in [phi1, w1].into_iter().enumerate() {
                let allowed = states[state];
                assert!(
                    x >= allowed.lo() - SLACK && x <= allowed.hi() + SLACK,
                    "state {state}: {x} outside {allowed:?} (omega {omega:?} u {u} p {params:?})"
                );
                hull[state] = hull[state].hull(Interval::point(x));
            }
            let middle = rng.unit() * 0.01;
            let (phi1, w1) = rig_step(phi0, w0, u, p, middle);
            for (state, x) in [phi1, w1].into_iter().enumerate() {
                let tube = workspace.tube()[state];
                assert!(
                    x >= tube.lo() - SLACK && x <= tube.hi() + SLACK,
                    "state {state}: {x} outside the tube {tube:?}"
                );
            }
            // Speeds of the order of rounding could be of either sign.
            if w1 == 0.0 || w1.abs() > SLACK {
                let mode = if w1 > 0.0 || (w1 == 0.0 && u > p[2]) {
                    FORWARD
                } else if w1 < 0.0 || (w1 == 0.0 && u < -p[2]) {
                    BACKWARD
                } else {
                    STICK
                };
                assert!(
                    during.contains(mode),
                    "mode {mode} is missing in {during:?}"
                );
                pruned += usize::from(during.len() < 3);
            }
        }
        trials += 1.0;
        for state in 0..2 {
            let excess = states[state].width() - hull[state].width();
            excess_sum[state] += excess;
            if excess > 0.15 {
                println!(
                    "excess {state} {excess:.3}: omega {omega:?} u {u} {params:?} -> {:?} hull {:?}",
                    states[state], hull[state]
                );
            }
        }
    }
    let mean = excess_sum.map(|sum| sum / trials);
    println!("mean excess width {mean:?}");
    assert!(mean[0] < 1e-3 && mean[1] < 0.02, "mean excess {mean:?}");
    assert!(pruned > 200_000, "{pruned} times a mode was excluded");
}

#[test]
fn a_standing_rig_stands() {
    let model = rig_model();
    let system = System::new(&model);
    let mut workspace = Workspace::new(&system, StepOptions::default());
    let mut states = [interval(-0.1, 0.1), Interval::ZERO];
    let params = [
        interval(-6.0, -0.05),
        interval(1.0, 400.0),
        interval(0.13, 0.3),
    ];
    for _ in 0..1000 {
        let inputs = [interval(0.11, 0.12)];
        system
            .step(
                &mut states,
                &params,
                &inputs,
                Interval::point(0.01),
                &mut workspace,
            )
            .unwrap();
        let boxes: Vec<Interval8> = states
            .iter()
            .chain(&params)
            .map(|x| Interval8::splat(*x))
            .collect();
        let [modes, ..] = system.active_modes(&boxes, Mask::lane(0), &inputs, &mut workspace);
        assert_eq!(modes.iter().collect::<Vec<_>>(), [1]);
    }
    assert_eq!(states[1], Interval::ZERO);
    assert!(states[0].width() < 0.2 + 1e-9, "{:?}", states[0]);
}
