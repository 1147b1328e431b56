//! The hyperbolic tangent on lanes.

use super::super::vector::Ends;
use super::arctangent::{between, is_not_small, with_sign};
use super::exponential::exp_parts;
use super::tables::{Fixed, ONE, pair, times};
use super::wide::{ROUNDER, Sum, Wide, fast_sum};

/// `tanh(1 / 64)` in units of `2^-126`.
const STEP: Fixed = 0x00ff_faaa_cccb_efc4_9508_942b_ac21_fe07;

/// `T = tanh(j / 64)` and `1 - T^2`.
static VALUES: [[f64; 4]; 256] = {
    let (mut table, mut t, mut j) = ([[0.0; 4]; 256], 0, 0);
    while j < 256 {
        let ([high, low], [slope, slope_low]) = (pair(t), pair(ONE - times(t, t)));
        table[j] = [high, low, slope, slope_low];
        t = over(t + STEP, ONE + times(t, STEP));
        j += 1;
    }
    table
};

/// `a / b` for `a < b`, cut to a unit: one bit after the other.
const fn over(a: Fixed, b: Fixed) -> Fixed {
    let (mut rest, mut quotient, mut i) = (a, 0, 0);
    while i < super::tables::POINT {
        rest *= 2;
        quotient *= 2;
        if rest >= b {
            rest -= b;
            quotient += 1;
        }
        i += 1;
    }
    quotient
}

/// `tanh a` as a sum of two floats, for `0 <= a <= 3.98`.
///
/// With `c = j / 64` next to `a`, `r = a - c` (exact: `c = 0` or Sterbenz), `|r| <= 2^-7`,
/// `T = tanh c = th + tl`, `S = 1 - T^2 = sh + sl` and `t = tanh r` the value is
/// `T + t S / (1 + T t)`.
///
/// *Parts.* `t = r + t3`, `t3 = r^3 (-1/3 + 2 r^2/15 - 17 r^4/315 + 62 r^6/2835)`, remainder below
/// `2^-83`; `|t3| < 2^-22.5` errs by `4 · 2^-53` of it. `d + dl = 1 + T t` up to `tl r`, below
/// `2^-60 T`, which is left out. With `q` the rounded `sh / d` and its exact remainder,
/// `S / (1 + T t) = q + ql`, `ql = (remainder + (sl - q dl)) / (d + dl)`, below `2^-22.4 T` and
/// with an error below `2^-75`, and `2^-60 S T` for what was left out.
///
/// *Sum.* `h + el = th + r q` without error (`pl` is the rest of the product), as `T = 0` or
/// `T > 1.9 · 2^-7`. The rest is `el + (tl + (pl + (t3 (q + ql) + r ql)))`. In units of `2^-75`:
/// `t3` errs by 2.9, its product by 1.1, the four sums by 0.8 each, `r ql` by 0.1 and, for what was
/// left out, by `2^-67 S T`. Relative to the value, which is more than `0.99 · 2^-7` and `T / 2`,
/// for `T != 0` this is below `2^-65.1 + 2^-66`. For `T = 0` the value is about `r = a`, and all
/// that errs is `t3`: below `2^-66`.
#[inline(always)]
pub(super) fn moderate<V: Wide>(a: V) -> Sum<V> {
    const ERROR: f64 = f64::from_bits((1023 - 64) << 52);
    let one = V::splat(1.0);
    let rounder = V::splat(ROUNDER);
    let number = a.times_plus(V::splat(64.0), rounder);
    let c = number.minus(rounder).times(V::splat(1.0 / 64.0));
    let r = a.minus(c);

    let r2 = r.times(r);
    let bracket = r2.times_plus(V::splat(62.0 / 2835.0), V::splat(-17.0 / 315.0));
    let bracket = r2.times_plus(bracket, V::splat(2.0 / 15.0));
    let bracket = r2.times_plus(bracket, V::splat(-1.0 / 3.0));
    let t3 = r.times(r2).times(bracket);

    let [th, tl, sh, sl] = number.rows(&VALUES);
    let d = th.times_plus(r, one);
    let dl = th.times_plus(t3, th.times_minus(r, d.minus(one)));
    let q = sh.over(d);
    let remainder = q.times_from(d, sh);
    let ql = remainder.plus(q.times_from(dl, sl)).over(d.plus(dl));

    let product = r.times(q);
    let pl = r.times_minus(q, product);
    let h = th.plus(product);
    let el = th.minus(h).plus(product);
    let rest = pl.plus(t3.times_plus(q.plus(ql), r.times(ql)));
    let low = el.plus(tl.plus(rest));
    Sum {
        high: h,
        low,
        error: h.times(V::splat(ERROR)),
        valid: is_not_small(a),
    }
}

