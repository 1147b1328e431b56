//! Exponentials, logarithms, arc and hyperbolic functions, angles and real powers against series in big
//! integers; their exact points by name.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

#[path = "support/inverse.rs"]
mod inverse;
#[path = "support/oracle.rs"]
mod oracle;
#[path = "support/points.rs"]
mod points;
mod support;

use std::f64::consts::{FRAC_PI_2, LN_2, PI};

use oracle::Fixed;
use points::{Exact, Function, anywhere, assert_encloses, check};
use support::Source;
use veribound_interval::Interval;

const CASES: usize = 2_500;

fn interval(lo: f64, hi: f64) -> Interval {
    Interval::new(lo, hi).unwrap()
}

fn point(x: f64) -> Interval {
    Interval::point(x)
}

/// A function by name, its oracle, and where it is asked.
type Row = (&'static str, Function, Exact, f64, f64, &'static [f64]);

/// Functions on floats from `least` to `most` with `anchors` between.
#[rustfmt::skip]
const FUNCTIONS: &[Row] = &[
    ("exp2", Interval::exp2, Fixed::exp2, -1022.0, 1023.9, &[1.0, -1.0, 52.0, 1023.0]),
    ("exp10", Interval::exp10, Fixed::exp10, -307.0, 308.0, &[1.0, -1.0, 22.0, 23.0, 308.0]),
    ("expm1", Interval::expm1, Fixed::expm1, -300.0, 709.0, &[1.0, -1.0, -37.0, LN_2]),
    ("log2", Interval::log2, Fixed::log2, 0.0, f64::MAX, &[1.0, 2.0, 0.5, 1024.0, f64::MIN_POSITIVE]),
    ("log10", Interval::log10, Fixed::log10, 0.0, f64::MAX, &[1.0, 10.0, 0.1, 1e22, 1e23, 1000.0]),
    ("log1p", Interval::log1p, Fixed::log1p, -1.0, f64::MAX, &[1.0, -0.5, -0.999]),
    ("asin", Interval::asin, Fixed::asin, -1.0, 1.0, &[1.0, -1.0, 0.5]),
    ("acos", Interval::acos, Fixed::acos, -1.0, 1.0, &[1.0, -1.0, 0.5]),
    ("sinh", Interval::sinh, Fixed::sinh, -710.0, 710.0, &[1.0, 22.0, 710.0]),
    ("cosh", Interval::cosh, Fixed::cosh, -710.0, 710.0, &[1.0, 22.0, 710.0]),
    ("asinh", Interval::asinh, Fixed::asinh, f64::MIN, f64::MAX, &[1.0, -1.0, 1e8]),
    ("acosh", Interval::acosh, Fixed::acosh, 1.0, f64::MAX, &[1.0, 2.0, 1e8]),
    ("atanh", Interval::atanh, Fixed::atanh, -1.0, 1.0, &[1.0, -1.0, 0.5]),
];

#[test]
fn values_at_points() {
    for (seed, &(name, f, exact, least, most, anchors)) in FUNCTIONS.iter().enumerate() {
        check(name, f, exact, 81 + seed as u64, CASES, |source| {
            loop {
                let x = anywhere(source, most.max(-least), anchors);
                let x = if least >= 0.0 { x.abs() } else { x };
                // The poles stand in other tests, and so do numbers so small that the oracle cannot tell
                // the value from its first approximation.
                let pole = (name == "log1p" || name == "atanh") && x.abs() == 1.0;
                let tiny = x != 0.0 && x.abs() < 1e-100;
                if least < x && x <= most && !pole && !tiny {
                    return x;
                }
            }
        });
    }
}

