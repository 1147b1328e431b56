//! Pendulum with dry friction, and a stick-slip oscillator on a moving belt (BM16): the truth is
//! inside some box after every sample.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

#[path = "../../flow/tests/common/mod.rs"]
mod common;

use common::models::{BELT, CHAIN, PENDULUM, Target};
use common::truth::{Events, Sim};
use common::{Rng, read};
use veribound_estimate::{Method, Observer, ObserverOptions, ParameterRule, Verdict};
use veribound_flow::StepOptions;
use veribound_interval::{Decimal, Interval};
use veribound_model::Sample;

/// Far above the error of the simulator in `common::truth` over a few seconds.
const SLACK: f64 = 1e-7;

struct Record<'a> {
    target: &'a Target,
    /// Range of every state at the start, and of every parameter: the priors.
    start: &'a [(f64, f64)],
    priors: &'a [(f64, f64)],
    bound: f64,
    /// Milliseconds between samples.
    period: i64,
    samples: usize,
}

fn options(rng: &mut Rng) -> ObserverOptions {
    ObserverOptions {
        boxes: 1 + rng.below(30),
        bisections: rng.below(15),
        every: 1 + rng.below(10),
        epsilon: rng.pick(&[1e-3, 1e-9]),
        trisect: rng.chance(0.5),
        parameter_rule: rng.pick(&[
            ParameterRule::WidestTerm,
            ParameterRule::OverlappingTerms,
            ParameterRule::WidestInfluence,
        ]),
        merge_across_modes: rng.chance(0.3),
        method: rng.pick(&[Method::Boxes, Method::Boxes, Method::Polytope]),
        windows: match rng.below(4) {
            0 => Vec::new(),
            1 => vec![1, 3],
            2 => vec![500],
            _ => vec![4, 16, 64],
        },
        step: StepOptions {
            order: 1 + rng.below(6),
            ..StepOptions::default()
        },
        ..ObserverOptions::default()
    }
}

/// A prior around the truth: the whole range, a part of it, or a point.
fn prior(rng: &mut Rng, truth: f64, (lo, hi): (f64, f64)) -> Interval {
    let (below, above) = (rng.between(lo, truth), rng.between(truth, hi));
    let (lo, hi) = match rng.below(6) {
        0 => (truth, above),
        1 => (below, truth),
        2 => (truth, truth),
        3 => (lo, hi),
        _ => (below, above),
    };
    Interval::new(lo, hi).unwrap()
}

