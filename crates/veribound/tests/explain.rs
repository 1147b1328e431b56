//! `veribound explain`: what a code means, by any spelling of it, and where errors say so.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that fails stops"
)]

mod support;

use support::{CART, Place, Ran, cart_record};

#[test]
fn a_code_is_explained_as_plain_text() {
    let place = Place::new();
    let ran = place.run(&["explain", "E0213"]).ended(0);
    assert_eq!(ran.err, "");
    assert!(
        ran.out.starts_with("E0213 the modes leave a gap\n\n"),
        "{}",
        ran.out
    );
    let example = "\n    forward  = { when = \"v > 0\", der = { v = \"-1\" } }\n";
    assert!(ran.out.contains(example), "{}", ran.out);
    for sign in ["```", "## ", "\u{1b}"] {
        assert!(!ran.out.contains(sign), "{sign:?} in:\n{}", ran.out);
    }
    assert!(!ran.out.contains("E0214"), "{}", ran.out);
    for typed in ["e0213", "0213", "213"] {
        assert_eq!(place.run(&["explain", typed]).ended(0).out, ran.out);
    }
}

#[test]
fn several_codes_are_explained_in_turn() {
    let place = Place::new();
    let one = |code| place.run(&["explain", code]).ended(0).out;
    let both = place.run(&["explain", "E0415", "E0201"]).ended(0).out;
    assert_eq!(both, format!("{}\n{}", one("E0415"), one("E0201")));
}

#[test]
fn without_a_code_all_are_listed() {
    let place = Place::new();
    let list = place.run(&["explain"]).ended(0).out;
    assert!(list.starts_with("Model files"), "{list}");
    assert!(list.contains("\n  E0213 the modes leave a gap\n"), "{list}");
    let codes = list.lines().filter(|line| line.starts_with("  E0")).count();
    let groups = list.lines().filter(|line| !line.starts_with(' ')).count();
    assert!(codes > 70 && groups > 5, "{list}");
}

#[test]
fn a_code_that_does_not_exist() {
    let place = Place::new();
    let ran = place.run(&["explain", "E0299"]).ended(2);
    assert_eq!(ran.out, "");
    let parts = [
        "error[E0613]: there is no code `E0299`",
        "--> command line:1:9",
        "explain E0299",
        "help: the nearest one is `E0301`",
    ];
    for part in parts {
        assert!(ran.err.contains(part), "no {part:?} in:\n{}", ran.err);
    }
    let ran = place.run(&["explain", "gap", "E0201", "E0000"]).ended(2);
    assert_eq!(ran.out, "");
    for part in ["`gap`", "`E0000`", "the nearest one is `E0101`"] {
        assert!(ran.err.contains(part), "no {part:?} in:\n{}", ran.err);
    }
}

/// The arithmetic must not matter to what explains why it was refused.
#[test]
fn codes_of_the_machine_are_explained_where_they_are_raised() {
    let place = Place::new();
    let mut command = place.command(&["explain", "E0508"]);
    command.env("VERIBOUND_LANES", "sse9");
    let ran = Ran::of(command.output().unwrap()).ended(0);
    assert!(ran.out.contains("VERIBOUND_LANES"), "{}", ran.out);
}

#[test]
fn a_run_that_fails_ends_with_the_command_that_explains_it() {
    let place = Place::new();
    let end = |model: &str, record: &str, code| {
        let model = place.file("m.toml", model);
        let record = place.file("r.csv", record);
        let ran = place.observe(&model, &record, &[]).ended(code);
        let (above, last) = ran.err.trim_end().rsplit_once("\n\n").unwrap();
        assert!(above.starts_with("error[E"), "{above}");
        last.to_owned()
    };
    let two = CART.replace("k * u", "kk * uu").replace(" +- 0.1", "");
    assert_eq!(
        end(&two, &cart_record(3), 2),
        "for more about these errors, try: veribound explain E0201 E0212"
    );
    let wrong = "t,u,pos\n0,1,0\n0.1,fast,0.2\n";
    assert_eq!(
        end(CART, wrong, 2),
        "for more about this error, try: veribound explain E0412"
    );
    let refuting = "t,u,pos\n0,1,0\n0.1,1,90\n";
    assert_eq!(
        end(CART, refuting, 1),
        "for more about this error, try: veribound explain E0301"
    );
}
