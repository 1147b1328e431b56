//! Sets of which some solutions stop for good and others turn once more.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod common;

use common::{Rng, Trials, interval, number, read};
use veribound_flow::form::{Effort, Enclosure, Flow, FormOptions, Stretch};
use veribound_interval::Interval;

const PENDULUM: &str = r#"
format = 1
states = ["theta", "omega"]
[init]
theta = 1
omega = 0
[params]
a = [40, 60]
b = [0, 0.1]
c = [0, 1]
[der]
theta = "omega"
omega = "-a*sin(theta) - b*omega - friction(omega, -a*sin(theta), c)"
[outputs]
angle = "theta +- 0.003"
"#;

/// Those of the measured pendulum.
const MIDDLE: [f64; 3] = [48.61, 0.0174, 0.483];

/// Seconds between samples.
const DT: f64 = 0.01;

/// A pendulum let go at rest, in plain floating point with every stop located.
#[derive(Clone, Copy)]
struct Swing {
    theta: f64,
    omega: f64,
    /// Sign of the speed; zero while it stands.
    side: f64,
    p: [f64; 3],
    turns: u32,
}

impl Swing {
    fn new(theta: f64, p: [f64; 3]) -> Swing {
        let mut swing = Swing {
            theta,
            omega: 0.0,
            side: 0.0,
            p,
            turns: 0,
        };
        swing.turn();
        swing
    }

    fn rate(&self, x: [f64; 2]) -> [f64; 2] {
        let [a, b, c] = self.p;
        [x[1], -a * x[0].sin() - b * x[1] - c * self.side]
    }

    fn stepped(&self, h: f64) -> [f64; 2] {
        let at = |x: [f64; 2], k: [f64; 2], h: f64| [x[0] + h * k[0], x[1] + h * k[1]];
        let x = [self.theta, self.omega];
        let k1 = self.rate(x);
        let k2 = self.rate(at(x, k1, h / 2.0));
        let k3 = self.rate(at(x, k2, h / 2.0));
        let k4 = self.rate(at(x, k3, h));
        [0, 1].map(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
    }

    fn turn(&mut self) {
        let pull = -self.p[0] * self.theta.sin();
        let is_held = pull.abs() <= self.p[2];
        self.side = if is_held { 0.0 } else { pull.signum() };
        self.omega = 0.0;
        self.turns += 1;
    }

    fn advance(&mut self, mut left: f64) {
        while left > 0.0 && self.side != 0.0 {
            let h = left.min(1e-3);
            let next = self.stepped(h);
            if next[1] * self.side > 0.0 {
                [self.theta, self.omega] = next;
                left -= h;
                continue;
            }
            let (mut lo, mut hi) = (0.0, h);
            for _ in 0..60 {
                let middle = 0.5 * (lo + hi);
                if self.stepped(middle)[1] * self.side > 0.0 {
                    lo = middle;
                } else {
                    hi = middle;
                }
            }
            self.theta = self.stepped(hi)[0];
            left -= hi;
            self.turn();
        }
    }

    fn turns_until(mut self, end: f64) -> u32 {
        self.advance(end);
        self.turns
    }
}

/// Pendulums with parameters in a box that start at one angle.
struct Set {
    theta: f64,
    params: [Interval; 3],
    samples: usize,
}

impl Set {
    fn new(theta: f64, relative: f64, seconds: f64) -> Set {
        let params = MIDDLE.map(|x| interval(x * (1.0 - relative), x * (1.0 + relative)));
        let samples = (seconds / DT).round() as usize;
        Set {
            theta,
            params,
            samples,
        }
    }

    fn enclose(&self, parts: usize, degree: Option<usize>) -> Enclosure {
        let flow = Flow::new(&read("pendulum", PENDULUM));
        let stretch = Stretch {
            inputs: vec![],
            dt: Interval::point(DT),
        };
        let start = [Interval::point(self.theta), Interval::ZERO];
        let effort = Effort {
            parts,
            ..Effort::default()
        };
        let options = FormOptions {
            degree,
            ..FormOptions::default()
        };
        let found = flow.enclose(
            &start,
            &self.params,
            &vec![stretch; self.samples],
            options,
            effort,
        );
        assert!(found.stopped.is_none(), "{:?}", found.stopped);
        found
    }

    fn at(&self, share: [f64; 3]) -> Swing {
        let p = [0, 1, 2].map(|i| {
            let x = self.params[i];
            (x.lo() + (x.hi() - x.lo()) * share[i]).clamp(x.lo(), x.hi())
        });
        Swing::new(self.theta, p)
    }

