//! Decimal text in and out, against exact fractions.

#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod support;

use num_bigint::BigInt;
use num_rational::BigRational;
use support::Source;
use veribound_interval::{Decimal, DecimalError, Interval, rational_to_interval, text};

fn fraction(x: f64) -> BigRational {
    BigRational::from_float(x).unwrap()
}

fn random_text(source: &mut Source) -> String {
    let mut text = String::from(["", "-", "+"][source.below(3) as usize]);
    let most = [3, 8, 17, 40, 400][source.below(5) as usize];
    let count = 1 + source.below(most);
    let point = source.below(count + 1);
    for k in 0..count {
        if k == point {
            text.push('.');
        }
        text.push(char::from(b'0' + source.below(10) as u8));
    }
    match source.below(4) {
        0 => text.push_str(&format!("e{}", source.below(700) as i64 - 350)),
        1 => text.push_str(&format!("E{:+}", source.below(40) as i64 - 20)),
        _ => {}
    }
    text
}

/// `lo <= number <= hi`, and no narrower pair of floats would do.
fn assert_smallest(x: Interval, number: &BigRational, what: &str) {
    if x.lo().is_finite() {
        assert!(fraction(x.lo()) <= *number, "{what}: {x:?}");
    }
    if x.hi().is_finite() {
        assert!(fraction(x.hi()) >= *number, "{what}: {x:?}");
    }
    if x.is_point() {
        assert!(fraction(x.lo()) == *number, "{what}: {x:?}");
    } else {
        assert_eq!(x.lo().next_up(), x.hi(), "{what}: {x:?}");
    }
}

#[test]
fn a_decimal_becomes_the_smallest_interval() {
    let mut source = Source(41);
    for _ in 0..50_000 {
        let spelled = random_text(&mut source);
        let number = Decimal::parse(&spelled).unwrap();
        let exact = number.to_rational();
        assert_smallest(number.to_interval(), &exact, &spelled);
        assert_eq!(
            rational_to_interval(&exact),
            number.to_interval(),
            "{spelled}"
        );
        let again = Decimal::parse(&number.to_string()).unwrap();
        assert_eq!(again, number, "{spelled} shown as {number}");
    }
}

/// Floats and the middles between them, spelled exactly: the hardest cases of rounding.
#[test]
fn floats_and_ties_are_decided_exactly() {
    let mut source = Source(42);
    for _ in 0..3_000 {
        let x = source.float();
        if x == 0.0 || x.abs() == f64::MAX {
            continue;
        }
        let exact = fraction(x);
        assert_eq!(rational_to_interval(&exact), Interval::point(x));
        let above = x.next_up();
        let middle = (&exact + fraction(above)) / BigInt::from(2);
        assert_eq!(
            rational_to_interval(&middle),
            Interval::new(x, above).unwrap()
        );
    }
    for spelled in ["1e400", "9e9999", "1.8e308"] {
        let x = Decimal::parse(spelled).unwrap().to_interval();
        assert_eq!((x.lo(), x.hi()), (f64::MAX, f64::INFINITY));
    }
    let tiny = Decimal::parse("-1e-9999").unwrap().to_interval();
    assert_eq!((tiny.lo(), tiny.hi()), (-f64::from_bits(1), 0.0));
    let border = Decimal::parse("9007199254740993").unwrap().to_interval();
    assert_eq!(
        (border.lo(), border.hi()),
        (9007199254740992.0, 9007199254740994.0)
    );
}

#[test]
fn sums_differences_and_order_are_exact() {
    let mut source = Source(43);
    for _ in 0..5_000 {
        let [a, b] = [0, 1].map(|_| Decimal::parse(&random_text(&mut source)).unwrap());
        let (ra, rb) = (a.to_rational(), b.to_rational());
        assert_eq!((&a + &b).to_rational(), &ra + &rb);
        assert_eq!((&a - &b).to_rational(), &ra - &rb);
        assert_eq!((-&a).to_rational(), -&ra);
        assert_eq!(a.cmp(&b), ra.cmp(&rb));
        assert_eq!(a.is_negative(), ra < BigRational::from_integer(0.into()));
    }
    assert_eq!(
        Decimal::parse("0.10").unwrap(),
        Decimal::parse("1e-1").unwrap()
    );
    assert_eq!(Decimal::from_i64(-12).to_string(), "-12");
    assert!(Decimal::zero().is_zero());
    assert_eq!(Decimal::parse("-0.0").unwrap(), Decimal::zero());
}

