//! Verdicts, exit codes and files of whole runs.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that fails stops"
)]

mod support;

use support::{CART, Place, bounds, cart_record, rig};

fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn a_consistent_run_writes_all_files() {
    let place = Place::new();
    let (model, record) = place.cart(21);
    let ran = place
        .run(&["observe", &model, &record, "-o", "out"])
        .ended(0);
    assert_eq!(ran.err, "");
    assert!(
        ran.out.starts_with("  consistent   21 of 21 samples"),
        "{}",
        ran.out
    );
    assert!(ran.out.contains("k   [0, 4]"), "{}", ran.out);
    let expected = [
        "boxes.csv",
        "fig/modes.png",
        "fig/modes.svg",
        "fig/outputs.png",
        "fig/outputs.svg",
        "fig/params.png",
        "fig/params.svg",
        "fig/states.png",
        "fig/states.svg",
        "fig/work.png",
        "fig/work.svg",
        "params.csv",
        "report.html",
        "run.toml",
        "states.csv",
        "summary.json",
    ];
    assert_eq!(place.files("out"), expected);
    assert_eq!(bounds(&place.read("out/params.csv"), "k").len(), 21);
    let run: toml::Table = place.read("out/run.toml").parse().unwrap();
    assert_eq!(run["record"]["samples"].as_integer(), Some(21));
    assert_eq!(run["options"]["boxes"].as_integer(), Some(50));
    let summary = json(&place.read("out/summary.json"));
    assert_eq!(summary["verdict"], "consistent");
    assert_eq!(summary["samples"], 21);
    assert_eq!(summary["interrupted"], false);
    let k = &summary["parameters"]["k"];
    assert!(k["lo"].as_f64().unwrap() <= 2.0 && k["hi"].as_f64().unwrap() >= 2.0);
    assert!(k["hi"].as_f64().unwrap() - k["lo"].as_f64().unwrap() < 2.0);
    assert_eq!(k["unit"], "m/(V*s)");
    assert_eq!(k["prior"]["hi"], 4);
    assert!(summary["work"]["box_steps"].as_u64().unwrap() > 20);
}

#[test]
fn equal_runs_write_equal_files() {
    let place = Place::new();
    let (model, record) = place.cart(21);
    let tables = ["params.csv", "states.csv", "boxes.csv", "run.toml"];
    place.observe(&model, &record, &[]).ended(0);
    let first = tables.map(|name| place.read(&format!("out/{name}")));
    place.observe(&model, &record, &[]).ended(0);
    assert_eq!(tables.map(|name| place.read(&format!("out/{name}"))), first);
}

#[test]
fn json_and_quiet_say_what_they_promise() {
    let place = Place::new();
    let (model, record) = place.cart(5);
    let ran = place.observe(&model, &record, &["--json"]).ended(0);
    assert_eq!(ran.out, place.read("out/summary.json"));
    let ran = place.observe(&model, &record, &["--quiet"]).ended(0);
    assert_eq!((ran.out.as_str(), ran.err.as_str()), ("", ""));
}

#[test]
fn the_results_of_a_folder_are_those_of_the_last_run() {
    let place = Place::new();
    let (model, record) = place.cart(5);
    place
        .run(&["observe", &model, &record, "-o", "out"])
        .ended(0);
    place.file("out/notes.txt", "mine");
    place.file("out/fig/photo.png", "mine");
    place.file("out/.params.csv.4294967295.part", "a killed run");
    place.observe(&model, &record, &[]).ended(0);
    let expected = [
        "boxes.csv",
        "fig/photo.png",
        "notes.txt",
        "params.csv",
        "run.toml",
        "states.csv",
        "summary.json",
    ];
    assert_eq!(place.files("out"), expected);
}

