//! Problems whose solution is known in closed form (BM18 and more).

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod common;

use common::models::{SLIDING, STAIRS, UNSTABLE};
use common::{RigText, Rng, interval, read, rig_step};
use veribound_flow::{StepOptions, System, Workspace};
use veribound_interval::Interval;

/// Rounding of the closed forms, which are evaluated in plain floating point.
const SLACK: f64 = 1e-13;

fn system(text: &str) -> System {
    System::new(&read("closed form", text))
}

/// One state, one equation, no output worth mentioning.
fn scalar(der: &str) -> System {
    system(&format!(
        "format = 1\n[states]\nx = {{ init = 0, domain = [-100, 100] }}\n[params]\np = [-10, 10]\n\
         [der]\nx = \"{der}\"\n[outputs]\ny = \"x +- 1\"\n"
    ))
}

struct Run {
    states: Vec<Interval>,
    params: Vec<Interval>,
    workspace: Workspace,
}

impl Run {
    fn new(system: &System, options: StepOptions, states: &[Interval], params: &[Interval]) -> Run {
        Run {
            states: states.to_vec(),
            params: params.to_vec(),
            workspace: Workspace::new(system, options),
        }
    }

    fn step(&mut self, system: &System, inputs: &[Interval], h: f64) {
        let dt = Interval::point(h);
        let (x, p) = (&mut self.states, &self.params);
        system.step(x, p, inputs, dt, &mut self.workspace).unwrap();
    }

    fn has(&self, state: usize, x: f64) -> bool {
        let b = self.states[state];
        let slack = SLACK * (1.0 + x.abs());
        b.lo() - slack <= x && x <= b.hi() + slack
    }
}

fn default() -> StepOptions {
    StepOptions::default()
}

/// Auer, Kiel, Rauh, AMCS 23(4) 2013, as noted in the project's mathematics 1.11.
#[test]
fn the_clip_problem() {
    let system = system(
        "format = 1\n[states]\nx = { init = 0 }\ny = { init = 0 }\n\
         [der]\nx = \"1\"\ny = \"min(max(x, -1), 1)\"\n[outputs]\nz = \"y +- 1\"\n",
    );
    for parts in [1, 4, 20, 57] {
        let h = 0.2 / f64::from(parts);
        let start = [interval(0.9, 0.91), Interval::ZERO];
        let mut run = Run::new(&system, default(), &start, &[]);
        for _ in 0..parts {
            run.step(&system, &[], h);
        }
        let y = run.states[1];
        assert!(
            y.lo() <= 0.195 + SLACK && y.hi() >= 0.195_95 - SLACK,
            "{y:?}"
        );
        if parts >= 20 {
            assert!(y.lo() >= 0.194_487_5 && y.hi() <= 0.196_487_5, "{y:?}");
        }
    }
}

#[test]
fn dry_friction_stops_in_finite_time_and_stays() {
    let system = system(
        "format = 1\n[states]\nx = { init = 0 }\n[inputs]\nu = { error = 0 }\n\
         [der]\nx = \"u - sign(x)\"\n[outputs]\ny = \"x +- 1\"\n",
    );
    for (x0, u) in [
        (0.1, 0.5),
        (-0.1, 0.5),
        (0.03, -0.999),
        (0.0, 0.25),
        (1e-9, 0.75),
    ] {
        for h in [0.01, 0.05, 0.2, 1.0] {
            let mut run = Run::new(&system, default(), &[Interval::point(x0)], &[]);
            let sign = f64::signum(x0);
            let speed = 1.0 - sign * u;
            for k in 1..=(2.0_f64 / h) as u32 {
                run.step(&system, &[Interval::point(u)], h);
                let t = f64::from(k) * h;
                let x = sign * (x0.abs() - speed * t).max(0.0);
                assert!(run.has(0, x), "{x} at {t}: {:?}", run.states);
                if t > x0.abs() / speed + h {
                    assert_eq!(run.states[0], Interval::ZERO, "it stays");
                }
            }
        }
    }
    // Any measurable input below the level: it stops all the same.
    let mut run = Run::new(&system, default(), &[interval(-0.1, 0.1)], &[]);
    for _ in 0..100 {
        run.step(&system, &[interval(-0.5, 0.5)], 0.01);
    }
    assert_eq!(run.states[0], Interval::ZERO);
    // At the level it may creep away on one side only.
    for _ in 0..10 {
        run.step(&system, &[interval(0.5, 1.0)], 0.01);
    }
    assert_eq!(run.states[0], Interval::ZERO);
    run.step(&system, &[interval(0.5, 1.5)], 0.01);
    assert!(run.states[0].lo() == 0.0 && run.states[0].hi() >= 0.005);
}

