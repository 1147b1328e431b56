//! Every message about a record, word by word: `testdata/messages/NAME.csv` must be refused with the
//! text in `NAME.expected`. `VERIBOUND_BLESS=1` writes the expected texts anew.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that fails stops"
)]

mod support;

use std::path::{Path, PathBuf};
use support::{decimal, rig};
use veribound_data::{Record, RecordOptions};
use veribound_model::model::Model;

const FOLDER: &str = "testdata/messages";

fn refusal(path: &str, model: &Model, options: RecordOptions) -> String {
    match Record::open(path, model, options) {
        Ok(_) => panic!("{path} was accepted"),
        Err(problems) => problems.render(false),
    }
}

/// Options that a file of `testdata/messages` is read with.
fn options(case: &str) -> RecordOptions {
    let mut options = RecordOptions::default();
    let columns = |pairs: &[(&str, &str)]| {
        let pairs = pairs
            .iter()
            .map(|(v, c)| ((*v).to_owned(), (*c).to_owned()));
        pairs.collect::<Vec<_>>()
    };
    match case {
        "column_named_wrong" => options.columns = columns(&[("phi_m", "phi_mess")]),
        "variable_named_wrong" => options.columns = columns(&[("phy_m", "phi_m"), ("zzz", "u")]),
        "time_named_wrong" => options.time = Some("clock".to_owned()),
        "time_named_in_milliseconds" => options.time = Some("clock_ms".to_owned()),
        "window_without_samples" => {
            options.from = Some(decimal("0.15"));
            options.to = Some(decimal("0.19"));
        }
        "window_after_the_end" => options.from = Some(decimal("7")),
        _ => {}
    }
    options
}

#[test]
fn every_message_reads_as_expected() {
    let bless = std::env::var_os("VERIBOUND_BLESS").is_some();
    let mut wrong = Vec::new();
    let mut cases: Vec<PathBuf> = std::fs::read_dir(FOLDER)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|end| end == "csv"))
        .collect();
    cases.sort();
    assert!(cases.len() > 30, "the test data are gone");
    for case in cases {
        let stem = case.file_stem().unwrap().to_str().unwrap();
        let path = format!("{FOLDER}/{stem}.csv");
        let mut model = rig();
        if stem.starts_with("model_names") {
            model.outputs[0].column = Some("angle".to_owned());
        }
        let message = refusal(&path, &model, options(stem));
        let expected = Path::new(FOLDER).join(format!("{stem}.expected"));
        if bless {
            std::fs::write(&expected, &message).unwrap();
        } else if std::fs::read_to_string(&expected).ok().as_deref() != Some(&message) {
            wrong.push(format!("--- {stem}\n{message}"));
        }
    }
    assert!(
        wrong.is_empty(),
        "{} messages differ:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}

#[test]
fn a_path_that_cannot_be_read_is_said() {
    let model = rig();
    let expected =
        "error[E0401]: cannot read `testdata/nothing.csv`: there is no such file or folder\n";
    let message = refusal("testdata/nothing.csv", &model, RecordOptions::default());
    assert!(message.starts_with(expected), "{message}");
    let message = refusal("testdata", &model, RecordOptions::default());
    assert!(
        message.starts_with("error[E0401]: cannot read `testdata`: it is a folder\n"),
        "{message}"
    );
}

#[cfg(target_os = "linux")]
#[test]
fn a_pipe_is_refused_because_it_can_be_read_only_once() {
    let message = refusal("/dev/zero", &rig(), RecordOptions::default());
    assert!(message.contains("it is no regular file"), "{message}");
}
