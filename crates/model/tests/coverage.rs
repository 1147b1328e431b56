//! What is proved about guards: cover everything, cover the domain, leave a gap, or not known.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

use veribound_model::{Coverage, Model};

/// A model with states `x` and `v`, input `u`, parameter `T` in [0.1, 0.2] and these guards.
fn model(guards: &[&str]) -> Result<Model, String> {
    model_with("", guards)
}

fn model_with(domain: &str, guards: &[&str]) -> Result<Model, String> {
    let mut text = format!(
        "format = 1\n[states]\nx = {{ init = 0{domain} }}\nv = {{ init = 0 }}\n[inputs]\nu = {{}}\n\
         [params]\nT = [0.1, 0.2]\n[outputs]\ny = \"x +- 1\"\n[modes]\n"
    );
    for (i, guard) in guards.iter().enumerate() {
        text.push_str(&format!(
            "m{i} = {{ when = \"{guard}\", der = {{ x = \"v\", v = \"u\" }} }}\n"
        ));
    }
    Model::from_text("guards.toml", text).map_err(|problems| problems.0[0].message.clone())
}

fn gap(guards: &[&str]) -> String {
    model(guards)
        .unwrap_err()
        .strip_prefix("the modes leave a gap: ")
        .unwrap()
        .to_string()
}

#[test]
fn guards_that_cover_everything() {
    for guards in [
        &["true"][..],
        &["x >= 0", "x <= 0"],
        &["x > 0", "x == 0", "x < 0"],
        &["x > 0", "not x > 0"],
        &["x + 1 > v", "v >= 1 + x"],
        &["x > v + 1", "x < v + 2"],
        &[
            "v > 0 or (v == 0 and u > T)",
            "v == 0 and abs(u) <= T",
            "v < 0 or (v == 0 and u < -T)",
        ],
        &["max(x, v) < 0", "x >= 0", "v >= 0"],
        &["abs(x) > T", "min(T - x, T + x) >= 0"],
        &["2*x - 2*v <= u", "v - x < -u/2"],
        &["sin(x) > 0.5", "sin(x) <= 0.5"],
        &["x^2 + v^2 >= 1", "not (v^2 + x^2 > 2)"],
        &["x != 0", "abs(x) <= 0"],
        &["x > 0 and v > 0", "x <= 0 or v <= 0"],
    ] {
        assert_eq!(
            model(guards).unwrap().coverage,
            Coverage::Everywhere,
            "{guards:?}"
        );
    }
}

#[test]
fn guards_that_cover_only_the_domain() {
    // T is never negative, a square neither, and x stays below 2000.
    for guards in [
        &["x > -T", "x < T"][..],
        &["x^2 + 1 > 0"],
        &["x < 2000"],
        &["x + T > 0 or x - T < 0"],
    ] {
        let coverage = model(guards).unwrap().coverage;
        assert!(
            matches!(coverage, Coverage::InDomain { .. }),
            "{guards:?}: {coverage:?}"
        );
    }
    let covered = model_with(", domain = [0, 2]", &["sqrt(x) >= 1", "sqrt(x) < 1"]).unwrap();
    assert!(matches!(covered.coverage, Coverage::InDomain { .. }));
    let covered = model_with(", domain = [0, 2]", &["x >= 0"]).unwrap();
    assert!(matches!(covered.coverage, Coverage::InDomain { .. }));
}

#[test]
fn gaps_are_found() {
    assert_eq!(gap(&["x > 0", "x < 0"]), "x = 0");
    assert_eq!(
        gap(&["x > T", "x < T"]),
        "x = T (for instance T in [0.1, 0.2])"
    );
    assert!(gap(&["x >= 1", "x <= -1"]).starts_with("-1 < x < 1 (for instance x in ["));
    assert!(gap(&["x > v", "x < v"]).starts_with("x = v (for instance v in ["));
    assert!(
        gap(&["x*x + v*v > 2"]).starts_with("x^2 + v^2 < 2"),
        "{}",
        gap(&["x*x + v*v > 2"])
    );
    // Both lines are excluded; only their crossing is left.
    assert_eq!(
        gap(&["x > 0", "x < 0", "v > 0", "v < 0"]),
        "x = 0 and v = 0"
    );
    // The stick mode of the rig forgotten, then written with a strict level.
    assert!(gap(&["v > 0", "v < 0", "v == 0 and u > T", "v == 0 and u < -T"]).starts_with("v = 0"));
    let strict = gap(&[
        "v > 0 or (v == 0 and u > T)",
        "v == 0 and abs(u) < T",
        "v < 0 or (v == 0 and u < -T)",
    ]);
    assert!(
        strict.contains("v = 0") && strict.contains("for instance"),
        "{strict}"
    );
}

#[test]
fn what_is_not_known_is_not_reported_as_a_gap() {
    for guards in [
        // Covered, but only by an identity of the sine.
        &["sin(x)^2 + cos(x)^2 > 0.999999999999999999"][..],
        // A gap along a curve that no rational point is known on.
        &["x^3 + v^3 > 1", "x^3 + v^3 < 1"],
        &["1/x > 0", "x <= 0"],
        &["sqrt(x) > 1", "sqrt(x) <= 1"],
    ] {
        let coverage = model(guards).unwrap().coverage;
        assert!(
            matches!(coverage, Coverage::Unproved(_)),
            "{guards:?}: {coverage:?}"
        );
        let text = model(guards).unwrap().describe();
        assert!(text.contains("not proved within the budget"), "{text}");
    }
}

#[test]
fn many_comparisons_end_in_time() {
    let mut guards = Vec::new();
    for i in 0..60 {
        guards.push(format!(
            "abs(x - {i}*v) + abs(v - {i}*u) > {i} and sin(x*{i}) < u^{}",
            i + 2
        ));
    }
    let guards: Vec<&str> = guards.iter().map(String::as_str).collect();
    let start = std::time::Instant::now();
    let _ = model(&guards);
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
}
