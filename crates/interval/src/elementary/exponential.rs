//! Exponential functions.

use super::Value;
use crate::Interval;
use crate::decimal::exact_power;

// At infinite ends CORE-MATH gives the limits 0, -1 and infinity. The neighbours and the bounds below
// keep them.

#[inline]
fn exp_at(x: f64) -> Value {
    if x == 0.0 {
        Value::ONE
    } else if x > 0.0 {
        Value::around(core_math::exp(x), 1.0, f64::INFINITY)
    } else {
        Value::around(core_math::exp(x), 0.0, 1.0)
    }
}

/// The float is `2^x` where `x` is an integer and the power is in range. A power of two `2^k` that was
/// rounded from another value lies on the side of it that `x > k` tells.
#[inline]
fn exp2_at(x: f64) -> Value {
    power_at(x, core_math::exp2(x), exponent_of_two)
}

/// A power with the exponent `x` that was rounded to nearest; `exponent` says of which integer a float
/// is the exact power.
#[inline]
fn power_at(x: f64, rounded: f64, exponent: fn(f64) -> Option<f64>) -> Value {
    if rounded == 0.0 {
        Value::beside(0.0, true)
    } else if rounded.is_infinite() {
        Value::ABOVE
    } else if let Some(k) = exponent(rounded) {
        if x == k {
            Value::exactly(rounded)
        } else {
            Value::beside(rounded, x > k)
        }
    } else {
        Value::near(rounded)
    }
}

/// The integer `k` with `x = 2^k`, if there is one. Required: positive and finite.
pub(super) fn exponent_of_two(x: f64) -> Option<f64> {
    let bits = x.to_bits();
    let fraction = bits & ((1 << 52) - 1);
    let k = match bits >> 52 {
        0 if fraction.is_power_of_two() => fraction.trailing_zeros() as i32 - 1074,
        0 => return None,
        biased if fraction == 0 => biased as i32 - 1023,
        _ => return None,
    };
    Some(f64::from(k))
}

/// The integer `k` with `x = 10^k`, if there is one and `x` is a float: `10^k` is one for `0 <= k <= 22`
/// only, since `5^23 > 2^53` and negative powers have no finite binary expansion.
pub(super) fn exponent_of_ten(x: f64) -> Option<f64> {
    if !(1.0..=1e22).contains(&x) || x.fract() != 0.0 {
        return None;
    }
    (0..=22).find(|k| exact_power(*k) == Some(x)).map(f64::from)
}

/// The float is `10^x` for the integers 0 to 22; see [`exponent_of_ten`] and the argument of
/// [`exp2_at`].
#[inline]
fn exp10_at(x: f64) -> Value {
    power_at(x, core_math::exp10(x), exponent_of_ten)
}

#[inline]
fn expm1_at(x: f64) -> Value {
    if x == 0.0 {
        Value::ZERO
    } else if x > 0.0 {
        // exp(x) - 1 > x.
        Value::around(core_math::expm1(x), x, f64::INFINITY)
    } else {
        // x and -1 are below, 0 is above.
        Value::around(core_math::expm1(x), x.max(-1.0), 0.0)
    }
}

impl Interval {
    /// The exponentials of the elements. Not a float but for `exp 0 = 1` (Lindemann).
    #[inline]
    pub fn exp(self) -> Interval {
        self.increasing(Interval::ENTIRE, exp_at)
    }

    /// The powers `2^x` of the elements. At integers in range they are floats and exact, elsewhere
    /// irrational.
    #[inline]
    pub fn exp2(self) -> Interval {
        self.increasing(Interval::ENTIRE, exp2_at)
    }

    /// The powers `10^x` of the elements. At the integers 0 to 22 they are floats and exact.
    #[inline]
    pub fn exp10(self) -> Interval {
        self.increasing(Interval::ENTIRE, exp10_at)
    }

    /// `exp(x) - 1` of the elements, sharp also near 0. Not a float but for 0 at 0 (Lindemann).
    #[inline]
    pub fn expm1(self) -> Interval {
        self.increasing(Interval::ENTIRE, expm1_at)
    }
}
