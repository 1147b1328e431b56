//! The fused product and sum, cancellation, and relations of sets.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod support;

use num_rational::BigRational;
use support::{Dyadic, Source, assert_tight, compare};
use veribound_interval::{Interval, Overlap};

fn interval(lo: f64, hi: f64) -> Interval {
    Interval::new(lo, hi).unwrap()
}

fn point(x: f64) -> Interval {
    Interval::point(x)
}

/// Products and sums of all kinds of floats, nearly cancelling ones among them: exactly rounded once.
#[test]
fn fused_points_are_tight() {
    let mut source = Source(61);
    for case in 0..200_000 {
        let (a, b) = source.floats();
        let product = a * b;
        let c = match case % 4 {
            0 if product.is_finite() => -product,
            1 if product.is_finite() => {
                let shift = 2_f64.powi(source.below(240) as i32 - 120);
                let c = product * shift * (1.0 + f64::EPSILON);
                if c.is_finite() { c } else { 1.0 }
            }
            2 => f64::from_bits(1),
            _ => source.float(),
        };
        let exact = Dyadic::of(a).times(&Dyadic::of(b)).plus(&Dyadic::of(c));
        let found = point(a).fma(point(b), point(c));
        assert_tight(
            found.lo(),
            found.hi(),
            |f| compare(f, &exact),
            || format!("{a:e} * {b:e} + {c:e}"),
        );
    }
}

/// The range over a box is the hull of the values at its corners; unbounded ends are limits.
#[test]
fn fused_intervals_are_spanned_by_corners() {
    let mut source = Source(62);
    for _ in 0..50_000 {
        let mut draw = || {
            let (a, b) = (source.between(-2.0, 2.0), source.between(-2.0, 2.0));
            if source.below(6) == 0 {
                point(a).hull(Interval::ZERO)
            } else {
                point(a).hull(point(b))
            }
        };
        let (x, y, z) = (draw(), draw(), draw());
        let mut hull = Interval::EMPTY;
        for a in [x.lo(), x.hi()] {
            for b in [y.lo(), y.hi()] {
                for c in [z.lo(), z.hi()] {
                    hull = hull.hull(point(a).fma(point(b), point(c)));
                }
            }
        }
        assert_eq!(x.fma(y, z), hull, "{x:?} {y:?} {z:?}");
        assert!(x.fma(y, z).is_subset_of(x * y + z));
    }
    let (inf, all) = (f64::INFINITY, Interval::ENTIRE);
    let one = Interval::ONE;
    assert_eq!(interval(1.0, inf).fma(one, one), interval(2.0, inf));
    assert_eq!(
        interval(-inf, 2.0).fma(interval(1.0, 3.0), one),
        interval(-inf, 7.0)
    );
    assert_eq!(all.fma(Interval::ZERO, one), one);
    assert_eq!(interval(1.0, inf).fma(one, interval(-inf, 0.0)), all);
    assert_eq!(interval(-inf, -1.0).fma(one, interval(0.0, inf)), all);
    for (x, y, z) in [
        (Interval::EMPTY, one, one),
        (one, Interval::EMPTY, one),
        (one, one, Interval::EMPTY),
    ] {
        assert_eq!(x.fma(y, z), Interval::EMPTY);
    }
}

fn exact(x: f64) -> BigRational {
    BigRational::from_float(x).unwrap()
}

/// `z` is the smallest with `self` inside `other + z`, or all numbers exactly where `other` is wider.
#[test]
fn a_cancelled_summand_is_as_small_as_possible() {
    let mut source = Source(63);
    let (mut cancelled, mut refused) = (0, 0);
    for case in 0..40_000 {
        let mut draw = || {
            let (a, b) = source.floats();
            point(a).hull(point(b))
        };
        let (mut x, mut y) = (draw(), draw());
        if case % 3 == 0 {
            // Nearly equal widths: the same set moved, and one float more or less at an end.
            let shift = point(source.between(-1e3, 1e3));
            y = x + shift;
            if source.below(2) == 0 && x.hi() < f64::MAX {
                x = interval(x.lo(), x.hi().next_up());
            }
        }
        if !x.is_bounded() || !y.is_bounded() {
            continue;
        }
        let z = x.cancel_minus(y);
        let fits = exact(x.hi()) - exact(x.lo()) >= exact(y.hi()) - exact(y.lo());
        if fits {
            cancelled += 1;
            let (lo, hi) = (point(x.lo()) - point(y.lo()), point(x.hi()) - point(y.hi()));
            assert_eq!((z.lo(), z.hi()), (lo.lo(), hi.hi()), "{x:?} {y:?}");
        } else {
            refused += 1;
            assert_eq!(z, Interval::ENTIRE, "{x:?} {y:?}");
        }
        assert_eq!(x.cancel_plus(-y), z);
    }
    assert!(
        cancelled > 5_000 && refused > 5_000,
        "{cancelled} {refused}"
    );
    // Widths beyond the largest float still have an order.
    let huge = interval(f64::MIN, f64::MAX);
    assert_eq!(
        huge.cancel_minus(interval(f64::MIN, f64::MAX.next_down())),
        interval(0.0, f64::MAX - f64::MAX.next_down())
    );
    assert_eq!(
        interval(f64::MIN, f64::MAX.next_down()).cancel_minus(huge),
        Interval::ENTIRE
    );
}

