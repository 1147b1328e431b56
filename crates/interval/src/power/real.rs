//! Powers with a real exponent.

use super::power_of_positive;
use crate::Interval;
use crate::elementary::Value;
use crate::interval::{larger, smaller};
use crate::round::{sqrt_down, sqrt_up};

impl Interval {
    /// The powers `x^y = exp(y ln x)` of the elements `x > 0`, and `0^y = 0` for `y > 0` (IEEE 1788
    /// `pow`). Negative `x` have no power here, also for whole `y`; see [`Interval::powi`].
    ///
    /// Ends are at most one float further out than the tight ones, and exact where the power is a
    /// float. Next to an exact power a larger argument may give an end one float further in.
    ///
    /// `y ln x` is linear in `y` and in `ln x`, so its extremes over a box are at corners, chosen as
    /// for a product by the signs of the ends of `y` and of `ln x`. At `x = 0` and at infinite ends
    /// the value is the limit.
    pub fn pow(self, exponent: Interval) -> Interval {
        let x = self.intersect(Interval::NON_NEGATIVE);
        if x.is_empty() || exponent.is_empty() {
            return Interval::EMPTY;
        }
        let ((a, b), (c, d)) = ((x.lo(), x.hi()), (exponent.lo(), exponent.hi()));
        if b == 0.0 {
            return if d > 0.0 {
                Interval::ZERO
            } else {
                Interval::EMPTY
            };
        }
        let (lo, hi) = if a >= 1.0 {
            let least = if c >= 0.0 { a } else { b };
            let most = if d >= 0.0 { b } else { a };
            (power(least, c).lo, power(most, d).hi)
        } else if b <= 1.0 {
            let least = if d >= 0.0 { a } else { b };
            let most = if c >= 0.0 { b } else { a };
            (power(least, d).lo, power(most, c).hi)
        } else if c >= 0.0 {
            (power(a, d).lo, power(b, d).hi)
        } else if d <= 0.0 {
            (power(b, c).lo, power(a, c).hi)
        } else {
            (
                smaller(power(a, d).lo, power(b, c).lo),
                larger(power(a, c).hi, power(b, d).hi),
            )
        };
        Interval::raw(lo, hi)
    }
}

/// `x^y` for `0 <= x <= inf` and any `y`, in the limit at the ends: 1 for `y = 0` or `x = 1`, which are
/// limits from inside the box wherever these are corners.
fn power(x: f64, y: f64) -> Value {
    if y == 0.0 || x == 1.0 {
        return Value::ONE;
    }
    if x == 0.0 || x.is_infinite() || y.is_infinite() {
        return if (x > 1.0) == (y > 0.0) {
            Value::ABOVE
        } else {
            Value::exactly(0.0)
        };
    }
    if let Some((root, whole)) = whole_exponent(x, y) {
        let power = power_of_positive(Interval::point(root), whole);
        return Value {
            lo: power.lo(),
            hi: power.hi(),
        };
    }
    let rounded = core_math::pow(x, y);
    if (x > 1.0) == (y > 0.0) {
        Value::around(rounded, 1.0, f64::INFINITY)
    } else {
        Value::around(rounded, 0.0, 1.0)
    }
}

/// A float `r` and an integer `n` with `x^y = r^n`, where `x^y` may be a float. Required: `x` positive
/// and finite, not 1, `y` finite, not 0.
///
/// `y` is a fraction with a power of two below. While it is not whole, `x = s^2` gives `x^y = s^(2y)`.
/// If `x` is no square of a float, the power is irrational: let `y = k / 2^j` in lowest terms with
/// `j >= 1` and suppose `x^y` is rational. Then `x^k` is the `2^j`-th power of a rational, and since `k` is
/// odd every prime divides `x` a multiple of `2^j` times. So `x` is the square of a rational, whose
/// significand has half as many bits: a float. (An `x` other than 1 is a square only a few times.)
///
/// Whole exponents beyond `i32` leave `None` too: the power of a significand other than a power of two
/// has too many bits for a float, and the power of any float other than 1 is beyond the range of floats.
fn whole_exponent(x: f64, y: f64) -> Option<(f64, i32)> {
    let (mut x, mut y) = (x, y);
    while y.fract() != 0.0 {
        let root = sqrt_down(x);
        if root != sqrt_up(x) {
            return None;
        }
        (x, y) = (root, 2.0 * y);
    }
    (y.abs() <= f64::from(i32::MAX)).then_some((x, y as i32))
}
