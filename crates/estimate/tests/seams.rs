//! Sleds with dry friction whose force is off at every sample, whose level may be new after standstills, written in several ways,
//! in one or two records: no truth is lost.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

#[path = "../../flow/tests/common/mod.rs"]
mod common;

use common::{Rng, number, read, rig_step};
use veribound_estimate::identify::{Conclusion, IdentifyOptions, identify, least_error};
use veribound_interval::{Decimal, Interval};
use veribound_model::Sample;

fn decimal(x: f64, digits: usize) -> Decimal {
    Decimal::parse(&format!("{x:.digits$}")).unwrap()
}

/// The same sled, with `c` as force.
const WRITTEN: &[&str] = &[
    "[der]\nx = \"v\"\nv = \"(u - d*v - friction(v, u, c))/m\"\n",
    "[modes]\nforward = { when = \"v > 0 or (v == 0 and u > c)\", der = { x = \"v\", v = \"(u - d*v - c)/m\" } }\n\
     stick = { when = \"v == 0 and abs(u) <= c\", der = { x = \"0\", v = \"0\" } }\n\
     backward = { when = \"v < 0 or (v == 0 and u < -c)\", der = { x = \"v\", v = \"(u - d*v + c)/m\" } }\n",
    "[modes]\nforward = { when = \"v >= 0\", der = { x = \"v\", v = \"(u - d*v - c)/m\" } }\n\
     backward = { when = \"v < 0\", der = { x = \"v\", v = \"(u - d*v + c)/m\" } }\n",
    "[modes]\nforward = { when = \"v > 0\", der = { x = \"v\", v = \"(u - d*v - c)/m\" } }\n\
     backward = { when = \"v <= 0\", der = { x = \"v\", v = \"(u - d*v + c)/m\" } }\n",
    "[modes]\nforward = { when = \"v >= 0\", der = { x = \"v\", v = \"(u - d*v - c)/m\" } }\n\
     backward = { when = \"v <= 0\", der = { x = \"v\", v = \"(u - d*v + c)/m\" } }\n",
    "[der]\nx = \"v\"\nv = \"(u - d*v - c*sign(v))/m\"\n",
];

#[derive(Debug, Default)]
struct Counts {
    records: usize,
    consistent: usize,
    narrowed: usize,
    resets: usize,
    least: usize,
}