#[test]
fn grazing_a_line_where_something_else_switches() {
    let system = system(
        "format = 1\n[states]\nx = { init = 0 }\ny = { init = 0 }\nz = { init = 0 }\n\
         [params]\nline = [0, 1]\n\
         [der]\nx = \"y\"\ny = \"-1\"\nz = \"sign(x - line)\"\n[outputs]\nw = \"z +- 1\"\n",
    );
    // The flight reaches 1/8 at t = 1/2.
    for gap in [0.0, 1e-3, -1e-3, 1e-6, -1e-6, 1e-12, -1e-12, 0.05] {
        for h in [0.01, 0.025, 0.1, 1.0] {
            let line = 0.125 - gap;
            let start = [Interval::ZERO, Interval::point(0.5), Interval::ZERO];
            let mut run = Run::new(&system, default(), &start, &[Interval::point(line)]);
            let half = f64::sqrt(2.0 * gap.max(0.0));
            for k in 1..=(1.0_f64 / h).round() as u32 {
                run.step(&system, &[], h);
                let t = f64::from(k) * h;
                let above = (t - (0.5 - half)).clamp(0.0, 2.0 * half);
                let z = 2.0 * above - t;
                assert!((z - run.states[2].mid()).abs() <= run.states[2].rad() + 1e-9);
                assert!(run.has(0, 0.5 * t - 0.5 * t * t) && run.has(1, 0.5 - t));
            }
        }
    }
}

/// `x' = Sgn(x)` from zero: `±(t - τ)+` for every `τ` is a solution.
#[test]
fn unstable_switching_keeps_every_departure() {
    let system = System::new(&read(UNSTABLE.name, UNSTABLE.text));
    for h in [0.01, 0.2] {
        let start = [Interval::ZERO, Interval::ZERO];
        let params = [Interval::ONE, Interval::ZERO];
        let mut run = Run::new(&system, default(), &start, &params);
        for k in 1..=10 {
            run.step(&system, &[Interval::ZERO], h);
            let t = f64::from(k) * h;
            assert!(run.has(0, t) && run.has(0, -t));
            assert!(
                run.states[0].width() <= 2.0 * t + 1e-12,
                "no more than needed"
            );
        }
    }
}

/// While `x1` is held at its level, `x2' = c a / b`.
#[test]
fn sliding_moves_other_components_inside_the_hull() {
    let system = System::new(&read(SLIDING.name, SLIDING.text));
    let level = read("level", SLIDING.text).modes.len();
    assert_eq!(level, 2);
    for (a, b, c) in [
        (0.5, 2.0, 3.0),
        (-1.9, 2.0, -4.0),
        (0.0, 1.0, 1.0),
        (2.0, 2.0, 1.0),
    ] {
        let params = [a, b, c].map(Interval::point);
        let start = [
            interval(0.3_f64.next_down(), 0.3),
            Interval::ZERO,
            Interval::ZERO,
        ];
        let mut run = Run::new(&system, default(), &start, &params);
        let (mut x2, mut x3) = (0.0, 0.0);
        for _ in 0..10 {
            run.step(&system, &[], 0.01);
            // x2' = c s + x3, x3' = x2 - c s x3 with s = a/b, by small Euler-Richardson steps.
            let s = a / b;
            for _ in 0..1000 {
                let d = 1e-5;
                let (m2, m3) = (
                    x2 + d / 2.0 * (c * s + x3),
                    x3 + d / 2.0 * (x2 - c * s * x3),
                );
                x2 += d * (c * s + m3);
                x3 += d * (m2 - c * s * m3);
            }
            assert!((x2 - run.states[1].mid()).abs() <= run.states[1].rad() + 1e-9);
            assert!((x3 - run.states[2].mid()).abs() <= run.states[2].rad() + 1e-9);
            assert!((0.3 - run.states[0].mid()).abs() <= run.states[0].rad() + 1e-15);
            // Rounding apart, the held state does not move; at |a| = |b| it may not be held.
            if a.abs() < b {
                assert!(run.states[0].width() < 1e-15, "{:?}", run.states[0]);
            }
        }
    }
}

