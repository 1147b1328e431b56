//! Powers of one float with 128 significant bits, in integers.

use std::cmp::Ordering;

use crate::round::{from_scaled, parts};

/// A positive number known by a lower bound: `m 2^e <= number <= m 2^e (1 + 2^-127)^cuts`.
///
/// `m` has its leading bit set (`2^127 <= m < 2^128`), and `cuts` counts how often a rest was dropped on
/// the way; with `cuts = 0` the number is `m 2^e` itself.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scaled {
    m: u128,
    e: i64,
    cuts: u64,
}

impl Scaled {
    /// A positive finite float, exactly.
    pub(super) fn of(x: f64) -> Scaled {
        let (m, e) = significand(x);
        Scaled {
            m: m << 75,
            e: e - 75,
            cuts: 0,
        }
    }

    /// The reciprocal of a positive finite float `m 2^e`.
    ///
    /// For `m = 2^52` it is a power of two. Else `2^52 < m < 2^53` gives
    /// `2^127 < floor(2^180 / m) < 2^128`; the division is done in two steps of 127 and 53 bits, and the
    /// rest that is dropped, below one unit, is less than a part 2^-127 of the quotient.
    fn of_reciprocal(x: f64) -> Scaled {
        let (m, e) = significand(x);
        if m == 1 << 52 {
            return Scaled {
                m: 1 << 127,
                e: -e - 52 - 127,
                cuts: 0,
            };
        }
        let (first, rest) = ((1 << 127) / m, (1 << 127) % m);
        Scaled {
            m: (first << 53) + (rest << 53) / m,
            e: -e - 180,
            cuts: 1,
        }
    }

    /// `x^n` for a positive finite `x`, by repeated squaring; `n = 0` gives 1.
    ///
    /// `cuts` stays below `2 |n| < 2^33`, and is 0 where no product loses a bit. In particular it is 0
    /// wherever the power is a float: its significand without closing zeros then has at most 53 bits,
    /// and so have all factors on the way.
    pub(super) fn power(x: f64, n: i32) -> Scaled {
        let mut square = if n < 0 {
            Scaled::of_reciprocal(x)
        } else {
            Scaled::of(x)
        };
        let mut product = Scaled::of(1.0);
        let mut rest = n.unsigned_abs();
        while rest > 0 {
            if rest & 1 == 1 {
                product = product.times(square);
            }
            rest >>= 1;
            if rest > 0 {
                square = square.times(square);
            }
        }
        product
    }

    /// The product, cut to 128 bits. A unit of the result is at most a part 2^-127 of it, so one more
    /// factor `1 + 2^-127` covers the cut.
    fn times(self, other: Scaled) -> Scaled {
        let (high, low) = wide_product(self.m, other.m);
        let e = self.e + other.e;
        let (m, e, rest) = if high >> 127 == 1 {
            (high, e + 128, low)
        } else {
            ((high << 1) | (low >> 127), e + 127, low << 1)
        };
        let cuts = self.cuts + other.cuts + u64::from(rest != 0);
        Scaled { m, e, cuts }
    }

    /// What may be missing from `m`, in its units: `m ((1 + 2^-127)^cuts - 1)` is below
    /// `2 cuts (1 + 2^-60)` for `cuts < 2^60`.
    fn missing(self) -> u128 {
        if self.cuts == 0 {
            0
        } else {
            2 * u128::from(self.cuts) + 1
        }
    }

    /// Largest float not above the number, or the one before it where a float lies among the last bits.
    pub(super) fn down(self) -> f64 {
        from_scaled(false, self.m, self.e, false, false)
    }

    /// Smallest float not below the number, or the one after it.
    pub(super) fn up(self) -> f64 {
        match self.m.checked_add(self.missing()) {
            Some(most) => from_scaled(false, most, self.e, false, true),
            // Half of it, and one for the bit that was shifted out.
            None => from_scaled(
                false,
                (self.m >> 1) + (self.missing() >> 1) + 2,
                self.e + 1,
                false,
                true,
            ),
        }
    }

