//! Random pendulums with dry friction, tanks with an overflow and drive trains: what is true is never excluded, and what
//! is proved to agree does, by solutions with every event located. Records that are short make many trials: what loses
//! a solution loses it in the first sets.

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
use veribound_estimate::identify::{
    Conclusion, Identified, IdentifyOptions, Reason, Status, Tile, identify,
};
use veribound_interval::{Decimal, Interval};
use veribound_model::{Model, Sample};

/// How far the solution in floating point may be from the exact one.
const SLACK: f64 = 1e-8;

/// A system that is smooth on each side of a border.
struct Sides {
    /// The last input is the side: 1 where `border` is positive, -1 where it is negative.
    rate: Rate,
    border: fn(&[f64], &[f64]) -> f64,
    /// The side on which a solution on the border goes on, if it leaves it.
    leaves: fn(&[f64], &[f64], f64) -> Option<f64>,
    longest: f64,
}

impl Sides {
    /// Moves `x` by `time`; the side is that of before.
    fn advance(&self, x: &mut Vec<f64>, p: &[f64], u: f64, side: &mut f64, mut time: f64) {
        while time > 0.0 {
            if *side == 0.0 {
                match (self.leaves)(x, p, 0.0) {
                    Some(next) => *side = next,
                    None => return,
                }
            }
            let step = time.min(self.longest);
            let moved = |by: f64, side: f64| {
                let mut end = x.clone();
                travel(self.rate, &mut end, p, &[u, side], by, by.max(1e-300));
                end
            };
            let end = moved(step, *side);
            if (self.border)(&end, p) * *side >= 0.0 {
                (*x, time) = (end, time - step);
                continue;
            }
            let (mut before, mut after) = (0.0, step);
            for _ in 0..60 {
                let middle = 0.5 * (before + after);
                if (self.border)(&moved(middle, *side), p) * *side >= 0.0 {
                    before = middle;
                } else {
                    after = middle;
                }
            }
            (*x, time) = (moved(after, *side), time - after);
            *side = (self.leaves)(x, p, *side).unwrap_or(0.0);
            if *side == 0.0 {
                return;
            }
        }
    }
}

/// A pendulum: `a`, `b`, `c` and the angle at which it hangs.
const PENDULUM: Sides = Sides {
    rate: |x, p, u, d| {
        d[0] = x[1];
        d[1] = -p[0] * (x[0] - p[3]).sin() - p[1] * x[1] - u[1] * p[2];
    },
    border: |x, _| x[1],
    leaves: |x, p, _| {
        let pull = -p[0] * (x[0] - p[3]).sin();
        (pull.abs() > p[2]).then(|| pull.signum())
    },
    longest: 0.02,
};

/// Two tanks: what flows from one to the other and away, and the overflow of the first above an edge.
const TANKS: Sides = Sides {
    rate: |x, p, u, d| {
        let down = 4.43 * p[0] * x[0].sqrt();
        let over = if u[1] > 0.0 {
            p[2] * (x[0] - p[3])
        } else {
            0.0
        };
        d[0] = u[0] - down - over;
        d[1] = down - 4.43 * p[1] * x[1].sqrt();
    },
    border: |x, p| x[0] - p[3],
    leaves: |_, _, side| Some(if side == 0.0 { 1.0 } else { -side }),
    longest: 0.05,
};

/// How solutions are found.
enum System {
    Sides(&'static Sides),
    Rig,
}

/// Something to identify: a model, what is true of it, and how its solutions are found.
struct Case {
    system: System,
    model: Model,
    start: Vec<f64>,
    truth: Vec<f64>,
    /// Inputs by sample, as they are recorded; none where the model has none.
    inputs: Vec<f64>,
    /// What acts in truth from a sample to the next, as shares of these.
    shares: Vec<f64>,
    /// The state that a signal says to be at rest, if one does.
    still: Option<usize>,
    dt: f64,
    /// States that are measured, from the first on.
    measured: usize,
    error: f64,
    /// Whether the start is known.
    is_known: bool,
}

impl Case {
    /// States at every sample.
    fn course(&self, p: &[f64], count: usize) -> Vec<Vec<f64>> {
        let mut x = self.start.clone();
        let mut side = match self.system {
            System::Sides(sides) => (sides.border)(&x, p),
            System::Rig => 0.0,
        };
        side = if side == 0.0 { 0.0 } else { side.signum() };
        let mut all = Vec::new();
        for k in 0..count {
            all.push(x.clone());
            let share = self.shares.get(k).copied().unwrap_or(1.0);
            let u = self.inputs.get(k).map_or(0.0, |u| u * share);
            match self.system {
                System::Sides(sides) => sides.advance(&mut x, p, u, &mut side, self.dt),
                System::Rig => {
                    let (phi, omega) = rig_step(x[0], x[1], u, [p[0], p[1], p[2]], self.dt);
                    x = vec![phi, omega];
                }
            }
        }
        all
    }