/// Two relays on levels next to each other, both attractive from outside: trapped between.
#[test]
fn trapped_between_two_levels() {
    let system = System::new(&read(STAIRS.name, STAIRS.text));
    let params = [0.0, -1.0, -1.0].map(Interval::point);
    let start = [interval(0.0, 0.2), Interval::ZERO];
    let mut run = Run::new(&system, default(), &start, &params);
    for _ in 0..100 {
        run.step(&system, &[interval(-1.5, 1.5)], 0.01);
    }
    let x = run.states[0];
    assert!(x.lo() <= 0.1 && x.hi() >= 0.1001 - 1e-15, "{x:?}");
    assert!(x.lo() >= 0.1 - 1e-15 && x.hi() <= 0.1001 + 1e-15, "{x:?}");
}

/// The rig stops exactly at a sample, or a moment before or after it.
#[test]
fn the_rig_stops_at_a_sample() {
    let system = System::new(&RigText::default().model());
    for explicit in [true, false] {
        let system = if explicit {
            system.clone()
        } else {
            System::new(
                &RigText {
                    explicit,
                    ..RigText::default()
                }
                .model(),
            )
        };
        for (a, b, level, u) in [
            (-2.0, 200.0, 0.15, 0.0),
            (-2.0, 200.0, 0.15, 0.15),
            (-0.05, 400.0, 0.3, -0.3),
            (-6.0, 1.0, 0.001, -0.2),
        ] {
            let c = b * (u - level) / a;
            for at in [0.01_f64, 0.0099999, 0.0100001, 0.05, 1e-9] {
                let w = if c > 0.0 {
                    c * (-a * at).exp_m1()
                } else {
                    0.01
                };
                for w in [w, w.next_up(), w.next_down()] {
                    let start = [Interval::ZERO, Interval::point(w)];
                    let params = [a, b, level].map(Interval::point);
                    let mut run = Run::new(&system, default(), &start, &params);
                    let (mut phi, mut omega) = (0.0, w);
                    for _ in 0..8 {
                        run.step(&system, &[Interval::point(u)], 0.01);
                        (phi, omega) = rig_step(phi, omega, u, [a, b, level], 0.01);
                        assert!(run.has(0, phi), "{phi} {:?}", run.states);
                        assert!(run.has(1, omega), "{omega} {:?}", run.states);
                    }
                    if c > 0.0 && u.abs() <= level && at < 0.02 {
                        assert!(run.states[1].mag() < 1e-13, "it stands: {:?}", run.states);
                    }
                }
            }
        }
    }
}

/// Two masses held by their own friction against a spring: nothing moves, in any step.
#[test]
fn a_chain_in_stick_stands() {
    let target = common::models::CHAIN;
    let system = System::new(&read(target.name, target.text));
    let start = [
        interval(0.0, 0.01),
        Interval::ZERO,
        interval(0.0, 0.01),
        Interval::ZERO,
    ];
    let params = [
        interval(1.0, 50.0),
        interval(0.0, 0.1),
        interval(1.6, 2.0),
        interval(0.6, 2.0),
    ];
    let mut run = Run::new(&system, default(), &start, &params);
    for _ in 0..500 {
        run.step(&system, &[interval(-1.0, 1.0)], 0.01);
    }
    assert_eq!(run.states[1], Interval::ZERO);
    assert_eq!(run.states[3], Interval::ZERO);
    assert!(run.states[0].width() < 0.01 + 1e-9);
}

