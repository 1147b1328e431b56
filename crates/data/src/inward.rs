//! Bounds as decimal text that adds nothing: of what is proved to be reached.

use crate::outward::DIGITS;
use veribound_interval::{Decimal, Interval, text};

/// Decimals that are not below the lower and not above the upper bound, the first not above the second;
/// `None` for the empty set and where an end is infinite, which no point reaches.
///
/// Where no two decimals of the usual length lie inside, more digits are given, as many as it takes.
pub(crate) fn ends(bounds: Interval) -> Option<(String, String)> {
    if bounds.is_empty() || !bounds.is_bounded() {
        return None;
    }
    let short = [DIGITS, 17].map(|digits| {
        (
            text::upper(bounds.lo(), digits),
            text::lower(bounds.hi(), digits),
        )
    });
    let exact = (text::exact(bounds.lo()), text::exact(bounds.hi()));
    let in_order = |(lo, hi): &(String, String)| {
        let ends = Decimal::parse(lo).ok().zip(Decimal::parse(hi).ok());
        ends.is_some_and(|(lo, hi)| lo <= hi)
    };
    short.into_iter().chain([exact]).find(in_order)
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_rational::BigRational;

    #[test]
    fn printed_ends_lie_inside_the_interval() {
        let decimal = |text: &str| Decimal::parse(text).unwrap().to_rational();
        let exact = |x: f64| BigRational::from_float(x).unwrap();
        let mut x = 1.0e-3_f64;
        for step in 0..4000_i32 {
            x = (x * 1.37 + f64::from(step % 7) * 0.1).rem_euclid(1.0e4) - 500.0;
            // From thousands of floats down to none between the ends.
            let width = 10_f64.powi(-(step % 19)) * f64::from(step % 2);
            let bounds = Interval::new(x, x + width).unwrap();
            let (lo, hi) = ends(bounds).unwrap();
            let (lo, hi) = (decimal(&lo), decimal(&hi));
            assert!(exact(bounds.lo()) <= lo && lo <= hi && hi <= exact(bounds.hi()));
        }
    }

    #[test]
    fn digits_are_few_where_few_tell_it() {
        let of = |lo, hi| ends(Interval::new(lo, hi).unwrap()).unwrap();
        let text = |lo: &str, hi: &str| (lo.to_owned(), hi.to_owned());
        let third = 1.0 / 3.0;
        assert_eq!(
            of(third, 2.0 * third),
            text("0.333333333334", "0.666666666666")
        );
        assert_eq!(of(0.5, 0.5), text("0.5", "0.5"));
        let point = "0.333333333333333314829616256247390992939472198486328125";
        assert_eq!(of(third, third), text(point, point));
    }

    #[test]
    fn nothing_reaches_an_infinite_end() {
        assert_eq!(ends(Interval::ENTIRE), None);
        assert_eq!(ends(Interval::EMPTY), None);
    }
}
