//! Forms on problems whose solutions are known, and what they do where there is none.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod common;

use common::smooth::SMOOTH;
use common::{Rng, interval, read};
use veribound_flow::form::{Effort, Flow, FormOptions, Obstacle, Output, Stretch};
use veribound_interval::{Decimal, Interval};

fn flow(text: &str) -> Flow {
    Flow::new(&read("form", text))
}

fn has(x: Interval, value: f64, slack: f64) -> bool {
    x.lo() - slack <= value && value <= x.hi() + slack
}

/// Random linear systems with an uncertain start and a constant input, against the exponential of the
/// matrix `[[A, b], [0, 0]]`; the hull of a linear image of a box is known.
#[test]
fn linear_systems_are_enclosed_tightly() {
    let mut rng = Rng(5);
    for round in 0..60 {
        let n = 1 + rng.below(4);
        let a: Vec<i64> = (0..n * n).map(|_| rng.below(9) as i64 - 4).collect();
        let names: Vec<String> = (0..n).map(|i| format!("x{i}")).collect();
        let rates: String = (0..n)
            .map(|i| {
                let sum: String = (0..n)
                    .map(|l| format!(" + ({})*x{l}/4", a[i * n + l]))
                    .collect();
                format!("x{i} = \"{} * u{sum}\"\n", i + 1)
            })
            .collect();
        let inits: String = names.iter().map(|x| format!("{x} = 0\n")).collect();
        let flow = flow(&format!(
            "format = 1\nstates = {names:?}\ninputs = [\"u\"]\n[init]\n{inits}[der]\n{rates}[outputs]\nm = \"x0 +- 1\"\n"
        ));
        let start: Vec<Interval> = (0..n)
            .map(|_| {
                let middle = rng.between(-2.0, 2.0);
                interval(middle - 0.125, middle + 0.125)
            })
            .collect();
        let (u, time) = (rng.between(-1.0, 1.0), rng.between(0.1, 3.0));
        let mut form = flow.start(&start, &[], FormOptions::default());
        flow.advance(&mut form, &[Interval::point(u)], Interval::point(time))
            .unwrap();
        let m = n + 1;
        let mut generator = vec![0.0; m * m];
        for i in 0..n {
            for l in 0..n {
                generator[i * m + l] = a[i * n + l] as f64 / 4.0 * time;
            }
            generator[i * m + n] = (i + 1) as f64 * time;
        }
        let exact = exponential(m, &generator);
        let hull = form.hull();
        for i in 0..n {
            let row = &exact[i * m..(i + 1) * m];
            let middle: f64 = (0..n).map(|l| row[l] * start[l].mid()).sum::<f64>() + row[n] * u;
            let radius: f64 = (0..n).map(|l| row[l].abs() * 0.125).sum();
            let size = 1.0 + middle.abs() + radius;
            let slack = 1e-13 * size;
            let (lo, hi) = (middle - radius, middle + radius);
            assert!(
                has(hull[i], lo, slack) && has(hull[i], hi, slack),
                "{round}: {lo} {hi} {}",
                hull[i]
            );
            assert!(
                hull[i].width() <= 2.0 * radius * (1.0 + 1e-4) + slack,
                "{round}"
            );
        }
    }
}

/// By scaling and squaring; good to some 1e-14.
fn exponential(n: usize, a: &[f64]) -> Vec<f64> {
    let times = |x: &[f64], y: &[f64]| -> Vec<f64> {
        (0..n * n)
            .map(|k| (0..n).map(|l| x[k / n * n + l] * y[l * n + k % n]).sum())
            .collect()
    };
    let identity: Vec<f64> = (0..n * n)
        .map(|k| f64::from(u8::from(k % (n + 1) == 0)))
        .collect();
    let scaled: Vec<f64> = a.iter().map(|x| x / 64.0).collect();
    let (mut sum, mut term) = (identity.clone(), identity);
    for k in 1..25 {
        term = times(&term, &scaled)
            .iter()
            .map(|x| x / f64::from(k))
            .collect();
        sum = sum.iter().zip(&term).map(|(x, y)| x + y).collect();
    }
    for _ in 0..6 {
        sum = times(&sum, &sum);
    }
    sum
}

