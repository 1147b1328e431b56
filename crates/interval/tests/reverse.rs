//! Reverse operations: no solution is lost, and near one branch the result is sharp.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

mod support;

use support::Source;
use veribound_interval::Interval;

const CASES: usize = 100_000;

type Forward = fn(Interval) -> Interval;
type Reverse = fn(Interval, Interval) -> Interval;

fn interval(lo: f64, hi: f64) -> Interval {
    Interval::new(lo, hi).unwrap()
}

/// An interval around a number: sometimes the point, sometimes up to a half line.
fn around(source: &mut Source, x: f64) -> Interval {
    let mut width = || match source.below(5) {
        0 => 0.0,
        1 => x.abs() * 1e-15,
        2 => f64::INFINITY,
        _ => source.unit() * 2_f64.powi(source.below(12) as i32 - 6),
    };
    let (below, above) = (width(), width());
    Interval::new((x - below).min(x), (x + above).max(x)).unwrap()
}

fn number(source: &mut Source) -> f64 {
    match source.below(4) {
        0 => source.float(),
        1 => source.between(-1e4, 1e4),
        _ => source.between(-8.0, 8.0),
    }
}

/// The value of a forward operation at points, widened at random so that it still holds the value.
fn value(source: &mut Source, exact: Interval) -> Interval {
    match source.below(3) {
        0 => exact,
        1 => exact.hull(around(source, exact.mid())),
        _ => exact.inflate(source.unit()),
    }
}

#[test]
fn no_solution_of_a_function_is_lost() {
    let functions: [(&str, Forward, Reverse); 31] = [
        ("sqr", Interval::sqr, Interval::sqr_rev),
        ("abs", Interval::abs, Interval::abs_rev),
        ("sqrt", Interval::sqrt, Interval::sqrt_rev),
        ("exp", Interval::exp, Interval::exp_rev),
        ("ln", Interval::ln, Interval::ln_rev),
        ("sin", Interval::sin, Interval::sin_rev),
        ("cos", Interval::cos, Interval::cos_rev),
        ("tan", Interval::tan, Interval::tan_rev),
        ("atan", Interval::atan, Interval::atan_rev),
        ("tanh", Interval::tanh, Interval::tanh_rev),
        ("recip", Interval::recip, Interval::recip_rev),
        ("exp2", Interval::exp2, Interval::exp2_rev),
        ("exp10", Interval::exp10, Interval::exp10_rev),
        ("expm1", Interval::expm1, Interval::expm1_rev),
        ("log2", Interval::log2, Interval::log2_rev),
        ("log10", Interval::log10, Interval::log10_rev),
        ("log1p", Interval::log1p, Interval::log1p_rev),
        ("asin", Interval::asin, Interval::asin_rev),
        ("acos", Interval::acos, Interval::acos_rev),
        ("sinh", Interval::sinh, Interval::sinh_rev),
        ("cosh", Interval::cosh, Interval::cosh_rev),
        ("asinh", Interval::asinh, Interval::asinh_rev),
        ("acosh", Interval::acosh, Interval::acosh_rev),
        ("atanh", Interval::atanh, Interval::atanh_rev),
        ("sign", Interval::sign, Interval::sign_rev),
        (
            "cube root",
            |x| x.rootn(3),
            |c, x| Interval::rootn_rev(3, c, x),
        ),
        (
            "fourth root",
            |x| x.rootn(4),
            |c, x| Interval::rootn_rev(4, c, x),
        ),
        (
            "inverse cube root",
            |x| x.rootn(-3),
            |c, x| Interval::rootn_rev(-3, c, x),
        ),
        ("cube", |x| x.powi(3), |c, x| Interval::powi_rev(3, c, x)),
        (
            "fourth power",
            |x| x.powi(4),
            |c, x| Interval::powi_rev(4, c, x),
        ),
        (
            "inverse cube",
            |x| x.powi(-3),
            |c, x| Interval::powi_rev(-3, c, x),
        ),
    ];
    let mut source = Source(31);
    for _ in 0..CASES {
        let solution = number(&mut source);
        for (name, forward, reverse) in functions {
            let exact = forward(Interval::point(solution));
            if exact.is_empty() {
                continue;
            }
            let c = value(&mut source, exact);
            let x = around(&mut source, solution);
            let found = reverse(c, x);
            assert!(
                found.contains(solution),
                "{name}: {solution:e} in {x:?}, value {c:?}: {found:?}"
            );
            assert!(found.is_subset_of(x), "{name}: {found:?} beyond {x:?}");
        }
    }
}

