//! Reverse operations of periodic functions.

use crate::Interval;

impl Interval {
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