/// Static friction above the sliding level: between the two a mass at rest may stay or start.
#[test]
fn friction_holds_up_to_its_static_level() {
    let system = system(
        r#"
format = 1
states = ["v"]
inputs = ["u"]
[init]
v = 0
[der]
v = "u - friction(v, u, 1, 2)"
[outputs]
v_m = "v +- 0.1"
"#,
    );
    for (drive, slowest, fastest) in [
        (0.5, 0.0, 0.0),
        (1.5, 0.0, 0.5),
        (-1.5, -0.5, 0.0),
        (3.0, 2.0, 2.0),
        (2.0, 0.0, 1.0),
        (-2.5, -1.5, -1.5),
    ] {
        let mut run = Run::new(&system, default(), &[Interval::ZERO], &[]);
        for _ in 0..10 {
            run.step(&system, &[Interval::point(drive)], 0.125);
        }
        let end = run.states[0];
        let exact = interval(slowest * 1.25, fastest * 1.25);
        assert!(exact.is_subset_of(end), "{drive}: {end} for {exact}");
        assert!(end.is_subset_of(exact.inflate(1e-12)), "{drive}: {end}");
    }
}

type Flow = fn(f64, f64, f64) -> f64;

/// `x' = f(x, p)` and its flow `(x0, p, t)`.
const FLOWS: [(&str, f64, f64, Flow); 38] = [
    ("p*x", 0.7, -1.3, |x, p, t| x * (p * t).exp()),
    ("p*x", -0.7, 2.3, |x, p, t| x * (p * t).exp()),
    ("p*x*(1 - x)", 0.3, 2.0, |x, p, t| {
        x / (x + (1.0 - x) * (-p * t).exp())
    }),
    ("x^2", 0.8, 0.0, |x, _, t| x / (1.0 - x * t)),
    ("x^3", -0.8, 0.0, |x, _, t| {
        x / (1.0 - 2.0 * x * x * t).sqrt()
    }),
    ("-x^2", -0.4, 0.0, |x, _, t| x / (1.0 + x * t)),
    ("exp(-x)", 0.2, 0.0, |x, _, t| (x.exp() + t).ln()),
    ("exp(p*x)", 0.2, -2.0, |x, p, t| {
        (-p * t + (-p * x).exp()).ln() / -p
    }),
    ("1 + x^2", 0.1, 0.0, |x, _, t| (x.atan() + t).tan()),
    ("sqrt(x)", 0.5, 0.0, |x, _, t| (x.sqrt() + 0.5 * t).powi(2)),
    ("1/x", 0.6, 0.0, |x, _, t| (x * x + 2.0 * t).sqrt()),
    ("x^-2", 0.6, 0.0, |x, _, t| (x.powi(3) + 3.0 * t).cbrt()),
    ("p*cos(x)", 0.3, 1.5, |x, p, t| {
        2.0 * ((p * t + (x.tan() + 1.0 / x.cos()).ln()) * 0.5)
            .tanh()
            .atan()
    }),
    ("sin(x)", 0.3, 0.0, |x, _, t| {
        2.0 * ((x / 2.0).tan() * t.exp()).atan()
    }),
    ("1/tan(x)", 0.9, 0.0, |x, _, t| {
        (x.cos() * (-t).exp()).acos()
    }),
    ("(1 + x^2)*atan(x)", 0.4, 0.0, |x, _, t| {
        (x.atan() * t.exp()).tan()
    }),
    ("tanh(x)", 0.4, 0.0, |x, _, t| (x.sinh() * t.exp()).asinh()),
    ("sinh(x)", 0.3, 0.0, |x, _, t| {
        2.0 * ((x / 2.0).tanh() * t.exp()).atanh()
    }),
    ("1/cosh(x)", 0.3, 0.0, |x, _, t| (x.sinh() + t).asinh()),
    ("sqrt(1 - x^2)*asin(x)", 0.4, 0.0, |x, _, t| {
        (x.asin() * t.exp()).sin()
    }),
    ("-sqrt(1 - x^2)*acos(x)", 0.9, 0.0, |x, _, t| {
        (x.acos() * t.exp()).cos()
    }),
    ("sqrt(1 + x^2)*asinh(x)", 0.4, 0.0, |x, _, t| {
        (x.asinh() * t.exp()).sinh()
    }),
    ("sqrt(x^2 - 1)*acosh(x)", 1.5, 0.0, |x, _, t| {
        (x.acosh() * t.exp()).cosh()
    }),
    ("(1 - x^2)*atanh(x)", 0.4, 0.0, |x, _, t| {
        (x.atanh() * t.exp()).tanh()
    }),
    ("x*log10(x)", 0.4, 0.0, |x, _, t| {
        (x.ln() * (t / 10.0_f64.ln()).exp()).exp()
    }),
    ("x*log2(x)", 0.4, 0.0, |x, _, t| {
        (x.ln() * (t / 2.0_f64.ln()).exp()).exp()
    }),
    ("x*log(x)", 0.4, 0.0, |x, _, t| (x.ln() * t.exp()).exp()),
    ("cbrt(x)", 0.7, 0.0, |x, _, t| {
        (x.powf(2.0 / 3.0) + 2.0 * t / 3.0).powf(1.5)
    }),
    ("-cbrt(x)", -0.7, 0.0, |x, _, t| {
        -((-x).powf(2.0 / 3.0) - 2.0 * t / 3.0).powf(1.5)
    }),
    ("-x^1.5", 0.7, 0.0, |x, _, t| {
        (x.powf(-0.5) + t / 2.0).powi(-2)
    }),
    ("x^(-0.3)", 0.7, 0.0, |x, _, t| {
        (x.powf(1.3) + 1.3 * t).powf(1.0 / 1.3)
    }),
    ("x^p", 0.7, 1.3, |x, p, t| {
        (x.powf(1.0 - p) + (1.0 - p) * t).powf(1.0 / (1.0 - p))
    }),
    ("1 + floor(x + 2)*(p - x)", -1.5, 2.0, |x, _, t| x + t),
    ("round(x)*(p - x)", 1.6, 2.0, |x, p, t| {
        p + (x - p) * (-2.0 * t).exp()
    }),
    ("-trunc(x)*x", -1.1, 0.0, |x, _, t| x * t.exp()),
    ("atan2(p, x)*(x^2 + p^2)", -0.4, 0.6, |x, p, t| {
        let angle = p.atan2(x) * (-p * t).exp();
        p * angle.cos() / angle.sin()
    }),
    ("abs(x) + max(x, p)", -0.5, -2.0, |x, _, _| x),
    ("min(x, 2) - 3*max(0, x - p)", 0.3, 0.1, |x, p, t| {
        (x - 1.5 * p) * (-2.0 * t).exp() + 1.5 * p
    }),
];