/// For tiny `x > 0` the values lie strictly between `x` and the next float, on the side that the first
/// two terms of the series tell.
#[test]
fn tiny_arguments() {
    let above: [(Function, bool); 4] = [
        (Interval::expm1, false),
        (Interval::asin, true),
        (Interval::sinh, true),
        (Interval::atanh, true),
    ];
    let below: [(Function, bool); 5] = [
        (Interval::log1p, false),
        (Interval::asinh, true),
        (Interval::atan, true),
        (Interval::tanh, true),
        (Interval::sin, true),
    ];
    let mut source = Source(99);
    for _ in 0..20_000 {
        let x = f64::from_bits(1 + source.below(1e-100_f64.to_bits()));
        let near = |found: Interval, lo: f64, hi: f64| {
            let wider = interval(lo.next_down(), hi.next_up());
            assert!(
                interval(lo, hi).is_subset_of(found) && found.is_subset_of(wider),
                "{x:e}: {found:?}"
            );
        };
        for (f, odd) in above {
            near(f(point(x)), x, x.next_up());
            if odd {
                near(f(point(-x)), -x.next_up(), -x);
            }
        }
        for (f, odd) in below {
            near(f(point(x)), x.next_down(), x);
            if odd {
                near(f(point(-x)), -x, -x.next_down());
            }
        }
        // 1 + x^2 / 2 and 1 + x ln 2.
        near(point(x).cosh(), 1.0, 1.0_f64.next_up());
        near(point(x).exp2(), 1.0, 1.0_f64.next_up());
        near(point(x).exp10(), 1.0, 1.0_f64.next_up());
        near(point(-x).exp2(), 1.0_f64.next_down(), 1.0);
    }
}

/// Monotone functions take their ends to the ends; hyperbolic cosine and arc cosine turn.
#[test]
fn ranges_are_spanned_by_the_ends() {
    let mut source = Source(95);
    for _ in 0..20_000 {
        for &(name, f, _, least, most, anchors) in FUNCTIONS {
            let mut end = || anywhere(&mut source, most.max(-least), anchors).clamp(least, most);
            let (a, b) = (end(), end());
            let x = point(a).hull(point(b));
            let (first, last) = (f(point(x.lo())), f(point(x.hi())));
            let expected = if name == "cosh" && x.contains(0.0) {
                first.hull(last).hull(Interval::ONE)
            } else if first.is_empty() || last.is_empty() {
                continue;
            } else {
                first.hull(last)
            };
            assert_eq!(f(x), expected, "{name} of {x:?}");
        }
    }
}

#[test]
fn larger_arguments_give_larger_results() {
    let mut source = Source(96);
    for _ in 0..20_000 {
        for &(name, f, _, least, most, anchors) in FUNCTIONS {
            let mut end = || anywhere(&mut source, most.max(-least), anchors).clamp(least, most);
            let inner = point(end()).hull(point(end()));
            let outer = inner.hull(point(end()));
            assert!(
                f(inner).is_subset_of(f(outer)),
                "{name} of {inner:?}, {outer:?}"
            );
            let next = interval(
                inner.lo().next_down().max(f64::MIN),
                inner.hi().next_up().min(f64::MAX),
            );
            assert!(
                f(inner).is_subset_of(f(next)),
                "{name} of {inner:?}, {next:?}"
            );
        }
    }
}

/// Every point at which a value is a float, and what is found there.
#[test]
fn exact_points_are_exact() {
    for k in -1074..=1023 {
        let power = if k < -1022 {
            f64::from_bits(1 << (k + 1074))
        } else {
            f64::from_bits(((k + 1023) as u64) << 52)
        };
        assert_eq!(point(f64::from(k)).exp2(), point(power), "2^{k}");
        assert_eq!(point(power).log2(), point(f64::from(k)), "log2 2^{k}");
        // The neighbours are no powers: their logarithms are on the right side.
        let (below, above) = (
            point(power.next_down()).log2(),
            point(power.next_up()).log2(),
        );
        assert!(
            power == f64::from_bits(1) || below.hi() <= f64::from(k),
            "{k}"
        );
        assert!(above.lo() >= f64::from(k), "{k}");
    }
    let mut power = 1_u128;
    for k in 0..=22 {
        assert_eq!(point(f64::from(k)).exp10(), point(power as f64), "10^{k}");
        assert_eq!(
            point(power as f64).log10(),
            point(f64::from(k)),
            "log10 10^{k}"
        );
        power *= 10;
    }
    for k in [-5.0, -1.0, 23.0, 24.0, 300.0] {
        assert!(!point(k).exp10().is_point(), "10^{k} is no float");
    }
    for f in [
        Interval::expm1,
        Interval::log1p,
        Interval::asin,
        Interval::sinh,
        Interval::asinh,
        Interval::atanh,
        Interval::tanh,
        Interval::atan,
    ] {
        assert_eq!(f(Interval::ZERO), Interval::ZERO);
    }
    assert_eq!(Interval::ONE.acos(), Interval::ZERO);
    assert_eq!(Interval::ONE.acosh(), Interval::ZERO);
    assert_eq!(Interval::ZERO.cosh(), Interval::ONE);
}

