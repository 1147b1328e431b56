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
use veribound_estimate::identify::{Conclusion, IdentifyOptions, identify, least_error};
use veribound_interval::{Decimal, Interval};
use veribound_model::Sample;

/// How far the solution in floating point may be from the exact one.
const SLACK: f64 = 1e-7;

/// An output of state, parameters and input.
type Output = fn(&[f64], &[f64], f64) -> f64;

/// How a state goes on over a time.
enum Flow {
    Smooth(Rate),
    Exact(fn(&mut Vec<f64>, &[f64], f64, f64)),
}

/// A family of systems; the first states are those of `start`.
struct Family {
    name: &'static str,
    flow: Flow,
    /// Equations and outputs.
    tail: &'static str,
    params: &'static [(&'static str, f64, f64)],
    start: &'static [(&'static str, f64, f64)],
    outputs: &'static [(Output, f64)],
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

#[derive(Debug, Default)]
struct Counts {
    trials: usize,
    consistent: usize,
    narrowed: usize,
    points: usize,
}

/// A family with outputs of which one sample in eight may be anything.
fn with_outliers(tail: &str) -> String {
    let (head, outputs) = tail.split_once("[outputs]\n").unwrap();
    let lines = outputs.lines().map(|line| {
        let (name, told) = line.split_once(" = ").unwrap();
        let (expr, error) = told.trim_matches('"').split_once(" +- ").unwrap();
        format!("{name} = {{ expr = \"{expr}\", error = {error}, outliers = \"1 in 8\" }}\n")
    });
    format!("{head}[outputs]\n{}", lines.collect::<String>())
}

/// Inputs as recorded, and what acts as shares of these.
struct Driven {
    inputs: Vec<f64>,
    shares: Vec<f64>,
}

impl Driven {
    fn random(rng: &mut Rng, most: f64, is_off: bool) -> Driven {
        let count = 20 + rng.below(60);
        let (mut inputs, mut shares) = (Vec::new(), Vec::new());
        let (mut u, mut left) = (0.0, 0);
        for _ in 0..count {
            if left == 0 {
                u = (most * rng.pick(&[1.0, -1.0, 0.0, 0.5, 0.2]) * 1e3).round() / 1e3;
                left = 1 + rng.below(count / 3);
            }
            left -= 1;
            inputs.push(u);
            let unit = rng.between(-1.0, 1.0);
            let share = 0.1 * (1.0 - 1e-12) * rng.pick(&[1.0, -1.0, unit]);
            shares.push(if is_off { 1.0 + share } else { 1.0 });
        }
        Driven { inputs, shares }
    }

    /// States at all samples, with what acts there.
    fn course(&self, family: &Family, p: &[f64], start: &[f64]) -> Vec<(Vec<f64>, f64)> {
        let mut x = start.to_vec();
        let acting = self
            .inputs
            .iter()
            .zip(&self.shares)
            .map(|(u, share)| u * share);
        acting
            .map(|u| {
                let now = x.clone();
                match &family.flow {
                    Flow::Smooth(rate) => {
                        let longest = family.dt / family.steps;
                        travel(*rate, &mut x, p, &[u], family.dt, longest);
                    }
                    Flow::Exact(go) => go(&mut x, p, u, family.dt),
                }
                (now, u)
            })
            .collect()
    }
}

