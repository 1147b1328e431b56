//! Sine, cosine and tangent on lanes.

use super::super::vector::Ends;
use super::exponential::open;
use super::tables::{CIRCLE, PI_OVER_128};
use super::wide::{ROUNDER, Sum, Wide, neighbours};

/// The largest argument that is not left to the scalar operation, as in the module `period`.
const LARGEST: f64 = 1_048_576.0;

/// `x = k P + r` with `P = π / 128`, `r = rh + rl`, and what sine and cosine of `r` are beside `r`
/// and 1.
///
/// *Reduction*, for `|x| <= 2^20`: `|k| < 2^25.4`, `|r| <= P (1/2 + 2^-25) < 2^-6.34`.
/// `P = P1 + P2 + P3` up to `2^-113`, where `P1` is a multiple of `2^-32` and `P2 < 2^-32` one of
/// `2^-59`. For `k = 0` all of `r` is `x`. Else `x` is a multiple of `2^-59`, since `|x| > 2^-6.4`,
/// and so are `x - k P1`, below `2^-6.34 + 2^-6.6` in size, and `x - k P1 - k P2`: both are floats.
/// `k P3 < 2^-33.6` is rounded with an error of `2^-87`. So `r = rh + rl` up to `2^-86`, and `r`
/// itself has a relative error of `2^-53` in the polynomials.
///
/// *Polynomials.* `sin r = rh + rl + ps`, `ps = r^3 (-1/6 + r^2/120 - r^4/5040)`, remainder
/// `r^9 / 9! < 2^-75`; `cos r = 1 + pc`, `pc = r^2 (-1/2 + r^2/24 - r^4/720 + r^6/40320)`,
/// remainder `r^10 / 10! < 2^-85`. Their rounding errors are at most `5 · 2^-53` of them:
/// `|pc| < 2^-13.68`, `2^-64.3`; `|ps| < r^3 / 6`.
///
/// Very small arguments, where `r^3` could vanish, are left out.
#[derive(Clone, Copy)]
struct Reduced<V: Wide> {
    /// `k` in its lowest bits.
    number: V,
    rh: V,
    rl: V,
    ps: V,
    pc: V,
    /// Where `k = 0`.
    whole: V::Mask,
    /// Where the argument is in range.
    within: V::Mask,
}

impl<V: Wide> Reduced<V> {
    #[inline(always)]
    fn of(x: V) -> Reduced<V> {
        const SMALL: f64 = f64::from_bits((1023 - 200) << 52);
        let (p1, p2, p3) = PI_OVER_128;
        let size = x.abs();
        let rounder = V::splat(ROUNDER);
        let number = x.times_plus(V::splat(128.0 * std::f64::consts::FRAC_1_PI), rounder);
        let k = number.minus(rounder);
        let rh = k.times_from(V::splat(p2), k.times_from(V::splat(p1), x));
        let rl = k.times(V::splat(-p3));
        let r = rh.plus(rl);
        let r2 = r.times(r);
        let odd = r2.times_plus(V::splat(-1.0 / 5040.0), V::splat(1.0 / 120.0));
        let odd = r2.times_plus(odd, V::splat(-1.0 / 6.0));
        let even = r2.times_plus(V::splat(1.0 / 40320.0), V::splat(-1.0 / 720.0));
        let even = r2.times_plus(even, V::splat(1.0 / 24.0));
        let even = r2.times_plus(even, V::splat(-0.5));
        Reduced {
            number,
            rh,
            rl,
            ps: r.times(r2).times(odd),
            pc: r2.times(even),
            whole: k.equals(V::splat(0.0)),
            within: V::both(
                V::splat(SMALL).at_most(size),
                size.at_most(V::splat(LARGEST)),
            ),
        }
    }