#[test]
fn limits_and_domains() {
    let (all, none, inf) = (Interval::ENTIRE, Interval::EMPTY, f64::INFINITY);
    for &(name, f, ..) in FUNCTIONS {
        assert_eq!(f(none), none, "{name}");
    }
    assert_eq!(all.exp2(), interval(0.0, inf));
    assert_eq!(all.exp10(), interval(0.0, inf));
    assert_eq!(all.expm1(), interval(-1.0, inf));
    assert_eq!((all.log2(), all.log10(), all.log1p()), (all, all, all));
    assert_eq!((all.sinh(), all.asinh(), all.atanh()), (all, all, all));
    assert_eq!(all.cosh(), interval(1.0, inf));
    assert_eq!(all.acosh(), interval(0.0, inf));
    assert_eq!(
        all.asin(),
        interval(-FRAC_PI_2.next_up(), FRAC_PI_2.next_up())
    );
    assert_eq!(all.acos(), interval(0.0, PI.next_up()));
    // Nothing of the domain is left.
    assert_eq!(interval(-5.0, 0.0).log2(), none);
    assert_eq!(interval(-5.0, 0.0).log10(), none);
    assert_eq!(interval(-5.0, -1.0).log1p(), none);
    assert_eq!(interval(1.0, 5.0).atanh(), none);
    assert_eq!(interval(-5.0, -1.0).atanh(), none);
    assert_eq!(interval(-5.0, 1.0_f64.next_down()).acosh(), none);
    assert_eq!(interval(1.0_f64.next_up(), 5.0).asin(), none);
    assert_eq!(interval(-5.0, (-1.0_f64).next_down()).acos(), none);
    // Beyond the range of floats.
    assert_eq!(point(1024.0).exp2(), interval(f64::MAX, inf));
    assert_eq!(point(-1075.0).exp2(), interval(0.0, f64::from_bits(1)));
    assert_eq!(point(309.0).exp10(), interval(f64::MAX, inf));
    assert_eq!(point(-400.0).exp10(), interval(0.0, f64::from_bits(1)));
    assert_eq!(point(800.0).sinh(), interval(f64::MAX, inf));
    assert_eq!(point(-800.0).cosh(), interval(f64::MAX, inf));
    assert_eq!(point(-800.0).expm1(), interval(-1.0, (-1.0_f64).next_up()));
}

/// Angles of points, and of boxes as hulls of the angles of their corners and of points on the axes.
#[test]
fn angles() {
    let fixed = Fixed::new(2700);
    let mut source = Source(97);
    let coordinate = |source: &mut Source| match source.below(6) {
        0 => 0.0,
        1 => source.float(),
        2 => [1.0, -1.0, f64::MAX, f64::from_bits(1)][source.below(4) as usize],
        _ => source.between(-4.0, 4.0),
    };
    for _ in 0..1_500 {
        let (y, x) = (coordinate(&mut source), coordinate(&mut source));
        let found = point(y).atan2(point(x));
        if y == 0.0 && x == 0.0 {
            assert_eq!(found, Interval::EMPTY);
        } else if y == 0.0 && x > 0.0 {
            assert_eq!(found, Interval::ZERO);
        } else {
            let y = if y == 0.0 { 0.0 } else { y };
            assert_encloses(found, &fixed.atan2(y, x), &format!("atan2({y:e}, {x:e})"));
        }
    }
    let plain = |source: &mut Source| match source.below(3) {
        0 => source.below(5) as f64 - 2.0,
        _ => source.between(-4.0, 4.0),
    };
    for _ in 0..20_000 {
        let mut side = || {
            let (a, b) = (plain(&mut source), plain(&mut source));
            point(a).hull(point(b))
        };
        let (y, x) = (side(), side());
        let angle = |y: f64, x: f64| point(y).atan2(point(x));
        let on = |side: Interval| {
            let mut samples = vec![side.lo(), side.hi(), side.mid()];
            samples.extend(
                [0.0, f64::from_bits(1), -f64::from_bits(1)]
                    .iter()
                    .filter(|z| side.contains(**z)),
            );
            samples
        };
        let mut hull = Interval::EMPTY;
        for b in on(y) {
            for a in on(x) {
                hull = hull.hull(angle(b, a));
            }
        }
        let found = y.atan2(x);
        assert!(
            hull.is_subset_of(found),
            "{y:?} {x:?}: {found:?} lacks {hull:?}"
        );
        // The samples next to the axes leave gaps below the limits.
        let slack = hull.inflate(1e-15);
        assert!(
            found.is_subset_of(slack),
            "{y:?} {x:?}: {found:?} beyond {hull:?}"
        );
    }
    let inf = f64::INFINITY;
    assert_eq!(
        Interval::ENTIRE.atan2(Interval::ENTIRE),
        interval(-PI.next_up(), PI.next_up())
    );
    assert_eq!(
        interval(1.0, inf).atan2(interval(1.0, inf)),
        interval(0.0, FRAC_PI_2.next_up())
    );
    assert_eq!(Interval::EMPTY.atan2(Interval::ONE), Interval::EMPTY);
    assert_eq!(Interval::ONE.atan2(Interval::EMPTY), Interval::EMPTY);
    assert_eq!((-Interval::ONE).atan2(Interval::EMPTY), Interval::EMPTY);
}

