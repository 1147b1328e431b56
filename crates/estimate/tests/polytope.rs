//! The polytope of what all samples say, online: the truth is never lost, and little is lost of what identification keeps.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

#[path = "../../flow/tests/common/mod.rs"]
mod common;

use common::{RigText, Rng, number, read, rig_step};
use veribound_estimate::identify::{IdentifyOptions, identify};
use veribound_estimate::{Contradiction, Method, Observer, ObserverOptions, Verdict};
use veribound_interval::{Decimal, Interval};
use veribound_model::{Model, Sample};

/// A record with what is true at every sample: states, then parameters.
struct Record {
    model: Model,
    samples: Vec<Sample>,
    truth: Vec<Vec<f64>>,
}

/// How far the truth in floating point may be from the exact one.
const SLACK: f64 = 1e-8;

fn decimal(x: f64, digits: usize) -> Decimal {
    Decimal::parse(&format!("{x:.digits$}")).unwrap()
}

/// A measurement with an error that often is at the bound.
fn measured(rng: &mut Rng, truth: f64, bound: f64) -> Interval {
    let reach = bound - 4.0 * SLACK;
    let error = rng.pick(&[-reach, reach, 0.0]) * rng.pick(&[1.0, 1.0, 0.7]);
    let read = decimal(truth + error, 12).to_interval();
    read + Interval::new(-bound, bound).unwrap()
}

/// A motor with dry friction, its angle read to 0.1 rad every 10 ms, with wide priors; or with narrower ones
/// and without torques that move it with some parameters and leave it at rest with others, since sets are not divided.
fn motor(rng: &mut Rng, count: usize, (tells_rest, is_clear): (bool, bool)) -> Record {
    let p = [
        -rng.between(0.5, 4.0),
        rng.between(50.0, 300.0),
        rng.between(0.05, 0.25),
    ];
    let around = |x: f64| {
        let ends = [0.9 * x, 1.1 * x].map(|x| format!("{x:.4}"));
        if x < 0.0 {
            [ends[1].clone(), ends[0].clone()]
        } else {
            ends
        }
    };
    let wide = RigText::default();
    let model = RigText {
        alpha: if is_clear {
            around(p[0])
        } else {
            wide.alpha.clone()
        },
        beta: if is_clear {
            around(p[1])
        } else {
            wide.beta.clone()
        },
        level: if is_clear {
            around(p[2])
        } else {
            wide.level.clone()
        },
        explicit: rng.chance(0.5),
        still: tells_rest.then_some(("0", None)),
        ..wide
    };
    let (mut x, mut w, mut u) = (0.0, 0.0, 0.0);
    let (mut samples, mut truth, mut left) = (Vec::new(), Vec::new(), 0);
    for k in 0..count {
        if left == 0 {
            left = if is_clear { 150 } else { 10 + rng.below(60) };
            u = if is_clear {
                [0.0, 0.4, 0.0, -0.5][k / 150 % 4]
            } else {
                rng.pick(&[0.0, 0.12, 0.2, 0.3, 0.4, 0.5, -0.2, -0.3, -0.4])
            };
        }
        left -= 1;
        let output = measured(rng, x, 0.1);
        samples.push(Sample {
            time: decimal(k as f64 * 0.01, 2),
            inputs: vec![decimal(u, 2).to_interval()],
            outputs: vec![(!rng.chance(0.05)).then_some(output)],
            signals: vec![Some(w == 0.0); usize::from(tells_rest)],
            line: k + 2,
        });
        truth.push(vec![x, w, p[0], p[1], p[2]]);
        (x, w) = rig_step(x, w, u, p, 0.01);
    }
    Record {
        model: model.model(),
        samples,
        truth,
    }
}

const TANKS: &str = "format = 1\nname = \"tanks\"\nstates = [\"h1\", \"h2\"]\ninputs = [\"q\"]\n[init]\n\
    h1 = [0.1, 0.3]\nh2 = [0.1, 0.3]\n[params]\na = [0.05, 0.2]\nb = [0.02, 0.15]\nw = [0, 5]\nedge = [0.4, 0.7]\n\
    [der]\nh1 = \"q - 4.43*a*sqrt(h1) - w*max(0, h1 - edge)\"\nh2 = \"4.43*(a*sqrt(h1) - b*sqrt(h2))\"\n\
    [outputs]\nupper = \"h1 +- 0.005\"\nlower = \"h2 +- 0.005\"\n";

