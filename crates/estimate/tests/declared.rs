//! What a model says of the course of input errors, and of outliers, in identification: the truth of random records is
//! never lost, and what is said is used.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

#[path = "../../flow/tests/common/mod.rs"]
mod common;

use common::{Rng, read};
use veribound_estimate::identify::{
    Conclusion, Identified, IdentifyOptions, identify, least_disturbance, least_error,
};
use veribound_interval::{Decimal, Interval};
use veribound_model::{Model, Sample};

fn number(name: &str, usual: u64) -> u64 {
    std::env::var(name).map_or(usual, |text| text.parse().unwrap())
}

fn run(model: &Model, record: &[Sample], sets: usize) -> Identified {
    let options = IdentifyOptions {
        sets,
        ..IdentifyOptions::default()
    };
    identify(model, &[record.to_vec()], &options, &|_| true)
}

/// Samples every `step` hundredths of a second: recorded inputs and outputs, as the model reads them.
fn record(model: &Model, step: usize, rows: &[(f64, f64)]) -> Vec<Sample> {
    let sample = |(k, (input, output)): (usize, &(f64, f64))| Sample {
        time: Decimal::parse(&format!("{}", (k * step) as f64 / 100.0)).unwrap(),
        inputs: model
            .inputs
            .iter()
            .map(|own| own.error.enclose(Interval::point(*input)))
            .collect(),
        outputs: vec![Some(
            model.outputs[0].error.enclose(Interval::point(*output)),
        )],
        signals: Vec::new(),
        line: k + 2,
    };
    rows.iter().enumerate().map(sample).collect()
}

/// A first-order lag: its gain and its rate are asked.
fn lag(hold: &str) -> Model {
    read(
        "lag",
        &format!(
            "format = 1\nstates = [\"x\"]\ninit.x = 0\ninputs.u = {{ error = {{ relative = 0.05{hold} }} }}\n[params]\n\
             a = [0.5, 2]\nb = [0.5, 2]\n[der]\nx = \"b*u - a*x\"\n[outputs]\ny = \"x +- 0.002\"\n"
        ),
    )
}

const LEVEL: &str = ", hold = \"level\"";
const SAMPLE: &str = ", hold = \"sample\"";

/// The exact record of a lag, with errors of the input that are drawn anew at every change of the recorded value, or at
/// every sample.
fn lag_record(
    rng: &mut Rng,
    (a, b): (f64, f64),
    count: usize,
    every: usize,
    is_level: bool,
) -> Vec<(f64, f64)> {
    let (mut x, mut u, mut error) = (0.0, 0.0, 0.0);
    let course = rng.below(3);
    let mut rows = Vec::new();
    for k in 0..count {
        if k % every == 0 {
            u = rng.pick(&[0.5, 1.0, -1.0, 1.5, 2.0]) + 0.01 * k as f64;
        }
        if k % every == 0 || !is_level {
            let unit = rng.between(-1.0, 1.0);
            error = 0.05
                * match course {
                    0 => 1.0,
                    1 => rng.pick(&[-1.0, 1.0]),
                    _ => unit,
                };
        }
        let noise = 0.00199 * rng.pick(&[-1.0, 1.0, 0.0]);
        rows.push((u, x + noise));
        let to = b * u * (1.0 + error * (1.0 - 1e-9)) / a;
        x = to + (x - to) * (-a * 0.1_f64).exp();
    }
    rows
}

/// Errors at their bounds, the same for a level or for a sample, never exclude the truth; and that an error is constant
/// tells more than that it is anything.
#[test]
fn constant_errors_of_inputs_keep_the_truth() {
    let models = [lag(""), lag(LEVEL), lag(SAMPLE)];
    let mut rng = Rng(number("VERIBOUND_SEED", 5));
    let mut told = [0.0; 2];
    for round in 0..number("VERIBOUND_ROUNDS", 3) {
        let truth = (rng.between(0.8, 1.5), rng.between(0.8, 1.5));
        let is_level = round % 3 != 2;
        // Every third time so many samples that each cannot be a quantity of its own.
        let count = if round % 3 == 1 { 60 } else { 24 };
        let rows = lag_record(&mut rng, truth, count, 8, is_level);
        let mut widths = Vec::new();
        for (position, model) in models.iter().enumerate() {
            if position == 1 && !is_level {
                continue;
            }
            let found = run(model, &record(model, 10, &rows), 10);
            assert!(
                !matches!(found.conclusion, Conclusion::Inconsistent(_)),
                "{position}"
            );
            for (bounds, truth) in found.params.iter().zip([truth.0, truth.1]) {
                assert!(
                    bounds.outer.contains(truth),
                    "{position} {truth} in {bounds:?}"
                );
                if let Some(inner) = bounds.inner {
                    assert!(inner.is_subset_of(bounds.outer));
                }
            }
            widths.push(found.params[0].outer.width());
        }
        if is_level {
            told[0] += widths[0];
            told[1] += widths[1];
        }
    }
    assert!(told[1] < 0.5 * told[0], "{told:?}");
}

