//! Every model of the examples, enclosed by every engine: random sets, and true solutions of random points of them.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod common;

use common::stem::{Stem, bounce};
use common::truth::{Sim, Switch, Truth};
use common::{Rng, Trials, interval, number, rig_step};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use veribound_flow::engine::{Engine, Engines, Task};
use veribound_flow::form::{Effort, FormOptions, Obstacle, Stretch};
use veribound_interval::Interval;
use veribound_model::Model;

/// What simulators in plain floating point may be off, for sizes around one.
const SLACK: f64 = 2e-8;

/// How a true solution is followed.
#[derive(Clone, Copy)]
enum Follow {
    /// By the simulator of switching systems.
    Located(Truth),
    /// By closed forms between events.
    Rig,
    Stem,
    Ball,
}

/// A model file, how its solutions are followed, what inputs and disturbances are drawn from, and for how long.
struct Example {
    file: &'static str,
    follow: Follow,
    inputs: &'static [(f64, f64)],
    time: f64,
}

const fn smooth(states: usize, f: common::truth::Field, longest: f64) -> Truth {
    Truth {
        states,
        f,
        switches: &[],
        kinks: &[],
        longest,
    }
}

const PENDULUM: &[Switch] = &[Switch {
    g: |x, _, _| x[1],
    b: |_, p, _, d| d[1] = -p[2],
}];

const BELT: Truth = Truth {
    states: 2,
    f: |x, p, _, d| {
        d[0] = x[1];
        d[1] = -p[0] * x[0] - p[1] * x[1];
    },
    switches: &[Switch {
        g: |x, _, u| x[1] - u[0],
        b: |_, p, _, d| d[1] = -p[2],
    }],
    kinks: &[],
    longest: 2e-3,
};

const TEXTBOOK: Truth = Truth {
    states: 2,
    f: |x, p, u, d| {
        d[0] = x[1];
        d[1] = p[0] * (u[0] - p[1] * x[1] - p[3]);
    },
    switches: &[Switch {
        g: |x, _, _| x[1],
        b: |_, p, _, d| d[1] = -p[0] * p[2],
    }],
    kinks: &[],
    longest: 2e-4,
};

const SWING: Truth = Truth {
    states: 2,
    f: |x, p, _, d| {
        d[0] = x[1];
        d[1] = -p[0] * (x[0] - p[3]).sin() - p[1] * x[1];
    },
    switches: PENDULUM,
    kinks: &[],
    longest: 5e-4,
};

/// With the energy beside it.
const ENERGY: Truth = Truth {
    states: 3,
    f: |x, p, _, d| {
        (SWING.f)(x, p, &[], d);
        d[2] = -p[1] * x[1] * x[1] - p[2] * x[1].abs();
    },
    ..SWING
};

/// Half of the play is `p[1]`.
const PLAY: Truth = Truth {
    states: 4,
    f: |x, p, u, d| {
        let twist = x[0] - x[2];
        let shaft = p[0] * (twist - twist.clamp(-p[1], p[1]));
        d[0] = x[1];
        d[1] = (u[0] - 0.05 * x[1] - shaft) / 0.1;
        d[2] = x[3];
        d[3] = p[2] * (shaft - p[3] * x[3]);
    },
    switches: &[],
    kinks: &[|x, p, _| x[0] - x[2] - p[1], |x, p, _| x[0] - x[2] + p[1]],
    longest: 1e-3,
};

/// The second input is the roughness that the map does not know.
const CAR: Truth = Truth {
    states: 2,
    f: |x, p, u, d| {
        let stretch = x[1] - u[0] - u[1];
        let stops = p[2] * (x[0] - x[0].clamp(-p[3], p[3]));
        d[0] = stretch;
        d[1] = -p[0] * x[0] - p[1] * stretch - stops;
    },
    switches: &[],
    kinks: &[|x, p, _| x[0] - p[3], |x, p, _| x[0] + p[3]],
    longest: 5e-4,
};

/// Opening, opening below, overflow, its edge.
const TANKS: Truth = Truth {
    states: 2,
    f: |x, p, u, d| {
        let fall = |h: f64| (2.0 * 9.81 * h).sqrt();
        let down = p[0] * fall(x[0]);
        d[0] = u[0] - down - p[2] * (x[0] - p[3]).max(0.0);
        d[1] = down - p[1] * fall(x[1]);
    },
    switches: &[],
    kinks: &[|x, p, _| x[0] - p[3]],
    longest: 1e-3,
};

