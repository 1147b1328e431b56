//! `veribound enclose`: tables, figures, modes, trajectories, and what it says where widths grow.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that fails stops"
)]

mod support;

use serde_json::Value;
use support::{Place, Ran, bounds};

const GROWTH: &str = "format = 1\nstates = [\"x\"]\ninputs = [\"u\"]\n[init]\nx = [0.9, 1.1]\n\
    [params]\nk = [0.5, 0.6]\n[der]\nx = \"k*x + u\"\n[outputs]\ny = \"x^2 + u +- 0.1\"\n";

/// `x' = x^2` from 1: `1 / (1 - t)`.
const POLE: &str = "format = 1\nstates = [\"x\"]\ninit.x = 1\n\n[der]\nx = \"\"\"0.5*x - 0.5*x +\n  x^2\"\"\"\n\
    [outputs]\ny = \"x +- 0.1\"\n";

/// Runs `enclose MODEL -o out` with more words.
fn enclose(place: &Place, model: &str, more: &str) -> Ran {
    let mut words = vec!["enclose", model, "-o", "out"];
    words.extend(more.split_whitespace());
    place.run(&words)
}

fn summary(place: &Place) -> Value {
    serde_json::from_str(&place.read("out/summary.json")).unwrap()
}

/// Row by row, the column of this name as text.
fn column(table: &str, name: &str) -> Vec<String> {
    let mut rows = csv::Reader::from_reader(table.as_bytes());
    let header = rows.headers().unwrap().clone();
    let at = header.iter().position(|known| known == name).unwrap();
    rows.records()
        .map(|row| row.unwrap()[at].to_owned())
        .collect()
}

#[test]
fn a_folder_contains_exact_solutions() {
    let place = Place::new();
    let model = place.file("m.toml", GROWTH);
    place.file("u.csv", "t,u\n0,0\n1,1\n");
    let flags = "--input u.csv --until 2 --every 0.5 --sample 5";
    let said = enclose(&place, &model, flags).ended(0).out;
    assert!(
        said.contains("5 of 5 true trajectories proved inside, none outside"),
        "{said}"
    );
    let files = [
        "fig/outputs.png",
        "fig/outputs.svg",
        "fig/states.png",
        "fig/states.svg",
        "parts.csv",
        "report.html",
        "run.toml",
        "summary.json",
        "tube.csv",
    ];
    assert_eq!(place.files("out"), files);
    let table = place.read("out/tube.csv");
    let times: Vec<f64> = column(&table, "t")
        .iter()
        .map(|t| t.parse().unwrap())
        .collect();
    assert_eq!(times, [0.0, 0.5, 1.0, 1.5, 2.0]);
    let solution = |x0: f64, k: f64, t: f64| {
        let (first, rest) = (t.min(1.0), (t - 1.0).max(0.0));
        let x = x0 * (k * first).exp();
        x * (k * rest).exp() + (k * rest).exp_m1() / k
    };
    let inside = |name: &str, row: usize, value: f64| {
        let (lo, hi) = bounds(&table, name)[row];
        assert!(
            lo <= value + 1e-9 && value <= hi + 1e-9,
            "{name}: {value} not in {lo}..{hi}"
        );
    };
    for (x0, k) in [(0.9, 0.5), (1.1, 0.6), (1.0, 0.55), (0.9, 0.6), (1.1, 0.5)] {
        for (row, t) in times.iter().enumerate() {
            let x = solution(x0, k, *t);
            let u = if *t < 1.0 { 0.0 } else { 1.0 };
            inside("x", row, x);
            inside("x.since", row, x);
            inside("y", row, x * x + u);
            inside("y.since", row, x * x + u);
            if row > 0 {
                let x = solution(x0, k, t - 0.2);
                inside("x.since", row, x);
                inside(
                    "y.since",
                    row,
                    x * x + if t - 0.2 < 1.0 { 0.0 } else { 1.0 },
                );
            }
        }
    }
    let largest = 1.1 * 1.2_f64.exp() + 0.6_f64.exp_m1() / 0.6;
    assert!((bounds(&table, "x")[4].1 - largest).abs() < 1e-3);
    // Where the input jumps, the output has been both.
    let (lo, hi) = bounds(&table, "y.since")[2];
    assert!(
        lo < 2.0 && hi > 1.0 + (1.1 * 0.6_f64.exp()).powi(2) - 1e-6,
        "{lo} {hi}"
    );
    let told = summary(&place);
    assert_eq!(told["verdict"], "proved");
    assert_eq!((&told["times"], &told["parts"]), (&5.into(), &1.into()));
    assert_eq!(told["trajectories"]["inside"], 5);
    assert_eq!(
        told["states"]["x"]["hi"].as_f64().unwrap(),
        bounds(&table, "x")[4].1
    );
    let always = &told["states"]["x"]["always"];
    assert!(always["lo"].as_f64().unwrap() <= 0.9 && always["hi"].as_f64().unwrap() >= largest);
    let info: toml::Table = place.read("out/run.toml").parse().unwrap();
    assert_eq!(info["profile"]["samples"].as_integer(), Some(2));
    assert_eq!(info["options"]["sample"].as_integer(), Some(5));
}

