//! The directed operations against exact integers: a million cases for each.
//!
//! These tests catch arithmetic that is left rounded to nearest: with `add_down` returning `a + b`, or
//! any other bound not moved outward, `sums_are_tight` and its siblings fail within the first cases
//! (an inexact sum lies above the true value half of the time). They also catch bounds moved too far.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

mod support;

use std::cmp::Ordering;

use num_rational::BigRational;
use num_traits::Zero;
use support::{Dyadic, Source, assert_tight, compare};
use veribound_interval::Interval;
use veribound_interval::round::{
    add_down, add_up, div_down, div_up, mul_down, mul_up, sqrt_down, sqrt_up, sub_down, sub_up,
};

const CASES: usize = 1_000_000;

#[test]
fn sums_are_tight() {
    let mut source = Source(1);
    for _ in 0..CASES {
        let (a, b) = source.floats();
        let exact = Dyadic::of(a).plus(&Dyadic::of(b));
        assert_tight(
            add_down(a, b),
            add_up(a, b),
            |x| compare(x, &exact),
            || format!("{a:e} + {b:e}"),
        );
    }
}

#[test]
fn differences_are_tight() {
    let mut source = Source(2);
    for _ in 0..CASES {
        let (a, b) = source.floats();
        let exact = Dyadic::of(a).plus(&Dyadic::of(-b));
        assert_tight(
            sub_down(a, b),
            sub_up(a, b),
            |x| compare(x, &exact),
            || format!("{a:e} - {b:e}"),
        );
    }
}

#[test]
fn products_are_tight() {
    let mut source = Source(3);
    for _ in 0..CASES {
        let (a, b) = source.floats();
        let exact = Dyadic::of(a).times(&Dyadic::of(b));
        assert_tight(
            mul_down(a, b),
            mul_up(a, b),
            |x| compare(x, &exact),
            || format!("{a:e} * {b:e}"),
        );
    }
}

#[test]
fn quotients_are_tight() {
    let mut source = Source(4);
    for _ in 0..CASES {
        let (a, b) = source.floats();
        if b == 0.0 {
            continue;
        }
        let (top, bottom) = (Dyadic::of(a), Dyadic::of(b));
        // x < a / b  exactly if  x b < a (b > 0) or x b > a (b < 0).
        let order = |x: f64| {
            if x.is_infinite() {
                return compare(x, &top);
            }
            let order = Dyadic::of(x).times(&bottom).compare(&top);
            if b > 0.0 { order } else { order.reverse() }
        };
        assert_tight(div_down(a, b), div_up(a, b), order, || {
            format!("{a:e} / {b:e}")
        });
    }
}

#[test]
fn roots_are_tight() {
    let mut source = Source(5);
    for case in 0..CASES {
        let mut a = source.float().abs();
        if case % 4 == 0 {
            // Squares and their neighbours.
            let square = a * a;
            let steps = source.below(3);
            a = f64::from_bits(square.to_bits() + steps);
        }
        if !a.is_finite() {
            continue;
        }
        let exact = Dyadic::of(a);
        let order = |x: f64| {
            if x < 0.0 {
                return Ordering::Less;
            }
            Dyadic::of(x).times(&Dyadic::of(x)).compare(&exact)
        };
        assert_tight(sqrt_down(a), sqrt_up(a), order, || format!("root of {a:e}"));
    }
}

/// The same claims through an independent exact arithmetic, on fewer cases.
#[test]
fn rational_numbers_agree() {
    let mut source = Source(6);
    let rational = |x: f64| BigRational::from_float(x).unwrap();
    for _ in 0..20_000 {
        let (a, b) = source.floats();
        let (ra, rb) = (rational(a), rational(b));
        let mut results = vec![
            (add_down(a, b), &ra + &rb, add_up(a, b)),
            (mul_down(a, b), &ra * &rb, mul_up(a, b)),
        ];
        if !rb.is_zero() {
            results.push((div_down(a, b), &ra / &rb, div_up(a, b)));
        }
        for (down, exact, up) in results {
            let order = |x: f64| match BigRational::from_float(x) {
                Some(x) => x.cmp(&exact),
                None if x > 0.0 => Ordering::Greater,
                None => Ordering::Less,
            };
            assert_tight(down, up, order, || format!("{a:e} and {b:e}"));
        }
    }
}

