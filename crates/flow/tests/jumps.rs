//! Jumps of the state: exact trajectories stay inside, at impacts, at rest, at grazing.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod common;

use common::{Rng, interval, read};
use veribound_flow::{StepOptions, System, Workspace, reduced};
use veribound_interval::Interval;

const BALL: &str = r#"
    format = 1
    states = ["h", "v"]
    inputs = ["g"]
    init = { h = 1, v = 0 }
    params = { e = [0, 1] }
    outputs = { y = "h +- 1" }
    [der]
    h = "v"
    v = "-g"
    [jumps]
    bounce = { when = "h <= 0 and v < 0", set = { v = "-e*v" } }
"#;

/// A set of boxes that follows solutions.
struct Follower {
    system: System,
    workspace: Workspace,
    boxes: Vec<Vec<Interval>>,
    tube: Vec<Interval>,
}

impl Follower {
    fn new(text: &str, start: Vec<Interval>, longest: f64) -> Follower {
        let system = System::new(&read("jumping", text));
        let options = StepOptions {
            longest,
            ..StepOptions::default()
        };
        Follower {
            workspace: Workspace::new(&system, options),
            system,
            tube: start.clone(),
            boxes: vec![start],
        }
    }

    fn step(&mut self, params: &[Interval], inputs: &[Interval], h: f64) {
        let mut next = Vec::new();
        let mut tube: Option<Vec<Interval>> = None;
        for states in &self.boxes {
            let (system, w) = (&self.system, &mut self.workspace);
            let ends = system.step_apart(states, params, inputs, Interval::point(h), w);
            next.extend(
                ends.unwrap_or_else(|failure| panic!("{failure:?} from {states:?}"))
                    .0,
            );
            let own = w.tube().to_vec();
            tube = Some(match tube {
                None => own,
                Some(all) => all.iter().zip(&own).map(|(a, b)| a.hull(*b)).collect(),
            });
        }
        self.boxes = reduced(next);
        self.tube = tube.unwrap();
    }

    fn contains(&self, x: &[f64], slack: f64) -> bool {
        self.boxes.iter().any(|b| inside(b, x, slack))
    }

    fn hull(&self, state: usize) -> Interval {
        let all = self.boxes.iter().map(|b| b[state]);
        all.fold(Interval::EMPTY, Interval::hull)
    }
}

fn inside(b: &[Interval], x: &[f64], slack: f64) -> bool {
    let near = interval(-slack, slack);
    b.iter().zip(x).all(|(b, x)| (*b + near).contains(*x))
}

/// A ball in flight; after less than `REST` between two impacts it is at rest.
#[derive(Clone, Copy)]
struct Ball {
    h: f64,
    v: f64,
}

const REST: f64 = 1e-9;

impl Ball {
    fn fly(&mut self, mut time: f64, g: f64, e: f64) {
        while time > 0.0 {
            // The later root of h + v t - g t^2/2.
            let impact = (self.v + (self.v * self.v + 2.0 * g * self.h).max(0.0).sqrt()) / g;
            if impact > time {
                self.h = (self.h + self.v * time - 0.5 * g * time * time).max(0.0);
                self.v -= g * time;
                return;
            }
            if impact < REST {
                (self.h, self.v) = (0.0, 0.0);
                return;
            }
            time -= impact;
            self.h = 0.0;
            self.v = -e * (self.v - g * impact);
        }
    }
}

