//! Logarithms.

use super::Value;
use super::exponential::{exponent_of_ten, exponent_of_two};
use crate::Interval;

#[inline]
fn ln_at(x: f64) -> Value {
    if x == 1.0 {
        Value::ZERO
    } else {
        Value::near(core_math::log(x))
    }
}

/// An integer `k` that was rounded from another value lies on the side of it that `x < 2^k` or `x > 2^k`
/// tells; CORE-MATH gives the power exactly where it is a float, and else 0 or infinity.
#[inline]
fn log2_at(x: f64) -> Value {
    if let Some(k) = exponent_of_two(x) {
        return Value::exactly(k);
    }
    let rounded = core_math::log2(x);
    if rounded.fract() == 0.0 {
        Value::beside(rounded, x > core_math::exp2(rounded))
    } else {
        Value::near(rounded)
    }
}

/// The same to base 10.
#[inline]
fn log10_at(x: f64) -> Value {
    if let Some(k) = exponent_of_ten(x) {
        return Value::exactly(k);
    }
    let rounded = core_math::log10(x);
    if rounded.fract() == 0.0 && (0.0..=22.0).contains(&rounded) {
        Value::beside(rounded, x > core_math::exp10(rounded))
    } else {
        Value::near(rounded)
    }
}

#[inline]
fn log1p_at(x: f64) -> Value {
    if x == 0.0 {
        Value::ZERO
    } else if x > 0.0 {
        // ln(1 + x) < x.
        Value::around(core_math::log1p(x), 0.0, x)
    } else {
        Value::around(core_math::log1p(x), f64::NEG_INFINITY, x)
    }
}

impl Interval {
    /// The natural logarithms of the positive elements. Not a float but for `ln 1 = 0` (Lindemann).
    #[inline]
    pub fn ln(self) -> Interval {
        self.increasing_between_poles(0.0, f64::INFINITY, ln_at)
    }

    /// The logarithms to base 2 of the positive elements: exact at powers of two, elsewhere
    /// irrational.
    #[inline]
    pub fn log2(self) -> Interval {
        self.increasing_between_poles(0.0, f64::INFINITY, log2_at)
    }

    /// The logarithms to base 10 of the positive elements: exact at `10^0 .. 10^22`, the powers of ten
    /// that are floats; elsewhere irrational.
    #[inline]
    pub fn log10(self) -> Interval {
        self.increasing_between_poles(0.0, f64::INFINITY, log10_at)
    }

    /// `ln(1 + x)` of the elements above -1, sharp also near 0. Not a float but for 0 at 0
    /// (Lindemann).
    #[inline]
    pub fn log1p(self) -> Interval {
        self.increasing_between_poles(-1.0, f64::INFINITY, log1p_at)
    }
}
