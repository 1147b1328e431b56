//! The exponential function on lanes.

use super::super::vector::{Ends, Vector};
use super::tables::{LN_2_OVER_128, POWERS};
use super::wide::{ROUNDER, Sum, Wide, neighbours};

/// `exp x` as `2^e (h + low)`, and `e` in the exponent field, without bias.
///
/// `x = k L + r` with `L = ln 2 / 128`, `k = 128 e + j`, so `exp x = 2^e T exp r` with `T = 2^(j/128)`.
///
/// *Reduction*, for `|x| <= 709`: `|k| < 2^17`, `|r| <= L (1/2 + 2^-34) < 2^-8.52`. `L = L1 + L2`
/// up to `2^-97`, where `L1` is a multiple of `2^-44`. `x - k L1` is a float: for `k = 0` it is
/// `x`; for `|k| = 1` Sterbenz's lemma holds (`|x| >= L1 / 2`, as `k` is right up to a few units of
/// `2^-53`, and `L1` is less than `L` by more); else `|x| >= 2^-7`, and it is a multiple of `2^-59`
/// below `2^-8`. `k L2` is below `2^-27` and rounded with an error below `2^-80`. So `r = rh + rl`
/// up to `2^-79`.
///
/// *Polynomial.* `exp r - 1 = rh + m`, `m = rl + r^2 (1/2 + r/6 + r^2/24 + r^3/120 + r^4/720)` up
/// to the remainder `r^7 / 5040 · 1.01 < 2^-71.9`. Errors of `m`, in units of `2^-70`: `r` is
/// rounded by `2^-62`, times the derivative 0.71; `r^2` by `2^-71`, times 1/2, 0.25; the bracket by
/// `2^-53`, times `r^2`, 1.0; the last sum 0.25; the remainder 0.27. Together less than 2.5.
///
/// *Product* with `T = th + tl`: `h + el = th + th rh` without error (`pl` is the rest of the
/// product). The rest `el + (pl + (th m + (tl + tl rh)))` has three roundings of numbers below
/// `2^-16`, 1.0 each; left out is `tl m`, 0.5. The errors of `m`, times
/// `th < 2`, are 5.0. Together less than 8.5, below `2^-66.9`.
///
/// `h` lies in `[0.99, 2.01]`.
#[inline(always)]
pub(super) fn exp_parts<V: Wide>(x: V) -> (V, V, V) {
    let (l1, l2) = LN_2_OVER_128;
    let rounder = V::splat(ROUNDER);
    let number = x.times_plus(V::splat(128.0 * std::f64::consts::LOG2_E), rounder);
    let k = number.minus(rounder);
    let rh = k.times_from(V::splat(l1), x);
    let rl = k.times(V::splat(-l2));
    let r = rh.plus(rl);

    let bracket = r.times_plus(V::splat(1.0 / 720.0), V::splat(1.0 / 120.0));
    let bracket = r.times_plus(bracket, V::splat(1.0 / 24.0));
    let bracket = r.times_plus(bracket, V::splat(1.0 / 6.0));
    let bracket = r.times_plus(bracket, V::splat(0.5));
    let m = r.times(r).times_plus(bracket, rl);

    let [th, tl] = number.pairs(&POWERS);
    let product = th.times(rh);
    let rest = th.times_minus(rh, product);
    let h = th.plus(product);
    let el = th.minus(h).plus(product);
    let low = el.plus(rest.plus(th.times_plus(m, tl.times_plus(rh, tl))));
    (h, low, number.bits_right::<7>().bits_left::<52>())
}

/// The same sum as a value in `[0.99, 2.01]`, and the exponent.
#[inline(always)]
pub(super) fn exp_sum<V: Wide>(x: V) -> (Sum<V>, V) {
    const ERROR: f64 = f64::from_bits((1023 - 66) << 52);
    let (high, low, exponent) = exp_parts(x);
    let sum = Sum {
        high,
        low,
        error: V::splat(ERROR),
        valid: V::both(x.at_most(V::splat(709.0)), V::splat(-708.0).at_most(x)),
    };
    (sum, exponent)
}

/// The float nearest to `exp x`, and where this is certain. Only the exponent is changed after the
/// rounding, and the result is normal.
#[inline(always)]
fn exp_nearest<V: Wide>(x: V) -> (V, V::Mask) {
    let (sum, exponent) = exp_sum(x);
    let (value, certain) = sum.nearest();
    (value.bits_plus(exponent), certain)
}

/// [`crate::Interval::exp`], and the lanes that are open.
#[inline(always)]
pub(super) fn exponentials<V: Wide>(x: Ends<V>, _: Ends<V>) -> (Ends<V>, u32) {
    let (zero, one) = (V::splat(0.0), V::splat(1.0));
    let (lo, hi) = (x.neg_lo.negated(), x.hi);
    let empty = x.is_empty();

    let (value, certain) = exp_nearest(lo);
    let (below, _) = neighbours(value);
    let least = V::select(lo.at_most(zero), zero, one);
    let below = V::select(lo.equals(zero), one, below.larger(least));
    let unbounded = lo.equals(V::splat(f64::NEG_INFINITY));
    let below = V::select(unbounded, zero, below);
    let lo_certain = V::either(certain, unbounded);

    let (value, certain) = exp_nearest(hi);
    let (_, above) = neighbours(value);
    let most = V::select(hi.at_most(zero), one, V::splat(f64::INFINITY));
    let above = V::select(hi.equals(zero), one, above.smaller(most));
    let unbounded = hi.equals(V::splat(f64::INFINITY));
    let above = V::select(unbounded, hi, above);
    let hi_certain = V::either(certain, unbounded);

    let done = V::either(V::both(lo_certain, hi_certain), empty);
    let all = Ends {
        neg_lo: below.negated(),
        hi: above,
    };
    (all.empty_where(empty), open::<V>(done))
}

/// The lanes where the mask is not set.
#[inline(always)]
pub(in super::super) fn open<V: Vector>(done: V::Mask) -> u32 {
    V::bits(done) ^ ((1 << V::WIDTH) - 1)
}