#[test]
fn real_powers_at_points() {
    let fixed = Fixed::new(1474);
    let mut source = Source(98);
    let mut cases = 0;
    while cases < CASES {
        let x = anywhere(&mut source, f64::MAX, &[1.0, 2.0, 0.5]).abs();
        let y = anywhere(&mut source, 1e18, &[1.0, -1.0, 0.5, 1.5, 3.0, -0.25]);
        let exponent = y * x.ln();
        if x == 0.0 || y.abs() < 1e-100 || exponent.abs() > 700.0 || x == 1.0 {
            continue;
        }
        cases += 1;
        let found = point(x).pow(point(y));
        assert_encloses(found, &fixed.pow(x, y), &format!("{x:e}^{y:e}"));
    }
}

/// Sines of arcs up to a little more than a turn: an end is 1 or -1 exactly where an extreme is inside.
#[test]
fn arcs_of_every_length() {
    let mut source = Source(0xa2c);
    for _ in 0..20_000 {
        let (lo, width) = (source.between(-20.0, 20.0), source.between(0.0, 6.6));
        let x = interval(lo, lo + width);
        // Turns to the next multiple, less the length: the order is clear but for rare cases.
        let rest = |from: f64| ((from - x.lo()) / (2.0 * PI)).rem_euclid(1.0) * 2.0 * PI - width;
        let ends = Interval::point(x.lo())
            .sin()
            .hull(Interval::point(x.hi()).sin());
        for (rest, found, extreme, end) in [
            (rest(FRAC_PI_2), x.sin().hi(), 1.0, ends.hi()),
            (rest(-FRAC_PI_2), x.sin().lo(), -1.0, ends.lo()),
        ] {
            if rest.abs() > 1e-9 {
                assert_eq!(found, if rest < 0.0 { extreme } else { end }, "{x:?}");
            }
        }
    }
}

/// A few floats around a multiple of π/2 of any size: where the cosine changes its sign the sine has an
/// extreme, and where it does not there is none.
#[test]
fn extremes_between_neighbouring_floats() {
    let mut source = Source(0xa2d);
    let mut crossed = 0;
    for _ in 0..50_000 {
        let size = 1 + source.below(51);
        let k = source.below(1 << size) as f64;
        let middle = k * FRAC_PI_2;
        let (below, above) = (source.below(4), source.below(4));
        let lo = (0..below).fold(middle, |x, _| x.next_down());
        let hi = (0..above).fold(middle, |x, _| x.next_up());
        let (slope_lo, slope_hi) = (Interval::point(lo).cos(), Interval::point(hi).cos());
        let (up, down) = (slope_lo.lo() > 0.0, slope_lo.hi() < 0.0);
        let (still_up, still_down) = (slope_hi.lo() > 0.0, slope_hi.hi() < 0.0);
        let sine = interval(lo, hi).sin();
        let ends = Interval::point(lo).sin().hull(Interval::point(hi).sin());
        if up && still_down {
            crossed += 1;
            assert_eq!((sine.lo(), sine.hi()), (ends.lo(), 1.0), "{lo:e} {hi:e}");
        } else if down && still_up {
            crossed += 1;
            assert_eq!((sine.lo(), sine.hi()), (-1.0, ends.hi()), "{lo:e} {hi:e}");
        } else if hi - lo < 1.0 {
            assert_eq!(sine, ends, "{lo:e} {hi:e}");
        }
    }
    assert!(crossed > 5_000, "{crossed}");
}
