//! Motors that rest and break away while samples pass, under torques that rise slowly, fall again and turn: the truth is never lost, with a signal
//! of rest and without, where friction is another after a rest, too; and proved points agree with exact solutions.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

#[path = "../../flow/tests/common/mod.rs"]
mod common;

use common::{Rng, number, read, rig_step};
use veribound_estimate::identify::{Conclusion, IdentifyOptions, identify};
use veribound_estimate::{Method, Observer, ObserverOptions, Verdict};
use veribound_interval::{Decimal, Interval};
use veribound_model::Sample;

/// A record, with parameters and states at every sample.
struct Record {
    samples: Vec<Sample>,
    params: Vec<[f64; 3]>,
    states: Vec<[f64; 2]>,
}

fn decimal(x: f64, digits: usize) -> Decimal {
    Decimal::parse(&format!("{x:.digits$}")).unwrap()
}

/// Torques rise slowly from rest, fall again, and turn.
fn draw(
    rng: &mut Rng,
    mut p: [f64; 3],
    noise: f64,
    (tells_rest, levels): (bool, &[f64]),
) -> Record {
    let (mut x, mut v, mut u, mut rested) = (0.0, 0.0, 0.5 * p[2], 0);
    let mut way = rng.pick(&[1.0, -1.0]);
    let mut rise = rng.between(0.002, 0.02);
    let mut record = Record {
        samples: Vec::new(),
        params: Vec::new(),
        states: Vec::new(),
    };
    for k in 0..150 + rng.below(150) {
        rested = if v == 0.0 { rested + 1 } else { 0 };
        if rested > 10 && !levels.is_empty() && rng.below(3) == 0 {
            p[2] = rng.pick(levels);
        }
        let level = ((way * u) * 1e4_f64).round() / 1e4;
        let unit = rng.between(-1.0, 1.0);
        let error = 0.999 * noise * rng.pick(&[-1.0, 1.0, unit]);
        let output = decimal(x + error, 9).to_interval().inflate(noise);
        record.samples.push(Sample {
            time: decimal(k as f64 * 0.01, 2),
            inputs: vec![decimal(level, 4).to_interval()],
            outputs: vec![(!rng.chance(0.05)).then_some(output)],
            signals: vec![Some(v == 0.0); usize::from(tells_rest)],
            line: k + 2,
        });
        record.params.push(p);
        record.states.push([x, v]);
        (x, v) = rig_step(x, v, level, p, 0.01);
        u += rise * rng.between(0.2, 1.8);
        if v != 0.0 && rng.chance(0.1) || u > 1.6 * p[2] {
            match rng.below(4) {
                0 => u = p[2] * rng.between(0.7, 1.0),
                1 => (way, u) = (-way, p[2] * rng.between(0.5, 1.3)),
                2 => rise = -rise.abs(),
                _ => u = 0.0,
            }
        }
        if u < 0.3 * p[2] {
            rise = rng.between(0.002, 0.02);
            u = p[2] * rng.between(0.6, 0.99);
        }
    }
    record
}

