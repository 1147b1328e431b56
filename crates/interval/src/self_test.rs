//! A check of the floating-point environment, to be run once when a program starts.

use std::fmt;
use std::hint::black_box;

use crate::round;

/// The property of the arithmetic that every proof here relies on and that does not hold.
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

    let known = core_math::exp(black_box(1.0)).to_bits() == 0x4005_bf0a_8b14_5769
        && core_math::log(black_box(2.0)).to_bits() == 0x3fe6_2e42_fefa_39ef
        && core_math::atan(black_box(1.0)).to_bits() == 0x3fe9_21fb_5444_2d18
        && core_math::sin(black_box(std::f64::consts::PI)).to_bits() == 0x3ca1_a626_3314_5c07;
    if known {
        Ok(())
    } else {
        Err(SelfTestError::ElementaryFunctionWrong)
    }
}