/// Runge and Kutta's steps, so many.
fn travel(rate: &dyn Fn(&[f64]) -> Vec<f64>, x: &mut [f64], h: f64, steps: usize) {
    let h = h / steps as f64;
    for _ in 0..steps {
        let along = |k: &[f64], share: f64| -> Vec<f64> {
            x.iter().zip(k).map(|(x, k)| x + share * h * k).collect()
        };
        let k1 = rate(x);
        let k2 = rate(&along(&k1, 0.5));
        let k3 = rate(&along(&k2, 0.5));
        let k4 = rate(&along(&k3, 1.0));
        for (i, x) in x.iter_mut().enumerate() {
            *x += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
        }
    }
}

/// Two tanks with an overflow, both levels read to 5 mm every 50 ms.
fn tanks(rng: &mut Rng, count: usize) -> Record {
    let p = [
        rng.between(0.07, 0.15),
        rng.between(0.04, 0.1),
        rng.between(0.5, 4.0),
        rng.between(0.45, 0.6),
    ];
    let mut x = [rng.between(0.1, 0.3), rng.between(0.1, 0.3)];
    let (mut samples, mut truth, mut q, mut left) = (Vec::new(), Vec::new(), 0.3, 0);
    for k in 0..count {
        if left == 0 {
            left = 20 + rng.below(60);
            q = rng.pick(&[0.2, 0.3, 0.4, 0.5, 0.6]);
        }
        left -= 1;
        let outputs = x.map(|x| (!rng.chance(0.05)).then_some(measured(rng, x, 0.005)));
        samples.push(Sample {
            time: decimal(k as f64 * 0.05, 2),
            inputs: vec![decimal(q, 1).to_interval()],
            outputs: outputs.to_vec(),
            signals: Vec::new(),
            line: k + 2,
        });
        truth.push([&x[..], &p].concat());
        let rate = |x: &[f64]| {
            let down = 4.43 * p[0] * x[0].sqrt();
            vec![
                q - down - p[2] * (x[0] - p[3]).max(0.0),
                down - 4.43 * p[1] * x[1].sqrt(),
            ]
        };
        travel(&rate, &mut x, 0.05, 64);
    }
    Record {
        model: read("tanks", TANKS),
        samples,
        truth,
    }
}

/// Few boxes, so that the strips matter.
fn options() -> ObserverOptions {
    ObserverOptions {
        method: Method::Polytope,
        boxes: 20,
        bisections: 10,
        ..ObserverOptions::default()
    }
}

fn random_options(rng: &mut Rng) -> ObserverOptions {
    ObserverOptions {
        boxes: 1 + rng.below(20),
        bisections: rng.below(10),
        rows: rng.pick(&[1, 8, 64]),
        replay: rng.pick(&[1, 3, 8]),
        history: rng.pick(&[2, 40, 20_000]),
        budget: rng.pick(&[1, 30_000, 300_000, 1_000_000]),
        ..options()
    }
}

/// Goes through a record; the truth is in some box after every sample. The hull of the parameters at the end.
fn observe(record: &Record, options: &ObserverOptions, story: &str) -> Vec<Interval> {
    let mut observer = Observer::new(&record.model, options.clone());
    let mut left = Vec::new();
    for (sample, truth) in record.samples.iter().zip(&record.truth) {
        match observer.step(sample).unwrap() {
            Verdict::Consistent(estimate) => left = estimate.params,
            other => panic!("{story} at {}: {other:?}", sample.time),
        }
        let states = truth.len() - record.model.params.len();
        let inside = observer.cells().iter().any(|cell| {
            cell.z.iter().zip(truth).enumerate().all(|(i, (z, x))| {
                let slack = if i < states { SLACK } else { 0.0 };
                z.inflate(slack).contains(*x)
            })
        });
        assert!(
            inside,
            "{story} at {}: {truth:?} lost: {left:?}",
            sample.time
        );
    }
    left
}

