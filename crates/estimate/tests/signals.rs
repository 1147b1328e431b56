//! What signals prove and allow: a reset is never missed, whatever is not known about its signal.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

use veribound_estimate::{Observer, ObserverOptions, Verdict};
use veribound_interval::{Decimal, Interval};
use veribound_model::{Model, Sample};

/// `x' = a` with `a = 0.5`, and `a = -0.5` from 6 s on: a new value at a sample at which the signal
/// has been true for 5 s.
const RAMP: &str = r#"
format = 1
states = ["x"]
init = { x = [-10, 10] }
[params]
a = [-1, 1]
[der]
x = "a"
[outputs]
y = "x +- 0.001"
slope = "a +- 0.1"
[signals]
still = { from = "column", type = "bool" }
[events.stop]
when = "still"
lasts = 5
action = "reset a"
"#;

const STEPS: i64 = 100;

fn decimal(text: &str) -> Interval {
    Decimal::parse(text).unwrap().to_interval()
}

/// Ten seconds, a sample each 0.1 s.
fn ramp(model: &Model) -> Vec<Sample> {
    (0..=STEPS)
        .map(|k| {
            let x = if k <= 60 { 5 * k } else { 300 - 5 * (k - 60) };
            let slope = if k < 60 { "0.5" } else { "-0.5" };
            let values = [
                decimal(&format!("{}.{:02}", x / 100, x % 100)),
                decimal(slope),
            ];
            Sample {
                time: Decimal::parse(&format!("{}.{}", k / 10, k % 10)).unwrap(),
                inputs: Vec::new(),
                outputs: model
                    .outputs
                    .iter()
                    .zip(values)
                    .map(|(output, value)| Some(output.error.enclose(value)))
                    .collect(),
                signals: vec![Some(true)],
                line: k as usize + 2,
            }
        })
        .collect()
}

/// The truth stays in the bounds; returns at how many samples `a` was reset.
fn resets(model: &Model, samples: &[Sample], story: &str) -> usize {
    let mut observer = Observer::new(model, ObserverOptions::default());
    let mut resets = 0;
    for sample in samples {
        let Verdict::Consistent(estimate) = observer.step(sample).unwrap() else {
            panic!("{story}: line {}: the truth is lost", sample.line);
        };
        let truth = if sample.line < 62 { 0.5 } else { -0.5 };
        assert!(
            estimate.params[0].contains(truth),
            "{story}: line {}",
            sample.line
        );
        resets += usize::from(estimate.resets[0]);
    }
    resets
}

#[test]
fn what_was_before_the_record_may_have_been_true() {
    let model = Model::from_text("ramp.toml", RAMP).unwrap();
    let samples = ramp(&model);
    for from in [0, 5, 40, 59, 60, 61] {
        resets(&model, &samples[from..], &format!("from sample {from}"));
    }
}

#[test]
fn a_missing_signal_may_have_been_true() {
    let model = Model::from_text("ramp.toml", RAMP).unwrap();
    for missing in [
        vec![30],
        vec![60],
        vec![10, 11, 12, 59, 60, 61],
        (0..101).collect(),
    ] {
        let mut samples = ramp(&model);
        for &k in &missing {
            let k: usize = k;
            samples[k].signals[0] = None;
        }
        resets(&model, &samples, &format!("missing at {missing:?}"));
    }
}

#[test]
fn a_hold_begins_at_its_first_true_sample() {
    let model = Model::from_text("ramp.toml", RAMP).unwrap();
    let mut samples = ramp(&model);
    samples[9].signals[0] = Some(false);
    // True from 1.0 s on: 5 s have passed at 6.0 s and after. Before 0.9 s it may have been true
    // for ever, but for the first sample, where there is nothing to forget.
    assert_eq!(resets(&model, &samples, "false at 0.9 s"), 8 + 41);
    samples[10].signals[0] = Some(false);
    let mut observer = Observer::new(&model, ObserverOptions::default());
    let lost = samples
        .iter()
        .position(|sample| !matches!(observer.step(sample), Ok(Verdict::Consistent(_))));
    assert_eq!(lost, Some(60), "no reset is allowed before 6.1 s");
}

#[test]
fn a_signal_proves_only_after_its_latency_in_the_record() {
    let text = RAMP.replace(
        "type = \"bool\" }",
        "type = \"bool\", proves = \"x == 0\", latency = 0.3 }",
    );
    let model = Model::from_text("ramp.toml", &text).unwrap();
    let samples = ramp(&model);
    let mut observer = Observer::new(&model, ObserverOptions::default());
    let refuted = samples
        .iter()
        .position(|sample| matches!(observer.step(sample), Ok(Verdict::Inconsistent(_))));
    // x = 0.15 at 0.3 s, the first sample at which the signal has been true for that long.
    assert_eq!(refuted, Some(3));
}
