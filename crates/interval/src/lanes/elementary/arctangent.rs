//! The arc tangent on lanes, and what it shares with the hyperbolic tangent.

use super::super::vector::Ends;
use super::exponential::open;
use super::tables::{Fixed, POINT, pair, times};
use super::wide::{ROUNDER, Sum, Wide, neighbours};

/// Added to the number of an argument above 1.
const INVERSE: u64 = 128;

/// `π / 2` in units of `2^-126`.
const QUARTER: Fixed = 0x6487_ed51_10b4_611a_6263_3145_c06e_0e69;

/// `atan(j / 64)`, and from number 128 on `π/2 - atan(j / 64)`, for `j <= 64`.
static ANGLES: [[f64; 2]; 256] = {
    let (mut table, mut angle, mut j) = ([[0.0; 2]; 256], 0, 0);
    while j <= 64 {
        table[j] = pair(angle);
        table[INVERSE as usize + j] = pair(QUARTER - angle);
        angle += angle_of_ratio(64, 4096 + (j * (j + 1)) as u128);
        j += 1;
    }
    table
};

/// `atan(n / d)` for `n / d <= 1 / 64`, by the series; the difference of `atan((j + 1) / 64)` and
/// `atan(j / 64)` is such an angle.
const fn angle_of_ratio(n: u128, d: u128) -> Fixed {
    let z = ((n << (POINT - 7)) / d) << 7;
    let square = times(z, z);
    let (mut power, mut sum, mut k) = (z, z, 1);
    while power > 0 {
        power = times(power, square);
        k += 2;
        sum = if k & 2 == 2 {
            sum - power / k
        } else {
            sum + power / k
        };
    }
    sum
}

/// `atan |x|` as a sum of two floats.
///
/// For `a = |x| <= 1` let `c = j / 64` be next to `a`, and for `a > 1` next to `1 / a`. Then
/// `atan a` is `B + atan t` with `B = atan c`, `t = (a - c) / (1 + a c)`, or `B = π/2 - atan c`,
/// `t = (a c - 1) / (a + c)`; in both cases `|t| < 2^-6.99`. Beyond `2^200` all values round to the
/// same float as there.
///
/// *Quotient* of sums of two floats `n + nl` and `d + dl`: `a - c` is exact (`c = 0` or Sterbenz),
/// and so is `n + nl = a c - 1` (the rounded product lies between 0.6 and 2, or `c = 0`); `d + dl`
/// is exact up to `2^-106`. With `q` the rounded `n / d` and its exact remainder `r`, `t = q + tl`
/// up to `2^-105`, `tl = (r + (nl - q dl)) / d`, and `|tl| < 2^-52.9`, or `2^-59` for `a <= 1`.
///
/// *Sum.* `atan t = q + tl + ps`, `ps = q^3 (-1/3 + q^2/5 - q^4/7 + q^6/9)`, up to the remainder
/// `2^-80` and `q^2 tl`, below `2^-66.8`, or `2^-72.9` for `a <= 1`. `h + el = B + q` without
/// error, as `B = 0` or `B > 1.9 |q|`. `ps` is below `2^-22.5` and errs by `4 · 2^-53` of it; its
/// sums with `tl`, the second part of `B` and `el` err by `2^-53` of it each. Together below
/// `2^-72.4` for `a <= 1`, and the value is more than `2^-7.01` for `c != 0`: relative, below
/// `2^-65.3`. For `c = 0` the value is about `q = a`, and all that errs is `ps`: relative, below
/// `2^-66`. For `a > 1` the value is more than 0.78, and the error below `2^-66.7`: relative, below
/// `2^-66.3`.
#[inline(always)]
pub(super) fn atan_sum<V: Wide>(x: V) -> Sum<V> {
    const ERROR: f64 = f64::from_bits((1023 - 65) << 52);
    const LARGEST: f64 = f64::from_bits((1023 + 200) << 52);
    let (zero, one) = (V::splat(0.0), V::splat(1.0));
    let a = x.abs().smaller(V::splat(LARGEST));
    let inverse = a.above(one);
    let argument = V::select(inverse, one.over(a), a);
    let rounder = V::splat(ROUNDER);
    let number = argument.times_plus(V::splat(64.0), rounder);
    let c = number.minus(rounder).times(V::splat(1.0 / 64.0));
    let place = number.bits_or(V::select(inverse, V::of_bits(INVERSE), zero));

    let product = c.times(a);
    let product_rest = c.times_minus(a, product);
    let n = V::select(inverse, product.minus(one), a.minus(c));
    let nl = V::select(inverse, product_rest, zero);
    let (first, second) = (V::select(inverse, a, one), V::select(inverse, c, product));
    let d = first.plus(second);
    let dl = second.minus(d.minus(first));
    let dl = dl.plus(V::select(inverse, zero, product_rest));
    let q = n.over(d);
    let tl = q.times_from(d, n).plus(q.times_from(dl, nl)).over(d);

    let q2 = q.times(q);
    let bracket = q2.times_plus(V::splat(1.0 / 9.0), V::splat(-1.0 / 7.0));
    let bracket = q2.times_plus(bracket, V::splat(1.0 / 5.0));
    let bracket = q2.times_plus(bracket, V::splat(-1.0 / 3.0));
    let ps = q.times(q2).times(bracket);

    let [bh, bl] = place.pairs(&ANGLES);
    let h = bh.plus(q);
    let el = bh.minus(h).plus(q);
    let low = el.plus(bl.plus(tl.plus(ps)));
    Sum {
        high: h,
        low,
        error: h.times(V::splat(ERROR)),
        valid: is_not_small(a),
    }
}

