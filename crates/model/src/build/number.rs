//! Exact numbers.

use super::tree::Flaw;
use crate::syntax::number;
use veribound_interval::Decimal;

/// An exact decimal number: whole numbers, [`Decimal`]s, or text as `"0.1"`, which is a tenth.
///
/// There is no conversion from `f64`, because `0.1_f64` is not a tenth:
/// [`Number::exactly`] takes a float for the number that it holds, digit for digit. Text that spells no
/// decimal number is refused when the model is built.
///
/// ```
/// use veribound_model::build::{ModelBuilder, Number};
///
/// let mut model = ModelBuilder::new("decay");
/// let x = model.state("x").init("0.9", "1.1").symbol();
/// let k = model.param("k", 0, Number::exactly(0.5)).symbol();
/// model.der(&x, -(k * &x));
/// model.output("x_m", &x, "1e-3");
/// assert!(model.to_toml().contains("k = { bounds = [0, 0.5] }"));
///
/// // 0.1 is held as a float a little above it; that is said instead of being hidden.
/// model.param("rate", 0, Number::exactly(0.1));
/// assert!(model.to_toml().contains("[0, 0.1000000000000000055511151231257827021181583404541015625]"));
/// ```
///
/// ```compile_fail
/// let mut model = veribound_model::build::ModelBuilder::new("decay");
/// model.param("k", 0.0, 0.1); // floats are not taken
/// ```
#[derive(Debug, Clone)]
pub struct Number(pub(super) Result<Decimal, Flaw>);

impl Number {
    /// The number that `value` holds, without rounding.
    ///
    /// Infinities and NaN are refused when the model is built, and so are numbers with more than 400
    /// digits, as the smallest floats have.
    pub fn exactly(value: f64) -> Number {
        if !value.is_finite() {
            return Number(Err(Flaw::NoNumber(value.to_string())));
        }
        // The smallest float ends 1074 digits behind the point.
        let digits = format!("{value:.1074}");
        Number::from(digits.trim_end_matches('0').trim_end_matches('.'))
    }
}

impl From<&str> for Number {
    fn from(text: &str) -> Number {
        let text = text.trim();
        Number(number::decimal(text, 0..text.len()).map_err(|_| Flaw::NoNumber(text.to_string())))
    }
}

impl From<String> for Number {
    fn from(text: String) -> Number {
        Number::from(text.as_str())
    }
}

impl From<Decimal> for Number {
    fn from(decimal: Decimal) -> Number {
        Number(Ok(decimal))
    }
}

impl From<&Decimal> for Number {
    fn from(decimal: &Decimal) -> Number {
        Number(Ok(decimal.clone()))
    }
}

macro_rules! whole_numbers {
    ($($whole:ty),*) => {$(
        impl From<$whole> for Number {
            fn from(value: $whole) -> Number {
                Number::from(value.to_string())
            }
        }
    )*};
}

whole_numbers!(i32, i64, u32, u64, usize);
