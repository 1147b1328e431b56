//! How regular operations are said to be, against what they do.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod support;

use support::Source;
use veribound_interval::Regularity::{Jump, Kink, Smooth, Undefined};
use veribound_interval::{Interval, Regularity, domain};

const CASES: usize = 1_000;

fn interval(lo: f64, hi: f64) -> Interval {
    Interval::new(lo, hi).unwrap()
}

/// A function of one number, and its claim.
struct One {
    name: &'static str,
    f: fn(Interval) -> Interval,
    claim: fn(Interval) -> Regularity,
    /// Numbers at which something happens, and what is left of the regularity on a set with this number
    /// as lower end, inside, as upper end.
    special: &'static [(f64, [Regularity; 3])],
}

const HALF_PI: f64 = std::f64::consts::FRAC_PI_2;

#[rustfmt::skip]
const FUNCTIONS: &[One] = &[
    One { name: "recip", f: Interval::recip, claim: domain::recip, special: &[(0.0, [Undefined; 3])] },
    One { name: "sqrt", f: Interval::sqrt, claim: domain::sqrt, special: &[(0.0, [Kink, Undefined, Undefined])] },
    One { name: "ln", f: Interval::ln, claim: domain::ln, special: &[(0.0, [Undefined; 3])] },
    One { name: "log2", f: Interval::log2, claim: domain::ln, special: &[(0.0, [Undefined; 3])] },
    One { name: "log10", f: Interval::log10, claim: domain::ln, special: &[(0.0, [Undefined; 3])] },
    One { name: "log1p", f: Interval::log1p, claim: domain::log1p, special: &[(-1.0, [Undefined; 3])] },
    One { name: "abs", f: Interval::abs, claim: domain::abs, special: &[(0.0, [Smooth, Kink, Smooth])] },
    One { name: "sign", f: Interval::sign, claim: domain::sign, special: &[(0.0, [Jump; 3])] },
    One { name: "sign_with_zero", f: Interval::sign_with_zero, claim: domain::sign_with_zero, special: &[(0.0, [Jump; 3])] },
    One { name: "floor", f: Interval::floor, claim: domain::floor, special: &[(2.0, [Smooth, Jump, Jump]), (-1.0, [Smooth, Jump, Jump])] },
    One { name: "ceil", f: Interval::ceil, claim: domain::ceil, special: &[(2.0, [Jump, Jump, Smooth]), (-1.0, [Jump, Jump, Smooth])] },
    One { name: "trunc", f: Interval::trunc, claim: domain::trunc, special: &[(2.0, [Smooth, Jump, Jump]), (-1.0, [Jump, Jump, Smooth])] },
    One { name: "to even", f: Interval::round_ties_to_even, claim: domain::round_ties_to_even, special: &[(1.5, [Smooth, Jump, Jump]), (2.5, [Jump, Jump, Smooth])] },
    One { name: "to away", f: Interval::round_ties_to_away, claim: domain::round_ties_to_away, special: &[(1.5, [Smooth, Jump, Jump]), (-2.5, [Jump, Jump, Smooth])] },
    One { name: "tan", f: Interval::tan, claim: domain::tan, special: &[(HALF_PI, [Undefined, Undefined, Smooth])] },
    One { name: "asin", f: Interval::asin, claim: domain::asin, special: &[(-1.0, [Kink, Undefined, Undefined]), (1.0, [Undefined, Undefined, Kink])] },
    One { name: "acos", f: Interval::acos, claim: domain::acos, special: &[(-1.0, [Kink, Undefined, Undefined]), (1.0, [Undefined, Undefined, Kink])] },
    One { name: "acosh", f: Interval::acosh, claim: domain::acosh, special: &[(1.0, [Kink, Undefined, Undefined])] },
    One { name: "atanh", f: Interval::atanh, claim: domain::atanh, special: &[(-1.0, [Undefined; 3]), (1.0, [Undefined; 3])] },
    One { name: "x^-1", f: |x| x.powi(-1), claim: |x| domain::powi(x, -1), special: &[(0.0, [Undefined; 3])] },
    One { name: "x^-2", f: |x| x.powi(-2), claim: |x| domain::powi(x, -2), special: &[(0.0, [Undefined; 3])] },
    One { name: "x^3", f: |x| x.powi(3), claim: |x| domain::powi(x, 3), special: &[(0.0, [Smooth; 3])] },
    One { name: "root 3", f: |x| x.rootn(3), claim: |x| domain::rootn(x, 3), special: &[(0.0, [Kink; 3])] },
    One { name: "root 4", f: |x| x.rootn(4), claim: |x| domain::rootn(x, 4), special: &[(0.0, [Kink, Undefined, Undefined])] },
    One { name: "root -3", f: |x| x.rootn(-3), claim: |x| domain::rootn(x, -3), special: &[(0.0, [Undefined; 3])] },
    One { name: "root -4", f: |x| x.rootn(-4), claim: |x| domain::rootn(x, -4), special: &[(0.0, [Undefined; 3])] },
    One { name: "root 1", f: |x| x.rootn(1), claim: |x| domain::rootn(x, 1), special: &[(0.0, [Smooth; 3])] },
    One { name: "x^1.5", f: |x| x.pow(Interval::point(1.5)), claim: |x| domain::pow(x, Interval::point(1.5)), special: &[(0.0, [Kink, Undefined, Undefined])] },
    One { name: "x^-0.5", f: |x| x.pow(Interval::point(-0.5)), claim: |x| domain::pow(x, Interval::point(-0.5)), special: &[(0.0, [Undefined; 3])] },
    One { name: "exp", f: Interval::exp, claim: |x| domain::everywhere([x]), special: &[(0.0, [Smooth; 3])] },
];

