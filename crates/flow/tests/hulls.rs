//! How much wider than solutions what is proved is: hulls of exact solutions, driven from event to event, beside bounds at every sample.
//!
//! The belt is measured in `forms_switching.rs`, the two tanks in `comparison.rs`.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod common;

use common::stem::{Stem, Way, bounce};
use common::{interval, read};
use veribound_flow::engine::{Engine, Engines, Task};
use veribound_flow::form::{Effort, Enclosure, FormOptions, Stretch};
use veribound_interval::Interval;

/// Widths below this are those of rounding.
const NARROW: f64 = 1e-7;

/// Moves a point, its state and parameters, through all samples.
type Solve<'a> = dyn FnMut(&[f64], &[f64]) -> Vec<Vec<f64>> + 'a;

/// A model, what is uncertain, and stretches that end at samples: length and input.
struct Sampled {
    text: String,
    start: Vec<Interval>,
    params: Vec<Interval>,
    stretches: Vec<(f64, Option<f64>)>,
    parts: usize,
}

impl Sampled {
    fn enclose(&self) -> Enclosure {
        let model = read("sampled", &self.text);
        let stretches = self.stretches.iter().map(|(h, u)| Stretch {
            inputs: u.iter().map(|u| Interval::point(*u)).collect(),
            dt: Interval::point(*h),
        });
        let stretches: Vec<Stretch> = stretches.collect();
        let task = Task {
            states: &self.start,
            params: &self.params,
            stretches: &stretches,
            options: FormOptions::default(),
            effort: Effort {
                parts: self.parts,
                ..Effort::default()
            },
        };
        let answer = Engines::new(&model).enclose(Engine::Auto, task, &|_| true);
        assert!(
            answer.enclosure.stopped.is_none(),
            "{:?}",
            answer.enclosure.stopped
        );
        answer.enclosure
    }

    /// Widths proved and of sampled solutions, of every state at every sample.
    ///
    /// `solve` is asked for a grid of so many values of each quantity.
    fn widths(&self, grid: usize, solve: &mut Solve<'_>) -> Vec<Vec<[f64; 2]>> {
        let found = self.enclose();
        let states = self.start.len();
        let uncertain: Vec<Interval> = self.start.iter().chain(&self.params).copied().collect();
        let total = uncertain.iter().filter(|x| !x.is_point()).count();
        let mut hulls = vec![vec![Interval::EMPTY; states]; self.stretches.len()];
        for number in 0..grid.pow(total as u32) {
            let mut digits = number;
            let mut at = |x: &Interval| {
                if x.is_point() {
                    return x.lo();
                }
                let digit = digits % grid;
                digits /= grid;
                let share = digit as f64 / (grid - 1) as f64;
                (x.lo() + share * (x.hi() - x.lo())).clamp(x.lo(), x.hi())
            };
            let point: Vec<f64> = uncertain.iter().map(&mut at).collect();
            let (x, p) = point.split_at(states);
            for (k, x) in solve(x, p).iter().enumerate() {
                for (i, x) in x.iter().enumerate() {
                    let end = found.ends[k][i];
                    let is_inside = end.inflate(1e-9).contains(*x);
                    assert!(is_inside, "{k} {i}: {x} in {end} from {point:?}");
                    hulls[k][i] = hulls[k][i].hull(Interval::point(*x));
                }
            }
        }
        let samples = hulls.iter().zip(&found.ends);
        samples
            .map(|(inner, outer)| {
                let states = outer.iter().zip(inner);
                states
                    .map(|(outer, inner)| [outer.width(), inner.width()])
                    .collect()
            })
            .collect()
    }
}

/// The largest ratio of widths at any of these samples, for every state.
fn worst(widths: &[Vec<[f64; 2]>]) -> Vec<f64> {
    let ratio = |[outer, inner]: [f64; 2]| (outer - NARROW).max(0.0) / (inner + 1e-300);
    let states = (0..widths[0].len()).map(|i| {
        let ratios = widths.iter().map(|sample| ratio(sample[i]));
        ratios.fold(0.0, f64::max)
    });
    states.collect()
}

fn all_below(ratios: &[f64], most: f64) -> bool {
    ratios.iter().all(|ratio| *ratio < most)
}

