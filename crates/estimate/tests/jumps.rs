//! The truth stays in some box of the observer where states jump: at impacts, at switches of memories, at
//! samples at which an input is a new one.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

#[path = "../../flow/tests/common/mod.rs"]
mod common;

use common::hybrid::{Events, Sim};
use common::jumping::{ALL, Jumping};
use common::{Rng, interval, read};
use veribound_estimate::{Observer, ObserverOptions, Verdict};
use veribound_flow::StepOptions;
use veribound_interval::{Decimal, Interval};
use veribound_model::{ErrorBound, Model, Output, Sample, Var};

/// How far true solutions are wrong, at most.
const SLACK: f64 = 2e-6;

/// The model, every state of it measured.
fn measured(target: &Jumping) -> Model {
    let mut model = read(target.name, target.text);
    let zero = Decimal::parse("0").unwrap();
    model.outputs = (0..model.states.len())
        .map(|state| Output {
            name: format!("y{state}"),
            unit: String::new(),
            column: None,
            expr: model.graph.var(Var::State(state)),
            error: ErrorBound {
                absolute: zero.clone(),
                relative: zero.clone(),
            },
            outliers: None,
        })
        .collect();
    model
}

/// Observes one random record; how often the observer stopped undecided is counted.
fn observe(target: &Jumping, seed: u64, undecided: &mut u64) -> Events {
    let mut rng = Rng(seed);
    let mut model = measured(target);
    let around = |rng: &mut Rng, truth: f64, range: (f64, f64), share: f64| {
        let reach = share * (range.1 - range.0);
        let (below, above) = (rng.unit() * reach, rng.unit() * reach);
        interval(truth - below, truth + above)
    };
    let share = rng.pick(&[0.0, 0.05, 0.2]);
    let mut x = Vec::new();
    for (state, range) in model.states.iter_mut().zip(target.start) {
        x.push(rng.inside(interval(range.0, range.1)));
        state.init = around(&mut rng, x[x.len() - 1], *range, share);
    }
    let mut p = Vec::new();
    for (param, range) in model.params.iter_mut().zip(target.params) {
        p.push(rng.inside(interval(range.0, range.1)));
        param.bounds = around(&mut rng, p[p.len() - 1], *range, share);
    }
    let options = ObserverOptions {
        boxes: 1 + rng.below(8),
        bisections: rng.below(5),
        every: 1 + rng.below(4),
        windows: match rng.below(3) {
            0 => Vec::new(),
            1 => vec![1, 2],
            _ => vec![3, 8],
        },
        step: StepOptions {
            order: 1 + rng.below(3),
            ..StepOptions::default()
        },
        ..ObserverOptions::default()
    };
    let period = rng.pick(&[10_i64, 25, 50]);
    let bound = rng.pick(&[0.01, 0.1]);
    let mut sim = Sim::new(target.hybrid, &x, &p, &[]);
    let mut observer = Observer::new(&model, options);
    let mut inputs: Vec<f64> = Vec::new();
    for k in 0..15 {
        if k == 0 || rng.chance(0.4) {
            let of = |range: &(f64, f64)| rng.between(range.0, range.1);
            inputs = target.inputs.iter().map(of).collect();
        }
        sim.u.clone_from(&inputs);
        // What is measured is the state before or after a jump at the sample.
        if rng.chance(0.5) {
            sim.jump_at_once();
        }
        let outputs = sim.x.iter().map(|x| {
            let reach = bound - 2.0 * SLACK;
            let y = x + rng.between(-reach, reach);
            rng.chance(0.7).then(|| interval(y - bound, y + bound))
        });
        let sample = Sample {
            time: Decimal::parse(&format!("{}e-3", k * period)).unwrap(),
            outputs: outputs.collect(),
            inputs: inputs.iter().map(|u| Interval::point(*u)).collect(),
            signals: Vec::new(),
            line: 0,
        };
        match observer.step(&sample).unwrap() {
            Verdict::Consistent(_) => {}
            Verdict::Inconsistent(refutation) => panic!(
                "{} {seed}, sample {k}: {:?} is refuted: {refutation:?}",
                target.name, sim.x
            ),
            Verdict::Undecided(_) => {
                *undecided += 1;
                return sim.events;
            }
        }
        let near = interval(-SLACK, SLACK);
        let truth: Vec<f64> = sim.x.iter().chain(&p).copied().collect();
        let found = observer.cells().iter().any(|cell| {
            let mut each = cell.z.iter().zip(&truth);
            each.all(|(z, x)| (*z + near).contains(*x))
        });
        assert!(
            found,
            "{} {seed}, sample {k}: {truth:?} is in no box: {:?}",
            target.name,
            observer.cells().iter().map(|c| &c.z).collect::<Vec<_>>()
        );
        sim.advance(0.001 * period as f64, &mut rng);
    }
    sim.events
}

#[test]
fn the_truth_is_never_lost() {
    for target in ALL {
        let (mut events, mut undecided) = (Events::default(), 0);
        let runs = 40;
        for seed in 0..runs {
            events.add(observe(target, seed, &mut undecided));
        }
        println!("{}: {events:?}, {undecided} undecided", target.name);
        assert!(events.jumps >= 10, "{}: {events:?}", target.name);
        assert!(
            undecided <= runs / 3,
            "{}: {undecided} undecided",
            target.name
        );
    }
}
