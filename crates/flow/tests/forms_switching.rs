//! Forms across switches: random boxes, random models, random true solutions; none may be lost.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod common;

use common::case::{Case, assert_inside, options};
use common::models::{self, Target};
use common::truth::Events;
use common::{Rng, Trials, interval, number, read};
use veribound_flow::form::{Effort, Enclosure, Flow, FormOptions, Meeting, Stretch, Unknown};
use veribound_interval::Interval;

/// What was met.
#[derive(Debug, Default)]
struct Tally {
    events: Events,
    proved: u64,
    given_up: u64,
    trials: Trials,
}

/// A whole run, which may look ahead.
fn enclose(target: &Target, flow: &Flow, rng: &mut Rng, tally: &mut Tally) {
    let case = Case::draw(target, rng);
    let effort = Effort {
        parts: rng.pick(&[1, 2, 3, 12]),
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
            tally.trials.checks += 1 + case.follow(k, &mut sim, &tubes[k], rng, &what);
            assert_inside(
                &format!("{what}, end of stretch {k}"),
                &case,
                &sim,
                &ends[k],
            );
        }
        tally.events.add(sim.events);
        tally.trials.solutions += 1;
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
            tally.trials.checks += 2 + case.follow(k, sim, &tube, rng, &what);
            assert_inside(&format!("{what}, end of stretch {k}"), &case, sim, &hull);
            let own: Vec<Interval> = (0..sim.x.len())
                .map(|i| {
                    let affine = form.state(i);
                    let mut value = Interval::point(affine.centre) + affine.remainder;
                    for ((unknown, range), slope) in form.unknowns().iter().zip(&affine.slopes) {
                        let own = match unknown {
                            Unknown::Start(i) => start[*i],
                            Unknown::Param(i) => p[*i],
                            Unknown::Axis(_) => panic!("a box has no axes"),
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
        tally.trials.solutions += 1;
    }
}

/// Through many short stretches with the same inputs, as between samples, where the form is narrowed now and then.
fn sampled(target: &Target, flow: &Flow, rng: &mut Rng, tally: &mut Tally) {
    let mut case = Case::draw(target, rng);
    let pieces: Vec<usize> = case.lengths.iter().map(|_| 1 + rng.below(12)).collect();
    let divided = |list: &[f64]| -> Vec<f64> {
        let pairs = list.iter().zip(&pieces);
        pairs
            .flat_map(|(h, count)| vec![h / *count as f64; *count])
            .collect()
    };
    let stretches = case.stretches.iter().zip(&pieces);
    case.stretches = stretches
        .flat_map(|(stretch, count)| vec![stretch.clone(); *count])
        .collect();
    case.lengths = divided(&case.lengths);
    for (stretch, h) in case.stretches.iter_mut().zip(&case.lengths) {
        stretch.dt = Interval::point(*h);
    }
    let chosen = options(rng);
    let what = format!("{} sampled with {chosen:?}", target.name);
    let mut solutions: Vec<_> = case
        .solutions(target, rng)
        .into_iter()
        .map(|(start, p, mut sim)| {
            let mut way = vec![sim.clone()];
            for (stretch, h) in case.stretches.iter().zip(&case.lengths) {
                let u: Vec<f64> = stretch.inputs.iter().map(|x| rng.inside(*x)).collect();
                sim.advance(&u, *h, rng);
                way.push(sim.clone());
            }
            (start, p, way)
        })
        .collect();
    for (_, _, way) in &solutions {
        tally.events.add(way[way.len() - 1].events);
        tally.trials.solutions += 1;
    }
    let own = |unknown: Unknown, start: &[f64], p: &[f64]| match unknown {
        Unknown::Start(i) => start[i],
        Unknown::Param(i) => p[i],
        Unknown::Axis(_) => panic!("a box has no axes"),
    };
    let mut checks = 0;
    let mut meet = |meeting: Meeting<'_>| {
        let (k, form) = (meeting.stretch, meeting.form);
        let hull = form.hull();
        for (start, p, way) in &solutions {
            let here = format!("{what}, sample {k}");
            assert_inside(&here, &case, &way[k], &hull);
            let affine: Vec<Interval> = (0..hull.len())
                .map(|i| {
                    let affine = form.state(i);
                    let mut value = Interval::point(affine.centre) + affine.remainder;
                    for ((unknown, range), slope) in form.unknowns().iter().zip(&affine.slopes) {
                        let own = Interval::point(own(*unknown, start, p));
                        let delta = own - Interval::point(range.mid());
                        value += Interval::point(*slope) * (delta / Interval::point(range.rad()));
                    }
                    value
                })
                .collect();
            assert_inside(&here, &case, &way[k], &affine);
            checks += 2;
        }
        if !meeting.is_passing && rng.chance(0.15) {
            let parts: Vec<Interval> = form
                .unknowns()
                .iter()
                .map(|_| interval(-rng.pick(&[1.0, 1.0, 0.4]), rng.pick(&[1.0, 1.0, 0.7])))
                .collect();
            form.narrow(&parts);
            let left = form.unknowns();
            solutions.retain(|(start, p, _)| {
                let mut left = left.iter();
                left.all(|(unknown, range)| range.contains(own(*unknown, start, p)))
            });
        }
    };
    let form = flow.start(&case.start, &case.params, chosen);
    match flow.follow(form, &case.stretches, &mut meet, &|_| true) {
        Ok(()) => tally.proved += 1,
        Err(_) => tally.given_up += 1,
    }
    tally.trials.checks += checks;
}

#[test]
fn no_solution_is_lost_across_switches() {
    let mut rng = Rng(number("VERIBOUND_SEED", 7));
    let mut all = Tally::default();
    for target in models::ALL {
        let flow = Flow::new(&read(target.name, target.text));
        let mut tally = Tally::default();
        for round in 0..number("VERIBOUND_ROUNDS", 12) {
            match round % 3 {
                0 => enclose(target, &flow, &mut rng, &mut tally),
                1 => advance(target, &flow, &mut rng, &mut tally),
                _ => sampled(target, &flow, &mut rng, &mut tally),
            }
        }
        println!("{:12} {tally:?}", target.name);
        all.events.add(tally.events);
        all.proved += tally.proved;
        all.given_up += tally.given_up;
        all.trials.add(tally.trials);
    }
    println!("{all:?}");
    all.trials.told("forms across switches");
    assert!(all.trials.checks > 10_000 && all.events.crossings > 200 && all.events.captures > 200);
}

/// A motor with dry friction, and how it is driven: one level for every sample of 10 ms.
struct Motor {
    params: [(f64, f64); 3],
    levels: Vec<f64>,
}

impl Motor {
    /// The hull of sampled solutions and the hull proved, at every sample.
    fn hulls(&self, options: FormOptions) -> Vec<[[Interval; 2]; 2]> {
        let text = "format = 1\nstates = [\"x\", \"v\"]\ninputs = [\"u\"]\n[init]\nx = 0\nv = 0\n[params]\na = [-3, 0]\n\
            b = [90, 210]\nT = [0, 0.3]\n[der]\nx = \"v\"\nv = \"a*v + b*(u - friction(v, u, T))\"\n[outputs]\nm = \"x +- 1\"\n";
        let flow = Flow::new(&read("motor", text));
        let params = self.params.map(|(lo, hi)| interval(lo, hi));
        let stretches: Vec<Stretch> = self
            .levels
            .iter()
            .map(|u| Stretch {
                inputs: vec![Interval::point(*u)],
                dt: Interval::point(0.01),
            })
            .collect();
        let start = [Interval::ZERO; 2];
        let proved = flow.enclose(&start, &params, &stretches, options, Effort::default());
        assert!(proved.stopped.is_none(), "{:?}", proved.stopped);
        let mut solutions = Vec::new();
        let at = |(lo, hi): (f64, f64), k: u32| lo + (hi - lo) * f64::from(k) / 4.0;
        for number in 0..125 {
            let p = [
                at(self.params[0], number % 5),
                at(self.params[1], number / 5 % 5),
                at(self.params[2], number / 25),
            ];
            solutions.push((p, 0.0, 0.0));
        }
        let mut hulls = Vec::new();
        for (u, end) in self.levels.iter().zip(&proved.ends) {
            let mut inner = [Interval::EMPTY; 2];
            for (p, x, v) in &mut solutions {
                (*x, *v) = common::rig_step(*x, *v, *u, *p, 0.01);
                inner[0] = inner[0].hull(Interval::point(*x));
                inner[1] = inner[1].hull(Interval::point(*v));
            }
            for (inner, outer) in inner.iter().zip(end) {
                let (lo, hi) = (inner.lo() - outer.lo(), outer.hi() - inner.hi());
                assert!(lo > -1e-8 && hi > -1e-8, "{inner} in {outer}");
            }
            hulls.push([inner, [end[0], end[1]]]);
        }
        hulls
    }
}

/// The worst of (width proved - `slack`) / width sampled, for both states, where solutions move.
fn worst(hulls: &[[[Interval; 2]; 2]], slack: f64) -> [(f64, usize); 2] {
    let mut worst = [(0.0, 0); 2];
    for (k, [inner, outer]) in hulls.iter().enumerate() {
        for i in 0..2 {
            let ratio = (outer[i].width() - slack) / (inner[i].width() + 1e-300);
            if outer[i].width() > slack && ratio > worst[i].0 {
                worst[i] = (ratio, k);
            }
        }
    }
    worst
}

/// Slip, reversal, stick and break-away at levels that differ from sample to sample.
#[test]
fn dependence_survives_friction_under_a_sampled_sine() {
    let motor = Motor {
        params: [(-2.05, -1.95), (99.0, 101.0), (0.098, 0.102)],
        levels: (0..1000)
            .map(|k| 0.25 * (0.8 * f64::from(k) * 0.01).sin())
            .collect(),
    };
    let hulls = motor.hulls(FormOptions::default());
    let [inner, outer] = hulls[999];
    let ratios = [0, 1].map(|i| outer[i].width() / inner[i].width());
    assert!(ratios[0] < 1.001 && ratios[1] < 1.001, "{ratios:?}");
    // At every sample, also at those during which solutions stop one after the other, and where all have come back to about
    // where they were.
    let largest = worst(&hulls, 1e-9);
    assert!(largest[0].0 < 1.5 && largest[1].0 < 1.5, "{largest:?}");
}

/// Eighty seconds with all stops and reversals: the hull at every sample.
#[test]
fn dependence_survives_eighty_seconds_of_the_rig() {
    let list = [0.4, 0.1, -0.3, 0.2, -0.1, -0.5, 0.05, 0.3, -0.2, 0.0];
    let motor = Motor {
        params: [(-2.001, -1.999), (199.9, 200.1), (0.149925, 0.150075)],
        levels: (0..8000).map(|k| list[k / 200 % list.len()]).collect(),
    };
    let hulls = motor.hulls(FormOptions::default());
    let largest = worst(&hulls, 1e-7);
    assert!(largest[0].0 < 1.01 && largest[1].0 < 1.01, "{largest:?}");
}

/// A mass on a belt slips, is caught, and is released: 20 seconds.
#[test]
fn dependence_survives_stick_and_slip() {
    let text = "format = 1\nstates = [\"x\", \"v\"]\n[init]\nx = 0\nv = 0\n[params]\nmu = [0.3, 0.35]\n[der]\nx = \"v\"\n\
        v = \"-x - 0.1*v - friction(v - 0.2, -x - 0.1*v, mu)\"\n[outputs]\nm = \"x +- 1\"\n";
    let flow = Flow::new(&read("belt", text));
    let start = [interval(1.0, 1.05), Interval::ZERO];
    let stretch = Stretch {
        inputs: vec![],
        dt: Interval::point(20.0),
    };
    let (options, effort) = (FormOptions::default(), Effort::default());
    let proved = flow.enclose(&start, &[interval(0.3, 0.35)], &[stretch], options, effort);
    // By closed forms between events, over a grid of 13 x 13 start values and levels.
    let inner = [
        interval(0.379_990, 0.446_089),
        interval(0.020_896_4, 0.058_395_5),
    ];
    for (inner, outer) in inner.iter().zip(&proved.ends[0]) {
        assert!(inner.is_subset_of(*outer), "{inner} {outer}");
        assert!(outer.width() < 1.02 * inner.width(), "{inner} {outer}");
    }
}

/// A ball, dropped from some height at some speed, bounces three times.
#[test]
fn dependence_survives_impacts() {
    let text = "format = 1\nstates = [\"h\", \"v\"]\n[init]\nh = 1\nv = 0\n[der]\nh = \"v\"\nv = \"-9.81\"\n[jumps]\n\
        bounce = { when = \"h <= 0 and v < 0\", set = { v = \"-0.75*v\" } }\n[outputs]\nm = \"h +- 1\"\n";
    let flow = Flow::new(&read("ball", text));
    let start = [interval(0.95, 1.05), interval(-0.05, 0.05)];
    let stretches = vec![
        Stretch {
            inputs: vec![],
            dt: interval(0.1, 0.1),
        };
        17
    ];
    let (options, effort) = (FormOptions::default(), Effort::default());
    let proved = flow.enclose(&start, &[], &stretches, options, effort);
    assert!(proved.stopped.is_none());
    let mut inner = vec![[Interval::EMPTY; 2]; stretches.len()];
    for number in 0..441 {
        let h = 0.95 + 0.1 * f64::from(number % 21) / 20.0;
        let v = -0.05 + 0.1 * f64::from(number / 21) / 20.0;
        for (k, inner) in inner.iter_mut().enumerate() {
            let (mut h, mut v, mut left) = (h, v, 0.1 * (k + 1) as f64);
            loop {
                let lands = (v + (v * v + 2.0 * 9.81 * h).sqrt()) / 9.81;
                if lands > left {
                    break;
                }
                (h, v, left) = (0.0, -0.75 * (v - 9.81 * lands), left - lands);
            }
            let now = [h + v * left - 9.81 / 2.0 * left * left, v - 9.81 * left];
            for (i, x) in now.into_iter().enumerate() {
                let bounds = proved.ends[k][i];
                assert!(bounds.inflate(1e-9).contains(x), "{k} {i}: {x} {bounds}");
                inner[i] = inner[i].hull(Interval::point(x));
            }
        }
    }
    for end in &proved.ends {
        assert!(
            end[0].lo() > -0.03,
            "no ball is far below the floor: {}",
            end[0]
        );
    }
    let ratio = |i: usize| proved.ends[16][i].width() / inner[16][i].width();
    assert!(ratio(0) < 1.001 && ratio(1) < 1.001);
}

fn stretch(inputs: &[f64], dt: Interval) -> Stretch {
    Stretch {
        inputs: inputs.iter().map(|u| Interval::point(*u)).collect(),
        dt,
    }
}

/// What is held at the value of an input is let go when the input takes another one, also within the window of
/// a release.
#[test]
fn what_an_input_holds_is_let_go_when_it_jumps() {
    let text = r#"
format = 1
states = ["x", "s"]
inputs = ["u"]
init = { x = 0, s = 0 }
outputs = { y = "x +- 0.01" }
der = { x = "s - sign(x - u)", s = "1" }
"#;
    let flow = Flow::new(&read("held by an input", text));
    let h = 0.0625;
    let stretches: Vec<Stretch> = [0.0, 0.5]
        .map(|u| stretch(&[u], Interval::point(h)))
        .to_vec();
    for from in [interval(0.0, 0.01), interval(0.9, 0.96)] {
        let start = [Interval::ZERO, from];
        let (chosen, effort) = (FormOptions::default(), Effort::default());
        let found = flow.enclose(&start, &[], &stretches, chosen, effort);
        for s in [from.lo(), from.mid(), from.hi()] {
            let slid = (s + h - 1.0).max(0.0);
            let x = 0.5 * slid * slid + (s + 1.0) * h + 1.5 * h * h;
            for end in found.ends.iter().skip(1) {
                assert!(
                    end[0].inflate(1e-12).contains(x),
                    "{x} from {s}: {:?}",
                    end[0]
                );
            }
        }
        assert!(found.stopped.is_none(), "{:?}", found.stopped);
    }
}

/// A sample whose time is not known, within the window of a crossing.
#[test]
fn a_sample_at_any_time_of_a_crossing() {
    let text = r#"
format = 1
states = ["x", "y"]
init = { x = 0, y = 0 }
outputs = { y_m = "x +- 0.01" }
der = { x = "1", y = "3 + 2*sign(x)" }
"#;
    let flow = Flow::new(&read("a switch in time", text));
    for width in [1e-6, 0.001, 0.01, 0.02] {
        let stretches = vec![stretch(&[], interval(0.1 - width, 0.1 + width)); 4];
        let start = [interval(-0.1025, -0.0975), Interval::ZERO];
        for degree in [1, 2] {
            let chosen = FormOptions {
                degree: Some(degree),
                ..FormOptions::default()
            };
            let found = flow.enclose(&start, &[], &stretches, chosen, Effort::default());
            assert!(found.stopped.is_none(), "{:?}", found.stopped);
            for (x, time) in [
                (start[0].lo(), 0.1 - width),
                (start[0].hi(), 0.1 - width),
                (start[0].lo(), 0.1 + width),
                (start[0].hi(), 0.1 + width),
            ] {
                for (k, end) in found.ends.iter().enumerate() {
                    let time = time * (k + 1) as f64;
                    let now = x + time;
                    let y = time.min(-x) + 5.0 * (now.max(0.0));
                    assert!(end[0].inflate(1e-12).contains(now), "{now}: {:?}", end[0]);
                    assert!(end[1].inflate(1e-12).contains(y), "{y}: {:?}", end[1]);
                }
            }
        }
    }
}

/// What dry friction holds stays, wherever it is; what it may not hold does not.
#[test]
fn what_friction_holds_is_proved_to_stay() {
    let text = r#"
        format = 1
        states = ["x", "v"]
        inputs = ["u"]
        init = { x = [-0.2, 0.3], v = 0 }
        params.mu = [0.1, 0.2]
        params.a = [-3, -1]
        der = { x = "v", v = "a*v + u - mu*sign(v)" }
        outputs.y = "x +- 0.1"
    "#;
    let model = read("friction", text);
    let flow = Flow::new(&model);
    let params: Vec<Interval> = model.params.iter().map(|param| param.bounds).collect();
    let rests = |v: f64, u: Interval| {
        let start = [model.states[0].init, Interval::point(v)];
        let stretch = Stretch {
            inputs: vec![u],
            dt: Interval::point(0.5),
        };
        let after = flow.box_after(&start, &params, &stretch);
        after.expect("a box").rests
    };
    assert!(rests(0.0, Interval::ZERO));
    assert!(rests(0.0, interval(-0.09, 0.09)));
    assert!(!rests(0.0, Interval::point(0.15)));
    assert!(!rests(0.0, Interval::point(-0.3)));
    assert!(!rests(1e-9, Interval::ZERO));
}
