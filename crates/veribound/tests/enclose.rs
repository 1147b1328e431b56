//! `veribound enclose`: a table of proved bounds, or nothing.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that fails stops"
)]

mod support;

use support::Place;

const GROWTH: &str = "format = 1\nstates = [\"x\"]\ninputs = [\"u\"]\n[init]\nx = [0.9, 1.1]\n\
    [params]\nk = [0.5, 0.6]\n[der]\nx = \"k*x + u\"\n[outputs]\ny = \"x +- 0.1\"\n";

#[test]
fn a_table_contains_exact_solutions() {
    let place = Place::new();
    let model = place.file("m.toml", GROWTH);
    let profile = place.file("u.csv", "t,u\n0,0\n1,1\n");
    let fixed = [
        "enclose", &model, "--input", &profile, "--until", "2", "--every", "0.5",
    ];
    let mut arguments = fixed.to_vec();
    arguments.extend(["-o", "e.csv"]);
    place.run(&arguments).ended(0);
    let table = place.read("e.csv");
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some("t,x.lo,x.hi,x.since.lo,x.since.hi"));
    let rows: Vec<Vec<f64>> = lines
        .map(|line| line.split(',').map(|x| x.parse().unwrap()).collect())
        .collect();
    assert_eq!(rows.len(), 5);
    for (x0, k) in [
        (0.9_f64, 0.5_f64),
        (1.1, 0.6),
        (1.0, 0.55),
        (0.9, 0.6),
        (1.1, 0.5),
    ] {
        for row in &rows {
            let t = row[0];
            let (first, rest) = (t.min(1.0), (t - 1.0).max(0.0));
            let x = x0 * (k * first).exp();
            let x = x * (k * rest).exp() + (k * rest).exp_m1() / k;
            assert!(
                row[1] <= x + 1e-9 && x <= row[2] + 1e-9,
                "{x} at {t}: {row:?}"
            );
            assert!(
                row[3] <= x + 1e-9 && x <= row[4] + 1e-9,
                "{x} at {t}: {row:?}"
            );
        }
    }
    assert!((rows[4][2] - (1.1 * 1.2_f64.exp() + 0.6_f64.exp_m1() / 0.6)).abs() < 1e-3);
}

#[test]
fn what_is_not_proved_is_not_written() {
    let place = Place::new();
    let text =
        "format = 1\nstates = [\"x\"]\ninit.x = 1\nder.x = \"x^2\"\noutputs.y = \"x +- 0.1\"\n";
    let model = place.file("m.toml", text);
    place
        .run(&[
            "enclose", &model, "--until", "2", "--every", "1", "-o", "e.csv",
        ])
        .ended(3);
    assert!(!place.path().join("e.csv").exists());
}

/// What was proved before the pole of `1 / (1 - t)` stays.
#[test]
fn what_is_proved_stays() {
    let place = Place::new();
    let text =
        "format = 1\nstates = [\"x\"]\ninit.x = 1\nder.x = \"x^2\"\noutputs.y = \"x +- 0.1\"\n";
    let model = place.file("m.toml", text);
    let run = place.run(&[
        "enclose", &model, "--until", "2", "--every", "0.25", "-o", "e.csv",
    ]);
    let said = run.ended(3).err;
    assert!(said.contains("The table ends at 0.75 s."), "{said}");
    let table = std::fs::read_to_string(place.path().join("e.csv")).unwrap();
    let last = table.lines().last().unwrap();
    assert!(
        last.starts_with("0.75,3.99999") || last.starts_with("0.75,4"),
        "{last}"
    );
}

/// `x' = -sign(x)` comes to zero at 1 and stays there.
#[test]
fn modes_are_followed() {
    let place = Place::new();
    let text = "format = 1\nstates = [\"x\"]\ninit.x = [0.9, 1]\nder.x = \"-sign(x)\"\noutputs.y = \"x +- 0.1\"\n";
    let model = place.file("m.toml", text);
    let run = place.run(&[
        "enclose", &model, "--until", "2", "--every", "0.5", "-o", "e.csv",
    ]);
    let said = run.ended(0).out;
    assert!(
        said.contains("x   [0, 0]") || said.contains("x   0"),
        "{said}"
    );
    let table = std::fs::read_to_string(place.path().join("e.csv")).unwrap();
    let row = table.lines().nth(2).unwrap();
    assert!(
        row.starts_with("0.5,0.39999") || row.starts_with("0.5,0.4,0.5"),
        "{row}"
    );
}
