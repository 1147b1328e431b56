//! What must hold between runs of the observer, and that it does refute what is false.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

#[path = "../../flow/tests/common/mod.rs"]
mod common;

use common::{RigText, Rng, rig_step};
use veribound_estimate::{Estimate, Observer, ObserverOptions, ParameterRule, Verdict};
use veribound_interval::Decimal;
use veribound_model::{Model, Sample};

const TRUTH: [f64; 3] = [-2.0, 200.0, 0.15];

/// 3 s of the rig with alternating torque; `shift` is added to every time stamp.
fn record(model: &Model, shift: &str, noise: f64) -> Vec<Sample> {
    let mut rng = Rng(5);
    let (mut phi, mut w, mut u) = (0.0, 0.0, 0.2);
    let decimal = |text: &str| Decimal::parse(text).unwrap();
    let mut samples = Vec::new();
    for k in 0..300_i64 {
        if k % 20 == 0 {
            u = rng.pick(&[0.2, -0.2, 0.25, 0.0, 0.15, -0.3, 0.1]);
        }
        let y = format!("{:.12}", phi + noise * rng.between(-1.0, 1.0));
        samples.push(Sample {
            time: &decimal(&format!("{}.{:02}", k / 100, k % 100)) + &decimal(shift),
            inputs: vec![
                model.inputs[0]
                    .error
                    .enclose(decimal(&format!("{u}")).to_interval()),
            ],
            outputs: vec![Some(
                model.outputs[0].error.enclose(decimal(&y).to_interval()),
            )],
            signals: Vec::new(),
            line: k as usize + 2,
        });
        (phi, w) = rig_step(phi, w, u, TRUTH, 0.01);
    }
    samples
}

fn estimates(model: &Model, options: ObserverOptions, samples: &[Sample]) -> Vec<Estimate> {
    let mut observer = Observer::new(model, options);
    samples
        .iter()
        .map(|sample| match observer.step(sample).unwrap() {
            Verdict::Consistent(estimate) => estimate,
            other => panic!("line {}: {other:?}", sample.line),
        })
        .collect()
}

#[test]
fn a_later_clock_changes_nothing() {
    let model = RigText::default().model();
    let options = ObserverOptions::default();
    let now = estimates(&model, options.clone(), &record(&model, "0", 0.09));
    let later = estimates(&model, options, &record(&model, "123456.789", 0.09));
    assert!(now == later);
}

#[test]
fn no_option_turns_consistent_into_inconsistent() {
    let model = RigText::default().model();
    let samples = record(&model, "0", 0.0999);
    let mut all = Vec::new();
    for boxes in [1, 5, 40] {
        for (every, bisections) in [(1, 3), (7, 20)] {
            for rule in [
                ParameterRule::WidestTerm,
                ParameterRule::OverlappingTerms,
                ParameterRule::WidestInfluence,
            ] {
                for across in [false, true] {
                    let options = ObserverOptions {
                        boxes,
                        every,
                        bisections,
                        parameter_rule: rule,
                        merge_across_modes: across,
                        trisect: across,
                        ..ObserverOptions::default()
                    };
                    all.push(estimates(&model, options, &samples));
                }
            }
        }
    }
    for k in 0..samples.len() {
        for run in &all {
            let first = &all[0][k];
            let pairs = first.states.iter().chain(&first.params);
            let others = run[k].states.iter().chain(&run[k].params);
            assert!(
                pairs.zip(others).all(|(a, b)| a.intersects(*b)),
                "sample {k}"
            );
        }
    }
}

#[test]
fn priors_without_the_truth_are_refuted_and_others_shrink() {
    let pair = |lo: &str, hi: &str| [lo.to_string(), hi.to_string()];
    let whole = RigText::default();
    let false_priors = [
        RigText {
            beta: pair("1", "60"),
            ..whole.clone()
        },
        RigText {
            level: pair("0.25", "0.3"),
            ..whole.clone()
        },
        RigText {
            alpha: pair("-0.2", "-0.05"),
            beta: pair("300", "400"),
            level: pair("0", "0.1"),
            ..whole.clone()
        },
    ];
    for text in false_priors {
        let model = text.model();
        let mut observer = Observer::new(&model, ObserverOptions::default());
        let refuted = record(&model, "0", 0.09)
            .iter()
            .any(|sample| match observer.step(sample) {
                Ok(verdict) => matches!(verdict, Verdict::Inconsistent(_)),
                Err(misuse) => panic!("{misuse}"),
            });
        assert!(refuted, "{}", text.text());
    }
    let model = whole.model();
    let last = estimates(
        &model,
        ObserverOptions::default(),
        &record(&model, "0", 0.09),
    )
    .pop()
    .unwrap();
    // The damping shows only in longer motions than these.
    for param in 1..3 {
        let (now, prior) = (
            last.params[param].width(),
            model.params[param].bounds.width(),
        );
        assert!(
            now < 0.9 * prior,
            "{}: {now} of {prior}",
            model.params[param].name
        );
    }
}
