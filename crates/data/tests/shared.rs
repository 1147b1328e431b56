//! The measured records, read where they are present.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that fails stops"
)]

mod support;

use support::{decimal, model, shared};
use veribound_data::{Record, RecordOptions};
use veribound_model::model::Model;

fn open(path: &str, model: &Model, columns: &[(&str, &str)]) -> Option<Record> {
    let Some(folder) = shared() else {
        println!(
            "SKIPPED {path}: no folder `shared` beside the project; set VERIBOUND_SHARED to it"
        );
        return None;
    };
    let columns = columns
        .iter()
        .map(|(v, c)| ((*v).to_owned(), (*c).to_owned()));
    let options = RecordOptions {
        columns: columns.collect(),
        ..RecordOptions::default()
    };
    match Record::open(folder.join("data").join(path), model, options) {
        Ok(record) => Some(record),
        Err(problems) => panic!("{}", problems.render(false)),
    }
}

fn check(record: &Record, samples: usize, first: &str, last: &str) {
    assert_eq!(record.len(), samples);
    assert_eq!(
        (record.first(), record.last()),
        (&decimal(first), &decimal(last))
    );
    let read = record.samples().unwrap().map(Result::unwrap);
    assert_eq!(
        read.filter(|sample| sample.outputs[0].is_some()).count(),
        samples
    );
}

#[test]
fn rig() {
    let columns = [("phi_m", "phi_meas_rad"), ("still", "standstill")];
    if let Some(record) = open("rig/rig.csv", &support::rig(), &columns) {
        check(&record, 8001, "0", "80");
        assert_eq!(record.ignored_columns(), [""; 0]);
        assert_eq!(record.warnings(), [""; 0]);
    }
}

#[test]
fn pendulum() {
    let angle = "angle = { expr = \"x\", unit = \"rad\", error = { absolute = 0.0032 } }";
    if let Some(record) = open("pendulum/pendulum.csv", &model("", angle, ""), &[]) {
        check(&record, 6432, "3.14832", "46.05375");
        assert_eq!(record.ignored_columns(), ["velocity_estimate_rad_per_s"]);
    }
}

#[test]
fn emps() {
    let position = "position = { expr = \"x\", unit = \"m\", error = { absolute = 0.0002 } }";
    let force = "force = { unit = \"N\" }";
    if let Some(record) = open("emps/emps.csv", &model(force, position, ""), &[]) {
        check(&record, 24841, "0", "24.84");
        assert_eq!(
            record.ignored_columns(),
            ["reference_position_m", "input_V"]
        );
    }
}
