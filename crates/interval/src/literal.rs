//! Reading numbers and intervals as IEEE 1788 writes them, exactly.

use std::fmt;
use std::str::FromStr;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Zero};

use crate::{Decimal, DecimalError, Interval, rational_to_interval};

/// More hexadecimal digits and larger binary exponents are refused, as decimal ones are.
const LIMIT: usize = 10_000;

/// Why a text is not a number or an interval.
///
/// ```
/// use veribound_interval::{LiteralError, literal};
///
/// assert_eq!(literal::number("1/0"), Err(LiteralError::ZeroDenominator));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LiteralError {
    /// A part of the text that should be a number is none.
    Number {
        /// That part.
        text: String,
        /// What is wrong with it, with places counted from its start.
        reason: DecimalError,
    },
    /// A fraction over 0.
    ZeroDenominator,
    /// The lower end is above the upper end, or both are the same infinity.
    Order,
    /// Neither in brackets, nor a number with a question mark.
    Shape,
}

impl fmt::Display for LiteralError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            LiteralError::Number { text, reason } => {
                write!(f, "'{}' is no number: {reason}", text.escape_debug())
            }
            LiteralError::ZeroDenominator => write!(f, "the fraction has the denominator 0"),
            LiteralError::Order => write!(f, "the lower end is not below the upper end"),
            LiteralError::Shape => write!(
                f,
                "an interval is written as [1, 2], [0.1], [empty], [entire] or 5.3?2"
            ),
        }
    }
}

impl std::error::Error for LiteralError {}

/// The number that a text spells: a decimal (`-0.1e3`), a fraction of decimals (`1/3`) or a hexadecimal
/// float (`0x1.8p-3`, the exponent to base 2 may be missing). No blanks.
///
/// *Guarantee*: the exact number; nothing is rounded.
///
/// *Errors*: [`LiteralError`]; also for more than 10 000 digits or larger exponents.
pub fn number(text: &str) -> Result<BigRational, LiteralError> {
    if let Some((top, bottom)) = text.split_once('/') {
        let (top, bottom) = (decimal(top)?, decimal(bottom)?);
        if bottom.is_zero() {
            return Err(LiteralError::ZeroDenominator);
        }
        return Ok(top / bottom);
    }
    let unsigned = text.trim_start_matches(['+', '-']);
    if unsigned.len() + 1 >= text.len() && matches!(unsigned.get(..2), Some("0x" | "0X")) {
        return hexadecimal(text).map_err(|reason| no_number(text, reason));
    }
    decimal(text)
}

fn no_number(text: &str, reason: DecimalError) -> LiteralError {
    LiteralError::Number {
        text: text.to_string(),
        reason,
    }
}

fn decimal(text: &str) -> Result<BigRational, LiteralError> {
    match Decimal::parse(text) {
        Ok(decimal) => Ok(decimal.to_rational()),
        Err(reason) => Err(no_number(text, reason)),
    }
}

/// An optional sign, `0x`, hexadecimal digits with at most one point, an optional exponent `p`.
fn hexadecimal(text: &str) -> Result<BigRational, DecimalError> {
    let bytes = text.as_bytes();
    let byte = |at: usize| bytes.get(at).copied();
    let negative = byte(0) == Some(b'-');
    let mut at = 2 + usize::from(matches!(byte(0), Some(b'+' | b'-')));
    let (mut digits, mut after_point, mut point) = (Vec::new(), 0_i64, false);
    loop {
        match byte(at) {
            Some(digit) if digit.is_ascii_hexdigit() => {
                digits.push(digit);
                after_point += i64::from(point);
            }
            Some(b'.') if !point => point = true,
            _ => break,
        }
        at += 1;
    }
    let fault = |at: usize| match text.get(at..).and_then(|rest| rest.chars().next()) {
        Some(found) => DecimalError::UnexpectedCharacter { found, at },
        None => DecimalError::MissingDigits { at },
    };
    if digits.is_empty() {
        return Err(fault(at));
    }
    let mut exponent = 0_i64;
    if matches!(byte(at), Some(b'p' | b'P')) {
        at += 1;
        let minus = byte(at) == Some(b'-');
        at += usize::from(matches!(byte(at), Some(b'+' | b'-')));
        let first = at;
        while let Some(digit @ b'0'..=b'9') = byte(at) {
            exponent = (exponent * 10 + i64::from(digit - b'0')).min(1_000_000);
            at += 1;
        }
        if at == first {
            return Err(fault(at));
        }
        exponent = if minus { -exponent } else { exponent };
    }
    if at < bytes.len() {
        return Err(fault(at));
    }
    if digits.len() > LIMIT || exponent.unsigned_abs() > LIMIT as u64 {
        return Err(DecimalError::TooLarge);
    }
    let exponent = exponent - 4 * after_point;
    // Only hexadecimal digits have been collected.
    let whole = BigInt::parse_bytes(&digits, 16).unwrap_or_default();
    let signed = if negative { -whole } else { whole };
    let power = BigInt::one() << exponent.unsigned_abs();
    Ok(if exponent < 0 {
        BigRational::new(signed, power)
    } else {
        BigRational::from_integer(signed * power)
    })
}