/// `--json` prints the summary; `--figures none` draws nothing; results are replaced together.
#[test]
fn the_flags_of_observe_mean_the_same() {
    let place = Place::new();
    let model = place.file(
        "m.toml",
        GROWTH.replace("inputs = [\"u\"]\n", "").replace(" + u", ""),
    );
    enclose(&place, &model, "--until 1 --every 0.1").ended(0);
    assert!(place.files("out").contains(&"fig/states.svg".to_owned()));
    let ran = enclose(
        &place,
        &model,
        "--until 1 --every 0.5 --figures none --report none --json",
    )
    .ended(0);
    assert_eq!(ran.out, place.read("out/summary.json"));
    assert_eq!(
        place.files("out"),
        ["parts.csv", "run.toml", "summary.json", "tube.csv"]
    );
    let ran = enclose(&place, &model, "--until 1 --every 0.5 --quiet").ended(0);
    assert_eq!((ran.out.as_str(), ran.err.as_str()), ("", ""));
    enclose(&place, &model, "--until 1 --every 0.5 --figures none,svg").ended(2);
    let said = enclose(&place, &model, "--until 1 --every 1 --plane x,z")
        .ended(2)
        .err;
    assert!(
        said.contains("error[E0601]: the model has no state `z`") && said.contains("it has `x`"),
        "{said}"
    );
    let ran = place.run(&["enclose", &model, "--until", "1", "--every", "1", "-o", "."]);
    ran.ended(0);
    assert!(place.path().join("tube.csv").exists() && place.path().join("m.toml").exists());
}

#[test]
fn the_start_is_told_where_nothing_is_proved() {
    let place = Place::new();
    let model = place.file("m.toml", POLE);
    let said = enclose(&place, &model, "--until 2 --every 2").ended(3).err;
    assert!(
        said.contains("Nothing is proved beyond the start."),
        "{said}"
    );
    let table = place.read("out/tube.csv");
    assert_eq!(column(&table, "t"), ["0"]);
    assert_eq!(summary(&place)["verdict"], "undecided");
}

/// What was proved before the pole of `1 / (1 - t)` stays, and the term that makes it is named with its line.
#[test]
fn what_is_proved_stays() {
    let place = Place::new();
    let model = place.file("m.toml", POLE);
    let said = enclose(&place, &model, "--until 2 --every 0.25 --sample 3")
        .ended(3)
        .err;
    assert!(said.contains("The results end at t = 0.75 s."), "{said}");
    assert!(
        said.contains("the width of `x` grew most, by the term `x^2` (m.toml:7)"),
        "{said}"
    );
    assert!(said.contains("Try an earlier end: `--until`."), "{said}");
    let table = place.read("out/tube.csv");
    let (lo, hi) = bounds(&table, "x")[3];
    assert!(lo <= 4.0 && 4.0 <= hi && hi - lo < 1e-9, "{lo} {hi}");
    let told = summary(&place);
    assert_eq!(
        (&told["verdict"], &told["until"]),
        (&"undecided".into(), &0.75.into())
    );
    assert_eq!(told["trajectories"]["drawn"], 3);
}