fn attack(rng: &mut Rng, story: &str, counts: &mut Counts) {
    let round6 = |x: f64| (x * 1e6).round() / 1e6;
    let limits = [("m", 0.3, 3.0), ("d", 0.2, 3.0), ("c", 0.1, 1.2)];
    let (mut params, mut truth) = (String::new(), Vec::new());
    let has_resets = rng.chance(0.5);
    let mut level = (0.0, 0.0);
    for (name, lo, hi) in limits {
        let x = round6(rng.between(lo, hi));
        truth.push(x);
        let reach = (hi - lo) * rng.pick(&[0.02, 0.2, 0.6]);
        let (below, above) = (rng.pick(&[0.0, 1.0, 0.5]), rng.pick(&[1.0, 0.0, 0.3]));
        let (lo, hi) = ((x - below * reach).max(lo), (x + above * reach).min(hi));
        level = (lo, hi);
        params += &if lo == hi {
            format!("{name} = {{ fixed = {lo} }}\n")
        } else {
            format!("{name} = [{lo}, {hi}]\n")
        };
    }
    let way = rng.below(WRITTEN.len());
    let lasts = rng.pick(&[0.0, 0.1]);
    let mut text = format!(
        "format = 1\nstates = [\"x\", \"v\"]\ninputs.u = {{ error = {{ relative = 0.1 }} }}\n[init]\nx = [-0.1, 0.1]\nv = 0\n[params]\n{params}{}\
         [outputs]\na = \"x +- 0.003\"\n",
        WRITTEN[way]
    );
    if has_resets {
        text += &format!(
            "[signals]\nstill = {{ proves = \"v == 0\", latency = 0 }}\n[events]\nrest = {{ when = \"still\", lasts = {lasts}, action = \"reset c\" }}\n"
        );
    }
    let model = read("sled", &text);
    let dt = 0.05;
    let (mut records, mut levels, mut starts) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..rng.pick(&[1, 1, 2]) {
        let count = 20 + rng.below(60);
        let mut x = [round6(rng.between(-0.1, 0.1)), 0.0];
        starts.push(x);
        let (mut u, mut left, mut c) = (0.0, 0, truth[2]);
        let mut since: Option<usize> = None;
        let (mut record, mut own) = (Vec::new(), Vec::new());
        for k in 0..count {
            if left == 0 {
                let near = truth[2];
                u = (rng.pick(&[1.0, -1.0, 0.0, 1.0])
                    * rng.pick(&[near, 2.0 * near, 1.5, 2.5])
                    * 1e3)
                    .round()
                    / 1e3;
                left = 3 + rng.below(count / 3);
            }
            left -= 1;
            let unit = rng.between(-1.0, 1.0);
            let share = 1.0 + 0.1 * (1.0 - 1e-12) * rng.pick(&[1.0, -1.0, unit]);
            let tells = x[1] == 0.0 && rng.chance(0.9);
            since = if tells { since.or(Some(k)) } else { None };
            let may = since.is_some_and(|since| (k - since) as f64 * dt >= lasts);
            // With what it begins a level is that of all records.
            if has_resets && may && k > 0 && rng.chance(0.7) {
                c = round6(rng.between(level.0, level.1)).clamp(level.0, level.1);
                counts.resets += 1;
            }
            own.push(c);
            let unit = rng.between(-1.0, 1.0);
            let noise = (0.003 - 1e-8) * rng.pick(&[1.0, -1.0, unit]);
            record.push(Sample {
                time: decimal(k as f64 * dt, 4),
                inputs: vec![model.inputs[0].error.enclose(decimal(u, 3).to_interval())],
                outputs: vec![
                    (!rng.chance(0.05)).then(|| {
                        decimal(x[0] + noise, 12).to_interval() + Interval::symmetric(0.003)
                    }),
                ],
                signals: if has_resets {
                    vec![Some(tells)]
                } else {
                    Vec::new()
                },
                line: k + 2,
            });
            let (position, velocity) = rig_step(
                x[0],
                x[1],
                u * share,
                [-truth[1] / truth[0], 1.0 / truth[0], c],
                dt,
            );
            x = [position, velocity];
        }
        records.push(record);
        levels.push(own);
    }
    let options = IdentifyOptions {
        sets: rng.pick(&[1, 4, 12]),
        ..IdentifyOptions::default()
    };
    let found = identify(&model, &records, &options, &|_| true);
    let told = || format!("{story}: {truth:?} {starts:?}\n{text}\n{found:?}");
    counts.records += records.len();
    assert!(
        !matches!(found.conclusion, Conclusion::Inconsistent(_)),
        "{}",
        told()
    );
    counts.consistent += usize::from(found.conclusion == Conclusion::Consistent);
    for (p, ((bounds, param), x)) in found
        .params
        .iter()
        .zip(&model.params)
        .zip(&truth)
        .enumerate()
    {
        if p == 2 && has_resets && levels.iter().any(|own| own[0] != truth[2]) {
            continue;
        }
        assert!(bounds.outer.contains(*x), "{x} {}", told());
        counts.narrowed += usize::from(bounds.outer.width() < 0.7 * param.bounds.width());
    }
    for (bounds, x) in found.starts.iter().zip(&starts) {
        for (bounds, x) in bounds.iter().zip(x) {
            assert!(bounds.outer.contains(*x), "{}", told());
        }
    }
    for (phases, own) in found.resets.iter().zip(&levels) {
        for phase in phases {
            let from = (phase.from.to_interval().mid() / dt).round() as usize;
            let until = (phase.until.to_interval().mid() / dt).round() as usize;
            let values = &own[from..until.max(from + 1).min(own.len())];
            if values.iter().all(|c| *c == values[0]) {
                assert!(
                    phase.bounds.outer.contains(values[0]),
                    "{} {phase:?} {}",
                    values[0],
                    told()
                );
            }
        }
    }
    if rng.chance(0.1) {
        let least = least_error(&model, &records, &options, &|_| true);
        assert!(least.factor.lo() <= 1.0, "{least:?} {}", told());
        counts.least += 1;
    }
}

#[test]
fn sleds_with_a_force_that_is_off() {
    let seed = number("VERIBOUND_SEED", 1);
    let mut counts = Counts::default();
    for round in 0..number("VERIBOUND_ROUNDS", 8) {
        let mut rng = Rng(seed * 5_000_011 + round);
        attack(
            &mut rng,
            &format!("seed {seed}, round {round}"),
            &mut counts,
        );
        if round % 50 == 49 {
            println!("{counts:?}");
        }
    }
    println!("{counts:?}");
    assert!(counts.narrowed > 0);
}
