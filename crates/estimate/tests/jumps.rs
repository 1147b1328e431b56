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
use common::{Rng, interval, number, read};
use veribound_estimate::identify::{Conclusion, IdentifyOptions, identify};
use veribound_estimate::{Method, Observer, ObserverOptions, Verdict};
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

/// A random record of a system, with what is true of it.
struct Record {
    model: Model,
    samples: Vec<Sample>,
    /// States at every sample, before or after a jump there.
    states: Vec<Vec<f64>>,
    /// States when it begins.
    start: Vec<f64>,
    params: Vec<f64>,
    events: Events,
}

fn record(target: &Jumping, rng: &mut Rng) -> Record {
    let mut model = measured(target);
    let around = |rng: &mut Rng, truth: f64, range: (f64, f64), share: f64| {
        let reach = share * (range.1 - range.0);
        let (below, above) = (rng.unit() * reach, rng.unit() * reach);
        interval(truth - below, truth + above)
    };
    let share = rng.pick(&[0.0, 0.05, 0.2]);
    let mut start = Vec::new();
    for (state, range) in model.states.iter_mut().zip(target.start) {
        let x = rng.inside(interval(range.0, range.1));
        state.init = around(rng, x, *range, share);
        start.push(x);
    }
    let mut params = Vec::new();
    for (param, range) in model.params.iter_mut().zip(target.params) {
        let p = rng.inside(interval(range.0, range.1));
        param.bounds = around(rng, p, *range, share);
        params.push(p);
    }
    let period = rng.pick(&[10_i64, 25, 50]);
    let bound = rng.pick(&[0.01, 0.1]);
    let mut sim = Sim::new(target.hybrid, &start, &params, &[]);
    let mut inputs: Vec<f64> = Vec::new();
    let (mut samples, mut states) = (Vec::new(), Vec::new());
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
            let unit = rng.between(-1.0, 1.0);
            let y = x + reach * rng.pick(&[unit, unit, -1.0, 1.0]);
            rng.chance(0.7).then(|| interval(y - bound, y + bound))
        });
        samples.push(Sample {
            time: Decimal::parse(&format!("{}e-3", k * period)).unwrap(),
            outputs: outputs.collect(),
            inputs: inputs.iter().map(|u| Interval::point(*u)).collect(),
            signals: Vec::new(),
            line: 0,
        });
        states.push(sim.x.clone());
        sim.advance(0.001 * period as f64, rng);
    }
    Record {
        model,
        samples,
        states,
        start,
        params,
        events: sim.events,
    }
}

fn random_options(rng: &mut Rng) -> ObserverOptions {
    ObserverOptions {
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
    }
}

/// Observes a record; tells whether the observer came to its end.
fn observe(record: &Record, options: ObserverOptions, story: &str) -> bool {
    let mut observer = Observer::new(&record.model, options);
    for (k, (sample, states)) in record.samples.iter().zip(&record.states).enumerate() {
        match observer.step(sample).unwrap() {
            Verdict::Consistent(_) => {}
            Verdict::Inconsistent(refutation) => {
                panic!("{story}, sample {k}: {states:?} is refuted: {refutation:?}")
            }
            Verdict::Undecided(_) => return false,
        }
        let near = interval(-SLACK, SLACK);
        let truth: Vec<f64> = states.iter().chain(&record.params).copied().collect();
        let found = observer.cells().iter().any(|cell| {
            let mut each = cell.z.iter().zip(&truth);
            each.all(|(z, x)| (*z + near).contains(*x))
        });
        assert!(
            found,
            "{story}, sample {k}: {truth:?} is in no box: {:?}",
            observer.cells().iter().map(|c| &c.z).collect::<Vec<_>>()
        );
    }
    true
}

#[test]
fn the_truth_is_never_lost() {
    for target in ALL {
        let (mut events, mut undecided) = (Events::default(), 0);
        let runs = number("VERIBOUND_ROUNDS", 60);
        for seed in 0..runs {
            let mut rng = Rng(seed);
            let record = record(target, &mut rng);
            let options = random_options(&mut rng);
            let is_whole = observe(&record, options, &format!("{} {seed}", target.name));
            undecided += u64::from(!is_whole);
            events.add(record.events);
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

/// Whatever sets are put aside where states jump, and however few rows are kept.
#[test]
fn polytopes_lose_no_truth() {
    for target in ALL {
        for seed in 0..number("VERIBOUND_ROUNDS", 8) {
            let mut rng = Rng(seed ^ 0x9a_77);
            let record = record(target, &mut rng);
            let options = ObserverOptions {
                method: Method::Polytope,
                rows: rng.pick(&[2, 64]),
                replay: rng.pick(&[1, 8]),
                history: rng.pick(&[3, 20_000]),
                budget: rng.pick(&[1, 10_000, 100_000, 1_000_000]),
                ..random_options(&mut rng)
            };
            observe(&record, options, &format!("{} {seed}", target.name));
        }
    }
}

/// Identification of systems that jump excludes neither what is true nor where it began.
#[test]
fn identification_loses_no_truth() {
    for target in ALL {
        let (mut narrower, mut consistent) = (0, 0);
        for seed in 0..number("VERIBOUND_ROUNDS", 3) {
            let mut rng = Rng(seed ^ 0x51_d4);
            let record = record(target, &mut rng);
            let options = IdentifyOptions {
                sets: 1,
                threads: 1,
                ..IdentifyOptions::default()
            };
            let Record { model, samples, .. } = &record;
            let samples = std::slice::from_ref(samples);
            let found = identify(model, samples, &options, &|_| true);
            let story = format!("{} {seed}: {:?} {found:?}", target.name, record.params);
            assert!(
                !matches!(found.conclusion, Conclusion::Inconsistent(_)),
                "{story}"
            );
            let near = |bounds: Interval, x: f64| bounds.inflate(SLACK).contains(x);
            for ((bounds, x), param) in found.params.iter().zip(&record.params).zip(&model.params) {
                assert!(near(bounds.outer, *x), "{story}");
                narrower += u64::from(bounds.outer.width() < 0.9 * param.bounds.width());
            }
            for (bounds, x) in found.starts[0].iter().zip(&record.start) {
                assert!(near(bounds.outer, *x), "{story}: {:?}", record.start);
            }
            consistent += u64::from(found.conclusion == Conclusion::Consistent);
        }
        println!(
            "{}: {consistent} consistent, {narrower} narrower",
            target.name
        );
    }
}