/// At the numbers where something happens the claims are exactly right: with the number, with one float
/// more, with one float less.
#[test]
fn claims_change_at_the_very_float() {
    let width = 0.25;
    for One {
        name,
        claim,
        special,
        ..
    } in FUNCTIONS
    {
        assert_eq!(claim(Interval::EMPTY), Undefined, "{name}");
        for &(x, [first, inside, last]) in *special {
            for (set, expected) in [
                (interval(x, x + width), first),
                (interval(x - width, x), last),
                (interval(x - width, x + width), inside),
                (interval(x.next_down(), x + width), inside),
                (interval(x - width, x.next_up()), inside),
            ] {
                assert_eq!(claim(set), expected, "{name} on {set:?}");
            }
        }
    }
    // The lower end of the widest gap without a pole, and all numbers.
    assert_eq!(domain::tan(interval(-HALF_PI, HALF_PI)), Smooth);
    assert_eq!(domain::tan(Interval::ENTIRE), Undefined);
    assert_eq!(domain::floor(interval(0.0, 1.0_f64.next_down())), Smooth);
    assert_eq!(domain::floor(Interval::ENTIRE), Jump);
    assert_eq!(domain::sign_with_zero(Interval::ZERO), Smooth);
    assert_eq!(domain::sign(Interval::ZERO), Jump);
    assert_eq!(domain::abs(Interval::ENTIRE), Kink);
    assert_eq!(domain::rootn(Interval::ONE, 0), Undefined);
    assert!(Undefined < Jump && Jump < Kink && Kink < Smooth);
}

/// A set around the interesting numbers.
fn draw(source: &mut Source) -> Interval {
    let end = |source: &mut Source| match source.below(4) {
        0 => source.float().clamp(-1e9, 1e9),
        1 => [0.0, 1.0, -1.0, 0.5, 1.5, -2.5, HALF_PI][source.below(7) as usize],
        _ => source.between(-3.0, 3.0),
    };
    let a = end(source);
    if source.below(8) == 0 {
        return Interval::point(a);
    }
    let b = if source.below(3) == 0 {
        a + source.unit() * 2_f64.powi(-(source.below(50) as i32))
    } else {
        end(source)
    };
    Interval::point(a).hull(Interval::point(b))
}

