//! Integer powers on lanes, in twice the precision of floats.

use super::Interval8;
use super::basic::magnitudes;
use super::elementary::{Wide, open};
use super::vector::Ends;

/// The largest exponent for which the error is small enough.
pub(super) const MOST: u32 = 64;

/// Numbers `(high + low) (1 + θ)`, where `lost` is 0 if nothing was rounded.
#[derive(Clone, Copy)]
struct Near<V> {
    high: V,
    low: V,
    lost: V,
}

impl<V: Wide> Near<V> {
    /// The product with a relative error below `9 · 2^-106`.
    ///
    /// Proof, with `u = 2^-53` and sizes relative to the product: `p + e` is the product of the
    /// high parts. Dropped is `low low` (`u^2`). Rounded are the mixed products (`u^2` and `2 u^2`)
    /// and their sum with `e` (`3 u^2`), which is below `4 u`, so that the last sum is exact
    /// (Fast2Sum). Where a product is below the smallest float, that is at most `2^-175` of the
    /// whole for the numbers of [`end`].
    #[inline(always)]
    fn times(self, other: Near<V>) -> Near<V> {
        let p = self.high.times(other.high);
        let e = self.high.times_minus(other.high, p);
        let mixed = self.high.times_plus(other.low, self.low.times(other.high));
        let rest = e.plus(mixed);
        let high = p.plus(rest);
        Near {
            high,
            low: rest.minus(high.minus(p)),
            lost: self.lost.plus(other.lost).plus(e.abs()),
        }
    }
}

/// `x^n` for `2 <= n <= 64`. The factors on the way lie between 1 and the power, and the errors of
/// at most 63 factors add up: `|θ| < 2^-96.8`.
#[inline(always)]
fn power<V: Wide>(x: V, n: u32) -> Near<V> {
    let zero = V::splat(0.0);
    let mut square = Near {
        high: x,
        low: zero,
        lost: zero,
    };
    let mut rest = n;
    while rest & 1 == 0 {
        square = square.times(square);
        rest >>= 1;
    }
    let mut product = square;
    while rest > 1 {
        rest >>= 1;
        square = square.times(square);
        if rest & 1 == 1 {
            product = product.times(square);
        }
    }
    product
}

/// The smallest float not below the `n`-th power of `x`, or its negative, and where this is certain.
///
/// `high` is the float nearest to `high + low`. The true power lies above it if
/// `low > 2^-95 |high|`, below it if `low < -2^-95 |high|`, and is `high` if nothing was rounded.
/// Zero and infinity are their own powers.
#[inline(always)]
fn end<V: Wide>(x: V, n: u32, negated: bool) -> (V, V::Mask) {
    const CERTAIN: f64 = f64::from_bits((1023 - 95) << 52);
    const LEAST: f64 = f64::from_bits((1023 - 900) << 52);
    const LARGEST: f64 = f64::from_bits((1023 + 900) << 52);
    let mut near = power(x, n);
    if negated {
        near.high = near.high.negated();
        near.low = near.low.negated();
    }
    let (zero, infinity) = (V::splat(0.0), V::splat(f64::INFINITY));
    let size = near.high.abs();
    let clear = near.low.abs().above(size.times(V::splat(CERTAIN)));
    let exact = near.lost.equals(zero);
    let ordinary = V::both(
        V::splat(LEAST).at_most(size),
        size.at_most(V::splat(LARGEST)),
    );
    let value = near.high.raised_where(near.low.above(zero));
    let limit = V::either(x.equals(zero), x.equals(infinity));
    let certain = V::either(V::both(ordinary, V::either(clear, exact)), limit);
    (V::select(limit, x, value), certain)
}

/// Odd powers are increasing, and `(-x)^n = -x^n`.
#[inline(always)]
fn odd<V: Wide>(x: Ends<V>, n: u32) -> (Ends<V>, u32) {
    let (neg_lo, lower) = end(x.neg_lo, n, false);
    let (hi, upper) = end(x.hi, n, false);
    let empty = x.is_empty();
    let done = V::either(V::both(lower, upper), empty);
    (Ends { neg_lo, hi }.empty_where(empty), open::<V>(done))
}

/// Even powers are those of the absolute values.
#[inline(always)]
fn even<V: Wide>(x: Ends<V>, n: u32) -> (Ends<V>, u32) {
    let (near, far) = magnitudes(x);
    let (neg_lo, lower) = end(near, n, true);
    let (hi, upper) = end(far, n, false);
    let empty = x.is_empty();
    let done = V::either(V::both(lower, upper), empty);
    (Ends { neg_lo, hi }.empty_where(empty), open::<V>(done))
}

/// [`crate::Interval::powi`] for `2 <= n <= 64`.
#[inline(always)]
pub(super) fn powi<V: Wide>(a: &Interval8, n: u32) -> Interval8 {
    let (mut all, mut rest) = (Interval8::EMPTY, 0);
    for i in 0..super::LANES / V::WIDTH {
        let x = Ends::<V>::load(a, i);
        let (ends, open) = if n & 1 == 1 { odd(x, n) } else { even(x, n) };
        ends.store(&mut all, i);
        rest |= open << (i * V::WIDTH);
    }
    if rest != 0 {
        let (a, fast) = (*a, all);
        all = one_by_one(&a, &fast, rest, n);
    }
    all
}

#[cold]
#[inline(never)]
fn one_by_one(a: &Interval8, fast: &Interval8, lanes: u32, n: u32) -> Interval8 {
    let mut all = *fast;
    for lane in 0..super::LANES {
        if lanes >> lane & 1 == 1 {
            all.set(lane, a.get(lane).powi(n as i32));
        }
    }
    all
}