/// Three masses of the chain: places, then speeds.
const CHAIN: Truth = Truth {
    states: 6,
    f: |x, p, u, d| {
        d[..3].copy_from_slice(&x[3..]);
        d[3] = u[0] + p[0] * (x[1] - x[0]);
        d[4] = p[0] * (x[0] - 2.0 * x[1] + x[2]);
        d[5] = p[0] * (x[1] - x[2]);
    },
    switches: &[
        Switch {
            g: |x, _, _| x[3],
            b: |_, p, _, d| d[3] = -p[1],
        },
        Switch {
            g: |x, _, _| x[4],
            b: |_, p, _, d| d[4] = -p[1],
        },
        Switch {
            g: |x, _, _| x[5],
            b: |_, p, _, d| d[5] = -p[1],
        },
    ],
    kinks: &[],
    longest: 5e-4,
};

const COMPARTMENTS: Truth = smooth(
    2,
    |x, p, u, d| {
        d[0] = u[0] - (p[0] + p[2]) * x[0] + p[1] * x[1];
        d[1] = p[0] * x[0] - p[1] * x[1];
    },
    1e-2,
);

const DIGESTION: Truth = smooth(
    6,
    |x, p, u, d| {
        let [s1, s2, c, x1, x2, z] = [x[0], x[1], x[2], x[3], x[4], x[5]];
        let [dilution, cod, vfa, tic, alk] = [u[0], u[1], u[2], u[3], u[4]];
        let first = p[0] * s1 / (s1 + 7.1);
        let second = p[1] * s2 / (s2 + 9.28 + s2 * s2 / 256.0);
        let (co2, ch4) = (c + s2 - z, 453.0 / 19.8 * second * x2);
        let root = ((co2 - 16.0 + ch4).powi(2) + 64.0 * ch4).sqrt();
        let gas = 19.8 * (co2 - (co2 + 16.0 + ch4 - root) / 2.0);
        d[0] = dilution * (cod - 0.064 * vfa - s1) - 42.14 * first * x1;
        d[1] = dilution * (vfa - s2) + 116.5 * first * x1 - 268.0 * second * x2;
        d[2] = dilution * (tic - c) - gas + 50.6 * first * x1 + 343.6 * second * x2;
        d[3] = (first - 0.5 * dilution) * x1;
        d[4] = (second - 0.5 * dilution) * x2;
        d[5] = dilution * (alk - z);
    },
    1e-4,
);

const REACTOR: Truth = smooth(
    2,
    |x, p, u, d| {
        let growth = p[0] * x[1] / (p[1] + x[1]);
        d[0] = (growth - 0.5 * u[0]) * x[0];
        d[1] = u[0] * (5.7 - x[1]) - 10.53 * growth * x[0];
    },
    1e-3,
);

const AXIS: Truth = smooth(
    2,
    |x, p, u, d| {
        let share = (x[1] - 0.03) / 0.09;
        d[0] = x[1];
        d[1] = p[0] * (u[0] - p[1] * (1.0 - share) - p[2] * share);
    },
    5e-4,
);

