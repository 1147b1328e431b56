//! `veribound identify` on records with known answers: bounds from both sides, contradictions, pavings, several
//! records, and what does not depend on threads.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that fails stops"
)]

mod support;

use serde_json::Value;
use std::fs;
use std::time::Instant;
use support::{CART, Place, Ran, bounds, cart_record, rig};

/// Two ranges.
type Tile = ((f64, f64), (f64, f64));

/// Runs `identify m.toml r.csv -o out --figures none` with more words.
fn identify(place: &Place, more: &str) -> Ran {
    let mut words = vec!["identify", "m.toml", "r.csv", "-o", "out"];
    words.extend(["--figures", "none", "--report", "none"]);
    words.extend(more.split_whitespace());
    place.run(&words)
}

fn summary(place: &Place) -> Value {
    serde_json::from_str(&place.read("out/summary.json")).unwrap()
}

/// Outer and inner bounds of an entry; the inner ones lie inside.
fn sides(entry: &Value) -> [(f64, f64); 2] {
    let ends = |at: &Value| (at["lo"].as_f64().unwrap(), at["hi"].as_f64().unwrap());
    let (outer, inner) = (ends(entry), ends(&entry["inner"]));
    assert!(outer.0 <= inner.0 && inner.0 <= inner.1 && inner.1 <= outer.1);
    [outer, inner]
}

/// The exact hull lies between both sides, and these are as near to each other as is said.
fn between(entry: &Value, (lo, hi): (f64, f64), tightness: f64) {
    let [outer, inner] = sides(entry);
    let slack = 1e-9 * (hi - lo);
    assert!(outer.0 <= lo + slack && hi - slack <= outer.1, "{entry}");
    assert!(lo - slack <= inner.0 && inner.1 <= hi + slack, "{entry}");
    let told = entry["tightness"].as_f64().unwrap();
    let ratio = (outer.1 - outer.0) / (inner.1 - inner.0);
    assert!(ratio <= told * (1.0 + 1e-9) && told <= tightness, "{entry}");
}

/// The cart, `x' = k u`, at 0.2 m every 0.1 s within 0.1 m: `|x0 + (k - 2) t| <= 0.1`.
#[test]
fn the_cart_has_the_hull_that_can_be_computed_by_hand() {
    let place = Place::new();
    place.cart(5);
    let ran = identify(&place, "").ended(0);
    assert!(
        ran.out.starts_with("  consistent   5 samples in "),
        "{}",
        ran.out
    );
    assert!(ran.out.contains("   the record\n"), "{}", ran.out);
    let told = summary(&place);
    assert_eq!(told["verdict"], "consistent");
    between(&told["parameters"]["k"], (1.5, 2.5), 1.05);
    between(
        &told["starts"][0]["states"]["x"],
        (-0.1, 0.1),
        f64::INFINITY,
    );
    // The points are those that reach the inner bounds.
    let points = place.read("out/points.csv");
    let [_, inner] = sides(&told["parameters"]["k"]);
    let found = bounds(&points, "k");
    let lo = found.iter().map(|k| k.0).fold(f64::INFINITY, f64::min);
    let hi = found.iter().map(|k| k.1).fold(f64::NEG_INFINITY, f64::max);
    assert!(lo <= inner.0 + 1e-9 && inner.1 - 1e-9 <= hi, "{points}");
    for (lo, hi) in found {
        assert!(
            (1.5..=2.5).contains(&lo) && (1.5..=2.5).contains(&hi),
            "{lo} {hi}"
        );
    }
}

/// A second record of the same cart tells more of `k`, and has a start of its own.
#[test]
fn records_share_parameters_and_not_starts() {
    let place = Place::new();
    place.cart(5);
    // From 0.05 m on, and longer: |k - 2| <= 0.2 / 0.8.
    let mut text = String::from("t,u,pos\n");
    for k in 0..9 {
        let t = f64::from(k) / 10.0;
        text += &format!("{t:.1},1,{:.2}\n", 0.05 + 2.0 * t);
    }
    place.file("s.csv", text);
    identify(&place, "s.csv").ended(0);
    let told = summary(&place);
    assert_eq!(told["samples"], 14);
    between(&told["parameters"]["k"], (1.75, 2.25), 1.05);
    let starts = told["starts"].as_array().unwrap();
    assert_eq!(starts[1]["record"], "s.csv");
    // k = 2 - d leaves [-0.1 + 0.4 d, 0.1] of the first and 0.05 more than [-0.1 + 0.8 d, 0.1] of the second.
    // How tight they are was asked of parameters only.
    between(&starts[0]["states"]["x"], (-0.1, 0.1), f64::INFINITY);
    between(&starts[1]["states"]["x"], (-0.05, 0.15), f64::INFINITY);
}