#[test]
fn a_bouncing_ball_stays_inside() {
    let mut rng = Rng(1);
    let mut impacts = 0;
    for case in 0..60 {
        let step = rng.pick(&[0.01, 0.05, 0.1]);
        let width = rng.pick(&[0.0, 1e-6, 1e-2, 0.2]);
        let near = |x: f64, w: f64| interval(x, x + w);
        let start = vec![
            near(rng.between(0.0, 1.0), width),
            near(rng.between(-2.0, 2.0), width),
        ];
        let g = near(rng.between(5.0, 10.0), 0.1 * width);
        let e = near(rng.between(0.0, 0.9), 0.1 * width);
        let mut follower = Follower::new(BALL, start.clone(), rng.pick(&[0.002, 0.01, 0.05]));
        let mut balls: Vec<(Ball, f64, f64)> = (0..20)
            .map(|_| {
                let (h, v) = (rng.inside(start[0]), rng.inside(start[1]));
                (Ball { h, v }, rng.inside(g), rng.inside(e))
            })
            .collect();
        for k in 0..(1.0 / step) as usize {
            follower.step(&[e], &[g], step);
            for (ball, g, e) in &mut balls {
                let before = ball.v;
                for part in [0.3, 0.7] {
                    ball.fly(part * step, *g, *e);
                    let x = [ball.h, ball.v];
                    assert!(
                        inside(&follower.tube, &x, 1e-7),
                        "case {case}, step {k}: {x:?}"
                    );
                }
                impacts += usize::from(before < 0.0 && ball.v > 0.0);
                let x = [ball.h, ball.v];
                assert!(
                    follower.contains(&x, 1e-7),
                    "case {case}, step {k}: {x:?} not in {:?}",
                    follower.boxes
                );
            }
        }
    }
    assert!(impacts > 1000, "only {impacts} impacts");
}

/// From a point the bounds stay thin over several impacts, and an impact at the border of a step tears
/// nothing.
#[test]
fn impacts_are_located() {
    let point = |x: f64| Interval::point(x);
    let mut follower = Follower::new(BALL, vec![point(1.0), point(0.0)], 0.01);
    let mut ball = Ball { h: 1.0, v: 0.0 };
    let mut widest = 0.0_f64;
    for _ in 0..150 {
        follower.step(&[point(0.75)], &[point(10.0)], 0.01);
        ball.fly(0.01, 10.0, 0.75);
        assert!(follower.contains(&[ball.h, ball.v], 1e-9));
        widest = widest.max(
            follower
                .boxes
                .iter()
                .map(|b| b[1].width())
                .fold(0.0, f64::max),
        );
    }
    assert!(widest < 1e-6, "{widest:e}");
}

/// Where a bounce takes more than half of the energy, rest is a box that stays as small as rounding;
/// else a box cannot hold what a ball in it may do, but what is enclosed stays enclosed.
#[test]
fn a_ball_at_rest_stays_at_rest() {
    for (e, steps, largest) in [
        (0.0, 200, 1e-14),
        (0.5, 200, 1e-14),
        (0.65, 200, 1e-9),
        (0.9, 20, 4.0),
    ] {
        let mut follower = Follower::new(BALL, vec![Interval::ZERO; 2], 0.01);
        for _ in 0..steps {
            follower.step(&[Interval::point(e)], &[Interval::point(9.81)], 0.01);
            assert!(follower.contains(&[0.0, 0.0], 0.0));
        }
        assert!(
            follower.hull(1).mag() < largest,
            "{e}: {}",
            follower.hull(1)
        );
        assert!(follower.hull(0).lo() >= 0.0);
    }
}

/// It also comes to rest: infinitely many impacts in finite time are passed.
#[test]
fn a_ball_comes_to_rest() {
    let point = |x: f64| Interval::point(x);
    let mut follower = Follower::new(BALL, vec![point(0.2), point(0.0)], 0.01);
    for _ in 0..100 {
        follower.step(&[point(0.5)], &[point(9.81)], 0.01);
    }
    assert!(follower.contains(&[0.0, 0.0], 0.0));
    assert!(follower.hull(1).mag() < 1e-5, "{}", follower.hull(1));
}

