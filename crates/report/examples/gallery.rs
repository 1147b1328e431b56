//! Draws all figures of an invented run of the drive-train rig, of a run with uncertain input, of what an
//! identification might leave, and of odd cases, into the folder given (default `target/gallery`): for looking at them.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::{env, fs};

use veribound_report::{
    Figure, FigureMeta, History, Identification, Parameter, PavingTile, ProvedParameter, Quantity,
    SampleRow, TileStatus, Zoom, png,
};

/// The angle in rad that a rig under a slow stop-and-go profile might have: 0 to 160 rad in 80 s.
fn angle(t: f64) -> f64 {
    let ramp = |from: f64, to: f64| ((t - from) / (to - from)).clamp(0.0, 1.0);
    let smooth = |from: f64, to: f64| {
        let x = ramp(from, to);
        x * x * (3.0 - 2.0 * x)
    };
    62.0 * smooth(2.0, 18.0) - 40.0 * smooth(22.0, 33.0)
        + 95.0 * smooth(36.0, 55.0)
        + 43.0 * smooth(60.0, 74.0)
        + 0.6 * (1.3 * t).sin() * smooth(2.0, 6.0)
}

fn meta(label: &str) -> FigureMeta {
    let param = |name: &str, unit: &str, prior, nominal| Parameter {
        quantity: Quantity::new(name, unit),
        prior,
        nominal: Some(nominal),
    };
    FigureMeta {
        title: "Drive-train rig".to_owned(),
        label: label.to_owned(),
        outputs: vec![Quantity::new("phi_m", "rad")],
        states: vec![Quantity::new("phi", "rad"), Quantity::new("omega", "rad/s")],
        params: vec![
            param("alpha", "1/s", (-6.0, -0.05), -2.5),
            param("beta", "1/(kg*m^2)", (100.0, 400.0), 205.0),
            param("T_Fs", "N*m", (0.08, 0.35), 0.15),
        ],
        modes: vec![
            "forward".to_owned(),
            "stick".to_owned(),
            "backward".to_owned(),
        ],
        sample_time_ms: Some(10.0),
        ..FigureMeta::default()
    }
}

/// A run whose bounds shrink whenever the rig moves; `slack` widens all of them.
fn rig(label: &str, slack: f64) -> Result<History, Box<dyn Error>> {
    let mut history = History::new(meta(label));
    let mut known = 0.0_f64;
    let mut friction = 0.0_f64;
    let mut was_still = true;
    let mut noise = 1u64;
    for k in 0..=8000 {
        let t = f64::from(k) * 0.01;
        noise = noise
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let error = ((noise >> 33) as f64 / f64::from(1u32 << 31) - 0.5) * 0.198;
        let speed = (angle(t + 5e-4) - angle(t - 5e-4)) / 1e-3;
        let still = speed.abs() < 0.02;
        let reset = still && !was_still && t > 19.0;
        if reset {
            friction = 0.0;
        }
        was_still = still;
        let step = (speed.abs() / 4.0).min(1.0) * 0.004;
        if (k / 40) % 3 == 0 {
            known += step;
            friction += 2.0 * step;
        }
        let left = (-known).exp();
        let band = |mid: f64, lo: f64, hi: f64, left: f64| {
            let floor = 0.06 * slack * (hi - lo);
            (
                (mid - (mid - lo) * left - floor).max(lo),
                (mid + (hi - mid) * left + floor).min(hi),
            )
        };
        let params = [
            band(-2.1, -6.0, -0.05, left),
            band(206.0, 100.0, 400.0, left),
            band(0.15, 0.08, 0.35, (-friction).exp()),
        ];
        let rad = (0.03 + 0.05 * left) * slack.sqrt() * (1.0 + 0.2 * (7.0 * t).sin());
        let phi = (angle(t) - rad, angle(t) + 0.8 * rad);
        let width = (0.05 + 1.2 * left * speed.abs().min(1.0)) * slack;
        let omega = (speed - width, speed + width);
        let measured = (angle(t) + error - 0.1, angle(t) + error + 0.1);
        let near = speed.abs() < 0.4;
        let boxes = if near {
            50
        } else {
            1 + (30.0 * left) as u64 + (noise >> 61)
        };
        history.push(&SampleRow {
            t,
            outputs: &[phi],
            measured: &[(!(4100..4300).contains(&k)).then_some(measured)],
            states: &[phi, omega],
            params: &params,
            resets: &[false, false, reset],
            modes: &[speed > -0.05, speed.abs() < 0.25, speed < 0.05],
            boxes,
            milliseconds: 0.004 * boxes as f64 * (1.0 + 0.4 * error / 0.1) + 0.002,
        })?;
    }
    Ok(history)
}

