//! What is pushed against a stop rests on it, and leaves it when it is pulled back: forms of random sets against exact solutions, driven from
//! event to event.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod common;

use common::stem::{Stem, VALVE, Way};
use common::{Rng, Trials, interval, number, read};
use veribound_flow::form::{Effort, Flow, FormOptions, Stretch};
use veribound_interval::Interval;

/// How far exact solutions are rounded, at most.
const SLACK: f64 = 1e-9;

/// Moves a state with these parameters on, under an input and for so long.
type Advance<'a> = dyn FnMut(&[f64], &mut [f64; 2], f64, f64) + 'a;

/// A set, and what pushes it from sample to sample.
struct Case {
    start: Vec<Interval>,
    params: Vec<Interval>,
    stretches: Vec<(f64, f64)>,
    /// A parameter in the middle of which outcomes part.
    parting: Option<usize>,
}

impl Case {
    /// Encloses the set, asks for exact solutions of random points, and looks at every sample and at times between; how many stretches were proved.
    fn attack(
        &self,
        flow: &Flow,
        rng: &mut Rng,
        trials: &mut Trials,
        advance: &mut Advance<'_>,
    ) -> usize {
        let stretches = self.stretches.iter().map(|(dt, u)| Stretch {
            inputs: vec![Interval::point(*u)],
            dt: Interval::point(*dt),
        });
        let stretches: Vec<Stretch> = stretches.collect();
        let options = FormOptions {
            degree: rng.pick(&[None, Some(1), Some(2), Some(3)]),
            ..FormOptions::default()
        };
        let effort = Effort {
            parts: rng.pick(&[1, 1, 8]),
            ..Effort::default()
        };
        let found = flow.enclose(&self.start, &self.params, &stretches, options, effort);
        for _ in 0..12 {
            let x: Vec<f64> = self.start.iter().map(|x| rng.inside(*x)).collect();
            let mut p: Vec<f64> = self.params.iter().map(|p| rng.inside(*p)).collect();
            if let Some(param) = self.parting.filter(|_| rng.chance(0.5)) {
                let (middle, radius) = self.params[param].mid_rad();
                let near = rng.pick(&[1e-3, 1e-4, 1e-5, 1e-6, 1e-8]);
                p[param] = middle + near * radius * rng.between(-1.0, 1.0);
            }
            let mut state = [x[0], x[1]];
            let ends = found.ends.iter().zip(&found.tubes);
            for (k, ((dt, u), (end, tube))) in self.stretches.iter().zip(ends).enumerate() {
                // Also just after the inputs changed.
                for share in [0.0003, 0.31, 0.6897] {
                    advance(&p, &mut state, *u, share * dt);
                    for (i, set) in tube.iter().enumerate() {
                        assert!(
                            set.inflate(SLACK).contains(state[i]),
                            "state {i} on the way in {k}: {state:?} not in {tube:?}; {x:?} {p:?} {:?} {:?} {:?}",
                            self.start,
                            self.params,
                            self.stretches
                        );
                    }
                }
                for (i, set) in end.iter().enumerate() {
                    assert!(
                        set.inflate(SLACK).contains(state[i]),
                        "state {i} at the end of {k}: {state:?} not in {end:?}; {x:?} {p:?} {:?} {:?} {:?}",
                        self.start,
                        self.params,
                        self.stretches
                    );
                }
                trials.checks += 4;
            }
            trials.solutions += 1;
        }
        found.ends.len()
    }
}

/// Levels that last for some samples each.
fn levels(rng: &mut Rng, dt: f64, (lo, hi): (f64, f64)) -> Vec<(f64, f64)> {
    let mut list = Vec::new();
    while list.len() < 24 {
        let level = rng.between(lo, hi);
        for _ in 0..1 + rng.below(6) {
            list.push((dt, level));
        }
    }
    list
}

