//! `new`, `doctor`, `completions`, `man`, `--json` of every command, and colours.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that fails stops"
)]

mod support;

use serde_json::Value;
use support::{CART, Place, Ran, cart_record};

fn json(ran: &Ran) -> Value {
    serde_json::from_str(&ran.out).unwrap_or_else(|error| panic!("{error} in {}", ran.out))
}

/// Every example can be made; what its README says is what the program tells, and the model is read.
#[test]
fn every_example_makes_a_folder() {
    let place = Place::new();
    for example in [
        "drive-train",
        "two-tanks",
        "bouncing-ball",
        "compartments",
        "lotka-volterra",
    ] {
        let ran = place.run(&["new", example, "--example", example]).ended(0);
        let readme = place.read(&format!("{example}/README.md"));
        let commands: Vec<&str> = ran
            .out
            .lines()
            .filter_map(|line| line.strip_prefix("    veribound "))
            .collect();
        assert!(commands.len() >= 2, "{}", ran.out);
        for command in &commands {
            assert!(
                readme.contains(&format!("veribound {command}")),
                "{command} in {readme}"
            );
        }
        assert!(readme.starts_with(&format!("# {example}\n")), "{readme}");
        place
            .run(&["check", &format!("{example}/model.toml")])
            .ended(0);
    }
    // Nothing is replaced.
    let ran = place.run(&["new", "two-tanks"]).ended(2);
    assert!(
        ran.err
            .contains("error[E0615]: `two-tanks` is there already"),
        "{}",
        ran.err
    );
    place.run(&["new", "x", "--example", "nothing"]).ended(2);
}

/// The folder runs: the first command that gives bounds gives them.
#[test]
fn the_folder_runs() {
    let place = Place::new();
    let made = json(
        &place
            .run(&["new", "ball", "--example", "bouncing-ball", "--json"])
            .ended(0),
    );
    assert_eq!(
        made["files"],
        serde_json::json!(["model.toml", "record.csv", "README.md"])
    );
    for command in made["commands"].as_array().unwrap() {
        let words: Vec<&str> = command.as_str().unwrap().split(' ').skip(1).collect();
        let mut program = place.command(&words);
        let ran = program
            .current_dir(place.path().join("ball"))
            .output()
            .unwrap();
        assert!(
            ran.status.success(),
            "{command}: {}",
            String::from_utf8_lossy(&ran.stderr)
        );
    }
    assert!(place.path().join("ball/out/report.html").exists());
}

#[test]
fn doctor_finds_all_well() {
    let place = Place::new();
    let ran = place.run(&["doctor"]).ended(0);
    for part in [
        "  threads: ",
        "  ok      sqrt 2 = 1.41421356",
        "  all is well\n",
        env!("CARGO_PKG_VERSION"),
    ] {
        assert!(ran.out.contains(part), "no {part} in {}", ran.out);
    }
    assert!(!ran.out.contains("FAILED"));
    let told = json(&place.run(&["doctor", "--json"]).ended(0));
    assert_eq!(told["healthy"], true);
    let lanes = told["lanes_available"].as_array().unwrap();
    assert!(lanes.contains(&told["lanes"]));
    for name in lanes {
        let mut program = place.command(&["doctor", "--json"]);
        let ran = program
            .env("VERIBOUND_LANES", name.as_str().unwrap())
            .output()
            .unwrap();
        let told: Value = serde_json::from_slice(&ran.stdout).unwrap();
        assert_eq!(&told["lanes"], name);
    }
    let mut program = place.command(&["doctor"]);
    let ran = Ran::of(program.env("VERIBOUND_LANES", "abacus").output().unwrap()).ended(2);
    assert!(
        ran.out.contains("FAILED") && ran.out.contains("prove nothing"),
        "{}",
        ran.out
    );
    assert!(ran.err.contains("error[E0508]"), "{}", ran.err);
}