    /// `S cos r + C sin r` for `S = sh + sl` and `C = ch + cl`, the sine of a multiple of `P` and
    /// its derivative: as a sum of two floats, with a relative error below `2^-62` where the mask
    /// says so.
    ///
    /// *If `S != 0`*: `|S| >= sin P` and `|C rh| < sin P`, so `h + el = sh + ch rh` without error
    /// (`pl` is the rest of the product), and the value is at least `|S| / 2.01`. In units of
    /// `2^-63` of the value, the errors are: `pc` 0.79; `ps` 0.13; the rest
    /// `el + (pl + (sh pc + (ch (rl + ps) + (cl rh + sl))))` has three roundings of numbers below
    /// `2^-13.68 |S| + 2^-21.5`, each 0.19, and others of the second of these sizes, 0.06; left out
    /// are `sl pc`, 0.16, and `cl (rl + ps)`, 0.03; the tables themselves, `2^-96`, nothing.
    /// Together less than 1.8.
    ///
    /// *If `S = 0`*, then `C = ±1`, and the value is `±(rh + (rl + ps))`. It is taken for certain
    /// only for `k = 0` or `|rh| >= 2^-20`, so that `rh` is the largest part. `ps` errs by
    /// `5 · 2^-53 r^2 / 6` of the value, below `2^-65.8`, the sum by much less, the reduction by
    /// `2^-66`; together less than `2^-64`.
    ///
    /// In both cases the second number is at most `2^-12.3` of the first one.
    #[inline(always)]
    fn turned(&self, [sh, sl, ch, cl]: [V; 4]) -> (V, V, V::Mask) {
        const NEAR_ZERO: f64 = f64::from_bits((1023 - 20) << 52);
        let product = ch.times(self.rh);
        let pl = ch.times_minus(self.rh, product);
        let h = sh.plus(product);
        let el = sh.minus(h).plus(product);
        let tail = ch.times_plus(self.rl.plus(self.ps), cl.times_plus(self.rh, sl));
        let low = el.plus(pl.plus(sh.times_plus(self.pc, tail)));
        let large = V::splat(NEAR_ZERO).at_most(h.abs());
        (h, low, V::both(self.within, V::either(large, self.whole)))
    }
}

/// `sin (x + turn π / 128)` as a sum of two floats.
#[inline(always)]
pub(super) fn sin_sum<V: Wide>(x: V, turn: u64) -> Sum<V> {
    const ERROR: f64 = f64::from_bits((1023 - 62) << 52);
    let reduced = Reduced::of(x);
    let place = reduced.number.bits_plus(V::of_bits(turn));
    let (high, low, valid) = reduced.turned(place.rows(&CIRCLE));
    Sum {
        high,
        low,
        error: high.abs().times(V::splat(ERROR)),
        valid,
    }
}

/// `tan x` as a sum of two floats.
///
/// `(h + l) / (g + m)` for sine and cosine, with `q` the float nearest to `h / g`, is
/// `q + ((h - q g) + (l - q m)) / (g + m)`; the first bracket is exact. In units of `2^-63` of the
/// value, sine and cosine err by 1.8 each. The brackets together are below `2^-11.3 |h|`; the
/// rounding of the second one, of their sum, of the divisor and of the quotient are each less than
/// `2^-53` of this, together 1.7. In all less than 5.4.
#[inline(always)]
pub(super) fn tan_sum<V: Wide>(x: V) -> Sum<V> {
    /// `6 · 2^-63`
    const ERROR: f64 = f64::from_bits(((1023 - 61) << 52) | (1 << 51));
    let reduced = Reduced::of(x);
    let [sh, sl, ch, cl] = reduced.number.rows(&CIRCLE);
    let (h, l, sin_valid) = reduced.turned([sh, sl, ch, cl]);
    let (g, m, cos_valid) = reduced.turned([ch, cl, sh.negated(), sl.negated()]);
    let valid = V::both(sin_valid, cos_valid);
    let q = h.over(g);
    let rest = q.times_from(g, h).plus(q.times_from(m, l));
    let low = rest.over(g.plus(m));
    Sum {
        high: q,
        low,
        error: q.abs().times(V::splat(ERROR)),
        valid,
    }
}

/// `floor(x / (π/2))` as `quarter` of the module `period` finds it in its short way, and where this
/// is certain.
#[inline(always)]
fn quarter<V: Wide>(x: V) -> (V, V::Mask) {
    let t = x.times(V::splat(std::f64::consts::FRAC_2_PI));
    let whole = t.floor_of();
    let rest = t.minus(whole);
    let clear = V::both(rest.above(V::splat(2e-9)), V::splat(1.0 - 2e-9).above(rest));
    let within = x.abs().at_most(V::splat(LARGEST));
    let zero = x.equals(V::splat(0.0));
    (whole, V::either(V::both(clear, within), zero))
}

/// Bounds of the value at an end, and where they are certain. At 0 it is exactly `at_zero`.
#[inline(always)]
fn value<V: Wide>(x: V, turn: u64, at_zero: V) -> (V, V, V::Mask) {
    let one = V::splat(1.0);
    let (value, certain) = sin_sum(x, turn).nearest();
    let (below, above) = neighbours(value);
    let zero = x.equals(V::splat(0.0));
    (
        V::select(zero, at_zero, below.larger(one.negated())),
        V::select(zero, at_zero, above.smaller(one)),
        V::either(certain, zero),
    )
}

