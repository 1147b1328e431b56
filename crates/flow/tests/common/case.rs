//! Random cases of the models that switch.

use super::models::Target;
use super::truth::Sim;
use super::{Rng, interval};
use veribound_flow::form::{FormOptions, Stretch};
use veribound_interval::Interval;

/// Error of the simulator in `common::truth`.
const SLACK: f64 = 4e-9;

/// A box in a range, often around a value worth hitting, that is at most `widest` of the range wide.
fn draw(rng: &mut Rng, lo: f64, hi: f64, special: &[f64], widest: f64) -> Interval {
    let at = if !special.is_empty() && rng.chance(0.3) {
        rng.pick(special)
    } else {
        rng.between(lo, hi)
    };
    let width = match rng.below(4) {
        0 => 0.0,
        1 => 1e-6,
        _ => rng.unit() * widest * (hi - lo),
    };
    let share = rng.pick(&[0.0, 0.5, 1.0, rng.clone().unit()]);
    interval(
        (at - share * width).max(lo),
        (at + (1.0 - share) * width).min(hi),
    )
}

/// Some options of forms.
pub fn options(rng: &mut Rng) -> FormOptions {
    let degree = rng.pick(&[None, Some(1), Some(2), Some(3)]);
    FormOptions {
        degree,
        order: rng.pick(&[None, None, Some(6), Some(15)]),
        closed: rng.clone().chance(0.5),
        ..FormOptions::default()
    }
}

/// Sets of start values, parameters and inputs of a model that switches.
#[derive(Debug)]
pub struct Case {
    pub start: Vec<Interval>,
    pub params: Vec<Interval>,
    pub stretches: Vec<Stretch>,
    pub lengths: Vec<f64>,
}

impl Case {
    pub fn draw(target: &Target, rng: &mut Rng) -> Case {
        let widest = rng.pick(&[0.003, 0.02, 0.1]);
        let params = target.params.iter();
        let params = params
            .map(|(lo, hi)| draw(rng, *lo, *hi, &[], widest))
            .collect();
        let states = target.states.iter();
        let start = states
            .map(|(lo, hi, special)| draw(rng, *lo, *hi, special, widest))
            .collect();
        let lengths: Vec<f64> = (0..1 + rng.below(6))
            .map(|_| {
                let spread = rng.between(0.001, 0.3);
                rng.pick(&[0.01, 0.01, 0.02, 0.1, 0.5, 1e-5, spread])
            })
            .collect();
        let stretches = lengths
            .iter()
            .map(|h| Stretch {
                inputs: target
                    .inputs
                    .iter()
                    .map(|(lo, hi, special)| {
                        let widest = rng.pick(&[0.0, 0.0, 0.01]);
                        draw(rng, *lo, *hi, special, widest)
                    })
                    .collect(),
                dt: Interval::point(*h),
            })
            .collect();
        Case {
            start,
            params,
            stretches,
            lengths,
        }
    }

    /// Points of the sets, start values and parameters, with true solutions.
    pub fn solutions(&self, target: &Target, rng: &mut Rng) -> Vec<(Vec<f64>, Vec<f64>, Sim)> {
        let point = |rng: &mut Rng, list: &[Interval]| -> Vec<f64> {
            list.iter().map(|x| rng.inside(*x)).collect()
        };
        (0..12)
            .map(|_| {
                let mut x = point(rng, &self.start);
                for (x, (b, (_, _, special))) in
                    x.iter_mut().zip(self.start.iter().zip(target.states))
                {
                    if !special.is_empty() && rng.chance(0.3) {
                        let level = rng.pick(special);
                        if b.contains(level) {
                            *x = level;
                        }
                    }
                }
                let p = point(rng, &self.params);
                (x.clone(), p.clone(), Sim::new(target.truth, &x, &p))
            })
            .collect()
    }

    /// Moves a solution through one stretch, and checks that it stays in `tube`; says how often.
    pub fn follow(
        &self,
        k: usize,
        sim: &mut Sim,
        tube: &[Interval],
        rng: &mut Rng,
        what: &str,
    ) -> u64 {
        let stretch = &self.stretches[k];
        let h = self.lengths[k];
        let pieces = 1 + rng.below(3);
        let mut cuts: Vec<f64> = (1..pieces).map(|_| rng.unit() * h).collect();
        cuts.sort_by(f64::total_cmp);
        cuts.push(h);
        let mut now = 0.0;
        for &cut in &cuts {
            let u: Vec<f64> = stretch.inputs.iter().map(|x| rng.inside(*x)).collect();
            sim.advance(&u, cut - now, rng);
            now = cut;
            assert_inside(
                &format!("{what}, tube of stretch {k} at {now}"),
                self,
                sim,
                tube,
            );
        }
        cuts.len() as u64
    }
}

/// Stops where a solution is not in `boxes`.
pub fn assert_inside(what: &str, case: &Case, sim: &Sim, boxes: &[Interval]) {
    for (i, (x, b)) in sim.x.iter().zip(boxes).enumerate() {
        let slack = SLACK * (1.0 + x.abs());
        assert!(
            *x >= b.lo() - slack && *x <= b.hi() + slack,
            "{what}: state {i} is {x:?}, outside {b:?} by {:e}; start {:?} params {:?} stretches {:?}",
            (b.lo() - x).max(x - b.hi()),
            case.start,
            case.params,
            case.stretches,
        );
    }
}
