//! How regular an operation is on the whole of its arguments (the idea of IEEE 1788 decorations).
//!
//! Interval evaluation leaves out elements at which an operation is undefined: `sqrt([-1, 1])` is
//! `[0, 1]`. Existence theorems (Picard, Brouwer) need a function that is defined and continuous on the
//! whole set, Taylor expansions one that is smooth, so a caller that relies on them asks here. The
//! regularity of an expression on a box is the minimum over its operations, each asked with the ranges of
//! its operands.
//!
//! *Guarantee*: the answer is never better than the truth. What is judged is the operation restricted
//! to the box of its arguments: `abs` is smooth on `[0, 1]`, `floor` on `[1, 1.5]`. Empty arguments are
//! [`Regularity::Undefined`]: nothing is claimed about an operation that was never evaluated. The
//! answers are exact, but where a function's own sentence says otherwise.
//!
//! | 1788 decoration | `com`, `dac` | `def` | `trv` |
//! |---|---|---|---|
//! | here | `Smooth` or `Kink` | `Jump` | `Undefined` |

use crate::Interval;

/// How regular an operation or an expression is on a whole box; later is better.
///
/// ```
/// use veribound_interval::{Interval, Regularity, domain};
///
/// let x = Interval::new(-1.0, 4.0).unwrap();
/// assert_eq!(domain::sqrt(x), Regularity::Undefined);
/// assert!(domain::everywhere([x]) > domain::abs(x) && domain::abs(x) == Regularity::Kink);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Regularity {
    /// Not defined somewhere on the box: a division by zero, the root of a negative number.
    Undefined,
    /// Defined, but may jump.
    Jump,
    /// Continuous, but may have a kink or an infinite slope.
    Kink,
    /// Infinitely often differentiable.
    Smooth,
}

use Regularity::{Jump, Kink, Smooth, Undefined};

/// `worse` if the claim holds and `Smooth` if not; undefined for empty arguments.
#[inline]
fn unless(claim: bool, worse: Regularity, x: Interval) -> Regularity {
    if x.is_empty() {
        Undefined
    } else if claim {
        worse
    } else {
        Smooth
    }
}

/// Operations that are smooth for all real numbers: `+ - *`, `neg`, `fma`, `sqr`, `exp`, `exp2`, `exp10`,
/// `expm1`, `sin`, `cos`, `atan`, `sinh`, `cosh`, `tanh`, `asinh`.
#[inline]
pub fn everywhere<const N: usize>(arguments: [Interval; N]) -> Regularity {
    if arguments.iter().any(|x| x.is_empty()) {
        Undefined
    } else {
        Smooth
    }
}

/// [`Interval::recip`]: undefined at 0.
#[inline]
pub fn recip(x: Interval) -> Regularity {
    unless(x.contains(0.0), Undefined, x)
}

/// Division `x / y`: undefined for `y = 0`.
#[inline]
pub fn div(x: Interval, y: Interval) -> Regularity {
    everywhere([x]).min(recip(y))
}

/// [`Interval::sqrt`]: undefined below 0, an infinite slope at 0.
#[inline]
pub fn sqrt(x: Interval) -> Regularity {
    from(x, 0.0)
}

/// A function that is defined from `least` on, with an infinite slope there.
#[inline]
fn from(x: Interval, least: f64) -> Regularity {
    if x.lo() < least {
        Undefined
    } else {
        unless(x.lo() == least, Kink, x)
    }
}

/// [`Interval::ln`], [`Interval::log2`], [`Interval::log10`]: undefined at and below 0.
#[inline]
pub fn ln(x: Interval) -> Regularity {
    unless(x.lo() <= 0.0, Undefined, x)
}

/// [`Interval::log1p`]: undefined at and below -1.
#[inline]
pub fn log1p(x: Interval) -> Regularity {
    unless(x.lo() <= -1.0, Undefined, x)
}

/// [`Interval::powi`]: undefined at 0 for negative `n`.
#[inline]
pub fn powi(x: Interval, n: i32) -> Regularity {
    unless(n < 0 && x.contains(0.0), Undefined, x)
}

/// [`Interval::rootn`]: an infinite slope at 0, or undefined there for negative `n`; for even `n`
/// undefined below 0, for `n = 0` everywhere.
#[inline]
pub fn rootn(x: Interval, n: i32) -> Regularity {
    if n == 0 || (n & 1 == 0 && x.lo() < 0.0) {
        return Undefined;
    }
    match n {
        1 => everywhere([x]),
        _ if n < 0 => recip(x),
        _ => unless(x.contains(0.0), Kink, x),
    }
}

