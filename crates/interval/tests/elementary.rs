//! The elementary functions against series in big integers.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

#[path = "support/oracle.rs"]
mod oracle;
#[path = "support/points.rs"]
mod points;
mod support;

use std::cmp::Ordering;
use std::f64::consts::{FRAC_PI_2, PI};

use num_traits::ToPrimitive;
use oracle::Fixed;
use points::{Exact, Function, Precisions, anywhere};
use support::{Source, compare};
use veribound_interval::{Interval, Regularity, domain};

const CASES: usize = 10_000;

fn check(name: &str, f: Function, exact: Exact, seed: u64, draw: impl Fn(&mut Source) -> f64) {
    points::check(name, f, exact, seed, CASES, draw);
}

#[test]
fn exponential() {
    check("exp", Interval::exp, Fixed::exp, 11, |s| {
        anywhere(s, 700.0, &[1.0, -1.0, 709.78])
    });
    check("exp", Interval::exp, Fixed::exp, 12, |s| {
        s.between(-760.0, 712.0)
    });
}

#[test]
fn logarithm() {
    check("ln", Interval::ln, Fixed::ln, 13, |s| {
        anywhere(s, f64::MAX, &[1.0, std::f64::consts::E])
            .abs()
            .max(f64::from_bits(1))
    });
}

#[test]
fn sine_cosine_tangent() {
    let anchors: Vec<f64> = (1..40).map(|k| f64::from(k) * FRAC_PI_2).collect();
    let draw = |s: &mut Source| anywhere(s, f64::MAX, &anchors);
    check("sin", Interval::sin, Fixed::sin, 14, draw);
    check("cos", Interval::cos, Fixed::cos, 15, draw);
    check("tan", Interval::tan, Fixed::tan, 16, draw);
}

#[test]
fn arc_tangent() {
    check("atan", Interval::atan, Fixed::atan, 17, |s| {
        anywhere(s, f64::MAX, &[1.0, -1.0])
    });
}

#[test]
fn hyperbolic_tangent() {
    check("tanh", Interval::tanh, Fixed::tanh, 18, |s| {
        anywhere(s, 100.0, &[1.0, 19.06])
    });
    assert_eq!(
        Interval::point(1e3).tanh(),
        Interval::new(1.0_f64.next_down(), 1.0).unwrap()
    );
}

/// Sine, cosine and tangent of intervals: exactly the right multiples of π/2 are found, whatever the
/// magnitude of the ends.
#[test]
fn extremes_inside_an_interval() {
    let precisions = Precisions::new();
    let mut source = Source(19);
    for _ in 0..20_000 {
        let lo = anywhere(&mut source, f64::MAX, &[FRAC_PI_2, PI]);
        let width = match source.below(4) {
            0 => source.between(0.0, 7.0),
            1 => (source.below(6) as f64) * FRAC_PI_2,
            2 => 0.0,
            _ => source.between(0.0, 0.1) * lo.abs(),
        };
        let x = Interval::point(lo).hull(Interval::point((lo + width).min(f64::MAX)));
        // Half turns inside (lo, hi]; 0 as the lower end has its own value at the end.
        let first = precisions.of(x.lo()).quarter_turns(x.lo());
        let last = precisions.of(x.hi()).quarter_turns(x.hi());
        let count = (&last - &first).to_i64().unwrap_or(i64::MAX).min(8);
        let start = ((first % 4_i64 + 4_i64) % 4_i64).to_i64().unwrap();
        let meets = |residue: i64| (1..=count).any(|k| (start + k) % 4 == residue);
        let two = |f: Exact| {
            let [a, b] = [x.lo(), x.hi()].map(|x| f(precisions.of(x), x));
            if a.compare(&b) == Ordering::Less {
                (a, b)
            } else {
                (b, a)
            }
        };
        let what = |name: &str| format!("{name} of {x:?}");
        for (name, result, ends, top, bottom) in [
            ("sin", x.sin(), two(Fixed::sin), 1, 3),
            ("cos", x.cos(), two(Fixed::cos), 0, 2),
        ] {
            if meets(top) {
                assert_eq!(result.hi(), 1.0, "{}", what(name));
            } else {
                assert_ne!(
                    compare(result.hi(), &ends.1),
                    Ordering::Less,
                    "{}",
                    what(name)
                );
                let inner = result.hi().next_down().next_down();
                assert_ne!(compare(inner, &ends.1), Ordering::Greater, "{}", what(name));
            }
            if meets(bottom) {
                assert_eq!(result.lo(), -1.0, "{}", what(name));
            } else {
                assert_ne!(
                    compare(result.lo(), &ends.0),
                    Ordering::Greater,
                    "{}",
                    what(name)
                );
                let inner = result.lo().next_up().next_up();
                assert_ne!(compare(inner, &ends.0), Ordering::Less, "{}", what(name));
            }
        }
        if meets(1) || meets(3) {
            assert_eq!(x.tan(), Interval::ENTIRE, "{}", what("tan"));
            assert_eq!(domain::tan(x), Regularity::Undefined);
        } else {
            let (least, most) = two(Fixed::tan);
            assert_ne!(
                compare(x.tan().lo(), &least),
                Ordering::Greater,
                "{}",
                what("tan")
            );
            assert_ne!(
                compare(x.tan().hi(), &most),
                Ordering::Less,
                "{}",
                what("tan")
            );
            assert_eq!(domain::tan(x), Regularity::Smooth);
        }
    }
}

/// Larger arguments give larger results: checked on nested intervals of all kinds.
#[test]
fn inclusion_is_kept() {
    let functions: [(&str, Function); 12] = [
        ("exp", Interval::exp),
        ("ln", Interval::ln),
        ("sin", Interval::sin),
        ("cos", Interval::cos),
        ("tan", Interval::tan),
        ("atan", Interval::atan),
        ("tanh", Interval::tanh),
        ("sqrt", Interval::sqrt),
        ("sqr", Interval::sqr),
        ("recip", Interval::recip),
        ("abs", Interval::abs),
        ("sign", Interval::sign),
    ];
    let mut source = Source(20);
    for _ in 0..20_000 {
        let mut draw = || Interval::point(anywhere(&mut source, f64::MAX, &[1.0]));
        let inner = draw().hull(draw());
        let outer = inner.hull(draw());
        for (name, f) in functions {
            assert!(
                f(inner).is_subset_of(f(outer)),
                "{name} of {inner:?} and {outer:?}"
            );
            let middle = f(Interval::point(inner.mid()));
            assert!(
                middle.is_subset_of(f(inner)),
                "{name} of {inner:?} at its middle"
            );
        }
    }
}