/// Two outputs, one without room for an inset; unbounded and missing bounds; a refutation.
fn odd() -> Result<History, Box<dyn Error>> {
    let param = |name: &str, prior| Parameter {
        quantity: Quantity::new(name, "1"),
        prior,
        nominal: None,
    };
    let mut history = History::new(FigureMeta {
        title: "Odd <case>".to_owned(),
        outputs: vec![
            Quantity::new("level", "m"),
            Quantity::new("a_rather_long_name", "um"),
        ],
        states: vec![Quantity::new("x", ""), Quantity::new("v", "m/s")],
        params: vec![
            param("rate", (f64::NEG_INFINITY, f64::INFINITY)),
            param("tiny", (1e-9, 4e-9)),
            param("drag", (0.0, 3e6)),
            param("g", (9.8064, 9.8068)),
        ],
        modes: vec!["free".to_owned(), "a mode with a longer name".to_owned()],
        zoom: Zoom::Window(10_003.0, 10_003.5),
        ..FigureMeta::default()
    });
    for k in 0..200 {
        let t = 1e4 + f64::from(k) * 0.05;
        let wave = (9.0 * t).sin();
        let shrink = 1.0 / (1.0 + f64::from(k) / 10.0);
        let measured = (k % 7 == 0).then_some((wave - 0.3, wave + 0.3));
        let unbounded = if k < 20 {
            (f64::NEG_INFINITY, f64::INFINITY)
        } else {
            (-shrink, shrink)
        };
        history.push(&SampleRow {
            t,
            outputs: &[(wave - 0.2, wave + 0.2), (1e-7 * wave, 1e-7 * (wave + 2.0))],
            measured: &[measured, None],
            states: &[unbounded, (-(1e9_f64.powf(shrink)), 5.0)],
            params: &[
                unbounded,
                (1e-9, 2e-9 + shrink * 2e-9),
                (0.0, 3e6 * shrink),
                (9.8064, 9.8068),
            ],
            modes: &[k % 5 != 0, k > 100],
            boxes: 3,
            milliseconds: 0.5,
            ..SampleRow::default()
        })?;
    }
    history.refute_at(1e4 + 9.5);
    Ok(history)
}

/// A needle of parameters, `|x / s| <= 1` in skewed coordinates, paved by bisection of the prior.
#[allow(clippy::indexing_slicing, reason = "there are three of each")]
fn identified() -> Identification {
    let middle = [-2.0, 200.0, 0.15];
    let size = [1e-4, 1e-2, 1.3e-6];
    // In multiples of the sizes: x + y, x - y + z, z.
    let forms = [[1.0, 0.96, 0.0], [0.05, -0.04, 0.2], [0.0, 0.3, 1.0]];
    let bounds = [0.2, 0.25, 1.0];
    let half: Vec<f64> = [1.1, 1.1, 1.3]
        .iter()
        .zip(size)
        .map(|(k, s)| k * s)
        .collect();
    let outer = |i: usize| (middle[i] - half[i] * 1.02, middle[i] + half[i] * 1.02);
    let param = |i: usize, name: &str, unit: &str, prior: (f64, f64)| ProvedParameter {
        quantity: Quantity::new(name, unit),
        prior,
        outer: Some(outer(i)),
        inner: Some((middle[i] - half[i], middle[i] + half[i])),
        tightness: 1.0201,
    };
    let params = vec![
        param(0, "alpha", "1/s", (-6.0, -0.05)),
        param(1, "beta", "1/(kg*m^2)", (1.0, 400.0)),
        param(2, "T_Fs", "N*m", (0.0, 0.3)),
    ];
    let mut tiles = Vec::new();
    let mut push = |params: &[(f64, f64)], status| {
        tiles.push(PavingTile {
            params: params.to_vec(),
            status,
        });
    };
    // The outer box first, then what is beside it, side by side.
    let mut around: Vec<(f64, f64)> = params.iter().map(|param| param.prior).collect();
    for i in 0..3 {
        let (lo, hi) = outer(i);
        let (first, last) = around[i];
        for side in [(first, lo), (hi, last)] {
            around[i] = side;
            push(&around, TileStatus::Outside);
        }
        around[i] = (lo, hi);
    }
    let mut waiting = vec![(around, 0)];
    while let Some((tile, depth)) = waiting.pop() {
        let (mut inside, mut outside) = (true, false);
        for (form, bound) in forms.iter().zip(bounds) {
            let (mut lo, mut hi) = (0.0, 0.0);
            for (k, weight) in form.iter().enumerate() {
                let ends = [tile[k].0, tile[k].1].map(|x| weight * (x - middle[k]) / size[k]);
                lo += ends[0].min(ends[1]);
                hi += ends[0].max(ends[1]);
            }
            inside &= -bound <= lo && hi <= bound;
            outside |= hi < -bound || bound < lo;
        }
        match (inside, outside) {
            (true, _) => push(&tile, TileStatus::Inside),
            (_, true) => push(&tile, TileStatus::Outside),
            _ if depth == 15 => push(&tile, TileStatus::Undecided),
            _ => {
                let (lo, hi) = tile[depth % 3];
                for half in [(lo, lo / 2.0 + hi / 2.0), (lo / 2.0 + hi / 2.0, hi)] {
                    let mut part = tile.clone();
                    part[depth % 3] = half;
                    waiting.push((part, depth + 1));
                }
            }
        }
    }
    Identification {
        title: "Drive-train rig".to_owned(),
        params,
        tiles,
    }
}

fn write(folder: &Path, history: &History, other: Option<&History>) -> Result<(), Box<dyn Error>> {
    let figures = match other {
        Some(other) => history.render_compared(other),
        None => history.render_all(),
    };
    write_figures(folder, figures)
}

fn write_figures(folder: &Path, figures: Vec<Figure>) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(folder)?;
    for figure in figures {
        fs::write(folder.join(format!("{}.svg", figure.name)), &figure.svg)?;
        fs::write(
            folder.join(format!("{}.png", figure.name)),
            png(&figure.svg)?,
        )?;
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = env::args_os()
        .nth(1)
        .map_or_else(|| PathBuf::from("target/gallery"), PathBuf::from);
    let exact = rig("exact input", 1.0)?;
    write(&folder.join("rig"), &exact, None)?;
    write(
        &folder.join("compared"),
        &exact,
        Some(&rig("with 10 % input uncertainty", 2.2)?),
    )?;
    write_figures(&folder.join("identified"), identified().render_all())?;
    write(&folder.join("odd"), &odd()?, None)?;
    write(&folder.join("empty"), &History::new(meta("empty")), None)?;
    Ok(())
}