/// Point boxes: the enclosure is thin, so a wrong coefficient or a missing remainder shows.
#[test]
fn elementary_flows_at_every_order() {
    for (der, x0, p, flow) in FLOWS {
        let system = scalar(der);
        for order in 1..=8 {
            for h in [0.01, 0.1, 0.25] {
                let options = StepOptions {
                    order,
                    longest: 1.0,
                    halvings: 8,
                };
                let start = [Interval::point(x0)];
                let mut run = Run::new(&system, options, &start, &[Interval::point(p)]);
                for k in 1..=2 {
                    run.step(&system, &[], h);
                    let x = flow(x0, p, f64::from(k) * h);
                    assert!(
                        run.has(0, x),
                        "{der}, order {order}, h {h}, step {k}: {x} not in {:?}",
                        run.states
                    );
                }
            }
        }
    }
}

/// Halving the step divides the width of one step's enclosure by nearly `2^(order + 1)`.
#[test]
fn the_width_falls_with_the_order() {
    for (der, x0, p, _) in FLOWS {
        if der.contains("abs") || der.contains("m") && der.contains("ax") || der == "p*x" {
            continue;
        }
        let system = scalar(der);
        for order in 1..=4_usize {
            let width = |h: f64| {
                let options = StepOptions {
                    order,
                    longest: 1.0,
                    halvings: 8,
                };
                let start = [Interval::point(x0)];
                let mut run = Run::new(&system, options, &start, &[Interval::point(p)]);
                run.step(&system, &[], h);
                run.states[0].width()
            };
            let (wide, thin) = (width(0.02), width(0.01));
            if thin > 1e-13 {
                let power = (wide / thin).log2();
                assert!(
                    power > order as f64 + 0.7,
                    "{der}, order {order}: power {power}"
                );
            }
        }
    }
}

