//! The tight directed operations on ordinary operands: of one float, or of both ends of an interval.
//!
//! Each function returns the tight upper bound and whether it holds: where a number is too small, too
//! large or not finite, the caller takes the exact way. Lower bounds are upper bounds of the negated
//! operation, since rounding to nearest is symmetric.
//!
//! Eight intervals ([`crate::lanes`]) have code of their own: a caller there needs an answer for each
//! lane, not one for all.

use super::elementwise::Elementwise;

/// `2^-960`: from here on the step of [`raised`] is one float.
pub(crate) const SMALL: f64 = f64::from_bits((1023 - 960) << 52);
/// `2^-53 (1 + 2^-52)`: this part of a float is between a half and a whole of the distance to the next.
pub(crate) const STEP: f64 = f64::from_bits(((1023 - 53) << 52) + 1);
/// `2^-480` and `2^480`: products, quotients and roots of numbers between them, and all parts of their
/// error-free transforms, neither overflow nor lose bits below the smallest float; the results are at
/// least `2^-960`.
pub(crate) const LEAST: f64 = f64::from_bits((1023 - 480) << 52);
pub(crate) const MOST: f64 = f64::from_bits((1023 + 480) << 52);

/// The next float above `s` where the mask is set, `s` elsewhere. Required: `|s| >= 2^-960` there.
///
/// Proof. Let `2^k <= |s| < 2^(k+1)`, `u = 2^(k-52)` the distance of the floats in that range, and
/// `w` the rounded product of `|s|` and `φ = 2^-53 (1 + 2^-52)`. Rounding is monotone, and both
/// `φ 2^k` and `φ 2^(k+1)` are floats, so `u/2 < w <= u (1 + 2^-52)`. For `s > 0` the sum `s + w` is
/// nearer to `s + u` than to any other float. For `s < 0` and `|s| >= 2^k + u` the same holds for
/// `|s| - u`: `w` exceeds `u` by less than half the distance of the floats, and for `|s| = 2^k + u`
/// it is only `u/2` and a little. For `|s| = 2^k` the floats below are `u/2` apart and
/// `w = u/2 (1 + 2^-52)`. Beyond the largest float the sum rounds to infinity, as it shall.
#[inline(always)]
fn raised<L: Elementwise>(s: L, mask: L::Mask) -> L {
    s.plus(s.abs().times(L::splat(STEP)).kept(mask))
}

/// `(a + b) - s` for `s` the sum rounded to nearest (Knuth's TwoSum).
///
/// Proof. A sum of two floats that is below the normal range is exact, so only overflow can spoil the
/// transform. An infinity in an intermediate gives NaN or an infinity at the end, so a finite result
/// is the exact error by Knuth's theorem.
#[inline(always)]
pub(super) fn sum_error<L: Elementwise>(a: L, b: L, s: L) -> L {
    let from_b = s.minus(a);
    a.minus(s.minus(from_b)).plus(b.minus(from_b))
}

/// Smallest float not below `a + b`.
///
/// Proof. With the exact error `e`: if `e > 0` the true sum lies strictly between `s` and the float
/// above, because `s` is the nearest float; otherwise `s` is not below it. Accepted are finite
/// errors (an error of a finite sum is at most 2^970), and large sums or exact ones, for which
/// [`raised`] is not asked to step.
#[inline(always)]
pub(crate) fn sum_up<L: Elementwise>(a: L, b: L) -> (L, bool) {
    let s = a.plus(b);
    let e = sum_error(a, b, s);
    let finite = L::splat(f64::MAX).above(e.abs());
    let large = L::either(s.abs().above(L::splat(SMALL)), e.equals(L::splat(0.0)));
    (
        raised(s, e.above(L::splat(0.0))),
        L::all(L::both(finite, large)),
    )
}

/// Smallest float not below `a * b`.
///
/// Proof. The residual `r = a b - p` is exact for the accepted factors
/// ([`Elementwise::product_error`]: the true product differs from `p` by a factor below 2), and its sign
/// tells on which side of `p` the true product lies, within one float since `p` is nearest.
#[inline(always)]
pub(crate) fn product_up<L: Elementwise>(a: L, b: L) -> (L, bool) {
    let p = a.times(b);
    let r = L::product_error(a, b, p);
    let (size_a, size_b, zero) = (a.abs(), b.abs(), L::splat(0.0));
    let no_overflow = L::both(L::splat(MOST).above(size_a), L::splat(MOST).above(size_b));
    let no_underflow = L::either(
        p.abs().above(L::splat(SMALL)),
        L::either(size_a.equals(zero), size_b.equals(zero)),
    );
    (
        raised(p, r.above(zero)),
        L::all(L::both(no_overflow, no_underflow)),
    )
}

/// `a - q b` without error, for `q` the quotient `a / b` (or the root of `a`, with `b = q`) rounded to
/// nearest, and operands between `2^-480` and `2^480`, or `a = 0`.
///
/// Proof. Let `p` be the nearest float to `q b`; `e = q b - p` is exact. `q b = a (1 + d)` with
/// `|d| < 2^-51`, so `a - p` is exact (Sterbenz). `a`, `q b` and so `r = a - q b` are multiples of
/// `v = ulp(q) ulp(b)`. For the quotient `|r| <= |b| ulp(q) / 2 < 2^52 v`; for the root
/// `|r| = |sqrt(a) - q| (sqrt(a) + q) <= q ulp(q) + ulp(q)^2 / 4`, hence at most `2^53 v`. So `r` is a
/// float, and `(a - p) - e` gives it without error. `|q| < 2^961` splits without overflow, and
/// `|q b| > 2^-481`.
#[inline(always)]
fn remainder<L: Elementwise>(a: L, b: L, q: L) -> L {
    let p = q.times(b);
    a.minus(p).minus(L::product_error(q, b, p))
}

/// Smallest float not below `a / b`.
///
/// Proof. `a / b - q = r / b` with the exact remainder `r`, a number of the sign of `r b`. That
/// product does not vanish by underflow: `|r| >= ulp(q) ulp(b) > 2^-588` and `|b| >= 2^-480`.
#[inline(always)]
pub(crate) fn quotient_up<L: Elementwise>(a: L, b: L) -> (L, bool) {
    let q = a.over(b);
    let r = remainder(a, b, q);
    let (size_a, size_b, zero) = (a.abs(), b.abs(), L::splat(0.0));
    let (least, most) = (L::splat(LEAST), L::splat(MOST));
    let divisor = L::both(size_b.above(least), most.above(size_b));
    let dividend = L::both(
        L::either(size_a.above(least), size_a.equals(zero)),
        most.above(size_a),
    );
    (
        raised(q, r.times(b).above(zero)),
        L::all(L::both(divisor, dividend)),
    )
}

/// Largest float not above, and smallest float not below, the square root of `a`.
///
/// Proof. The sign of the exact remainder `a - s^2` is the sign of `sqrt(a) - s`.
#[inline(always)]
pub(crate) fn root_bounds<L: Elementwise>(a: L) -> (L, L, bool) {
    let s = a.root();
    let r = remainder(a, s, s);
    let zero = L::splat(0.0);
    let ordinary = L::both(a.above(L::splat(LEAST)), L::splat(MOST).above(a));
    let down = raised(s.negated(), zero.above(r)).negated();
    (down, raised(s, r.above(zero)), L::all(ordinary))
}