#[test]
fn a_contradiction_is_proved_with_the_samples_that_make_it() {
    let place = Place::new();
    place.cart(5);
    // With |u| = 1 and k <= 4 it moves 0.4 m in 0.1 s at most, 0.8 m in 0.2 s.
    let record = "t,u,pos\n0,1,0\n0.1,1,0.2\n0.2,1,1.3\n0.3,1,1.5\n";
    place.file("r.csv", record);
    let ran = identify(&place, "").ended(1);
    assert!(
        ran.out.starts_with("  inconsistent (proved)"),
        "{}",
        ran.out
    );
    assert!(
        ran.out
            .contains("nothing agrees with r.csv up to t = 0.2 s (line 4)")
    );
    assert!(ran.err.starts_with("error[E0301]: "), "{}", ran.err);
    assert!(ran.err.contains("--> r.csv:4:1"), "{}", ran.err);
    let told = summary(&place);
    assert_eq!(told["verdict"], "inconsistent");
    let refutation = &told["refutation"];
    assert_eq!(refutation["record"], "r.csv");
    assert_eq!(refutation["time"], 0.2);
    assert_eq!(refutation["line"], 4);
    // The last one, with any of those before.
    let samples = refutation["samples"].as_array().unwrap();
    assert!(samples.len() == 2 && samples[1] == 2, "{refutation}");
    assert_eq!(told["parameters"]["k"]["empty"], true);
    // 1.3 - 0.2 - 0.4 = 0.7 <= 2 * 0.35, and 0.1 was declared.
    let least = &told["least_error"];
    let ends = ["at_least", "enough"].map(|end| least[end].as_f64().unwrap());
    assert!(
        3.499 < ends[0] && ends[0] <= 3.5 && 3.5 <= ends[1] && ends[1] < 3.501,
        "{least}"
    );
    assert!(
        ran.out
            .contains("  measurement errors must be at least 3.4"),
        "{}",
        ran.out
    );
    // A sensor that is worse explains it.
    identify(&place, "--output-error pos=0.36").ended(0);
    identify(&place, "--output-error pos=0.3").ended(1);
    // So does the part of the record before.
    identify(&place, "--until 0.1").ended(0);
}

/// Two exponentials that are not told apart easily, so that a paving takes a while.
const DECAYS: &str = "format = 1\nstates = [\"a\", \"b\"]\ninit = { a = 20, b = -8 }\nparams.p = [0, 1]\nparams.q = [0, 1]\n\
    der.a = \"-p*a\"\nder.b = \"-q*b\"\noutputs.y = \"a + b +- 0.5\"\n";

/// A run that is killed again and again, at moments that nobody chose, comes to the same results to the byte.
#[test]
fn a_killed_run_goes_on_to_the_same_result() {
    let place = Place::new();
    place.file("m.toml", DECAYS);
    let mut text = String::from("t,y\n");
    for k in 0..=10 {
        let t = f64::from(k);
        text += &format!(
            "{k},{:.1}\n",
            20.0 * (-0.6 * t).exp() - 8.0 * (-0.2 * t).exp()
        );
    }
    place.file("r.csv", text);
    let asked = "--paving 0.3% --sets 300 --tightness 1.0001";
    let begin = Instant::now();
    identify(&place, asked).ended(0);
    let whole = begin.elapsed();
    let files = ["points.csv", "paving.csv"];
    let wanted = files.map(|file| place.read(&format!("out/{file}")));
    let work = |place: &Place| {
        let told = summary(place);
        (
            told["work"]["sets"].clone(),
            told["work"]["passes"].clone(),
            told["parameters"].clone(),
        )
    };
    let wanted_work = work(&place);
    fs::remove_dir_all(place.path().join("out")).unwrap();
    let (mut killed, mut share) = (0, 0.15);
    loop {
        let words = format!(
            "identify m.toml r.csv -o out --figures none --report none --quiet --resume {asked}"
        );
        let words: Vec<&str> = words.split_whitespace().collect();
        let mut child = place.command(&words).spawn().unwrap();
        std::thread::sleep(whole.mul_f64(share));
        share *= 1.2;
        match child.try_wait().unwrap() {
            Some(status) => {
                assert_eq!(status.code(), Some(0));
                break;
            }
            None => {
                child.kill().unwrap();
                child.wait().unwrap();
                killed += 1;
            }
        }
    }
    assert!(killed > 0);
    assert_eq!(files.map(|file| place.read(&format!("out/{file}"))), wanted);
    assert_eq!(work(&place), wanted_work);
    assert!(!place.path().join("out/checkpoint.bin").exists());
    // What is kept of another run, or is damaged, is refused.
    place.file("out/checkpoint.bin", "nonsense");
    let ran = identify(&place, &format!("{asked} --resume")).ended(2);
    assert!(ran.err.contains("error[E0505]: "), "{}", ran.err);
}

