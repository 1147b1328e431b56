//! Decimal text of floats and intervals, rounded outward exactly.

use std::fmt;

use num_bigint::BigUint;
use num_integer::Integer;
use num_traits::{One, Zero};

use crate::{Decimal, Interval};

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

/// Both ends for people: rounded outward, with the fewest digits (3 to 15) that widen the interval by
/// at most 2 %.
///
/// *Guarantee*: the real numbers spelled enclose the interval. Where 15 digits widen it by more (ends
/// that agree in all of them), these are given. Ends are spelled as by [`lower`] and [`upper`].
///
/// ```
/// use veribound_interval::{Interval, text};
/// let bounds = Interval::new(199.99121, 200.01509).unwrap();
/// assert_eq!(text::readable(bounds), ("199.9912".to_string(), "200.0151".to_string()));
/// ```
pub fn readable(bounds: Interval) -> (String, String) {
    let allowed = bounds.width() * 1.02;
    let ends = |digits| (lower(bounds.lo(), digits), upper(bounds.hi(), digits));
    // Infinite ends are no decimals: no number of digits makes their interval narrower.
    let fits = |(lo, hi): &(String, String)| {
        enclosure(lo)
            .zip(enclosure(hi))
            .is_none_or(|(lo, hi)| lo.hull(hi).width() <= allowed)
    };
    (3..MOST_DIGITS)
        .map(ends)
        .find(fits)
        .unwrap_or_else(|| ends(MOST_DIGITS))
}

/// Both ends for people, rounded inward: of what is proved to be reached, as [`readable`] is of what is
/// proved to hold all. As few digits (3 to 15) as narrow the interval by at most 2 %.
///
/// *Guarantee*: the interval of the real numbers spelled lies inside `bounds`, and the first is not above
/// the second. Where 15 digits narrow it by more, these are given; `None` where no decimals of 15 digits
/// lie inside.
///
/// ```
/// use veribound_interval::{Interval, text};
/// let bounds = Interval::new(199.99121, 200.01509).unwrap();
/// assert_eq!(text::readable_inside(bounds), Some(("199.9913".to_string(), "200.015".to_string())));
/// ```
pub fn readable_inside(bounds: Interval) -> Option<(String, String)> {
    let mut widest = None;
    for digits in 3..=MOST_DIGITS {
        let (lo, hi) = (upper(bounds.lo(), digits), lower(bounds.hi(), digits));
        let ends = Decimal::parse(&lo).ok().zip(Decimal::parse(&hi).ok());
        let Some((from, to)) = ends.filter(|(from, to)| from <= to) else {
            continue;
        };
        widest = Some((lo, hi));
        if (&to - &from).to_interval().lo() * 1.02 >= bounds.width() {
            break;
        }
    }
    widest
}

/// The decimal that is exactly the float `x`; `-inf`, `inf` and `nan` as by [`lower`].
///
/// *Cost*: a float near 1 may need 53 digits, a tiny one some hundreds.
///
/// ```
/// assert_eq!(veribound_interval::text::exact(-3.025), "-3.024999999999999911182158029987476766109466552734375");
/// ```
pub fn exact(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return directed(x, 1, false);
    }
    let (m, e) = binary(x.abs());
    let zeros = m.trailing_zeros();
    let (m, e) = (m >> zeros, e + i64::from(zeros));
    // m 2^e = m 5^-e 10^e.
    let (digits, exponent) = if e < 0 {
        (BigUint::from(5_u32).pow(e.unsigned_abs() as u32) * m, e)
    } else {
        (BigUint::from(m) << e as u64, 0)
    };
    spell(x < 0.0, &digits.to_str_radix(10), exponent)
}

/// The ends of the interval that a user wrote as two decimals and that was read as `read`.
///
/// `[-6, -0.05]` is held as floats a little outside; printing these outward would show
/// -0.0499999999999 where the user knows -0.05. Decimals of at most 15 digits are farther apart than
/// floats, so at most one of them is read as a given end; and the model reader widens every end
/// with more digits to one of 15, so the end that is found is the user's (or lies outside of it).
/// Where no short decimal is read as the end, it is rounded outward.
pub fn spelled(read: Interval) -> (String, String) {
    // Below the normal floats the argument fails; there the ends are rounded outward.
    let short = |x: f64| {
        1..=(if x == 0.0 || x.abs() > 1e-290 {
            MOST_DIGITS
        } else {
            0
        })
    };
    let lo = short(read.lo()).map(|digits| upper(read.lo(), digits));
    let lo = lo.filter(|text| enclosure(text).is_some_and(|end| end.lo() == read.lo()));
    let hi = short(read.hi()).map(|digits| lower(read.hi(), digits));
    let hi = hi.filter(|text| enclosure(text).is_some_and(|end| end.hi() == read.hi()));
    let (mut lo, mut hi) = (lo, hi);
    (
        lo.next().unwrap_or_else(|| lower(read.lo(), MOST_DIGITS)),
        hi.next().unwrap_or_else(|| upper(read.hi(), MOST_DIGITS)),
    )
}

