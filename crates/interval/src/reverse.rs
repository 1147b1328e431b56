//! Reverse operations: from the value of an operation back to an argument.
//!
//! In each function `c` encloses the value and `x` the argument that is wanted; further operands come
//! first. *Guarantee*: every element of `x` for which the relation can hold with elements of the
//! other arguments is in the result, and the result is a subset of `x`. An empty result therefore
//! proves that the relation cannot hold. Where the solutions have two pieces, each piece is cut with
//! `x` before the hull is taken.

use crate::Interval;
use crate::power::{root_down, root_up};

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
        let (first, second) = Interval::mul_rev_pair(b, c);
        x.intersect(first).hull(x.intersect(second))
    }

    /// The two pieces of `{x : b * x in c}`, from below to above; the second is empty where one
    /// interval holds all.
    pub fn mul_rev_pair(b: Interval, c: Interval) -> (Interval, Interval) {
        if b.is_empty() || c.is_empty() {
            return (Interval::EMPTY, Interval::EMPTY);
        }
        if b.recip_defined() {
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

    /// `{x : x^n in c}`; for negative `n` the number 0 is no solution.
    pub fn powi_rev(n: i32, c: Interval, x: Interval) -> Interval {
        if n == 0 {
            return if c.contains(1.0) { x } else { Interval::EMPTY };
        }
        let roots = |c: Interval| {
            let (c, n) = (c.intersect(Interval::NON_NEGATIVE), n.unsigned_abs());
            if c.is_empty() || n == 1 {
                c
            } else {
                Interval::raw(root_down(c.lo(), n), root_up(c.hi(), n))
            }
        };
        // Solutions below and above 0.
        let above = roots(c);
        let below = if n & 1 == 0 { -above } else { -roots(-c) };
        let (below, above) = if n < 0 {
            (below.recip(), above.recip())
        } else {
            (below, above)
        };
        x.intersect(below).hull(x.intersect(above))
    }

    /// `{x : |x| in c}`.
    #[inline]
    pub fn abs_rev(c: Interval, x: Interval) -> Interval {
        both_signs(c.intersect(Interval::NON_NEGATIVE), x)
    }

    /// `{x : sqrt(x) in c}`.
    #[inline]
    pub fn sqrt_rev(c: Interval, x: Interval) -> Interval {
        x.intersect(c.intersect(Interval::NON_NEGATIVE).sqr())
    }

    /// `{x : exp(x) in c}`.
    #[inline]
    pub fn exp_rev(c: Interval, x: Interval) -> Interval {
        x.intersect(c.ln())
    }

    /// `{x : ln(x) in c}`.
    #[inline]
    pub fn ln_rev(c: Interval, x: Interval) -> Interval {
        x.intersect(c.exp())
    }

    /// `{x : tanh(x) in c}`.
    #[inline]
    pub fn tanh_rev(c: Interval, x: Interval) -> Interval {
        x.intersect(c.atanh())
    }

    /// `{x : atan(x) in c}`: the tangents of `c` inside `(-π/2, π/2)`.
    pub fn atan_rev(c: Interval, x: Interval) -> Interval {
        // The float below π/2 is the last one where the tangent is on the branch of the arc tangent.
        let last = std::f64::consts::FRAC_PI_2;
        if c.is_empty() || c.lo() > last || c.hi() < -last {
            return Interval::EMPTY;
        }
        let lo = if c.lo() < -last {
            f64::NEG_INFINITY
        } else {
            Interval::point(c.lo()).tan().lo()
        };
        let hi = if c.hi() > last {
            f64::INFINITY
        } else {
            Interval::point(c.hi()).tan().hi()
        };
        x.intersect(Interval::ordered(lo, hi))
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

    /// `{x : sin(x) in c}`.
    ///
    /// On the branch `[kπ - π/2, kπ + π/2]` the solutions are `kπ + (-1)^k asin(c)`. An unbounded or
    /// very large end of `x` stays as it is.
    pub fn sin_rev(c: Interval, x: Interval) -> Interval {
        let principal = c.asin();
        branches(principal, x, 0.0, |k| {
            half_turns(k) + if k & 1 == 0 { principal } else { -principal }
        })
    }

    /// `{x : cos(x) in c}`: on `[kπ, (k + 1)π]` the solutions are `kπ + acos(c)` for even `k` and
    /// `(k + 1)π - acos(c)` for odd `k`.
    pub fn cos_rev(c: Interval, x: Interval) -> Interval {
        let principal = c.acos();
        branches(principal, x, 0.5, |k| {
            if k & 1 == 0 {
                half_turns(k) + principal
            } else {
                half_turns(k + 1) - principal
            }
        })
    }

    /// `{x : tan(x) in c}`: on `(kπ - π/2, kπ + π/2)` the solutions are `kπ + atan(c)`.
    pub fn tan_rev(c: Interval, x: Interval) -> Interval {
        let principal = c.atan();
        branches(principal, x, 0.0, |k| half_turns(k) + principal)
    }
}

/// The elements of `x` whose absolute value is in `size`.
#[inline]
fn both_signs(size: Interval, x: Interval) -> Interval {
    x.intersect(size).hull(x.intersect(-size))
}

/// `kπ`; the branch numbers are far below 2^53.
fn half_turns(k: i64) -> Interval {
    Interval::PI * Interval::point(k as f64)
}

/// The hull of `x` with the pieces of all branches `k` of a periodic function.
///
/// Branch `k` covers `[(k - 1/2 + shift) π, (k + 1/2 + shift) π]`, the branches together cover the
/// line, and `piece(k)` encloses all solutions on branch `k`. The lower end of the result is that
/// of the first piece that meets `x`, counted from one branch before the one that holds `x.lo`; the
/// rounding error of the branch number is far below 1 for the magnitudes allowed. If no piece between
/// the two ends meets `x`, there is no solution. The third branch from the end lies inside `x`, if `x`
/// reaches beyond it, and has a piece, so the search is short.
fn branches(
    principal: Interval,
    x: Interval,
    shift: f64,
    piece: impl Fn(i64) -> Interval,
) -> Interval {
    const LARGEST: f64 = 1e12;
    if principal.is_empty() || x.is_empty() {
        return Interval::EMPTY;
    }
    let number = |end: f64| (end / std::f64::consts::PI - shift).round() as i64;
    let cut = |k: i64| x.intersect(piece(k));
    let low_known = x.lo().abs() <= LARGEST;
    let high_known = x.hi().abs() <= LARGEST;
    let lo = if low_known {
        let first = number(x.lo()) - 1;
        let last = if high_known {
            number(x.hi()) + 1
        } else {
            first + 4
        };
        match (first..=last).map(cut).find(|piece| !piece.is_empty()) {
            Some(piece) => piece.lo(),
            None => return Interval::EMPTY,
        }
    } else {
        x.lo()
    };
    let hi = if high_known {
        let last = number(x.hi()) + 1;
        let first = if low_known {
            number(x.lo()) - 1
        } else {
            last - 4
        };
        match (first..=last)
            .rev()
            .map(cut)
            .find(|piece| !piece.is_empty())
        {
            Some(piece) => piece.hi(),
            None => return Interval::EMPTY,
        }
    } else {
        x.hi()
    };
    Interval::ordered(lo, hi)
}