/// A saddle: the width outgrows everything, and says since when, by what, and what to try.
#[test]
fn a_width_past_use_is_diagnosed() {
    let place = Place::new();
    let text = "format = 1\nstates = [\"x\", \"y\"]\n[init]\nx = [-0.01, 0.01]\ny = 0\n[params]\nk = [0.9, 1.1]\n\n[der]\n\
        x = \"y\"\ny = \"k*x - 0.1*y\"\n[outputs]\nm = \"x +- 0.1\"\n";
    let model = place.file("m.toml", text);
    let said = enclose(&place, &model, "--until 12 --every 0.1")
        .ended(0)
        .err;
    assert!(
        said.contains("warning: the width of `y` grew past use from t = "),
        "{said}"
    );
    assert!(
        said.contains(
            "by the term `k*x` (m.toml:11); then those of `x`. Try a narrower start of `x`."
        ),
        "{said}"
    );
    let told = summary(&place);
    assert_eq!(told["past_use"][0]["state"], "x");
    assert_eq!(
        (&told["past_use"][1]["term"], &told["past_use"][1]["line"]),
        (&"k*x".into(), &11.into())
    );
    let since = told["past_use"][0]["since"].as_f64().unwrap();
    assert!((2.0..5.0).contains(&since), "{since}");
    // A stable one, driven by an unknown force from rest, is as wide as it has to be.
    let text = "format = 1\nstates = [\"v\"]\ninit.v = 0\nder.v = \"f - v\"\noutputs.m = \"v +- 0.1\"\n\
        [disturbances]\nf = [-1, 1]\n";
    let model = place.file("n.toml", text);
    let ran = enclose(&place, &model, "--until 10 --every 0.1 --sample 3").ended(0);
    assert!(!ran.err.contains("warning"), "{}", ran.err);
    let told = summary(&place);
    assert!(told["past_use"].as_array().unwrap().is_empty());
    assert_eq!(told["trajectories"]["inside"], 3);
}

/// Three more that grow past use, each for another reason: chaos, a force on what is unstable, a parameter. State, term, time and remedy are those
/// that the equations have; CORA#73, CORA#51 and TaylorModels.jl#111 ended in explosions or steps of 1e-17 without any of these.
#[test]
fn a_diagnosis_is_right() {
    let place = Place::new();
    // Widths double every 0.77 s at first, and lose two orders of magnitude where x*y is large.
    let lorenz = place.file(
        "lorenz.toml",
        "format = 1\nstates = [\"x\", \"y\", \"z\"]\ninit = { x = [14.99, 15.01], y = [14.99, 15.01], z = 36 }\n[der]\n\
         x = \"10*(y - x)\"\ny = \"x*(28 - z) - y\"\nz = \"x*y - 8*z/3\"\n[outputs]\nm = \"x +- 1\"\n",
    );
    let said = enclose(&place, &lorenz, "--until 6 --every 0.1 --parts 1").err;
    let told = summary(&place);
    let past = &told["past_use"].as_array().unwrap()[0];
    let since = past["since"].as_f64().unwrap();
    assert!((4.5..=6.0).contains(&since), "{since}");
    let (state, line) = (
        past["state"].as_str().unwrap(),
        past["line"].as_u64().unwrap(),
    );
    let terms: &[&str] = match state {
        "y" => &["x*(28 - z)"],
        "z" => &["x*y"],
        _ => panic!("{said}"),
    };
    assert!(terms.contains(&past["term"].as_str().unwrap()), "{said}");
    assert_eq!(line, if state == "y" { 6 } else { 7 });
    assert!(said.contains("Try more parts: `--parts 8`."), "{said}");
    // What was proved until then stays.
    let rows = bounds(&place.read("out/tube.csv"), "x");
    assert!(rows.len() as f64 > 10.0 * since && rows[10].1 - rows[10].0 < 1.0);
    // A pendulum upside down, pushed by a wind: 2*x takes over from the wind.
    let driven = place.file(
        "driven.toml",
        "format = 1\nstates = [\"x\", \"v\"]\ninit = { x = 0, v = 0 }\ndisturbances.wind = [-1, 1]\n\n[der]\nx = \"v\"\n\
         v = \"wind + 2*x\"\n[outputs]\nm = \"x +- 1\"\n",
    );
    let said = enclose(&place, &driven, "--until 20 --every 0.1")
        .ended(0)
        .err;
    assert!(
        said.contains("the width of `v` grew past use from t = 6.8 s on, by the term `2*x` (driven.toml:8); then those of `x`."),
        "{said}"
    );
    assert!(
        said.contains("Try narrower bounds of the disturbance `wind`."),
        "{said}"
    );
    // Only the rate of growth is uncertain.
    let growing = place.file(
        "growing.toml",
        "format = 1\nstates = [\"x\", \"y\"]\ninit = { x = 1, y = 3 }\nparams.rate = [0.5, 1.5]\n[der]\n\
         x = \"1 - x + 0.1*y\"\ny = \"rate*y - 0.5*y\"\n[outputs]\nm = \"x +- 1\"\n",
    );
    let said = enclose(&place, &growing, "--until 20 --every 0.1")
        .ended(0)
        .err;
    assert!(
        said.contains("the width of `y` grew past use from t = "),
        "{said}"
    );
    assert!(
        said.contains("by the term `rate*y` (growing.toml:7)"),
        "{said}"
    );
    assert!(said.contains("Try narrower bounds of `rate`."), "{said}");
    let past = &summary(&place)["past_use"];
    assert_eq!(
        (&past[0]["state"], &past[1]["state"]),
        (&"x".into(), &"y".into())
    );
}