const EXAMPLES: [Example; 19] = [
    Example::of("drive-train/model.toml", Follow::Rig, &[(-0.4, 0.4)], 0.5),
    Example::of(
        "drive-train/model-friction.toml",
        Follow::Rig,
        &[(-0.4, 0.4)],
        0.5,
    ),
    Example::of("pendulum/model.toml", Follow::Located(ENERGY), &[], 0.5),
    Example::of(
        "pendulum/model-plain.toml",
        Follow::Located(SWING),
        &[],
        0.5,
    ),
    Example::of(
        "emps/model.toml",
        Follow::Located(AXIS),
        &[(-30.0, 60.0)],
        0.3,
    ),
    Example::of(
        "emps/model-textbook.toml",
        Follow::Located(TEXTBOOK),
        &[(-60.0, 60.0)],
        0.1,
    ),
    Example::of(
        "two-tanks/model.toml",
        Follow::Located(TANKS),
        &[(0.1, 0.5)],
        2.0,
    ),
    Example::of("belt/model.toml", Follow::Located(BELT), &[(0.0, 0.4)], 3.0),
    Example::of(
        "backlash/model.toml",
        Follow::Located(PLAY),
        &[(-0.5, 0.5)],
        0.5,
    ),
    Example::of(
        "quarter-car/model.toml",
        Follow::Located(CAR),
        &[(-0.5, 0.5), (-0.01, 0.01)],
        0.3,
    ),
    Example::of(
        "chain/model.toml",
        Follow::Located(CHAIN),
        &[(-6.0, 6.0)],
        0.2,
    ),
    Example::of("bouncing-ball/model.toml", Follow::Ball, &[], 1.2),
    Example::of("valve/model.toml", Follow::Stem, &[(-2.0, 10.0)], 3.0),
    Example::of(
        "compartments/model.toml",
        Follow::Located(COMPARTMENTS),
        &[(0.0, 1.0)],
        5.0,
    ),
    Example::of(
        "compartments/model-tissue.toml",
        Follow::Located(COMPARTMENTS),
        &[(0.0, 1.0)],
        5.0,
    ),
    Example::of(
        "michaelis-menten/model.toml",
        Follow::Located(smooth(
            1,
            |x, p, _, d| d[0] = -p[0] * x[0] / (p[1] + x[0]),
            1e-2,
        )),
        &[],
        5.0,
    ),
    Example::of(
        "lotka-volterra/model.toml",
        Follow::Located(smooth(
            2,
            |x, p, _, d| {
                d[0] = p[0] * x[0] * (1.0 - x[1]);
                d[1] = p[1] * x[1] * (x[0] - 1.0);
            },
            2e-3,
        )),
        &[],
        2.0,
    ),
    Example::of(
        "bioreactor/model.toml",
        Follow::Located(REACTOR),
        &[(0.1, 0.6)],
        2.0,
    ),
    Example::of(
        "anaerobic-digestion/model.toml",
        Follow::Located(DIGESTION),
        &[
            (0.2, 1.0),
            (7.0, 15.0),
            (80.0, 160.0),
            (5.0, 10.0),
            (50.0, 100.0),
        ],
        0.02,
    ),
];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples")
}

/// A solution and its parameters.
struct Solution {
    follow: Follow,
    sim: Sim,
}

impl Solution {
    fn advance(&mut self, u: &[f64], h: f64, rng: &mut Rng) {
        let (x, p) = (&mut self.sim.x, &self.sim.p);
        match self.follow {
            Follow::Located(_) => self.sim.advance(u, h, rng),
            Follow::Rig => (x[0], x[1]) = rig_step(x[0], x[1], u[0], [p[0], p[1], p[2]], h),
            Follow::Stem => {
                let mut state = [x[0], x[1]];
                let stem = Stem {
                    k: p[0],
                    c: p[1],
                    friction: p[2],
                    room: [0.0, 0.05],
                };
                stem.advance(&mut state, u[0], h, &mut |_| ());
                x.copy_from_slice(&state);
            }
            Follow::Ball => {
                let mut state = [x[0], x[1]];
                bounce(&mut state, [p[0], p[1]], h);
                x.copy_from_slice(&state);
            }
        }
    }
}

/// A part of what a file allows.
fn part(rng: &mut Rng, x: Interval, share: f64) -> Interval {
    let width = share * x.width() * rng.unit();
    let lo = rng.between(x.lo(), x.hi() - width);
    interval(lo, (lo + width).min(x.hi()))
}

impl Example {
    const fn of(
        file: &'static str,
        follow: Follow,
        inputs: &'static [(f64, f64)],
        time: f64,
    ) -> Example {
        Example {
            file,
            follow,
            inputs,
            time,
        }
    }

    /// The model; of the chain the first three masses only.
    fn model(&self) -> Model {
        let text = std::fs::read_to_string(folder().join(self.file)).unwrap();
        common::read(self.file, &text.replace("n = 50", "n = 3"))
    }

