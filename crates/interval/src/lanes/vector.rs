//! What the operations on lanes need from an instruction set.

use super::{Floats, Interval8, basic};
use crate::Interval;

/// Some floats side by side, in a register of the instruction set.
///
/// Arithmetic rounds up where it says so. `Upper` is a number that is about to be rounded up: what an
/// instruction set needs to decide (the nearest float and the error of it), or the bound itself.
pub(super) trait Vector: Copy {
    /// One truth value per float.
    type Mask: Copy;
    /// A value before it is rounded up.
    type Upper: Copy;
    /// How many floats there are; a divisor of [`super::LANES`].
    const WIDTH: usize;

    /// The floats with the numbers `chunk * WIDTH ..`.
    fn load(from: &Floats, chunk: usize) -> Self;
    /// Puts the floats where [`Vector::load`] finds them.
    fn store(self, to: &mut Floats, chunk: usize);
    fn splat(x: f64) -> Self;

    fn negated(self) -> Self;
    fn abs(self) -> Self;
    /// `if self > other { self } else { other }`: `other` where one is NaN.
    fn larger(self, other: Self) -> Self;
    /// `if self < other { self } else { other }`: `other` where one is NaN.
    fn smaller(self, other: Self) -> Self;

    /// `self > other`, false for NaN.
    fn above(self, other: Self) -> Self::Mask;
    /// `self <= other`, false for NaN.
    fn at_most(self, other: Self) -> Self::Mask;
    /// `self == other`, false for NaN.
    fn equals(self, other: Self) -> Self::Mask;
    fn both(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    fn either(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// `a` and not `b`.
    fn without(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// `a` where the mask is set, `b` elsewhere.
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self;
    /// Float `i` in bit `i`.
    fn bits(mask: Self::Mask) -> u32;
    /// Bit `i` for float `i`.
    fn mask(bits: u32) -> Self::Mask;

    /// What an end that [`Vector::sum_up`] or [`Vector::round_up`] gave is at least: `-inf` in the
    /// lanes of the mask, elsewhere the largest negative number (or `-inf`, if this is never given
    /// for it).
    fn floor(empty: Self::Mask) -> Self;
    /// `larger` of the floor of a set that is not empty.
    fn or_lowest(self) -> Self;

    /// Smallest float not below `a + b`, for operands that are not NaN; `-inf` or NaN where the sum
    /// is too small for a float or an operand is `-inf`.
    fn sum_up(self, other: Self) -> Self;

    /// `a b`, of which a caller has to ask whether it is [`Vector::proved`].
    fn product(self, other: Self) -> Self::Upper;
    /// `-a b`
    fn negated_product(self, other: Self) -> Self::Upper;
    /// The larger one of two proved products.
    fn larger_upper(a: Self::Upper, b: Self::Upper) -> Self::Upper;
    /// Makes products `0 inf` zero, and tells in which lanes any of the products is not certain to be
    /// rounded correctly by [`Vector::round_up`].
    fn proved<const N: usize>(
        products: [Self::Upper; N],
        factors: [(Self, Self); N],
    ) -> ([Self::Upper; N], u32);

    /// `n / d` for `d > 0`, also for `d = +0` if `n > 0`, and where it is not certain to be rounded
    /// correctly. Required: not two infinities. `n / inf` is 0.
    fn quotient(self, divisor: Self) -> (Self::Upper, Self::Mask);
    /// The square root of a number that is not negative, and where it is not certain to be rounded
    /// correctly.
    fn root(self) -> (Self::Upper, Self::Mask);
    /// The negated square root.
    fn negated_root(self) -> (Self::Upper, Self::Mask);

    // The longer operations of [`Interval`]. A path may replace each of them: by vector code, where it
    // has any, and by a function of its own, since a copy in every kernel would fill the caches and
    // take long to compile.

    #[inline(always)]
    fn mul(a: &Interval8, b: &Interval8) -> Interval8 {
        basic::mul::<Self>(a, b)
    }

    #[inline(always)]
    fn scale(a: &Interval8, factor: Interval) -> Interval8 {
        basic::scale::<Self>(a, factor)
    }

    #[inline(always)]
    fn div(a: &Interval8, b: &Interval8) -> Interval8 {
        basic::div::<Self>(a, b)
    }

    #[inline(always)]
    fn sqr(a: &Interval8) -> Interval8 {
        basic::sqr::<Self>(a)
    }

    #[inline(always)]
    fn sqrt(a: &Interval8) -> Interval8 {
        basic::sqrt::<Self>(a)
    }

    #[inline(always)]
    fn exp(a: &Interval8) -> Interval8 {
        a.map(Interval::exp)
    }

    #[inline(always)]
    fn ln(a: &Interval8) -> Interval8 {
        a.map(Interval::ln)
    }

    #[inline(always)]
    fn sin(a: &Interval8) -> Interval8 {
        a.map(Interval::sin)
    }

    #[inline(always)]
    fn cos(a: &Interval8) -> Interval8 {
        a.map(Interval::cos)
    }

    #[inline(always)]
    fn tan(a: &Interval8) -> Interval8 {
        a.map(Interval::tan)
    }

    #[inline(always)]
    fn atan(a: &Interval8) -> Interval8 {
        a.map(Interval::atan)
    }

    #[inline(always)]
    fn tanh(a: &Interval8) -> Interval8 {
        a.map(Interval::tanh)
    }

    #[inline(always)]
    fn powi(a: &Interval8, n: i32) -> Interval8 {
        a.map(|x| x.powi(n))
    }

    /// Smallest float not below the value; `-inf` or NaN where it is too small for a float.
    fn round_up(value: Self::Upper) -> Self;
}

/// Some intervals side by side.
#[derive(Clone, Copy)]
pub(super) struct Ends<V> {
    pub(super) neg_lo: V,
    pub(super) hi: V,
}

impl<V: Vector> Ends<V> {
    #[inline(always)]
    pub(super) fn load(from: &Interval8, chunk: usize) -> Ends<V> {
        Ends {
            neg_lo: V::load(&from.neg_lo, chunk),
            hi: V::load(&from.hi, chunk),
        }
    }

    #[inline(always)]
    pub(super) fn store(self, to: &mut Interval8, chunk: usize) {
        self.neg_lo.store(&mut to.neg_lo, chunk);
        self.hi.store(&mut to.hi, chunk);
    }

    /// Nothing is stored as an empty set but `-inf` at both ends, and this upper end no other set has.
    #[inline(always)]
    pub(super) fn is_empty(self) -> V::Mask {
        self.hi.equals(V::splat(f64::NEG_INFINITY))
    }

    /// Where at least one is empty.
    #[inline(always)]
    pub(super) fn any_empty(self, other: Ends<V>) -> V::Mask {
        let least = self.hi.smaller(other.hi);
        least.equals(V::splat(f64::NEG_INFINITY))
    }

    #[inline(always)]
    pub(super) fn empty_where(self, mask: V::Mask) -> Ends<V> {
        let none = V::splat(f64::NEG_INFINITY);
        Ends {
            neg_lo: V::select(mask, none, self.neg_lo),
            hi: V::select(mask, none, self.hi),
        }
    }
}
