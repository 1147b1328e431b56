//! `veribound simulate`: what it writes is proved, and what it cannot prove it does not write.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that fails stops"
)]

mod support;

use support::{CART, Place, rig};

/// `x' = -x` from 1, measured within 0.1.
const DECAY: &str = "format = 1\nstates = [\"x\"]\ninit.x = 1\nparams.k = [0, 3]\n\
    der.x = \"-k * x\"\noutputs.y = \"x +- 0.1\"\n";

fn column(record: &str, at: usize) -> Vec<f64> {
    let rows = record.lines().skip(2);
    rows.map(|row| row.split(',').nth(at).unwrap().parse().unwrap())
        .collect()
}

#[test]
fn errors_stay_inside_the_bound_that_was_asked_for() {
    let place = Place::new();
    let model = place.file("m.toml", DECAY);
    let fixed = [
        "simulate", &model, "--params", "k=1", "--until", "5", "--every", "0.05",
    ];
    let run = |more: &[&str]| {
        let mut arguments = fixed.to_vec();
        arguments.extend(more);
        arguments.extend(["-o", "r.csv"]);
        place.run(&arguments).ended(0);
        let record = place.read("r.csv");
        let (times, values) = (column(&record, 0), column(&record, 1));
        assert_eq!(times.len(), 101);
        times
            .iter()
            .zip(values)
            .map(|(t, y)| y - (-t).exp())
            .collect::<Vec<f64>>()
    };
    let errors = run(&["--error", "0.02"]);
    assert!(errors.iter().all(|e| e.abs() <= 0.02 + 1e-12));
    assert!(errors.iter().any(|e| *e > 0.01) && errors.iter().any(|e| *e < -0.01));
    let worst = run(&["--error", "worst"]);
    assert!(
        worst.iter().all(|e| (0.098..=0.1).contains(&e.abs())),
        "{worst:?}"
    );
    assert!(worst.iter().any(|e| *e > 0.0) && worst.iter().any(|e| *e < 0.0));
    let rounded = run(&["--error", "0"]);
    assert!(rounded.iter().all(|e| e.abs() < 1e-3));
    assert_ne!(run(&["--seed", "2"]), run(&["--seed", "3"]));
    assert_eq!(run(&["--seed", "2"]), run(&["--seed", "2"]));
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_no_record() {
    let place = Place::new();
    let model = place.file("m.toml", DECAY);
    let flags = [
        "simulate", &model, "--params", "k=0", "--until", "10000", "--every", "0.01", "-o", "r.csv",
    ];
    let child = place
        .command(&flags)
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    while place.files("").len() < 2 {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let sent = std::process::Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(sent.success());
    let ran = support::Ran::of(child.wait_with_output().unwrap()).ended(130);
    assert_eq!(ran.err, "interrupted: no record is written\n");
    assert_eq!(place.files(""), ["m.toml"]);
}

#[test]
fn a_value_outside_its_prior_is_said() {
    let place = Place::new();
    let model = place.file("m.toml", DECAY);
    let ran = place
        .typed(&format!(
            "simulate {model} --params k=4 --change 1:k=-1 --until 2 --every 1 -o r.csv"
        ))
        .ended(0);
    for part in [
        "note: k = 4 lies outside its prior [0, 3]\n",
        "note: k = -1 lies outside its prior [0, 3]\n",
        "  3 samples in r.csv\n",
    ] {
        assert!(ran.err.contains(part), "no {part:?} in:\n{}", ran.err);
    }
    assert_eq!(place.files(""), ["m.toml", "r.csv"]);
}

#[test]
fn profiles_may_be_written_as_records_may() {
    let place = Place::new();
    let (model, plain) = (
        place.file("m.toml", CART),
        place.file("plain.csv", "t,u\n0,1\n0.5,2\n1,0\n"),
    );
    let tabs =
        "# \"made\" by hand\n\n\"Time [s]\" ; note;u [V]\n0;a,b;1\n\n0.50;;2\n;;\n1;\"c;d\";0\n";
    let other = place.file("other.csv", tabs);
    let simulate = |profile: &str| {
        place
            .typed(&format!(
                "simulate {model} --params k=1 --start x=0 --input {profile} -o r.csv"
            ))
            .ended(0);
        let text = place.read("r.csv");
        text.split_once('\n').unwrap().1.to_owned()
    };
    assert_eq!(simulate(&plain), simulate(&other));
}

#[test]
fn standstill_is_written_only_where_it_is_proved() {
    let place = Place::new();
    let profile = place.file("p.csv", "t,u\n0,0.1\n1,0.3\n2,0\n4,0\n");
    let model = rig("model.toml");
    let params = "alpha=-2,beta=200,T_Fs=0.15";
    let flags = [
        "simulate", &model, "--params", params, "--start", "phi=0", "--input", &profile,
    ];
    let flags: Vec<&str> = flags
        .into_iter()
        .chain(["--every", "0.01", "-o", "r.csv"])
        .collect();
    place.run(&flags).ended(0);
    let record = place.read("r.csv");
    let still = column(&record, 3);
    assert!(
        still[..=100].iter().all(|s| *s == 1.0),
        "it stands until the torque breaks it away"
    );
    assert!(still[101..=200].iter().all(|s| *s == 0.0));
    assert!(
        still[300..].iter().all(|s| *s == 1.0),
        "it comes to rest again"
    );
    // The record is one the observer can explain, of course.
    place.observe(&model, "r.csv", &[]).ended(0);
}

#[test]
fn a_change_of_a_parameter_refutes_the_constant_one() {
    let place = Place::new();
    let (model, profile) = (rig("model.toml"), rig("profile.csv"));
    let params = "alpha=-2,beta=200,T_Fs=0.15";
    let flags = [
        "simulate", &model, "--params", params, "--start", "phi=0", "--input", &profile,
    ];
    let more = [
        "--every",
        "0.01",
        "--until",
        "32",
        "--change",
        "12.5:T_Fs=0.05",
        "-o",
        "r.csv",
    ];
    let flags: Vec<&str> = flags.into_iter().chain(more).collect();
    place.run(&flags).ended(0);
    assert!(
        place
            .read("r.csv")
            .starts_with("# veribound simulate model.toml --params alpha=-2")
    );
    place.observe(&model, "r.csv", &[]).ended(1);
    place
        .observe(&model, "r.csv", &["--reset", "T_Fs@still:0.2"])
        .ended(0);
}

#[test]
fn what_is_not_known_is_asked_for() {
    let place = Place::new();
    let (cart, decay) = (
        place.file("cart.toml", CART),
        place.file("decay.toml", DECAY),
    );
    let profile = place.file("p.csv", "t,u\n0,1\n0.15,2\n1,0\n");
    let grid = ["--until", "1", "--every", "0.1", "-o", "r.csv"];
    let refused = |flags: &[&str], code: &str, part: &str| {
        let flags: Vec<&str> = ["simulate"]
            .iter()
            .chain(flags)
            .chain(&grid)
            .copied()
            .collect();
        let ran = place.run(&flags).ended(2);
        assert!(
            ran.err.contains(code) && ran.err.contains(part),
            "{}",
            ran.err
        );
        assert!(!place.path().join("r.csv").exists());
    };
    refused(&[&decay, "--params", "j=1"], "E0601", "`j`");
    refused(&[&decay, "--params", "k=1,k=2"], "E0608", "twice");
    refused(
        &[&cart, "--params", "k=1"],
        "E0607",
        "`x` starts anywhere in [-1, 1]",
    );
    refused(
        &[&cart, "--params", "k=1", "--start", "x=0"],
        "E0607",
        "--input",
    );
    let uneven = [
        cart.as_str(),
        "--params",
        "k=1",
        "--start",
        "x=0",
        "--input",
        &profile,
    ];
    refused(&uneven, "E0608", "changes at t = 0.15 s");
    refused(
        &[&decay, "--params", "k=1", "--change", "x"],
        "E0608",
        "SECONDS:NAME=VALUE",
    );
    refused(
        &[&decay, "--params", "k=1", "--decimals", "1"],
        "E0609",
        "`y`",
    );
    refused(
        &[&decay, "--params", "k=1", "--error", "0.5"],
        "E0610",
        "more than the model allows",
    );
}

#[test]
fn what_the_model_fixes_needs_no_value() {
    let place = Place::new();
    let fixed = DECAY.replace("params.k = [0, 3]", "params.k = { fixed = 0.1 }");
    let model = place.file("m.toml", &fixed);
    place
        .typed(&format!("simulate {model} --until 1 --every 0.5 -o r.csv"))
        .ended(0);
    assert!(
        place
            .read("r.csv")
            .starts_with("# veribound simulate m.toml --until 1 ")
    );
    let free = place.file("free.toml", DECAY);
    let ran = place
        .run(&[
            "simulate", &free, "--until", "1", "--every", "0.5", "-o", "r.csv",
        ])
        .ended(2);
    assert!(ran.err.contains("no value is given for `k`"), "{}", ran.err);
}

#[test]
fn too_few_decimals_are_called_so() {
    let place = Place::new();
    let sharp = DECAY.replace("+- 0.1", "+- 0.0005");
    let model = place.file("m.toml", &sharp);
    let ran = place
        .run(&[
            "simulate", &model, "--params", "k=1", "--until", "1", "--every", "0.5", "-o", "r.csv",
        ])
        .ended(2);
    assert!(
        ran.err.contains("rounding `y` to 4 decimals") && ran.err.contains("`--decimals`"),
        "{}",
        ran.err
    );
}

/// `x'' = -x` with a disturbance, measured within 0.1.
const OSCILLATOR: &str = "format = 1\nstates = [\"x\", \"v\"]\ninit = { x = [0.5, 1.5], v = 0 }\n\
    disturbances = { w = [-0.1, 0.1] }\nparams.k = [0.5, 2]\n\
    der.x = \"v\"\nder.v = \"-k*x + w\"\noutputs.y = \"x +- 0.1\"\n";

#[test]
fn what_is_not_given_is_drawn_and_told() {
    let place = Place::new();
    let model = place.file("m.toml", DECAY);
    let run = |more: &[&str]| {
        let fixed = [
            "simulate", &model, "--until", "2", "--every", "0.1", "-o", "r.csv",
        ];
        let all: Vec<&str> = fixed.iter().chain(more).copied().collect();
        place.run(&all).ended(0);
        place.read("r.csv")
    };
    let drawn = run(&["--random", "--seed", "5"]);
    let told = drawn.lines().nth(1).unwrap();
    let value = told.strip_prefix("# drawn: k=").unwrap();
    let number: f64 = value.parse().unwrap();
    assert!((0.0..=3.0).contains(&number), "{told}");
    assert!(
        drawn.starts_with("# veribound simulate m.toml --until 2 --every 0.1 --random --seed 5")
    );
    // The same with what was told, but for what is said of it; another seed draws another.
    let given = run(&["--params", &format!("k={value}"), "--seed", "5"]);
    let rows = |text: &str, skip: usize| text.lines().skip(skip).collect::<Vec<_>>().join("\n");
    assert_eq!(rows(&drawn, 2), rows(&given, 1));
    assert_ne!(run(&["--random", "--seed", "6"]).lines().nth(1), Some(told));
    // What is given is not drawn.
    let both = run(&["--random", "--params", "k=1"]);
    assert!(!both.contains("# drawn"), "{both}");
}

/// A record that is drawn agrees with the model it was drawn from: parameters, start, disturbances and errors.
#[test]
fn what_is_drawn_is_consistent() {
    let place = Place::new();
    let model = place.file("m.toml", OSCILLATOR);
    for seed in ["1", "2", "3"] {
        place
            .typed(&format!(
                "simulate {model} --random --seed {seed} --until 8 --every 0.1 -o r.csv"
            ))
            .ended(0);
        place
            .typed(&format!("observe {model} r.csv --figures none -o out"))
            .ended(0);
    }
}

/// Boxes around a point grow with every turn; what keeps the turn does not.
#[test]
fn a_thousand_seconds_of_turns() {
    let place = Place::new();
    let model = place.file("m.toml", OSCILLATOR);
    place.typed(&format!("simulate {model} --params k=1 --start x=1 --until 1000 --every 0.5 --error 0 --decimals 6 -o r.csv")).ended(0);
    let record = place.read("r.csv");
    for (t, y) in column(&record, 0).iter().zip(column(&record, 1)) {
        assert!((y - t.cos()).abs() < 2e-6, "{t}: {y}");
    }
}

#[test]
fn the_trajectory_itself() {
    let place = Place::new();
    let model = place.file("m.toml", OSCILLATOR);
    place.typed(&format!("simulate {model} --params k=1 --start x=1 --until 5 --every 0.25 -o r.csv --trajectory way --figures svg")).ended(0);
    let files = place.files("way/fig");
    assert_eq!(files, ["outputs.svg", "plane.svg", "states.svg"]);
    let table = place.read("way/trajectory.csv");
    let names: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let at = |name: &str| names.iter().position(|known| *known == name).unwrap();
    let rows: Vec<Vec<f64>> = table
        .lines()
        .skip(1)
        .map(|row| {
            row.split(',')
                .map(|cell| cell.parse().unwrap_or(f64::NAN))
                .collect()
        })
        .collect();
    assert_eq!(rows.len(), 21);
    let within = |row: &[f64], name: &str, value: f64| {
        let (lo, hi) = (
            row[at(&format!("{name}.lo"))],
            row[at(&format!("{name}.hi"))],
        );
        assert!(
            lo - 1e-9 <= value && value <= hi + 1e-9,
            "{name} is {value} in [{lo}, {hi}]"
        );
        hi - lo
    };
    for (k, row) in rows.iter().enumerate() {
        let t = 0.25 * k as f64;
        assert!(within(row, "x", t.cos()) < 1e-9 && within(row, "v", -t.sin()) < 1e-9);
        assert!(within(row, "y", t.cos()) < 1e-9);
        // And at times between.
        for share in [0.2, 0.5, 0.9] {
            let before = (t - 0.25 * share).max(0.0);
            assert!(within(row, "x.since", before.cos()) < 0.4);
            within(row, "v.since", -before.sin());
            within(row, "y.since", before.cos());
        }
    }
}