/// The exact values are from a Taylor series of order 40 with 40 digits.
#[test]
fn lorenz_after_ten_seconds() {
    let flow = flow(SMOOTH[7].text);
    let start = [15.0, 15.0, 36.0].map(Interval::point);
    let mut form = flow.start(&start, &[Interval::point(28.0)], FormOptions::default());
    flow.advance(&mut form, &[], Interval::point(10.0)).unwrap();
    for (x, exact) in form.hull().iter().zip([
        -5.909_806_554_623_889,
        -11.341_403_153_690_429,
        9.080_177_822_327_795,
    ]) {
        assert!(
            has(*x, exact, 0.0) && x.width() < 1.35e-7,
            "{x:?} for {exact}"
        );
    }
}

const B2: &str = "format = 1\nstates = [\"x1\", \"x2\"]\ninputs = [\"u\"]\n[init]\nx1 = 0\nx2 = 0\n\
    [params]\nalpha = [-2.2, -1.8]\nbeta = [95, 105]\n\
    [der]\nx1 = \"x2\"\nx2 = \"alpha*x2 + beta*(u - 0.1)\"\n[outputs]\nm = \"x1 +- 1\"\n";

/// With u = 0.5 a peer that kept remainders symbolically said x1 <= 34.3133 at 2 s; 34.3281 is true. The exact hull
/// at 5 s is known too.
#[test]
fn a_staircase_with_constant_parameters() {
    let flow = flow(B2);
    let decimal = |text: &str| Decimal::parse(text).unwrap().to_interval();
    let params = [decimal("-2.2").hull(decimal("-1.8")), interval(95.0, 105.0)];
    let start = [Interval::ZERO, Interval::point(0.5)];
    let mut form = flow.start(&start, &params, FormOptions::default());
    flow.advance(&mut form, &[decimal("0.5")], Interval::point(2.0))
        .unwrap();
    assert!(form.hull()[0].hi() >= 34.328_087_96, "{:?}", form.hull());
    for degree in 1..=5 {
        let options = FormOptions {
            degree: Some(degree),
            ..FormOptions::default()
        };
        let mut form = flow.start(&start, &params, options);
        for k in 0..10 {
            let u = decimal(if k % 2 == 0 { "0.5" } else { "0.3" });
            flow.advance(&mut form, &[u], Interval::point(0.5)).unwrap();
        }
        let exact = [
            interval(60.0940744, 79.4238177),
            interval(10.7930363, 15.0371282),
        ];
        for (x, exact) in form.hull().iter().zip(exact) {
            assert!(exact.is_subset_of(x.inflate(1e-7)), "{degree}: {x}");
            if degree > 2 {
                assert!(x.width() <= 1.01 * exact.width(), "{degree}: {x}");
            }
        }
    }
}

/// After a measurement the centre and the unknowns must be related anew: with x1' = 0, x2' = x1,
/// x0 = [-1, 1] x {0} and x2(1) in [0.5, 1], a peer lost x1 = 0.95.
#[test]
fn a_measurement_narrows_the_unknowns_and_loses_nothing() {
    let text = "format = 1\nstates = [\"x1\", \"x2\"]\n[init]\nx1 = 0\nx2 = 0\n\
                [der]\nx1 = \"0\"\nx2 = \"x1\"\n[outputs]\nm = \"x2 +- 1\"\n";
    let model = read("contract", text);
    let flow = Flow::new(&model);
    let output = Output::new(&model, model.outputs[0].expr);
    let mut form = flow.start(
        &[interval(-1.0, 1.0), Interval::ZERO],
        &[],
        FormOptions::default(),
    );
    flow.advance(&mut form, &[], Interval::ONE).unwrap();
    let y = form.output(&output, &[]).unwrap();
    assert_eq!(form.contract(&y, interval(0.5, 1.0)), Ok(true));
    flow.advance(&mut form, &[], Interval::ONE).unwrap();
    let hull = form.hull();
    for truth in [0.5, 0.75, 0.95, 1.0] {
        assert!(
            hull[0].contains(truth) && hull[1].contains(2.0 * truth),
            "{hull:?}"
        );
    }
    assert!(
        interval(0.5, 1.0).is_subset_of(hull[0]) && hull[0].width() < 0.5 + 1e-12,
        "{hull:?}"
    );
    assert!(form.unknowns()[0].1.width() < 0.5 + 1e-12);
    let y = form.output(&output, &[]).unwrap();
    assert!(
        form.contract(&y, interval(2.1, 3.0)).is_err(),
        "a contradiction is proved"
    );
}