/// Very small arguments, where cubes could vanish, are left out.
#[inline(always)]
pub(super) fn is_not_small<V: Wide>(a: V) -> V::Mask {
    const SMALL: f64 = f64::from_bits((1023 - 200) << 52);
    V::splat(SMALL).at_most(a)
}

/// The value at `x` from the one at `|x|`.
#[inline(always)]
pub(super) fn with_sign<V: Wide>(x: V, (value, certain): (V, V::Mask)) -> (V, V::Mask) {
    let negative = V::splat(0.0).above(x);
    (V::select(negative, value.negated(), value), certain)
}

/// The interval between the lower neighbour of one value and the upper one of another, for an
/// increasing odd function that is not steeper than `x` and bounded by `most`; and the lanes that
/// are open.
#[inline(always)]
pub(super) fn between<V: Wide>(
    x: Ends<V>,
    (first, first_certain): (V, V::Mask),
    (last, last_certain): (V, V::Mask),
    most: f64,
) -> (Ends<V>, u32) {
    let (zero, most) = (V::splat(0.0), V::splat(most));
    let (lo, hi) = (x.neg_lo.negated(), x.hi);
    let empty = x.is_empty();
    let (below, _) = neighbours(first);
    let (_, above) = neighbours(last);
    // 0 is beside a value of the one sign, the argument beside one of the other sign; 0 at 0.
    let least = V::select(lo.above(zero), zero, lo.larger(most.negated()));
    let greatest = V::select(zero.above(hi), zero, hi.smaller(most));
    let (lo_zero, hi_zero) = (lo.equals(zero), hi.equals(zero));
    let all = Ends {
        neg_lo: V::select(lo_zero, zero, below.larger(least)).negated(),
        hi: V::select(hi_zero, zero, above.smaller(greatest)),
    };
    let certain = V::both(
        V::either(first_certain, lo_zero),
        V::either(last_certain, hi_zero),
    );
    let done = V::either(certain, empty);
    (all.empty_where(empty), open::<V>(done))
}

/// [`crate::Interval::atan`], and the lanes that are open.
#[inline(always)]
pub(super) fn arctangents<V: Wide>(x: Ends<V>, _: Ends<V>) -> (Ends<V>, u32) {
    let lo = x.neg_lo.negated();
    let first = with_sign(lo, atan_sum(lo).nearest());
    let last = with_sign(x.hi, atan_sum(x.hi).nearest());
    between(x, first, last, f64::INFINITY)
}

#[cfg(test)]
mod tests {
    use num_bigint::BigInt;
    use num_traits::Zero;

    use super::super::tables::exact::{assert_near, pi, series, sum, unit};
    use super::*;

    #[test]
    fn angles() {
        let mut angle = BigInt::zero();
        for j in 0..=64_usize {
            assert_near(&sum(&ANGLES[j]), &angle, -106);
            assert_near(&sum(&ANGLES[128 + j]), &((pi() >> 1) - &angle), -105);
            for [high, low] in [ANGLES[j], ANGLES[128 + j]] {
                assert!(low.abs() <= 2_f64.powi(-53) * high.abs());
                assert!(high == 0.0 || high > 1.9 / 128.0);
            }
            // tan(s - t) = (s - t) / (1 + s t) for tangents s and t.
            angle += series(&(unit(0) * 64 / (4096 + j * (j + 1))), -1);
        }
        assert_eq!(ANGLES[0], [0.0, 0.0]);
        assert_near(&sum(&ANGLES[64]), &(pi() >> 2), -106);
    }
}
