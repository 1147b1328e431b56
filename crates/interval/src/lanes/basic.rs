//! The operations on eight intervals, for every instruction set.
//!
//! *Guarantee* of each function: in every lane the bits of the operation of [`Interval`] with its
//! name (the sign of a zero end aside). Both are the smallest possible intervals, so it is enough
//! that each end is the tight bound. Lanes where this is not certain are done by the scalar
//! operation itself.
//!
//! With ends `[-n, h]` stored as `n` and `h`, every end is rounded up; `-inf` is an end only of the
//! empty set, so that an end of any other set which became `-inf` is a number below the largest
//! negative float, and [`Vector::floor`] puts that float there.

use super::vector::{Ends, Vector};
use super::{Interval8, LANES};
use crate::Interval;

/// Every chunk of two arguments by the function `$chunk`; the lanes that it reports are done one by
/// one.
///
/// A macro, because a closure or a function passed as a value is a function without the instruction
/// set: neither would it be inlined, nor would the instructions be inlined into it.
macro_rules! chunks {
    ($vector:ident, $a:expr, $b:expr, $chunk:ident, $exact:expr) => {{
        use $crate::lanes::{Interval8, LANES, basic::one_by_one, vector::Ends};
        let (mut all, mut rest) = (Interval8::EMPTY, 0);
        for i in 0..LANES / $vector::WIDTH {
            let (ends, open) = $chunk(Ends::<$vector>::load($a, i), Ends::<$vector>::load($b, i));
            ends.store(&mut all, i);
            rest |= open << (i * $vector::WIDTH);
        }
        if rest != 0 {
            // Copies, so that the arguments themselves may stay in registers.
            let (a, b, fast) = (*$a, *$b, all);
            all = one_by_one(&a, &b, &fast, rest, $exact);
        }
        all
    }};
}
#[cfg(target_arch = "x86_64")]
pub(super) use chunks;

#[cold]
#[inline(never)]
pub(super) fn one_by_one(
    a: &Interval8,
    b: &Interval8,
    fast: &Interval8,
    lanes: u32,
    exact: fn(Interval, Interval) -> Interval,
) -> Interval8 {
    let mut all = *fast;
    for lane in 0..LANES {
        if lanes >> lane & 1 == 1 {
            all.set(lane, exact(a.get(lane), b.get(lane)));
        }
    }
    all
}

/// A sum with an empty set has an end `-inf - inf` or `-inf`, which becomes the floor `-inf`.
#[inline(always)]
fn sum<V: Vector>(a: Ends<V>, b: Ends<V>) -> (Ends<V>, u32) {
    let floor = V::floor(a.any_empty(b));
    let sum = Ends {
        neg_lo: a.neg_lo.sum_up(b.neg_lo).larger(floor),
        hi: a.hi.sum_up(b.hi).larger(floor),
    };
    (sum, 0)
}

#[inline(always)]
fn difference<V: Vector>(a: Ends<V>, b: Ends<V>) -> (Ends<V>, u32) {
    let negated = Ends {
        neg_lo: b.hi,
        hi: b.neg_lo,
    };
    sum(a, negated)
}

#[inline(always)]
pub(super) fn add<V: Vector>(a: &Interval8, b: &Interval8) -> Interval8 {
    chunks!(V, a, b, sum, |a, b| a + b)
}

#[inline(always)]
pub(super) fn sub<V: Vector>(a: &Interval8, b: &Interval8) -> Interval8 {
    chunks!(V, a, b, difference, |a, b| a - b)
}