/// `x' = -x + u` with `|u| <= 1`: every `x` up to `1 - exp(-t)` is reached, no other.
#[test]
fn inputs_are_any_functions() {
    let text = "format = 1\nstates = [\"x\"]\ninputs = [\"u\"]\n[init]\nx = 0\n[der]\nx = \"u - x\"\n\
                [outputs]\nm = \"x +- 1\"\n";
    let flow = flow(text);
    let mut form = flow.start(&[Interval::ZERO], &[], FormOptions::default());
    for k in 1..=20 {
        flow.advance(&mut form, &[interval(-1.0, 1.0)], Interval::point(0.125))
            .unwrap();
        let most = 1.0 - f64::exp(-0.125 * f64::from(k));
        let x = form.hull()[0];
        assert!(x.hi() >= most - 1e-14 && x.lo() <= -most + 1e-14, "{x}");
        assert!(x.mag() <= 1.2 * most, "{x} for {most}");
    }
}

/// What cannot be proved is an error that leaves the form where it was, at once and at every size.
#[test]
fn failures_change_nothing_and_claim_nothing() {
    let case = |der: &str, start: Interval, time: f64| {
        let flow = flow(&format!(
            "format = 1\nstates = [\"x\"]\n[init]\nx = 0\n[der]\nx = \"{der}\"\n[outputs]\nm = \"x +- 1\"\n"
        ));
        let mut form = flow.start(&[start], &[], FormOptions::default());
        let before = form.hull();
        let result = flow.advance(&mut form, &[], Interval::point(time));
        assert_eq!(form.hull(), before);
        let diverged = result.unwrap_err();
        assert!(diverged.reached.hi() <= time, "{der}");
        diverged
    };
    // Blows up at 1.
    assert!(case("x^2", Interval::ONE, 1.5).reached.hi() < 1.0);
    assert!(case("x^2", interval(0.9, 1.0), 1.05).reached.hi() < 1.0);
    assert!(case("-sqrt(x)", Interval::ONE, 3.0).reached.hi() < 2.0);
    assert_eq!(
        case("log(x)", interval(-1.0, 1.0), 0.1).obstacle,
        Obstacle::Undefined
    );
    assert_eq!(
        case("1/x", interval(-1.0, 1.0), 0.1).obstacle,
        Obstacle::Undefined
    );
    // x' = 1 + x^2 from 0 has its pole at pi/2.
    assert!(case("1 + x^2", Interval::ZERO, 2.0).reached.hi() < std::f64::consts::FRAC_PI_2);
}

/// Guards that are proved to leave no gap only up to 2 prove nothing beyond.
#[test]
fn nothing_is_claimed_where_guards_may_leave_a_gap() {
    let text = "format = 1\nstates = { x = { init = 0, domain = [-1, 2] } }\noutputs.m = \"x +- 1\"\n\
        [modes.low]\nwhen = \"x < 1\"\nder = { x = \"1\" }\n[modes.high]\nwhen = \"x >= 1 and x < 2.5\"\nder = { x = \"2\" }\n";
    let flow = flow(text);
    let stretches = vec![
        Stretch {
            inputs: vec![],
            dt: Interval::point(0.5),
        };
        5
    ];
    let (options, effort) = (FormOptions::default(), Effort::default());
    let enclosure = flow.enclose(&[Interval::ZERO], &[], &stretches, options, effort);
    // It passes 1 at 1 and 2 at 1.5.
    assert_eq!(enclosure.stopped.unwrap().obstacle, Obstacle::LeavesDomain);
    assert!(enclosure.ends.len() == 2 || enclosure.ends.len() == 3);
    assert!(enclosure.ends[1][0].contains(1.0));
}

