//! Reverse operations: from the value of an operation back to an argument.
//!
//! In each function `c` encloses the value and `x` the argument that is wanted; further operands come
//! first. *Guarantee*: every element of `x` for which the relation can hold with elements of the
//! other arguments is in the result, and the result is a subset of `x`. An empty result therefore
//! proves that the relation cannot hold. Where the solutions have two pieces, each piece is cut with
//! `x` before the hull is taken.

mod elementary;
mod periodic;
mod power;

use crate::Interval;

impl Interval {
    /// `{x : b + x in c}`.
    #[inline]
    pub fn add_rev(b: Interval, c: Interval, x: Interval) -> Interval {
        x.intersect(c - b)
    }

    /// `{x : x - b in c}`, the minuend of a difference.
    #[inline]
    pub fn sub_rev_left(b: Interval, c: Interval, x: Interval) -> Interval {
        x.intersect(c + b)
    }

    /// `{x : a - x in c}`, the subtrahend of a difference.
    #[inline]
    pub fn sub_rev_right(a: Interval, c: Interval, x: Interval) -> Interval {
        x.intersect(a - c)
    }

    /// `{x : b * x in c}`, for any `b`: if 0 is in both `b` and `c` nothing is learned, if it is in
    /// `b` only, the quotients by the negative and the positive part of `b` are two pieces.
    #[inline]
    pub fn mul_rev(b: Interval, c: Interval, x: Interval) -> Interval {
        let (first, second) = Interval::mul_rev_to_pair(b, c);
        x.intersect(first).hull(x.intersect(second))
    }

    /// The two pieces of `{x : b * x in c}`, from below to above; the second is empty where one
    /// interval holds all.
    pub fn mul_rev_to_pair(b: Interval, c: Interval) -> (Interval, Interval) {
        if b.is_empty() || c.is_empty() {
            return (Interval::EMPTY, Interval::EMPTY);
        }
        if !b.contains(0.0) {
            return (c / b, Interval::EMPTY);
        }
        if c.contains(0.0) {
            return (Interval::ENTIRE, Interval::EMPTY);
        }
        // 0 is in b and not in c: the factor 0 has no solution, each side of it a half line.
        let negative = c / Interval::ordered(b.lo(), 0.0);
        let positive = c / Interval::ordered(0.0, b.hi());
        let (first, second) = if c.lo() > 0.0 {
            (negative, positive)
        } else {
            (positive, negative)
        };
        if first.is_empty() {
            (second, first)
        } else {
            (first, second)
        }
    }

    /// `{x : x / b in c}`, the dividend.
    #[inline]
    pub fn div_rev_left(b: Interval, c: Interval, x: Interval) -> Interval {
        if b == Interval::ZERO {
            Interval::EMPTY
        } else {
            x.intersect(c * b)
        }
    }

    /// `{x : a / x in c}`, the divisor: `a = c x`.
    #[inline]
    pub fn div_rev_right(a: Interval, c: Interval, x: Interval) -> Interval {
        if x == Interval::ZERO {
            Interval::EMPTY
        } else {
            Interval::mul_rev(c, a, x)
        }
    }

    /// `{x : x^2 in c}`.
    #[inline]
    pub fn sqr_rev(c: Interval, x: Interval) -> Interval {
        both_signs(c.sqrt(), x)
    }

    /// `{x : |x| in c}`.
    #[inline]
    pub fn abs_rev(c: Interval, x: Interval) -> Interval {
        both_signs(c.intersect(Interval::NON_NEGATIVE), x)
    }

    /// `{x : 1 / x in c}`.
    #[inline]
    pub fn recip_rev(c: Interval, x: Interval) -> Interval {
        Interval::powi_rev(-1, c, x)
    }

    /// `{x : sqrt(x) in c}`.
    #[inline]
    pub fn sqrt_rev(c: Interval, x: Interval) -> Interval {
        x.intersect(c.intersect(Interval::NON_NEGATIVE).sqr())
    }

    /// `{x : sign(x) meets c}`, with `sign(0) = [-1, 1]`.
    #[inline]
    pub fn sign_rev(c: Interval, x: Interval) -> Interval {
        if !c.intersects(Interval::UNIT) {
            return Interval::EMPTY;
        }
        let lo = if c.contains(-1.0) {
            f64::NEG_INFINITY
        } else {
            0.0
        };
        let hi = if c.contains(1.0) { f64::INFINITY } else { 0.0 };
        x.intersect(Interval::raw(lo, hi))
    }

    /// `{x : min(b, x) in c}`: `x` is never below `c`, and not above it unless `b` can be the minimum.
    #[inline]
    pub fn min_rev(b: Interval, c: Interval, x: Interval) -> Interval {
        if b.is_empty() || c.is_empty() || b.hi() < c.lo() {
            return Interval::EMPTY;
        }
        let hi = if b.lo() > c.hi() {
            c.hi()
        } else {
            f64::INFINITY
        };
        x.intersect(Interval::raw(c.lo(), hi))
    }

    /// `{x : max(b, x) in c}`; mirror image of [`Interval::min_rev`].
    #[inline]
    pub fn max_rev(b: Interval, c: Interval, x: Interval) -> Interval {
        -Interval::min_rev(-b, -c, -x)
    }
}

/// The elements of `x` whose absolute value is in `size`.
#[inline]
fn both_signs(size: Interval, x: Interval) -> Interval {
    x.intersect(size).hull(x.intersect(-size))
}
