//! Powers in twice the precision of floats: the fast way to a tight end.

use crate::round::{Elementwise, Pair};

/// The largest exponent for which the error is small enough to be forgotten.
const MOST: u32 = 64;

/// Numbers `(high + low) (1 + θ)` with `|θ| <= 65 2^-102`, one for each end; `|low| <= 2^-53 |high|`.
///
/// Valid where `high` is in [`ORDINARY`]: the factors on the way lie between 1 and the power.
#[derive(Clone, Copy)]
pub(super) struct Near {
    high: Pair,
    low: Pair,
    /// 0 where no rounding happened: the number is `high`.
    lost: Pair,
}

/// `2^-900` to `2^900`.
const ORDINARY: std::ops::Range<f64> =
    f64::from_bits((1023 - 900) << 52)..f64::from_bits((1023 + 900) << 52);

impl Near {
    /// `x^n` for two positive numbers; `None` for exponents that are too large.
    #[inline]
    pub(super) fn power(x: Pair, n: i32) -> Option<Near> {
        let mut rest = n.unsigned_abs();
        if !(1..=MOST).contains(&rest) {
            return None;
        }
        let zero = Pair::splat(0.0);
        let mut square = Near {
            high: x,
            low: zero,
            lost: zero,
        };
        while rest & 1 == 0 {
            square = square.times(square);
            rest >>= 1;
        }
        let mut product = square;
        while rest > 1 {
            rest >>= 1;
            square = square.times(square);
            if rest & 1 == 1 {
                product = product.times(square);
            }
        }
        Some(if n < 0 { product.recip() } else { product })
    }

    /// The product with an error below `2^-102` of it; with the errors of the factors, as in `(1 + θ)^k`,
    /// that makes at most `(n - 1) 2^-102` and a little for the `n`-th power.
    ///
    /// Proof, with `u = 2^-53` and sizes relative to the product: `p + e` is the product of the high
    /// parts. Dropped is `low low` (`u^2`). Rounded are the mixed products (`u^2` each), their sum
    /// (`2 u^2`) and its sum with `e` (`3 u^2`), which is below `4 u`, so that the last sum is exact
    /// (Dekker). Together that is below `9 u^2 = 9/16 2^-102`; where a low part is so small that a mixed
    /// product is subnormal, the rounding of it is below `2^-1075`, at most `2^-175` of the product.
    #[inline]
    fn times(self, other: Near) -> Near {
        let p = self.high.times(other.high);
        let e = Pair::product_error(self.high, other.high, p);
        let mixed = self.high.times(other.low).plus(self.low.times(other.high));
        let rest = e.plus(mixed);
        let high = p.plus(rest);
        Near {
            high,
            low: rest.minus(high.minus(p)),
            lost: self.lost.plus(other.lost).plus(e.abs()),
        }
    }

    /// The reciprocal with one more error below `2^-102`.
    ///
    /// Proof. `q = (1 + d) / high` with `|d| <= u`; `1 - q high = (1 - p) - e` is exact (Sterbenz, and `-d`
    /// is a multiple of `ulp(q) ulp(high)`). The rest `r = 1 - q (high + low)` is at most `2 u` and
    /// computed with two roundings (`u^2` and `2 u^2`). The reciprocal is `q (1 + r + r^2 ...)`:
    /// dropped are `4 u^2` and a little, rounded is `q r` (`2 u^2`). Together below `10 u^2`.
    #[inline]
    fn recip(self) -> Near {
        let one = Pair::splat(1.0);
        let q = one.over(self.high);
        let p = q.times(self.high);
        let e = Pair::product_error(q, self.high, p);
        let missed = one.minus(p).minus(e);
        let step = q.times(missed.minus(q.times(self.low)));
        let high = q.plus(step);
        Near {
            high,
            low: step.minus(high.minus(q)),
            lost: self.lost.plus(missed.abs()),
        }
    }

    /// The tight lower bound in the first place.
    #[inline]
    pub(super) fn down(self) -> Option<f64> {
        bound(
            self.high.first(),
            self.low.first(),
            self.lost.first(),
            false,
        )
    }

    /// The tight upper bound in the second place.
    #[inline]
    pub(super) fn up(self) -> Option<f64> {
        bound(
            self.high.second(),
            self.low.second(),
            self.lost.second(),
            true,
        )
    }
}

/// The side of `high` on which the number lies is the sign of `low`, where this is more than `2^-95` of
/// `high`: the unknown part `θ (high + low)` is below `2^-95.9`. It lies within one float, since
/// `|low|` is at most half the distance of the floats.
#[inline]
fn bound(high: f64, low: f64, lost: f64, up: bool) -> Option<f64> {
    const CERTAIN: f64 = f64::from_bits((1023 - 95) << 52);
    if !ORDINARY.contains(&high) {
        None
    } else if lost == 0.0 {
        Some(high)
    } else if low.abs() <= CERTAIN * high {
        None
    } else {
        Some(match (up, low > 0.0) {
            (true, true) => high.next_up(),
            (false, false) => high.next_down(),
            _ => high,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No random power comes so near to a float: what the error hides is left to the exact way.
    #[test]
    fn what_is_too_near_to_a_float_is_not_decided() {
        let above = 1.0_f64.next_up();
        let below = 1.0_f64.next_down();
        let (certain, hidden) = (2_f64.powi(-94), 2_f64.powi(-95));
        assert_eq!(bound(1.0, certain, 1.0, true), Some(above));
        assert_eq!(bound(1.0, certain, 1.0, false), Some(1.0));
        assert_eq!(bound(1.0, -certain, 1.0, true), Some(1.0));
        assert_eq!(bound(1.0, -certain, 1.0, false), Some(below));
        for low in [hidden, -hidden, 0.0] {
            assert_eq!(bound(1.0, low, 1e-40, true), None);
            assert_eq!(bound(1.0, low, 1e-40, false), None);
        }
        assert_eq!(bound(1.0, 0.0, 0.0, true), Some(1.0));
        for high in [
            2_f64.powi(900),
            2_f64.powi(-901),
            0.0,
            f64::INFINITY,
            f64::NAN,
        ] {
            assert_eq!(bound(high, 0.0, 0.0, true), None);
        }
    }
}
