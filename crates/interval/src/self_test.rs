//! A check of the floating-point environment, to be run once when a program starts.

use std::fmt;
use std::hint::black_box;

use crate::round;

/// The property of the arithmetic that every proof here relies on and that does not hold.
///
/// ```
/// use veribound_interval::{SelfTestError, self_test};
///
/// assert_eq!(self_test(), Ok(()));
/// assert!(!SelfTestError::NotRoundedToNearest.to_string().is_empty());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SelfTestError {
    /// Sums, products, quotients or roots are not rounded to the nearest float.
    NotRoundedToNearest,
    /// Results below the normal range are replaced by zero.
    SubnormalResultsFlushed,
    /// Operands below the normal range are read as zero.
    SubnormalOperandsFlushed,
    /// An elementary function misses a value that is known exactly.
    ElementaryFunctionWrong,
}

impl fmt::Display for SelfTestError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self {
            SelfTestError::NotRoundedToNearest => {
                "floating-point results are not rounded to nearest"
            }
            SelfTestError::SubnormalResultsFlushed => "very small results are flushed to zero",
            SelfTestError::SubnormalOperandsFlushed => "very small operands are read as zero",
            SelfTestError::ElementaryFunctionWrong => "an elementary function gives a wrong value",
        };
        write!(
            f,
            "the arithmetic of this machine cannot be trusted: {what}"
        )
    }
}

impl std::error::Error for SelfTestError {}

/// Checks that the running thread rounds to nearest, keeps subnormal numbers, and computes known
/// elementary values.
///
/// *Guarantee*: a changed rounding mode (up, down, toward zero) or a flush-to-zero or
/// denormals-are-zero mode of this thread is found. A test by example cannot prove a library right.
///
/// *Errors*: the first property that does not hold.
pub fn self_test() -> Result<(), SelfTestError> {
    let sum = |a: f64, b: f64| black_box(black_box(a) + black_box(b));
    let product = |a: f64, b: f64| black_box(black_box(a) * black_box(b));
    let quotient = |a: f64, b: f64| black_box(black_box(a) / black_box(b));
    let unit = f64::EPSILON;

    // A quarter and three quarters of a unit, of both signs: each other mode fails at least one.
    let nearest = sum(1.0, 0.25 * unit) == 1.0
        && sum(1.0, 0.75 * unit) == 1.0 + unit
        && sum(-1.0, -0.25 * unit) == -1.0
        && sum(-1.0, -0.75 * unit) == -1.0 - unit
        && sum(1.0, 0.5 * unit) == 1.0
        && product(1.0 + unit, 1.0 + unit) == 1.0 + 2.0 * unit
        && product(-1.0 - unit, 1.0 + unit) == -1.0 - 2.0 * unit
        && quotient(1.0, 3.0).to_bits() == 0x3fd5_5555_5555_5555
        && quotient(-2.0, 3.0).to_bits() == 0xbfe5_5555_5555_5555
        && black_box(black_box(2.0_f64).sqrt()).to_bits() == 0x3ff6_a09e_667f_3bcd
        && black_box(black_box(3.0_f64).sqrt()).to_bits() == 0x3ffb_b67a_e858_4caa;
    if !nearest {
        return Err(SelfTestError::NotRoundedToNearest);
    }

    let least = f64::from_bits(1);
    // The bits are looked at, since a comparison with zero may itself read the number as zero.
    if product(f64::MIN_POSITIVE, 0.5).to_bits() != 1 << 51
        || quotient(f64::MIN_POSITIVE, 4.0).to_bits() != 1 << 50
        || sum(f64::MIN_POSITIVE, -1.5 * f64::MIN_POSITIVE).to_bits() != (1 << 63) | (1 << 51)
    {
        return Err(SelfTestError::SubnormalResultsFlushed);
    }
    let large = f64::from_bits(0x7fd0_0000_0000_0000); // 2^1022
    if sum(least, f64::MIN_POSITIVE).to_bits() != (1 << 52) + 1
        || product(least, large) != f64::EPSILON
        || black_box(least) == black_box(0.0)
    {
        return Err(SelfTestError::SubnormalOperandsFlushed);
    }
    if round::mul_down(black_box(0.1), 3.0) >= round::mul_up(black_box(0.1), 3.0) {
        return Err(SelfTestError::NotRoundedToNearest);
    }

    if known_values().all(|(found, known)| black_box(found).to_bits() == known.to_bits()) {
        Ok(())
    } else {
        Err(SelfTestError::ElementaryFunctionWrong)
    }
}

/// One value of every elementary function that is called, and the float nearest to the true value.
fn known_values() -> impl Iterator<Item = (f64, f64)> {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, LN_2, LOG2_E, LOG10_2, PI, SQRT_2};
    let bits = f64::from_bits;
    let (half, one, two) = (black_box(0.5), black_box(1.0), black_box(2.0));
    [
        (core_math::exp(one), std::f64::consts::E),
        (core_math::exp2(half), SQRT_2),
        (core_math::exp10(half), black_box(10.0_f64).sqrt()),
        (core_math::expm1(one), bits(0x3ffb_7e15_1628_aed3)),
        (core_math::log(two), LN_2),
        (core_math::log2(std::f64::consts::E), LOG2_E),
        (core_math::log10(two), LOG10_2),
        (core_math::log1p(one), LN_2),
        (core_math::pow(two, half), SQRT_2),
        (core_math::cbrt(black_box(27.0)), 3.0),
        (core_math::sin(black_box(PI)), bits(0x3ca1_a626_3314_5c07)),
        (
            core_math::cos(black_box(FRAC_PI_2)),
            bits(0x3c91_a626_3314_5c07),
        ),
        (core_math::tan(black_box(FRAC_PI_4)), 1.0_f64.next_down()),
        (core_math::asin(one), FRAC_PI_2),
        (core_math::acos(-one), PI),
        (core_math::atan(one), FRAC_PI_4),
        (core_math::atan2(one, -one), 3.0 * FRAC_PI_4),
        (core_math::sinh(one), bits(0x3ff2_cd9f_c44e_b982)),
        (core_math::cosh(one), bits(0x3ff8_b075_51d9_f550)),
        (core_math::tanh(one), bits(0x3fe8_5efa_b514_f394)),
        (core_math::asinh(one), bits(0x3fec_3436_6179_d427)),
        (core_math::acosh(two), bits(0x3ff5_1242_7198_0435)),
        (core_math::atanh(half), bits(0x3fe1_93ea_7aad_030b)),
    ]
    .into_iter()
}

#[cfg(test)]
mod tests {
    #[test]
    fn every_known_value_is_found() {
        for (place, (found, known)) in super::known_values().enumerate() {
            assert_eq!(found.to_bits(), known.to_bits(), "value {place}");
        }
    }
}