const HEATING: &str = r#"
    format = 1
    states = ["T", "on"]
    inputs = ["outside"]
    init = { T = 20, on = 0 }
    params = { k = [0.1, 2], power = [5, 60] }
    outputs = { y = "T +- 1" }
    [der]
    T = "-k*(T - outside) + power*on"
    on = "0"
    [jumps]
    start = { when = "T < 19 and on < 0.5", set = { on = "1" } }
    stop = { when = "T > 21 and on > 0.5", set = { on = "0" } }
"#;

/// A relay with hysteresis is a state that jumps: its memory is always exactly 0 or 1.
#[test]
fn a_thermostat_remembers() {
    let mut rng = Rng(3);
    let mut switched = 0;
    for case in 0..60 {
        let width = rng.pick(&[0.0, 1e-3, 0.1, 1.5]);
        let near = |x: f64, w: f64| interval(x, x + w);
        let start = near(rng.between(17.5, 21.0), width);
        let on = f64::from(u8::from(rng.chance(0.5)));
        let k = near(rng.between(0.1, 1.0), 0.01 * width);
        let outside = near(rng.between(-5.0, 10.0), 0.0);
        let power = near(rng.between(30.0, 50.0), 0.0);
        let first = vec![start, Interval::point(on)];
        let step = rng.pick(&[0.01, 0.05]);
        let mut follower = Follower::new(HEATING, first, 0.05);
        let mut truths: Vec<([f64; 2], f64)> = (0..10)
            .map(|_| ([rng.inside(start), on], rng.inside(k)))
            .collect();
        let jump = |x: &mut [f64; 2]| {
            if x[0] < 19.0 && x[1] < 0.5 {
                x[1] = 1.0;
            } else if x[0] > 21.0 && x[1] > 0.5 {
                x[1] = 0.0;
            }
        };
        for n in 0..60 {
            follower.step(&[k, power], &[outside], step);
            for b in &follower.boxes {
                assert!(b[1] == Interval::ZERO || b[1] == Interval::ONE, "{b:?}");
            }
            for (x, k) in &mut truths {
                let before = x[1];
                jump(x);
                let mut left = step;
                loop {
                    let rest = outside.mid() + power.mid() * x[1] / *k;
                    let at = |t: f64| rest + (x[0] - rest) * (-*k * t).exp();
                    let border = if x[1] > 0.5 { 21.0 } else { 19.0 };
                    let until = ((x[0] - rest) / (border - rest)).ln() / *k;
                    if !(until > 0.0 && until < left) {
                        x[0] = at(left);
                        break;
                    }
                    left -= until;
                    *x = [border, 1.0 - x[1]];
                }
                switched += usize::from(before != x[1]);
                assert!(
                    follower.contains(&x[..], 1e-9),
                    "case {case}, step {n}: {x:?} not in {:?}",
                    follower.boxes
                );
                assert!(
                    inside(&follower.tube, &x[..], 1e-9),
                    "case {case}, step {n}"
                );
            }
        }
    }
    assert!(switched > 100, "only {switched} switches");
}

const STOPS: &str = r#"
    format = 1
    states = ["x", "v"]
    inputs = ["F"]
    init = { x = 0, v = 0 }
    outputs = { y = "x +- 1" }
    [der]
    x = "v"
    v = "F"
    [jumps]
    lower = { when = "x <= 0 and v < 0", set = { v = "0" } }
    upper = { when = "x >= 1 and v > 0", set = { v = "0" } }
"#;

