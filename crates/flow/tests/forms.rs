//! Forms lose no solution, stay near the true set, and fail without a claim.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod common;

use common::smooth::{SMOOTH, Smooth, part, travel};
use common::{Rng, Trials, interval, number, read};
use veribound_flow::form::{Effort, Flow, Form, FormOptions, Output, OutputForm, Stretch, Unknown};
use veribound_interval::Interval;

/// Error of the integrator in `common::smooth`, for sizes around one.
const SLACK: f64 = 1e-11;

fn flow(text: &str) -> Flow {
    Flow::new(&read("form", text))
}

fn has(x: Interval, value: f64, slack: f64) -> bool {
    x.lo() - slack <= value && value <= x.hi() + slack
}

fn random_options(rng: &mut Rng) -> FormOptions {
    FormOptions {
        order: rng.pick(&[None, Some(4), Some(8), Some(12), Some(20), Some(27)]),
        degree: rng.pick(&[None, Some(1), Some(2), Some(3)]),
        share: rng.pick(&[1e-7, 1e-3]),
        steepest: rng.pick(&[0.3, 0.7, 2.0]),
        closed: rng.clone().chance(0.5),
        ..FormOptions::default()
    }
}

/// Start, state now, parameters.
type Solution = (Vec<f64>, Vec<f64>, Vec<f64>);

/// Integrates the corners, the middle and random points of the boxes beside the form.
fn attack(model: &Smooth, rng: &mut Rng, trials: &mut Trials) {
    let flow = flow(model.text);
    let widest = rng.pick(&[0.05, 0.2, 0.5]);
    let states: Vec<Interval> = model.states.iter().map(|r| part(rng, *r, widest)).collect();
    let params: Vec<Interval> = model.params.iter().map(|r| part(rng, *r, widest)).collect();
    let mut form = flow.start(&states, &params, random_options(rng));
    // Steps over kinks are of second order only; `forms_switching` locates them.
    let bent = model.name.contains("kinks");
    let (slack, longest) = if bent { (4e-8, 2e-4) } else { (SLACK, 0.02) };
    let mut points: Vec<Solution> = (0..12)
        .map(|_| {
            let start: Vec<f64> = states.iter().map(|r| rng.inside(*r)).collect();
            let p = params.iter().map(|r| rng.inside(*r)).collect();
            (start.clone(), start, p)
        })
        .collect();
    let stretches = 1 + rng.below(3);
    for _ in 0..stretches {
        let dt = model.time / stretches as f64;
        let ranges = model.inputs.iter();
        let inputs: Vec<Interval> = ranges.map(|r| part(rng, *r, 0.1)).collect();
        if flow
            .advance(&mut form, &inputs, Interval::point(dt))
            .is_err()
        {
            return;
        }
        let tube = form.tube().to_vec();
        for (_, x, p) in &mut points {
            // Any input function: here it changes a few times.
            let changes = 1 + rng.below(4);
            for _ in 0..changes {
                let u: Vec<f64> = inputs.iter().map(|r| rng.inside(*r)).collect();
                travel(model.rate, x, p, &u, dt / changes as f64, longest);
                for (x, tube) in x.iter().zip(&tube) {
                    assert!(has(*tube, *x, slack), "{}: {x} in {tube}", model.name);
                }
                trials.checks += 1;
            }
        }
        let hull = form.hull();
        for (start, x, p) in &points {
            for (i, x) in x.iter().enumerate() {
                let name = model.name;
                assert!(
                    has(hull[i], *x, slack),
                    "{name}: state {i}: {x} in {}",
                    hull[i]
                );
                assert!(
                    hull[i].is_subset_of(tube[i].inflate(1e-9 + 0.5 * tube[i].width())),
                    "{name}: {} {}",
                    hull[i],
                    tube[i]
                );
                let affine = form.state(i);
                let value = at(&form, &affine, start, p);
                assert!(has(value, *x, slack), "{name}: {x} in {value} by the form");
            }
            trials.checks += 2;
        }
    }
    trials.solutions += points.len() as u64;
}

