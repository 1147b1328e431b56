//! The four experiments of the talk on the first 15 s of the drive train record.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that fails stops"
)]

mod support;

use support::{Place, Ran, bounds, rig};
use veribound_interval::lanes::Path;

/// The values the record was made with.
const TRUTH: [(&str, f64); 3] = [("alpha", -2.0), ("beta", 200.0), ("T_Fs", 0.15)];

fn observe(place: &Place, out: &str, more: &[&str]) -> String {
    let (model, record) = (rig("model.toml"), rig("rig.csv"));
    let mut arguments = vec![
        "observe",
        &model,
        &record,
        "-o",
        out,
        "--figures",
        "none",
        "--to",
        "15",
    ];
    arguments.extend(more);
    let ran = place.run(&arguments).ended(0);
    let table = place.read(&format!("{out}/params.csv"));
    for (name, truth) in TRUTH {
        let rows = bounds(&table, name);
        assert_eq!(rows.len(), 1501);
        for (at, (lo, hi)) in rows.iter().enumerate() {
            assert!(
                *lo <= truth && truth <= *hi,
                "{name} is lost at row {at} of {out}"
            );
        }
    }
    ran.err
}

fn widths(place: &Place, out: &str) -> [f64; 3] {
    let table = place.read(&format!("{out}/params.csv"));
    TRUTH.map(|(name, _)| {
        let (lo, hi) = *bounds(&table, name).last().unwrap();
        hi - lo
    })
}

#[test]
fn plain_then_reset_then_second_pass_then_uncertain_torque() {
    let place = Place::new();
    // (a) plain
    assert_eq!(observe(&place, "a", &[]), "");
    let plain = widths(&place, "a");
    assert!(
        plain[0] < 5.0 && plain[1] < 399.0 && plain[2] < 0.2,
        "{plain:?}"
    );

    // (b) the dry friction may be new after a standstill of 0.2 s
    let said = observe(&place, "b", &["--reset", "T_Fs@still:0.2"]);
    assert!(said.contains("T_Fs may take a new value"), "{said}");
    let table = place.read("b/params.csv");
    assert!(
        table.lines().any(|line| line.ends_with(",T_Fs")),
        "no reset in the table"
    );
    let dry = bounds(&table, "T_Fs");
    let prior = |(lo, hi): &(f64, f64)| *lo <= 0.0 && *hi >= 0.3;
    let narrow = dry.iter().position(|bounds| !prior(bounds)).unwrap();
    assert!(
        dry[narrow..].iter().any(prior),
        "the reset gives nothing back"
    );

    // (c) a second pass from the boxes of the first
    let said = observe(&place, "c", &["--start-from", "a"]);
    assert!(said.contains("boxes that the run in a left"), "{said}");
    let second = widths(&place, "c");
    assert!(
        second
            .iter()
            .zip(&plain)
            .all(|(second, first)| second <= first),
        "{second:?}"
    );
    assert!(second.iter().sum::<f64>() < plain.iter().sum::<f64>());

    // (c) after (b): what can be reset is not taken over
    let said = observe(
        &place,
        "c2",
        &["--start-from", "a", "--reset", "T_Fs@still:0.2"],
    );
    assert!(
        said.contains("not taken for `T_Fs`, which can be reset"),
        "{said}"
    );

    // (d) the torque may be off by 10 %
    let said = observe(&place, "d", &["--input-error", "u=10%", "--overlay", "a"]);
    assert!(
        said.contains("u may be off by 0.1 times the recorded value"),
        "{said}"
    );
    let uncertain = widths(&place, "d");
    assert!(
        uncertain.iter().zip(&plain).all(|(d, a)| d >= a),
        "{uncertain:?} {plain:?}"
    );
}

#[test]
fn the_short_form_of_the_model_gives_the_same_bounds() {
    let place = Place::new();
    let record = rig("rig.csv");
    for (out, model) in [
        ("long", rig("model.toml")),
        ("short", rig("model-friction.toml")),
    ] {
        let flags = [
            "observe",
            &model,
            &record,
            "-o",
            out,
            "--figures",
            "none",
            "--to",
            "8",
        ];
        place.run(&flags).ended(0);
    }
    assert_eq!(
        place.read("long/params.csv"),
        place.read("short/params.csv")
    );
}

#[test]
fn the_record_in_the_repository_is_the_one_that_the_program_makes() {
    let place = Place::new();
    let record = std::fs::read_to_string(rig("rig.csv")).unwrap();
    let line = record.lines().next().unwrap();
    let mut arguments: Vec<String> = line
        .trim_start_matches("# veribound ")
        .split(' ')
        .map(str::to_owned)
        .collect();
    for (name, path) in [
        ("model.toml", rig("model.toml")),
        ("profile.csv", rig("profile.csv")),
    ] {
        *arguments.iter_mut().find(|word| *word == name).unwrap() = path;
    }
    arguments.extend(["-o", "again.csv"].map(str::to_owned));
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    place.run(&arguments).ended(0);
    assert!(place.read("again.csv") == record, "the record differs");
}

/// Which instructions do the arithmetic is not to be seen in the results: to the bit the same on every
/// path that this processor has.
#[test]
fn every_path_of_the_lanes_gives_the_same_bounds() {
    let place = Place::new();
    let (model, record) = (rig("model.toml"), rig("rig.csv"));
    let of = |path: Path| {
        let out = path.name();
        let flags = ["-o", out, "--figures", "none", "--to", "4"];
        let arguments = [&["observe", &model, &record], &flags[..]].concat();
        let mut command = place.command(&arguments);
        command.env("VERIBOUND_LANES", out);
        Ran::of(command.output().unwrap()).ended(0);
        ["params.csv", "states.csv", "boxes.csv"].map(|name| place.read(&format!("{out}/{name}")))
    };
    let portable = of(Path::Portable);
    for path in Path::available() {
        assert!(of(path) == portable, "{} differs", path.name());
    }
}