#[test]
fn no_solution_of_an_operation_is_lost() {
    type Operation = fn(Interval, Interval) -> Interval;
    type Back = fn(Interval, Interval, Interval) -> Interval;
    // `operation(b, x)` and the way back to `x`.
    let operations: [(&str, Operation, Back); 9] = [
        ("b + x", |b, x| b + x, Interval::add_rev),
        ("x - b", |b, x| x - b, Interval::sub_rev_left),
        ("b - x", |b, x| b - x, Interval::sub_rev_right),
        ("b * x", |b, x| b * x, Interval::mul_rev),
        ("x / b", |b, x| x / b, Interval::div_rev_left),
        ("b / x", |b, x| b / x, Interval::div_rev_right),
        ("min", Interval::min, Interval::min_rev),
        ("x^b", |b, x| x.pow(b), Interval::pow_rev1),
        ("b^x", Interval::pow, Interval::pow_rev2),
    ];
    let mut source = Source(32);
    for _ in 0..CASES {
        let (solution, other) = (number(&mut source), number(&mut source));
        for (name, operation, back) in operations {
            let exact = operation(Interval::point(other), Interval::point(solution));
            if exact.is_empty() {
                continue;
            }
            let c = value(&mut source, exact);
            let (b, x) = (around(&mut source, other), around(&mut source, solution));
            let found = back(b, c, x);
            assert!(
                found.contains(solution) && found.is_subset_of(x),
                "{name}: x = {solution:e}, b = {b:?}, c = {c:?}, in {x:?}: {found:?}"
            );
            if name == "min" {
                let found = Interval::max_rev(-b, -c, -x);
                assert!(found.contains(-solution), "max: {b:?} {c:?} {x:?}");
            }
        }
    }
}

#[test]
fn signs_are_turned_back() {
    let x = interval(-3.0, 5.0);
    assert_eq!(Interval::sign_rev(Interval::ONE, x), interval(0.0, 5.0));
    assert_eq!(Interval::sign_rev(-Interval::ONE, x), interval(-3.0, 0.0));
    assert_eq!(Interval::sign_rev(interval(-0.5, 0.5), x), Interval::ZERO);
    assert_eq!(Interval::sign_rev(interval(-1.0, 1.0), x), x);
    assert_eq!(Interval::sign_rev(interval(2.0, 3.0), x), Interval::EMPTY);
    assert_eq!(
        Interval::sign_rev(Interval::ONE, interval(-3.0, -1.0)),
        Interval::EMPTY
    );
}

#[test]
fn one_branch_is_sharp() {
    let near = |found: Interval, lo: f64, hi: f64| {
        assert!(
            (found.lo() - lo).abs() < 1e-12 && (found.hi() - hi).abs() < 1e-12,
            "{found:?} is not near [{lo}, {hi}]"
        );
    };
    let half = interval(0.4, 0.5);
    near(
        Interval::sin_rev(half, interval(-1.0, 1.5)),
        0.4_f64.asin(),
        0.5_f64.asin(),
    );
    let second = std::f64::consts::PI;
    near(
        Interval::sin_rev(half, interval(2.0, 4.0)),
        second - 0.5_f64.asin(),
        second - 0.4_f64.asin(),
    );
    near(
        Interval::cos_rev(half, interval(0.0, 3.0)),
        0.5_f64.acos(),
        0.4_f64.acos(),
    );
    near(
        Interval::cos_rev(half, interval(-3.0, 0.0)),
        -(0.4_f64.acos()),
        -(0.5_f64.acos()),
    );
    near(
        Interval::tan_rev(half, interval(2.0, 4.5)),
        second + 0.4_f64.atan(),
        second + 0.5_f64.atan(),
    );
    near(
        Interval::atan_rev(half, Interval::ENTIRE),
        0.4_f64.tan(),
        0.5_f64.tan(),
    );
    near(
        Interval::tanh_rev(half, Interval::ENTIRE),
        0.4_f64.atanh(),
        0.5_f64.atanh(),
    );
    near(
        Interval::powi_rev(5, half, Interval::ENTIRE),
        0.4_f64.powf(0.2),
        0.5_f64.powf(0.2),
    );
    near(
        Interval::powi_rev(-2, half, interval(0.0, 9.0)),
        2_f64.sqrt(),
        2.5_f64.sqrt(),
    );
    // No solution between two branches.
    assert_eq!(Interval::sin_rev(half, interval(0.6, 2.5)), Interval::EMPTY);
    assert_eq!(
        Interval::cos_rev(interval(1.5, 2.0), Interval::ENTIRE),
        Interval::EMPTY
    );
    assert_eq!(
        Interval::tanh_rev(interval(1.0, 2.0), Interval::ENTIRE),
        Interval::EMPTY
    );
    assert_eq!(
        Interval::atan_rev(interval(1.6, 2.0), Interval::ENTIRE),
        Interval::EMPTY
    );
    // Unbounded and very large ends stay.
    assert_eq!(Interval::sin_rev(half, Interval::ENTIRE), Interval::ENTIRE);
    assert_eq!(Interval::sin_rev(half, interval(0.0, 1e300)).hi(), 1e300);
}

