//! More functions of the oracle, made from its series of exp, ln and atan.
//!
//! Differences of nearly equal numbers are avoided, so that values near 0 keep their relative precision.

use num_bigint::BigInt;
use num_traits::{Signed, Zero};

use crate::oracle::Fixed;
use crate::support::Dyadic;

impl Fixed {
    fn square_root(&self, x: &BigInt) -> BigInt {
        (x << self.bits).sqrt()
    }

    fn with_sign_of(x: f64, size: BigInt) -> BigInt {
        if x < 0.0 { -size } else { size }
    }

    /// A number that may be far beyond 1, in fixed point.
    fn fixed(&self, x: Dyadic) -> BigInt {
        match x.e + self.bits as i64 {
            up @ 0.. => x.m << up as u64,
            down => x.m >> (-down) as u64,
        }
    }

    pub fn exp2(&self, x: f64) -> Dyadic {
        self.exp_of(self.times(&self.of(x), &self.ln2))
    }

    pub fn exp10(&self, x: f64) -> Dyadic {
        let ln10 = self.ln_of(Dyadic::of(10.0));
        self.exp_of(self.times(&self.of(x), &ln10))
    }

    /// The series without its first term for small arguments.
    fn expm1_of(&self, x: f64) -> BigInt {
        if x.abs() > 0.5 {
            return self.fixed(self.exp(x)) - self.one();
        }
        let x = self.of(x);
        let (mut term, mut sum, mut n) = (x.clone(), BigInt::zero(), 1);
        while !term.is_zero() && term != BigInt::from(-1) {
            sum += &term;
            n += 1;
            term = self.times(&term, &x) / n;
        }
        sum
    }

    pub fn expm1(&self, x: f64) -> Dyadic {
        self.dyadic(self.expm1_of(x))
    }

    pub fn log2(&self, x: f64) -> Dyadic {
        let ln = self.ln_of(Dyadic::of(x));
        self.dyadic(self.over(&ln, &self.ln2))
    }

    pub fn log10(&self, x: f64) -> Dyadic {
        let ln = self.ln_of(Dyadic::of(x));
        self.dyadic(self.over(&ln, &self.ln_of(Dyadic::of(10.0))))
    }

    /// `2 artanh(x / (2 + x))`, by its series for small arguments.
    fn log1p_of(&self, x: &BigInt) -> BigInt {
        if x.abs() > self.one() >> 1_u32 {
            return self.ln_of(self.dyadic(x + self.one()));
        }
        let z = self.over(x, &(x + self.one() * 2));
        let square = self.times(&z, &z);
        let (mut power, mut sum, mut n) = (z.clone(), z, 1);
        while !power.is_zero() && power != BigInt::from(-1) {
            power = self.times(&power, &square);
            n += 2;
            sum += &power / n;
        }
        sum * 2
    }

    pub fn log1p(&self, x: f64) -> Dyadic {
        self.dyadic(self.log1p_of(&self.of(x)))
    }

    /// `atan(x / sqrt(1 - x^2))`.
    fn asin_of(&self, x: f64) -> BigInt {
        let exact = self.of(x);
        let rest = self.one() - self.times(&exact, &exact);
        if rest.is_zero() {
            return Self::with_sign_of(x, self.half_pi.clone());
        }
        self.atan_of(self.over(&exact, &self.square_root(&rest)))
    }

    pub fn asin(&self, x: f64) -> Dyadic {
        self.dyadic(self.asin_of(x))
    }

    pub fn acos(&self, x: f64) -> Dyadic {
        self.dyadic(&self.half_pi - self.asin_of(x))
    }

    /// `(t + t / (1 + t)) / 2` for `t = exp(|x|) - 1`.
    pub fn sinh(&self, x: f64) -> Dyadic {
        let t = self.expm1_of(x.abs());
        let both = &t + self.over(&t, &(&t + self.one()));
        self.dyadic(Self::with_sign_of(x, both >> 1_u32))
    }

    pub fn cosh(&self, x: f64) -> Dyadic {
        let both = self.fixed(self.exp(x)) + self.fixed(self.exp(-x));
        self.dyadic(both >> 1_u32)
    }

    /// `ln(1 + (|x| + x^2 / (1 + sqrt(1 + x^2))))`.
    pub fn asinh(&self, x: f64) -> Dyadic {
        let size = self.of(x.abs());
        let square = self.times(&size, &size);
        let root = self.square_root(&(&square + self.one()));
        let beyond = size + self.over(&square, &(root + self.one()));
        self.dyadic(Self::with_sign_of(x, self.log1p_of(&beyond)))
    }

    /// `ln(1 + (t + sqrt(2 t + t^2)))` for `t = x - 1`.
    pub fn acosh(&self, x: f64) -> Dyadic {
        let t = self.of(x) - self.one();
        let root = self.square_root(&(&t * 2 + self.times(&t, &t)));
        self.dyadic(self.log1p_of(&(t + root)))
    }

    /// `ln(1 + 2 |x| / (1 - |x|)) / 2`.
    pub fn atanh(&self, x: f64) -> Dyadic {
        let size = self.of(x.abs());
        let ratio = self.over(&(&size * 2), &(self.one() - &size));
        self.dyadic(Self::with_sign_of(x, self.log1p_of(&ratio) >> 1_u32))
    }

    /// The angle of `(x, y)`, not the origin.
    pub fn atan2(&self, y: f64, x: f64) -> Dyadic {
        let (over, under) = (self.of(y), self.of(x));
        if x == 0.0 {
            return self.dyadic(Self::with_sign_of(y, self.half_pi.clone()));
        }
        let angle = self.atan_of(self.over(&over, &under));
        self.dyadic(if x > 0.0 {
            angle
        } else {
            angle + Self::with_sign_of(y, &self.half_pi * 2)
        })
    }

    /// `x^y` for positive `x`, where `y ln x` is no larger than the logarithms of floats.
    pub fn pow(&self, x: f64, y: f64) -> Dyadic {
        self.exp_of(self.times(&self.of(y), &self.ln_of(Dyadic::of(x))))
    }
}