/// Relations against their definitions by elements, on a grid of ends.
#[test]
fn relations_hold_by_their_definitions() {
    let inf = f64::INFINITY;
    let ends = [-inf, -1.0, 0.0, 1.0, 2.0, inf];
    let mut sets = vec![Interval::EMPTY];
    for lo in ends {
        sets.extend(ends.iter().filter_map(|hi| Interval::new(lo, *hi)));
    }
    // Elements that show all there is to see about these sets.
    let elements = |x: Interval| {
        (-12..=16)
            .map(|k| f64::from(k) / 4.0)
            .filter(move |e| x.contains(*e))
            .collect::<Vec<f64>>()
    };
    for &x in &sets {
        for &y in &sets {
            let (xs, ys) = (elements(x), elements(y));
            let all =
                |claim: fn(f64, f64) -> bool| xs.iter().all(|a| ys.iter().all(|b| claim(*a, *b)));
            assert_eq!(x.precedes(y), all(|a, b| a <= b), "{x:?} {y:?}");
            assert_eq!(x.strictly_precedes(y), all(|a, b| a < b), "{x:?} {y:?}");
            assert_eq!(x.is_disjoint_from(y), all(|a, b| a != b), "{x:?} {y:?}");
            assert_eq!(
                x.is_subset_of(y),
                xs.iter().all(|a| y.contains(*a)) && (x.is_empty() || x.hull(y) == y)
            );
            let turned = y.overlap(x);
            let expected = match x.overlap(y) {
                Overlap::FirstEmpty => Overlap::SecondEmpty,
                Overlap::SecondEmpty => Overlap::FirstEmpty,
                Overlap::Before => Overlap::After,
                Overlap::After => Overlap::Before,
                Overlap::Meets => Overlap::MetBy,
                Overlap::MetBy => Overlap::Meets,
                Overlap::Overlaps => Overlap::OverlappedBy,
                Overlap::OverlappedBy => Overlap::Overlaps,
                Overlap::Starts => Overlap::StartedBy,
                Overlap::StartedBy => Overlap::Starts,
                Overlap::ContainedBy => Overlap::Contains,
                Overlap::Contains => Overlap::ContainedBy,
                Overlap::Finishes => Overlap::FinishedBy,
                Overlap::FinishedBy => Overlap::Finishes,
                same => same,
            };
            assert_eq!(turned, expected, "{x:?} {y:?}");
            let sum = Interval::ONE;
            if x.is_strictly_less(y) {
                assert!(x.is_weakly_less(y), "{x:?} {y:?}");
            }
            assert_eq!(x.is_weakly_less(y), (-y).is_weakly_less(-x), "{x:?} {y:?}");
            assert_eq!(x.is_strictly_less(y), (x + sum).is_strictly_less(y + sum));
        }
    }
}

#[test]
fn steps_are_the_values_of_floats() {
    let mut source = Source(64);
    type Step = (fn(Interval) -> Interval, fn(f64) -> f64);
    let steps: [Step; 5] = [
        (Interval::floor, f64::floor),
        (Interval::ceil, f64::ceil),
        (Interval::trunc, f64::trunc),
        (Interval::round_ties_to_even, f64::round_ties_even),
        (Interval::round_ties_to_away, f64::round),
    ];
    for _ in 0..20_000 {
        let a = source.float();
        let b = source.below(41) as f64 / 4.0 - 5.0;
        let x = point(a).hull(point(b));
        for (f, at) in steps {
            assert_eq!(f(x), point(at(a)).hull(point(at(b))), "{x:?}");
        }
        let sign = |x: f64| if x == 0.0 { 0.0 } else { x.signum() };
        assert_eq!(x.sign_with_zero(), point(sign(a)).hull(point(sign(b))));
        assert!(x.sign_with_zero().is_subset_of(x.sign()));
    }
    for (f, _) in steps {
        assert_eq!(f(Interval::EMPTY), Interval::EMPTY);
        assert_eq!(f(Interval::ENTIRE), Interval::ENTIRE);
    }
    assert_eq!(Interval::EMPTY.sign_with_zero(), Interval::EMPTY);
}