/// A motor with friction, exactly.
fn motor_step(
    (alpha, beta, level): (f64, f64, f64),
    (mut x, mut v): (f64, f64),
    u: f64,
    h: f64,
) -> (f64, f64) {
    let mut left = h;
    while left > 0.0 {
        let sign = if v != 0.0 {
            v.signum()
        } else if u.abs() <= level {
            return (x, 0.0);
        } else {
            u.signum()
        };
        let c = beta * (u - sign * level) / alpha;
        let ratio = c / (v + c);
        let stop = if v != 0.0 && ratio > 0.0 && ratio < 1.0 {
            ratio.ln() / alpha
        } else {
            f64::INFINITY
        };
        let part = left.min(stop);
        let grown = (alpha * part).exp_m1();
        x += (v + c) * grown / alpha - c * part;
        v = if stop <= left {
            0.0
        } else {
            (v + c) * (grown + 1.0) - c
        };
        left -= part;
    }
    (x, v)
}

/// Through stops, rests and reversals, with the torque off by as much as it may be, and at the friction level.
#[test]
fn constant_errors_at_reversals_keep_the_truth() {
    let model = read(
        "motor",
        "format = 1\nstates = [\"x\", \"v\"]\ninputs.u = { error = { relative = 0.03, hold = \"level\" } }\n[init]\nx = [-0.2, 0.2]\nv = 0\n\
         [params]\nalpha = [-2.6, -1.6]\nbeta = [170, 230]\nT = [0.1, 0.2]\n[der]\nx = \"v\"\n\
         v = \"alpha*v + beta*(u - friction(v, u, T))\"\n[outputs]\nm = \"x +- 0.1\"\n",
    );
    let mut rng = Rng(number("VERIBOUND_SEED", 23));
    let mut consistent = 0;
    let rounds = number("VERIBOUND_ROUNDS", 4);
    for round in 0..rounds {
        let truth = (
            rng.between(-2.3, -1.8),
            rng.between(185.0, 215.0),
            rng.between(0.13, 0.17),
        );
        let (mut x, mut v, mut u, mut error, mut left) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64, 0);
        let mut rows = Vec::new();
        let last = 150 + rng.below(250);
        for _ in 0..last {
            if left == 0 {
                let near = truth.2 / 1.03;
                let before = u;
                u = (rng.pick(&[0.0, 1.0, -1.0, 1.0]) * rng.pick(&[0.3, 0.25, near]) * 1e4).round()
                    / 1e4;
                left = 20 + rng.below(60);
                let sign = if round % 2 == 0 {
                    1.0
                } else {
                    rng.pick(&[-1.0, 1.0])
                };
                // As long as the recorded value is the same, so is the error.
                if u != before {
                    error = 0.03 * sign * (1.0 - 1e-9);
                }
            }
            left -= 1;
            let noise = 0.0999 * rng.pick(&[-1.0, 1.0, 0.0]);
            rows.push((u, ((x + noise) * 1e6).round() / 1e6));
            (x, v) = motor_step(truth, (x, v), u * (1.0 + error), 0.01);
        }
        let found = run(&model, &record(&model, 1, &rows), 8);
        assert!(
            !matches!(found.conclusion, Conclusion::Inconsistent(_)),
            "{truth:?}"
        );
        for (bounds, truth) in found.params.iter().zip([truth.0, truth.1, truth.2]) {
            assert!(bounds.outer.contains(truth), "{truth} in {bounds:?}");
        }
        consistent += u64::from(found.conclusion == Conclusion::Consistent);
    }
    assert!(consistent > 0, "none of {rounds}");
}

