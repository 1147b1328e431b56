//! Numbers and intervals as text, read exactly and printed outward.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod support;

use num_bigint::BigInt;
use num_rational::BigRational;
use support::Source;
use veribound_interval::{
    DecimalError, Interval, LiteralError, literal, rational_to_interval, text,
};

fn read(text: &str) -> Interval {
    text.parse()
        .unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn fraction(top: i64, bottom: i64) -> BigRational {
    BigRational::new(BigInt::from(top), BigInt::from(bottom))
}

/// A float as hexadecimal digits and a binary exponent, exactly.
fn hexadecimal(x: f64, shift: i32) -> String {
    let bits = x.to_bits();
    let sign = if x < 0.0 { "-" } else { "" };
    let biased = ((bits >> 52) & 0x7ff) as i32;
    let fraction = bits & ((1 << 52) - 1);
    let (whole, exponent) = if biased == 0 {
        (0, -1022)
    } else {
        (1, biased - 1023)
    };
    // The same number with the point elsewhere.
    let digits = (u128::from(fraction) | (whole << 52)) << shift;
    let (before, after) = (digits >> 52, digits & ((1 << 52) - 1));
    format!("{sign}0x{before:X}.{after:013x}p{:+}", exponent - shift)
}

#[test]
fn every_float_is_read_from_its_hexadecimal_digits() {
    let mut source = Source(46);
    for _ in 0..50_000 {
        let x = source.float();
        let spelled = hexadecimal(x, source.below(9) as i32);
        assert_eq!(
            read(&format!("[{spelled}]")),
            Interval::point(x),
            "{spelled}"
        );
        if x != 0.0 {
            assert_eq!(
                literal::number(&spelled).unwrap(),
                BigRational::from_float(x).unwrap()
            );
        }
    }
    for (spelled, exact) in [
        ("0x1.8p-3", fraction(3, 16)),
        ("0X10", fraction(16, 1)),
        ("-0x.8P1", fraction(-1, 1)),
        ("+0xA.", fraction(10, 1)),
        ("1/3", fraction(1, 3)),
        ("-4/2", fraction(-2, 1)),
        ("0.1/0.3", fraction(1, 3)),
        ("1e2/3", fraction(100, 3)),
        ("-.5", fraction(-1, 2)),
    ] {
        assert_eq!(literal::number(spelled).unwrap(), exact, "{spelled}");
    }
    // More bits than a float has are rounded outward, not away.
    let one = read("[0x1.00000000000001p0]");
    assert_eq!((one.lo(), one.hi()), (1.0, 1.0_f64.next_up()));
    assert_eq!(read("[0x1p-1080]").hi(), f64::from_bits(1));
    assert_eq!(read("[0x1p1024]").lo(), f64::MAX);
}

#[test]
fn fractions_are_enclosed_by_neighbours() {
    let mut source = Source(47);
    for _ in 0..20_000 {
        let top = source.below(2_000_001) as i64 - 1_000_000;
        let bottom = 1 + source.below(1_000_000) as i64;
        let x = read(&format!("[{top}/{bottom}]"));
        let exact = fraction(top, bottom);
        assert_eq!(x, rational_to_interval(&exact));
        assert!(BigRational::from_float(x.lo()).unwrap() <= exact);
        assert!(BigRational::from_float(x.hi()).unwrap() >= exact);
        assert!(x.is_point() || x.lo().next_up() == x.hi());
    }
}

/// What is printed with any number of digits is read as a set around the interval.
#[test]
fn printed_intervals_are_read_around_themselves() {
    let mut source = Source(48);
    for _ in 0..20_000 {
        let (a, b) = source.floats();
        let x = match source.below(20) {
            0 => Interval::point(a).hull(Interval::ENTIRE),
            1 => Interval::new(a, f64::INFINITY).unwrap(),
            2 => Interval::EMPTY,
            _ => Interval::point(a).hull(Interval::point(b)),
        };
        let digits = 1 + source.below(20) as usize;
        let shown = format!("{x:.digits$}");
        let again = read(&shown);
        assert!(x.is_subset_of(again), "{shown}");
        assert_eq!(x.is_empty(), again.is_empty(), "{shown}");
        // With 17 digits a bounded set grows by at most two floats at each end.
        if digits >= 17 && x.is_bounded() && x.mag() < 1e300 && x.mig() > 1e-290 {
            let (lo, hi) = (x.lo().next_down().next_down(), x.hi().next_up().next_up());
            assert!(again.lo() >= lo && again.hi() <= hi, "{shown}");
        }
        // Every float has a finite decimal expansion.
        if x.is_bounded() && x.mag() < 1e20 && x.mig() > 1e-20 {
            assert_eq!(read(&format!("{x:.800}")), x);
        }
        let (lo, hi) = (text::lower(x.lo(), digits), text::upper(x.hi(), digits));
        assert!(x.is_empty() || read(&format!("[{lo},{hi}]")) == again);
    }
}

#[test]
fn intervals_are_read_as_the_standard_writes_them() {
    let interval = |lo, hi| Interval::new(lo, hi).unwrap();
    let inf = f64::INFINITY;
    for (spelled, expected) in [
        ("[1, 2]", interval(1.0, 2.0)),
        ("  [ -1e0 ,0x2 ]\t", interval(-1.0, 2.0)),
        ("[1/2,3/2]", interval(0.5, 1.5)),
        ("[7]", interval(7.0, 7.0)),
        ("[,]", Interval::ENTIRE),
        ("[1,]", interval(1.0, inf)),
        ("[,1]", interval(-inf, 1.0)),
        ("[-INF,+Infinity]", Interval::ENTIRE),
        ("[-infinity, inf]", Interval::ENTIRE),
        ("[Entire]", Interval::ENTIRE),
        ("[EMPTY]", Interval::EMPTY),
        ("[]", Interval::EMPTY),
        ("5.5?5", interval(5.0, 6.0)),
        ("-5.5?5d", interval(-6.0, -5.5)),
        ("5.5?5u", interval(5.5, 6.0)),
        ("10?", interval(9.5, 10.5)),
        ("10??", Interval::ENTIRE),
        ("10??d", interval(-inf, 10.0)),
        ("25?5e1", interval(200.0, 300.0)),
        ("25?5E-1", interval(2.0, 3.0)),
        // Far apart as exact numbers, the same float.
        ("[1e-400, 2e-400]", interval(0.0, f64::from_bits(1))),
    ] {
        assert_eq!(read(spelled), expected, "{spelled}");
    }
}

#[test]
fn what_is_no_interval_is_refused() {
    use LiteralError::{Number, Order, Shape, ZeroDenominator};
    let number = |text: &str, reason| Number {
        text: text.to_string(),
        reason,
    };
    let unexpected = |found, at| DecimalError::UnexpectedCharacter { found, at };
    for (spelled, error) in [
        ("", Shape),
        ("1", Shape),
        ("[1", Shape),
        ("1]", Shape),
        ("5?2x", Shape),
        ("5?2??", Shape),
        ("5e3?2", Shape),
        ("[2, 1]", Order),
        ("[1.0000000000000002, 1.0000000000000001]", Order),
        ("[1/0]", ZeroDenominator),
        ("[0/0, 1]", ZeroDenominator),
        ("[1, 2, 3]", number("2, 3", unexpected(',', 1))),
        ("[inf]", number("inf", unexpected('i', 0))),
        ("[inf, inf]", number("inf", unexpected('i', 0))),
        ("[-inf, -inf]", number("-inf", unexpected('i', 1))),
        ("[+, 1]", number("+", DecimalError::MissingDigits { at: 1 })),
        ("[1, -]", number("-", DecimalError::MissingDigits { at: 1 })),
        ("[nan]", number("nan", unexpected('n', 0))),
        ("[1/2/3]", number("2/3", unexpected('/', 1))),
        ("[1 2]", number("1 2", unexpected(' ', 1))),
        ("[0x]", number("0x", DecimalError::MissingDigits { at: 2 })),
        (
            "[0x1p]",
            number("0x1p", DecimalError::MissingDigits { at: 4 }),
        ),
        ("[--0x1]", number("--0x1", unexpected('-', 1))),
        ("[0x1.2.3]", number("0x1.2.3", unexpected('.', 5))),
        (
            "[0x1p99999999]",
            number("0x1p99999999", DecimalError::TooLarge),
        ),
        ("[0x1p10001]", number("0x1p10001", DecimalError::TooLarge)),
        (
            "[0x.1p-10001]",
            number("0x.1p-10001", DecimalError::TooLarge),
        ),
        ("[1e99999]", number("1e99999", DecimalError::TooLarge)),
        ("?", number("", DecimalError::Empty)),
        ("[５]", number("５", unexpected('５', 0))),
    ] {
        let found = spelled.parse::<Interval>();
        assert_eq!(found, Err(error.clone()), "{spelled:?}");
        assert!(!error.to_string().is_empty());
    }
}