/// [`Interval::pow`]: undefined for negative bases, and for the base 0 with an exponent that is not
/// positive. With a base 0 `Kink` is answered also where all powers are smooth (exponent 2, say).
#[inline]
pub fn pow(x: Interval, y: Interval) -> Regularity {
    if x.lo() < 0.0 || (x.lo() == 0.0 && y.lo() <= 0.0) {
        return Undefined;
    }
    everywhere([y]).min(unless(x.lo() == 0.0, Kink, x))
}

/// [`Interval::abs`]: a kink at 0, if 0 is inside.
#[inline]
pub fn abs(x: Interval) -> Regularity {
    unless(x.lo() < 0.0 && x.hi() > 0.0, Kink, x)
}

/// [`Interval::min`] and [`Interval::max`]: a kink where the arguments are equal, unless one is never
/// above the other.
#[inline]
pub fn min(x: Interval, y: Interval) -> Regularity {
    everywhere([y]).min(unless(x.lo() < y.hi() && y.lo() < x.hi(), Kink, x))
}

/// See [`min`].
#[inline]
pub fn max(x: Interval, y: Interval) -> Regularity {
    min(x, y)
}

/// [`Interval::sign`], set-valued at 0: a jump if 0 is an element.
#[inline]
pub fn sign(x: Interval) -> Regularity {
    unless(x.contains(0.0), Jump, x)
}

/// [`Interval::sign_with_zero`]: a jump if 0 is an element and not the only one.
#[inline]
pub fn sign_with_zero(x: Interval) -> Regularity {
    constant(x, x.sign_with_zero())
}

/// [`Interval::floor`]: constant, or with a jump.
#[inline]
pub fn floor(x: Interval) -> Regularity {
    constant(x, x.floor())
}

/// [`Interval::ceil`]: constant, or with a jump.
#[inline]
pub fn ceil(x: Interval) -> Regularity {
    constant(x, x.ceil())
}

/// [`Interval::trunc`]: constant, or with a jump.
#[inline]
pub fn trunc(x: Interval) -> Regularity {
    constant(x, x.trunc())
}

/// [`Interval::round_ties_to_even`]: constant, or with a jump.
#[inline]
pub fn round_ties_to_even(x: Interval) -> Regularity {
    constant(x, x.round_ties_to_even())
}

/// [`Interval::round_ties_to_away`]: constant, or with a jump.
#[inline]
pub fn round_ties_to_away(x: Interval) -> Regularity {
    constant(x, x.round_ties_to_away())
}

/// Step functions do not decrease: one value, or a jump between two.
#[inline]
fn constant(x: Interval, values: Interval) -> Regularity {
    unless(!values.is_point(), Jump, x)
}

/// [`Interval::tan`]: undefined at its poles; on sets wider than 2π that is certain.
#[inline]
pub fn tan(x: Interval) -> Regularity {
    unless(x.has_pole_of_tan(), Undefined, x)
}

/// [`Interval::asin`] and [`Interval::acos`]: undefined outside of `[-1, 1]`, infinite slopes at ±1.
#[inline]
pub fn asin(x: Interval) -> Regularity {
    from(x, -1.0).min(from(-x, -1.0))
}

/// See [`asin`].
#[inline]
pub fn acos(x: Interval) -> Regularity {
    asin(x)
}

/// [`Interval::acosh`]: undefined below 1, an infinite slope at 1.
#[inline]
pub fn acosh(x: Interval) -> Regularity {
    from(x, 1.0)
}

/// [`Interval::atanh`]: undefined outside of `(-1, 1)`.
#[inline]
pub fn atanh(x: Interval) -> Regularity {
    unless(x.lo() <= -1.0 || x.hi() >= 1.0, Undefined, x)
}

/// [`Interval::atan2`] of `y` and `x`: undefined at the origin. A jump between `-π` and π if the set has
/// points with `x < 0` on the axis `y = 0` and below it.
#[inline]
pub fn atan2(y: Interval, x: Interval) -> Regularity {
    if y.contains(0.0) && x.contains(0.0) {
        return Undefined;
    }
    let crossed = x.lo() < 0.0 && y.lo() < 0.0 && y.hi() >= 0.0;
    everywhere([y]).min(unless(crossed, Jump, x))
}