#[test]
fn the_truth_is_never_lost() {
    let seed = number("VERIBOUND_SEED", 41);
    let (mut narrowed, mut points, mut all) = (0, 0, 0);
    for round in 0..number("VERIBOUND_ROUNDS", 3) {
        let mut rng = Rng(seed * 1_000_003 + round);
        let rng = &mut rng;
        let p = [
            -rng.between(1.0, 3.0),
            rng.between(100.0, 200.0),
            rng.between(0.08, 0.2),
        ];
        let (tells_rest, resets) = rng.pick(&[(false, false), (true, false), (true, true)]);
        let wide = rng.pick(&[0.05, 0.2, 0.4]);
        let below = rng.unit();
        let list = |x: f64, wide: f64| {
            let (a, b) = (x * (1.0 - wide * below), x * (1.0 + wide));
            format!("[{:.6}, {:.6}]", a.min(b), a.max(b))
        };
        let noise = rng.pick(&[0.1, 0.01, 1e-3]);
        let levels: Vec<f64> = if resets {
            [0.9, 1.0, 1.03].iter().map(|share| share * p[2]).collect()
        } else {
            Vec::new()
        };
        let mut text = format!(
            "format = 1\nstates = [\"x\", \"v\"]\ninputs = [\"u\"]\n[init]\nx = [-0.2, 0.2]\nv = 0\n[params]\n\
             alpha = {}\nbeta = {}\nT = {}\n[der]\nx = \"v\"\nv = \"alpha*v + beta*(u - friction(v, u, T))\"\n\
             [outputs]\nm = \"x +- {noise}\"\n",
            list(p[0], wide),
            list(p[1], wide),
            if resets {
                format!("[{:.6}, {:.6}]", 0.85 * p[2], 1.1 * p[2])
            } else {
                list(p[2], wide)
            }
        );
        if tells_rest {
            text += "[signals]\nstill = { proves = \"v == 0\", latency = 0 }\n";
        }
        if resets {
            text += "[events]\nrest = { when = \"still\", lasts = 0.1, action = \"reset T\" }\n";
        }
        let model = read("motor", &text);
        let record = draw(rng, p, noise, (tells_rest, &levels));
        let story = format!(
            "seed {seed} round {round} rest {tells_rest} resets {resets} noise {noise} {p:?}\n{text}"
        );
        let options = IdentifyOptions {
            sets: rng.pick(&[1, 6, 16]),
            ..IdentifyOptions::default()
        };
        let found = identify(
            &model,
            std::slice::from_ref(&record.samples),
            &options,
            &|_| true,
        );
        assert!(
            !matches!(found.conclusion, Conclusion::Inconsistent(_)),
            "{story}"
        );
        let fixed = p.iter().zip(&found.params).take(if resets { 2 } else { 3 });
        for (truth, bounds) in fixed {
            assert!(bounds.outer.contains(*truth), "{story} {truth} {bounds:?}");
        }
        if resets {
            let at = |time: &Decimal| {
                record
                    .samples
                    .iter()
                    .position(|sample| sample.time == *time)
            };
            for phase in &found.resets[0] {
                let (from, until) = (at(&phase.from).unwrap(), at(&phase.until).unwrap());
                for params in &record.params[from..until] {
                    assert!(
                        phase.bounds.outer.contains(params[2]),
                        "{story} {params:?} {phase:?}"
                    );
                }
            }
        } else {
            narrowed +=
                usize::from(found.params[2].outer.width() < 0.5 * model.params[2].bounds.width());
            for point in &found.points {
                points += 1;
                let q = [point[0].mid(), point[1].mid(), point[2].mid()];
                let (mut x, mut v) = (0.0, 0.0_f64);
                let mut allowed = found.starts[0][0].outer.inflate(1e-9);
                for sample in &record.samples {
                    let rests = sample.signals.first() == Some(&Some(true));
                    assert!(!rests || v.abs() < 1e-6, "{story} point {q:?}");
                    if let Some(told) = sample.outputs[0] {
                        allowed = allowed.intersect((told - Interval::point(x)).inflate(1e-7));
                    }
                    (x, v) = rig_step(x, v, sample.inputs[0].mid(), q, 0.01);
                }
                assert!(!allowed.is_empty(), "{story} point {q:?}");
            }
        }
        let options = ObserverOptions {
            method: Method::Polytope,
            boxes: 1 + rng.below(8),
            bisections: rng.below(4),
            ..ObserverOptions::default()
        };
        let mut observer = Observer::new(&model, options);
        for ((sample, params), states) in record
            .samples
            .iter()
            .zip(&record.params)
            .zip(&record.states)
        {
            let verdict = observer.step(sample).unwrap();
            assert!(
                matches!(verdict, Verdict::Consistent(_)),
                "{story} at {}",
                sample.time
            );
            let truth = [&states[..], params].concat();
            let inside = observer.cells().iter().any(|cell| {
                let both = cell.z.iter().zip(&truth).enumerate();
                both.into_iter()
                    .all(|(i, (z, x))| z.inflate(if i < 2 { 1e-8 } else { 0.0 }).contains(*x))
            });
            assert!(inside, "{story} at {}", sample.time);
        }
        all += 1;
    }
    println!("{narrowed} of {all} narrowed, {points} points");
    assert!(narrowed > 0 && points > 0);
}
