//! Where operations are said to be defined, continuous and differentiable.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use veribound_interval::Interval;

/// A claim about an interval.
type Claim = fn(Interval) -> bool;

/// Sets on which zero is outside, at an end, inside, alone; and the empty set, of which all claims
/// are false.
const SETS: [(f64, f64); 9] = [
    (1.0, 2.0),
    (-2.0, -1.0),
    (0.0, 1.0),
    (-1.0, 0.0),
    (-1.0, 1.0),
    (0.0, 0.0),
    (5e-324, f64::INFINITY),
    (f64::NEG_INFINITY, -5e-324),
    (f64::NEG_INFINITY, f64::INFINITY),
];

/// For each of [`SETS`] in order whether the claim holds.
fn assert_table(name: &str, claim: Claim, expected: [bool; 9]) {
    for ((lo, hi), expected) in SETS.into_iter().zip(expected) {
        let found = claim(Interval::new(lo, hi).unwrap());
        assert_eq!(found, expected, "{name} on [{lo}, {hi}]");
    }
    assert!(!claim(Interval::EMPTY), "{name} on the empty set");
}

#[test]
fn claims_hold_exactly_where_they_are_true() {
    let (yes, no) = (true, false);
    let positive = [yes, no, no, no, no, no, yes, no, no];
    let not_negative = [yes, no, yes, no, no, yes, yes, no, no];
    let without_zero = [yes, yes, no, no, no, no, yes, yes, no];
    assert_table("sqrt_defined", Interval::sqrt_defined, not_negative);
    assert_table("sqrt_smooth", Interval::sqrt_smooth, positive);
    assert_table("ln_defined", Interval::ln_defined, positive);
    assert_table("recip_defined", Interval::recip_defined, without_zero);
    assert_table("sign_continuous", Interval::sign_continuous, without_zero);
    assert_table("abs_smooth", Interval::abs_smooth, without_zero);
    assert_table("powi_defined(3)", |x| x.powi_defined(3), [yes; 9]);
    assert_table("powi_defined(0)", |x| x.powi_defined(0), [yes; 9]);
    assert_table("powi_defined(-1)", |x| x.powi_defined(-1), without_zero);
    assert_table("powi_defined(-2)", |x| x.powi_defined(-2), without_zero);
    // Half lines and [1, 2] hold a pole of the tangent.
    let no_pole = [no, no, yes, yes, yes, yes, no, no, no];
    assert_table("tan_continuous", Interval::tan_continuous, no_pole);
}