/// `tanh a` as a sum of two floats, for `3.98 <= a <= 20`.
///
/// `tanh a = 1 - 2 / (E + 1)`, where `E = exp(2 a) > 2800` as a sum of two floats has a relative
/// error below `2^-66`, and so has `E + 1 = d + dl`, `|dl| < 2^-51 d`. With `q` the rounded `2 / d`
/// and its exact remainder, `2 / (d + dl) = q + ql` up to `2^-100 q`,
/// `ql = (remainder - q dl) / d`. As `q < 2^-10.4`, the value `1 - q - ql` errs by less than
/// `2^-76`, and its last rounding by `2^-105`.
#[inline(always)]
pub(super) fn large<V: Wide>(a: V) -> Sum<V> {
    const ERROR: f64 = f64::from_bits((1023 - 70) << 52);
    let (one, two) = (V::splat(1.0), V::splat(2.0));
    let (h, low, exponent) = exp_parts(a.plus(a));
    let scale = one.bits_plus(exponent);
    let (high, rest) = fast_sum(h, low);
    let (d, dl) = fast_sum(high.times(scale), one);
    let dl = dl.plus(rest.times(scale));
    let q = two.over(d);
    let ql = q.times_from(d, two).minus(q.times(dl)).over(d);
    let (value, el) = fast_sum(one, q.negated());
    Sum {
        high: value,
        low: el.minus(ql),
        error: V::splat(ERROR),
        valid: is_not_small(a),
    }
}

/// The float nearest to `tanh x`, and where this is certain.
///
/// For `|x| >= 20` the value lies within `2 exp(-40) < 2^-56` of 1, which so is the nearest float.
#[inline(always)]
fn tanh_nearest<V: Wide>(x: V) -> (V, V::Mask) {
    const BORDER: f64 = 3.98;
    const FLAT: f64 = 20.0;
    let a = x.abs();
    let near = a.at_most(V::splat(BORDER));
    let flat = V::splat(FLAT).at_most(a);
    let (mut value, mut certain) = (V::splat(1.0), flat);
    if V::bits(near) != 0 {
        let (some, some_certain) = moderate(a.smaller(V::splat(BORDER))).nearest();
        value = V::select(near, some, value);
        certain = V::either(certain, V::both(near, some_certain));
    }
    if V::bits(V::either(near, flat)) != (1 << V::WIDTH) - 1 {
        let (some, some_certain) =
            large(a.larger(V::splat(BORDER)).smaller(V::splat(FLAT))).nearest();
        let other = V::without(V::without(some_certain, near), flat);
        value = V::select(other, some, value);
        certain = V::either(certain, other);
    }
    with_sign(x, (value, certain))
}

/// [`crate::Interval::tanh`], and the lanes that are open.
#[inline(always)]
pub(super) fn tanhs<V: Wide>(x: Ends<V>, _: Ends<V>) -> (Ends<V>, u32) {
    let (first, last) = (tanh_nearest(x.neg_lo.negated()), tanh_nearest(x.hi));
    between(x, first, last, 1.0)
}

#[cfg(test)]
mod tests {
    use super::super::tables::exact::{BITS, assert_near, sum, unit};
    use super::*;

    #[test]
    fn values() {
        for (j, [high, low, slope, slope_low]) in VALUES.into_iter().enumerate() {
            // exp(j / 32) by its series.
            let (mut term, mut power, mut n) = (unit(0), unit(0), 1);
            while term > unit(-390) {
                term = term * j / (32 * n);
                power += &term;
                n += 1;
            }
            let t = ((&power - unit(0)) << BITS) / (&power + unit(0));
            assert_near(&sum(&[high, low]), &t, -106);
            assert_near(
                &sum(&[slope, slope_low]),
                &(unit(0) - ((&t * &t) >> BITS)),
                -106,
            );
            assert!(low.abs() <= 2_f64.powi(-53) * high.abs());
            assert!(slope_low.abs() <= 2_f64.powi(-53) * slope);
            assert!(high == 0.0 || high > 1.9 / 128.0);
        }
        assert_eq!(VALUES[0], [0.0, 0.0, 1.0, 0.0]);
    }
}
