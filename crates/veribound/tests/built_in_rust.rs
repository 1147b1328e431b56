//! The rig built in Rust code is the rig of the file, and gets the same bounds, to the bit.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails stops")]

#[path = "../../../examples/drive-train/main.rs"]
mod example;

use std::path::Path;
use veribound::{Interval, Model, Observer, ObserverOptions, Record, RecordOptions, Verdict};

/// Bounds of states and parameters after every sample of the first seconds, in which the rig starts and stops.
fn bounds(model: &Model) -> Vec<(Vec<Interval>, Vec<Interval>)> {
    let record = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/drive-train/rig.csv");
    let record = Record::open(record, model, RecordOptions::default()).unwrap();
    let mut observer = Observer::new(model, ObserverOptions::default());
    let mut found = Vec::new();
    for sample in record.samples().unwrap().take(400) {
        match observer.step(&sample.unwrap()).unwrap() {
            Verdict::Consistent(estimate) => found.push((estimate.states, estimate.params)),
            other => panic!("{other:?}"),
        }
    }
    found
}

#[test]
fn code_and_file_get_the_same_bounds() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../examples/drive-train/model-friction.toml");
    let from_file = bounds(&Model::from_file(file).unwrap());
    let built = bounds(&example::rig().unwrap());
    assert_eq!(from_file.len(), 400);
    assert!(from_file == built);
}