/// The affine function at the unknowns of the solution that starts at `x` with parameters `p`.
fn at(form: &Form, affine: &OutputForm, x: &[f64], p: &[f64]) -> Interval {
    let mut value = Interval::point(affine.centre) + affine.remainder;
    for ((unknown, range), slope) in form.unknowns().iter().zip(&affine.slopes) {
        let own = match unknown {
            Unknown::Start(i) => x[*i],
            Unknown::Param(i) => p[*i],
            Unknown::Axis(_) => panic!("a box has no axes"),
        };
        let delta = Interval::point(own) - Interval::point(range.mid());
        value += Interval::point(*slope) * (delta / Interval::point(range.rad()));
    }
    value
}

#[test]
fn no_solution_is_lost() {
    let mut rng = Rng(number("VERIBOUND_SEED", 11));
    let rounds = number("VERIBOUND_ROUNDS", 25);
    let mut all = Trials::default();
    for model in SMOOTH {
        let mut trials = Trials::default();
        for _ in 0..rounds {
            attack(model, &mut rng, &mut trials);
        }
        assert!(trials.checks > 40 * rounds, "{}: {trials:?}", model.name);
        all.add(trials);
    }
    all.told("forms of smooth models");
}

/// Contracted by measurements of one true solution, the form never loses that solution.
#[test]
fn contraction_keeps_the_truth() {
    let mut rng = Rng(23);
    for model in SMOOTH
        .iter()
        .filter(|model| model.name != "kinks that are continuous")
    {
        let text = read(model.name, model.text);
        let output = Output::new(&text, text.outputs[0].expr);
        let flow = Flow::new(&text);
        for _ in 0..12 {
            let states: Vec<Interval> = model
                .states
                .iter()
                .map(|r| part(&mut rng, *r, 0.1))
                .collect();
            let params: Vec<Interval> = model
                .params
                .iter()
                .map(|r| part(&mut rng, *r, 0.1))
                .collect();
            let mut x: Vec<f64> = states.iter().map(|r| rng.inside(*r)).collect();
            let p: Vec<f64> = params.iter().map(|r| rng.inside(*r)).collect();
            let mut form = flow.start(&states, &params, random_options(&mut rng));
            for _ in 0..5 {
                let u: Vec<f64> = model.inputs.iter().map(|r| rng.between(r.0, r.1)).collect();
                let inputs: Vec<Interval> = u.iter().map(|u| Interval::point(*u)).collect();
                let dt = model.time / 8.0;
                if flow
                    .advance(&mut form, &inputs, Interval::point(dt))
                    .is_err()
                {
                    break;
                }
                travel(model.rate, &mut x, &p, &u, dt, 0.02);
                let y = form.output(&output, &inputs).unwrap();
                let truth = if text.outputs[0].name == "m" && model.name == "tanks" {
                    x[1]
                } else {
                    x[0]
                };
                assert!(
                    has(y.hull, truth, SLACK),
                    "{}: {truth} in {}",
                    model.name,
                    y.hull
                );
                let shift = rng.between(-1.0, 1.0);
                let measured = interval(truth - 1e-3 * (1.1 - shift), truth + 1e-3 * (1.1 + shift));
                form.contract(&y, measured).unwrap();
                for (hull, x) in form.hull().iter().zip(&x) {
                    assert!(has(*hull, *x, SLACK), "{}: {x} in {hull}", model.name);
                }
                for (unknown, range) in form.unknowns() {
                    if let Unknown::Param(i) = unknown {
                        assert!(has(range, p[i], 1e-12), "{}", model.name);
                    }
                }
            }
        }
    }
}