/// The valve of the examples under its pressure, a sample every 20 ms: it leaves the closed stop, slides, meets the open stop, sticks, and goes
/// back, where all of them were let go at once: half of them leave as slowly as can be.
#[test]
fn a_valve_with_stiction_between_stops() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/valve/");
    let text = std::fs::read_to_string(format!("{folder}model.toml")).unwrap();
    let profile = std::fs::read_to_string(format!("{folder}profile.csv")).unwrap();
    let number = |text: &str| text.parse::<f64>().unwrap();
    let rows = profile.lines().skip(2);
    let rows = rows.map(|row| row.split_once(',').unwrap());
    let rows: Vec<[f64; 2]> = rows.map(|(t, p)| [number(t), number(p)]).collect();
    let stretches = rows
        .windows(2)
        .flat_map(|rows| [((rows[1][0] - rows[0][0]) / 5.0, Some(rows[0][1])); 5]);
    let around = |x: f64| interval(0.99 * x, 1.01 * x);
    let valve = Sampled {
        text,
        start: vec![interval(0.0, 0.0002), Interval::ZERO],
        params: vec![Interval::point(100.0), around(60.0), around(1.5)],
        stretches: stretches.collect(),
        parts: 1,
    };
    let mut met: Vec<(Way, usize)> = Vec::new();
    let widths = valve.widths(7, &mut |x, p| {
        let stem = Stem {
            k: p[0],
            c: p[1],
            friction: p[2],
            room: [0.0, 0.05],
        };
        let mut state = [x[0], x[1]];
        let samples = valve.stretches.iter().enumerate();
        let moved = samples.map(|(k, (h, pressure))| {
            stem.advance(&mut state, pressure.unwrap(), *h, &mut |way| {
                met.push((way, k));
            });
            state.to_vec()
        });
        moved.collect()
    });
    let first = |way: Way| {
        let samples = met.iter().filter(|(own, _)| *own == way);
        samples.map(|(_, k)| *k).min().unwrap()
    };
    let ways = [
        Way::LeftStop,
        Way::SlidingRight,
        Way::RightStop,
        Way::SlidingLeft,
        Way::Stopped,
    ];
    let [.., stop, back, stuck] = ways.map(first);
    assert!(stop > 100 && back > stop && stuck < stop);
    let before = worst(&widths[..stop]);
    let ratios = worst(&widths);
    println!(
        "valve: {before:?} until sample {stop}, then {ratios:?}, at the end {:?}",
        worst(&widths[299..])
    );
    assert!(all_below(&before, 1.01), "{before:?}");
    assert!(all_below(&ratios, 1.12), "{ratios:?}");
}

/// BM14 until 1.7 s, at every 50 ms.
#[test]
fn a_bouncing_ball() {
    let text = "format = 1\nstates = [\"h\", \"v\"]\n[init]\nh = 1\nv = 0\n[der]\nh = \"v\"\nv = \"-9.81\"\n\
        [jumps]\nbounce = { when = \"h <= 0 and v < 0\", set = { v = \"-0.75*v\" } }\n[outputs]\nm = \"h +- 1\"\n";
    let ball = Sampled {
        text: text.to_owned(),
        start: vec![interval(0.95, 1.05), interval(-0.05, 0.05)],
        params: vec![],
        stretches: vec![(0.05, None); 34],
        parts: 1,
    };
    let widths = ball.widths(101, &mut |x, _| {
        let mut state = [x[0], x[1]];
        let moved = (0..34).map(|_| {
            bounce(&mut state, [0.75, 9.81], 0.05);
            state.to_vec()
        });
        moved.collect()
    });
    let (ratios, last) = (worst(&widths), worst(&widths[33..]));
    println!("ball: {ratios:?}, at the end {last:?}");
    assert!(
        all_below(&ratios, 1.01) && all_below(&last, 1.01),
        "{ratios:?} {last:?}"
    );
}

