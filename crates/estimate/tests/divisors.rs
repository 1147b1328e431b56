//! Random systems with divisors in several places, products of parameters, and inputs of any course: the truth of short
//! records is never lost, and points that are proved to agree do.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

#[path = "../../flow/tests/common/mod.rs"]
mod common;

use common::smooth::{Rate, travel};
use common::{Rng, number, read, rig_step};
use veribound_estimate::identify::{Conclusion, IdentifyOptions, identify};
use veribound_interval::{Decimal, Interval};
use veribound_model::Sample;

/// How far the solution in floating point may be from the exact one.
const SLACK: f64 = 1e-7;

/// How a state goes on over a time.
enum Flow {
    Smooth(Rate),
    Exact(fn(&mut Vec<f64>, &[f64], f64, f64)),
}

/// A family of systems; the first states are those of `start`.
struct Family {
    name: &'static str,
    flow: Flow,
    /// What stands before and after the parameters.
    head: &'static str,
    tail: &'static str,
    params: &'static [(&'static str, f64, f64)],
    start: &'static [(&'static str, f64, f64)],
    outputs: &'static [(fn(&[f64], &[f64], f64) -> f64, f64)],
    /// The largest input; none where there is none.
    input: f64,
    dt: f64,
    /// Steps of the integrator from sample to sample: many where rates are not smooth.
    steps: f64,
}