/// The table of [`Interval`]'s `Mul`, read as a choice of a factor from `[a, b]` and one from `[c, d]`:
///
/// | upper end  | `c >= 0` | `d <= 0` | `c < 0 < d`      |   | lower end  | `c >= 0` | `d <= 0` | `c < 0 < d`      |
/// |------------|----------|----------|------------------|---|------------|----------|----------|------------------|
/// | `a >= 0`   | `b d`    | `a d`    | `b d`            |   | `a >= 0`   | `a c`    | `b c`    | `b c`            |
/// | `b <= 0`   | `b c`    | `a c`    | `a c`            |   | `b <= 0`   | `a d`    | `b d`    | `a d`            |
/// | `a < 0 < b`| `b d`    | `a c`    | `b d` or `a c`   |   | `a < 0 < b`| `a d`    | `b c`    | `a d` or `b c`   |
///
/// Where an interval is `[0, 0]` it is in two rows or columns, and each product of that row is
/// zero. Only where both factors have both signs a second product counts; computed for all lanes it
/// does no harm, since no product of ends lies outside the result (`0 inf = 0`).
#[inline(always)]
fn times<V: Vector>(x: Ends<V>, y: Ends<V>) -> (Ends<V>, u32) {
    let zero = V::splat(0.0);
    let (a, b, c, d) = (x.neg_lo.negated(), x.hi, y.neg_lo.negated(), y.hi);
    let (x_positive, x_negative) = (x.neg_lo.at_most(zero), x.hi.at_most(zero));
    let (y_positive, y_negative) = (y.neg_lo.at_most(zero), y.hi.at_most(zero));

    let upper_a = V::either(y_negative, V::without(x_negative, y_positive));
    let upper_c = V::either(x_negative, V::without(y_negative, x_positive));
    let upper = (V::select(upper_a, a, b), V::select(upper_c, c, d));
    let lower_b = V::either(y_negative, V::without(x_positive, y_positive));
    let lower_c = V::without(V::either(x_positive, y_negative), x_negative);
    let lower = (V::select(lower_b, b, a), V::select(lower_c, c, d));
    let products = [
        V::negated_product(lower.0, lower.1),
        V::product(upper.0, upper.1),
    ];
    let one_sign = V::either(
        V::either(x_positive, x_negative),
        V::either(y_positive, y_negative),
    );
    let ([neg_lo, hi], open) = if V::bits(one_sign) == (1 << V::WIDTH) - 1 {
        V::proved(products, [lower, upper])
    } else {
        let ([first_neg_lo, first_hi], open) = V::proved(products, [lower, upper]);
        let second = [V::negated_product(b, c), V::product(a, c)];
        let ([second_neg_lo, second_hi], more) = V::proved(second, [(b, c), (a, c)]);
        (
            [
                V::larger_upper(first_neg_lo, second_neg_lo),
                V::larger_upper(first_hi, second_hi),
            ],
            open | more,
        )
    };
    let product = Ends {
        neg_lo: V::round_up(neg_lo).or_lowest(),
        hi: V::round_up(hi).or_lowest(),
    };
    (product.empty_where(x.any_empty(y)), open)
}

#[inline(always)]
pub(super) fn mul<V: Vector>(a: &Interval8, b: &Interval8) -> Interval8 {
    chunks!(V, a, b, times, |a, b| a * b)
}

/// Products with factors that are not negative: two columns of the table above. Required: the factors
/// are not empty.
#[inline(always)]
fn scaled<V: Vector>(x: Ends<V>, factor: Ends<V>) -> (Ends<V>, u32) {
    let zero = V::splat(0.0);
    let (least, most) = (factor.neg_lo.negated(), factor.hi);
    let lower = (
        x.neg_lo.negated(),
        V::select(x.neg_lo.at_most(zero), least, most),
    );
    let upper = (x.hi, V::select(x.hi.at_most(zero), least, most));
    let products = [
        V::negated_product(lower.0, lower.1),
        V::product(upper.0, upper.1),
    ];
    let ([neg_lo, hi], open) = V::proved(products, [lower, upper]);
    let product = Ends {
        neg_lo: V::round_up(neg_lo).or_lowest(),
        hi: V::round_up(hi).or_lowest(),
    };
    (product.empty_where(x.is_empty()), open)
}

/// `a * factor` for a factor with `lo >= 0`.
#[inline(always)]
pub(super) fn scale<V: Vector>(a: &Interval8, factor: Interval) -> Interval8 {
    let factor = Interval8::splat(factor);
    chunks!(V, a, &factor, scaled, |a, b| a * b)
}

/// The squares of the numbers of least and of largest magnitude.
#[inline(always)]
fn square<V: Vector>(x: Ends<V>, _: Ends<V>) -> (Ends<V>, u32) {
    let (near, far) = magnitudes(x);
    let products = [V::negated_product(near, near), V::product(far, far)];
    let ([neg_lo, hi], open) = V::proved(products, [(near, near), (far, far)]);
    let square = Ends {
        neg_lo: V::round_up(neg_lo).or_lowest(),
        hi: V::round_up(hi),
    };
    (square.empty_where(x.is_empty()), open)
}