/// `x(n h) = x0 + n p h` exactly, in integers of size 2^-111: rounding itself is on trial.
#[test]
fn the_last_bit_is_enclosed() {
    let system = scalar("p");
    let mut rng = Rng(3);
    // `x` in units of 2^-111.
    let units = |x: f64| -> i128 {
        let bits = x.abs().to_bits();
        let exponent = (bits >> 52) as i32;
        if exponent == 0 {
            return 0;
        }
        let mantissa = i128::from((bits & ((1 << 52) - 1)) | (1 << 52));
        let shift = exponent - 1075 + 111;
        let size = if shift >= 0 {
            mantissa << shift
        } else {
            assert_eq!(
                mantissa & ((1 << -shift) - 1),
                0,
                "{x} has bits below the unit"
            );
            mantissa >> -shift
        };
        if x < 0.0 { -size } else { size }
    };
    for case in 0..400 {
        let p = rng.between(1.0, 2.0) * if case % 2 == 0 { 1.0 } else { -1.0 };
        let h = rng.between(1.0 / 128.0, 1.0 / 64.0);
        let x0 = match case % 3 {
            0 => 0.0,
            _ => (rng.next() >> 11) as f64 / (1_u64 << 53) as f64,
        };
        let product = {
            let mantissa = |x: f64| i128::from((x.to_bits() & ((1 << 52) - 1)) | (1 << 52));
            // p is below 2 with unit 2^-52, h below 2^-6 with unit 2^-59.
            assert!(p.abs().log2() < 1.0 && h.log2() < -6.0);
            mantissa(p) * mantissa(h) * if p < 0.0 { -1 } else { 1 }
        };
        let start = [Interval::point(x0)];
        let mut run = Run::new(&system, default(), &start, &[Interval::point(p)]);
        let mut exact = units(x0);
        for _ in 0..if x0 == 0.0 { 1 } else { 100 } {
            run.step(&system, &[], h);
            exact += product;
            // Compare in whole units: the bounds of sums near zero have finer bits.
            let (lo, hi) = (run.states[0].lo(), run.states[0].hi());
            let coarse = |x: f64| x == 0.0 || x.abs() >= 2.0_f64.powi(-58);
            if coarse(lo) {
                assert!(units(lo) <= exact, "case {case}: {lo:e} is above");
            }
            if coarse(hi) {
                assert!(units(hi) >= exact, "case {case}: {hi:e} is below");
            }
        }
    }
}

/// An argument of `abs`, `min` or `max` that touches its kink from one side, just where the
/// series starts: the same branch must be taken at the point and over the range.
#[test]
fn kinks_touched_from_one_side() {
    // The second equation has the same solutions from starts in the interval.
    let both = interval(-1e-3, 1e-3);
    let (below, above) = (interval(-1e-3, 0.0), interval(0.0, 1e-3));
    let forms = [
        ("1 + 3*x + abs(-x^2)", "1 + 3*x + x^2", both),
        ("1 + 3*x + min(x^2, 0)", "1 + 3*x", both),
        ("1 + 3*x + max(0, -x^2)", "1 + 3*x", both),
        ("1 + 3*x - min(0, -x^2)", "1 + 3*x + x^2", both),
        ("1 + 3*x + max(x^2, 0)", "1 + 3*x + x^2", both),
        ("1 + 3*x + abs(x)*abs(x)", "1 + 3*x + x^2", both),
        ("-1 + 3*x + abs(x) - max(x, 0)", "-1 + 2*x", below),
        ("1 + 3*x + abs(x) + min(x, 0)", "1 + 4*x", above),
        ("1 - 3*x + max(x, 0)", "1 - 2*x", above),
        ("-1 - 3*x + min(0, x)", "-1 - 2*x", below),
    ];
    for (kinked, smooth, starts) in forms {
        let (kinked_system, smooth_system) = (scalar(kinked), scalar(smooth));
        for order in 1..=6 {
            for start in [
                Interval::ZERO,
                below.intersect(starts),
                above.intersect(starts),
            ] {
                let options = StepOptions {
                    order,
                    longest: 1.0,
                    halvings: 8,
                };
                let fine = StepOptions {
                    order: 10,
                    ..options
                };
                let params = [Interval::ZERO];
                for (x0, h) in [start.lo(), start.hi()]
                    .map(|x| [(x, 0.02), (x, 0.1)])
                    .concat()
                {
                    let mut run = Run::new(&kinked_system, options, &[start], &params);
                    run.step(&kinked_system, &[], h);
                    let x0 = [Interval::point(x0)];
                    let mut exact = Run::new(&smooth_system, fine, &x0, &params);
                    exact.step(&smooth_system, &[], h);
                    assert!(
                        run.has(0, exact.states[0].mid()),
                        "{kinked}, order {order}, from {start:?}: {:?} lost, {:?}",
                        exact.states,
                        run.states
                    );
                }
            }
        }
    }
}