fn rounds(usual: u64) -> u64 {
    number("VERIBOUND_ROUNDS", 1) * usual
}

#[test]
fn the_truth_of_motors_is_never_lost() {
    for round in 0..rounds(10) {
        let mut rng = Rng(number("VERIBOUND_SEED", 1) * 1_000_003 + round);
        let tells_rest = rng.chance(0.5);
        let is_clear = rng.chance(0.7);
        let record = motor(&mut rng, 300, (tells_rest, is_clear));
        let options = random_options(&mut rng);
        observe(
            &record,
            &options,
            &format!("motor, round {round}, {options:?}"),
        );
    }
}

#[test]
fn the_truth_of_tanks_is_never_lost() {
    for round in 0..rounds(3) {
        let mut rng = Rng(number("VERIBOUND_SEED", 1) * 7_000_003 + round);
        let record = tanks(&mut rng, 100);
        let options = random_options(&mut rng);
        observe(
            &record,
            &options,
            &format!("tanks, round {round}, {options:?}"),
        );
    }
}

/// What identification proves to be reached is left by all budgets of rows, and more rows leave little more than that.
#[test]
fn fewer_rows_leave_more() {
    for round in 0..rounds(1) {
        let mut rng = Rng(number("VERIBOUND_SEED", 1) * 31 + round);
        let record = motor(&mut rng, 900, (true, true));
        let whole = IdentifyOptions::default();
        let found = identify(
            &record.model,
            std::slice::from_ref(&record.samples),
            &whole,
            &|_| true,
        );
        let mut all = Vec::new();
        for rows in [8, 32, 128] {
            let options = ObserverOptions { rows, ..options() };
            let left = observe(&record, &options, &format!("round {round}, {rows} rows"));
            for (left, bounds) in left.iter().zip(&found.params) {
                let inner = bounds.inner.unwrap();
                assert!(
                    inner.is_subset_of(*left),
                    "round {round}, {rows} rows: {left} {bounds:?}"
                );
            }
            all.push(left);
        }
        for (param, bounds) in found.params.iter().enumerate() {
            let widths: Vec<f64> = all.iter().map(|left| left[param].width()).collect();
            println!("{widths:?} of {bounds:?}");
            assert!(widths[2] <= 1.05 * widths[0], "{widths:?}");
            assert!(
                widths[2] <= 1.5 * bounds.inner.unwrap().width(),
                "{widths:?} {bounds:?}"
            );
        }
    }
}

/// No sample takes more than its budget and one piece of work, by count; without a budget some take more, and bounds at the end are not
/// clearly narrower.
#[test]
fn no_sample_takes_more_than_its_budget() {
    // A moment of boxes near to a switch, with the polynomials of these models.
    const PIECE: u64 = 400_000;
    let (mut longest, mut wider, mut narrower) = (0, 0.0_f64, 0.0_f64);
    for round in 0..rounds(3) {
        let mut rng = Rng(number("VERIBOUND_SEED", 1) * 131 + round);
        let record = motor(&mut rng, 750, (true, true));
        let mut ends = Vec::new();
        for budget in [usize::MAX, 1_000_000, 300_000] {
            let options = ObserverOptions {
                budget,
                ..options()
            };
            let mut observer = Observer::new(&record.model, options);
            let (mut most, mut all, mut left) = (0, 0, Vec::new());
            for sample in &record.samples {
                match observer.step(sample).unwrap() {
                    Verdict::Consistent(estimate) => left = estimate.params,
                    other => panic!("round {round}, {budget} at {}: {other:?}", sample.time),
                }
                most = most.max(observer.spent());
                all += observer.spent();
            }
            if budget == usize::MAX {
                longest = longest.max(most);
            } else {
                let (budget, count) = (budget as u64, record.samples.len() as u64);
                assert!(most <= budget + PIECE, "round {round}, {budget}: {most}");
                assert!(all <= count * budget + PIECE, "round {round}: {all}");
            }
            ends.push(left);
        }
        for param in 0..ends[0].len() {
            let widths: Vec<f64> = ends.iter().map(|left| left[param].width()).collect();
            println!("round {round}: {widths:?}");
            wider = wider.max(widths[1] / widths[0]);
            narrower = narrower.max(widths[0] / widths[1]);
        }
    }
    println!(
        "without a budget {longest}; with one {wider} times as wide, or {narrower} times as narrow"
    );
    assert!(wider < 1.3 && narrower < 1.3, "{wider} {narrower}");
    assert!(longest > 2 * (1_000_000 + PIECE), "{longest}");
}

