//! Power series with rational coefficients.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Zero};
use veribound_interval::Interval;
use veribound_model::Unary;

/// Coefficients kept.
pub const COUNT: usize = 7;

pub fn rational(numerator: i64, denominator: i64) -> BigRational {
    BigRational::new(numerator.into(), denominator.into())
}

pub fn contains(x: Interval, exact: &BigRational) -> bool {
    let end = |end: f64| BigRational::from_float(end);
    end(x.lo()).is_none_or(|lo| lo <= *exact) && end(x.hi()).is_none_or(|hi| *exact <= hi)
}

/// `c0 + c1 t + c2 t² + ...`, exactly.
#[derive(Debug, Clone, PartialEq)]
pub struct Exact(pub Vec<BigRational>);

impl Exact {
    pub fn constant(value: BigRational) -> Exact {
        let mut all = vec![BigRational::zero(); COUNT];
        all[0] = value;
        Exact(all)
    }

    pub fn zip(
        &self,
        other: &Exact,
        with: impl Fn(&BigRational, &BigRational) -> BigRational,
    ) -> Exact {
        Exact(
            self.0
                .iter()
                .zip(&other.0)
                .map(|(a, b)| with(a, b))
                .collect(),
        )
    }

    pub fn scaled(&self, factor: &BigRational) -> Exact {
        Exact(self.0.iter().map(|c| c * factor).collect())
    }

    pub fn times(&self, other: &Exact) -> Exact {
        let coefficient = |k: usize| (0..=k).map(|j| &self.0[j] * &other.0[k - j]).sum();
        Exact((0..COUNT).map(coefficient).collect())
    }

    /// For a series that does not begin with 0.
    pub fn inverse(&self) -> Exact {
        let mut all: Vec<BigRational> = vec![self.0[0].recip()];
        for k in 1..COUNT {
            let known: BigRational = (1..=k).map(|j| &self.0[j] * &all[k - j]).sum();
            all.push(-known / &self.0[0]);
        }
        Exact(all)
    }

    pub fn power(&self, n: i32) -> Exact {
        let mut product = Exact::constant(BigRational::one());
        for _ in 0..n.unsigned_abs() {
            product = product.times(self);
        }
        if n < 0 { product.inverse() } else { product }
    }

    /// `Σ outer_k self^k` for a series that begins with 0.
    pub fn inside(&self, outer: &[BigRational]) -> Exact {
        let mut sum = Exact::constant(BigRational::zero());
        for coefficient in outer.iter().rev() {
            sum = sum.times(self);
            sum.0[0] += coefficient;
        }
        sum
    }
}

/// The series of a function at 0, if its coefficients are rational.
pub fn at_zero(function: Unary) -> Option<Vec<BigRational>> {
    let factorial = |k: usize| (1..=k).fold(BigInt::one(), |all, i| all * i);
    let over_factorial = |k: usize| BigRational::new(BigInt::one(), factorial(k));
    let odd = |k: usize| k % 2 == 1;
    let alternating = |k: usize| rational(if (k / 2).is_multiple_of(2) { 1 } else { -1 }, 1);
    let zero = BigRational::zero;
    // (2m)! / (4^m m!^2 (2m + 1)) of t^(2m + 1)
    let arcsine = |k: usize| {
        let m = k / 2;
        let below = BigInt::from(4).pow(m as u32) * factorial(m) * factorial(m) * k;
        BigRational::new(factorial(2 * m), below)
    };
    let all = |coefficient: &dyn Fn(usize) -> BigRational| -> Vec<BigRational> {
        (0..COUNT).map(coefficient).collect()
    };
    let quotient = |above: Unary, below: Unary| {
        let (above, below) = (Exact(at_zero(above)?), Exact(at_zero(below)?));
        Some(above.times(&below.inverse()).0)
    };
    Some(match function {
        Unary::Exp => all(&over_factorial),
        Unary::Sin => all(&|k| {
            if odd(k) {
                alternating(k) * over_factorial(k)
            } else {
                zero()
            }
        }),
        Unary::Cos => all(&|k| {
            if odd(k) {
                zero()
            } else {
                alternating(k) * over_factorial(k)
            }
        }),
        Unary::Sinh => all(&|k| if odd(k) { over_factorial(k) } else { zero() }),
        Unary::Cosh => all(&|k| if odd(k) { zero() } else { over_factorial(k) }),
        Unary::Atan => all(&|k| {
            if odd(k) {
                alternating(k) / BigInt::from(k)
            } else {
                zero()
            }
        }),
        Unary::Atanh => all(&|k| {
            if odd(k) {
                rational(1, k as i64)
            } else {
                zero()
            }
        }),
        Unary::Asin => all(&|k| if odd(k) { arcsine(k) } else { zero() }),
        Unary::Asinh => all(&|k| {
            if odd(k) {
                alternating(k) * arcsine(k)
            } else {
                zero()
            }
        }),
        Unary::Tan => quotient(Unary::Sin, Unary::Cos)?,
        Unary::Tanh => quotient(Unary::Sinh, Unary::Cosh)?,
        _ => return None,
    })
}

/// `ln(1 + t)` and `sqrt(1 + t)`
pub fn beside_one(function: Unary) -> Vec<BigRational> {
    let mut binomial = BigRational::one();
    let mut root = Vec::new();
    for k in 0..COUNT as i64 {
        root.push(binomial.clone());
        binomial *= (rational(1, 2) - rational(k, 1)) / rational(k + 1, 1);
    }
    let logarithm = |k: i64| match k {
        0 => BigRational::zero(),
        _ => rational(if k % 2 == 1 { 1 } else { -1 }, k),
    };
    match function {
        Unary::Sqrt => root,
        _ => (0..COUNT as i64).map(logarithm).collect(),
    }
}