/// Every engine can be asked, all prove the same, and the result names the one that did.
#[test]
fn engines_are_chosen_and_told() {
    let place = Place::new();
    let text = "format = 1\nstates = [\"x\"]\ninit.x = [0.8, 0.9]\nder.x = \"-friction(x, 0, 1)\"\noutputs.y = \"x +- 0.1\"\n";
    let model = place.file("m.toml", text);
    for (engine, told) in [
        ("auto", "comparison (corners in x)"),
        ("comparison", "comparison (corners in x)"),
        ("forms", "forms"),
        ("boxes", "boxes"),
        ("closed", "closed"),
    ] {
        let flags = format!("--until 0.5 --every 0.5 --engine {engine}");
        let said = enclose(&place, &model, &flags).ended(0).out;
        assert!(said.contains(&format!("engine: {told}\n")), "{said}");
        assert_eq!(summary(&place)["engine"], told);
        let (lo, hi) = bounds(&place.read("out/tube.csv"), "x")[1];
        assert!(
            (lo - 0.3).abs() < 1e-9 && (hi - 0.4).abs() < 1e-9,
            "{lo} {hi}"
        );
    }
}

/// A stiff model with affine modes is held for long: one step in closed form, which `check` announces; a model that has
/// none is told which state is in the way.
#[test]
fn closed_forms_are_chosen_and_refused() {
    let place = Place::new();
    let text = "format = 1\nstates = [\"x\", \"v\"]\ninit = { x = [0.9, 1.1], v = 0 }\nder.x = \"v\"\n\
                der.v = \"-1000*x - 1000*v\"\noutputs.y = \"x +- 0.1\"\n";
    let model = place.file("m.toml", text);
    let told = place.run(&["check", &model]).ended(0).out;
    assert!(
        told.contains(
            "in closed form, since modes are affine, where inputs are held for 0.0030 s or longer"
        ),
        "{told}"
    );
    let said = enclose(&place, &model, "--until 3 --every 1").ended(0).out;
    assert!(said.contains("engine: closed"), "{said}");
    let (lo, hi) = bounds(&place.read("out/tube.csv"), "x")[1];
    // The slow root of s^2 + 1000 s + 1000 is -1.001002, the fast one takes its share at once.
    assert!(lo > 0.331 && hi < 0.406, "{lo} {hi}");
    let bent = text.replace("1000*v\"", "1000*v*v\"");
    let model = place.file("bent.toml", &bent);
    let said = enclose(&place, &model, "--until 1 --every 1 --engine closed")
        .ended(3)
        .err;
    let wanted = "there is no closed form, since the rate of `v` is not affine in the states. Nothing is proved beyond \
                  the start. Try `--engine auto`.";
    assert!(said.contains(wanted), "{said}");
}

/// An engine that can prove nothing says so, with what is known at the start.
#[test]
fn an_engine_that_proves_nothing_is_no_error() {
    let place = Place::new();
    for (name, times) in [("quarter-car", "0.02"), ("belt", "0.02"), ("valve", "0.02")] {
        let folder = support::example(name);
        let model = folder.join("model.toml").display().to_string();
        let mut flags = format!("--until {times} --every {times} --engine comparison --sample 2");
        let profile = folder.join("profile.csv");
        if profile.exists() {
            flags = format!("{flags} --input {}", profile.display());
        }
        let said = enclose(&place, &model, &flags).ended(3).err;
        assert!(
            said.contains("the right-hand side is not proved to be monotone")
                && said.contains("Nothing is proved beyond the start."),
            "{said}"
        );
        let (table, told) = (place.read("out/tube.csv"), summary(&place));
        assert_eq!(column(&table, "t"), ["0"]);
        assert!(column(&table, "modes").iter().all(String::is_empty));
        assert_eq!(
            (&told["verdict"], &told["parts"]),
            (&"undecided".into(), &1.into())
        );
        for (state, always) in told["states"].as_object().unwrap() {
            let (lo, hi) = bounds(&table, state)[0];
            assert!(lo <= hi && always["lo"].as_f64() == Some(lo), "{state}");
        }
    }
}

