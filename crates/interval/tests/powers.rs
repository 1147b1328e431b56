//! Integer powers, roots, real powers that are exact, the fused product and sum, and cancellation,
//! against exact numbers.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod support;

use std::cmp::Ordering;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::One;
use support::{Dyadic, Source, assert_tight, compare};
use veribound_interval::Interval;

fn interval(lo: f64, hi: f64) -> Interval {
    Interval::new(lo, hi).unwrap()
}

fn point(x: f64) -> Interval {
    Interval::point(x)
}

fn whole_power(x: f64, n: u32) -> Dyadic {
    let exact = Dyadic::of(x);
    Dyadic {
        m: exact.m.pow(n),
        e: exact.e * i64::from(n),
    }
}

/// `f` compared with `x^n`: for negative `n`, `f x^-n` with 1, turned round where `x^-n` is negative.
fn compare_power(f: f64, x: f64, n: i32) -> Ordering {
    let power = whole_power(x, n.unsigned_abs());
    if n >= 0 || f.is_infinite() {
        return compare(f, &power);
    }
    let product = Dyadic::of(f).times(&power);
    let order = product.compare(&Dyadic::of(1.0));
    if power.m < BigInt::from(0) {
        order.reverse()
    } else {
        order
    }
}

/// Exponents of all sizes for which the exact power fits the memory.
fn exponent(source: &mut Source) -> i32 {
    let n = match source.below(8) {
        0..4 => 3 + source.below(8),
        4 | 5 => 3 + source.below(62),
        6 => 60 + source.below(10),
        _ => 3 + source.below(1500),
    } as i32;
    if source.below(3) == 0 { -n } else { n }
}

/// A base whose power is mostly in range.
fn base(source: &mut Source, n: i32) -> f64 {
    match source.below(6) {
        0 => source.float(),
        1 => (1 + source.below(64)) as f64 * 2_f64.powi(source.below(9) as i32 - 4),
        2 => -(1.0 + source.unit() / f64::from(n.unsigned_abs())),
        3 => f64::from_bits(1.0_f64.to_bits() + source.below(9) - 4),
        _ => source.between(-2.0, 2.0) * 2_f64.powi((source.below(1800) as i32 - 900) / n),
    }
}

#[test]
fn powers_of_points_are_tight() {
    let mut source = Source(51);
    for _ in 0..30_000 {
        let n = exponent(&mut source);
        let x = base(&mut source, n);
        if x == 0.0 {
            continue;
        }
        let found = point(x).powi(n);
        // Tight, though one float more would be allowed: no random number hits the rare exception.
        assert_tight(
            found.lo(),
            found.hi(),
            |f| compare_power(f, x, n),
            || format!("{x:e}^{n}"),
        );
        // As a real power too, where the base allows it; at most one float further.
        if x > 0.0 {
            assert_eq!(point(x).pow(point(f64::from(n))), found, "{x:e}^{n}");
        }
    }
}

#[test]
fn powers_of_intervals_are_spanned_by_ends_and_zero() {
    let mut source = Source(52);
    for _ in 0..30_000 {
        let n = exponent(&mut source);
        let x = point(base(&mut source, n)).hull(point(base(&mut source, n)));
        let (first, last) = (point(x.lo()).powi(n), point(x.hi()).powi(n));
        let crosses = x.lo() < 0.0 && x.hi() > 0.0;
        let expected = match (n > 0, n % 2 == 0) {
            (true, true) if crosses => first.hull(last).hull(Interval::ZERO),
            (true, _) => first.hull(last),
            (false, true) if x.contains(0.0) => {
                first.hull(last).hull(interval(f64::MAX, f64::INFINITY))
            }
            (false, false) if crosses => Interval::ENTIRE,
            (false, false) if x.hi() == 0.0 => first.hull(interval(f64::NEG_INFINITY, f64::MIN)),
            (false, false) if x.lo() == 0.0 => last.hull(interval(f64::MAX, f64::INFINITY)),
            (false, _) => first.hull(last),
        };
        if x != Interval::ZERO {
            assert_eq!(x.powi(n), expected, "{x:?}^{n}");
        }
    }
    for n in [i32::MAX, i32::MIN, i32::MIN + 1, 1 << 30] {
        let x = interval(0.5, 2.0).powi(n);
        assert_eq!(x, interval(0.0, f64::INFINITY), "{n}");
        assert!(point(1.0_f64.next_up()).powi(n).is_bounded(), "{n}");
        assert_eq!(Interval::ONE.powi(n), Interval::ONE);
        assert_eq!(Interval::ENTIRE.powi(n).hi(), f64::INFINITY);
    }
    assert_eq!(Interval::ZERO.powi(-3), Interval::EMPTY);
    assert_eq!(Interval::ENTIRE.powi(-3), Interval::ENTIRE);
    assert_eq!(Interval::EMPTY.powi(0), Interval::EMPTY);
}

