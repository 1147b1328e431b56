//! Elementary functions by series in big-integer fixed point: slow, simple, and sharing nothing with
//! the code under test.
//!
//! A number is an integer count of `2^-bits`. Every function here errs by less than `2^-200` relative
//! to its value (the working precision leaves more than 250 bits after cancellation, and the series have fewer
//! than 2000 terms with an error of one unit each).

#![allow(dead_code, reason = "each test uses a part")]

use num_bigint::BigInt;
use num_traits::{One, Signed, ToPrimitive, Zero};

use crate::support::Dyadic;

/// Fixed-point arithmetic with a number of bits after the point.
pub struct Fixed {
    pub bits: u64,
    pub half_pi: BigInt,
    pub ln2: BigInt,
}

impl Fixed {
    pub fn new(bits: u64) -> Fixed {
        let mut fixed = Fixed {
            bits,
            half_pi: BigInt::zero(),
            ln2: BigInt::zero(),
        };
        // Machin: π/4 = 4 atan(1/5) - atan(1/239);  ln 2 = 2 artanh(1/3).
        let quarter = fixed.inverse_series(5, -1) * 4 - fixed.inverse_series(239, -1);
        fixed.half_pi = quarter * 2;
        fixed.ln2 = fixed.inverse_series(3, 1) * 2;
        fixed
    }

    pub fn one(&self) -> BigInt {
        BigInt::one() << self.bits
    }

    /// `sum of sign^k / ((2k + 1) n^(2k + 1))`: `atan(1/n)` for -1, `artanh(1/n)` for +1.
    fn inverse_series(&self, n: u32, sign: i32) -> BigInt {
        let mut power = self.one() / n;
        let mut sum = power.clone();
        let (mut k, mut turn) = (1_u32, 1);
        while !power.is_zero() {
            power /= n * n;
            turn *= sign;
            k += 2;
            sum += (&power / k) * turn;
        }
        sum
    }

    pub fn of(&self, x: f64) -> BigInt {
        if x == 0.0 {
            return BigInt::zero();
        }
        let exact = Dyadic::of(x);
        let shift = exact.e + self.bits as i64;
        assert!(shift >= 0, "not enough bits for {x:e}");
        exact.m << shift as u64
    }

    pub fn times(&self, a: &BigInt, b: &BigInt) -> BigInt {
        (a * b) >> self.bits
    }

    pub fn over(&self, a: &BigInt, b: &BigInt) -> BigInt {
        (a << self.bits) / b
    }

    pub fn dyadic(&self, x: BigInt) -> Dyadic {
        Dyadic {
            m: x,
            e: -(self.bits as i64),
        }
    }

    /// `exp(x)` as a multiple of a power of two.
    pub fn exp(&self, x: f64) -> Dyadic {
        self.exp_of(self.of(x))
    }

    pub fn exp_of(&self, x: BigInt) -> Dyadic {
        let k = floor_over(&(&x + (&self.ln2 >> 1_u32)), &self.ln2);
        let rest = x - &k * &self.ln2;
        let (mut term, mut sum, mut n) = (self.one(), self.one(), 1);
        while !term.is_zero() && term != BigInt::from(-1) {
            term = self.times(&term, &rest) / n;
            sum += &term;
            n += 1;
        }
        Dyadic {
            m: sum,
            e: k.to_i64().unwrap() - self.bits as i64,
        }
    }

    pub fn ln(&self, x: f64) -> Dyadic {
        self.dyadic(self.ln_of(Dyadic::of(x)))
    }

    /// The logarithm of a positive number.
    pub fn ln_of(&self, exact: Dyadic) -> BigInt {
        let length = exact.m.bits() as i64;
        // m in [3/4, 3/2): x = m 2^k.
        let mut k = exact.e + length;
        let mut m = match self.bits as i64 - length {
            up @ 0.. => exact.m << up as u64,
            down => exact.m >> (-down) as u64,
        };
        if &m * 4 < self.one() * 3 {
            m <<= 1;
            k -= 1;
        }
        let z = self.over(&(&m - self.one()), &(&m + self.one()));
        let square = self.times(&z, &z);
        let (mut power, mut sum, mut n) = (z.clone(), z, 1);
        while !power.is_zero() && power != BigInt::from(-1) {
            power = self.times(&power, &square);
            n += 2;
            sum += &power / n;
        }
        sum * 2 + &self.ln2 * k
    }