#[test]
fn a_run_says_all_that_repeats_it() {
    let place = Place::new();
    let (model, record) = place.cart(21);
    place.observe(&model, &record, &[]).ended(0);
    let flags = [
        "observe",
        &model,
        &record,
        "-o",
        "b",
        "--start-from",
        "out",
        "--overlay",
        "out",
        "--zoom",
        "0.5..1",
        "--figures",
        "svg",
    ];
    place.run(&flags).ended(0);
    let text = place.read("b/run.toml");
    assert!(
        text.starts_with("# Paths are relative to the folder in which the command was run.\n"),
        "{text}"
    );
    assert!(!text.contains(place.path().to_str().unwrap()), "{text}");
    let run: toml::Table = text.parse().unwrap();
    let words = run["program"]["command"].as_array().unwrap();
    let words: Vec<&str> = words.iter().map(|word| word.as_str().unwrap()).collect();
    assert_eq!(words, [["veribound"].as_slice(), flags.as_slice()].concat());
    let options = &run["options"];
    assert_eq!(options["zoom"].as_str(), Some("0.5..1"));
    assert_eq!(options["start_from"].as_str(), Some("out"));
    assert_eq!(options["overlay"].as_str(), Some("out"));
    let mut read = vec![&run["model"], &run["record"], &run["overlay"]];
    read.extend(run["start"].as_array().unwrap());
    let expected = [
        "m.toml",
        "r.csv",
        "out/params.csv",
        "out/summary.json",
        "out/boxes.csv",
    ];
    for (file, name) in read.iter().zip(expected) {
        assert_eq!(file["path"].as_str(), Some(name));
        let digest = veribound_data::sha256_of_file(place.path().join(name)).unwrap();
        assert_eq!(file["sha256"].as_str(), Some(digest.as_str()), "{name}");
    }
    assert_eq!(read.len(), expected.len());
}

#[test]
fn missing_values_are_counted_and_unused_columns_named() {
    let place = Place::new();
    let record = "t [s],u,pos,wind,note\n0,1,0,3,a\n0.1,1,NaN,3,\n0.2,1,,3,b\n30,1,60,3,\n";
    let (model, record) = (place.file("m.toml", CART), place.file("r.csv", record));
    // The long gap before the last sample is no problem.
    let ran = place.observe(&model, &record, &[]).ended(0);
    assert_eq!(
        ran.err,
        "note: pos: 2 values missing\nnote: columns not used: wind, note\n"
    );
    let summary = json(&place.read("out/summary.json"));
    assert_eq!(summary["missing"], serde_json::json!({ "pos": 2 }));
    let ran = place.observe(&model, &record, &["-q"]).ended(0);
    assert_eq!(ran.err, "");
}

#[test]
fn another_unit_is_said_even_to_those_who_want_to_hear_nothing() {
    let place = Place::new();
    let record = cart_record(5).replace("pos", "pos [ticks]");
    let (model, record) = (place.file("m.toml", CART), place.file("r.csv", record));
    let ran = place.observe(&model, &record, &["--quiet"]).ended(0);
    let text = "the column `pos [ticks]` is in ticks, the model says m for `pos`: the numbers are taken \
                as they are";
    assert_eq!(ran.err, format!("warning: {text}\n"));
    let summary = json(&place.read("out/summary.json"));
    assert_eq!(summary["assumptions"], serde_json::json!([text]));
    assert!(place.read("out/run.toml").contains(text));
}

#[test]
fn a_record_in_another_unit_gives_the_same_bounds() {
    let place = Place::new();
    let model = place.file("m.toml", CART);
    let plain = place.file("plain.csv", cart_record(21));
    place.observe(&model, &plain, &[]).ended(0);
    let expected = (place.read("out/states.csv"), place.read("out/params.csv"));
    let mut text = String::from("t,u [mV],pos [cm]\n");
    for k in 0..21 {
        text += &format!("{}.{},1000,{}\n", k / 10, k % 10, 20 * k);
    }
    let scaled = place.file("scaled.csv", text);
    let ran = place.observe(&model, &scaled, &[]).ended(0);
    let said = [
        "the column `u [mV]` is in mV and converted to V: times 1/1000",
        "the column `pos [cm]` is in cm and converted to m: times 1/100",
    ];
    assert_eq!(ran.err, format!("note: {}\nnote: {}\n", said[0], said[1]));
    let summary = json(&place.read("out/summary.json"));
    assert_eq!(summary["assumptions"], serde_json::json!(said));
    assert!(
        said.iter()
            .all(|said| place.read("out/run.toml").contains(said))
    );
    let found = (place.read("out/states.csv"), place.read("out/params.csv"));
    assert_eq!(found, expected);
}

