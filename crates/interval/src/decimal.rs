//! Exact decimal numbers: what a file spells is what is meant.

mod parse;

use std::cmp::Ordering;
use std::fmt;
use std::ops::{Add, Neg, Sub};

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

use crate::Interval;
use crate::round::{div_down, div_up, from_scaled, mul_down, mul_up};

pub use parse::DecimalError;

/// An exact decimal number `coefficient * 10^exponent`.
///
/// Equal numbers are equal however they are spelled. ([`Decimal::parse`] `"0.10"` and `"1e-1"`.)
///
/// ```
/// use veribound_interval::Decimal;
/// let tenth = Decimal::parse("0.1").unwrap();
/// let enclosure = tenth.to_interval();
/// assert!(enclosure.lo() < enclosure.hi()); // 0.1 is not a float
/// ```
#[derive(Clone, Debug)]
pub struct Decimal {
    coefficient: BigInt,
    exponent: i32,
}

impl Decimal {
    /// The number 0.
    pub fn zero() -> Decimal {
        Decimal::from_i64(0)
    }

    /// A whole number, exactly.
    pub fn from_i64(value: i64) -> Decimal {
        Decimal {
            coefficient: BigInt::from(value),
            exponent: 0,
        }
    }

    /// The smallest interval with this number: a point if it is a float, else two neighbours.
    pub fn to_interval(&self) -> Interval {
        // Short way for the usual number: a coefficient below 2^53 and a power of ten up to 10^22 are
        // floats, so one tight directed operation gives the tight bounds.
        if let (Some(whole), Some(power)) = (
            self.coefficient.to_i64(),
            exact_power(self.exponent.unsigned_abs()),
        ) && whole.unsigned_abs() <= 1 << 53
        {
            let whole = whole as f64;
            return if self.exponent < 0 {
                Interval::raw(div_down(whole, power), div_up(whole, power))
            } else {
                Interval::raw(mul_down(whole, power), mul_up(whole, power))
            };
        }
        let power = BigInt::from(10).pow(self.exponent.unsigned_abs());
        if self.exponent < 0 {
            fraction_to_interval(&self.coefficient, &power)
        } else {
            fraction_to_interval(&(&self.coefficient * power), &BigInt::one())
        }
    }

    /// The number as a reduced fraction.
    pub fn to_rational(&self) -> BigRational {
        let power = BigInt::from(10).pow(self.exponent.unsigned_abs());
        if self.exponent < 0 {
            BigRational::new(self.coefficient.clone(), power)
        } else {
            BigRational::from_integer(&self.coefficient * power)
        }
    }

    /// True for a number below 0.
    pub fn is_negative(&self) -> bool {
        self.coefficient.is_negative()
    }

    /// True for the number 0.
    pub fn is_zero(&self) -> bool {
        self.coefficient.is_zero()
    }

    /// Both coefficients over the smaller of the two exponents.
    fn aligned(&self, other: &Decimal) -> (BigInt, BigInt, i32) {
        let exponent = self.exponent.min(other.exponent);
        let scaled = |x: &Decimal| match x.exponent.abs_diff(exponent) {
            0 => x.coefficient.clone(),
            more => &x.coefficient * BigInt::from(10).pow(more),
        };
        (scaled(self), scaled(other), exponent)
    }
}

/// `10^n` where it is a float, which holds up to `n = 22`.
pub(crate) fn exact_power(n: u32) -> Option<f64> {
    const POWERS: [f64; 23] = [
        1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
        1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
    ];
    POWERS.get(n as usize).copied()
}

/// The smallest interval with a rational number.
pub fn rational_to_interval(number: &BigRational) -> Interval {
    fraction_to_interval(number.numer(), number.denom())
}

/// The smallest interval with `numerator / denominator`, for a positive denominator.
///
/// The quotient is taken with 66 to 68 bits, the remainder only says whether there is more.
fn fraction_to_interval(numerator: &BigInt, denominator: &BigInt) -> Interval {
    if numerator.is_zero() {
        return Interval::ZERO;
    }
    let (top, bottom) = (numerator.magnitude(), denominator.magnitude());
    let shift = 67 + bottom.bits() as i64 - top.bits() as i64;
    let (top, bottom) = if shift >= 0 {
        (top << shift as u64, bottom.clone())
    } else {
        (top.clone(), bottom << shift.unsigned_abs())
    };
    let quotient = &top / &bottom;
    let more = &quotient * &bottom != top;
    let Some(quotient) = quotient.to_u128() else {
        return Interval::ENTIRE;
    };
    let bound = |up| from_scaled(numerator.is_negative(), quotient, -shift, more, up);
    Interval::raw(bound(false), bound(true))
}

impl PartialEq for Decimal {
    fn eq(&self, other: &Decimal) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Decimal {}

impl PartialOrd for Decimal {
    fn partial_cmp(&self, other: &Decimal) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Decimal {
    fn cmp(&self, other: &Decimal) -> Ordering {
        let (a, b, _) = self.aligned(other);
        a.cmp(&b)
    }
}

impl Add for &Decimal {
    type Output = Decimal;

    fn add(self, other: &Decimal) -> Decimal {
        let (a, b, exponent) = self.aligned(other);
        Decimal {
            coefficient: a + b,
            exponent,
        }
    }
}

impl Sub for &Decimal {
    type Output = Decimal;

    fn sub(self, other: &Decimal) -> Decimal {
        let (a, b, exponent) = self.aligned(other);
        Decimal {
            coefficient: a - b,
            exponent,
        }
    }
}

impl Neg for &Decimal {
    type Output = Decimal;

    fn neg(self) -> Decimal {
        Decimal {
            coefficient: -&self.coefficient,
            exponent: self.exponent,
        }
    }
}

impl fmt::Display for Decimal {
    /// The exact number: plain digits where that is short, else digits with an exponent.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let digits = self.coefficient.magnitude().to_str_radix(10);
        f.write_str(&crate::text::spell(
            self.coefficient.is_negative(),
            &digits,
            i64::from(self.exponent),
        ))
    }
}
