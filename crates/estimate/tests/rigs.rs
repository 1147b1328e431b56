//! Random rigs through the whole observer: the truth is inside some box after every sample, in all
//! four experiments of the talk.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

#[path = "../../flow/tests/common/mod.rs"]
mod common;

use common::{RigText, Rng, rig_step};
use veribound_estimate::{Method, Observer, ObserverOptions, ParameterRule, Verdict};
use veribound_flow::StepOptions;
use veribound_flow::engine::Engine;
use veribound_interval::{Decimal, Interval};
use veribound_model::{Model, Sample};

/// Error of the closed form in plain floating point, accumulated over a record.
const SLACK: f64 = 1e-9;

/// Recorded errors stay this far inside the declared bound, for the same reason: the record must
/// agree with the true parameters, not with parameters near them.
const MARGIN: f64 = 2e-9;

const BOUND: f64 = 0.1;

/// Time stamps are whole numbers of these.
const TICK: f64 = 1e-4;

#[derive(Clone, Copy, PartialEq, Debug)]
enum Experiment {
    Plain,
    Reset,
    SecondPass,
    TorqueError,
}

/// A decimal as text and the float nearest to it.
#[derive(Clone)]
struct Number(String, f64);

fn number(x: f64, digits: usize) -> Number {
    let text = format!("{x:.digits$}");
    let value = text.parse().unwrap();
    Number(text, value)
}

/// What is recorded at one instant, apart from the measured angle.
struct Row {
    ticks: i64,
    torque: Number,
    measured: bool,
    still: Option<bool>,
    /// Angle, velocity and parameters from this instant on.
    truth: [f64; 5],
}

struct Case {
    model: Model,
    rows: Vec<Row>,
    resets: u32,
    stops: u32,
}

/// Draws the recorded torque, sample after sample.
struct Torque {
    kind: usize,
    left: usize,
    place: f64,
    step: f64,
}

impl Torque {
    fn next(&mut self, rng: &mut Rng, level: f64, w: f64) -> Number {
        if self.left == 0 {
            self.kind = rng.below(10);
            self.left = 1 + rng.below(40);
            self.place = rng.pick(&[-1.0, 1.0]);
            self.step = 2.6 / self.left as f64 * rng.pick(&[1.0, 0.5, 0.1]);
            if self.kind == 3 {
                self.place *= -1.3;
                self.step *= -self.place.signum();
            }
        }
        self.left -= 1;
        let sign = self.place.signum();
        match self.kind {
            0 => number(sign * level * rng.pick(&[0.999, 1.001]), 9),
            1 => number(sign * level, 6),
            2 => number(sign * level + rng.pick(&[-1e-9, 1e-9]), 9),
            3 => {
                self.place += self.step;
                number(self.place * level, 9)
            }
            4 => number(0.0, 1),
            5 => number(sign * (level + 0.1), 6),
            6 => number(rng.between(-2.0, 2.0) * level, 9),
            7 => number(-w.signum() * (level + 0.05), 6),
            8 => number(sign * level * 0.5, 9),
            _ => number(sign * (level + 0.03), 6),
        }
    }
}

/// `[lo, hi]` in the file around the true value: wide, thin, a point, or with the truth at an end.
fn prior(rng: &mut Rng, truth: &Number, lo: f64, hi: f64) -> [String; 2] {
    let below = rng.between(lo, truth.1);
    let above = rng.between(truth.1, hi);
    let floor = |x: f64| format!("{:.6}", (x * 1e6).floor() * 1e-6);
    let ceil = |x: f64| format!("{:.6}", (x * 1e6).ceil() * 1e-6);
    match rng.below(8) {
        0 => [truth.0.clone(), ceil(above)],
        1 => [floor(below), truth.0.clone()],
        2 => [truth.0.clone(), truth.0.clone()],
        3 | 4 => [floor(below), ceil(above)],
        _ => [format!("{lo}"), format!("{hi}")],
    }
}