/// The least and the largest absolute value of a set that is not empty.
///
/// Of `-lo` and `hi` the larger one is the largest magnitude; the smaller one is negative where the
/// set has one sign, and then it is the negated magnitude of the nearer end.
#[inline(always)]
pub(super) fn magnitudes<V: Vector>(x: Ends<V>) -> (V, V) {
    let near = x.neg_lo.smaller(x.hi).negated().larger(V::splat(0.0));
    (near, x.neg_lo.larger(x.hi))
}

#[inline(always)]
pub(super) fn sqr<V: Vector>(a: &Interval8) -> Interval8 {
    chunks!(V, a, a, square, |a, _| a.sqr())
}

/// Quotients over `[c, d]`, after both sets are negated where `d <= 0`, so that `d >= 0`.
///
/// For `c >= 0` an end `n` (to be rounded up) is `n / d` if `n <= 0` and else `n / c`, which is
/// `+inf` for `c = 0`, as it has to be: the quotients are unbounded then. For `c < 0 < d` all
/// numbers are quotients, save `0 / y = 0`. Over `[0, 0]` there are none.
#[inline(always)]
fn over<V: Vector>(x: Ends<V>, y: Ends<V>) -> (Ends<V>, u32) {
    let (zero, infinity) = (V::splat(0.0), V::splat(f64::INFINITY));
    let turned = y.hi.at_most(zero);
    let both_signs = V::without(y.neg_lo.above(zero), turned);
    let neg_lo = V::select(turned, x.hi, x.neg_lo);
    let hi = V::select(turned, x.neg_lo, x.hi);
    // The sign is taken off a lower end -0, and off those of `both_signs`, whose quotients are dropped.
    let c = V::select(turned, y.hi, y.neg_lo).abs();
    let d = V::select(turned, y.neg_lo, y.hi);
    let nothing = V::either(x.any_empty(y), d.at_most(zero));

    let (neg_lo_above, hi_above) = (neg_lo.above(zero), hi.above(zero));
    let (lower, lower_open) = neg_lo.quotient(V::select(neg_lo_above, c, d));
    let (upper, upper_open) = hi.quotient(V::select(hi_above, c, d));
    let is_zero = V::both(neg_lo.equals(zero), hi.equals(zero));
    let whole = V::select(is_zero, zero, infinity);
    let quotient = Ends {
        neg_lo: V::select(both_signs, whole, V::round_up(lower).or_lowest()),
        hi: V::select(both_signs, whole, V::round_up(upper).or_lowest()),
    };
    let open = V::without(
        V::either(lower_open, upper_open),
        V::either(both_signs, nothing),
    );
    (quotient.empty_where(nothing), V::bits(open))
}

#[inline(always)]
pub(super) fn div<V: Vector>(a: &Interval8, b: &Interval8) -> Interval8 {
    chunks!(V, a, b, over, |a, b| a / b)
}

/// Roots of the elements that are not negative; none where the upper end is below zero.
#[inline(always)]
fn roots<V: Vector>(x: Ends<V>, _: Ends<V>) -> (Ends<V>, u32) {
    let zero = V::splat(0.0);
    let nothing = zero.above(x.hi);
    let (lower, lower_open) = x.neg_lo.negated().larger(zero).negated_root();
    let (upper, upper_open) = x.hi.larger(zero).root();
    let root = Ends {
        neg_lo: V::round_up(lower),
        hi: V::round_up(upper),
    };
    let open = V::without(V::either(lower_open, upper_open), nothing);
    (root.empty_where(nothing), V::bits(open))
}

#[inline(always)]
pub(super) fn sqrt<V: Vector>(a: &Interval8) -> Interval8 {
    chunks!(V, a, a, roots, |a, _| a.sqrt())
}

/// For the empty set both ends stay `-inf`.
#[inline(always)]
fn absolute<V: Vector>(x: Ends<V>, _: Ends<V>) -> (Ends<V>, u32) {
    let absolute = Ends {
        neg_lo: x.neg_lo.smaller(x.hi).smaller(V::splat(0.0)),
        hi: x.neg_lo.larger(x.hi),
    };
    (absolute, 0)
}

#[inline(always)]
pub(super) fn abs<V: Vector>(a: &Interval8) -> Interval8 {
    chunks!(V, a, a, absolute, |a, _| a.abs())
}