/// The slope of a root exists nowhere where its argument is exactly zero: nothing is known then.
#[test]
fn roots_of_what_is_exactly_zero() {
    for (der, end) in [
        ("k*sqrt(u)*v - friction(v, 0, T)", 0.09),
        ("k*sqrt(u) - v", 0.1 * (-0.1_f64).exp()),
        ("k*sqrt(abs(u)) - v", 0.1 * (-0.1_f64).exp()),
        ("k*sqrt(max(u, 0))*v - v", 0.1 * (-0.1_f64).exp()),
    ] {
        let system = system(&format!(
            "format = 1\nstates = [\"v\"]\ninputs = [\"u\"]\ninit = {{ v = 0 }}\n[params]\n\
             T = [0.1, 0.3]\nk = [0.1, 1]\n[der]\nv = \"{der}\"\n[outputs]\ny = \"v +- 1\"\n"
        ));
        let mut workspace = Workspace::new(&system, StepOptions::default());
        let mut v = [interval(-0.1, 0.1)];
        let params = [interval(0.1, 0.3), interval(0.1, 1.0)];
        let h = interval(0.1, 0.1);
        let done = system.step(&mut v, &params, &[Interval::ZERO], h, &mut workspace);
        assert!(done.is_ok(), "{der}: {done:?}");
        for x in [end, -end] {
            assert!(
                v[0].lo() - SLACK <= x && x <= v[0].hi() + SLACK,
                "{der}: {v:?} lost {x}"
            );
        }
        assert!(v[0].mag() < 0.1 + 1e-9, "{der}: {v:?}");
    }
}

/// A comparison that does not depend on its state has no level.
#[test]
fn comparisons_without_slope() {
    let system = system(
        "format = 1\nstates = [\"x\"]\ninit = { x = 0 }\n[params]\np = [-1, 1]\n[modes]\n\
         always = { when = \"2*x - x - x >= 0\", der = { x = \"1 + p\" } }\n\
         never = { when = \"2*x - x - x < 0\", der = { x = \"p - 5\" } }\n\
         [outputs]\ny = \"x +- 1\"\n",
    );
    let mut workspace = Workspace::new(&system, StepOptions::default());
    for x in [-1.0, 0.0, 2.0] {
        let mut states = [interval(x, x)];
        let h = interval(0.5, 0.5);
        system
            .step(&mut states, &[Interval::ZERO], &[], h, &mut workspace)
            .unwrap();
        assert!(states[0].contains(x + 0.5), "{states:?}");
    }
}

/// The closure of a guard's region may hold points at which the guard itself is not defined.
#[test]
fn guards_undefined_at_their_border() {
    let system = system(
        "format = 1\nstates = [\"x\"]\ninit = { x = 0 }\n[modes]\n\
         right = { when = \"1/x > 0\", der = { x = \"1\" } }\n\
         left = { when = \"1/x < 0\", der = { x = \"-1\" } }\n\
         [outputs]\ny = \"x +- 1\"\n",
    );
    let mut workspace = Workspace::new(&system, StepOptions::default());
    for start in [interval(0.0, 0.0), interval(-0.1, 0.0), interval(0.0, 0.1)] {
        let mut states = [start];
        let h = interval(0.5, 0.5);
        system
            .step(&mut states, &[], &[], h, &mut workspace)
            .unwrap();
        assert!(
            states[0].contains(0.5) && states[0].contains(-0.5),
            "{start:?} {states:?}"
        );
    }
}