#[test]
fn completions_and_manual_know_all_commands() {
    let place = Place::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = place.run(&["completions", shell]).ended(0).out;
        for word in [
            "observe",
            "identify",
            "enclose",
            "doctor",
            "velocity-horizon",
        ] {
            assert!(script.contains(word), "no {word} for {shell}");
        }
    }
    let page = place.run(&["man"]).ended(0).out;
    assert!(
        page.contains(".TH veribound 1") && page.contains("observe"),
        "{page}"
    );
    place.run(&["man", "-o", "pages"]).ended(0);
    let pages = place.files("pages");
    assert!(pages.contains(&"veribound.1".to_owned()), "{pages:?}");
    assert!(
        pages.contains(&"veribound-observe.1".to_owned()),
        "{pages:?}"
    );
    let observe = place.read("pages/veribound-observe.1");
    assert!(observe.contains("velocity\\-horizon"), "{observe}");
}

/// Every command has one JSON document for what its text says.
#[test]
fn json_everywhere() {
    let place = Place::new();
    let (model, record) = place.cart(5);
    let told = json(&place.run(&["check", &model, "--json"]).ended(0));
    assert_eq!(told["parameters"]["k"]["bounds"]["hi"], 4);
    assert_eq!(told["states"]["x"]["unit"], "m");
    let text = place.run(&["check", &model]).ended(0).out;
    assert_eq!(
        told["description"].as_str().unwrap().trim_end(),
        text.trim_end()
    );
    let told = json(&place.run(&["explain", "E0213", "201", "--json"]).ended(0));
    assert_eq!(told["codes"][0]["code"], "E0213");
    assert_eq!(told["codes"][1]["code"], "E0201");
    assert!(
        json(&place.run(&["explain", "--json"]).ended(0))["codes"]
            .as_array()
            .unwrap()
            .len()
            > 70
    );
    let flags = [
        "simulate", &model, "--params", "k=2", "--start", "x=0", "--input", &record, "-o", "s.csv",
        "--json",
    ];
    let told = json(&place.run(&flags).ended(0));
    assert_eq!(
        (&told["record"], &told["samples"]),
        (&"s.csv".into(), &5.into())
    );
    for words in [
        vec!["observe", &model, &record, "-o", "a"],
        vec!["identify", &model, &record, "-o", "b", "--sets", "3"],
    ] {
        let words = [
            &words[..],
            &["--figures", "none", "--report", "none", "--json"],
        ]
        .concat();
        let ran = place.run(&words);
        assert_eq!(json(&ran)["samples"], 5);
    }
}

/// Colours come on a terminal only, or when they are asked for.
#[test]
fn colours_are_asked_for() {
    let place = Place::new();
    let model = place.file("m.toml", CART.replace("k * u", "k * v"));
    let escape = '\u{1b}';
    assert!(!place.run(&["check", &model]).ended(2).err.contains(escape));
    assert!(
        place
            .run(&["check", &model, "--color", "always"])
            .ended(2)
            .err
            .contains(escape)
    );
    assert!(
        place
            .run(&["--color", "always", "check", &model])
            .ended(2)
            .err
            .contains(escape)
    );
    assert!(
        !place
            .run(&["check", &model, "--color", "never"])
            .ended(2)
            .err
            .contains(escape)
    );
    let mut program = place.command(&["check", &model]);
    let ran = Ran::of(program.env("NO_COLOR", "1").output().unwrap());
    assert!(!ran.err.contains(escape));
}

/// Tables as Parquet files stand beside those of text, and go with them.
#[test]
fn tables_as_parquet() {
    let place = Place::new();
    let (model, record) = (
        place.file("m.toml", CART),
        place.file("r.csv", cart_record(9)),
    );
    place.observe(&model, &record, &["--parquet"]).ended(0);
    for name in ["boxes", "params", "states"] {
        let bytes = std::fs::read(place.path().join(format!("out/{name}.parquet"))).unwrap();
        assert!(bytes.starts_with(b"PAR1") && bytes.ends_with(b"PAR1"));
    }
    place.observe(&model, &record, &[]).ended(0);
    assert!(
        !place
            .files("out")
            .iter()
            .any(|name| name.ends_with(".parquet"))
    );
}