    /// True only if the number is at most `bound`, which is exact.
    pub(super) fn is_at_most(self, bound: Scaled) -> bool {
        let most = self.m.checked_add(self.missing());
        match self.e.cmp(&bound.e) {
            Ordering::Less => most.is_some() || self.e + 1 < bound.e,
            Ordering::Equal => most.is_some_and(|most| most <= bound.m),
            Ordering::Greater => false,
        }
    }

    /// True only if the number is at least `bound`, which is exact.
    pub(super) fn is_at_least(self, bound: Scaled) -> bool {
        (self.e, self.m) >= (bound.e, bound.m)
    }
}

/// `m` and `e` with `x = m 2^e` and `2^52 <= m < 2^53`, for a positive finite `x`.
fn significand(x: f64) -> (u128, i64) {
    let (_, m, e) = parts(x);
    (m, i64::from(e))
}

/// `a b = high 2^128 + low`, from four products of halves.
fn wide_product(a: u128, b: u128) -> (u128, u128) {
    const LOW: u128 = (1 << 64) - 1;
    let ((a1, a0), (b1, b0)) = ((a >> 64, a & LOW), (b >> 64, b & LOW));
    let (least, left, right) = (a0 * b0, a1 * b0, a0 * b1);
    let middle = (least >> 64) + (left & LOW) + (right & LOW);
    let high = a1 * b1 + (left >> 64) + (right >> 64) + (middle >> 64);
    (high, (middle << 64) | (least & LOW))
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_bigint::BigUint;

    /// The number lies between its bounds, and is the lower one exactly where nothing was cut.
    #[test]
    fn powers_are_between_their_bounds() {
        let mut state = 7_u64;
        for case in 0..20_000 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            // Few bits, many bits, close to a power of two.
            let bits = match case % 4 {
                0 => (1023 << 52) | (state >> 56 << 44),
                1 => (1024 << 52) - (state >> 58),
                2 => (1023 << 52) + (state >> 58),
                _ => (1023 << 52) | (state >> 12),
            };
            let x = f64::from_bits(bits);
            let n = 1 + (state % 40) as i32;
            let (m, e) = significand(x);
            // x^n = exact 2^(e n), and its reciprocal times this number is 1.
            let exact = BigUint::from(m).pow(n as u32);
            let order = |bound: u128, exponent: i64, reciprocal: bool| {
                let (bound, one) = (BigUint::from(bound), BigUint::from(1_u32));
                let (left, right, shift) = if reciprocal {
                    (bound * &exact, one, exponent + e * i64::from(n))
                } else {
                    (bound, exact.clone(), exponent - e * i64::from(n))
                };
                if shift >= 0 {
                    (left << shift as u64).cmp(&right)
                } else {
                    left.cmp(&(right << shift.unsigned_abs()))
                }
            };
            for (power, reciprocal) in [(Scaled::power(x, n), false), (Scaled::power(x, -n), true)]
            {
                let least = order(power.m, power.e, reciprocal);
                let most = power.m.checked_add(power.missing());
                let most = most.map_or(Ordering::Greater, |m| order(m, power.e, reciprocal));
                assert!(
                    least != Ordering::Greater && most != Ordering::Less,
                    "{x:e}^{n}"
                );
                assert_eq!(least == Ordering::Equal, power.cuts == 0, "{x:e}^{n}");
                assert!(power.cuts < 2 * n as u64, "{x:e}^{n}");
            }
        }
    }

    #[test]
    fn bounds_beyond_128_bits_carry() {
        let number = Scaled {
            m: u128::MAX,
            e: -128,
            cuts: 1 << 32,
        };
        assert_eq!(number.down(), 1.0_f64.next_down());
        assert_eq!(number.up(), 1.0_f64.next_up());
        assert!(!number.is_at_most(Scaled::of(1.0)));
        assert!(number.is_at_most(Scaled::of(2.0)));
        assert!(!number.is_at_least(Scaled::of(1.0)));
    }
}
