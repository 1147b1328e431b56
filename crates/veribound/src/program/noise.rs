//! Bounded pseudo-random errors, and decimals with a fixed number of places.

use std::fmt;
use veribound_interval::{Decimal, Interval};

/// A repeatable source of errors: SplitMix64 (Steele, Lea, Flood 2014), the same numbers for the same
/// seed on every machine.
#[derive(Debug, Clone)]
pub struct Noise {
    state: u64,
    decimals: usize,
}

/// A number as it is written in a record.
#[derive(Debug, Clone, PartialEq)]
pub struct Written {
    text: String,
    exact: Interval,
}

impl Noise {
    /// Errors of the given seed, written with `decimals` places.
    pub fn new(seed: u64, decimals: usize) -> Noise {
        Noise {
            state: seed,
            decimals,
        }
    }

    /// Places after the point.
    pub fn decimals(&self) -> usize {
        self.decimals
    }

    /// More than the largest change that writing with so many decimals makes. Half a unit of the last
    /// place is what it makes in decimals; the tenth above it is for the float that is written.
    pub fn rounding(&self) -> f64 {
        0.55 * 10_f64.powi(-(self.decimals as i32))
    }

    /// A number in [-1, 1].
    pub fn share(&mut self) -> f64 {
        // 53 bits fill a float.
        let unit = (self.next() >> 11) as f64 / (1_u64 << 53) as f64;
        2.0 * unit - 1.0
    }

    /// -1 or 1.
    pub fn sign(&mut self) -> f64 {
        if self.next() >> 63 == 0 { 1.0 } else { -1.0 }
    }

    fn next(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A decimal near `value`. What is proved of it is proved of the text, so nothing hangs on how
    /// well the float is rounded.
    pub fn write(&self, value: f64) -> Written {
        let text = format!("{value:.*}", self.decimals);
        let text = if text.trim_matches(['-', '0', '.']).is_empty() {
            text.trim_start_matches('-').to_owned()
        } else {
            text
        };
        let exact = Decimal::parse(&text).map_or(Interval::ENTIRE, |number| number.to_interval());
        Written { text, exact }
    }
}

impl Written {
    /// The smallest interval that contains the decimal.
    pub fn exact(&self) -> Interval {
        self.exact
    }
}

impl fmt::Display for Written {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_are_those_of_the_published_generator() {
        let mut noise = Noise::new(1_234_567, 4);
        let expected = [6_457_827_717_110_365_317, 3_203_168_211_198_807_973];
        assert_eq!([noise.next(), noise.next()], expected);
    }

    #[test]
    fn shares_fill_their_range() {
        let mut noise = Noise::new(1, 4);
        let shares: Vec<f64> = (0..1000).map(|_| noise.share()).collect();
        assert!(shares.iter().all(|x| (-1.0..=1.0).contains(x)));
        assert!(shares.iter().any(|x| *x > 0.99) && shares.iter().any(|x| *x < -0.99));
        assert!((0..100).all(|_| noise.sign().abs() == 1.0));
    }

    #[test]
    fn what_is_written_is_near() {
        let noise = Noise::new(1, 4);
        for value in [0.0, -0.00001, 1.23456, -155.55555, 1e9 + 0.1] {
            let written = noise.write(value);
            assert!((written.exact() - Interval::point(value)).mag() <= noise.rounding());
            assert!(!written.to_string().starts_with("-0.0000"), "{written}");
        }
    }
}