/// No claim is better than what samples show: every sample has a value, and halving towards the largest
/// change finds no two neighbouring floats whose values lie apart.
#[test]
fn samples_refute_no_claim() {
    let mut source = Source(71);
    for _ in 0..CASES {
        let x = draw(&mut source);
        for One { name, f, claim, .. } in FUNCTIONS {
            let claimed = claim(x);
            if claimed == Undefined {
                continue;
            }
            let at = |x: f64| {
                let value = f(Interval::point(x));
                assert!(
                    !value.is_empty(),
                    "{name} has no value at {x:e} in {claimed:?}"
                );
                value
            };
            let (mut a, mut b) = (x.lo(), x.hi());
            if claimed < Kink {
                at(a);
                at(b);
                continue;
            }
            while a.next_up() < b {
                let middle = a + 0.5 * (b - a);
                if middle <= a || middle >= b {
                    break;
                }
                let values = [at(a), at(middle), at(b)].map(Interval::mid);
                if (values[1] - values[0]).abs() > (values[2] - values[1]).abs() {
                    b = middle;
                } else {
                    a = middle;
                }
            }
            let (first, last) = (at(a), at(b));
            let gap = first.hull(last).width();
            let slack = 1e-6 * (1.0 + first.mag().max(last.mag()));
            // Next to a pole the values of neighbours are far apart and large, and subnormal neighbours are
            // themselves far apart.
            if first.mag().max(last.mag()) > 1e8 || a.abs().max(b.abs()) < 1e-290 {
                continue;
            }
            assert!(
                gap <= slack,
                "{name} jumps between {a:e} and {b:e} in {x:?}"
            );
        }
    }
}

/// A function of two numbers, its claim, and the truth about boxes by other means.
#[test]
fn claims_about_two_arguments() {
    let mut source = Source(72);
    let mut draw = || {
        let mut end = || source.below(7) as f64 - 3.0;
        Interval::point(end()).hull(Interval::point(end()))
    };
    // Ends are whole, so halves show every sign, order and touching there is.
    let samples = |x: Interval| {
        (0..=12)
            .map(move |k| x.lo() + f64::from(k) / 2.0)
            .filter(move |sample| x.contains(*sample))
    };
    for _ in 0..20_000 {
        let (x, y) = (draw(), draw());
        let pairs = || samples(x).flat_map(|a| samples(y).map(move |b| (a, b)));
        let point = Interval::point;
        let undefined = |f: fn(Interval, Interval) -> Interval| {
            pairs().any(|(a, b)| f(point(a), point(b)).is_empty())
        };
        assert_eq!(
            domain::div(x, y) == Undefined,
            undefined(|x, y| x / y),
            "{x:?} / {y:?}"
        );
        assert_eq!(
            domain::pow(x, y) == Undefined,
            undefined(Interval::pow),
            "{x:?}^{y:?}"
        );
        assert_eq!(
            domain::atan2(x, y) == Undefined,
            undefined(Interval::atan2),
            "atan2 {x:?} {y:?}"
        );
        // A jump: a point on the negative half of the axis, and points below in the box.
        let on_axis = pairs().any(|(a, b)| a == 0.0 && b < 0.0);
        let below = pairs().any(|(a, b)| a < 0.0 && b < 0.0);
        if domain::atan2(x, y) != Undefined {
            assert_eq!(domain::atan2(x, y) == Jump, on_axis && below, "{x:?} {y:?}");
        }
        let least_first = pairs().any(|(a, b)| a < b);
        let least_second = pairs().any(|(a, b)| b < a);
        let kink = least_first && least_second;
        assert_eq!(domain::min(x, y) == Kink, kink, "min {x:?} {y:?}");
        assert_eq!(domain::max(x, y), domain::min(x, y));
    }
    let (empty, one) = (Interval::EMPTY, Interval::ONE);
    for rule in [
        domain::div,
        domain::pow,
        domain::atan2,
        domain::min,
        domain::max,
    ] {
        assert_eq!(rule(empty, one), Undefined);
        assert_eq!(rule(one, empty), Undefined);
    }
    assert_eq!(domain::everywhere([one, one, empty]), Undefined);
    assert_eq!(domain::everywhere([one, one, one]), Smooth);
}