/// The way back from a value at a point is narrow: a bound on the loss of each function.
#[test]
fn inverse_functions_are_sharp() {
    let pairs: [(&str, Forward, Reverse, f64, f64); 15] = [
        ("exp2", Interval::exp2, Interval::exp2_rev, -5.0, 5.0),
        ("exp10", Interval::exp10, Interval::exp10_rev, -5.0, 5.0),
        ("expm1", Interval::expm1, Interval::expm1_rev, -2.0, 5.0),
        ("log2", Interval::log2, Interval::log2_rev, 0.1, 50.0),
        ("log10", Interval::log10, Interval::log10_rev, 0.1, 50.0),
        ("log1p", Interval::log1p, Interval::log1p_rev, -0.5, 50.0),
        ("asin", Interval::asin, Interval::asin_rev, -0.9, 0.9),
        ("acos", Interval::acos, Interval::acos_rev, -0.9, 0.9),
        ("sinh", Interval::sinh, Interval::sinh_rev, -5.0, 5.0),
        ("cosh", Interval::cosh, Interval::cosh_rev, 0.5, 5.0),
        ("asinh", Interval::asinh, Interval::asinh_rev, -5.0, 5.0),
        ("acosh", Interval::acosh, Interval::acosh_rev, 1.5, 50.0),
        ("atanh", Interval::atanh, Interval::atanh_rev, -0.9, 0.9),
        (
            "x^2.3",
            |x| x.pow(Interval::point(2.3)),
            |c, x| Interval::pow_rev1(Interval::point(2.3), c, x),
            0.1,
            9.0,
        ),
        (
            "3^x",
            |x| Interval::point(3.0).pow(x),
            |c, x| Interval::pow_rev2(Interval::point(3.0), c, x),
            -5.0,
            5.0,
        ),
    ];
    let mut source = Source(34);
    for _ in 0..10_000 {
        for (name, forward, reverse, least, most) in pairs {
            let x = source.between(least, most);
            let positive = interval(if least > 0.0 { 0.0 } else { least }, f64::INFINITY);
            let found = reverse(forward(Interval::point(x)), positive);
            let most = 1e-13 * x.abs().max(1.0);
            assert!(
                found.contains(x) && found.width() <= most,
                "{name}: {x} in {found:?}"
            );
        }
    }
    // Values that are never taken.
    let none = Interval::EMPTY;
    let all = Interval::ENTIRE;
    assert_eq!(Interval::cosh_rev(interval(0.0, 0.5), all), none);
    assert_eq!(Interval::exp2_rev(interval(-2.0, 0.0), all), none);
    assert_eq!(Interval::expm1_rev(interval(-2.0, -1.0), all), none);
    assert_eq!(Interval::asin_rev(interval(1.6, 2.0), all), none);
    assert_eq!(Interval::acos_rev(interval(-1.0, -0.1), all), none);
    assert_eq!(Interval::acosh_rev(interval(-2.0, -1.0), all), none);
    assert_eq!(Interval::rootn_rev(4, interval(-2.0, -1.0), all), none);
    assert_eq!(Interval::rootn_rev(0, all, all), none);
    assert_eq!(Interval::powi_rev(0, interval(2.0, 3.0), all), none);
    assert_eq!(Interval::acos_rev(all, all), interval(-1.0, 1.0));
    assert_eq!(Interval::asin_rev(all, all), interval(-1.0, 1.0));
    // Two branches, each cut before the hull is taken.
    assert_eq!(
        Interval::cosh_rev(interval(1.0, 2.0), interval(-9.0, 0.0)).hi(),
        0.0
    );
    assert_eq!(
        Interval::powi_rev(-3, interval(-8.0, 8.0), interval(-0.25, 1.0)),
        interval(0.5, 1.0)
    );
    assert_eq!(
        Interval::rootn_rev(-3, interval(-8.0, 8.0), interval(-1.0 / 1024.0, 1.0)),
        interval(1.0 / 512.0, 1.0)
    );
}

#[test]
fn roots_of_all_degrees_end() {
    let mut source = Source(33);
    for _ in 0..20_000 {
        let c = Interval::point(source.float().abs());
        let bits = 1 + source.below(30);
        let n = 2 + source.below(1 << bits) as i32;
        let root = Interval::powi_rev(n, c, interval(0.0, f64::INFINITY));
        assert!(!root.is_empty(), "root {n} of {c:?}");
        assert!(root.powi(n).intersects(c), "root {n} of {c:?}: {root:?}");
        if n < 100 && c.lo() > 1e-300 && c.hi() < 1e300 {
            assert!(
                root.width() <= 1e-14 * f64::from(n) * root.hi(),
                "root {n} of {c:?}: {root:?}"
            );
        }
    }
}
