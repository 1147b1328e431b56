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
    let last = text.lines().last().unwrap();
    assert!(last.contains("try: veribound explain E0"), "{text}");
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
    let (model, record) = place.cart(3);
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
    let (model, record) = place.cart(3);
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
    let (model, record) = place.cart(5000);
    let program = env!("CARGO_BIN_EXE_veribound");
    let line = format!(
        "trap '' XFSZ; ulimit -f 64; exec '{program}' observe {model} {record} -o out --figures none --report none"
    );
    let output = std::process::Command::new("sh")
        .args(["-c", &line])
        .current_dir(place.path())
        .output();
    let ran = support::Ran::of(output.unwrap()).ended(2);
    says(&ran.err, &["error[E050", "out/"]);
    assert_eq!(place.files("out"), [""; 0]);
}

/// A second run into the same folder, on disks that are full at different places.
#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_is_full_leaves_the_results_of_the_run_before() {
    let place = Place::new();
    let (model, record) = place.cart(200);
    let flags = ["--figures", "svg"];
    place
        .run(&[&["observe", &model, &record, "-o", "out"], flags.as_slice()].concat())
        .ended(0);
    let before: Vec<(String, String)> = place
        .files("out")
        .into_iter()
        .map(|name| (name.clone(), place.read(&format!("out/{name}"))))
        .collect();
    assert!(before.iter().any(|(name, _)| name == "summary.json"));
    let program = env!("CARGO_BIN_EXE_veribound");
    for blocks in [1, 2, 4, 8, 12, 16, 20] {
        let line = format!(
            "trap '' XFSZ; ulimit -f {blocks}; \
             exec '{program}' observe {model} {record} -o out --figures svg --to 19"
        );
        let output = std::process::Command::new("sh")
            .args(["-c", &line])
            .current_dir(place.path())
            .output();
        let ran = support::Ran::of(output.unwrap()).ended(2);
        says(&ran.err, &["error[E050", "out/"]);
        for (name, text) in &before {
            assert_eq!(
                &place.read(&format!("out/{name}")),
                text,
                "{blocks}: {name}"
            );
        }
        assert_eq!(place.files("out").len(), before.len());
    }
}

#[test]
fn results_in_the_place_of_what_is_read() {
    let place = Place::new();
    let model = place.file("m.toml", CART);
    let record = place.file("params.csv", cart_record(5));
    place.observe(&model, &record, &[]).ended(0);
    std::fs::copy(place.path().join(&model), place.path().join("run.toml")).unwrap();
    let observe = |model: &str, out: &str, more: &[&str], parts: &[&str]| {
        let before = place.files("");
        let mut arguments = vec!["observe", model, &record, "-o", out];
        arguments.extend(more);
        let ran = place.run(&arguments).ended(2);
        says(&ran.err, &[parts, &["error[E0611]", "-o DIR"]].concat());
        assert_eq!(place.read(&record), cart_record(5));
        assert_eq!(place.files(""), before);
    };
    let is_record = "`params.csv` is the record";
    for out in [".", "out/..", "new/..", place.path().to_str().unwrap()] {
        observe(&model, out, &[], &[is_record]);
    }
    observe(
        "run.toml",
        "out/../.",
        &[],
        &["`run.toml` is the model file"],
    );
    let out = "those in `out`";
    observe(&model, "out", &["--start-from", "out"], &[out]);
    observe(&model, "./new/../out", &["--overlay", "out"], &[out]);

    let decay = "format = 1\nstates = [\"x\"]\ninputs = [\"u\"]\ninit.x = 1\n\
        params.k = [0, 3]\nder.x = \"-k * u\"\noutputs.y = \"x +- 0.1\"\n";
    let (model, profile) = (
        place.file("decay.toml", decay),
        place.file("p.csv", "t,u\n0,1\n1,1\n"),
    );
    for (output, what) in [
        ("decay.toml", "the model file"),
        ("out/../p.csv", "the profile"),
    ] {
        let flags = [
            "simulate", &model, "--params", "k=1", "--input", &profile, "-o", output,
        ];
        let ran = place.run(&flags).ended(2);
        says(&ran.err, &["error[E0611]", what, "-o RECORD"]);
        assert_eq!(place.read(&model), decay);
        assert_eq!(place.read(&profile), "t,u\n0,1\n1,1\n");
    }
}

#[cfg(unix)]
#[test]
fn results_in_the_place_of_what_a_link_leads_to() {
    let place = Place::new();
    let (model, record) = (
        place.file("m.toml", CART),
        place.file("states.csv", cart_record(5)),
    );
    std::os::unix::fs::symlink(place.path(), place.path().join("here")).unwrap();
    let ran = place
        .run(&["observe", &model, &record, "-o", "here"])
        .ended(2);
    says(&ran.err, &["error[E0611]", "`states.csv` is the record"]);
    assert_eq!(place.read(&record), cart_record(5));
}

#[test]
fn a_start_from_results_that_are_not_complete() {
    let place = Place::new();
    let (model, record) = place.cart(5);
    place.observe(&model, &record, &[]).ended(0);
    std::fs::remove_file(place.path().join("out/summary.json")).unwrap();
    let flags = ["observe", &model, &record, "-o", "b", "--start-from", "out"];
    let ran = place.run(&flags).ended(2);
    says(
        &ran.err,
        &["error[E0504]", "`out` holds no complete results"],
    );
    assert!(!place.path().join("b").exists());
}

#[cfg(unix)]
#[test]
fn a_record_that_may_not_be_read() {
    use std::os::unix::fs::PermissionsExt;
    let place = Place::new();
    let (model, record) = place.cart(5);
    let path = place.path().join(&record);
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o000)).unwrap();
    if std::fs::read(&path).is_ok() {
        // Straight to the terminal: the test harness swallows what passes through its macros.
        use std::io::Write;
        let _ = writeln!(
            std::io::stderr(),
            "SKIPPED a_record_that_may_not_be_read: this user may read everything"
        );
        return;
    }
    let ran = place.observe(&model, &record, &[]).ended(2);
    says(&ran.err, &["error[E0401]", "`r.csv`", "permission denied"]);
    assert!(!place.path().join("out").exists());
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
        &["--figures", "svg"],
        &["error[E0612]", "--figures svg,png"],
    );
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
    let (model, record) = place.cart(3);
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

#[test]
fn a_path_of_the_lanes_that_does_not_exist() {
    let place = Place::new();
    let (model, record) = place.cart(3);
    let mut command = place.command(&["observe", &model, &record, "-o", "out"]);
    command.env("VERIBOUND_LANES", "sse9");
    let ran = support::Ran::of(command.output().unwrap()).ended(2);
    says(&ran.err, &["E0508", "`sse9`", "portable"]);
    assert!(!place.path().join("out").exists());
}