/// BM18: the clip problem, dry friction under a force below its level, and a flight that may graze a line.
#[test]
fn closed_forms_in_pieces() {
    let clip = Sampled {
        text: "format = 1\nstates = [\"x\", \"y\"]\ninit = { x = 0, y = 0 }\nder = { x = \"1\", y = \"min(max(x, -1), 1)\" }\n\
               outputs.z = \"y +- 1\""
            .to_owned(),
        start: vec![interval(0.9, 0.91), Interval::ZERO],
        params: vec![],
        stretches: vec![(0.05, None); 4],
        parts: 1,
    };
    let ratios = worst(&clip.widths(101, &mut |x, _| {
        let at = |t: f64| {
            let until = t.min(1.0 - x[0]);
            vec![x[0] + t, x[0] * until + 0.5 * until * until + t - until]
        };
        (1..=4).map(|k| at(0.05 * f64::from(k))).collect()
    }));
    println!("clip: {ratios:?}");
    assert!(all_below(&ratios, 1.05), "{ratios:?}");
    let stop = Sampled {
        text: "format = 1\nstates = [\"x\"]\ninit.x = 0\nparams.u = [-1, 1]\nder.x = \"u - sign(x)\"\noutputs.y = \"x +- 1\""
            .to_owned(),
        start: vec![interval(-0.05, 0.1)],
        params: vec![interval(0.3, 0.6)],
        stretches: vec![(0.05, None); 8],
        parts: 1,
    };
    let ratios = worst(&stop.widths(41, &mut |x, p| {
        let sign = x[0].signum();
        let at = |t: f64| vec![sign * (x[0].abs() - (1.0 - sign * p[0]) * t).max(0.0)];
        (1..=8).map(|k| at(0.05 * f64::from(k))).collect()
    }));
    println!("stop: {ratios:?}");
    assert!(all_below(&ratios, 1.01), "{ratios:?}");
    // Some pass the line, some do not, one touches it.
    let graze = Sampled {
        text: "format = 1\nstates = [\"x\", \"y\", \"z\"]\ninit = { x = 0, y = 0, z = 0 }\n\
               der = { x = \"y\", y = \"-1\", z = \"sign(x - 0.125)\" }\noutputs.w = \"z +- 1\""
            .to_owned(),
        start: vec![interval(-0.01, 0.01), Interval::point(0.5), Interval::ZERO],
        params: vec![],
        stretches: vec![(0.125, None); 8],
        parts: 64,
    };
    let ratios = worst(&graze.widths(401, &mut |x, _| {
        let half = (2.0 * x[0]).max(0.0).sqrt();
        let at = |t: f64| {
            let above = (t - (0.5 - half)).clamp(0.0, 2.0 * half);
            vec![x[0] + 0.5 * t - 0.5 * t * t, 0.5 - t, 2.0 * above - t]
        };
        (1..=8).map(|k| at(0.125 * f64::from(k))).collect()
    }));
    println!("graze: {ratios:?}");
    assert!(all_below(&ratios, 1.01), "{ratios:?}");
}

const PENDULUM: &str = "format = 1\nstates = [\"theta\", \"omega\"]\ninit = { theta = -2, omega = -4 }\n[params]\na = [30, 70]\n\
    b = [0, 0.5]\nc = [0, 2]\n[let]\npull = \"-a*sin(theta) - b*omega\"\n[der]\ntheta = \"omega\"\n\
    omega = \"pull - friction(omega, pull, c)\"\n[outputs]\nangle = \"theta +- 1\"\n";

/// A pendulum that never rests, by steps of order four that end where it turns.
fn swing(mut x: [f64; 2], p: &[f64], dt: f64) -> [f64; 2] {
    let step = |x: [f64; 2], way: f64, h: f64| -> [f64; 2] {
        let rates = |x: [f64; 2]| [x[1], -p[0] * x[0].sin() - p[1] * x[1] - way * p[2]];
        let ahead = |k: [f64; 2], h: f64| [x[0] + h * k[0], x[1] + h * k[1]];
        let first = rates(x);
        let second = rates(ahead(first, 0.5 * h));
        let third = rates(ahead(second, 0.5 * h));
        let last = rates(ahead(third, h));
        let sum = |i: usize| first[i] + 2.0 * (second[i] + third[i]) + last[i];
        [x[0] + h * sum(0) / 6.0, x[1] + h * sum(1) / 6.0]
    };
    let mut way = x[1].signum();
    for _ in 0..16 {
        let mut left = dt / 16.0;
        let mut next = step(x, way, left);
        if next[1] * way < 0.0 {
            let (mut from, mut until) = (0.0, left);
            for _ in 0..60 {
                let middle = 0.5 * (from + until);
                match step(x, way, middle)[1] * way < 0.0 {
                    true => until = middle,
                    false => from = middle,
                }
            }
            x = step(x, way, from);
            x[1] = 0.0;
            left -= from;
            way = -way;
            next = step(x, way, left);
        }
        x = next;
    }
    x
}

/// A pendulum turns six times, at last over several samples: all solutions cross together each time, though on the surface
/// they have one velocity.
#[test]
fn a_pendulum_turns_together() {
    let around = |x: f64, share: f64| interval(x * (1.0 - share), x * (1.0 + share));
    let pendulum = Sampled {
        text: PENDULUM.into(),
        start: vec![interval(-2.0158, -2.0105), interval(-4.136, -4.117)],
        params: vec![around(48.6, 0.0005), around(0.017, 0.1), around(0.48, 0.03)],
        stretches: vec![(0.00667, None); 400],
        parts: 1,
    };
    let widths = pendulum.widths(2, &mut |x, p| {
        let mut x = [x[0], x[1]];
        let samples = (0..400).map(|_| {
            x = swing(x, p, 0.00667);
            x.to_vec()
        });
        samples.collect()
    });
    let ratios = worst(&widths);
    println!("pendulum: {ratios:?}");
    assert!(all_below(&ratios, 1.3), "{ratios:?}");
}