/// Tiles cover the prior without overlapping, and their statuses are true.
#[test]
fn a_paving_covers_the_prior() {
    let place = Place::new();
    place.cart(5);
    let model = CART.replace(
        "params.k = ",
        "params.c = { unit = \"m\", bounds = [-0.5, 0.5] }\nparams.k = ",
    );
    // A sensor with an offset, and a start that is known: |c + (k - 2) t| <= 0.1.
    let model = model.replace("[-1, 1]", "0").replace("x +-", "x + c +-");
    place.file("m.toml", model);
    let ran = identify(&place, "--paving 5% --sets 20000").ended(0);
    assert!(ran.out.contains("  paving: "), "{}", ran.out);
    let told = summary(&place);
    assert!(
        told["paving"]["undecided"].as_f64().unwrap() <= 0.05,
        "{told}"
    );
    let text = place.read("out/paving.csv");
    let (c, k) = (bounds(&text, "c"), bounds(&text, "k"));
    let statuses: Vec<String> = text
        .lines()
        .skip(1)
        .map(|line| line.split(',').nth(4).unwrap().to_owned())
        .collect();
    let tiles: Vec<_> = c.into_iter().zip(k).zip(statuses).collect();
    let area = |((c, k), _): &(Tile, String)| (c.1 - c.0) * (k.1 - k.0);
    let whole: f64 = tiles.iter().map(area).sum();
    assert!((whole - 4.0).abs() < 1e-9, "{whole}");
    let agrees = |c: f64, k: f64| [0.0, 0.4].map(|t: f64| (c + (k - 2.0) * t).abs() <= 0.1);
    for i in 0..60 {
        for j in 0..60 {
            let (at_c, at_k) = (-0.497 + f64::from(i) / 61.0, 0.011 + f64::from(j) / 15.3);
            let holds = |((c, k), _): &&(Tile, String)| {
                c.0 <= at_c && at_c <= c.1 && k.0 <= at_k && at_k <= k.1
            };
            let mut found = tiles.iter().filter(holds).peekable();
            assert!(found.peek().is_some(), "nothing covers {at_c} {at_k}");
            for (_, status) in found {
                let wrong = if agrees(at_c, at_k) == [true; 2] {
                    "outside"
                } else {
                    "inside"
                };
                assert_ne!(status, wrong, "{at_c} {at_k}");
            }
        }
    }
}

#[test]
fn results_do_not_depend_on_threads() {
    let place = Place::new();
    place.cart(9);
    let run = |threads: &str| {
        identify(&place, &format!("--paving 10% --sets 300 -j {threads}")).ended(0);
        let told = place.read("out/summary.json");
        let without_time: Vec<String> = told
            .lines()
            .filter(|line| !line.contains("\"wall_s\""))
            .map(str::to_owned)
            .collect();
        let tables = ["out/points.csv", "out/paving.csv"].map(|name| place.read(name));
        (without_time, tables)
    };
    assert_eq!(run("1"), run("2"));
}

/// With few sets the bounds are wide, and hold all the same.
#[test]
fn few_sets_lose_nothing() {
    let place = Place::new();
    place.cart(9);
    for sets in 1..6 {
        let ran = identify(&place, &format!("--sets {sets} --tightness 1.000001"));
        assert!(matches!(ran.code, Some(0 | 3)), "{}", ran.err);
        let k = &summary(&place)["parameters"]["k"];
        let ends = (k["lo"].as_f64().unwrap(), k["hi"].as_f64().unwrap());
        assert!(ends.0 <= 1.75 && 2.25 <= ends.1, "{k}");
    }
}