impl FromStr for Interval {
    type Err = LiteralError;

    /// Reads an interval literal of IEEE 1788, upper and lower case alike:
    ///
    /// - `[1, 2]`, `[1/3, 0x1.8p1]`: two numbers as in [`number`]; a missing one or `inf` is no bound;
    /// - `[0.1]`: one number; `[empty]` and `[]`; `[entire]` and `[,]`;
    /// - `5.3?2`: two units of the last digit around the decimal (half a unit if the count is missing, no
    ///   bound for a second `?`), only upward or downward with `u` or `d` behind, times a power of ten
    ///   with `e-3` behind that.
    ///
    /// Not read: decorations (`_com`), which there are none of here.
    ///
    /// *Guarantee*: the result is the smallest interval with the numbers meant, which are compared and
    /// added exactly.
    ///
    /// *Errors*: [`LiteralError`].
    ///
    /// ```
    /// use veribound_interval::Interval;
    /// let third: Interval = "[1/3]".parse().unwrap();
    /// assert!(third.lo() < third.hi() && third.lo().next_up() == third.hi());
    /// ```
    fn from_str(text: &str) -> Result<Interval, LiteralError> {
        let text = text.trim().to_ascii_lowercase();
        let Some(inside) = text.strip_prefix('[') else {
            return uncertain(&text);
        };
        let inside = inside.strip_suffix(']').ok_or(LiteralError::Shape)?.trim();
        match inside {
            "" | "empty" => return Ok(Interval::EMPTY),
            "entire" => return Ok(Interval::ENTIRE),
            _ => {}
        }
        let Some((lower, upper)) = inside.split_once(',') else {
            return Ok(rational_to_interval(&number(inside)?));
        };
        // A missing number, or the infinity on its own side, is no bound.
        let end = |text: &str, sides: &[&str]| {
            let size = sides.iter().find_map(|side| text.strip_prefix(side));
            match size.unwrap_or(text) {
                "" | "inf" | "infinity" if size.is_some() || text.is_empty() => Ok(None),
                _ => number(text).map(Some),
            }
        };
        let lower = end(lower.trim(), &["-"])?;
        let upper = end(upper.trim(), &["+", ""])?;
        between(lower, upper)
    }
}

/// The smallest interval from one number to another; `None` is no bound.
fn between(
    lower: Option<BigRational>,
    upper: Option<BigRational>,
) -> Result<Interval, LiteralError> {
    if let (Some(lower), Some(upper)) = (&lower, &upper)
        && lower > upper
    {
        return Err(LiteralError::Order);
    }
    let lo = lower.map_or(f64::NEG_INFINITY, |x| rational_to_interval(&x).lo());
    let hi = upper.map_or(f64::INFINITY, |x| rational_to_interval(&x).hi());
    Ok(Interval::raw(lo, hi))
}

/// `5.3?2ue1`: a decimal without exponent, a question mark, then as [`Interval::from_str`] says.
fn uncertain(text: &str) -> Result<Interval, LiteralError> {
    let (middle, rest) = text.split_once('?').ok_or(LiteralError::Shape)?;
    if middle.contains('e') {
        return Err(LiteralError::Shape);
    }
    let digits = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let (count, rest) = rest.split_at(digits);
    let (unbounded, rest) = match rest.strip_prefix('?') {
        Some(rest) if count.is_empty() => (true, rest),
        _ => (false, rest),
    };
    let (down, up, rest) = match (rest.strip_prefix('d'), rest.strip_prefix('u')) {
        (Some(rest), _) => (true, false, rest),
        (_, Some(rest)) => (false, true, rest),
        _ => (true, true, rest),
    };
    let scale = match rest {
        "" => decimal("1")?,
        _ if rest.starts_with('e') => decimal(&format!("1{rest}"))?,
        _ => return Err(LiteralError::Shape),
    };
    let places = middle.split_once('.').map_or(0, |(_, after)| after.len());
    let unit = decimal(&format!("1e-{places}"))?;
    let count = match count {
        "" => decimal("0.5")?,
        _ => decimal(count)?,
    };
    let (middle, radius) = (decimal(middle)? * &scale, count * unit * scale);
    let end = |open: bool, moved: BigRational| match (open, unbounded) {
        (false, _) => Some(middle.clone()),
        (true, true) => None,
        (true, false) => Some(moved),
    };
    between(end(down, &middle - &radius), end(up, &middle + &radius))
}