/// `x' = -friction(x, 0, 1)` comes to zero and stays there; the table and the strip say which mode acts.
#[test]
fn modes_are_told() {
    let place = Place::new();
    let text = "format = 1\nstates = [\"x\"]\ninit.x = [0.8, 0.9]\nder.x = \"-friction(x, 0, 1)\"\noutputs.y = \"x +- 0.1\"\n";
    let model = place.file("m.toml", text);
    let said = enclose(
        &place,
        &model,
        "--until 2 --every 0.5 --sample 4 --engine forms",
    )
    .ended(0)
    .out;
    assert!(said.contains("modes possible at the end: stick"), "{said}");
    let table = place.read("out/tube.csv");
    let modes = column(&table, "modes");
    assert_eq!(modes, ["", "forward", "forward|stick", "stick", "stick"]);
    assert_eq!(bounds(&table, "x")[4], (0.0, 0.0));
    let (lo, hi) = bounds(&table, "x")[1];
    assert!((lo - 0.3).abs() < 1e-9 && (hi - 0.4).abs() < 1e-9);
    assert!(place.files("out").contains(&"fig/modes.svg".to_owned()));
    assert_eq!(summary(&place)["modes"], serde_json::json!(["stick"]));
}

/// A ball with impacts it may or may not have had is divided: the parts cover the start, and their ends the end.
#[test]
fn parts_are_told() {
    let place = Place::new();
    let model = support::example("bouncing-ball")
        .join("model.toml")
        .display()
        .to_string();
    let flags = "--until 1.2 --every 0.05 --parts";
    enclose(&place, &model, &format!("{flags} 4 --sample 5")).ended(0);
    let (parts, table) = (place.read("out/parts.csv"), place.read("out/tube.csv"));
    let told = summary(&place);
    let count = bounds(&parts, "h").len();
    assert_eq!(told["parts"], count);
    assert!((2..=4).contains(&count), "{count}");
    let hull = |list: &[(f64, f64)]| {
        let lo = list.iter().map(|x| x.0).fold(f64::INFINITY, f64::min);
        (
            lo,
            list.iter().map(|x| x.1).fold(f64::NEG_INFINITY, f64::max),
        )
    };
    assert_eq!(hull(&bounds(&parts, "h.start")), (0.95, 1.05));
    assert_eq!(hull(&bounds(&parts, "v.start")), (-0.05, 0.05));
    assert_eq!(
        hull(&bounds(&parts, "h")),
        *bounds(&table, "h").last().unwrap()
    );
    assert!(place.files("out").contains(&"fig/plane.svg".to_owned()));
    // Fewer parts never give narrower bounds.
    enclose(&place, &model, &format!("{flags} 1 --figures none")).ended(0);
    let whole = place.read("out/tube.csv");
    for name in ["h", "v", "h.since", "v.since", "height", "height.since"] {
        for (part, whole) in bounds(&table, name).iter().zip(bounds(&whole, name)) {
            assert!(
                whole.0 <= part.0 && part.1 <= whole.1,
                "{name}: {part:?} {whole:?}"
            );
        }
    }
}

/// Every example is enclosed for a moment, and true trajectories lie inside.
#[test]
fn all_examples_are_enclosed() {
    let place = Place::new();
    place.file("force.csv", "t,force_N\n0,1\n");
    let folder = support::example("");
    let mut models = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let folder = entry.unwrap().path();
        let name = folder.file_name().unwrap().to_string_lossy().into_owned();
        let profile = match folder.join("profile.csv") {
            path if path.exists() => format!("--input {}", path.display()),
            _ if name == "emps" => "--input force.csv".to_owned(),
            _ => String::new(),
        };
        // Six states with eleven unknowns take long.
        let times = match name.as_str() {
            "anaerobic-digestion" => "--until 0.0001 --every 0.0001",
            "chain" => "--until 0.001 --every 0.001",
            _ => "--until 0.02 --every 0.01",
        };
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_none_or(|ending| ending != "toml") {
                continue;
            }
            let model = path.display().to_string();
            let flags = format!("{times} {profile} --parts 1 --figures none --sample 2");
            let said = enclose(&place, &model, &flags).ended(0).out;
            assert!(
                said.contains("2 of 2 true trajectories proved inside"),
                "{model}: {said}"
            );
            models += 1;
        }
    }
    assert!(models >= 19, "{models}");
}
