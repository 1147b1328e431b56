//! What several tests share: a generator of floats with all the awkward ones, and exact numbers.

#![allow(dead_code, reason = "each test uses a part")]
#![allow(clippy::indexing_slicing, reason = "a test fails by panicking")]

use std::cmp::Ordering;

use num_bigint::BigInt;
use num_traits::Zero;

/// A small generator with a fixed seed (splitmix64), so that every run sees the same numbers.
pub struct Source(pub u64);

impl Source {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, n: u64) -> u64 {
        self.bits() % n
    }

    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.unit()
    }

    fn signed(&mut self, x: f64) -> f64 {
        if self.bits() & 1 == 0 { x } else { -x }
    }

    /// A finite float: ordinary ones half of the time, else one of the awkward kinds.
    pub fn float(&mut self) -> f64 {
        let x = match self.below(16) {
            0..8 => (1.0 + self.unit()) * 2_f64.powi(self.below(80) as i32 - 40),
            8 => f64::from_bits(self.below(0x7ff << 52)),
            9 => f64::from_bits(self.bits() & ((1 << (1 + self.below(52))) - 1)),
            10 => {
                let bits = 1 + self.below(53);
                f64::from_bits(f64::MAX.to_bits() - self.below(1 << bits))
            }
            11 => self.below(2000) as f64 / 2_f64.powi(self.below(12) as i32),
            // Near powers of two, where the distance of the floats changes.
            12 => f64::from_bits(((1 + self.below(2045)) << 52) + self.below(5) - 2),
            // Near the borders of the fast ways: 2^±480, 2^±960, 2^-1021.
            13 => {
                let border = [-480, 480, -960, 960, -1021, -962][self.below(6) as usize];
                (1.0 + self.unit()) * 2_f64.powi(border + self.below(5) as i32 - 2)
            }
            14 => [
                0.0,
                f64::MAX,
                f64::MIN_POSITIVE,
                f64::from_bits(1),
                1.0,
                2_f64.powi(-960),
            ][self.below(6) as usize],
            // Few bits: products, quotients and roots that are exact or ties.
            _ => (1 + self.below(1 << 27)) as f64 * 2_f64.powi(self.below(1900) as i32 - 1000),
        };
        self.signed(x)
    }

    /// Two floats, often related: nearly opposite, far apart by just over 53 bits, multiples.
    pub fn floats(&mut self) -> (f64, f64) {
        let a = self.float();
        let b = match self.below(8) {
            0 => {
                let steps = self.below(9) as i64 - 4;
                -f64::from_bits((a.to_bits() as i64).saturating_add(steps) as u64)
            }
            1 => {
                let smaller = a * 2_f64.powi(-(self.below(60) as i32));
                self.signed(smaller)
            }
            2 => self.between(-1.0, 1.0) * a.abs() * 2_f64.powi(-52),
            3 => a * self.below(100) as f64,
            _ => self.float(),
        };
        (a, if b.is_finite() { b } else { 1.0 })
    }
}

/// An exact number `m 2^e`.
#[derive(Clone, Debug)]
pub struct Dyadic {
    pub m: BigInt,
    pub e: i64,
}

impl Dyadic {
    pub fn of(x: f64) -> Dyadic {
        assert!(x.is_finite());
        let bits = x.to_bits();
        let biased = ((bits >> 52) & 0x7ff) as i64;
        let fraction = (bits & ((1 << 52) - 1)) as i64;
        let (m, e) = if biased == 0 {
            (fraction, -1074)
        } else {
            (fraction + (1 << 52), biased - 1075)
        };
        Dyadic {
            m: BigInt::from(if x.is_sign_negative() { -m } else { m }),
            e,
        }
    }

    pub fn plus(&self, other: &Dyadic) -> Dyadic {
        let e = self.e.min(other.e);
        Dyadic {
            m: self.at(e) + other.at(e),
            e,
        }
    }

    pub fn times(&self, other: &Dyadic) -> Dyadic {
        Dyadic {
            m: &self.m * &other.m,
            e: self.e + other.e,
        }
    }

    /// The exponent of the leading bit, for a number other than 0.
    pub fn size(&self) -> i64 {
        self.m.bits() as i64 + self.e
    }

    fn at(&self, e: i64) -> BigInt {
        &self.m << (self.e - e) as u64
    }

    pub fn compare(&self, other: &Dyadic) -> Ordering {
        if self.m.is_zero() || other.m.is_zero() {
            return self.m.cmp(&other.m);
        }
        let e = self.e.min(other.e);
        self.at(e).cmp(&other.at(e))
    }
}

/// `x` compared with an exact number, also for an infinite `x`.
pub fn compare(x: f64, exact: &Dyadic) -> Ordering {
    if x == f64::INFINITY {
        Ordering::Greater
    } else if x == f64::NEG_INFINITY {
        Ordering::Less
    } else {
        Dyadic::of(x).compare(exact)
    }
}

/// Asserts that `down` and `up` are the tight bounds of a number that `order` compares floats with.
pub fn assert_tight(
    down: f64,
    up: f64,
    order: impl Fn(f64) -> Ordering,
    what: impl Fn() -> String,
) {
    let low = order(down);
    assert!(
        low != Ordering::Greater,
        "{}: {down:e} is above the true value",
        what()
    );
    let high = order(up);
    assert!(
        high != Ordering::Less,
        "{}: {up:e} is below the true value",
        what()
    );
    if low == Ordering::Equal || high == Ordering::Equal {
        assert!(down == up, "{}: exact, but {down:e} {up:e}", what());
    } else {
        assert!(
            down.next_up() == up,
            "{}: {down:e} {up:e} are not neighbours",
            what()
        );
    }
}
