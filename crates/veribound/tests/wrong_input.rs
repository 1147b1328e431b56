//! Wrong input, one test for each kind: exit code 2, a message with the place and one thing to do, and
//! nothing written.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that fails stops"
)]

mod support;

use support::{CART, Place, cart_record};

/// Observes a wrong model or record; asserts that the message holds all `parts` and no file appears.
fn refused(model: impl AsRef<[u8]>, record: impl AsRef<[u8]>, more: &[&str], parts: &[&str]) {
    let place = Place::new();
    let (model, record) = (place.file("m.toml", model), place.file("r.csv", record));
    let ran = place.observe(&model, &record, more).ended(2);
    says(&ran.err, parts);
    assert_eq!(ran.out, "");
    assert!(
        !place.path().join("out").exists(),
        "{:?}",
        place.files("out")
    );
}

fn says(text: &str, parts: &[&str]) {
    for part in parts.iter().chain(&["error"]) {
        assert!(text.contains(part), "no {part:?} in:\n{text}");
    }
    assert!(!text.contains("panicked"), "{text}");
    assert!(text.contains("help: "), "nothing to do in:\n{text}");
}

fn wrong_model(from: &str, to: &str, parts: &[&str]) {
    assert!(CART.contains(from), "{from}");
    refused(CART.replace(from, to), cart_record(3), &[], parts);
}

fn wrong_record(record: impl AsRef<[u8]>, parts: &[&str]) {
    refused(CART, record, &[], parts);
}

#[test]
fn an_unknown_name() {
    wrong_model(
        "k * u",
        "kk * u",
        &["error[E02", "m.toml:6:", "`kk`", "^^", "did you mean `k`?"],
    );
}

#[test]
fn a_unit_of_wrong_syntax() {
    wrong_model(
        "m/(V*s)",
        "m/(V*s",
        &["error[E0117]", "m.toml:5:", "m/(V*s", "^"],
    );
}

#[test]
fn an_unbalanced_bracket() {
    wrong_model(
        "k * u",
        "(k * u",
        &["error[E01", "m.toml:6:", "(k * u", "^"],
    );
}

#[test]
fn an_empty_prior() {
    wrong_model(
        "[0, 4]",
        "[]",
        &["error[E0", "m.toml:5:", "bounds = []", "^"],
    );
}

#[test]
fn a_prior_that_is_reversed() {
    wrong_model(
        "[0, 4]",
        "[4, 0]",
        &["error[E02", "m.toml:5:", "[4, 0]", "^"],
    );
}

#[test]
fn an_output_without_a_bound() {
    wrong_model(
        "x +- 0.1 [m]",
        "x [m]",
        &["error[E0212]", "m.toml:7:", "`pos`", "+- 0.1"],
    );
}

#[test]
fn modes_that_leave_a_gap() {
    let model = CART.replace(
        "der.x = \"k * u\"\n",
        "[modes]\nup = { when = \"x > 0\", der = { x = \"k * u\" } }\n\
         down = { when = \"x < -0.5\", der = { x = \"-k * u\" } }\n[der]\n",
    );
    let model = model.replace("[der]\noutputs.pos", "[outputs]\npos");
    refused(
        model,
        cart_record(3),
        &[],
        &["error[E02", "m.toml:", "^", "x"],
    );
}

#[test]
fn numbers_that_are_none() {
    wrong_record(
        "t,u,pos\n0,1,0\n0.1,inf,0.2\n",
        &["error[E04", "r.csv:3:", "inf", "^^^"],
    );
    wrong_record(
        "t,u,pos\n0,1,0\n0.1,fast,0.2\n",
        &["error[E04", "r.csv:3:", "fast", "^^^^"],
    );
    // An output that is NaN was not measured; an input must be known.
    wrong_record(
        "t,u,pos\n0,1,0\n0.1,NaN,0.2\n",
        &["error[E04", "r.csv:3:", "`u`"],
    );
}

#[test]
fn a_column_that_is_missing() {
    let record = "t,u,position\n0,1,0\n";
    wrong_record(record, &["error[E04", "r.csv:1:", "`pos`", "--column"]);
    refused(
        CART,
        record,
        &["--column", "pos=nowhere"],
        &["error[E04", "nowhere"],
    );
}

#[test]
fn time_that_does_not_increase() {
    wrong_record(
        "t,u,pos\n0,1,0\n0.2,1,0.4\n0.1,1,0.2\n",
        &["error[E04", "r.csv:4:", "0.1", "^"],
    );
}

#[test]
fn time_stamps_that_are_there_twice() {
    wrong_record(
        "t,u,pos\n0,1,0\n0.1,1,0.2\n0.1,1,0.2\n",
        &["error[E04", "r.csv:4:", "0.1", "^"],
    );
}

