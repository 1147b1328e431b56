//! Decimal text of floats and intervals, rounded outward exactly.

use std::fmt;

use num_bigint::BigUint;
use num_integer::Integer;
use num_traits::{One, Zero};

use crate::Interval;

/// A decimal text with at most `digits` significant digits that is not above `x`.
///
/// *Guarantee*: the real number spelled is `<= x`, and no number with that many digits lies between.
/// `-inf` and `inf` for infinities (`inf` does not occur as a lower end of a nonempty interval), `nan`
/// for NaN. `digits = 0` counts as 1.
///
/// ```
/// assert_eq!(veribound_interval::text::lower(0.1, 3), "0.1"); // the float is above 1/10
/// assert_eq!(veribound_interval::text::upper(0.1, 3), "0.101");
/// ```
pub fn lower(x: f64, digits: usize) -> String {
    directed(x, digits, false)
}

/// A decimal text with at most `digits` significant digits that is not below `x`; see [`lower`].
pub fn upper(x: f64, digits: usize) -> String {
    directed(x, digits, true)
}

fn directed(x: f64, digits: usize, up: bool) -> String {
    if x.is_nan() {
        return "nan".to_string();
    }
    if x.is_infinite() {
        return if x > 0.0 { "inf" } else { "-inf" }.to_string();
    }
    if x == 0.0 {
        return "0".to_string();
    }
    let negative = x < 0.0;
    let (digits, exponent) = magnitude(x.abs(), digits.max(1) as i64, up != negative);
    spell(negative, &digits, exponent)
}

/// `digits` and `exponent` with `digits * 10^exponent` next to the positive float `x`, cut to `count`
/// digits, and grown by one unit of the last digit if `away` and something was cut.
///
/// `x = m 2^e` is an exact fraction. The decimal exponent `k` of the leading digit is guessed and then
/// corrected until the cut quotient has `count` digits, so the guess needs no guarantee. A carry to
/// `10^count` is a valid spelling (the zeros are dropped later).
fn magnitude(x: f64, count: i64, away: bool) -> (String, i64) {
    let bits = x.to_bits();
    let biased = (bits >> 52) as i64;
    let fraction = bits & ((1 << 52) - 1);
    let (m, e) = if biased == 0 {
        (fraction, -1074)
    } else {
        (fraction | (1 << 52), biased - 1075)
    };
    let mut k = ((e + 64 - i64::from(m.leading_zeros()) - 1) as f64 * std::f64::consts::LOG10_2)
        .floor() as i64;
    loop {
        let scale = count - 1 - k;
        let (quotient, more) = match cut_short(m, e, scale) {
            Some((quotient, more)) => (BigUint::from(quotient), more),
            None => cut_long(m, e, scale),
        };
        let digits = quotient.to_str_radix(10);
        let length = if quotient.is_zero() {
            0
        } else {
            digits.len() as i64
        };
        match length.cmp(&count) {
            std::cmp::Ordering::Less => k -= 1,
            std::cmp::Ordering::Greater => k += 1,
            std::cmp::Ordering::Equal if away && more => {
                return ((quotient + 1_u32).to_str_radix(10), -scale);
            }
            std::cmp::Ordering::Equal => return (digits, -scale),
        }
    }
}

/// `floor(m 2^e 10^scale)` and whether something was cut, where 128 bits hold all of it:
/// `m < 2^53` and `10^22 < 2^74`.
fn cut_short(m: u64, e: i64, scale: i64) -> Option<(u128, bool)> {
    if !(0..=22).contains(&scale) || !(-127..=0).contains(&e) {
        return None;
    }
    let whole = u128::from(m) * 10_u128.pow(scale as u32);
    let quotient = whole >> -e;
    Some((quotient, quotient << -e != whole))
}

/// The same for all numbers.
fn cut_long(m: u64, e: i64, scale: i64) -> (BigUint, bool) {
    let power = BigUint::from(10_u32).pow(scale.unsigned_abs() as u32);
    let (mut top, mut bottom) = (BigUint::from(m), BigUint::one());
    if scale >= 0 {
        top *= power;
    } else {
        bottom *= power;
    }
    if e >= 0 {
        top <<= e as u64;
    } else {
        bottom <<= e.unsigned_abs();
    }
    let (quotient, rest) = top.div_rem(&bottom);
    (quotient, !rest.is_zero())
}

/// Spells `digits * 10^exponent` without closing zeros: plain where the leading digit stands between
/// 10^-5 and 10^15, with an exponent elsewhere.
pub(crate) fn spell(negative: bool, digits: &str, exponent: i64) -> String {
    let digits = digits.trim_start_matches('0');
    let short = digits.trim_end_matches('0');
    if short.is_empty() {
        return "0".to_string();
    }
    let lead = exponent + digits.len() as i64 - 1;
    let mut text = String::with_capacity(short.len() + 8);
    if negative {
        text.push('-');
    }
    let zeros = |n: i64| "0".repeat(usize::try_from(n).unwrap_or(0));
    let count = short.len() as i64;
    if !(-5..=15).contains(&lead) {
        let (first, rest) = short.split_at(1);
        text.push_str(first);
        if !rest.is_empty() {
            text.push('.');
            text.push_str(rest);
        }
        text.push_str(&format!("e{lead}"));
    } else if lead < 0 {
        text.push_str("0.");
        text.push_str(&zeros(-lead - 1));
        text.push_str(short);
    } else if count <= lead + 1 {
        text.push_str(short);
        text.push_str(&zeros(lead + 1 - count));
    } else {
        let (whole, rest) = short.split_at(lead as usize + 1);
        text.push_str(whole);
        text.push('.');
        text.push_str(rest);
    }
    text
}

impl fmt::Display for Interval {
    /// `[lower, upper]`, rounded outward to the precision in significant digits (6 if none is given);
    /// `[empty]` for the empty set.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_empty() {
            return f.write_str("[empty]");
        }
        let digits = f.precision().unwrap_or(6);
        write!(
            f,
            "[{}, {}]",
            lower(self.lo(), digits),
            upper(self.hi(), digits)
        )
    }
}