/// Known to 50 digits: `(1 + 2^-52)^(2^31 - 1)`, its reciprocal, and `(1 - 2^-53)^(2^31 - 1)`.
#[test]
fn the_largest_exponents_are_tight() {
    let n = i32::MAX;
    // exp(n ln(1 + u)) = 1 + n u + n (n - 1) u^2 / 2 + n (n - 1) (n - 2) u^3 / 6 + ..., the rest of which
    // is below 2^-80, as fractions.
    let binomial = |u: BigRational| {
        let (mut term, mut sum) = (BigRational::one(), BigRational::one());
        for k in 0..5_i64 {
            let next = BigRational::new(BigInt::from(i64::from(n) - k), BigInt::from(k + 1));
            term = term * next * &u;
            sum += &term;
        }
        sum
    };
    for x in [1.0_f64.next_up(), 1.0_f64.next_down()] {
        let u = BigRational::from_float(x).unwrap() - BigRational::one();
        let power = veribound_interval::rational_to_interval(&binomial(u.clone()));
        assert_eq!(point(x).powi(n), power, "{x}");
        let reciprocal = veribound_interval::rational_to_interval(&binomial(u).recip());
        assert_eq!(point(x).powi(-n), reciprocal, "{x}");
    }
}

#[test]
fn roots_of_points_are_tight() {
    let mut source = Source(53);
    for _ in 0..8_000 {
        let n = match source.below(3) {
            0 => 2 + source.below(400) as i32,
            _ => 2 + source.below(12) as i32,
        };
        let n = if source.below(3) == 0 { -n } else { n };
        // Mostly floats, sometimes exact powers of short numbers.
        let a = match source.below(3) {
            0 => {
                let short = point((1 + source.below(40)) as f64).powi(n.abs());
                if short.is_point() { short.lo() } else { 3.0 }
            }
            _ => source.float().abs(),
        };
        if a == 0.0 {
            continue;
        }
        let found = point(a).rootn(n);
        // f < root(a) for positive n where f^n < a; for negative n where f^|n| a < 1.
        let order = |f: f64| {
            if f <= 0.0 || f.is_infinite() {
                return f.partial_cmp(&1.0).unwrap();
            }
            let power = whole_power(f, n.unsigned_abs());
            if n > 0 {
                power.compare(&Dyadic::of(a))
            } else {
                power.times(&Dyadic::of(a)).compare(&Dyadic::of(1.0))
            }
        };
        assert_tight(found.lo(), found.hi(), order, || {
            format!("root {n} of {a:e}")
        });
        if n % 2 != 0 {
            assert_eq!(point(-a).rootn(n), -found);
        } else {
            assert_eq!(point(-a).rootn(n), Interval::EMPTY);
        }
    }
    let inf = f64::INFINITY;
    let x = interval(-8.0, 27.0);
    assert_eq!(x.rootn(3), interval(-2.0, 3.0));
    assert_eq!(x.rootn(-3), Interval::ENTIRE);
    assert_eq!(interval(0.0, 8.0).rootn(-3), interval(0.5, inf));
    assert_eq!(interval(-8.0, 0.0).rootn(-3), interval(-inf, -0.5));
    assert_eq!(interval(-1.0, 16.0).rootn(4), interval(0.0, 2.0));
    assert_eq!(interval(-1.0, 16.0).rootn(-4), interval(0.5, inf));
    assert_eq!(interval(-1.0, 0.0).rootn(-4), Interval::EMPTY);
    assert_eq!(interval(-1.0, 0.0).rootn(4), Interval::ZERO);
    assert_eq!(Interval::ENTIRE.rootn(5), Interval::ENTIRE);
    assert_eq!(interval(1.0, inf).rootn(-4), interval(0.0, 1.0));
    assert_eq!(x.rootn(0), Interval::EMPTY);
    assert_eq!((x.rootn(1), x.rootn(-1)), (x, x.recip()));
}