const FAMILIES: &[Family] = &[
    Family {
        name: "two masses",
        flow: Flow::Smooth(|x, p, u, d| {
            let force = p[2] * (x[0] - x[2]);
            d[0] = x[1];
            d[1] = (u[0] - force - p[3] * x[1]) / p[0];
            d[2] = x[3];
            d[3] = force / p[1];
        }),
        head: "",
        tail: "[der]\nx = \"v\"\nv = \"(u - k*(x - y) - d*v)/m\"\ny = \"w\"\nw = \"k*(x - y)/M\"\n[outputs]\n\
               a = \"x +- 0.01\"\nb = \"y +- 0.01\"\n",
        params: &[
            ("m", 0.5, 3.0),
            ("M", 0.5, 3.0),
            ("k", 5.0, 40.0),
            ("d", 0.1, 2.0),
        ],
        start: &[
            ("x", -0.2, 0.2),
            ("v", -0.5, 0.5),
            ("y", -0.2, 0.2),
            ("w", -0.5, 0.5),
        ],
        outputs: &[(|x, _, _| x[0], 0.01), (|x, _, _| x[2], 0.01)],
        input: 3.0,
        dt: 0.05,
        steps: 2.0,
    },
    Family {
        name: "force and acceleration",
        flow: Flow::Smooth(|x, p, u, d| {
            d[0] = x[1];
            d[1] = (u[0] - p[1] * x[0] - p[2] * x[1]) / p[0] - p[3];
        }),
        head: "",
        tail: "[der]\nx = \"v\"\nv = \"(u - k*x - d*v)/m - g\"\n[outputs]\na = \"(u - k*x - d*v)/m +- 0.2\"\nb = \"k*x +- 0.1\"\n\
               c = \"x/m +- 0.02\"\n",
        params: &[
            ("m", 0.5, 3.0),
            ("k", 2.0, 20.0),
            ("d", 0.1, 2.0),
            ("g", -1.0, 1.0),
        ],
        start: &[("x", -0.5, 0.5), ("v", -0.5, 0.5)],
        outputs: &[
            (|x, p, u| (u - p[1] * x[0] - p[2] * x[1]) / p[0], 0.2),
            (|x, p, _| p[1] * x[0], 0.1),
            (|x, p, _| x[0] / p[0], 0.02),
        ],
        input: 3.0,
        dt: 0.05,
        steps: 2.0,
    },
    Family {
        name: "sizes and products",
        flow: Flow::Smooth(|x, p, u, d| {
            d[0] = (u[0] - p[1] * x[0] - p[2] * x[0] * (x[0]).abs()) / p[0] + p[3] * p[1] / p[0];
        }),
        head: "",
        tail: "[der]\nx = \"(u - d*x - c*x*abs(x))/m + o*d/m\"\n[outputs]\na = \"x +- 0.01\"\n",
        params: &[
            ("m", 0.5, 3.0),
            ("d", 0.2, 3.0),
            ("c", 0.1, 1.0),
            ("o", -0.5, 0.5),
        ],
        start: &[("x", -0.5, 0.5)],
        outputs: &[(|x, _, _| x[0], 0.01)],
        input: 3.0,
        dt: 0.1,
        steps: 100.0,
    },
    Family {
        name: "a sum below",
        flow: Flow::Smooth(|x, p, u, d| {
            d[0] = x[1];
            d[1] = (u[0] - p[1] * x[0]) / (p[0] + p[2]) - p[3] * x[1] / p[0];
        }),
        head: "",
        tail: "[der]\nx = \"v\"\nv = \"(u - k*x)/(m + M) - d*v/m\"\n[outputs]\na = \"x +- 0.005\"\nb = \"v +- 0.02\"\n",
        params: &[
            ("m", 0.5, 3.0),
            ("k", 2.0, 20.0),
            ("M", 0.5, 3.0),
            ("d", 0.1, 2.0),
        ],
        start: &[("x", -0.5, 0.5), ("v", -0.5, 0.5)],
        outputs: &[(|x, _, _| x[0], 0.005), (|x, _, _| x[1], 0.02)],
        input: 3.0,
        dt: 0.05,
        steps: 2.0,
    },
    Family {
        name: "ratio of masses",
        flow: Flow::Smooth(|x, p, u, d| {
            d[0] = -p[0] / p[1] * x[0] + u[0] / p[1];
            d[1] = (p[0] / p[1]) * (x[0] - x[1]) / p[2] + p[3] / p[2];
        }),
        head: "",
        tail: "[der]\nx = \"-(m/M)*x + u/M\"\ny = \"(m/M)*(x - y)/T + q/T\"\n[outputs]\na = \"x +- 0.01\"\nb = \"y/T +- 0.01\"\n",
        params: &[
            ("m", 0.5, 3.0),
            ("M", 0.5, 3.0),
            ("T", 0.5, 2.0),
            ("q", -1.0, 1.0),
        ],
        start: &[("x", -0.5, 0.5), ("y", -0.5, 0.5)],
        outputs: &[(|x, _, _| x[0], 0.01), (|x, p, _| x[1] / p[2], 0.01)],
        input: 2.0,
        dt: 0.1,
        steps: 2.0,
    },
    Family {
        name: "sled",
        flow: Flow::Exact(|x, p, u, time| {
            let (position, velocity) =
                rig_step(x[0], x[1], u, [-p[1] / p[0], 1.0 / p[0], p[2]], time);
            *x = vec![position, velocity];
        }),
        head: "",
        tail: "[der]\nx = \"v\"\nv = \"(u - d*v - friction(v, u, c))/m\"\n[outputs]\na = \"x +- 0.002\"\n",
        params: &[("m", 0.5, 3.0), ("d", 0.3, 3.0), ("c", 0.2, 1.0)],
        start: &[("x", -0.1, 0.1), ("v", -0.5, 0.5)],
        outputs: &[(|x, _, _| x[0], 0.002)],
        input: 2.0,
        dt: 0.05,
        steps: 2.0,
    },
    Family {
        name: "sled of modes",
        flow: Flow::Exact(|x, p, u, time| {
            let (position, velocity) =
                rig_step(x[0], x[1], u, [-p[1] / p[0], 1.0 / p[0], p[2] / p[3]], time);
            *x = vec![position, velocity];
        }),
        head: "",
        tail: "[modes]\nforward = { when = \"v > 0 or (v == 0 and u > c/r)\", der = { x = \"v\", v = \"(u - d*v - c/r)/m\" } }\n\
               stick = { when = \"v == 0 and abs(u) <= c/r\", der = { x = \"0\", v = \"0\" } }\n\
               backward = { when = \"v < 0 or (v == 0 and u < -c/r)\", der = { x = \"v\", v = \"(u - d*v + c/r)/m\" } }\n\
               [outputs]\na = \"x +- 0.002\"\n",
        params: &[
            ("m", 0.5, 3.0),
            ("d", 0.3, 3.0),
            ("c", 0.2, 1.0),
            ("r", 0.8, 1.2),
        ],
        start: &[("x", -0.1, 0.1), ("v", -0.5, 0.5)],
        outputs: &[(|x, _, _| x[0], 0.002)],
        input: 2.0,
        dt: 0.05,
        steps: 2.0,
    },
    Family {
        name: "ball",
        flow: Flow::Exact(|x, p, _, mut time| {
            let g = p[0] / p[1];
            let floor = p[3] / p[1];
            loop {
                let (h, v) = (x[0] - floor, x[1]);
                let hit = (v + (v * v + 2.0 * g * h.max(0.0)).sqrt()) / g;
                if hit > time || hit < 1e-9 {
                    x[0] += v * time - 0.5 * g * time * time;
                    x[1] -= g * time;
                    return;
                }
                x[0] = floor;
                x[1] = -(v - g * hit) * p[2] / p[1];
                time -= hit;
            }
        }),
        head: "",
        tail: "[der]\nx = \"v\"\nv = \"-w/m\"\n[jumps]\nhit = { when = \"x <= c/m and v < 0\", set = { x = \"c/m\", v = \"-v*e/m\" } }\n\
               [outputs]\na = \"x +- 0.005\"\n",
        params: &[
            ("w", 8.0, 12.0),
            ("m", 0.9, 1.2),
            ("e", 0.6, 0.85),
            ("c", 0.0, 0.1),
        ],
        start: &[("x", 0.5, 1.0), ("v", -0.5, 0.5)],
        outputs: &[(|x, _, _| x[0], 0.005)],
        input: 0.0,
        dt: 0.04,
        steps: 2.0,
    },
    Family {
        name: "sled of two modes",
        flow: Flow::Exact(|x, p, u, time| {
            let (position, velocity) = rig_step(x[0], x[1], u, [-p[1], p[3], p[2]], time);
            *x = vec![position, velocity];
        }),
        head: "",
        tail: "[modes]\nforward = { when = \"v >= 0\", der = { x = \"v\", v = \"b*(u - c) - d*v\" } }\n\
               backward = { when = \"v < 0\", der = { x = \"v\", v = \"b*(u + c) - d*v\" } }\n\
               [outputs]\na = \"x +- 0.002\"\n",
        params: &[
            ("m", 0.5, 3.0),
            ("d", 0.3, 3.0),
            ("c", 0.2, 1.0),
            ("b", 0.5, 2.0),
        ],
        start: &[("x", -0.1, 0.1), ("v", 0.0, 0.0)],
        outputs: &[(|x, _, _| x[0], 0.002)],
        input: 1.0,
        dt: 0.05,
        steps: 2.0,
    },
];