#[test]
fn a_record_in_degrees_gives_bounds_that_overlap_those_of_one_in_radians() {
    let place = Place::new();
    let model = CART.replace("[m]", "[rad]").replace("m/(V*s)", "rad/(V*s)");
    let model = place.file("m.toml", model);
    let mut texts = ["t,u,pos [rad]\n", "t,u,pos [deg]\n"].map(String::from);
    for k in 0..21 {
        let (time, angle) = (f64::from(k) / 10.0, f64::from(k) / 5.0);
        texts[0] += &format!("{time:.1},1,{angle:.1}\n");
        texts[1] += &format!("{time:.1},1,{:.15}\n", angle.to_degrees());
    }
    let found = texts.map(|text| {
        let record = place.file("r.csv", text);
        place.observe(&model, &record, &[]).ended(0);
        bounds(&place.read("out/params.csv"), "k")
    });
    assert_eq!(found[0].len(), 21);
    for (one, other) in found[0].iter().zip(&found[1]) {
        assert!(one.0 <= other.1 && other.0 <= one.1, "{one:?} {other:?}");
        assert!((one.0 - other.0).abs() < 1e-9 && (one.1 - other.1).abs() < 1e-9);
    }
}

#[test]
fn a_window_says_where_the_start_intervals_hold() {
    let place = Place::new();
    let record = cart_record(21)
        .replace("u,pos", "u,x_m")
        .replace("0.0,1,0.0", "0.0,1,9.0");
    let (model, record) = (place.file("m.toml", CART), place.file("r.csv", record));
    let flags = ["--column", "pos=x_m", "--from", "0.15", "--to", "0.4"];
    let ran = place.observe(&model, &record, &flags).ended(0);
    let said = "the start intervals of the model file hold at t = 0.2 s";
    assert!(ran.err.contains(said), "{}", ran.err);
    let summary = json(&place.read("out/summary.json"));
    assert!(
        summary["assumptions"][0]
            .as_str()
            .unwrap()
            .starts_with(said)
    );
    assert_eq!(summary["samples"], 3);
}

#[test]
fn a_contradiction_is_proved_with_its_place() {
    let place = Place::new();
    let record = cart_record(21).replace("1.5,1,3.0", "1.5,1,30.0");
    let (model, record) = (place.file("m.toml", CART), place.file("r.csv", record));
    let ran = place.observe(&model, &record, &[]).ended(1);
    assert!(
        ran.out
            .starts_with("  inconsistent (proved)   15 of 21 samples"),
        "{}",
        ran.out
    );
    for part in [
        "error[E0301]: no parameter in the prior explains the data (proved)",
        "r.csv:17:",
        "1.5,1,30.0",
        "t = 1.5 s: the enclosure of pos is [",
        "the measurement allows [29.899, 30.101] m: gap 2",
        "help: ",
    ] {
        assert!(ran.err.contains(part), "no {part:?} in:\n{}", ran.err);
    }
    let summary = json(&place.read("out/summary.json"));
    assert_eq!(summary["verdict"], "inconsistent");
    assert_eq!(summary["refutation"]["kind"], "output");
    assert_eq!(summary["refutation"]["sample"], 15);
    assert_eq!(summary["refutation"]["line"], 17);
    assert_eq!(summary["refutation"]["output"], "pos");
    assert!(summary["refutation"]["gap"].as_f64().unwrap() > 20.0);
    let k = &summary["parameters"]["k"];
    assert_eq!((&k["empty"], k.get("lo")), (&true.into(), None));
    assert_eq!(bounds(&place.read("out/params.csv"), "k").len(), 15);
}