#[test]
fn a_decimal_comma() {
    wrong_record(
        "t;u;pos\n0;1;0\n0,1;1;0,2\n",
        &["error[E04", "r.csv:3:", "0,1", "^", "comma"],
    );
}

#[test]
fn an_empty_file() {
    wrong_record("", &["error[E0402]", "r.csv", "empty"]);
    refused(
        "",
        cart_record(3),
        &[],
        &["error[E0104]", "m.toml", "empty"],
    );
}

#[test]
fn a_header_without_samples() {
    wrong_record("t,u,pos\n", &["error[E0403]", "r.csv", "no samples"]);
}

#[test]
fn a_binary_file() {
    let bytes: Vec<u8> = (0..=255).cycle().take(4000).collect();
    wrong_record(&bytes, &["error[E04", "r.csv"]);
    refused(&bytes, cart_record(3), &[], &["error[E01", "m.toml"]);
}

#[test]
fn paths_that_cannot_be_read() {
    let place = Place::new();
    let (model, record) = (
        place.file("m.toml", CART),
        place.file("r.csv", cart_record(3)),
    );
    let ran = place.observe("nowhere.toml", &record, &[]).ended(2);
    says(
        &ran.err,
        &["error[E0101]", "`nowhere.toml`", "no such file"],
    );
    let ran = place.observe(&model, "nowhere.csv", &[]).ended(2);
    says(&ran.err, &["error[E0401]", "`nowhere.csv`", "no such file"]);
    let ran = place.observe(&model, ".", &[]).ended(2);
    says(&ran.err, &["error[E0401]", "folder"]);
    let ran = place.run(&["check", "nowhere.toml"]).ended(2);
    says(&ran.err, &["error[E0101]"]);
    assert!(!place.path().join("out").exists());
}

#[test]
fn a_folder_that_cannot_be_written() {
    let place = Place::new();
    let (model, record) = (
        place.file("m.toml", CART),
        place.file("r.csv", cart_record(3)),
    );
    place.file("out", "a file is in the way");
    let ran = place.observe(&model, &record, &[]).ended(2);
    says(&ran.err, &["error[E0501]", "`out`", "-o DIR"]);
    assert_eq!(place.read("out"), "a file is in the way");
}

/// A disk that takes no more: the shell limits the size of files, so that writing fails half way.
#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_is_full_leaves_no_half_table() {
    let place = Place::new();
    let (model, record) = (
        place.file("m.toml", CART),
        place.file("r.csv", cart_record(5000)),
    );
    let program = env!("CARGO_BIN_EXE_veribound");
    let line = format!(
        "trap '' XFSZ; ulimit -f 64; exec '{program}' observe {model} {record} -o out --figures none"
    );
    let output = std::process::Command::new("sh")
        .args(["-c", &line])
        .current_dir(place.path())
        .output();
    let ran = support::Ran::of(output.unwrap()).ended(2);
    says(&ran.err, &["error[E050", "out/"]);
    assert_eq!(place.files("out"), [""; 0]);
}

#[test]
fn flags_that_do_not_fit_the_model() {
    let record = cart_record(3);
    let flag = |flags: &[&str], parts: &[&str]| refused(CART, &record, flags, parts);
    flag(
        &["--reset", "j@still"],
        &["error[E0601]", "command line", "--reset j@still", "`k`"],
    );
    flag(
        &["--reset", "k@still"],
        &["error[E0602]", "no signal or event `still`"],
    );
    flag(&["--input-error", "w=10%"], &["error[E0603]", "`u`"]);
    flag(&["--start-from", "nowhere"], &["error[E0401]", "nowhere"]);
    flag(&["--overlay", "nowhere"], &["error[E0605]", "nowhere"]);
    flag(
        &["--from", "7"],
        &["error[E0416]", "runs from 0 s to 0.2 s"],
    );
    let own = CART.replace(
        "inputs = [\"u [V]\"]",
        "inputs.u = { error = { relative = 0.2 } }",
    );
    refused(
        own,
        &record,
        &["--input-error", "u=10%"],
        &["error[E0604]", "cannot take that back"],
    );
}

#[test]
fn flags_that_cannot_be_read() {
    let place = Place::new();
    let (model, record) = (
        place.file("m.toml", CART),
        place.file("r.csv", cart_record(3)),
    );
    for flags in [
        ["--boxes", "0"],
        ["--boxes", "many"],
        ["--order", "99"],
        ["--to", "1,5"],
        ["--zoom", "3..2"],
        ["--reset", "k"],
        ["--input-error", "u"],
        ["--wrong", "1"],
    ] {
        let ran = place.observe(&model, &record, &flags).ended(2);
        assert!(ran.err.contains(flags[0]), "{}", ran.err);
    }
    place.run(&["observe", &model]).ended(2);
    place.run(&[]).ended(2);
    place.run(&["--help"]).ended(0);
    assert!(!place.path().join("out").exists());
}
