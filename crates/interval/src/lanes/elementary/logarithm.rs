//! The natural logarithm on lanes.

use super::super::vector::Ends;
use super::exponential::open;
use super::tables::{FIRST, LN_2_PARTS, PIECES, WIDTH};
use super::wide::{Sum, Wide, fast_sum, neighbours};

/// `ln x` as a sum of two floats; not at 1.
///
/// `x = 2^e z` with `z` in `[0.6875, 1.375)`, and with the reciprocal `c` of the piece of `z`:
/// `ln x = e ln 2 - ln c + ln(1 + r)`, `r = z c - 1`. The product is `p + pl` without error,
/// `rh = p - 1` is exact (Sterbenz). `|r| < 2^-7.4`, or `c = 1`, `|r| <= 2^-7`, `pl = 0`.
///
/// *Parts.* `A = e LN2H + LCH` is exact: a multiple of `2^-42` below `2^10`. `B = e LN2L + LCL` is
/// below `2^-32` and errs by less than `2^-84`, its constants included. `ln(1 + r)` is
/// `rh - hh/2 - hl/2 + rh^3 P(rh) + pl (1 - rh + rh^2)`, where `hh + hl = rh^2` without error and
/// `P = 1/3 - rh/4 + ... - rh^7/10`, up to the remainder `rh^11 / 11 · 1.01 < 2^-80` and
/// `pl rh^3 + pl^2 < 2^-75`.
///
/// *Sum.* `A + rh` and then `- hh/2` are added without error (Fast2Sum: `A = 0`, or `|A| > 1.7 |r|`
/// as a test of the tables shows for `e = 0`, and else `|A| > 0.3`; the first sum is more than
/// `hh / 2`). All the rest is below `2^-23.5`. In units of `2^-77` its errors are: the power 2.3,
/// `P` 1.8, the two sums 1.0 each, what is left out of the series 3.8. So:
/// - For `A != 0` the error is less than `2^-73.6`, and `|ln x| > 2^-8`, since `x` is not in the
///   pieces at 1: relative, below `2^-65.5`.
/// - For `A = 0` (`c = 1`, `e = 0`, `B = pl = 0`), with `ρ = |rh| <= 2^-7` the errors of `rh^3 P`,
///   of its two sums and the remainder are below `ρ^3 2^-52 + ρ^11 / 10`: relative, below
///   `2^-65.5`.
#[inline(always)]
pub(super) fn ln_sum<V: Wide>(x: V) -> Sum<V> {
    const ERROR: f64 = f64::from_bits((1023 - 65) << 52);
    /// A float with this exponent has its integer in its lowest bits.
    const INTEGERS: u64 = 0x4330_0000_0000_0000;
    /// Added to the exponent, so that it is not negative.
    const LIFT: u64 = 1024;
    let within = V::both(
        V::splat(f64::MIN_POSITIVE).at_most(x),
        x.at_most(V::splat(f64::MAX)),
    );
    let from_first = x.bits_plus(V::of_bits((LIFT << 52).wrapping_sub(FIRST)));
    let exponent = from_first.bits_right::<52>();
    let e = exponent
        .bits_or(V::of_bits(INTEGERS))
        .minus(V::splat((1_u64 << 52) as f64 + LIFT as f64));
    let z = x
        .bits_plus(V::of_bits(LIFT << 52))
        .bits_minus(exponent.bits_left::<52>());
    let piece = from_first.bits_right::<WIDTH>();

    let [c, log_high, log_low, _] = piece.rows(&PIECES);
    let p = z.times(c);
    let pl = z.times_minus(c, p);
    let rh = p.minus(V::splat(1.0));

    let (high, low) = LN_2_PARTS;
    let a = e.times_plus(V::splat(high), log_high);
    let b = e.times_plus(V::splat(low), log_low);

    let hh = rh.times(rh);
    let hl = rh.times_minus(rh, hh);
    let mut polynomial = V::splat(-0.1);
    for coefficient in [
        1.0 / 9.0,
        -1.0 / 8.0,
        1.0 / 7.0,
        -1.0 / 6.0,
        1.0 / 5.0,
        -1.0 / 4.0,
        1.0 / 3.0,
    ] {
        polynomial = rh.times_plus(polynomial, V::splat(coefficient));
    }

    let half = V::splat(0.5);
    let (first, first_rest) = fast_sum(a, rh);
    let (s, second_rest) = fast_sum(first, hh.times(half).negated());
    let tail = pl
        .times_plus(rh.times_minus(rh, rh), pl)
        .plus(hl.times_from(half, b));
    let tail = rh.times(hh).times_plus(polynomial, tail);
    let low = first_rest.plus(second_rest).plus(tail);
    Sum {
        high: s,
        low,
        error: s.abs().times(V::splat(ERROR)),
        valid: within,
    }
}

/// [`crate::Interval::ln`], and the lanes that are open.
#[inline(always)]
pub(super) fn logarithms<V: Wide>(x: Ends<V>, _: Ends<V>) -> (Ends<V>, u32) {
    let (zero, one) = (V::splat(0.0), V::splat(1.0));
    let infinity = V::splat(f64::INFINITY);
    let (lo, hi) = (x.neg_lo.negated(), x.hi);
    let nothing = hi.at_most(zero);

    let (value, certain) = ln_sum(lo).nearest();
    let (below, _) = neighbours(value);
    let below = V::select(lo.equals(one), zero, below);
    let unbounded = lo.at_most(zero);
    let below = V::select(unbounded, infinity.negated(), below);
    let lo_certain = V::either(V::either(certain, unbounded), lo.equals(one));

    let (value, certain) = ln_sum(hi).nearest();
    let (_, above) = neighbours(value);
    let above = V::select(hi.equals(one), zero, above);
    let unbounded = hi.equals(infinity);
    let above = V::select(unbounded, infinity, above);
    let hi_certain = V::either(V::either(certain, unbounded), hi.equals(one));

    let done = V::either(V::both(lo_certain, hi_certain), nothing);
    let all = Ends {
        neg_lo: below.negated(),
        hi: above,
    };
    (all.empty_where(nothing), open::<V>(done))
}