/// `-1` or `1` at each end: the sign of 0 is every number between.
#[inline(always)]
fn signs<V: Vector>(x: Ends<V>, _: Ends<V>) -> (Ends<V>, u32) {
    let (zero, one, minus_one) = (V::splat(0.0), V::splat(1.0), V::splat(-1.0));
    let sign = Ends {
        neg_lo: V::select(zero.above(x.neg_lo), minus_one, one),
        hi: V::select(zero.above(x.hi), minus_one, one),
    };
    (sign.empty_where(x.is_empty()), 0)
}

#[inline(always)]
pub(super) fn sign<V: Vector>(a: &Interval8) -> Interval8 {
    chunks!(V, a, a, signs, |a, _| a.sign())
}

#[inline(always)]
fn least<V: Vector>(a: Ends<V>, b: Ends<V>) -> (Ends<V>, u32) {
    let least = Ends {
        neg_lo: a.neg_lo.larger(b.neg_lo),
        hi: a.hi.smaller(b.hi),
    };
    (least.empty_where(a.any_empty(b)), 0)
}

#[inline(always)]
pub(super) fn min<V: Vector>(a: &Interval8, b: &Interval8) -> Interval8 {
    chunks!(V, a, b, least, Interval::min)
}

#[inline(always)]
fn most<V: Vector>(a: Ends<V>, b: Ends<V>) -> (Ends<V>, u32) {
    let most = Ends {
        neg_lo: a.neg_lo.smaller(b.neg_lo),
        hi: a.hi.larger(b.hi),
    };
    (most.empty_where(a.any_empty(b)), 0)
}

#[inline(always)]
pub(super) fn max<V: Vector>(a: &Interval8, b: &Interval8) -> Interval8 {
    chunks!(V, a, b, most, Interval::max)
}

#[inline(always)]
fn common<V: Vector>(a: Ends<V>, b: Ends<V>) -> (Ends<V>, u32) {
    let common = Ends {
        neg_lo: a.neg_lo.smaller(b.neg_lo),
        hi: a.hi.smaller(b.hi),
    };
    let nothing = common.neg_lo.negated().above(common.hi);
    (common.empty_where(nothing), 0)
}

#[inline(always)]
pub(super) fn intersect<V: Vector>(a: &Interval8, b: &Interval8) -> Interval8 {
    chunks!(V, a, b, common, Interval::intersect)
}

#[inline(always)]
fn joined<V: Vector>(a: Ends<V>, b: Ends<V>) -> (Ends<V>, u32) {
    let hull = Ends {
        neg_lo: a.neg_lo.larger(b.neg_lo),
        hi: a.hi.larger(b.hi),
    };
    (hull, 0)
}

#[inline(always)]
pub(super) fn hull<V: Vector>(a: &Interval8, b: &Interval8) -> Interval8 {
    chunks!(V, a, b, joined, Interval::hull)
}

/// `a` in the lanes of the mask, `b` elsewhere.
#[inline(always)]
pub(super) fn select<V: Vector>(mask: u8, a: &Interval8, b: &Interval8) -> Interval8 {
    let mut all = Interval8::EMPTY;
    for i in 0..LANES / V::WIDTH {
        let mask = V::mask(u32::from(mask) >> (i * V::WIDTH));
        let (a, b) = (Ends::<V>::load(a, i), Ends::<V>::load(b, i));
        let chosen = Ends {
            neg_lo: V::select(mask, a.neg_lo, b.neg_lo),
            hi: V::select(mask, a.hi, b.hi),
        };
        chosen.store(&mut all, i);
    }
    all
}

macro_rules! tests {
    ($($(#[$note:meta])* $name:ident: |$x:ident| $question:expr;)+) => {
        $($(#[$note])*
        #[inline(always)]
        pub(super) fn $name<V: Vector>(a: &Interval8) -> u8 {
            let mut bits = 0;
            for i in 0..LANES / V::WIDTH {
                let $x = Ends::<V>::load(a, i);
                bits |= V::bits($question) << (i * V::WIDTH);
            }
            bits as u8
        })+
    };
}

tests! {
    /// The lanes without elements.
    is_empty: |x| x.is_empty();
    /// The lanes with positive elements only.
    is_positive: |x| V::splat(0.0).above(x.neg_lo);
    /// The lanes with 0 as an element.
    contains_zero: |x| V::both(V::splat(0.0).at_most(x.neg_lo), V::splat(0.0).at_most(x.hi));
}