/// Random records of a family.
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
        let told = match around(rng, x, *lo, *hi) {
            (lo, hi) if lo == hi => format!("{{ fixed = {lo} }}"),
            (lo, hi) => format!("[{lo}, {hi}]"),
        };
        params += &format!("{name} = {told}\n");
    }
    let is_known = rng.chance(0.5);
    let (mut init, mut start) = (String::new(), Vec::new());
    for (name, lo, hi) in family.start {
        let x = round6(rng.between(*lo, *hi));
        start.push(x);
        let told = match around(rng, x, *lo, *hi) {
            (lo, hi) if lo == hi || is_known => format!("{x}"),
            (lo, hi) => format!("[{lo}, {hi}]"),
        };
        init += &format!("{name} = {told}\n");
    }
    let is_off = family.input > 0.0 && rng.chance(0.4);
    let is_spoilt = rng.chance(0.2);
    let input = match (family.input > 0.0, is_off) {
        (false, _) => "",
        (true, false) => "inputs.u = { error = 0 }\n",
        (true, true) => "inputs.u = { error = { relative = 0.1 } }\n",
    };
    let states = family.start.iter().map(|(name, ..)| format!("{name:?}"));
    let states: Vec<String> = states.collect();
    let tail = if is_spoilt {
        with_outliers(family.tail)
    } else {
        family.tail.to_owned()
    };
    let text = format!(
        "format = 1\nstates = [{}]\n{input}[init]\n{init}[params]\n{params}{tail}",
        states.join(", "),
    );
    let model = read(family.name, &text);
    let drives = 0..rng.pick(&[1, 1, 2]);
    let drives: Vec<Driven> = drives
        .map(|_| Driven::random(rng, family.input, is_off))
        .collect();
    let mut records = Vec::new();
    for drive in &drives {
        let mut record = Vec::new();
        for (k, (x, u)) in drive.course(family, &truth, &start).iter().enumerate() {
            let outputs = family.outputs.iter().map(|(output, error)| {
                let unit = rng.between(-1.0, 1.0);
                let mut noise = (error - 4.0 * SLACK) * rng.pick(&[1.0, -1.0, unit]);
                if is_spoilt && k % 8 == 5 {
                    noise *= rng.pick(&[1.5, 10.0, 1e4]);
                }
                let read = decimal(output(x, &truth, *u) + noise, 12).to_interval();
                let is_told = is_spoilt || !rng.chance(0.05);
                is_told.then(|| read + Interval::symmetric(*error))
            });
            let outputs = outputs.collect();
            let recorded = decimal(drive.inputs[k], 3).to_interval();
            record.push(Sample {
                time: decimal(k as f64 * family.dt, 4),
                outputs,
                inputs: { model.inputs.iter() }
                    .map(|input| input.error.enclose(recorded))
                    .collect(),
                signals: Vec::new(),
                line: k + 2,
            });
        }
        records.push(record);
    }
    let options = IdentifyOptions {
        sets: rng.pick(&[1, 4, 12]),
        ..IdentifyOptions::default()
    };
    let found = identify(&model, &records, &options, &|_| true);
    let told = || {
        format!(
            "{} {story}: {truth:?} {start:?}\n{text}\n{found:?}",
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
    for (bounds, x) in found.starts.iter().flat_map(|own| own.iter().zip(&start)) {
        assert!(bounds.outer.contains(*x), "{}", told());
    }
    if rng.chance(0.03) {
        let least = least_error(&model, &records, &options, &|_| true);
        assert!(least.factor.lo() <= 1.0, "{least:?} {}", told());
    }
    if !is_known || is_off || is_spoilt {
        return;
    }
    for point in &found.points {
        let p: Vec<f64> = point.iter().map(|x| x.mid()).collect();
        for (x, param) in point.iter().zip(&model.params) {
            assert!(x.intersects(param.bounds), "{x} {}", told());
        }
        for (drive, record) in drives.iter().zip(&records) {
            for (sample, (x, u)) in record.iter().zip(drive.course(family, &p, &start)) {
                for (told_of, (output, _)) in sample.outputs.iter().zip(family.outputs) {
                    let value = output(&x, &p, u);
                    assert!(
                        told_of.is_none_or(|y| y.inflate(SLACK).contains(value)),
                        "{p:?}: {value} {told_of:?} {}",
                        told()
                    );
                }
            }
        }
        counts.points += 1;
    }
}

/// Who sticks between two modes moves by neither of them: the second one is not written to hold there.
#[test]
fn what_slides_between_two_modes_agrees() {
    for (forward, backward) in [("v >= 0", "v < 0"), ("v > 0", "v <= 0")] {
        let model = read(
            "sled",
            &format!(
                "format = 1\nstates = [\"x\", \"v\"]\ninputs.u = {{ error = {{ relative = 0.1 }} }}\ninit = {{ x = 0, v = 0 }}\n\
                 params.c = [0.35, 0.45]\nparams.d = [0.5, 2]\n[modes]\n\
                 forward = {{ when = \"{forward}\", der = {{ x = \"v\", v = \"u - c - d*v\" }} }}\n\
                 backward = {{ when = \"{backward}\", der = {{ x = \"v\", v = \"u + c - d*v\" }} }}\n\
                 [outputs]\na = \"x +- 0.002\"\n"
            ),
        );
        for u in [0.3, -0.3, 0.0] {
            let sample = |k: usize| Sample {
                time: decimal(0.05 * k as f64, 4),
                inputs: vec![model.inputs[0].error.enclose(Interval::point(u))],
                outputs: vec![Some(Interval::symmetric(0.002))],
                signals: Vec::new(),
                line: k + 2,
            };
            let record: Vec<Sample> = (0..40).map(sample).collect();
            let found = identify(&model, &[record], &IdentifyOptions::default(), &|_| true);
            assert!(
                !matches!(found.conclusion, Conclusion::Inconsistent(_)),
                "{forward} {u}: {found:?}"
            );
            for (bounds, truth) in found.params.iter().zip([0.36, 1.0]) {
                assert!(bounds.outer.contains(truth), "{forward} {u}: {found:?}");
            }
        }
    }
}

#[test]
fn systems_with_divisors_lose_no_truth() {
    let seed = number("VERIBOUND_SEED", 1);
    let mut all: Vec<Counts> = FAMILIES.iter().map(|_| Counts::default()).collect();
    for round in 0..number("VERIBOUND_ROUNDS", 2) {
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

/// Next to nothing may be divided by: quotients at vertices of linear programs need not be numbers.
#[test]
fn divisors_of_any_size() {
    let mut points = 0;
    for (m, k) in [
        ("[1e-3, 1e20]", "[0, 1e3]"),
        ("[0.5, 1e30]", "[-5, 5]"),
        ("[1e-3, 1e300]", "[1, 1e20]"),
        ("[1e-300, 1e3]", "[0, 10]"),
        ("[0.5, 2]", "[0, 1e30]"),
    ] {
        let model = read(
            "wide",
            &format!(
                "format = 1\nstates = [\"x\"]\ninputs = [\"u\"]\ninit.x = 0\nparams = {{ m = {m}, k = {k} }}\n\
                 der.x = \"(u - k*x)/m\"\noutputs.y = \"x +- 0.01\"\n"
            ),
        );
        for count in [3, 12, 60] {
            let sample = |k: usize| {
                let t = 0.1 * k as f64;
                let x = decimal(0.5 * (1.0 - (-2.0 * t).exp()), 12).to_interval();
                Sample {
                    time: decimal(t, 4),
                    inputs: vec![Interval::ONE],
                    outputs: vec![Some(x + Interval::symmetric(0.01))],
                    signals: Vec::new(),
                    line: k + 2,
                }
            };
            let record: Vec<Sample> = (0..count).map(sample).collect();
            let options = IdentifyOptions {
                sets: 20,
                ..IdentifyOptions::default()
            };
            let found = identify(&model, &[record], &options, &|_| true);
            assert!(
                !matches!(found.conclusion, Conclusion::Inconsistent(_)),
                "{m} {k} {found:?}"
            );
            for (bounds, truth) in found.params.iter().zip([1.0, 2.0]) {
                assert!(bounds.outer.contains(truth), "{m} {k} {found:?}");
            }
            points += found.points.len();
        }
    }
    assert!(points > 0);
}