#[test]
fn infinities_and_nan_claim_nothing_wrong() {
    let inf = f64::INFINITY;
    assert_eq!((add_down(inf, -inf), add_up(inf, -inf)), (-inf, inf));
    assert_eq!((mul_down(0.0, inf), mul_up(-inf, 0.0)), (0.0, 0.0));
    assert_eq!((mul_down(-2.0, inf), mul_up(-2.0, -inf)), (-inf, inf));
    assert_eq!((div_down(1.0, inf), div_up(-1.0, inf)), (0.0, 0.0));
    assert_eq!((div_down(1.0, 0.0), div_up(1.0, 0.0)), (-inf, inf));
    assert_eq!((sqrt_down(inf), sqrt_up(inf)), (inf, inf));
    assert_eq!((sqrt_down(-1.0), sqrt_up(-1.0)), (-inf, inf));
    for (down, up) in [
        (add_down(f64::NAN, 1.0), add_up(1.0, f64::NAN)),
        (mul_down(f64::NAN, 0.0), mul_up(0.0, f64::NAN)),
        (div_down(f64::NAN, 1.0), div_up(1.0, f64::NAN)),
        (sqrt_down(f64::NAN), sqrt_up(f64::NAN)),
    ] {
        assert_eq!((down, up), (-inf, inf));
    }
}

fn random_interval(source: &mut Source) -> Interval {
    let (a, b) = source.floats();
    match source.below(8) {
        0 => Interval::point(a),
        1 => Interval::point(a).hull(Interval::ZERO),
        2 => Interval::new(a, f64::INFINITY).unwrap(),
        3 => Interval::point(a).hull(Interval::point(a.next_up().min(f64::MAX))),
        _ => Interval::point(a).hull(Interval::point(b)),
    }
}

/// All four products (or quotients) of ends, with the scalar operations that the tests above check.
fn by_ends(
    x: Interval,
    y: Interval,
    down: fn(f64, f64) -> f64,
    up: fn(f64, f64) -> f64,
) -> Interval {
    let pairs = [
        (x.lo(), y.lo()),
        (x.lo(), y.hi()),
        (x.hi(), y.lo()),
        (x.hi(), y.hi()),
    ];
    let lo = pairs
        .iter()
        .map(|&(a, b)| down(a, b))
        .fold(f64::INFINITY, f64::min);
    let hi = pairs
        .iter()
        .map(|&(a, b)| up(a, b))
        .fold(f64::NEG_INFINITY, f64::max);
    Interval::new(lo, hi).unwrap()
}

#[test]
fn interval_operations_are_the_hull_of_their_ends() {
    let mut source = Source(7);
    for _ in 0..CASES {
        let (x, y) = (random_interval(&mut source), random_interval(&mut source));
        let sum = Interval::new(add_down(x.lo(), y.lo()), add_up(x.hi(), y.hi())).unwrap();
        assert_eq!(x + y, sum, "{x:?} + {y:?}");
        let difference = Interval::new(sub_down(x.lo(), y.hi()), sub_up(x.hi(), y.lo())).unwrap();
        assert_eq!(x - y, difference, "{x:?} - {y:?}");
        assert_eq!(x * y, by_ends(x, y, mul_down, mul_up), "{x:?} * {y:?}");
        if !y.contains(0.0) && x.is_bounded() && y.is_bounded() {
            assert_eq!(x / y, by_ends(x, y, div_down, div_up), "{x:?} / {y:?}");
        }
        let size = Interval::new(x.mig(), x.mag()).unwrap();
        assert_eq!(x.sqr(), size * size, "square of {x:?}");
        if x.lo() >= 0.0 {
            let root = Interval::new(sqrt_down(x.lo()), sqrt_up(x.hi())).unwrap();
            assert_eq!(x.sqrt(), root, "root of {x:?}");
        }
        assert!(x.is_subset_of(x.hull(y)) && x.intersect(y).is_subset_of(y));
        assert!(x.contains(x.mid()), "middle of {x:?}");
        let around = Interval::point(x.mid()) + Interval::symmetric(x.rad());
        assert!(x.is_subset_of(around), "radius of {x:?}");
    }
}

