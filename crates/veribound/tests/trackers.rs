//! Reports about other programs, asked of this one: nothing is lost, nothing is found where nothing is, and no option changes a verdict.
//! Docstrings name the reports; `docs/known-bugs-of-others.md` lists all of them, and is held against the tests here.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that fails stops"
)]

mod support;

use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use support::{Place, bounds};

/// ibex-lib#470, #529: solving `x1*x2 = 0` lost the box {0} x [-1, 1]; an optimum of -1066942004 was found for x in [-1, 1].
/// What is left of both parameters is all of them; tiles that are excluded hold no solution; all stay inside the prior.
#[test]
fn a_product_that_is_zero_keeps_both_axes() {
    let place = Place::new();
    place.file(
        "m.toml",
        "format = 1\nstates = [\"s\"]\ninit.s = 0\nparams = { a = [-1, 1], b = [-1, 1] }\nder.s = \"a*b\"\noutputs.y = \"s +- 0.001\"\n",
    );
    place.file("r.csv", "t_s,y\n0,0\n1,0\n");
    let flags = "identify m.toml r.csv -o out --figures none --report none --paving 30% --sets 200";
    place.typed(flags).ended(0);
    let told: Value = serde_json::from_str(&place.read("out/summary.json")).unwrap();
    for name in ["a", "b"] {
        let param = &told["parameters"][name];
        let [lo, hi] = ["lo", "hi"].map(|end| param[end].as_f64().unwrap());
        assert_eq!((lo, hi), (-1.0, 1.0), "{param}");
    }
    let paving = place.read("out/paving.csv");
    let (a, b) = (bounds(&paving, "a"), bounds(&paving, "b"));
    let rows: Vec<&str> = paving.lines().skip(1).collect();
    assert!(rows.len() > 10);
    for (row, (a, b)) in rows.iter().zip(a.iter().zip(&b)) {
        assert!(
            a.0 >= -1.0 && a.1 <= 1.0 && b.0 >= -1.0 && b.1 <= 1.0,
            "{row}"
        );
        let is_open = |x: &(f64, f64)| x.0 < 0.0 && 0.0 < x.1;
        assert!(
            !row.contains("outside") || !(is_open(a) || is_open(b)),
            "{row}"
        );
    }
}

/// dreal3#140: `pow` made an optimum of (1, 1) disappear.
#[test]
fn a_power_keeps_its_zero() {
    let place = Place::new();
    place.file(
        "m.toml",
        "format = 1\nstates = [\"s\"]\ninit.s = 0\nparams = { a = [-10, 10], b = [-10, 10] }\noutputs.y = \"s +- 0.001\"\n\
         der.s = \"(100*(a^2 - b)^2 + (1 - b)^2)^2/4000\"\n",
    );
    place.file("r.csv", "t_s,y\n0,0\n1,0\n");
    place
        .typed("identify m.toml r.csv -o out --figures none --report none --sets 20")
        .ended(0);
    let told: Value = serde_json::from_str(&place.read("out/summary.json")).unwrap();
    for name in ["a", "b"] {
        let param = &told["parameters"][name];
        let [lo, hi] = ["lo", "hi"].map(|end| param[end].as_f64().unwrap());
        assert!(lo <= 1.0 && 1.0 <= hi, "{param}");
    }
}

/// dreal2#61: with one step size `v' = k t` for 17 s to 289 was unsatisfiable, with another satisfiable. Here with every engine, order and longest step.
#[test]
fn no_step_size_changes_a_verdict() {
    let place = Place::new();
    place.file(
        "m.toml",
        "format = 1\nstates = [\"s\", \"v\"]\ninit = { s = 0, v = 0 }\nparams.k = [1.9, 2.1]\nder = { s = \"1\", v = \"k*s\" }\n\
         outputs.y = \"v +- 0.1\"\n",
    );
    place.file("r.csv", "t_s,y\n0,0\n17,289\n");
    place.file("wrong.csv", "t_s,y\n0,0\n17,310\n");
    for flags in [
        "",
        "--order 1",
        "--order 6 --longest-step 17",
        "--longest-step 0.1",
        "--engine forms",
        "--engine closed",
        "--method polytope",
    ] {
        let more: Vec<&str> = flags.split_whitespace().collect();
        place.observe("m.toml", "r.csv", &more).ended(0);
        let (lo, hi) = *bounds(&place.read("out/params.csv"), "k").last().unwrap();
        assert!(lo <= 2.0 && 2.0 <= hi, "{flags}: {lo} {hi}");
        place.observe("m.toml", "wrong.csv", &more).ended(1);
    }
}

/// IntervalRootFinding.jl#184, #146: of `x + sign(x) = 0` an interval without a root was called unique, and an empty one said to
/// hold a root.
#[test]
fn a_measured_sign_keeps_its_jump() {
    let place = Place::new();
    place.file(
        "m.toml",
        "format = 1\nstates = [\"x\"]\ninit.x = [-5, 5]\nder.x = \"0\"\noutputs.y = \"x + sign(x) +- 0\"\n",
    );
    for (y, code) in [("0", 0), ("1.5", 0), ("6.5", 1)] {
        place.file("r.csv", format!("t_s,y\n0,{y}\n1,{y}\n"));
        place.observe("m.toml", "r.csv", &[]).ended(code);
        if code == 0 {
            let (lo, hi) = *bounds(&place.read("out/states.csv"), "x").last().unwrap();
            let root = if y == "0" { 0.0 } else { 0.5 };
            assert!(lo <= root && root <= hi, "{y}: {lo} {hi}");
        }
    }
}

/// Names of all tests in a folder and below.
fn tests_in(folder: &Path, found: &mut BTreeSet<String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            if path.file_name().is_some_and(|name| name != "target") {
                tests_in(&path, found);
            }
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            let text = fs::read_to_string(&path).unwrap();
            for part in text.split("#[test]").skip(1) {
                let name = part.split_once("fn ").map(|(_, rest)| rest);
                let name = name.and_then(|rest| rest.split_once('('));
                found.extend(name.map(|(name, _)| name.to_owned()));
            }
        }
    }
}

/// The page that says which test stands for which report names only tests that exist, and counts all reports.
#[test]
fn the_list_of_reports_names_tests_that_exist() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let page = fs::read_to_string(root.join("docs/known-bugs-of-others.md")).unwrap();
    let mut tests = BTreeSet::new();
    tests_in(&root.join("crates"), &mut tests);
    let rows = page.lines().filter(|line| line.starts_with("| "));
    let rows = rows.filter(|line| !line.starts_with("| report"));
    let (mut seen, mut reports) = (0, 0);
    for row in rows {
        let last = row.trim_end_matches([' ', '|']).rsplit('|').next().unwrap();
        let names: Vec<&str> = last.split('`').skip(1).step_by(2).collect();
        assert!(
            last.contains("left out: ") || !names.is_empty(),
            "no test: {row}"
        );
        for name in names {
            assert!(tests.contains(name), "there is no test `{name}`: {row}");
            seen += 1;
        }
        reports += 1;
    }
    assert!(seen > 80 && reports > 50, "{seen} {reports}");
}