/// An observation goes on from what an identification left.
#[test]
fn an_observation_starts_from_the_bounds() {
    let place = Place::new();
    place.cart(5);
    identify(&place, "").ended(0);
    fs::rename(place.path().join("out"), place.path().join("id")).unwrap();
    let ran = place.observe("m.toml", "r.csv", &["--start-from", "id"]);
    let ran = ran.ended(0);
    assert!(
        ran.err.contains("the run in id left (--start-from)"),
        "{}",
        ran.err
    );
    let k = bounds(&place.read("out/params.csv"), "k")[0];
    assert!(1.4 < k.0 && k.1 < 2.6, "{k:?}");
}

/// A record with noise up to the bound: a hundred times narrower than the observer, and reached from inside.
#[test]
fn the_rig_is_told_from_both_sides() {
    let place = Place::new();
    let (model, record) = (rig("model.toml"), rig("rig.csv"));
    let ran = place.run(&["identify", &model, &record, "-o", "out", "--sets", "12"]);
    ran.ended(0);
    let told = summary(&place);
    for (name, truth, width) in [
        ("alpha", -2.0, 6e-4),
        ("beta", 200.0, 0.06),
        ("T_Fs", 0.15, 2e-5),
    ] {
        let entry = &told["parameters"][name];
        let [outer, inner] = sides(entry);
        assert!(outer.0 < truth && truth < outer.1, "{name}: {entry}");
        assert!(outer.1 - outer.0 < width, "{name}: {entry}");
        assert!(outer.0 <= inner.0 && inner.1 <= outer.1, "{name}: {entry}");
        assert!(inner.0 < inner.1, "{name}: {entry}");
    }
    assert!(place.files("out").contains(&"fig/bounds.png".to_owned()));
}

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_what_is_proved() {
    use std::process::{Command, Stdio};
    let place = Place::new();
    let (model, record) = (rig("model.toml"), rig("rig.csv"));
    let endless = [
        "--tightness",
        "1.0000001",
        "--sets",
        "1000000",
        "--figures",
        "none",
        "--report",
        "none",
    ];
    let mut arguments = vec!["identify", &model, &record, "-o", "out"];
    arguments.extend(endless);
    let child = place
        .command(&arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // The folder is made when the record is read.
    while !place.path().join("out").exists() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    std::thread::sleep(std::time::Duration::from_millis(700));
    // Not INT: a shell that runs the tests in the background lets its children ignore that one.
    let sent = Command::new("kill")
        .args(["-TERM", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(sent.success());
    let ran = Ran::of(child.wait_with_output().unwrap()).ended(130);
    assert!(
        ran.err
            .contains("interrupted: the files tell what was proved"),
        "{}",
        ran.err
    );
    let told = summary(&place);
    assert_eq!(told["interrupted"], true);
    for (name, truth) in [("alpha", -2.0), ("beta", 200.0), ("T_Fs", 0.15)] {
        let entry = &told["parameters"][name];
        let ends = (entry["lo"].as_f64().unwrap(), entry["hi"].as_f64().unwrap());
        assert!(ends.0 <= truth && truth <= ends.1, "{name}: {entry}");
    }
    let files = ["points.csv", "run.toml", "summary.json"];
    assert_eq!(place.files("out"), files);
}

/// A record that is read from later on has the start intervals of the model there.
#[test]
fn a_window_has_the_start_of_the_model() {
    let place = Place::new();
    place.file("m.toml", CART.replace("[-1, 1]", "[0, 1]"));
    place.file("r.csv", cart_record(9));
    let ran = identify(&place, "--from 0.2").ended(0);
    let note = "the start intervals of the model file hold at t = 0.2 s";
    assert!(ran.err.contains(note), "{}", ran.err);
    let told = summary(&place);
    assert_eq!(told["samples"], 7);
    // |x - 0.4 + (k - 2) t| <= 0.1 for t from 0 to 0.6.
    between(
        &told["parameters"]["k"],
        (2.0 - 1.0 / 3.0, 2.0 + 1.0 / 3.0),
        1.05,
    );
    between(&told["starts"][0]["states"]["x"], (0.3, 0.5), f64::INFINITY);
}
