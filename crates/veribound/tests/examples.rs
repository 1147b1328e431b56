//! Every example with a record: the observer narrows its priors and never loses the values that the record
//! was made with.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that fails stops"
)]

mod support;

use std::fs;
use support::{Place, bounds, example};

/// The folder, the last time to read, and for every parameter: name, true value, largest part of the prior
/// that may be left.
type Case = (
    &'static str,
    &'static str,
    &'static [(&'static str, f64, f64)],
);

const CASES: [Case; 12] = [
    ("bouncing-ball", "3", &[("e", 0.75, 0.3), ("g", 9.81, 0.4)]),
    ("chain", "0.9", &[("k", 100.0, 1.0), ("T", 2.0, 0.6)]),
    ("valve", "6", &[("c", 60.0, 1.0), ("Fc", 1.5, 0.7)]),
    (
        "two-tanks",
        "40",
        &[
            ("a12", 0.09, 0.01),
            ("a2", 0.068, 0.01),
            ("w", 2.0, 0.3),
            ("edge", 0.5, 0.1),
        ],
    ),
    (
        "belt",
        "9",
        &[("k", 1.0, 0.2), ("c", 0.1, 1.0), ("mu", 0.3, 0.15)],
    ),
    (
        "backlash",
        "4.2",
        &[
            ("k", 1.0, 0.1),
            ("gap", 0.2, 0.3),
            ("inv_J", 5.0, 0.15),
            ("b", 0.1, 0.6),
        ],
    ),
    (
        "quarter-car",
        "2",
        &[
            ("k", 40.0, 0.5),
            ("c", 6.0, 0.15),
            ("stop", 200.0, 0.7),
            ("room", 0.05, 0.7),
        ],
    ),
    (
        "compartments",
        "30",
        &[("p1", 0.6, 0.15), ("p2", 0.15, 0.1), ("p3", 0.35, 0.15)],
    ),
    (
        "michaelis-menten",
        "20",
        &[("V", 1.0, 0.1), ("K", 2.0, 0.1)],
    ),
    (
        "lotka-volterra",
        "10",
        &[("theta1", 3.0, 0.4), ("theta2", 1.0, 0.4)],
    ),
    ("bioreactor", "20", &[("mu_m", 1.2, 0.5), ("K_S", 7.1, 0.5)]),
    (
        "anaerobic-digestion",
        "4",
        &[("mu1_m", 1.2, 0.9), ("mu2_m", 0.74, 0.4)],
    ),
];

fn file(name: &str, file: &str) -> String {
    example(name).join(file).display().to_string()
}

#[test]
fn true_values_stay_inside_and_priors_shrink() {
    let place = Place::new();
    for (name, to, truth) in CASES {
        let (model, record) = (file(name, "model.toml"), file(name, "record.csv"));
        place.run(&["check", &model]).ended(0);
        place.observe(&model, &record, &["--to", to]).ended(0);
        let table = place.read("out/params.csv");
        for (param, value, left) in truth {
            let rows = bounds(&table, param);
            for (row, (lo, hi)) in rows.iter().enumerate() {
                assert!(
                    lo <= value && value <= hi,
                    "{name}: {param} is lost at row {row}: [{lo}, {hi}]"
                );
            }
            let width = |(lo, hi): &(f64, f64)| hi - lo;
            let share = width(rows.last().unwrap()) / width(&rows[0]);
            assert!(
                share <= *left,
                "{name}: {share} of the prior of {param} is left"
            );
        }
    }
}

#[test]
fn no_example_with_a_record_is_forgotten() {
    for folder in fs::read_dir(example("")).unwrap() {
        let folder = folder.unwrap();
        let name = folder.file_name().into_string().unwrap();
        if folder.path().join("record.csv").exists() {
            assert!(
                CASES.iter().any(|(known, _, _)| *known == name),
                "{name} has no true values here"
            );
        }
    }
}

/// With the blood not measured, a drug that goes to and fro cannot be told from one that stays.
#[test]
fn the_tissue_alone_tells_the_observer_nothing() {
    let place = Place::new();
    let (model, record) = (
        file("compartments", "model-tissue.toml"),
        file("compartments", "record.csv"),
    );
    place.observe(&model, &record, &[]).ended(0);
    let table = place.read("out/params.csv");
    for (param, value) in [("p1", 0.6), ("p2", 0.15), ("p3", 0.35)] {
        for (lo, hi) in bounds(&table, param) {
            assert!(lo <= value && value <= hi, "{param} is lost");
        }
    }
}

/// The record of fifty masses is that of fewer, as long as those that move are among them.
#[test]
fn a_chain_that_is_too_short_is_refuted() {
    let place = Place::new();
    let whole = fs::read_to_string(file("chain", "model.toml")).unwrap();
    let record = file("chain", "record.csv");
    for (n, code) in [("2", 1), ("5", 0)] {
        let shorter = whole.replace("n = 50", &format!("n = {n}"));
        assert_ne!(shorter, whole);
        let model = place.file("m.toml", shorter);
        place.observe(&model, &record, &[]).ended(code);
    }
    let (lo, hi) = *bounds(&place.read("out/params.csv"), "T").last().unwrap();
    assert!(lo <= 2.0 && 2.0 <= hi && hi - lo < 1.1, "{lo} {hi}");
}

/// The records can be made again, to the byte, by the command that their first line tells. Those with more
/// than 100 internal steps for a sample take too long here.
#[test]
fn the_records_are_those_that_the_program_makes() {
    for (name, _, _) in CASES {
        let record = fs::read_to_string(file(name, "record.csv")).unwrap();
        let line = record.lines().next().unwrap();
        let mut arguments: Vec<&str> = line.trim_start_matches("# veribound ").split(' ').collect();
        let steps = arguments
            .iter()
            .position(|word| *word == "--steps")
            .unwrap();
        if arguments[steps + 1].parse::<u32>().unwrap() > 100 {
            continue;
        }
        let place = Place::new();
        for input in ["model.toml", "profile.csv"] {
            if let Ok(text) = fs::read(file(name, input)) {
                place.file(input, text);
            }
        }
        arguments.extend(["-o", "again.csv"]);
        place.run(&arguments).ended(0);
        assert!(
            place.read("again.csv") == record,
            "the record of {name} differs"
        );
    }
}