fn decimal(x: f64, digits: usize) -> Decimal {
    Decimal::parse(&format!("{x:.digits$}")).unwrap()
}

fn text((lo, hi): (f64, f64)) -> String {
    if lo == hi {
        format!("{{ fixed = {lo} }}")
    } else {
        format!("[{lo}, {hi}]")
    }
}

#[derive(Debug, Default)]
struct Counts {
    trials: usize,
    consistent: usize,
    narrowed: usize,
    points: usize,
}

/// One random record of a family.
fn attack(family: &Family, rng: &mut Rng, story: &str, counts: &mut Counts) {
    let round6 = |x: f64| (x * 1e6).round() / 1e6;
    let around = |rng: &mut Rng, x: f64, lo: f64, hi: f64| {
        let reach = (hi - lo) * rng.pick(&[0.02, 0.2, 0.6]);
        let (below, above) = (rng.pick(&[0.0, 1.0, 0.5]), rng.pick(&[1.0, 0.0, 0.3]));
        ((x - below * reach).max(lo), (x + above * reach).min(hi))
    };
    let (mut params, mut truth) = (String::new(), Vec::new());
    for (name, lo, hi) in family.params {
        let x = round6(rng.between(*lo, *hi));
        truth.push(x);
        params += &format!("{name} = {}\n", text(around(rng, x, *lo, *hi)));
    }
    let is_known = rng.chance(0.5);
    let (mut init, mut start) = (String::new(), Vec::new());
    for (name, lo, hi) in family.start {
        let x = round6(rng.between(*lo, *hi));
        start.push(x);
        let (lo, hi) = if is_known {
            (x, x)
        } else {
            around(rng, x, *lo, *hi)
        };
        let told = if lo == hi {
            format!("{lo}")
        } else {
            format!("[{lo}, {hi}]")
        };
        init += &format!("{name} = {told}\n");
    }
    let has_input = family.input > 0.0;
    let is_off = has_input && rng.chance(0.4);
    let input = match (has_input, is_off) {
        (false, _) => "",
        (true, false) => "inputs.u = { error = 0 }\n",
        (true, true) => "inputs.u = { error = { relative = 0.1 } }\n",
    };
    let states: Vec<String> = family
        .start
        .iter()
        .map(|(name, ..)| format!("{name:?}"))
        .collect();
    let model_text = format!(
        "format = 1\nstates = [{}]\n{input}{}[init]\n{init}[params]\n{params}{}",
        states.join(", "),
        family.head,
        family.tail
    );
    let model = read(family.name, &model_text);
    let count = 20 + rng.below(60);
    let (mut inputs, mut shares) = (Vec::new(), Vec::new());
    let (mut u, mut left) = (0.0, 0);
    for _ in 0..count {
        if left == 0 {
            u = (family.input * rng.pick(&[1.0, -1.0, 0.0, 0.5, 0.2]) * 1e3).round() / 1e3;
            left = 1 + rng.below(count / 3);
        }
        left -= 1;
        inputs.push(u);
        let unit = rng.between(-1.0, 1.0);
        let share = 0.1 * (1.0 - 1e-12) * rng.pick(&[1.0, -1.0, unit]);
        shares.push(if is_off { 1.0 + share } else { 1.0 });
    }
    let course = |p: &[f64], start: &[f64]| {
        let mut x = start.to_vec();
        let mut all = Vec::new();
        for k in 0..count {
            all.push(x.clone());
            let u = inputs[k] * shares[k];
            match &family.flow {
                Flow::Smooth(rate) => {
                    travel(*rate, &mut x, p, &[u], family.dt, family.dt / family.steps)
                }
                Flow::Exact(go) => go(&mut x, p, u, family.dt),
            }
        }
        all
    };
    let states = course(&truth, &start);
    let sample = |k: usize, rng: &mut Rng| {
        let acting = inputs[k] * shares[k];
        let outputs = family.outputs.iter().map(|(output, error)| {
            let unit = rng.between(-1.0, 1.0);
            let noise = (error - 4.0 * SLACK) * rng.pick(&[1.0, -1.0, unit]);
            let read = decimal(output(&states[k], &truth, acting) + noise, 12).to_interval();
            (!rng.chance(0.05)).then(|| read + Interval::symmetric(*error))
        });
        Sample {
            time: decimal(k as f64 * family.dt, 4),
            outputs: outputs.collect(),
            inputs: (model.inputs.iter())
                .map(|input| input.error.enclose(decimal(inputs[k], 3).to_interval()))
                .collect(),
            signals: Vec::new(),
            line: k + 2,
        }
    };
    let record: Vec<Sample> = (0..count).map(|k| sample(k, rng)).collect();
    let options = IdentifyOptions {
        sets: rng.pick(&[1, 4, 12]),
        ..IdentifyOptions::default()
    };
    let found = identify(&model, std::slice::from_ref(&record), &options, &|_| true);
    let told = || {
        format!(
            "{} {story}: {truth:?} {start:?}\n{model_text}\n{found:?}",
            family.name
        )
    };
    counts.trials += 1;
    assert!(
        !matches!(found.conclusion, Conclusion::Inconsistent(_)),
        "{}",
        told()
    );
    counts.consistent += usize::from(found.conclusion == Conclusion::Consistent);
    for ((bounds, param), x) in found.params.iter().zip(&model.params).zip(&truth) {
        assert!(bounds.outer.contains(*x), "{x} {}", told());
        counts.narrowed += usize::from(bounds.outer.width() < 0.7 * param.bounds.width());
        if let Some(inner) = bounds.inner {
            assert!(inner.is_subset_of(bounds.outer), "{}", told());
        }
    }
    for (bounds, x) in found.starts[0].iter().zip(&start) {
        assert!(bounds.outer.contains(*x), "{}", told());
    }
    if !is_known || is_off {
        return;
    }
    for point in &found.points {
        let p: Vec<f64> = point.iter().map(|x| x.mid()).collect();
        for (x, param) in point.iter().zip(&model.params) {
            assert!(x.intersects(param.bounds), "{x} {}", told());
        }
        for (k, (sample, x)) in record.iter().zip(course(&p, &start)).enumerate() {
            for (told_, (output, _)) in sample.outputs.iter().zip(family.outputs) {
                let value = output(&x, &p, inputs[k]);
                assert!(
                    told_.is_none_or(|y| y.inflate(1e-6).contains(value)),
                    "{p:?} at {k}: {value} {told_:?} {}",
                    told()
                );
            }
        }
        counts.points += 1;
    }
}

#[test]
fn systems_with_divisors_lose_no_truth() {
    let seed = number("VERIBOUND_SEED", 1);
    let mut all: Vec<Counts> = FAMILIES.iter().map(|_| Counts::default()).collect();
    for round in 0..number("VERIBOUND_ROUNDS", 3) {
        for (family, counts) in FAMILIES.iter().zip(&mut all) {
            let mut rng = Rng((seed * 7_000_003 + round) * 31 + family.name.len() as u64);
            attack(
                family,
                &mut rng,
                &format!("seed {seed}, round {round}"),
                counts,
            );
        }
        if round % 20 == 19 {
            for (family, counts) in FAMILIES.iter().zip(&all) {
                println!("{}: {counts:?}", family.name);
            }
        }
    }
    for (family, counts) in FAMILIES.iter().zip(&all) {
        println!("{}: {counts:?}", family.name);
    }
    let points: usize = all.iter().map(|counts| counts.points).sum();
    let narrowed: usize = all.iter().map(|counts| counts.narrowed).sum();
    let trials: usize = all.iter().map(|counts| counts.trials).sum();
    assert!(points > 0 && narrowed >= trials, "{all:?}");
}