fn case(rng: &mut Rng, experiment: Experiment) -> Case {
    let alpha = number(-(0.05 * 119.0_f64.powf(rng.unit())), 5);
    let beta = number(2.0 * 190.0_f64.powf(rng.unit()), 4);
    let level = number(rng.between(0.0, 0.3), 6);
    let phi = number(rng.between(-0.2, 0.2), 4);
    let omega = number(
        if rng.chance(0.6) {
            0.0
        } else {
            rng.between(-1.0, 1.0)
        },
        4,
    );
    let torque_error = experiment == Experiment::TorqueError;
    let mut text = RigText {
        explicit: rng.chance(0.5),
        phi: prior(rng, &phi, -0.2, 0.2),
        omega: if rng.chance(0.5) {
            [omega.0.clone(), omega.0.clone()]
        } else {
            prior(rng, &omega, -1.0, 1.0)
        },
        alpha: prior(rng, &alpha, -6.0, -0.05),
        beta: prior(rng, &beta, 1.0, 400.0),
        level: prior(rng, &level, 0.0, 0.3),
        input_error: if torque_error {
            "{ relative = 0.1 }"
        } else {
            "{ relative = 0 }"
        },
        ..RigText::default()
    };
    // Latency and shortest standstill, in ticks.
    let latency = rng.pick(&[0, 200, 300]);
    let lasts = rng.pick(&[0, 500, 2000]);
    let seconds = |ticks: i64| -> &'static str {
        match ticks {
            0 => "0",
            200 => "0.02",
            300 => "0.03",
            500 => "0.05",
            _ => "0.2",
        }
    };
    let signal = experiment == Experiment::Reset || rng.chance(0.4);
    if signal {
        let resets = (experiment == Experiment::Reset).then_some(seconds(lasts));
        text.still = Some((seconds(latency), resets));
    }
    let model = text.model();
    let range = model.params[2].bounds;

    let mut rows: Vec<Row> = Vec::new();
    let mut p = [alpha.1, beta.1, level.1];
    let (mut x, mut w) = (phi.1, omega.1);
    let mut ticks = rng.below(5000) as i64;
    let mut torque = Torque {
        kind: 0,
        left: 0,
        place: 0.0,
        step: 0.0,
    };
    let (mut resets, mut stops) = (0, 0);
    let mut since: Option<i64> = None;
    let steady = rng.chance(0.5);
    for k in 0..150 + rng.below(251) {
        let still = signal
            .then_some(w == 0.0 && !rng.chance(0.02))
            .filter(|_| !rng.chance(0.01));
        since = (still == Some(true)).then(|| since.unwrap_or(ticks));
        if experiment == Experiment::Reset
            && since.is_some_and(|since| ticks - since >= lasts)
            && rng.chance(0.3)
        {
            let new = rng.inside(range);
            p[2] = if rng.chance(0.2) {
                new
            } else {
                number(new, 6).1
            };
            p[2] = p[2].clamp(range.lo(), range.hi());
            resets += 1;
        }
        let recorded = torque.next(rng, p[2], w);
        rows.push(Row {
            ticks,
            torque: recorded.clone(),
            measured: !rng.chance(0.1),
            still,
            truth: [x, w, p[0], p[1], p[2]],
        });
        let dt = if steady {
            100
        } else {
            rng.pick(&[100, 100, 20 + (k % 300) as i64, 1, 700])
        };
        ticks += dt;
        let pieces = if torque_error { 1 + rng.below(3) } else { 1 };
        let moving = w != 0.0;
        for _ in 0..pieces {
            let reach = 0.1 - 1e-9;
            let u = if torque_error {
                recorded.1 * (1.0 + rng.pick(&[-reach, reach, rng.clone().between(-reach, reach)]))
            } else {
                recorded.1
            };
            (x, w) = rig_step(x, w, u, p, dt as f64 * TICK / pieces as f64);
        }
        stops += u32::from(moving && w == 0.0);
    }
    // A signal may come early by its latency, if the standstill has begun when that is over.
    for k in 1..rows.len() {
        let starts = rows[k].truth[1] == 0.0 && rows[k].still == Some(true);
        if starts && rows[k - 1].truth[1] != 0.0 && rng.chance(0.5) {
            for j in (0..k).rev() {
                let follows = j > 0 && rows[j - 1].still == Some(true);
                if rows[j].truth[1] == 0.0 || follows || rows[k].ticks - rows[j].ticks > latency {
                    break;
                }
                rows[j].still = Some(true);
            }
        }
    }
    Case {
        model,
        rows,
        resets,
        stops,
    }
}

