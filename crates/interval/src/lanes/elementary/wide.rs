//! What the elementary functions need from an instruction set beside [`Vector`].

use super::super::vector::Vector;
use crate::round::STEP;

/// Arithmetic that is rounded to nearest, fused products, and the bits of the floats.
pub(in super::super) trait Wide: Vector {
    fn plus(self, other: Self) -> Self;
    fn minus(self, other: Self) -> Self;
    fn times(self, other: Self) -> Self;
    fn over(self, other: Self) -> Self;
    /// `self a + b`, rounded once.
    fn times_plus(self, a: Self, b: Self) -> Self;
    /// `self a - b`, rounded once.
    fn times_minus(self, a: Self, b: Self) -> Self;
    /// `b - self a`, rounded once.
    fn times_from(self, a: Self, b: Self) -> Self;
    /// The largest integer that is not above.
    fn floor_of(self) -> Self;

    /// The bits as integers: the sum, the difference, those that either has.
    fn bits_plus(self, other: Self) -> Self;
    fn bits_minus(self, other: Self) -> Self;
    fn bits_or(self, other: Self) -> Self;
    /// The bits moved to higher places.
    fn bits_left<const N: u32>(self) -> Self;
    /// The bits moved to lower places, zeros behind them.
    fn bits_right<const N: u32>(self) -> Self;
    /// The columns of the rows whose numbers the lowest bits tell, as many bits as the table has.
    /// Required: the number of rows is a power of two.
    fn pairs<const M: usize>(self, table: &[[f64; 2]; M]) -> [Self; 2];
    /// The same of four columns.
    fn rows<const M: usize>(self, table: &[[f64; 4]; M]) -> [Self; 4];

    /// The next float above where the mask is set, for normal numbers; see `raised` of the basic
    /// operations.
    #[inline(always)]
    fn raised_where(self, mask: Self::Mask) -> Self {
        let above = self.abs().times_plus(Self::splat(STEP), self);
        Self::select(mask, above, self)
    }

    #[inline(always)]
    fn of_bits(bits: u64) -> Self {
        Self::splat(f64::from_bits(bits))
    }
}

/// `high + low` with `|low| <= |high|`: a value up to less than `error`, where `valid`.
#[derive(Clone, Copy)]
pub(super) struct Sum<V: Wide> {
    pub(super) high: V,
    pub(super) low: V,
    pub(super) error: V,
    pub(super) valid: V::Mask,
}

impl<V: Wide> Sum<V> {
    /// The float nearest to the value, and where this is certain.
    ///
    /// Proof. `value` is the rounded sum and `rest` the exact rest of it (Fast2Sum). Rounding is
    /// monotone: where the two sums with `rest` moved by the error are rounded to `value`, all
    /// numbers between them are. The errors of the moved rests themselves, below `2^-105 |value|`,
    /// have to be part of `error`.
    #[inline(always)]
    pub(super) fn nearest(self) -> (V, V::Mask) {
        let value = self.high.plus(self.low);
        let rest = self.high.minus(value).plus(self.low);
        let below = value.plus(rest.minus(self.error)).equals(value);
        let above = value.plus(rest.plus(self.error)).equals(value);
        (value, V::both(V::both(below, above), self.valid))
    }
}

/// The next floats below and above, for normal numbers that are not the least; see `raised` of the
/// basic operations for the proof.
#[inline(always)]
pub(super) fn neighbours<V: Wide>(x: V) -> (V, V) {
    let (size, step) = (x.abs(), V::splat(STEP));
    (size.times_from(step, x), size.times_plus(step, x))
}

/// Adding this number to a float below `2^51` rounds it to an integer, which then stands in the
/// lowest bits.
pub(super) const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// The sum and its error. Required: `|a| >= |b|`, or `a = 0`.
#[inline(always)]
pub(super) fn fast_sum<V: Wide>(a: V, b: V) -> (V, V) {
    let sum = a.plus(b);
    (sum, a.minus(sum).plus(b))
}