    /// Measurements with errors that often are at the bound, some of them missing.
    fn record(&self, rng: &mut Rng, count: usize) -> Vec<Sample> {
        let states = self.course(&self.truth, count);
        let told = |rng: &mut Rng, x: f64| {
            let reach = self.error - 4.0 * SLACK;
            let unit = rng.between(-1.0, 1.0);
            let error = reach * rng.pick(&[-1.0, 1.0, unit]);
            let read = decimal(x + error, 12).to_interval();
            (!rng.chance(0.05)).then(|| read + Interval::symmetric(self.error))
        };
        let sample = |(k, x): (usize, &Vec<f64>)| Sample {
            time: decimal(k as f64 * self.dt, 4),
            inputs: self
                .inputs
                .get(k)
                .zip(self.model.inputs.first())
                .map(|(u, input)| input.error.enclose(decimal(*u, 3).to_interval()))
                .into_iter()
                .collect(),
            outputs: x[..self.measured].iter().map(|x| told(rng, *x)).collect(),
            signals: self
                .still
                .map(|state| Some(x[state] == 0.0))
                .into_iter()
                .collect(),
            line: k + 2,
        };
        states.iter().enumerate().map(sample).collect()
    }

    /// Whether the solution with these parameters, from the known start, meets all samples.
    fn agrees(&self, p: &[f64], record: &[Sample]) -> bool {
        let states = self.course(p, record.len());
        record.iter().zip(states).all(|(sample, x)| {
            let mut pairs = sample.outputs.iter().zip(x);
            pairs.all(|(told, x)| told.is_none_or(|told| told.inflate(SLACK).contains(x)))
        })
    }
}

fn decimal(x: f64, digits: usize) -> Decimal {
    Decimal::parse(&format!("{x:.digits$}")).unwrap()
}

/// A prior around what is true, that much wider or less on each side, and inside of what can be.
fn around(rng: &mut Rng, x: f64, (lo, hi): (f64, f64)) -> (f64, f64) {
    let reach = (hi - lo) * rng.pick(&[0.01, 0.1, 0.4]);
    let below = rng.pick(&[0.0, 1.0, 0.5]) * reach;
    let above = rng.pick(&[1.0, 0.0, 0.3]) * reach;
    ((x - below).max(lo), (x + above).min(hi))
}

fn text((lo, hi): (f64, f64)) -> String {
    if lo == hi {
        format!("{lo}")
    } else {
        format!("[{lo}, {hi}]")
    }
}

/// A pendulum that swings, and may come to rest, with its angle read to 10 or 3 mrad.
fn pendulum(rng: &mut Rng, is_known: bool) -> (Case, usize) {
    let limits = [(30.0, 70.0), (0.0, 0.5), (0.0, 2.0), (-0.1, 0.1)];
    let inner = [(40.0, 60.0), (0.0, 0.3), (0.1, 1.5), (-0.05, 0.05)];
    let truth: Vec<f64> = inner.iter().map(|(lo, hi)| rng.between(*lo, *hi)).collect();
    let start = [rng.between(0.1, 1.2) * rng.pick(&[-1.0, 1.0]), 0.0];
    let start = start.map(|x| decimal(x, 6).to_interval().mid());
    let error = rng.pick(&[0.01, 0.003]);
    let priors: Vec<String> = { truth.iter().zip(limits) }
        .map(|(x, limits)| match around(rng, *x, limits) {
            (lo, hi) if lo == hi => format!("{{ fixed = {lo} }}"),
            ends => text(ends),
        })
        .collect();
    let init = start.map(|x| {
        let reach = if is_known { 0.0 } else { 0.5 };
        text((x - reach, x + reach))
    });
    let model = format!(
        "format = 1\nstates = [\"th\", \"om\"]\n[init]\nth = {}\nom = {}\n[params]\na = {}\nb = {}\nc = {}\noff = {}\n[let]\n\
         pull = \"-a*sin(th - off) - b*om\"\n[der]\nth = \"om\"\nom = \"pull - friction(om, pull, c)\"\n[outputs]\n\
         angle = \"th +- {error}\"\n",
        init[0], init[1], priors[0], priors[1], priors[2], priors[3],
    );
    let case = Case {
        system: System::Sides(&PENDULUM),
        model: read("pendulum", &model),
        start: start.to_vec(),
        truth,
        inputs: Vec::new(),
        shares: Vec::new(),
        still: None,
        dt: 0.02,
        measured: 1,
        error,
        is_known,
    };
    (case, 40 + rng.below(120))
}

/// Tanks whose inflow takes another level now and then, both levels read to 5 mm.
fn tanks(rng: &mut Rng, is_known: bool) -> (Case, usize) {
    let limits = [(0.05, 0.2), (0.02, 0.15), (0.0, 5.0), (0.4, 0.7)];
    let inner = [(0.07, 0.15), (0.04, 0.1), (0.5, 4.0), (0.45, 0.6)];
    let truth: Vec<f64> = inner.iter().map(|(lo, hi)| rng.between(*lo, *hi)).collect();
    let start = [0, 1].map(|_| decimal(rng.between(0.1, 0.3), 6).to_interval().mid());
    let priors: Vec<String> = { truth.iter().zip(limits) }
        .map(|(x, limits)| match around(rng, *x, limits) {
            (lo, hi) if lo == hi => format!("{{ fixed = {lo} }}"),
            ends => text(ends),
        })
        .collect();
    let init = start.map(|x| {
        let reach = if is_known { 0.0 } else { 0.05 };
        text((x - reach, x + reach))
    });
    let model = format!(
        "format = 1\nstates = [\"h1\", \"h2\"]\ninputs = [\"q\"]\n[init]\nh1 = {}\nh2 = {}\n[params]\na = {}\nb = {}\nw = {}\n\
         edge = {}\n[der]\nh1 = \"q - 4.43*a*sqrt(h1) - w*max(0, h1 - edge)\"\nh2 = \"4.43*(a*sqrt(h1) - b*sqrt(h2))\"\n\
         [outputs]\nupper = \"h1 +- 0.005\"\nlower = \"h2 +- 0.005\"\n",
        init[0], init[1], priors[0], priors[1], priors[2], priors[3],
    );
    let count = 40 + rng.below(80);
    let (mut q, mut left) = (0.3, 0);
    let inputs = (0..count).map(|_| {
        if left == 0 {
            left = 10 + rng.below(30);
            q = rng.pick(&[0.2, 0.3, 0.4, 0.5, 0.6]);
        }
        left -= 1;
        q
    });
    let case = Case {
        system: System::Sides(&TANKS),
        model: read("tanks", &model),
        start: start.to_vec(),
        truth,
        inputs: inputs.collect(),
        shares: Vec::new(),
        still: None,
        dt: 0.1,
        measured: 2,
        error: 0.005,
        is_known,
    };
    (case, count)
}

/// A drive train with dry friction, its angle read to 0.1 or 0.01 rad every 10 ms; a signal may say when it rests, and the
/// torque may be off by a tenth, at every sample by another share.
fn rig(rng: &mut Rng, is_known: bool) -> (Case, usize) {
    let limits = [(-6.0, -0.05), (1.0, 400.0), (0.0, 0.3)];
    let inner = [(-4.0, -0.5), (50.0, 300.0), (0.02, 0.25)];
    let truth: Vec<f64> = inner.iter().map(|(lo, hi)| rng.between(*lo, *hi)).collect();
    let priors: Vec<String> = { truth.iter().zip(limits) }
        .map(|(x, limits)| match around(rng, *x, limits) {
            (lo, hi) if lo == hi => format!("{{ fixed = {lo} }}"),
            ends => text(ends),
        })
        .collect();
    let error = rng.pick(&[0.1, 0.01]);
    let (tells_rest, is_off) = (rng.chance(0.3), rng.chance(0.4));
    let start = text(if is_known { (0.0, 0.0) } else { (-0.2, 0.2) });
    let torque = if is_off {
        "\n[inputs]\nu = { error = { relative = 0.1 } }"
    } else {
        "inputs = [\"u\"]"
    };
    let still = if tells_rest {
        "[signals]\nstill = { proves = \"omega == 0\", latency = 0 }\n"
    } else {
        ""
    };
    let model = format!(
        "format = 1\nstates = [\"phi\", \"omega\"]\n{torque}\n[init]\nphi = {start}\nomega = 0\n[params]\nalpha = {}\n\
         beta = {}\nT = {}\n[der]\nphi = \"omega\"\nomega = \"alpha*omega + beta*(u - friction(omega, u, T))\"\n\
         [outputs]\nangle = \"phi +- {error}\"\n{still}",
        priors[0], priors[1], priors[2],
    );
    let count = 150 + rng.below(350);
    let (mut u, mut left) = (0.0, 0);
    let mut inputs = Vec::with_capacity(count);
    while inputs.len() < count {
        if left == 0 {
            let sign = rng.pick(&[0.0, 1.0, -1.0, 1.0]);
            u = sign * (rng.between(0.1, 0.4) * 1e3).round() / 1e3;
            left = 5 + rng.below(count / 4);
        }
        left -= 1;
        inputs.push(u);
    }
    let share = |rng: &mut Rng| {
        let unit = rng.between(-1.0, 1.0);
        1.0 + 0.1 * (1.0 - 1e-12) * rng.pick(&[-1.0, 1.0, unit])
    };
    let case = Case {
        system: System::Rig,
        model: read("rig", &model),
        start: vec![0.0, 0.0],
        truth,
        shares: inputs
            .iter()
            .map(|_| if is_off { share(rng) } else { 1.0 })
            .collect(),
        inputs,
        still: tells_rest.then_some(1),
        dt: 0.01,
        measured: 1,
        error,
        // Points that agree do so with some course of the torque, which is not told.
        is_known: is_known && !is_off,
    };
    (case, count)
}

/// What became of many cases.
#[derive(Debug, Default)]
struct Counts {
    trials: usize,
    consistent: usize,
    /// Parameters that records narrowed to less than half.
    narrowed: usize,
    points: usize,
    tiles: usize,
    /// Tiles with the truth that are divided along other axes.
    needles: usize,
}

impl Counts {
    /// The truth is not excluded, and what is proved to agree does, with the start that is known.
    fn judge(
        &mut self,
        rng: &mut Rng,
        case: &Case,
        record: &[Sample],
        found: &Identified,
        story: &str,
    ) {
        self.trials += 1;
        let told = || format!("{story}: truth {:?}\n{found:?}", case.truth);
        assert!(
            !matches!(found.conclusion, Conclusion::Inconsistent(_)),
            "{}",
            told()
        );
        let params = found.params.iter().zip(&case.model.params);
        for ((bounds, param), truth) in params.zip(&case.truth) {
            assert!(bounds.outer.contains(*truth), "{}", told());
            self.narrowed += usize::from(bounds.outer.width() < 0.5 * param.bounds.width());
        }
        for (bounds, x) in found.starts[0].iter().zip(&case.start) {
            assert!(bounds.outer.contains(*x), "{}", told());
        }
        self.consistent += usize::from(found.conclusion == Conclusion::Consistent);
        let is_true = |tile: &&Tile| {
            let mut pairs = tile.params.iter().zip(&case.truth);
            pairs.all(|(x, truth)| x.contains(*truth))
        };
        let upright = found.tiles.iter().filter(|tile| tile.turned.is_none());
        for tile in upright.filter(is_true) {
            assert!(tile.status != Status::Outside, "{tile:?} {}", told());
            let Reason::Needle { frame } = tile.reason else {
                continue;
            };
            let pieces = found.tiles.iter().filter(is_true).filter(|tile| {
                let turned = tile.turned.as_ref();
                turned.is_some_and(|turned| turned.frame == frame)
            });
            let mut statuses = pieces.map(|tile| tile.status);
            assert!(
                statuses.any(|status| status != Status::Outside),
                "{tile:?} {}",
                told()
            );
            self.needles += 1;
        }
        if !case.is_known {
            return;
        }
        for point in &found.points {
            let p: Vec<f64> = point.iter().map(|x| x.mid()).collect();
            assert!(case.agrees(&p, record), "{p:?} {}", told());
            self.points += 1;
        }
        for tile in &found.tiles {
            let p = inside(rng, found, tile);
            match tile.status {
                Status::Inside => {
                    assert!(case.agrees(&p, record), "{p:?} {tile:?} {}", told());
                    self.tiles += 1;
                }
                // What agrees by more than this solution is wrong lies in no such tile.
                Status::Outside => {
                    let is_believed = case
                        .model
                        .params
                        .iter()
                        .zip(&p)
                        .all(|(param, p)| param.bounds.contains(*p));
                    assert!(
                        !is_believed || !strictly(case, &p, record),
                        "{p:?} {tile:?} {}",
                        told()
                    );
                }
                Status::Undecided | Status::Turned => {}
            }
        }
    }
}

/// A point of a tile, well inside where it is turned.
fn inside(rng: &mut Rng, found: &Identified, tile: &Tile) -> Vec<f64> {
    let Some(turned) = &tile.turned else {
        return tile
            .params
            .iter()
            .map(|x| rng.between(x.lo(), x.hi()))
            .collect();
    };
    let frame = &found.frames[turned.frame];
    let y: Vec<f64> = turned
        .unknowns
        .iter()
        .map(|y| rng.between(y.lo(), y.hi()))
        .collect();
    let rows = frame.centre.iter().zip(&frame.axes);
    rows.map(|(centre, row)| centre + row.iter().zip(&y).map(|(slope, y)| slope * y).sum::<f64>())
        .collect()
}

/// Whether all samples are met by more than the solution is wrong.
fn strictly(case: &Case, p: &[f64], record: &[Sample]) -> bool {
    let states = case.course(p, record.len());
    record.iter().zip(states).all(|(sample, x)| {
        let mut pairs = sample.outputs.iter().zip(x);
        pairs.all(|(told, x)| {
            told.is_none_or(|told| told.lo() + SLACK <= x && x <= told.hi() - SLACK)
        })
    })
}

/// Records that are whole, or a few samples of them and only the first sets.
#[derive(Clone, Copy, PartialEq)]
enum Length {
    Whole,
    Short,
}

fn sweep(
    name: &str,
    (usual, length): (u64, Length),
    make: fn(&mut Rng, bool) -> (Case, usize),
) -> Counts {
    let mut counts = Counts::default();
    let seed = number("VERIBOUND_SEED", 1);
    for round in 0..number("VERIBOUND_ROUNDS", usual) {
        let mut rng = Rng(seed * 9_000_011 + round);
        let (case, whole) = make(&mut rng, round % 2 == 0);
        let count = match length {
            Length::Whole => whole,
            Length::Short => whole / 4,
        };
        let record = case.record(&mut rng, count);
        assert!(case.agrees(&case.truth, &record));
        // A paving may look at twenty times as many.
        let is_paved = length == Length::Whole && round % 4 == 0;
        let options = IdentifyOptions {
            sets: match (length, is_paved) {
                (Length::Short, _) => 1,
                (_, true) => 2,
                _ => 6,
            },
            undecided: is_paved.then_some(0.3),
            ..IdentifyOptions::default()
        };
        let found = identify(
            &case.model,
            std::slice::from_ref(&record),
            &options,
            &|_| true,
        );
        let story = format!("{name}, seed {seed}, round {round}");
        counts.judge(&mut rng, &case, &record, &found, &story);
        if counts.trials.is_multiple_of(100) {
            println!("{name}: {counts:?}");
        }
    }
    println!("{name}: {counts:?}");
    counts
}

fn is_told(counts: &Counts) {
    assert!(counts.narrowed >= counts.trials, "{counts:?}");
    assert!(
        3 * counts.consistent >= counts.trials && counts.points > 0,
        "{counts:?}"
    );
}

#[test]
fn the_truth_of_pendulums_is_never_lost() {
    is_told(&sweep("pendulums", (4, Length::Whole), pendulum));
}

#[test]
fn the_truth_of_tanks_is_never_lost() {
    is_told(&sweep("tanks", (8, Length::Whole), tanks));
}

#[test]
fn short_records_of_pendulums_lose_no_truth() {
    let counts = sweep("short pendulums", (20, Length::Short), pendulum);
    assert!(2 * counts.narrowed >= counts.trials, "{counts:?}");
}

#[test]
fn short_records_of_tanks_lose_no_truth() {
    let counts = sweep("short tanks", (20, Length::Short), tanks);
    assert!(2 * counts.narrowed >= counts.trials, "{counts:?}");
}

#[test]
fn short_records_of_rigs_lose_no_truth() {
    let counts = sweep("short rigs", (20, Length::Short), rig);
    assert!(2 * counts.narrowed >= counts.trials, "{counts:?}");
}
