//! Bars on records that do not lie in the repository: the synthetic rig with its reference hulls,
//! the measured pendulum and the measured axis. They are read from the folder `shared` beside the project (or from
//! VERIBOUND_SHARED); without it each test says loudly that it was skipped.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that fails stops"
)]

use std::path::{Path, PathBuf};
use veribound::identify::{Conclusion, IdentifyOptions, identify};
use veribound::{
    Estimate, Interval, Model, Observer, ObserverOptions, Record, RecordOptions, Sample, Verdict,
};

fn project() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn data(path: &str) -> Option<PathBuf> {
    let shared = std::env::var_os("VERIBOUND_SHARED")
        .map_or_else(|| project().join("../shared"), PathBuf::from);
    let file = shared.join("data").join(path);
    if file.is_file() {
        return Some(file);
    }
    // Straight to the terminal: the test harness swallows what passes through its macros.
    use std::io::Write;
    let _ = writeln!(
        std::io::stderr(),
        "SKIPPED {path}: no folder `shared` beside the project; set VERIBOUND_SHARED to it"
    );
    None
}

/// Runs the observer with its defaults; every verdict must be consistent.
fn observe(model: &Model, file: &Path, options: RecordOptions) -> Estimate {
    let record = Record::open(file, model, options).unwrap();
    let mut observer = Observer::new(model, ObserverOptions::default());
    assert_eq!(ObserverOptions::default().boxes, 50);
    let mut last = None;
    for sample in record.samples().unwrap() {
        match observer.step(&sample.unwrap()).unwrap() {
            Verdict::Consistent(estimate) => last = Some(estimate),
            other => panic!("{other:?}"),
        }
    }
    last.unwrap()
}

fn rig(file: &Path) -> Estimate {
    let model = Model::from_file(project().join("examples/drive-train/model.toml")).unwrap();
    let phi = if file.ends_with("rig.csv") {
        "phi_meas_rad"
    } else {
        "phi_rad"
    };
    let columns = [("phi_m", phi), ("still", "standstill")];
    let options = RecordOptions {
        columns: columns.map(|(v, c)| (v.to_owned(), c.to_owned())).to_vec(),
        ..RecordOptions::default()
    };
    observe(&model, file, options)
}

/// Contains the hull of the consistent set (near-exact, floating point), and is at most `widest`.
fn assert_bounds(what: &str, bounds: Interval, hull: (f64, f64), widest: f64) {
    println!(
        "{what}: {bounds} (hull {hull:?}, width {:.4} of at most {widest})",
        bounds.width()
    );
    assert!(
        bounds.lo() <= hull.0 && hull.1 <= bounds.hi(),
        "{what} lost: {bounds}"
    );
    assert!(bounds.width() <= widest, "{what} too wide: {bounds}");
}

#[test]
fn rig_with_noise() {
    let Some(file) = data("rig/rig.csv") else {
        return;
    };
    let found = rig(&file);
    // At most 1.5 times a box list with exact hulls: [-2.653,-1.537], [188.0,225.4], [0.1406,0.1594].
    assert_bounds("alpha", found.params[0], (-2.00014652, -1.99993179), 1.674);
    assert_bounds("beta", found.params[1], (199.992339, 200.014741), 56.1);
    assert_bounds("T_Fs", found.params[2], (0.149998719, 0.150001390), 0.0282);
}

#[test]
fn rig_without_noise_has_the_widest_consistent_set() {
    let Some(file) = data("rig/rig_exact.csv") else {
        return;
    };
    let found = rig(&file);
    assert_bounds("alpha", found.params[0], (-2.032, -1.969), 1.674);
    assert_bounds("beta", found.params[1], (196.87, 203.23), 199.5);
    assert_bounds("T_Fs", found.params[2], (0.14953, 0.15047), 0.075);
}

#[test]
fn pendulum() {
    let Some(file) = data("pendulum/pendulum.csv") else {
        return;
    };
    let model = Model::from_file(project().join("examples/pendulum/model.toml")).unwrap();
    let options = RecordOptions {
        from: Some(veribound::Decimal::parse("8").unwrap()),
        to: Some(veribound::Decimal::parse("13").unwrap()),
        ..RecordOptions::default()
    };
    let found = observe(&model, &file, options);
    let param = |name: &str| {
        let index = model
            .params
            .iter()
            .position(|param| param.name == name)
            .unwrap();
        found.params[index]
    };
    // A point found consistent by a minimax fit on this window.
    assert_bounds("a", param("a"), (48.604, 48.604), 4.0);
    assert_bounds("b", param("b"), (0.0227, 0.0227), 0.12);
    assert_bounds("c", param("c"), (0.438, 0.438), 0.9);
}

#[test]
fn positioning_axis() {
    let Some(file) = data("emps/emps.csv") else {
        return;
    };
    let model = Model::from_file(project().join("examples/emps/model.toml")).unwrap();
    let options = RecordOptions {
        to: Some(veribound::Decimal::parse("3").unwrap()),
        ..RecordOptions::default()
    };
    let found = observe(&model, &file, options);
    // A point inside the consistent set of the equation in its integrated form (linear program).
    assert_bounds("inv_M", found.params[0], (0.01072, 0.01072), 0.012);
    assert_bounds("R_slow", found.params[1], (25.4, 25.4), 40.0);
    assert_bounds("R_fast", found.params[2], (40.3, 40.3), 15.0);
}

/// Identification at the edge of what the record can tell: hulls from an independent optimiser, which may be off by
/// 2e-6 rad, lie inside of the outer bounds, and these are at most 5 % wider.
#[test]
fn the_rig_is_identified_to_the_edge() {
    let Some(file) = data("rig/rig.csv") else {
        return;
    };
    let model = Model::from_file(project().join("examples/drive-train/model.toml")).unwrap();
    let columns = [("phi_m", "phi_meas_rad"), ("still", "standstill")];
    let options = RecordOptions {
        columns: columns
            .iter()
            .map(|(a, b)| ((*a).to_owned(), (*b).to_owned()))
            .collect(),
        ..RecordOptions::default()
    };
    let record = Record::open(&file, &model, options).unwrap();
    let samples: Vec<Sample> = record.samples().unwrap().map(Result::unwrap).collect();
    let found = identify(&model, &[samples], &IdentifyOptions::default(), &|_| true);
    assert_eq!(found.conclusion, Conclusion::Consistent);
    let reference = [
        (-2.000_146_52, -1.999_931_79),
        (199.992_339, 200.014_741),
        (0.149_998_719, 0.150_001_39),
    ];
    for (bounds, (lo, hi)) in found.params.iter().zip(reference) {
        let slack = 1e-4 * (hi - lo);
        let outer = bounds.outer;
        assert!(
            outer.lo() <= lo + slack && hi - slack <= outer.hi(),
            "{bounds:?}"
        );
        assert!(outer.width() <= 1.05 * (hi - lo), "{bounds:?}");
        assert!(bounds.tightness() <= 1.05, "{bounds:?}");
    }
}