#[test]
fn valves_rest_on_their_stops() {
    let flow = Flow::new(&read("valve", VALVE));
    let first = number("VERIBOUND_SEED", 0);
    let (mut trials, mut proved, mut stops, mut back) = (Trials::default(), 0, 0, 0);
    for seed in first..first + number("VERIBOUND_ROUNDS", 40) {
        let mut rng = Rng(seed);
        let width = rng.pick(&[0.0, 1e-3, 0.01, 0.05]);
        let around = |x: f64| interval((1.0 - width) * x, (1.0 + width) * x);
        let place = rng.pick(&[0.0, 0.0, 0.02, 0.05 / (1.0 + width)]);
        let (c, friction) = (rng.between(35.0, 80.0), rng.between(0.3, 2.5));
        // Exact levels, at which the middle of the set just does not leave.
        let friction = if rng.chance(0.3) { 1.5 } else { friction };
        let mut stretches = levels(&mut rng, 0.02, (-4.0, 11.0));
        if friction == 1.5 {
            for (_, level) in &mut stretches {
                *level = 0.5 * (2.0 * *level).round();
            }
            // Pushed to the stop, pulled so that half of the set just leaves, and pushed or pulled on.
            if rng.chance(0.6) {
                let next = rng.pick(&[8.0, 9.5, 3.0, 3.5, 4.0]);
                for (level, count) in [(10.0, 120), (3.5, 1 + rng.below(8)), (next, 10)] {
                    stretches.extend(vec![(0.02, level); count]);
                }
            }
        }
        let case = Case {
            start: vec![around(place), Interval::ZERO],
            params: vec![around(c), around(friction)],
            parting: (friction == 1.5).then_some(1),
            stretches,
        };
        let mut rested = false;
        let mut advance = |p: &[f64], state: &mut [f64; 2], u: f64, dt: f64| {
            let stem = Stem {
                k: 100.0,
                c: p[0],
                friction: p[1],
                room: [0.0, 0.05],
            };
            stem.advance(state, u, dt, &mut |way| match way {
                Way::LeftStop | Way::RightStop => rested = true,
                Way::SlidingLeft | Way::SlidingRight if rested => {
                    (rested, back) = (false, back + 1);
                }
                _ => {}
            });
            stops += u64::from(rested);
        };
        proved += case.attack(&flow, &mut rng, &mut trials, &mut advance);
    }
    println!("{proved} stretches, {stops} at rest on a stop, {back} left one");
    trials.told("valves on their stops");
    assert!(proved > 500 && stops > 1000 && back > 100);
}

/// Nothing but the floor holds it: `x'' = u - g`.
#[test]
fn a_mass_rests_on_the_floor() {
    let text = "format = 1\nstates = [\"x\", \"v\"]\ninputs = [\"u\"]\n[init]\nx = 0\nv = 0\n[params]\ng = [5, 15]\n[der]\nx = \"v\"\nv = \"u - g\"\n\
        [jumps]\nlands = { when = \"x <= 0 and v < 0\", set = { v = \"0\" } }\n[outputs]\ny = \"x +- 0.1\"\n";
    let flow = Flow::new(&read("mass", text));
    let first = number("VERIBOUND_SEED", 0);
    let (mut trials, mut proved, mut rested) = (Trials::default(), 0, 0);
    for seed in first..first + number("VERIBOUND_ROUNDS", 60) {
        let mut rng = Rng(seed);
        let width = rng.pick(&[0.0, 1e-3, 0.01, 0.05]);
        let g = rng.between(6.0, 14.0);
        let height = rng.pick(&[0.0, 0.0, 0.1]);
        let case = Case {
            start: vec![interval(height, height * (1.0 + width)), Interval::ZERO],
            params: vec![interval(g, g * (1.0 + width))],
            stretches: levels(&mut rng, 0.05, (g - 8.0, g + 4.0)),
            parting: None,
        };
        let mut advance = |p: &[f64], state: &mut [f64; 2], u: f64, dt: f64| {
            let (a, mut rest) = (u - p[0], dt);
            let [x, v] = *state;
            if x <= 0.0 && v <= 0.0 && a <= 0.0 {
                *state = [0.0, 0.0];
                rested += 1;
                return;
            }
            // When it lands, if it does.
            let root = (v * v - 2.0 * a * x).max(0.0).sqrt();
            let lands = if a < 0.0 || (a > 0.0 && v < 0.0 && v * v >= 2.0 * a * x) {
                (v + root) / -a
            } else if a == 0.0 && v < 0.0 {
                x / -v
            } else {
                f64::INFINITY
            };
            let lands = if a > 0.0 && lands.is_finite() {
                (-v - root) / a
            } else {
                lands
            };
            if lands <= rest {
                rest -= lands;
                *state = if a > 0.0 {
                    [0.5 * a * rest * rest, a * rest]
                } else {
                    [0.0, 0.0]
                };
                return;
            }
            *state = [x + rest * (v + 0.5 * a * rest), v + a * rest];
        };
        proved += case.attack(&flow, &mut rng, &mut trials, &mut advance);
    }
    println!("{proved} stretches, {rested} at rest on the floor");
    trials.told("masses on the floor");
    assert!(proved > 1000 && rested > 1000);
}