/// The end may lie anywhere in the time given.
#[test]
fn uncertain_times() {
    let text = "format = 1\nstates = [\"x\"]\n[init]\nx = 0\n[der]\nx = \"x\"\n[outputs]\nm = \"x +- 1\"\n";
    let flow = flow(text);
    let mut form = flow.start(&[Interval::ONE], &[], FormOptions::default());
    flow.advance(&mut form, &[], interval(1.0, 1.25)).unwrap();
    let (x, tube) = (form.hull()[0], form.tube()[0]);
    let exact = interval(1.0_f64.exp(), 1.25_f64.exp());
    assert!(exact.is_subset_of(x.inflate(1e-13)) && x.width() < 1.5 * exact.width());
    assert!(interval(1.0, 1.25_f64.exp()).is_subset_of(tube.inflate(1e-13)));
}

/// Uncertainty that came from inputs is moved by the matrix of every parameter, not of the middle one.
#[test]
fn what_inputs_left_grows_at_every_rate() {
    let text = "format = 1\nstates = [\"x\"]\ninputs = [\"u\"]\n[init]\nx = 0\n[params]\np = [1, 2]\n\
                [der]\nx = \"p*x + u\"\n[outputs]\nm = \"x +- 1\"\n";
    let flow = flow(text);
    for degree in [1, 2, 3, 6] {
        let options = FormOptions {
            degree: Some(degree),
            ..FormOptions::default()
        };
        let mut form = flow.start(&[Interval::ZERO], &[interval(1.0, 2.0)], options);
        flow.advance(&mut form, &[interval(-1.0, 1.0)], Interval::point(0.5))
            .unwrap();
        flow.advance(&mut form, &[Interval::ZERO], Interval::ONE)
            .unwrap();
        let most = (2.0 * 0.5_f64).exp_m1() / 2.0 * 2.0_f64.exp();
        let x = form.hull()[0];
        assert!(
            x.lo() <= -most && x.hi() >= most,
            "{degree}: {x} for {most}"
        );
        assert!(
            degree == 1 || x.hi() <= 1.5 * most,
            "{degree}: {x} for {most}"
        );
    }
}

/// Few orders and long steps: what is neglected in time is of the size of the set.
#[test]
fn coarse_steps_lose_nothing() {
    for (der, start, time, end) in [
        ("x^2", 1.0, 0.5, 2.0),
        ("-x^3", 1.0, 1.5, 0.5),
        ("x*(2 - x)", 0.1, 2.0, 2.0 / (1.0 + 19.0 * (-4.0_f64).exp())),
        ("exp(-x)", 0.0, 3.0, 4.0_f64.ln()),
        ("cos(x)", 0.0, 2.0, 2.0_f64.sinh().atan()),
        ("1/x", 1.0, 1.5, 2.0),
        ("sqrt(x)", 1.0, 2.0, 4.0),
    ] {
        let flow = flow(&format!(
            "format = 1\nstates = [\"x\"]\n[init]\nx = 0\n[der]\nx = \"{der}\"\n[outputs]\nm = \"x +- 1\"\n"
        ));
        for tolerance in [1e-2, 1e-3, 1e-5] {
            let options = FormOptions {
                order: Some(4),
                tolerance,
                steepest: 3.0,
                ..FormOptions::default()
            };
            let mut form = flow.start(&[Interval::point(start)], &[], options);
            if flow.advance(&mut form, &[], Interval::point(time)).is_ok() {
                let x = form.hull()[0];
                assert!(has(x, end, 1e-14), "{der} with {tolerance}: {end} in {x}");
            } else {
                assert!(tolerance > 1e-3, "{der} with {tolerance}");
            }
        }
    }
}
