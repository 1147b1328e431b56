//! Reading decimal numbers.

use std::fmt;

use num_bigint::{BigInt, BigUint, Sign};
use num_traits::Zero;

use super::Decimal;

/// Digits and exponents beyond this are refused, so that a short text cannot ask for a number that
/// fills the memory.
const LIMIT: usize = 10_000;

/// Why a text is not a decimal number. `at` counts bytes from the start of the text.
///
/// ```
/// use veribound_interval::{Decimal, DecimalError};
///
/// let wrong = Decimal::parse("1.2.3").unwrap_err();
/// assert_eq!(wrong, DecimalError::UnexpectedCharacter { found: '.', at: 3 });
/// assert_eq!(wrong.to_string(), "'.' cannot stand at character 4");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum DecimalError {
    /// The text has no character.
    Empty,
    /// The text ends where a digit must stand.
    MissingDigits {
        /// Where the digit is missing.
        at: usize,
    },
    /// A character that cannot stand here.
    UnexpectedCharacter {
        /// The character.
        found: char,
        /// Where it stands.
        at: usize,
    },
    /// More digits or a larger exponent than 10 000.
    TooLarge,
}

impl fmt::Display for DecimalError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            DecimalError::Empty => write!(f, "the number is empty"),
            DecimalError::MissingDigits { at } => {
                write!(f, "a digit is missing at character {}", at + 1)
            }
            DecimalError::UnexpectedCharacter { found, at } => {
                write!(
                    f,
                    "'{}' cannot stand at character {}",
                    found.escape_debug(),
                    at + 1
                )
            }
            DecimalError::TooLarge => {
                write!(
                    f,
                    "the number has more than {LIMIT} digits or too large an exponent"
                )
            }
        }
    }
}

impl std::error::Error for DecimalError {}

impl Decimal {
    /// Reads an optional sign, digits with at most one point (at least one digit on either side of
    /// it), and an optional exponent; nothing else, also no blanks.
    ///
    /// *Cost*: linear for up to 18 digits without a number on the heap beyond the result.
    ///
    /// *Errors*: [`DecimalError`] with the place of the first character that does not fit.
    pub fn parse(text: &str) -> Result<Decimal, DecimalError> {
        let bytes = text.as_bytes();
        if bytes.is_empty() {
            return Err(DecimalError::Empty);
        }
        let byte = |at: usize| bytes.get(at).copied();
        let mut at = 0;
        let negative = byte(0) == Some(b'-');
        if matches!(byte(0), Some(b'+' | b'-')) {
            at += 1;
        }
        let mut digits = Digits::default();
        let (mut point, mut after_point) = (false, 0_i64);
        loop {
            match byte(at) {
                Some(digit @ b'0'..=b'9') => {
                    digits.push(digit);
                    after_point += i64::from(point);
                }
                Some(b'.') if !point => point = true,
                _ => break,
            }
            at += 1;
        }
        if digits.count == 0 {
            return Err(fault(text, at));
        }
        let mut exponent = 0_i64;
        if matches!(byte(at), Some(b'e' | b'E')) {
            at += 1;
            let minus = byte(at) == Some(b'-');
            if matches!(byte(at), Some(b'+' | b'-')) {
                at += 1;
            }
            let first = at;
            while let Some(digit @ b'0'..=b'9') = byte(at) {
                exponent = (exponent * 10 + i64::from(digit - b'0')).min(1_000_000);
                at += 1;
            }
            if at == first {
                return Err(fault(text, at));
            }
            exponent = if minus { -exponent } else { exponent };
        }
        if at < bytes.len() {
            return Err(fault(text, at));
        }
        let exponent = exponent - after_point;
        if digits.count > LIMIT || exponent.unsigned_abs() > LIMIT as u64 {
            return Err(DecimalError::TooLarge);
        }
        let magnitude = digits.value();
        let sign = if negative { Sign::Minus } else { Sign::Plus };
        Ok(Decimal {
            coefficient: BigInt::from_biguint(sign, magnitude),
            exponent: exponent as i32,
        })
    }
}

/// The first place where the text stops being a number.
fn fault(text: &str, at: usize) -> DecimalError {
    match text.get(at..).and_then(|rest| rest.chars().next()) {
        Some(found) => DecimalError::UnexpectedCharacter { found, at },
        None => DecimalError::MissingDigits { at },
    }
}

/// Digits as they are read: 18 at a time in a machine word.
#[derive(Default)]
struct Digits {
    count: usize,
    word: u64,
    in_word: u32,
    rest: BigUint,
}

impl Digits {
    fn push(&mut self, digit: u8) {
        self.count += 1;
        if self.count > LIMIT {
            return;
        }
        if self.in_word == 18 {
            self.flush();
        }
        self.word = self.word * 10 + u64::from(digit - b'0');
        self.in_word += 1;
    }

    fn flush(&mut self) {
        self.rest = &self.rest * 10_u64.pow(self.in_word) + self.word;
        (self.word, self.in_word) = (0, 0);
    }

    fn value(mut self) -> BigUint {
        if self.rest.is_zero() {
            return BigUint::from(self.word);
        }
        self.flush();
        self.rest
    }
}