    /// A grid of them; and where two turn another number of times, some that are on the border in between.
    fn solutions(&self, rng: &mut Rng) -> Vec<Swing> {
        let end = self.samples as f64 * DT;
        let grid = |k: u32| [k % 3, k / 3 % 3, k / 9].map(|k| f64::from(k) / 2.0);
        let mut list: Vec<[f64; 3]> = (0..27).map(grid).collect();
        let turns: Vec<u32> = list.iter().map(|s| self.at(*s).turns_until(end)).collect();
        let between =
            |a: [f64; 3], b: [f64; 3], k: f64| [0, 1, 2].map(|i| a[i] + k * (b[i] - a[i]));
        for _ in 0..30 {
            let (i, l) = (rng.below(27), rng.below(27));
            let (first, last) = (list[i], list[l]);
            if turns[i] == turns[l] {
                continue;
            }
            let (mut lo, mut hi) = (0.0, 1.0);
            for _ in 0..50 {
                let middle = 0.5 * (lo + hi);
                if self.at(between(first, last, middle)).turns_until(end) == turns[i] {
                    lo = middle;
                } else {
                    hi = middle;
                }
                if rng.chance(0.3) {
                    list.push(between(first, last, middle));
                }
            }
            list.push(between(first, last, lo));
            list.push(between(first, last, hi));
        }
        list.into_iter().map(|share| self.at(share)).collect()
    }

    /// Stops where a solution is lost; the hull of all of them at every sample.
    fn sampled(&self, found: &Enclosure, rng: &mut Rng, trials: &mut Trials) -> Vec<[Interval; 2]> {
        let mut solutions = self.solutions(rng);
        let mut hulls = Vec::new();
        trials.solutions += solutions.len() as u64;
        trials.checks += 2 * (solutions.len() * found.ends.len()) as u64;
        for (end, tube) in found.ends.iter().zip(&found.tubes) {
            let mut hull = [Interval::EMPTY; 2];
            for swing in &mut solutions {
                swing.advance(DT);
                for (i, x) in [swing.theta, swing.omega].into_iter().enumerate() {
                    let is_inside = |bounds: Interval| bounds.inflate(4e-9).contains(x);
                    assert!(
                        is_inside(end[i]) && is_inside(tube[i]),
                        "state {i}: {x:?} in {:?} {:?} with {:?} from {}, sample {}",
                        end[i],
                        tube[i],
                        swing.p,
                        self.theta,
                        hulls.len()
                    );
                    hull[i] = hull[i].hull(Interval::point(x));
                }
            }
            hulls.push(hull);
        }
        hulls
    }

    /// The worst of width proved over width sampled, for the angle, and where it is.
    fn worst(&self, parts: usize, rng: &mut Rng) -> (f64, usize) {
        let found = self.enclose(parts, None);
        let hulls = self.sampled(&found, rng, &mut Trials::default());
        let ratios = hulls
            .iter()
            .zip(&found.ends)
            .map(|(inner, outer)| (outer[0].width() - 1e-8) / inner[0].width());
        let ratios = ratios.enumerate().map(|(k, ratio)| (ratio, k));
        ratios.fold(
            (0.0, 0),
            |worst, own| if own.0 > worst.0 { own } else { worst },
        )
    }
}

/// Thirty seconds from a radian: 41 turns, until all stand.
#[test]
fn a_pendulum_comes_to_rest() {
    let mut rng = Rng(3);
    let worst = Set::new(1.0, 0.5e-3, 30.0).worst(64, &mut rng);
    println!("{worst:?}");
    assert!(worst.0 < 1.05, "{worst:?}");
}

/// At the last turn some stay, and others turn once more.
#[test]
fn a_pendulum_stays_or_turns_once_more() {
    let mut rng = Rng(4);
    for theta in [0.11045, 0.1105, 0.1106] {
        let set = Set::new(theta, 0.5e-3, 30.0);
        let worst = set.worst(64, &mut rng);
        println!("{worst:?}");
        assert!(worst.0 < 1.05, "{theta}: {worst:?}");
    }
}

/// Random sets, few parts or many: those that hesitate longest are not lost.
#[test]
fn no_solution_is_lost_where_outcomes_part() {
    let mut rng = Rng(number("VERIBOUND_SEED", 5));
    let (mut parted, mut trials) = (0, Trials::default());
    for _ in 0..number("VERIBOUND_ROUNDS", 24) {
        let relative = rng.pick(&[1e-5, 1e-4, 1e-3]);
        // From where some pendulum of the set is between turning once more and not.
        let turns = |theta: f64| Swing::new(theta, MIDDLE).turns_until(3.0);
        let (mut lo, mut hi) = (rng.between(0.05, 0.07), 0.1);
        let few = turns(lo);
        for _ in 0..50 {
            let middle = 0.5 * (lo + hi);
            if turns(middle) == few {
                lo = middle;
            } else {
                hi = middle;
            }
        }
        let theta = lo * (1.0 + relative * rng.between(-1.0, 1.0)) * rng.pick(&[1.0, -1.0]);
        let set = Set::new(theta, relative, 3.0);
        let degree = rng.pick(&[None, Some(2), Some(4)]);
        let found = set.enclose(rng.pick(&[8, 16, 64]), degree);
        set.sampled(&found, &mut rng, &mut trials);
        // What was between stays between.
        parted += usize::from(found.ends.last().unwrap()[1].width() > 0.0);
    }
    println!("{parted} sets parted");
    trials.told("sets whose outcomes part");
    assert!(parted > 12);
}