/// Lengths of the stretches of the past that are remembered.
fn windows(rng: &mut Rng) -> Vec<u64> {
    let lists: [&[u64]; 6] = [&[], &[1], &[2, 3], &[4, 16, 64], &[1000], &[7, 1, 7]];
    rng.pick(&lists).to_vec()
}

fn random_options(rng: &mut Rng) -> ObserverOptions {
    ObserverOptions {
        boxes: 1 + rng.below(rng.clone().pick(&[8, 30, 60])),
        bisections: rng.below(25),
        every: 1 + rng.below(20),
        epsilon: rng.pick(&[1e-3, 0.0, 1e-9, 0.1]),
        trisect: rng.chance(0.5),
        parameter_rule: rng.pick(&[
            ParameterRule::WidestTerm,
            ParameterRule::OverlappingTerms,
            ParameterRule::WidestInfluence,
        ]),
        merge_across_modes: rng.chance(0.3),
        windows: windows(rng),
        velocity_horizon: rng.pick(&[2.0, 0.0, 100.0]),
        method: if rng.chance(0.15) {
            Method::Polytope
        } else {
            Method::Boxes
        },
        rows: rng.pick(&[2, 16, 64]),
        replay: rng.pick(&[1, 8]),
        history: rng.pick(&[30, 20_000]),
        budget: rng.pick(&[1, 20_000, 300_000, 1_000_000]),
        step: StepOptions {
            order: 1 + rng.below(6),
            ..StepOptions::default()
        },
        ..ObserverOptions::default()
    }
}

/// How measurement errors are chosen, all within the bound.
fn error(kind: usize, k: usize, truth: f64, seen: Option<Interval>, rng: &mut Rng) -> f64 {
    let reach = BOUND - MARGIN;
    match kind {
        0 => rng.between(-reach, reach),
        1 => reach,
        2 => -reach,
        3 => reach * if k.is_multiple_of(2) { 1.0 } else { -1.0 },
        4 => rng.pick(&[-reach, reach]),
        5 => 0.0,
        // Against the estimate: the truth is at the end that the estimate favours least.
        _ => match seen {
            Some(seen) if seen.mid() < truth => -reach,
            _ => reach,
        },
    }
}

fn assert_inside(observer: &Observer, truth: &[f64; 5], story: &str) {
    let inside = observer.cells().iter().any(|cell| {
        cell.z.iter().zip(truth).enumerate().all(|(i, (z, x))| {
            let slack = if i < 2 { SLACK * (1.0 + x.abs()) } else { 0.0 };
            z.lo() - slack <= *x && *x <= z.hi() + slack
        })
    });
    assert!(inside, "{story}: {truth:?} lost; {:?}", observer.cells());
}

/// One pass of the observer over the record; returns the number of samples.
fn observe(observer: &mut Observer, case: &Case, noise: usize, rng: &mut Rng, story: &str) -> u64 {
    let mut seen = None;
    let model = &case.model;
    for (k, row) in case.rows.iter().enumerate() {
        let decimal = |text: &str| Decimal::parse(text).unwrap();
        let recorded = number(row.truth[0] + error(noise, k, row.truth[0], seen, rng), 12);
        let torque = decimal(&row.torque.0).to_interval();
        let angle = decimal(&recorded.0).to_interval();
        let sample = Sample {
            time: decimal(&format!("{}.{:04}", row.ticks / 10_000, row.ticks % 10_000)),
            inputs: vec![model.inputs[0].error.enclose(torque)],
            outputs: vec![row.measured.then(|| model.outputs[0].error.enclose(angle))],
            signals: model.signals.iter().map(|_| row.still).collect(),
            line: k + 2,
        };
        let story = format!("{story} sample {k}");
        match observer.step(&sample).unwrap() {
            Verdict::Consistent(estimate) => seen = Some(estimate.states[0]),
            other => panic!("{story}: truth {:?}: {other:?}", row.truth),
        }
        assert_inside(observer, &row.truth, &story);
    }
    case.rows.len() as u64
}