/// Smaller sets give smaller hulls, and stretches of time can be divided anyhow.
#[test]
fn parts_lie_inside_and_stretches_agree() {
    let mut rng = Rng(31);
    for model in SMOOTH {
        let flow = flow(model.text);
        for _ in 0..6 {
            let inputs: Vec<Interval> = model
                .inputs
                .iter()
                .map(|r| part(&mut rng, *r, 0.0))
                .collect();
            let states: Vec<Interval> = model
                .states
                .iter()
                .map(|r| part(&mut rng, *r, 0.1))
                .collect();
            let params: Vec<Interval> = model
                .params
                .iter()
                .map(|r| part(&mut rng, *r, 0.1))
                .collect();
            let inner = |rng: &mut Rng, x: &Interval| {
                let (a, b) = (rng.inside(*x), rng.inside(*x));
                interval(a.min(b), a.max(b))
            };
            let fewer: Vec<Interval> = states.iter().map(|x| inner(&mut rng, x)).collect();
            let run = |states: &[Interval], parts: usize| -> Option<Vec<Interval>> {
                let mut form = flow.start(states, &params, FormOptions::default());
                for _ in 0..parts {
                    let dt = Interval::point(0.25 * model.time / parts as f64);
                    flow.advance(&mut form, &inputs, dt).ok()?;
                }
                Some(form.hull())
            };
            let (Some(whole), Some(part)) = (run(&states, 1), run(&fewer, 1)) else {
                panic!("{}", model.name)
            };
            for (x, y) in part.iter().zip(&whole) {
                let slack = 2e-3 * y.width() + 1e-12;
                assert!(
                    x.is_subset_of(y.inflate(slack)),
                    "{}: {x} in {y}",
                    model.name
                );
            }
            let divided = run(&states, 3).unwrap();
            for (x, y) in divided.iter().zip(&whole) {
                let gap = (x.lo() - y.lo()).abs().max((x.hi() - y.hi()).abs());
                let share = if model.name == "kinks that are continuous" {
                    0.5
                } else {
                    0.02
                };
                assert!(
                    gap <= share * y.width() + 1e-12,
                    "{}: {x} and {y}",
                    model.name
                );
            }
        }
    }
}

/// Sets that are too wide for one form are divided, and the parts together lose nothing.
#[test]
fn wide_sets_are_divided() {
    let model = &SMOOTH[5];
    let flow = flow(model.text);
    let start = [interval(1.25, 1.55), interval(2.35, 2.45)];
    let stretches: Vec<Stretch> = (0..7)
        .map(|_| Stretch {
            inputs: Vec::new(),
            dt: Interval::ONE,
        })
        .collect();
    let degree = |degree: Option<usize>| FormOptions {
        degree,
        ..FormOptions::default()
    };
    let mut rng = Rng(3);
    let effort = |parts: usize| Effort {
        parts,
        ..Effort::default()
    };
    let enclose = |wanted: Option<usize>, parts: usize| {
        flow.enclose(&start, &[], &stretches, degree(wanted), effort(parts))
    };
    // What was proved before it failed is a part of what is proved with more effort.
    let failed = enclose(Some(2), 1);
    assert!(failed.stopped.is_some() && failed.ends.len() < stretches.len());
    let (whole, divided) = (enclose(None, 1), enclose(Some(3), 64));
    assert!(whole.stopped.is_none() && divided.stopped.is_none());
    assert!(whole.parts.len() == 1 && divided.parts.len() > 1);
    for enclosure in [&whole, &divided] {
        for _ in 0..40 {
            let mut x: Vec<f64> = start.iter().map(|r| rng.inside(*r)).collect();
            for (end, tube) in enclosure.ends.iter().zip(&enclosure.tubes) {
                for _ in 0..5 {
                    travel(model.rate, &mut x, &[], &[], 0.2, 0.02);
                    assert!(x.iter().zip(tube).all(|(x, r)| has(*r, *x, 1e-10)));
                }
                assert!(
                    x.iter().zip(end).all(|(x, r)| has(*r, *x, 1e-10)),
                    "{x:?} {end:?}"
                );
            }
        }
        // The hull of many samples is x [1.79998, 1.90417], y [0.84797, 1.28394].
        let end = &enclosure.ends[6];
        assert!(interval(1.79998, 1.90417).is_subset_of(end[0].inflate(1e-5)));
        assert!(interval(0.84797, 1.28394).is_subset_of(end[1].inflate(1e-5)));
        assert!(
            end[0].width() < 0.1227 && end[1].width() < 0.4902,
            "{end:?}"
        );
    }
}
