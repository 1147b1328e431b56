//! Forms across switches: random boxes, random models, random true solutions; none may be lost.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod common;

use common::models::{self, Target};
use common::truth::{Events, Sim};
use common::{Rng, interval, read};
use veribound_flow::form::{Effort, Enclosure, Flow, FormOptions, Stretch, Unknown};
use veribound_interval::Interval;

/// Error of the simulator in `common::truth`.
const SLACK: f64 = 4e-9;

/// What was met.
#[derive(Debug, Default)]
struct Tally {
    events: Events,
    proved: u64,
    given_up: u64,
    checks: u64,
}

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

fn options(rng: &mut Rng) -> FormOptions {
    let degree = rng.pick(&[None, Some(1), Some(2), Some(3)]);
    FormOptions {
        degree,
        order: rng.pick(&[None, None, Some(6), Some(15)]),
        ..FormOptions::default()
    }
}

struct Case {
    start: Vec<Interval>,
    params: Vec<Interval>,
    stretches: Vec<Stretch>,
    lengths: Vec<f64>,
}

impl Case {
    fn draw(target: &Target, rng: &mut Rng) -> Case {
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

    fn solutions(&self, target: &Target, rng: &mut Rng) -> Vec<(Vec<f64>, Vec<f64>, Sim)> {
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

    /// Moves a solution through one stretch, and checks that it stays in `tube`.
    fn follow(&self, k: usize, sim: &mut Sim, tube: &[Interval], rng: &mut Rng, what: &str) -> u64 {
        let stretch = &self.stretches[k];
        let h = self.lengths[k];
        let pieces = 1 + rng.below(3);
        let mut cuts: Vec<f64> = (1..pieces).map(|_| rng.unit() * h).collect();
        cuts.sort_by(f64::total_cmp);
        cuts.push(h);
        let mut now = 0.0;
        for cut in cuts {
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
        sim.x.len() as u64
    }
}

fn assert_inside(what: &str, case: &Case, sim: &Sim, boxes: &[Interval]) {
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

/// A whole run, which may look ahead.
fn enclose(target: &Target, flow: &Flow, rng: &mut Rng, tally: &mut Tally) {
    let case = Case::draw(target, rng);
    let effort = Effort {
        parts: 1 + rng.below(3),
        ..Effort::default()
    };
    let chosen = options(rng);
    let (start, params) = (&case.start, &case.params);
    let Enclosure {
        ends,
        tubes,
        stopped,
        ..
    } = flow.enclose(start, params, &case.stretches, chosen, effort);
    match stopped {
        None => tally.proved += 1,
        Some(_) => tally.given_up += 1,
    }
    assert!(ends.len() == tubes.len() && ends.len() <= case.stretches.len());
    assert_eq!(stopped.is_none(), ends.len() == case.stretches.len());
    let what = format!("{} enclosed with {chosen:?}", target.name);
    for (_, _, mut sim) in case.solutions(target, rng) {
        for k in 0..ends.len() {
            tally.checks += case.follow(k, &mut sim, &tubes[k], rng, &what);
            assert_inside(
                &format!("{what}, end of stretch {k}"),
                &case,
                &sim,
                &ends[k],
            );
        }
        tally.events.add(sim.events);
    }
}

/// Stretch by stretch; the affine functions of the form must be true for the solution's own unknowns.
fn advance(target: &Target, flow: &Flow, rng: &mut Rng, tally: &mut Tally) {
    let case = Case::draw(target, rng);
    let chosen = options(rng);
    let mut form = flow.start(&case.start, &case.params, chosen);
    let what = format!("{} advanced with {chosen:?}", target.name);
    let mut solutions = case.solutions(target, rng);
    for (k, stretch) in case.stretches.iter().enumerate() {
        let before = form.hull();
        if flow
            .advance(&mut form, &stretch.inputs, stretch.dt)
            .is_err()
        {
            assert_eq!(form.hull(), before, "a failure changes nothing");
            tally.given_up += 1;
            break;
        }
        tally.proved += 1;
        let (tube, hull) = (form.tube().to_vec(), form.hull());
        for (start, p, sim) in &mut solutions {
            tally.checks += case.follow(k, sim, &tube, rng, &what);
            assert_inside(&format!("{what}, end of stretch {k}"), &case, sim, &hull);
            let own: Vec<Interval> = (0..sim.x.len())
                .map(|i| {
                    let affine = form.state(i);
                    let mut value = Interval::point(affine.centre) + affine.remainder;
                    for ((unknown, range), slope) in form.unknowns().iter().zip(&affine.slopes) {
                        let own = match unknown {
                            Unknown::Start(i) => start[*i],
                            Unknown::Param(i) => p[*i],
                        };
                        let delta = Interval::point(own) - Interval::point(range.mid());
                        value += Interval::point(*slope) * (delta / Interval::point(range.rad()));
                    }
                    value
                })
                .collect();
            assert_inside(&format!("{what}, form after stretch {k}"), &case, sim, &own);
        }
    }
    for (_, _, sim) in &solutions {
        tally.events.add(sim.events);
    }
}

fn seed() -> u64 {
    let text = std::env::var("VERIBOUND_SEED").unwrap_or_default();
    text.parse().unwrap_or(7)
}

fn rounds() -> usize {
    let text = std::env::var("VERIBOUND_ROUNDS").unwrap_or_default();
    text.parse().unwrap_or(8)
}

#[test]
fn no_solution_is_lost_across_switches() {
    let mut rng = Rng(seed());
    let mut all = Tally::default();
    for target in models::ALL {
        let flow = Flow::new(&read(target.name, target.text));
        let mut tally = Tally::default();
        for round in 0..rounds() {
            if round % 2 == 0 {
                enclose(target, &flow, &mut rng, &mut tally);
            } else {
                advance(target, &flow, &mut rng, &mut tally);
            }
        }
        println!("{:12} {tally:?}", target.name);
        all.events.add(tally.events);
        all.proved += tally.proved;
        all.given_up += tally.given_up;
        all.checks += tally.checks;
    }
    println!("{all:?}");
    assert!(all.checks > 10_000 && all.events.crossings > 200 && all.events.captures > 200);
}