/// `x = r^(2^j)` and `y = k / 2^j` give `x^y = r^k`: found as the float it is, or tight.
#[test]
fn real_powers_that_are_rational() {
    let mut source = Source(54);
    let mut exact = 0;
    for _ in 0..20_000 {
        let j = source.below(4) as i32;
        let bits = 1 + source.below(53 >> j);
        let r = (1 + source.below(1 << bits)) as f64 * 2_f64.powi(source.below(21) as i32 - 10);
        let x = point(r).powi(1 << j);
        let k = source.below(25) as i32 - 12;
        if !x.is_point() || k == 0 || r == 1.0 {
            continue;
        }
        let found = x.pow(point(f64::from(k) / f64::from(1 << j)));
        assert_eq!(found, point(r).powi(k), "({r:e}^(2^{j}))^({k}/2^{j})");
        exact += usize::from(found.is_point());
    }
    assert!(exact > 4_000, "{exact}");
    // The smallest float as a power, and roots of it.
    assert_eq!(point(2.0).pow(point(-1074.0)), point(f64::from_bits(1)));
    assert_eq!(
        point(f64::from_bits(1)).pow(point(0.5)),
        point(2_f64.powi(-537))
    );
    assert_eq!(point(4.0).pow(point(-0.5)), point(0.5));
    assert_eq!(
        point(2.0).pow(point(1e300)),
        interval(f64::MAX, f64::INFINITY)
    );
    assert_eq!(
        point(2.0).pow(point(-1e300)),
        interval(0.0, f64::from_bits(1))
    );
}

/// Boxes of bases and exponents: samples inside are enclosed, corners are reached.
#[test]
fn real_powers_of_boxes() {
    let mut source = Source(55);
    for _ in 0..20_000 {
        let mut ends = |from: f64| {
            let mut end = || match source.below(4) {
                0 => [0.0, 1.0, 2.0, 0.5][source.below(4) as usize],
                _ => source.between(from, 3.0),
            };
            let (a, b) = (end(), end());
            point(a).hull(point(b))
        };
        let (x, y) = (ends(-1.0), ends(-3.0));
        let found = x.pow(y);
        // Samples inside: the enclosure of each value meets the range (next to an exact power the
        // enclosure of another one may reach one float beyond).
        for i in 0..=4 {
            for j in 0..=4 {
                let part = |x: Interval, k: i32| x.lo() + (x.hi() - x.lo()) * f64::from(k) / 4.0;
                let (a, b) = (part(x, i), part(y, j));
                let value = point(a).pow(point(b));
                if x.contains(a) && y.contains(b) && !value.is_empty() {
                    assert!(
                        value.intersects(found),
                        "{x:?}^{y:?}: {found:?} lacks {value:?}"
                    );
                }
            }
        }
        // Bases above 0 reach the extremes at corners.
        if x.lo() > 0.0 {
            let corner = |a: f64, b: f64| point(a).pow(point(b));
            let low = corner(x.lo(), y.lo()).hull(corner(x.hi(), y.lo()));
            let high = corner(x.lo(), y.hi()).hull(corner(x.hi(), y.hi()));
            assert_eq!(found, low.hull(high), "{x:?}^{y:?}");
        }
    }
    let inf = f64::INFINITY;
    assert_eq!(Interval::ENTIRE.pow(Interval::ENTIRE), interval(0.0, inf));
    assert_eq!(
        interval(0.0, 0.5).pow(interval(-1.0, 1.0)),
        interval(0.0, inf)
    );
    assert_eq!(interval(0.0, 0.5).pow(Interval::ZERO), Interval::ONE);
    assert_eq!(Interval::ZERO.pow(interval(-1.0, 0.0)), Interval::EMPTY);
    assert_eq!(Interval::ZERO.pow(interval(-1.0, 1.0)), Interval::ZERO);
    assert_eq!(interval(-3.0, -1.0).pow(Interval::ONE), Interval::EMPTY);
    assert_eq!(
        interval(2.0, inf).pow(interval(-inf, -1.0)),
        interval(0.0, 0.5)
    );
}