/// A mass that is pushed against stops without bouncing rests there, and leaves when it is pulled.
#[test]
fn a_mass_between_end_stops() {
    let mut rng = Rng(4);
    let (mut resting, mut leaving) = (0, 0);
    for case in 0..40 {
        let width = rng.pick(&[0.0, 1e-3, 0.05]);
        let x = rng.between(0.0, 0.9);
        let start = vec![interval(x, x + width), interval(-0.1, -0.1 + width)];
        let mut follower = Follower::new(STOPS, start.clone(), 0.005);
        let mut truths: Vec<[f64; 2]> = (0..10)
            .map(|_| [rng.inside(start[0]), rng.inside(start[1])])
            .collect();
        let mut force = rng.between(-8.0, 8.0);
        for n in 0..100 {
            if rng.chance(0.1) {
                force = rng.between(-8.0, 8.0);
            }
            follower.step(&[], &[Interval::point(force)], 0.02);
            for truth in &mut truths {
                let was_resting = truth[1] == 0.0;
                slide(truth, force, 0.02);
                resting += usize::from(truth[1] == 0.0);
                leaving += usize::from(was_resting && truth[1] != 0.0);
                assert!(
                    follower.contains(&truth[..], 1e-8),
                    "case {case}, step {n}: {truth:?} not in {:?}",
                    follower.boxes
                );
            }
        }
        let (x, v) = (follower.hull(0), follower.hull(1));
        assert!(x.lo() >= 0.0 && x.hi() <= 1.0, "case {case}: {x}");
        assert!(v.mag() < 6.0, "case {case}: {v}");
    }
    assert!(resting > 1000 && leaving > 100, "{resting} {leaving}");
}

/// Constant force between plastic stops, in closed form.
fn slide(x: &mut [f64; 2], force: f64, time: f64) {
    let mut left = time;
    for _ in 0..3 {
        let [position, v] = *x;
        let at_stop = (position <= 0.0 && v <= 0.0) || (position >= 1.0 && v >= 0.0);
        let outward = if position <= 0.0 {
            force < 0.0
        } else {
            force > 0.0
        };
        if at_stop {
            *x = [position.clamp(0.0, 1.0), 0.0];
            if outward {
                return;
            }
        }
        let [position, v] = *x;
        // The first time after now at which a stop is met from inside.
        let meet = |stop: f64, towards: f64| {
            let (a, b, c) = (0.5 * force, v, position - stop);
            let root = (b * b - 4.0 * a * c).sqrt();
            let roots = [(-b - root) / (2.0 * a), (-b + root) / (2.0 * a)];
            let inward = |t: &f64| *t > 1e-12 && (v + force * t) * towards > 0.0;
            roots
                .into_iter()
                .filter(inward)
                .fold(f64::INFINITY, f64::min)
        };
        let (to, stop) = [(meet(0.0, -1.0), 0.0), (meet(1.0, 1.0), 1.0)]
            .into_iter()
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap();
        if to >= left {
            *x = [
                position + v * left + 0.5 * force * left * left,
                v + force * left,
            ];
            return;
        }
        *x = [stop, 0.0];
        left -= to;
    }
}

/// A condition on an input holds at once when the input changes.
#[test]
fn an_input_can_set_a_memory() {
    let text = r#"
        format = 1
        states = ["x", "m"]
        inputs = ["u"]
        init = { x = 0, m = 0 }
        outputs = { y = "x +- 1" }
        der = { x = "m", m = "0" }
        jumps.set = { when = "u > 1 and m < 0.5", set = { m = "1" } }
    "#;
    let mut follower = Follower::new(text, vec![Interval::ZERO; 2], 0.05);
    follower.step(&[], &[Interval::point(0.5)], 0.25);
    assert_eq!(follower.boxes, [vec![Interval::ZERO; 2]]);
    follower.step(&[], &[Interval::point(2.0)], 0.25);
    assert_eq!(follower.boxes.len(), 1, "{:?}", follower.boxes);
    assert!(follower.contains(&[0.25, 1.0], 0.0));
    assert!(follower.hull(0).width() < 1e-12, "{}", follower.hull(0));
    // Where the input may or may not be above, both are kept.
    let mut follower = Follower::new(text, vec![Interval::ZERO; 2], 0.05);
    follower.step(&[], &[interval(0.5, 1.5)], 0.25);
    assert!(follower.contains(&[0.0, 0.0], 0.0) && follower.contains(&[0.25, 1.0], 0.0));
    assert!(follower.contains(&[0.1, 1.0], 0.0));
}