/// Observes `runs` random systems; returns the events of the truths.
fn observe(record: &Record<'_>, runs: u64, seed: u64) -> Events {
    let target = record.target;
    let mut events = Events::default();
    let mut ends = [0_u32; 2];
    for run in 0..runs {
        let mut rng = Rng(seed * 1_000_003 + run);
        let mut model = read(target.name, target.text);
        let draw = |rng: &mut Rng, (lo, hi): (f64, f64)| match rng.below(8) {
            0 => lo,
            1 => hi,
            _ => rng.between(lo, hi),
        };
        let x: Vec<f64> = record.start.iter().map(|r| draw(&mut rng, *r)).collect();
        let p: Vec<f64> = record.priors.iter().map(|r| draw(&mut rng, *r)).collect();
        for ((state, x), range) in model.states.iter_mut().zip(&x).zip(record.start) {
            state.init = prior(&mut rng, *x, *range);
        }
        for ((param, p), range) in model.params.iter_mut().zip(&p).zip(record.priors) {
            param.bounds = prior(&mut rng, *p, *range);
        }
        let mut sim = Sim::new(target.truth, &x, &p);
        let options = options(&mut rng);
        let noise = rng.below(6);
        let story = format!(
            "{} run {run} seed {seed} noise {noise} {options:?}",
            target.name
        );
        let mut observer = Observer::new(&model, options);
        let mut milliseconds = 0_i64;
        let mut torque = 0.0;
        let mut seen: Option<Interval> = None;
        for k in 0..record.samples {
            let reach = record.bound - 2.0 * SLACK;
            let y = if target.name == CHAIN.name {
                sim.x[2]
            } else {
                sim.x[0]
            };
            let error = match noise {
                0 => rng.between(-reach, reach),
                1 => reach,
                2 => -reach,
                3 => reach * if k % 2 == 0 { 1.0 } else { -1.0 },
                4 => 0.0,
                _ if seen.is_some_and(|seen| seen.mid() < y) => -reach,
                _ => reach,
            };
            let decimal = |text: String| Decimal::parse(&text).unwrap();
            let recorded = decimal(format!("{:.12}", y + error)).to_interval();
            if rng.chance(0.05) {
                torque = rng.pick(&[-2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5]);
            }
            let measured = !rng.chance(0.1);
            let sample = Sample {
                time: decimal(format!(
                    "{}.{:03}",
                    milliseconds / 1000,
                    milliseconds % 1000
                )),
                inputs: model
                    .inputs
                    .iter()
                    .map(|_| Interval::point(torque))
                    .collect(),
                outputs: vec![measured.then(|| model.outputs[0].error.enclose(recorded))],
                signals: Vec::new(),
                line: k + 2,
            };
            match observer.step(&sample).unwrap() {
                Verdict::Consistent(estimate) => seen = estimate.outputs.first().copied(),
                // Wide boxes may become too wide to integrate: that proves nothing wrong.
                Verdict::Undecided(_) => {
                    ends[1] += 1;
                    break;
                }
                other => panic!("{story} sample {k}: {:?} {p:?}: {other:?}", sim.x),
            }
            let inside = observer.cells().iter().any(|cell| {
                let (z, q) = cell.z.split_at(x.len());
                let near = |(z, x): (&Interval, &f64)| z.lo() - SLACK <= *x && *x <= z.hi() + SLACK;
                z.iter().zip(&sim.x).all(near) && q.iter().zip(&p).all(|(q, p)| q.contains(*p))
            });
            assert!(
                inside,
                "{story} sample {k}: {:?} {p:?} lost: {:?}",
                sim.x,
                observer.cells()
            );
            let dt = record.period
                + if rng.chance(0.1) {
                    rng.below(20) as i64
                } else {
                    0
                };
            milliseconds += dt;
            let u = vec![torque; model.inputs.len()];
            sim.advance(&u, dt as f64 * 1e-3, &mut rng);
            if k + 1 == record.samples {
                ends[0] += 1;
            }
        }
        events.add(sim.events);
    }
    println!(
        "{}: {ends:?} runs whole, undecided; {events:?}",
        target.name
    );
    assert!(
        ends[0] > 4 * ends[1],
        "{}: undecided too often",
        target.name
    );
    events
}

fn seed() -> u64 {
    std::env::var("ATTACK_SEED").map_or(1, |n| n.parse().unwrap())
}

fn runs(default: u64) -> u64 {
    std::env::var("ATTACK_RUNS").map_or(default, |n| n.parse().unwrap())
}

#[test]
fn belt() {
    let record = Record {
        target: &BELT,
        start: &[(0.6, 1.05), (-0.2, 0.4)],
        priors: &[(0.8, 1.2), (0.05, 0.15), (0.25, 0.4)],
        bound: 0.005,
        period: 15,
        samples: 700,
    };
    let events = observe(&record, runs(24), seed());
    assert!(events.captures > 15 && events.releases > 15);
}

#[test]
fn pendulum() {
    let record = Record {
        target: &PENDULUM,
        start: &[(-1.2, 1.2), (-0.5, 0.5)],
        priors: &[(25.0, 45.0), (-0.05, 0.05), (0.0, 0.5), (0.0, 1.0)],
        bound: 0.003,
        period: 10,
        samples: 300,
    };
    let events = observe(&record, runs(30), seed());
    assert!(events.crossings > 100 && events.captures > 3);
}

/// Two friction elements that hold and release each other, driven by steps of the force.
#[test]
fn chain() {
    let record = Record {
        target: &CHAIN,
        start: &[(-0.01, 0.01), (0.0, 0.0), (-0.01, 0.01), (0.0, 0.0)],
        priors: &[(30.0, 60.0), (0.5, 2.0), (0.3, 0.8), (0.2, 0.6)],
        bound: 0.005,
        period: 10,
        samples: 200,
    };
    let events = observe(&record, runs(20), seed());
    assert!(events.captures > 15 && events.releases > 15);
}
