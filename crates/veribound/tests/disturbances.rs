//! Disturbances: unknown functions of time, of which a model knows bounds only.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that fails stops"
)]

mod support;

use support::{Place, bounds};

/// `x' = d - k x` from 0, with `d` up to `reach` in size.
fn pushed(reach: &str) -> String {
    format!(
        "format = 1\nstates = [\"x\"]\ninit.x = 0\ndisturbances.d = [-{reach}, {reach}]\n\
         params.k = [0.5, 3]\nder.x = \"d - k*x\"\noutputs.y = \"x +- 0.01\"\n"
    )
}

/// Every 0.05 s the value at that time, within the bound of the model.
fn record(value: impl Fn(f64) -> f64) -> String {
    let mut text = String::from("t,y\n");
    for sample in 0..200 {
        let t = f64::from(sample) * 0.05;
        // Errors between -0.008 and 0.008, and at most 0.0005 of rounding.
        let error = 0.008 * (f64::from(sample) * 1.7).sin();
        text += &format!("{t:.2},{:.3}\n", value(t) + error);
    }
    text
}

#[test]
fn a_disturbance_may_change_at_any_time() {
    let place = Place::new();
    let model = place.file("m.toml", pushed("0.3"));
    // d = 0.3 cos(7 t), k = 1: between two samples it changes by a tenth.
    let value = |t: f64| 0.3 * ((7.0 * t).cos() + 7.0 * (7.0 * t).sin() - (-t).exp()) / 50.0;
    let data = place.file("r.csv", record(value));
    place.run(&["observe", &model, &data, "-o", "out"]).ended(0);
    for (sample, (lo, hi)) in bounds(&place.read("out/states.csv"), "x")
        .iter()
        .enumerate()
    {
        let truth = value(sample as f64 * 0.05);
        assert!(
            *lo <= truth && truth <= *hi,
            "{truth} in [{lo}, {hi}] at {sample}"
        );
    }
    for (lo, hi) in bounds(&place.read("out/params.csv"), "k") {
        assert!(lo <= 1.0 && 1.0 <= hi);
    }
}

#[test]
fn a_disturbance_beyond_its_bounds_is_refuted() {
    let place = Place::new();
    let (wide, narrow) = (
        place.file("wide.toml", pushed("0.3")),
        place.file("narrow.toml", pushed("0.05")),
    );
    let fixed = [
        "simulate", &wide, "--params", "k=1", "--until", "5", "--every", "0.05",
    ];
    let mut pushed = fixed.to_vec();
    pushed.extend(["--disturbance", "d=0.2", "-o", "pushed.csv"]);
    place.run(&pushed).ended(0);
    let record = place.read("pushed.csv");
    assert!(record.starts_with("# veribound simulate wide.toml --params k=1 --disturbance d=0.2 "));
    assert!(record.contains("\nt [s],y\n"), "no column for d: {record}");
    place
        .run(&["observe", &wide, "pushed.csv", "-o", "out"])
        .ended(0);
    let refuted = place
        .run(&["observe", &narrow, "pushed.csv", "-o", "no"])
        .ended(1);
    assert!(refuted.out.contains("inconsistent"), "{}", refuted.out);
    // Where none is said it rests in the middle.
    let mut rest = fixed.to_vec();
    rest.extend(["-o", "rest.csv"]);
    place.run(&rest).ended(0);
    place
        .run(&["observe", &narrow, "rest.csv", "-o", "out"])
        .ended(0);
}

#[test]
fn a_disturbance_is_no_column_and_no_input() {
    let place = Place::new();
    let model = place.file("m.toml", pushed("0.3"));
    let data = place.file("r.csv", record(|_| 0.0));
    let say = |flags: &[&str], code: &str, part: &str| {
        let mut all = vec!["observe", model.as_str(), data.as_str(), "-o", "out"];
        all.extend(flags);
        let ran = place.run(&all).ended(2);
        assert!(
            ran.err.contains(code) && ran.err.contains(part),
            "{}",
            ran.err
        );
    };
    say(
        &["--column", "d=y"],
        "E0420",
        "no input, output or signal `d`",
    );
    say(&["--input-error", "d=0.1"], "E0603", "no input `d`");
    let outside = [
        "simulate",
        &model,
        "--params",
        "k=1",
        "--until",
        "1",
        "--every",
        "0.5",
        "--disturbance",
        "d=0.4",
        "-o",
        "s.csv",
    ];
    let ran = place.run(&outside).ended(2);
    assert!(
        ran.err.contains("the disturbance `d` cannot be 0.4") && ran.err.contains("[-0.3, 0.3]"),
        "{}",
        ran.err
    );
}