#[test]
fn what_a_signal_proves_can_refute_too() {
    let place = Place::new();
    let model = std::fs::read_to_string(rig("model.toml")).unwrap();
    let model = place.file(
        "m.toml",
        model.replace(
            "omega = { unit = \"rad/s\", init = 0 }",
            "omega = { unit = \"rad/s\", init = 5 }",
        ),
    );
    let ran = place.observe(&model, &rig("rig.csv"), &[]).ended(1);
    assert!(
        ran.err.contains("what `still` proves to be zero is 5"),
        "{}",
        ran.err
    );
}

#[test]
fn not_being_able_to_prove_is_no_error_and_no_proof() {
    let place = Place::new();
    let model = "format = 1\nstates = [\"x\"]\ninit.x = [1, 2]\nparams.k = [1, 2]\n\
        der.x = \"k * x^2\"\noutputs.y = \"x +- 0.1\"\n";
    // The solution runs to infinity before t = 10.
    let (model, record) = (
        place.file("m.toml", model),
        place.file("r.csv", "t,y\n0,1.5\n10,1.5\n"),
    );
    let ran = place.observe(&model, &record, &[]).ended(3);
    assert!(
        ran.err
            .contains("error[E0302]: nothing could be proved about the step to t = 10 s")
    );
    assert!(ran.err.contains("r.csv:3:"), "{}", ran.err);
    let summary = json(&place.read("out/summary.json"));
    assert_eq!(summary["verdict"], "undecided");
    assert_eq!(summary["samples"], 1);
    let states = bounds(&place.read("out/states.csv"), "x");
    let [(lo, hi)] = states.as_slice() else {
        panic!("{states:?}")
    };
    assert!(
        (1.4 - 1e-9..=1.4).contains(lo) && (1.6..=1.6 + 1e-9).contains(hi),
        "{states:?}"
    );
}

#[test]
fn a_check_says_what_was_understood() {
    let place = Place::new();
    let ran = place.run(&["check", &rig("model.toml")]).ended(0);
    for part in [
        "2 states, 1 input, 3 parameters",
        "stick",
        "prior [-6, -0.05]",
        "(proved)",
        "engine: forms, and where they are not tight and it does not take many times as long comparison of two corners in \
         phi, not in",
    ] {
        assert!(ran.out.contains(part), "no {part:?} in:\n{}", ran.out);
    }
}