fn decay(outliers: &str) -> Model {
    read(
        "decay",
        &format!(
            "format = 1\nstates = [\"x\"]\ninit.x = [0.5, 1.5]\nparams.k = [0.1, 2]\nder.x = \"-k*x\"\n\
             outputs.y = {{ expr = \"x\", error = 0.01{outliers} }}\n"
        ),
    )
}

const TWO_IN_20: &str = ", outliers = \"2 in 20\"";

/// The exact record of a decay with noise at the bound, and these samples off.
fn decay_record(rng: &mut Rng, (k, start): (f64, f64), off: &[(usize, f64)]) -> Vec<(f64, f64)> {
    let value = |i: usize| {
        let noise = 0.00999 * rng.pick(&[-1.0, 1.0, 0.3]);
        let more: f64 = off
            .iter()
            .filter(|(at, _)| *at == i)
            .map(|(_, size)| size)
            .sum();
        (0.0, start * (-k * 0.05 * i as f64).exp() + noise + more)
    };
    (0..60).map(value).collect()
}

/// Outliers of any size, as many as are allowed, two in every twenty: the truth stays, and bounds are near those of the
/// record without them.
#[test]
fn allowed_outliers_keep_the_truth() {
    let (strict, model) = (decay(""), decay(TWO_IN_20));
    let mut rng = Rng(number("VERIBOUND_SEED", 41));
    let rounds = number("VERIBOUND_ROUNDS", 12);
    let mut share = 0.0;
    for round in 0..rounds {
        let truth = (rng.between(0.4, 1.5), rng.between(0.7, 1.3));
        let at = rng.below(17);
        let next = at + 1 + rng.below(2);
        let mut off = Vec::new();
        for window in 0..3 {
            for place in [at, next] {
                // From hardly off to very far.
                let size = rng.pick(&[-1.0, 1.0]) * 10_f64.powf(rng.between(-2.3, 3.0));
                off.push((20 * window + place, size));
            }
        }
        let rows = decay_record(&mut rng, truth, &off);
        let found = run(&model, &record(&model, 5, &rows), 60);
        assert_eq!(found.conclusion, Conclusion::Consistent, "{round} {off:?}");
        assert!(
            found.params[0].outer.contains(truth.0),
            "{truth:?} {found:?}"
        );
        assert!(
            found.starts[0][0].outer.contains(truth.1),
            "{truth:?} {found:?}"
        );
        let clean = decay_record(&mut rng, truth, &[]);
        let clean = run(&strict, &record(&strict, 5, &clean), 60);
        share += found.params[0].outer.width() / clean.params[0].outer.width();
    }
    let share = share / rounds as f64;
    assert!(share < 4.0, "{share}");
}

/// One more far outlier in a window than is allowed is a contradiction, wherever the window lies.
#[test]
fn one_outlier_too_many_is_refuted() {
    let model = decay(TWO_IN_20);
    let mut rng = Rng(number("VERIBOUND_SEED", 43));
    for _ in 0..number("VERIBOUND_ROUNDS", 8) {
        let truth = (rng.between(0.4, 1.5), rng.between(0.7, 1.3));
        let at = rng.below(40);
        let mut size = || rng.pick(&[-1.0, 1.0]) * 10_f64.powf(rng.between(0.5, 3.0));
        let off = [(at, size()), (at + 7, size()), (at + 19, size())];
        let rows = decay_record(&mut rng, truth, &off);
        let found = run(&model, &record(&model, 5, &rows), 60);
        assert!(
            matches!(found.conclusion, Conclusion::Inconsistent(_)),
            "{off:?} {found:?}"
        );
        // One later it is in another window.
        let off = [off[0], off[1], (at + 20, off[2].1)];
        let rows = decay_record(&mut rng, truth, &off);
        let found = run(&model, &record(&model, 5, &rows), 60);
        assert_eq!(found.conclusion, Conclusion::Consistent, "{off:?}");
        assert!(found.params[0].outer.contains(truth.0));
    }
}

