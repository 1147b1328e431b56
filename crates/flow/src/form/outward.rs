//! Upper bounds of sums and products of numbers that are not negative, in plain floating point.

/// Largest relative error of one rounded operation.
pub(super) const UNIT: f64 = f64::EPSILON / 2.0;

/// Far above what underflow can take from a bound, far below anything that matters.
const TINY: f64 = 1e-290;

/// No norm may pass this, so that underflow in a factor stays below [`TINY`] in the product.
const LARGEST: f64 = 1e25;

/// An upper bound of an expression of sums and products of numbers that are not negative, given its
/// floating-point value and a bound on the number of operations between any operand and the result.
///
/// Proof. Each operation takes at most the share `u = 2^-53`, so the exact value is at most
/// `value / (1 - u)^n`, which is below `value (1 + 2 u n)` for `n u < 1/4`; the four further operations
/// counted pay for rounding this formula itself. Underflow takes at most `2^-1074` per product, and
/// what is multiplied with later is below [`LARGEST`], or the step is given up.
#[inline(always)]
pub(super) fn raised(value: f64, operations: usize) -> f64 {
    value * (1.0 + (operations + 4) as f64 * f64::EPSILON) + TINY
}

/// Upper bounds of `base^j` for `j` from 0.
pub(super) fn powers(base: f64, into: &mut [f64]) {
    let mut power = 1.0;
    for slot in into {
        *slot = power;
        power = raised(power * base, 1);
    }
}

/// True for what is too large to go on with, or no number.
pub(super) fn is_lost(x: f64) -> bool {
    x.is_nan() || x >= LARGEST
}
