//! Bounds as decimal text that does not cut anything off.

use veribound_interval::{Interval, text};

/// Significant digits of printed bounds.
pub(crate) const DIGITS: usize = 12;

/// A decimal that is not above the lower bound.
pub(crate) fn lower(bounds: Interval) -> String {
    text::lower(bounds.lo(), DIGITS)
}

/// A decimal that is not below the upper bound.
pub(crate) fn upper(bounds: Interval) -> String {
    text::upper(bounds.hi(), DIGITS)
}

/// Bounds of what is proved to lie in `bounds` and, by the user's word, in the prior read as `prior`.
///
/// An end at which nothing was cut off the prior is the prior's own, as the user spelled it.
pub(crate) fn inside_prior(bounds: Interval, prior: Interval) -> (String, String) {
    text::inside_prior((lower(bounds), upper(bounds)), bounds, prior)
}

#[cfg(test)]
mod tests {
    use super::*;
    use veribound_interval::{Decimal, text::spelled};

    fn decimal(text: &str) -> Decimal {
        Decimal::parse(text).unwrap()
    }

    #[test]
    fn printed_bounds_contain_the_interval() {
        let mut x = 1.0e-3_f64;
        for step in 0..2000_u32 {
            x = (x * 1.37 + f64::from(step % 7) * 0.1).rem_euclid(1.0e4) - 500.0;
            let bounds = Interval::new(x, x + 1.0 / 3.0).unwrap();
            let exact = |x: f64| veribound_interval_exact(x);
            assert!(decimal(&lower(bounds)).to_rational() <= exact(bounds.lo()));
            assert!(decimal(&upper(bounds)).to_rational() >= exact(bounds.hi()));
        }
    }

    /// The float as a fraction, from its bits.
    fn veribound_interval_exact(x: f64) -> num_rational::BigRational {
        num_rational::BigRational::from_float(x).unwrap()
    }

    #[test]
    fn what_the_user_wrote_is_printed_as_it_was_written() {
        for (lo, hi) in [
            ("-6", "-0.05"),
            ("0.08", "0.35"),
            ("100", "400"),
            ("-1e-9", "1.23456789012345"),
        ] {
            let read = decimal(lo).to_interval().hull(decimal(hi).to_interval());
            let (printed_lo, printed_hi) = spelled(read);
            assert_eq!(decimal(&printed_lo), decimal(lo));
            assert_eq!(decimal(&printed_hi), decimal(hi));
        }
    }

    #[test]
    fn ends_that_nobody_wrote_are_printed_outward() {
        let third = Interval::ONE / Interval::point(3.0);
        let (lo, hi) = spelled(third);
        assert_eq!(
            (lo.as_str(), hi.as_str()),
            ("0.333333333333333", "0.333333333333334")
        );
    }

    #[test]
    fn an_end_of_the_prior_stays_the_end_of_the_prior() {
        let prior = decimal("-6")
            .to_interval()
            .hull(decimal("-0.05").to_interval());
        let cut = Interval::new(-2.5, prior.hi()).unwrap();
        assert_eq!(
            inside_prior(cut, prior),
            ("-2.5".to_owned(), "-0.05".to_owned())
        );
        assert_eq!(inside_prior(Interval::ENTIRE, prior).0, "-inf");
    }
}