/// Width, radius and inflated ends are single directed operations: the tight ones, and outward.
#[test]
fn widths_and_radii_are_tight() {
    let mut source = Source(9);
    // The smallest float not below the largest of some differences.
    let assert_least = |found: f64, differences: &[Dyadic], what: &str| {
        let above = |x: f64| differences.iter().all(|d| compare(x, d) != Ordering::Less);
        assert!(above(found), "{what}: {found:e} is too small");
        assert!(!above(found.next_down()), "{what}: {found:e} is too large");
    };
    for _ in 0..CASES / 10 {
        let (a, b) = source.floats();
        let x = Interval::point(a).hull(Interval::point(b));
        let difference = |a: f64, b: f64| Dyadic::of(a).plus(&Dyadic::of(-b));
        assert_least(x.width(), &[difference(x.hi(), x.lo())], "width");
        let mid = x.mid();
        let sides = [difference(x.hi(), mid), difference(mid, x.lo())];
        assert_least(x.rad(), &sides, "radius");
        let r = source.float().abs();
        let around = x.inflate(r);
        assert_least(around.hi(), &[difference(x.hi(), -r)], "upper end");
        assert_least(-around.lo(), &[difference(-x.lo(), -r)], "lower end");
    }
    let x = Interval::new(-1.0, 2.0).unwrap();
    assert_eq!(x.inflate(-1.0), x);
    assert_eq!(x.inflate(f64::NAN), Interval::ENTIRE);
    assert_eq!(Interval::EMPTY.inflate(1.0), Interval::EMPTY);
}

#[test]
fn powers_contain_the_exact_ones_and_are_near() {
    let mut source = Source(8);
    for _ in 0..100_000 {
        let x = random_interval(&mut source);
        let n = 1 + source.below(9) as i32;
        let power = x.powi(n);
        let exact = |x: f64| (1..n).fold(Dyadic::of(x), |p, _| p.times(&Dyadic::of(x)));
        let slack = 2;
        let even_around_zero = n % 2 == 0 && x.contains(0.0);
        let (least, most) = if n % 2 == 0 {
            (x.mig(), x.mag())
        } else {
            (x.lo(), x.hi())
        };
        if even_around_zero {
            assert_eq!(power.lo(), 0.0);
        }
        if least.is_finite() {
            let inner = (0..slack).fold(power.lo(), |x, _| x.next_up());
            assert_ne!(
                compare(power.lo(), &exact(least)),
                Ordering::Greater,
                "{x:?}^{n}"
            );
            assert_ne!(compare(inner, &exact(least)), Ordering::Less, "{x:?}^{n}");
        }
        if most.is_finite() {
            let inner = (0..slack).fold(power.hi(), |x, _| x.next_down());
            assert_ne!(
                compare(power.hi(), &exact(most)),
                Ordering::Less,
                "{x:?}^{n}"
            );
            assert_ne!(compare(inner, &exact(most)), Ordering::Greater, "{x:?}^{n}");
        }
        assert!(x.powi(-n).is_subset_of(x.powi(n).recip()));
        assert!(Interval::point(x.mid()).powi(-n).is_subset_of(x.powi(-n)));
    }
    let x = Interval::new(0.9, 1.1).unwrap();
    assert!(x.powi(i32::MAX).contains(1.0) && x.powi(i32::MIN).contains(1.0));
    assert_eq!(Interval::ZERO.powi(-1), Interval::EMPTY);
    assert_eq!(Interval::ZERO.powi(0), Interval::ONE);
}
