//! `veribound identify`: what is refused, and what a run leaves behind whatever it finds.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that fails stops"
)]

mod support;

use support::{Place, Ran, cart_record};

/// Runs `identify m.toml r.csv` with more words, on the cart.
fn identify(place: &Place, more: &str) -> Ran {
    place.cart(5);
    place.typed(&format!("identify m.toml r.csv {more}"))
}

/// The run is refused with a message that has all `parts`, and writes nothing.
fn refused(place: &Place, more: &str, parts: &[&str]) {
    let ran = identify(place, more).ended(2);
    assert_eq!(ran.out, "", "{more}");
    for part in parts {
        assert!(ran.err.contains(part), "no {part:?} in:\n{}", ran.err);
    }
    assert!(!place.path().join("out").exists(), "{more}");
}

#[test]
fn a_command_line_that_says_too_little_or_too_much() {
    let place = Place::new();
    refused(&place, "", &["--output <DIR>"]);
    let ran = place.run(&["identify", "m.toml", "-o", "out"]).ended(2);
    assert!(ran.err.contains("<RECORD>..."), "{}", ran.err);
    for (flag, part) in [
        ("--tightness 1", "expected a number above 1"),
        ("--tightness wide", "expected a number above 1"),
        ("--paving 0%", "expected a share above 0 and up to 100%"),
        ("--paving 101%", "expected a share above 0 and up to 100%"),
        ("--paving much", "--paving"),
        ("--sets 0", "--sets"),
        ("-j 0", "--threads"),
        ("--output-error pos", "expected NAME=BOUND"),
        ("--from late", "--from"),
        ("--until never", "<SECONDS>"),
        ("--start-from out", "unexpected argument"),
    ] {
        refused(&place, &format!("-o out {flag}"), &[part]);
    }
}

#[test]
fn what_observe_refuses_is_refused_in_its_words() {
    let place = Place::new();
    for (flags, parts) in [
        ("--figures none,svg", &["error[E0612]"][..]),
        ("--reset j@still", &["error[E0601]", "--reset j@still"]),
        (
            "--input-error w=10%",
            &["error[E0603]", "^ not in [inputs]"],
        ),
        (
            "--output-error y=1",
            &[
                "error[E0601]: the model has no output `y`",
                "--output-error y=1",
                "its outputs are `pos`",
            ],
        ),
        (
            "--output-error pos=0.05",
            &["error[E0604]: the model file allows `pos` an error of 0.1 m"],
        ),
        ("--column pos=angle", &["error[E0408]"]),
        ("--until -1", &["error[E0416]"]),
    ] {
        refused(&place, &format!("-o out {flags}"), parts);
    }
    let ran = identify(&place, "-o out missing.csv").ended(2);
    assert!(ran.err.contains("error[E0401]"), "{}", ran.err);
    assert!(ran.err.contains("missing.csv"), "{}", ran.err);
    // Nothing that is read is replaced.
    place.file("summary.json", cart_record(3));
    let ran = identify(&place, "summary.json -o .").ended(2);
    let part = "error[E0611]: `summary.json` is the record: the run would replace it";
    assert!(ran.err.contains(part), "{}", ran.err);
    assert_eq!(place.read("summary.json"), cart_record(3));
}

#[test]
fn a_record_that_is_wrong_is_told_with_its_name() {
    let place = Place::new();
    place.file("bad.csv", "t,u,pos\n0,1,0\n0.1,fast,0.2\n");
    let ran = identify(&place, "bad.csv -o out").ended(2);
    for part in ["error[E0412]", "bad.csv:3:"] {
        assert!(ran.err.contains(part), "no {part:?} in:\n{}", ran.err);
    }
    assert!(!place.path().join("out").exists());
}

/// Whatever is found, all files are there, and say the same.
#[test]
fn every_run_leaves_all_its_files() {
    let place = Place::new();
    place.file("s.csv", cart_record(3));
    let flags = "s.csv -o out --figures svg --sets 3 --until 0.3 -j 1 --output-error pos=0.2";
    let ran = identify(&place, flags);
    assert!(matches!(ran.code, Some(0 | 3)), "{}", ran.err);
    for part in [
        "7 samples of 2 records in ",
        "k   [0, 4] ",
        "at the start of r.csv",
        "at the start of s.csv",
        "results in out: summary.json, points.csv, run.toml, report.html, figures in fig/",
    ] {
        assert!(ran.out.contains(part), "no {part:?} in:\n{}", ran.out);
    }
    let note = "note: pos may be off by 0.2 m, 0.1 in the model file (--output-error)\n";
    assert!(ran.err.starts_with(note), "{}", ran.err);
    let files = [
        "fig/bounds.svg",
        "points.csv",
        "report.html",
        "run.toml",
        "summary.json",
    ];
    assert_eq!(place.files("out"), files);
    let summary: serde_json::Value = serde_json::from_str(&place.read("out/summary.json")).unwrap();
    assert_eq!(summary["samples"], 7);
    assert_eq!(summary["parameters"]["k"]["prior"]["hi"], 4);
    assert_eq!(summary["starts"][1]["record"], "s.csv");
    assert_eq!(summary["interrupted"], false);
    let info: toml::Table = place.read("out/run.toml").parse().unwrap();
    assert_eq!(info["records"].as_array().unwrap().len(), 2);
    assert_eq!(info["records"][0]["samples"].as_integer(), Some(4));
    let options = &info["options"];
    assert_eq!(options["sets"].as_integer(), Some(3));
    assert_eq!(options["to"].as_str(), Some("0.3"));
    assert_eq!(options["output_error"][0].as_str(), Some("pos=0.2"));
    // The results of an observation are replaced by those of an identification, and the other way round.
    place.observe("m.toml", "r.csv", &[]).ended(0);
    assert!(place.files("out").contains(&"boxes.csv".to_owned()));
    assert!(!place.files("out").contains(&"points.csv".to_owned()));
    let ran = identify(
        &place,
        "-o out --figures none --report none --json --sets 3",
    );
    assert_eq!(ran.out, place.read("out/summary.json"));
    let files = ["points.csv", "run.toml", "summary.json"];
    assert_eq!(place.files("out"), files);
    let ran = identify(&place, "-o out --figures none --quiet --sets 3");
    assert_eq!(ran.out, "");
}

/// The window has one meaning in all commands, under both of its names.
#[test]
fn until_is_to() {
    let place = Place::new();
    let (model, record) = place.cart(5);
    let observe = |flag: &str| {
        place.observe(&model, &record, &[flag, "0.2"]).ended(0);
        place.read("out/params.csv")
    };
    assert_eq!(observe("--to"), observe("--until"));
}