fn run(experiment: Experiment, rigs: u64, seed: u64) {
    let (mut samples, mut resets, mut stops, mut worst) = (0, 0, 0, 0);
    for rig in 0..rigs {
        let mut rng = Rng(seed * 1_000_003 + rig);
        let case = case(&mut rng, experiment);
        let options = random_options(&mut rng);
        let noise = rng.below(7);
        let story = format!("{experiment:?} rig {rig} (seed {seed}) noise {noise} {options:?}");
        let mut observer = Observer::new(&case.model, options);
        samples += observe(&mut observer, &case, noise, &mut rng, &story);
        worst = worst.max(observer.boxes_max());
        let second =
            experiment == Experiment::SecondPass || experiment == Experiment::Reset && rig % 3 == 0;
        if second {
            let boxes: Vec<Vec<Interval>> = observer
                .cells()
                .iter()
                .map(|cell| cell.z[2..].to_vec())
                .collect();
            let mut again = Observer::new(&case.model, random_options(&mut rng));
            assert!(again.start_from(&boxes), "{story}: nothing to start from");
            samples += observe(
                &mut again,
                &case,
                noise,
                &mut rng,
                &format!("{story} again"),
            );
        }
        resets += case.resets;
        stops += case.stops;
    }
    println!(
        "{experiment:?}: {rigs} rigs, {samples} samples, {stops} stops, {resets} resets, {worst} boxes"
    );
    assert!(
        u64::from(stops) > rigs,
        "the rigs stop too rarely to mean anything"
    );
    assert!(experiment != Experiment::Reset || u64::from(resets) > rigs);
}

fn rigs() -> u64 {
    std::env::var("ATTACK_RIGS").map_or(125, |n| n.parse().unwrap())
}

fn seed() -> u64 {
    std::env::var("ATTACK_SEED").map_or(1, |n| n.parse().unwrap())
}

/// Boxes that an engine moves besides keep the truth in all four experiments.
#[test]
fn engines_besides_boxes() {
    let engines = [Engine::Forms, Engine::Closed, Engine::Comparison];
    let experiments = [
        Experiment::Plain,
        Experiment::Reset,
        Experiment::SecondPass,
        Experiment::TorqueError,
    ];
    for (number, engine) in engines.into_iter().enumerate() {
        for (of, experiment) in experiments.into_iter().enumerate() {
            for rig in 0..rigs().div_ceil(125) {
                let mut rng = Rng(seed() * 77_777 + 100 * rig + 10 * number as u64 + of as u64);
                let case = case(&mut rng, experiment);
                let options = ObserverOptions {
                    boxes: 1 + rng.below(3),
                    bisections: rng.below(4),
                    engine,
                    ..random_options(&mut rng)
                };
                let noise = rng.below(7);
                let story = format!("{experiment:?} rig {rig} noise {noise} {options:?}");
                let mut observer = Observer::new(&case.model, options);
                observe(&mut observer, &case, noise, &mut rng, &story);
            }
        }
    }
}

/// What forms keep from sample to sample narrows parameters more than boxes can, as many as there are.
#[test]
fn dependence_narrows_parameters() {
    let mut rng = Rng(5);
    let mut ratios = Vec::new();
    for _ in 0..6 {
        let case = case(&mut rng, Experiment::Plain);
        let width = |engine: Engine| {
            let options = ObserverOptions {
                boxes: 6,
                bisections: 3,
                engine,
                ..ObserverOptions::default()
            };
            let mut observer = Observer::new(&case.model, options);
            observe(&mut observer, &case, 0, &mut Rng(9), "dependence");
            let widths = (2..5).map(|i| {
                let of = |acc: Interval, cell: &veribound_estimate::Cell| acc.hull(cell.z[i]);
                let known = observer.cells().iter().fold(Interval::EMPTY, of).width();
                let prior = case.model.params[i - 2].bounds.width();
                if prior > 0.0 { known / prior } else { 1.0 }
            });
            widths.product::<f64>()
        };
        ratios.push(width(Engine::Forms) / width(Engine::Boxes));
    }
    println!("{ratios:?}");
    let mean = ratios.iter().map(|x| x.ln()).sum::<f64>() / ratios.len() as f64;
    assert!(mean.exp() < 0.9, "{ratios:?}");
}

#[test]
fn plain() {
    run(Experiment::Plain, rigs(), seed());
}

#[test]
fn reset_at_standstill() {
    run(Experiment::Reset, rigs(), seed());
}

#[test]
fn second_pass() {
    run(Experiment::SecondPass, rigs(), seed());
}

#[test]
fn torque_error_of_ten_percent() {
    run(Experiment::TorqueError, rigs(), seed());
}