    /// One random set, one engine, and solutions from points of the set; says how much was proved.
    fn attack(&self, model: &Model, engines: &Engines, rng: &mut Rng, trials: &mut Trials) -> f64 {
        let share = rng.pick(&[1e-3, 0.01, 0.03, 0.1]);
        let states: Vec<Interval> = model
            .states
            .iter()
            .map(|state| part(rng, state.init, share))
            .collect();
        let params: Vec<Interval> = model
            .params
            .iter()
            .map(|param| part(rng, param.bounds, share))
            .collect();
        let count = 1 + rng.below(12);
        let lengths: Vec<f64> = (0..count)
            .map(|_| self.time / count as f64 * rng.pick(&[1.0, 1.0, 0.3]))
            .collect();
        let mut inputs: Vec<Interval> = Vec::new();
        let mut stretches = Vec::new();
        for (k, h) in lengths.iter().enumerate() {
            if k == 0 || rng.chance(0.6) {
                let wide = rng.pick(&[0.0, 0.0, 0.01]);
                let list = self.inputs.iter();
                inputs = list
                    .map(|(lo, hi)| part(rng, interval(*lo, *hi), wide))
                    .collect();
            }
            stretches.push(Stretch {
                inputs: inputs.clone(),
                dt: Interval::point(*h),
            });
        }
        let engine = rng.pick(&Engine::ALL);
        let options = FormOptions {
            degree: rng.pick(&[None, None, Some(1), Some(2), Some(3)]),
            ..FormOptions::default()
        };
        let effort = Effort {
            parts: rng.pick(&[1, 1, 4]),
            ..Effort::default()
        };
        let task = Task {
            states: &states,
            params: &params,
            stretches: &stretches,
            options,
            effort,
        };
        // What is proved until the work is enough stays.
        let work = Mutex::new(0.0);
        let answer = engines.enclose(engine, task, &|standing| {
            let mut work = work.lock().unwrap();
            *work += 1.0 + standing.cost / 100.0;
            *work < 20_000.0
        });
        let found = &answer.enclosure;
        let what = format!(
            "{} by {engine:?} {options:?} {effort:?} from {states:?} {params:?} {stretches:?}",
            self.file
        );
        if let Some(stopped) = &found.stopped {
            assert!(
                stopped.obstacle != Obstacle::Undefined,
                "{what}: {stopped:?}"
            );
        }
        for _ in 0..12 {
            let point = |rng: &mut Rng, list: &[Interval]| -> Vec<f64> {
                list.iter().map(|x| rng.inside(*x)).collect()
            };
            let (x, p) = (point(rng, &states), point(rng, &params));
            let truth = match self.follow {
                Follow::Located(truth) => truth,
                _ => smooth(x.len(), |_, _, _, _| (), 1.0),
            };
            let mut solution = Solution {
                follow: self.follow,
                sim: Sim::new(truth, &x, &p),
            };
            for (k, (end, tube)) in found.ends.iter().zip(&found.tubes).enumerate() {
                let cut = rng.unit();
                for share in [cut, 1.0 - cut] {
                    let u = point(rng, &stretches[k].inputs);
                    solution.advance(&u, share * lengths[k], rng);
                    inside(
                        &solution,
                        tube,
                        &format!("{what}, on the way in stretch {k}"),
                    );
                }
                inside(
                    &solution,
                    end,
                    &format!("{what}, at the end of stretch {k}"),
                );
                trials.checks += 3;
            }
            trials.solutions += u64::from(!found.ends.is_empty());
        }
        found.ends.len() as f64 / stretches.len() as f64
    }
}

fn inside(solution: &Solution, boxes: &[Interval], what: &str) {
    for (i, (x, bounds)) in solution.sim.x.iter().zip(boxes).enumerate() {
        let slack = SLACK * (1.0 + x.abs());
        assert!(
            *x >= bounds.lo() - slack && *x <= bounds.hi() + slack,
            "state {i} of parameters {:?} is {x:?}, outside {bounds:?} by {:e}: {what}",
            solution.sim.p,
            (bounds.lo() - x).max(x - bounds.hi()),
        );
    }
}

#[test]
fn no_solution_of_an_example_is_lost() {
    let mut rng = Rng(number("VERIBOUND_SEED", 3));
    let rounds = number("VERIBOUND_ROUNDS", 4);
    let mut all = Trials::default();
    for example in &EXAMPLES {
        let model = example.model();
        let engines = Engines::new(&model);
        let (mut trials, mut proved) = (Trials::default(), 0.0);
        let begin = std::time::Instant::now();
        for _ in 0..rounds {
            proved += example.attack(&model, &engines, &mut rng, &mut trials);
        }
        let share = proved / rounds as f64;
        println!(
            "{:32} {trials:?}, {share:.2} of the time proved, {:.1} s",
            example.file,
            begin.elapsed().as_secs_f64()
        );
        all.add(trials);
    }
    all.told("the examples");
    assert!(all.solutions > 100 * rounds, "{all:?}");
}

/// A new example is one of these.
#[test]
fn no_example_is_forgotten() {
    let mut found = 0;
    for entry in std::fs::read_dir(folder()).unwrap() {
        for file in std::fs::read_dir(entry.unwrap().path()).unwrap() {
            let path = file.unwrap().path();
            let name = path.file_name().unwrap().to_str().unwrap();
            if !(name.starts_with("model") && name.ends_with(".toml")) {
                continue;
            }
            let file = path.strip_prefix(folder()).unwrap().to_str().unwrap();
            let is_known = EXAMPLES.iter().any(|example| example.file == file);
            assert!(is_known, "{file} is not attacked");
            found += 1;
        }
    }
    assert_eq!(found, EXAMPLES.len());
}
