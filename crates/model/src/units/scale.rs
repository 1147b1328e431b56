//! How much one unit is of another: a rational number times a power of pi, exactly.

use num_rational::{BigRational, Ratio};
use num_traits::{One, Pow, ToPrimitive};
use std::fmt;
use veribound_interval::{Decimal, Interval, rational_to_interval};

/// Numbers beyond this many bits are no scale of a unit.
const MOST_BITS: u64 = 65_536;

/// `rational * pi^pi`, never zero or negative.
///
/// Example: [`Unit`](crate::Unit).
#[derive(Debug, Clone, PartialEq)]
pub struct Scale {
    rational: BigRational,
    pi: i64,
}

impl Scale {
    pub(crate) fn new(rational: BigRational, pi: i64) -> Scale {
        Scale { rational, pi }
    }

    pub(crate) fn one() -> Scale {
        Scale::new(BigRational::one(), 0)
    }

    /// Whether it is exactly one.
    pub fn is_one(&self) -> bool {
        self.pi == 0 && self.rational.is_one()
    }

    pub(crate) fn times(&self, other: &Scale) -> Scale {
        Scale::new(&self.rational * &other.rational, self.pi + other.pi)
    }

    pub(crate) fn over(&self, other: &Scale) -> Scale {
        Scale::new(&self.rational / &other.rational, self.pi - other.pi)
    }

    /// A power; `None` when it is not a rational number times a whole power of pi, or too long.
    pub(crate) fn power(&self, power: Ratio<i64>) -> Option<Scale> {
        let pi = power * self.pi;
        let bits = self
            .rational
            .numer()
            .bits()
            .max(self.rational.denom().bits());
        let exponent = power.numer().to_i32()?;
        if !pi.is_integer() || bits.saturating_mul(power.numer().unsigned_abs()) > MOST_BITS {
            return None;
        }
        let raised = Pow::pow(&self.rational, exponent);
        let degree = power.denom().to_u32()?;
        let rational = BigRational::new(
            raised.numer().nth_root(degree),
            raised.denom().nth_root(degree),
        );
        let is_exact = Pow::pow(&rational, degree) == raised;
        is_exact.then(|| Scale::new(rational, pi.to_integer()))
    }

    /// The expression that multiplies `term` by the scale: `1000*v`, `v/60`, `pi/180*phi`.
    pub(crate) fn multiply(&self, term: &str) -> String {
        let (above, below) = self.parts();
        match (above.as_slice(), below.as_slice()) {
            ([], [one]) => format!("{term}/{one}"),
            _ => format!("{self}*{term}"),
        }
    }

    /// What stands above and below the line.
    fn parts(&self) -> (Vec<String>, Vec<String>) {
        let pi = match self.pi.abs() {
            1 => "pi".to_owned(),
            power => format!("pi^{power}"),
        };
        let side = |number: String, has_pi: bool| {
            let number = Some(number).filter(|number| number != "1");
            let pi = has_pi.then(|| pi.clone());
            number.into_iter().chain(pi).collect()
        };
        (
            side(short(self.rational.numer().to_string()), self.pi > 0),
            side(short(self.rational.denom().to_string()), self.pi < 0),
        )
    }
}

/// Long powers of ten as `1e9`.
fn short(number: String) -> String {
    let zeros = number.len().saturating_sub(1);
    if zeros >= 6 && number.starts_with('1') && number.ends_with(&"0".repeat(zeros)) {
        format!("1e{zeros}")
    } else {
        number
    }
}

impl fmt::Display for Scale {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (above, below) = self.parts();
        let above = match above.is_empty() {
            true => "1".to_owned(),
            false => above.join("*"),
        };
        match below.as_slice() {
            [] => write!(f, "{above}"),
            [one] => write!(f, "{above}/{one}"),
            many => write!(f, "{above}/({})", many.join("*")),
        }
    }
}

/// From numbers in one unit to numbers in another.
///
/// Example: [`Unit`](crate::Unit).
#[derive(Debug, Clone, PartialEq)]
pub struct Conversion {
    factor: Scale,
    /// Encloses the power of pi in the factor.
    pi: Interval,
}

impl Conversion {
    pub(crate) fn new(factor: Scale) -> Conversion {
        let power = (0..factor.pi.abs()).fold(Interval::ONE, |power, _| power * Interval::PI);
        let pi = if factor.pi.is_negative() {
            Interval::ONE / power
        } else {
            power
        };
        Conversion { factor, pi }
    }

    /// What a number is multiplied by.
    pub fn factor(&self) -> &Scale {
        &self.factor
    }

    /// An interval with the converted number in it: the smallest one for a rational factor.
    ///
    /// The rational part is multiplied exactly, so only pi and the last rounding make it wider.
    pub fn apply(&self, number: &Decimal) -> Interval {
        let exact = rational_to_interval(&(number.to_rational() * &self.factor.rational));
        if self.factor.pi == 0 {
            exact
        } else {
            exact * self.pi
        }
    }
}