/// While the record is checked nothing has been found that is worth to be kept.
#[cfg(unix)]
#[test]
fn a_signal_during_the_check_of_the_record_ends_at_once() {
    use std::process::{Command, Stdio};
    let place = Place::new();
    let (model, record) = place.cart(1_000_000);
    let child = place
        .command(&["observe", &model, &record, "-o", "out"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_millis(100));
    // Not INT: a shell that runs the tests in the background lets its children ignore that one.
    let sent = Command::new("kill")
        .args(["-TERM", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(sent.success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), None, "ended by the signal");
    assert!(!place.path().join("out").exists());
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_complete_files_up_to_the_last_sample() {
    use std::process::{Command, Stdio};
    let place = Place::new();
    let (model, record) = (rig("model.toml"), rig("rig.csv"));
    let slow = ["--boxes", "400", "--bisections", "400", "--every", "1"];
    let mut arguments = vec!["observe", &model, &record, "-o", "out", "--figures", "svg"];
    arguments.extend(slow);
    let child = place
        .command(&arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let begun = || {
        place
            .files("out")
            .iter()
            .any(|name| name.starts_with(".params.csv"))
    };
    while !begun() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    std::thread::sleep(std::time::Duration::from_millis(400));
    assert_eq!(
        place.files("out").len(),
        2,
        "tables have their names only when they are complete"
    );
    let sent = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(sent.success());
    let ran = support::Ran::of(child.wait_with_output().unwrap()).ended(130);
    assert!(ran.err.contains("interrupted"), "{}", ran.err);
    let summary = json(&place.read("out/summary.json"));
    assert_eq!(summary["interrupted"], true);
    assert_eq!(summary["verdict"], "consistent");
    let samples = summary["samples"].as_u64().unwrap();
    assert!(samples > 0 && samples < 8001, "{samples}");
    for (table, name) in [("params.csv", "alpha"), ("states.csv", "omega")] {
        let text = place.read(&format!("out/{table}"));
        assert!(text.ends_with('\n'));
        assert_eq!(bounds(&text, name).len() as u64, samples);
    }
    let left: Vec<String> = place
        .files("out")
        .into_iter()
        .filter(|name| name.contains(".part"))
        .collect();
    assert_eq!(left, [""; 0]);
    // The files can be gone on from.
    let on = [
        "observe",
        &model,
        &record,
        "-o",
        "on",
        "--start-from",
        "out",
        "--to",
        "1",
        "--figures",
        "none",
    ];
    place.run(&on).ended(0);
}

/// The most memory a run had, in KiB.
#[cfg(target_os = "linux")]
fn peak_memory(place: &Place, samples: usize, report: &str) -> u64 {
    let (model, record) = place.cart(samples);
    let flags = [
        "observe",
        &model,
        &record,
        "-o",
        "out",
        "--figures",
        "none",
        "--report",
        report,
        "--boxes",
        "4",
    ];
    let mut child = place
        .command(&flags)
        .stdout(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let mut most = 0;
    let status = format!("/proc/{}/status", child.id());
    while child.try_wait().unwrap().is_none() {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let peak = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let peak = peak.and_then(|rest| rest.trim().trim_end_matches(" kB").parse().ok());
        most = most.max(peak.unwrap_or(0));
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    assert_eq!(child.wait().unwrap().code(), Some(0));
    most
}

#[cfg(target_os = "linux")]
#[test]
fn memory_does_not_grow_with_the_record() {
    let place = Place::new();
    // Figures keep 4000 columns of time, a page 100 000: both lengths fill them.
    for (report, short, long) in [("none", 20_000, 200_000), ("html", 150_000, 300_000)] {
        let short = peak_memory(&place, short, report);
        let long = peak_memory(&place, long, report);
        assert!(
            short > 0 && long < short + short / 4 + 1024,
            "{report}: {short} KiB, then {long} KiB"
        );
    }
}

/// An output with `if` measures, decides its own branch, and contradicts.
#[test]
fn an_output_of_two_branches() {
    let place = Place::new();
    let piecewise = CART.replace(
        "\"x +- 0.1 [m]\"",
        "\"if x > 0.5 then x else 0 +- 0.1 [m]\"",
    );
    assert_ne!(piecewise, CART);
    let model = place.file("m.toml", piecewise);
    let ramp = place.file("r.csv", "t,u,pos\n0,0,0\n1,1,1\n2,1,2\n");
    place.observe(&model, &ramp, &[]).ended(0);
    let (lo, hi) = *bounds(&place.read("out/states.csv"), "x").last().unwrap();
    assert!(lo >= 1.8 && hi <= 2.2, "{lo} {hi}");
    // Between the branches there is nothing away from the border.
    let between = place.file("b.csv", "t,u,pos\n0,0,0\n1,0,1\n");
    place.observe(&model, &between, &[]).ended(0);
    let none = place.file("n.csv", "t,u,pos\n0,0,0.3\n1,0,1\n");
    place.observe(&model, &none, &[]).ended(1);
    let flags = [
        "simulate", &model, "--params", "k=1", "--start", "x=0", "--input", &ramp, "-o", "s.csv",
    ];
    place.run(&flags).ended(0);
}