/// A motor whose friction becomes another one without a reset is refuted, and boxes of the same number do not see it.
#[test]
fn a_change_is_refuted() {
    let mut refuted = 0;
    for round in 0..3 {
        let mut rng = Rng(100 + round);
        let record = motor(&mut rng, 900, (true, true));
        let p = &record.truth[0];
        let (mut x, mut w) = (p[0], p[1]);
        let mut observer = Observer::new(&record.model, options());
        for (k, sample) in record.samples.iter().enumerate() {
            let mut sample = sample.clone();
            sample.outputs = vec![Some(measured(&mut rng, x, 0.1))];
            sample.signals = vec![Some(w == 0.0)];
            let u = sample.inputs[0].mid();
            let level = if k < 500 { p[4] } else { p[4] + 0.02 };
            (x, w) = rig_step(x, w, u, [p[2], p[3], level], 0.01);
            match observer.step(&sample).unwrap() {
                Verdict::Consistent(_) => {}
                Verdict::Inconsistent(refutation) => {
                    assert!(k >= 500, "round {round}, {k}: {refutation:?}");
                    let (a, b) = match refutation.contradiction {
                        Contradiction::Output {
                            enclosure,
                            measured,
                            ..
                        } => (enclosure, measured),
                        Contradiction::Apart {
                            enclosure, allowed, ..
                        } => (enclosure, allowed),
                        Contradiction::Signal { enclosure, .. } => (enclosure, Interval::ZERO),
                        Contradiction::Motion {
                            enclosure, needed, ..
                        } => (enclosure, needed),
                    };
                    assert!(!a.intersects(b), "{a} {b}");
                    refuted += 1;
                    break;
                }
                Verdict::Undecided(why) => panic!("round {round}, {k}: {why:?}"),
            }
        }
    }
    assert!(refuted >= 2, "{refuted}");
}

/// What an input makes jump at a sample may be measured there before or after the jump, also at the newest sample.
#[test]
fn what_jumps_at_a_sample_is_not_lost() {
    let text = "format = 1\nstates = [\"x\"]\ninputs = [\"u\"]\ninit.x = [0.9, 1.1]\nparams.k = [0.4, 0.6]\n\
                der.x = \"-k*x\"\n[jumps]\nkick = { when = \"u >= 1 and x <= 3\", set.x = \"x + 5\" }\n\
                [outputs]\ny = \"x +- 0.05\"\n";
    let (count, jump, k) = (40, 10, 0.5);
    let mut rng = Rng(11);
    for (is_after, is_told) in [(false, true), (true, true), (true, false)] {
        let (mut samples, mut truth) = (Vec::new(), Vec::new());
        let mut x = 1.0;
        for i in 0..count {
            let told = if i == jump && is_after { x + 5.0 } else { x };
            let is_known = is_told || i != jump;
            samples.push(Sample {
                time: decimal(0.1 * f64::from(i), 1),
                inputs: vec![Interval::point(f64::from(u8::from(i >= jump)))],
                outputs: vec![is_known.then(|| measured(&mut rng, told, 0.05))],
                signals: Vec::new(),
                line: 2,
            });
            truth.push(vec![told, k]);
            if i == jump {
                x += 5.0;
            }
            x *= (-k * 0.1_f64).exp();
        }
        let model = read("kick", text);
        let record = Record {
            model,
            samples,
            truth,
        };
        observe(&record, &options(), &format!("{is_after} {is_told}"));
    }
}