/// `printed`, the ends of what is proved to lie in `bounds` and, by the user's word, in the prior read
/// as `prior`: an end at which nothing was cut off the prior becomes the prior's own, as [`spelled`].
pub fn inside_prior(
    printed: (String, String),
    bounds: Interval,
    prior: Interval,
) -> (String, String) {
    let (mut lo, mut hi) = printed;
    let (prior_lo, prior_hi) = spelled(prior);
    if bounds.lo() == prior.lo() {
        lo = prior_lo;
    }
    if bounds.hi() == prior.hi() {
        hi = prior_hi;
    }
    (lo, hi)
}

fn enclosure(text: &str) -> Option<Interval> {
    Some(Decimal::parse(text).ok()?.to_interval())
}

/// Digits with which every bound can be printed well enough for people, and the most for which decimals
/// are farther apart than floats: [`spelled`] finds again what has no more.
pub const MOST_DIGITS: usize = 15;

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
    let (m, e) = binary(x);
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

/// `m` and `e` with `x = m 2^e`, of a float from 0 on.
fn binary(x: f64) -> (u64, i64) {
    let bits = x.to_bits();
    let biased = (bits >> 52) as i64;
    let fraction = bits & ((1 << 52) - 1);
    if biased == 0 {
        (fraction, -1074)
    } else {
        (fraction | (1 << 52), biased - 1075)
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

#[cfg(test)]
mod tests {
    use super::*;

    fn show(lo: f64, hi: f64) -> String {
        let (lo, hi) = readable(Interval::new(lo, hi).unwrap());
        format!("{lo} {hi}")
    }

    #[test]
    fn few_digits_where_they_tell_enough() {
        assert_eq!(show(-2.652_81, -1.537_49), "-2.66 -1.53");
        assert_eq!(show(199.991_21, 200.015_09), "199.9912 200.0151");
        assert_eq!(show(0.149_575, 0.150_276), "0.14957 0.15028");
        assert_eq!(show(0.0, 0.0), "0 0");
        assert_eq!(show(0.0, 0.25), "0 0.25");
        assert_eq!(show(f64::NEG_INFINITY, 1.0), "-inf 1");
    }

    #[test]
    fn readable_ends_enclose_and_hardly_widen() {
        let mut state = 1_u64;
        for case in 0..20_000_u32 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            let mid = (state >> 11) as f64 / (1_u64 << 50) as f64 - 4.0;
            // Down to widths of a few floats, where 15 digits are too few.
            let width = 10_f64.powi(-((case % 17) as i32));
            let x = Interval::new(mid, mid + width).unwrap();
            let (lo, hi) = readable(x);
            let spelled = |text: &str| Decimal::parse(text).unwrap().to_interval();
            let (below, above) = (spelled(&lo), spelled(&hi));
            assert!(below.lo() <= x.lo() && x.hi() <= above.hi(), "{lo} {hi}");
            let shown = below.hull(above);
            assert!(
                case % 17 > 11 || shown.width() <= 1.02 * x.width(),
                "{lo} {hi}"
            );
        }
    }

    #[test]
    fn readable_ends_inside_stay_inside_and_hardly_narrow() {
        let decimal = |text: &str| Decimal::parse(text).unwrap();
        let exactly = |x: f64| decimal(&exact(x));
        let mut state = 1_u64;
        for case in 0..20_000_u32 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            let mid = (state >> 11) as f64 / (1_u64 << 50) as f64 - 4.0;
            let width = 10_f64.powi(-((case % 18) as i32));
            let x = Interval::new(mid, mid + width).unwrap();
            let Some((lo, hi)) = readable_inside(x) else {
                assert!(case % 18 > 12, "nothing of {mid} + {width}");
                continue;
            };
            let (lo, hi) = (decimal(&lo), decimal(&hi));
            assert!(exactly(x.lo()) <= lo && lo <= hi && hi <= exactly(x.hi()));
            let shown = (&hi - &lo).to_interval().hi();
            assert!(case % 18 > 11 || shown * 1.021 >= x.width(), "{lo} {hi}");
        }
    }

    #[test]
    fn what_is_reached_at_one_point() {
        let of = |lo, hi| readable_inside(Interval::new(lo, hi).unwrap());
        assert_eq!(of(0.5, 0.5), Some(("0.5".to_owned(), "0.5".to_owned())));
        assert_eq!(of(0.1, 0.1), None);
        assert_eq!(of(0.0, 0.25), Some(("0".to_owned(), "0.25".to_owned())));
        assert_eq!(readable_inside(Interval::ENTIRE), None);
    }

    #[test]
    fn an_exact_decimal_is_read_as_its_float_and_nothing_is_between() {
        let mut state = 3_u64;
        let odd = [5e-324, f64::MAX, f64::MIN_POSITIVE, 0.1, 1e22, 1e23, 0.0];
        let random = std::iter::repeat_with(|| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            f64::from_bits(state)
        });
        let finite = random.filter(|x| x.is_finite()).take(300);
        for x in odd.into_iter().chain(finite) {
            let text = exact(x);
            assert_eq!(text.parse::<f64>(), Ok(x), "{text}");
            let read = Decimal::parse(&text).unwrap().to_interval();
            assert_eq!((read.lo(), read.hi()), (x, x), "{text}");
        }
        assert_eq!(exact(f64::NEG_INFINITY), "-inf");
        assert_eq!(exact(-1024.0), "-1024");
    }
}