    /// How many multiples of π/2 lie below or at `x`, and `x` minus the nearest one with its number.
    fn reduced(&self, x: f64) -> (BigInt, BigInt, BigInt) {
        let x = self.of(x);
        let floor = floor_over(&x, &self.half_pi);
        let nearest = floor_over(&(&x + (&self.half_pi >> 1_u32)), &self.half_pi);
        let rest = x - &nearest * &self.half_pi;
        (floor, nearest, rest)
    }

    /// `floor(x / (π/2))`.
    pub fn quarter_turns(&self, x: f64) -> BigInt {
        self.reduced(x).0
    }

    fn sin_cos(&self, x: f64) -> (BigInt, BigInt) {
        let (_, turns, rest) = self.reduced(x);
        let (mut term, mut n) = (self.one(), 0);
        let (mut sin, mut cos) = (BigInt::zero(), BigInt::zero());
        while !term.is_zero() && term != BigInt::from(-1) {
            match n % 4 {
                0 => cos += &term,
                1 => sin += &term,
                2 => cos -= &term,
                _ => sin -= &term,
            }
            n += 1;
            term = self.times(&term, &rest) / n;
        }
        match ((turns % 4_i32 + 4_i32) % 4_i32).to_i32().unwrap() {
            0 => (sin, cos),
            1 => (cos, -sin),
            2 => (-sin, -cos),
            _ => (-cos, sin),
        }
    }

    pub fn sin(&self, x: f64) -> Dyadic {
        self.dyadic(self.sin_cos(x).0)
    }

    pub fn cos(&self, x: f64) -> Dyadic {
        self.dyadic(self.sin_cos(x).1)
    }

    pub fn tan(&self, x: f64) -> Dyadic {
        let (sin, cos) = self.sin_cos(x);
        self.dyadic(self.over(&sin, &cos))
    }

    pub fn atan(&self, x: f64) -> Dyadic {
        self.dyadic(self.atan_of(self.of(x)))
    }

    pub fn atan_of(&self, x: BigInt) -> BigInt {
        let large = x.abs() > self.one();
        let mut z = if large {
            self.over(&self.one(), &x)
        } else {
            x.clone()
        };
        // atan z = 2 atan(z / (1 + sqrt(1 + z^2))), four times.
        for _ in 0..4 {
            let root = ((self.one() + self.times(&z, &z)) << self.bits).sqrt();
            z = self.over(&z, &(root + self.one()));
        }
        let square = self.times(&z, &z);
        let (mut power, mut sum, mut n) = (z.clone(), z, 1);
        while !power.is_zero() && power != BigInt::from(-1) {
            power = -self.times(&power, &square);
            n += 2;
            sum += &power / n;
        }
        let small = sum * 16;
        if !large {
            small
        } else if x.is_positive() {
            &self.half_pi - small
        } else {
            -&self.half_pi - small
        }
    }

    /// `(1 - e^-2|x|) / (1 + e^-2|x|)` with the sign of `x`.
    pub fn tanh(&self, x: f64) -> Dyadic {
        let power = self.exp(-2.0 * x.abs());
        let shift = power.e + self.bits as i64;
        let t = if shift >= 0 {
            power.m << shift as u64
        } else {
            power.m >> (-shift) as u64
        };
        let size = self.over(&(self.one() - &t), &(self.one() + &t));
        self.dyadic(if x < 0.0 { -size } else { size })
    }
}

fn floor_over(a: &BigInt, b: &BigInt) -> BigInt {
    num_integer::Integer::div_floor(a, b)
}