/// How much of the error of an input, or of a disturbance, is needed is known exactly: 1 s of 1 +- 10 % comes to 1.4 where
/// four times as much is allowed.
#[test]
fn the_least_disturbance_is_enclosed() {
    let models = [
        "inputs.u = { error = 0.1 }\n",
        "inputs.u = { error = { relative = 0.1, hold = \"level\" } }\n",
        "disturbances.u = [0.9, 1.1]\n",
        "disturbances.u = { bounds = [0.9, 1.1], hold = \"sample\" }\n",
    ];
    for input in models {
        let model = read(
            "integral",
            &format!(
                "format = 1\nstates = [\"x\"]\ninit.x = 0\n{input}[params]\np = [0, 1]\n[der]\nx = \"u + 0*p\"\n\
                 [outputs]\ny = \"x +- 0.1\"\n"
            ),
        );
        for (last, least) in [(1.5, 4.0), (1.15, 0.5)] {
            let mut samples = record(&model, 50, &[(1.0, 0.0), (1.0, 0.5), (1.0, last)]);
            samples[1].outputs[0] = None;
            for sample in &mut samples {
                if let Some(bounds) = model.inputs[0].within {
                    sample.inputs[0] = bounds;
                }
            }
            let options = IdentifyOptions {
                tightness: 1.01,
                ..IdentifyOptions::default()
            };
            let found = least_disturbance(&model, &[samples], &options, &|_| true).unwrap();
            let (lo, hi) = (found.factor.lo(), found.factor.hi());
            assert!(lo <= least && least <= hi, "{input} {found:?}");
            assert!(hi <= 1.02 * lo, "{input} {found:?}");
        }
    }
    // Nothing that could be larger.
    let exact = read(
        "integral",
        "format = 1\nstates = [\"x\"]\ninputs = [\"u\"]\ninit.x = 0\nparams.p = [0, 1]\nder.x = \"u + 0*p\"\noutputs.y = \"x +- 0.1\"\n",
    );
    let samples = record(&exact, 50, &[(1.0, 0.0), (1.0, 0.5)]);
    assert!(
        least_disturbance(&exact, &[samples], &IdentifyOptions::default(), &|_| true).is_none()
    );
}

/// The record that refutes is named, wherever it stands, and of samples that refute only together with others none alone.
#[test]
fn the_record_that_refutes_is_named() {
    let (strict, model) = (decay(""), decay(TWO_IN_20));
    let mut rng = Rng(3);
    let truth = (0.8, 1.0);
    let good = record(&strict, 5, &decay_record(&mut rng, truth, &[]));
    let bad = record(&strict, 5, &decay_record(&mut rng, truth, &[(30, 0.3)]));
    for (records, at) in [
        ([good.clone(), bad.clone()], 1),
        ([bad.clone(), good.clone()], 0),
    ] {
        let found = identify(&strict, &records, &IdentifyOptions::default(), &|_| true);
        let Conclusion::Inconsistent(refuted) = found.conclusion else {
            panic!("{found:?}");
        };
        assert_eq!(refuted.record, at, "{refuted:?}");
        assert!(refuted.samples.contains(&30), "{refuted:?}");
        // One outlier is allowed.
        let found = identify(&model, &records, &IdentifyOptions::default(), &|_| true);
        assert_eq!(found.conclusion, Conclusion::Consistent);
    }
    let off = [(30, 0.3), (33, -0.4), (35, 0.2)];
    let bad = record(&model, 5, &decay_record(&mut rng, truth, &off));
    let found = identify(&model, &[good, bad], &IdentifyOptions::default(), &|_| true);
    let Conclusion::Inconsistent(refuted) = found.conclusion else {
        panic!("{found:?}");
    };
    // Two may be off: what refutes takes at least three.
    assert_eq!(refuted.record, 1);
    assert!(
        refuted.samples.is_empty() || refuted.samples.len() >= 3,
        "{refuted:?}"
    );
}

/// Samples without an error have fewer rows than others when the factor of errors is asked.
#[test]
fn the_least_error_with_outliers_and_exact_samples() {
    let model = read(
        "decay",
        "format = 1\nstates = [\"x\"]\ninit.x = [0.5, 1.5]\nparams.k = [0.1, 2]\nder.x = \"-k*x\"\n\
         outputs.y = { expr = \"x\", error = { relative = 0.02 }, outliers = \"1 in 10\" }\n",
    );
    let value = |i: i32| {
        if i % 10 == 4 {
            0.0
        } else {
            (-0.04 * f64::from(i)).exp()
        }
    };
    let rows: Vec<(f64, f64)> = (0..30).map(|i| (0.0, value(i))).collect();
    let samples = record(&model, 5, &rows);
    let found = least_error(&model, &[samples], &IdentifyOptions::default(), &|_| true);
    // Without any error the truth agrees.
    assert!(found.factor.lo() < 1e-3, "{found:?}");
}