/// True where one of `count` quarters after `start` has the given number, up to multiples of 4.
#[inline(always)]
fn include<V: Wide>(start: V, count: V, number: f64) -> V::Mask {
    // From the first one of them to the wanted one.
    let distance = V::splat(number - 1.0).minus(start);
    let turns = distance.times(V::splat(0.25)).floor_of();
    count.above(turns.times_from(V::splat(4.0), distance))
}

/// [`crate::Interval::sin`] or, a quarter turn further, [`crate::Interval::cos`], and the lanes
/// that are open.
///
/// Of the multiples of `π/2` in `(lo, hi]`, numbered `k(lo) + 1 ..= k(hi)`, the numbers
/// `maximum + 4 m` are maxima, and the minima are two quarters later. The width decides as in the
/// module `period`.
#[inline(always)]
fn waves<V: Wide>(x: Ends<V>, turn: u64, at_zero: f64, maximum: f64) -> (Ends<V>, u32) {
    let (one, at_zero) = (V::splat(1.0), V::splat(at_zero));
    let (lo, hi) = (x.neg_lo.negated(), x.hi);
    let empty = x.is_empty();
    let width = hi.sum_up(x.neg_lo);
    let broad = width.above(V::splat(2.0 * std::f64::consts::PI));

    let (first_below, first_above, first_certain) = value(lo, turn, at_zero);
    let (last_below, last_above, last_certain) = value(hi, turn, at_zero);
    let ((start, start_certain), (stop, stop_certain)) = (quarter(lo), quarter(hi));
    let count = stop.minus(start);
    let top = V::either(broad, include(start, count, maximum));
    let bottom = V::either(broad, include(start, count, maximum + 2.0));
    let least = first_below.smaller(last_below).negated();
    let all = Ends {
        neg_lo: V::select(bottom, one, least),
        hi: V::select(top, one, first_above.larger(last_above)),
    };
    let values = V::both(first_certain, last_certain);
    let quarters = V::both(start_certain, stop_certain);
    let certain = V::both(values, quarters);
    let done = V::either(V::either(certain, empty), broad);
    (all.empty_where(empty), open::<V>(done))
}

#[inline(always)]
pub(super) fn sines<V: Wide>(x: Ends<V>, _: Ends<V>) -> (Ends<V>, u32) {
    waves(x, 0, 0.0, 1.0)
}

#[inline(always)]
pub(super) fn cosines<V: Wide>(x: Ends<V>, _: Ends<V>) -> (Ends<V>, u32) {
    waves(x, 64, 1.0, 0.0)
}

/// [`crate::Interval::tan`]: between two poles, the numbers 1 and 3 up to multiples of 4, it is
/// increasing.
#[inline(always)]
pub(super) fn tangents<V: Wide>(x: Ends<V>, _: Ends<V>) -> (Ends<V>, u32) {
    let (zero, infinity) = (V::splat(0.0), V::splat(f64::INFINITY));
    let (lo, hi) = (x.neg_lo.negated(), x.hi);
    let empty = x.is_empty();
    let broad = hi
        .sum_up(x.neg_lo)
        .above(V::splat(2.0 * std::f64::consts::PI));
    let ((start, start_certain), (stop, stop_certain)) = (quarter(lo), quarter(hi));
    let count = stop.minus(start);
    let poles = V::either(include(start, count, 1.0), include(start, count, 3.0));
    let quarters = V::both(start_certain, stop_certain);

    let (first, first_certain) = tan_sum(lo).nearest();
    let (last, last_certain) = tan_sum(hi).nearest();
    let (below, _) = neighbours(first);
    let (_, above) = neighbours(last);
    let (lo_zero, hi_zero) = (lo.equals(zero), hi.equals(zero));
    let all = Ends {
        neg_lo: V::select(lo_zero, zero, below).negated(),
        hi: V::select(hi_zero, zero, above),
    };
    let unbounded = V::either(broad, V::both(poles, quarters));
    let values = V::both(
        V::either(first_certain, lo_zero),
        V::either(last_certain, hi_zero),
    );
    let certain = V::both(values, quarters);
    let done = V::either(V::either(certain, empty), unbounded);
    let all = Ends {
        neg_lo: V::select(unbounded, infinity, all.neg_lo),
        hi: V::select(unbounded, infinity, all.hi),
    };
    (all.empty_where(empty), open::<V>(done))
}