#[test]
fn what_is_no_decimal_is_refused_with_its_place() {
    use DecimalError::{Empty, MissingDigits, TooLarge, UnexpectedCharacter};
    let unexpected = |found, at| UnexpectedCharacter { found, at };
    for (spelled, error) in [
        ("", Empty),
        ("+", MissingDigits { at: 1 }),
        (".", MissingDigits { at: 1 }),
        ("-.e3", unexpected('e', 2)),
        ("1e", MissingDigits { at: 2 }),
        ("1e+", MissingDigits { at: 3 }),
        ("1,5", unexpected(',', 1)),
        ("1.2.3", unexpected('.', 3)),
        (" 1", unexpected(' ', 0)),
        ("1 ", unexpected(' ', 1)),
        ("nan", unexpected('n', 0)),
        ("-inf", unexpected('i', 1)),
        ("0x10", unexpected('x', 1)),
        ("1_000", unexpected('_', 1)),
        ("1e5.0", unexpected('.', 3)),
        ("--1", unexpected('-', 1)),
        ("１", unexpected('１', 0)),
        ("3µ", unexpected('µ', 1)),
        ("1e10001", TooLarge),
        ("1e-99999999999999999999999999", TooLarge),
    ] {
        assert_eq!(Decimal::parse(spelled), Err(error), "{spelled:?}");
        assert!(!error.to_string().is_empty());
    }
    assert_eq!(Decimal::parse(&"1".repeat(10_001)), Err(TooLarge));
    assert!(Decimal::parse(&"1".repeat(10_000)).is_ok());
    for spelled in ["1.", ".5", "+3", "-0", "00012.50", "1E5"] {
        assert!(Decimal::parse(spelled).is_ok(), "{spelled}");
    }
}

/// Printed bounds never lie inside, and are the nearest with that many digits.
#[test]
fn printed_bounds_are_outward_and_tight() {
    let mut source = Source(44);
    let ten = BigRational::from_integer(10.into());
    for case in 0..60_000 {
        let x = if case % 2 == 0 {
            source.float()
        } else {
            source.between(-1000.0, 1000.0)
        };
        if x == 0.0 {
            continue;
        }
        let digits = 1 + source.below(20) as usize;
        let (low, high) = (text::lower(x, digits), text::upper(x, digits));
        let [down, up] = [&low, &high].map(|text| Decimal::parse(text).unwrap().to_rational());
        let exact = fraction(x);
        assert!(down <= exact && exact <= up, "{x:e}: {low} {high}");
        // One unit of the last digit, from the leading digit of the bound with the larger magnitude.
        let size = if x > 0.0 { &high } else { &low };
        let shown = format!("{:e}", size.parse::<f64>().unwrap().abs());
        if size.contains("e308") {
            continue;
        }
        let lead: i32 = shown.split('e').nth(1).unwrap().parse().unwrap();
        let unit = ten.pow(lead + 1 - digits as i32);
        assert!(
            &up - &down <= unit,
            "{x:e} with {digits} digits: {low} {high}"
        );
        if down == exact || up == exact {
            assert_eq!(low, high, "{x:e} is a decimal with {digits} digits");
        }
        for text in [&low, &high] {
            let mantissa = text.split('e').next().unwrap();
            let count = mantissa
                .trim_start_matches(['-', '0', '.'])
                .replace('.', "");
            let significant = count.trim_end_matches('0').len();
            assert!(
                significant <= digits,
                "{text} has more than {digits} digits"
            );
        }
    }
}

#[test]
fn an_interval_is_inside_its_text() {
    let mut source = Source(45);
    for _ in 0..5_000 {
        let (a, b) = source.floats();
        let x = Interval::point(a).hull(Interval::point(b));
        let shown = format!("{x:.4}");
        let (lo, hi) = shown.trim_matches(['[', ']']).split_once(", ").unwrap();
        assert!(
            Decimal::parse(lo).unwrap().to_rational() <= fraction(x.lo()),
            "{shown}"
        );
        assert!(
            Decimal::parse(hi).unwrap().to_rational() >= fraction(x.hi()),
            "{shown}"
        );
    }
}
