//! Numbers as the reals they spell.

use crate::syntax::Problem;
use std::ops::Range;
use veribound_interval::Decimal;

/// Digits and exponents beyond this are refused: an f64 ends at 1e308 and starts at 5e-324, and the
/// exact value of `1e999999999` would fill the memory.
const LARGEST_EXPONENT: i64 = 400;
const MOST_DIGITS: usize = 400;

/// The number that `raw` (found at `range`) spells, exactly. Underscores between digits are allowed
/// as in TOML.
///
/// # Errors
/// Other forms (hexadecimal, infinite, not a number) and numbers too long to be meant.
pub(crate) fn decimal(raw: &str, range: Range<usize>) -> Result<Decimal, Problem> {
    let plain = raw.replace('_', "");
    let unsigned = plain.trim_start_matches(['+', '-']);
    let refuse = |message: String, help: &str| {
        Err(Problem::new(
            "E0108",
            message,
            range.clone(),
            "not a decimal number",
            help,
        ))
    };
    if unsigned.eq_ignore_ascii_case("inf") {
        return refuse("a number is infinite".into(), "write a finite number");
    }
    if unsigned.eq_ignore_ascii_case("nan") {
        return refuse(
            "a number is NaN, which is no number".into(),
            "write a finite number",
        );
    }
    if unsigned.starts_with("0x") || unsigned.starts_with("0o") || unsigned.starts_with("0b") {
        return refuse(
            format!("`{raw}` is not written as a decimal number"),
            "write it with decimal digits",
        );
    }
    let exponent = match plain.split_once(['e', 'E']) {
        Some((_, exponent)) => exponent.parse::<i64>().unwrap_or(i64::MAX),
        None => 0,
    };
    if plain.len() > MOST_DIGITS || exponent.unsigned_abs() > LARGEST_EXPONENT as u64 {
        return Err(Problem::new(
            "E0108",
            "a number is too long or too far from one",
            range.clone(),
            "cannot be used",
            format!("write at most {MOST_DIGITS} digits and exponents up to {LARGEST_EXPONENT}"),
        ));
    }
    match Decimal::parse(&plain) {
        Ok(decimal) => Ok(decimal),
        Err(_) => refuse(
            format!("`{raw}` is not a decimal number"),
            "write digits, as in 2.5 or 1e-3",
        ),
    }
}
