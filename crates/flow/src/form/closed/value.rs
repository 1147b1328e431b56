//! Numbers that depend on the unknowns, and matrices of them.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: matrices are `n * n`, row by row; full polynomials have one coefficient per monomial"
)]

use super::super::ahead::{around, multiply};
use super::super::monomials::Monomials;
use super::super::outward::{UNIT, is_lost, raised};
use super::super::size::Size;
use veribound_interval::Interval;

/// A function of the unknowns: at most `radius` from a polynomial, which has one coefficient where it is constant.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Value {
    polynomial: Vec<f64>,
    radius: f64,
}

impl Value {
    pub(super) fn constant(x: f64) -> Value {
        Value {
            polynomial: vec![x],
            radius: 0.0,
        }
    }

    pub(super) fn of(mut polynomial: Vec<f64>, radius: f64) -> Value {
        if polynomial[1..].iter().all(|x| *x == 0.0) {
            polynomial.truncate(1);
        }
        Value { polynomial, radius }
    }

    /// Exactly zero, for all unknowns.
    pub(super) fn is_zero(&self) -> bool {
        self.radius == 0.0 && self.polynomial.len() == 1 && self.polynomial[0] == 0.0
    }

    /// True if numbers are too large to go on.
    pub(super) fn is_lost(&self) -> bool {
        is_lost(self.size())
    }

    /// All coefficients, and the radius.
    pub(super) fn parts(&self, count: usize) -> (Vec<f64>, f64) {
        let mut polynomial = self.polynomial.clone();
        polynomial.resize(count, 0.0);
        (polynomial, self.radius)
    }

    /// How far it can be from its polynomial.
    pub(super) fn radius(&self) -> f64 {
        self.radius
    }

    /// An upper bound of absolute values.
    pub(super) fn size(&self) -> f64 {
        let sum: f64 = self.polynomial.iter().map(|x| x.abs()).sum();
        if sum == 0.0 && self.radius == 0.0 {
            return 0.0;
        }
        raised(sum + self.radius, self.polynomial.len() + 1)
    }

    pub(super) fn hull(&self) -> Interval {
        let own = around(&self.polynomial);
        if self.radius == 0.0 {
            own
        } else {
            own.inflate(self.radius)
        }
    }

    pub(super) fn widened(mut self, by: f64) -> Value {
        if by > 0.0 {
            self.radius = raised(self.radius + by, 1);
        }
        self
    }

    pub(super) fn plus(&self, other: &Value) -> Value {
        if self.is_zero() {
            return other.clone();
        }
        if other.is_zero() {
            return self.clone();
        }
        let (long, short) = if self.polynomial.len() < other.polynomial.len() {
            (other, self)
        } else {
            (self, other)
        };
        let mut polynomial = long.polynomial.clone();
        let mut rounding = 0.0;
        for (x, y) in polynomial.iter_mut().zip(&short.polynomial) {
            *x += y;
            rounding += UNIT * x.abs();
        }
        let radius = raised(long.radius + short.radius + rounding, polynomial.len() + 2);
        Value { polynomial, radius }
    }

    /// Times a float.
    pub(super) fn times_float(&self, factor: f64) -> Value {
        if self.is_zero() {
            return self.clone();
        }
        let polynomial: Vec<f64> = self.polynomial.iter().map(|x| x * factor).collect();
        let sum: f64 = polynomial.iter().map(|x| x.abs()).sum();
        let radius = raised(
            UNIT * sum + factor.abs() * self.radius,
            polynomial.len() + 2,
        );
        Value { polynomial, radius }
    }

    /// Divided by a float that is not zero.
    pub(super) fn divided(&self, divisor: f64) -> Value {
        if self.is_zero() {
            return self.clone();
        }
        let polynomial: Vec<f64> = self.polynomial.iter().map(|x| x / divisor).collect();
        let sum: f64 = polynomial.iter().map(|x| x.abs()).sum();
        let radius = UNIT * sum + self.radius / divisor.abs();
        Value {
            radius: raised(radius, polynomial.len() + 2),
            polynomial,
        }
    }

    pub(super) fn times(&self, other: &Value, monomials: &Monomials) -> Value {
        let (long, short) = if self.polynomial.len() < other.polynomial.len() {
            (other, self)
        } else {
            (self, other)
        };
        if self.is_zero() || other.is_zero() {
            return Value::constant(0.0);
        }
        let by_radii =
            long.size() * short.radius + short.size() * long.radius + long.radius * short.radius;
        if short.polynomial.len() == 1 {
            let product = Value {
                polynomial: long.polynomial.clone(),
                radius: 0.0,
            };
            return product
                .times_float(short.polynomial[0])
                .widened(raised(by_radii, 6));
        }
        let mut polynomial = vec![0.0; monomials.len()];
        multiply(
            monomials,
            &self.polynomial,
            &other.polynomial,
            &mut polynomial,
        );
        let measured = |x: &Value| {
            let mut size = Size::new(monomials, 1);
            size.measure(monomials, &x.polynomial, &[1.0], 0);
            size
        };
        let lost = measured(self).product(&measured(other), monomials, 0);
        Value {
            polynomial,
            radius: raised(lost + by_radii, 7),
        }
    }
}

/// A square matrix, row by row.
#[derive(Debug, Clone)]
pub(super) struct Matrix {
    pub(super) n: usize,
    pub(super) entries: Vec<Value>,
}

impl Matrix {
    pub(super) fn zero(n: usize) -> Matrix {
        Matrix {
            n,
            entries: vec![Value::constant(0.0); n * n],
        }
    }

    pub(super) fn is_lost(&self) -> bool {
        self.entries.iter().any(Value::is_lost)
    }

    pub(super) fn hull(&self) -> Vec<Interval> {
        self.entries.iter().map(Value::hull).collect()
    }

    pub(super) fn times_float(&self, factor: f64) -> Matrix {
        let entries = self.entries.iter().map(|x| x.times_float(factor));
        Matrix {
            n: self.n,
            entries: entries.collect(),
        }
    }

    pub(super) fn divided(&self, divisor: f64) -> Matrix {
        let entries = self.entries.iter().map(|x| x.divided(divisor));
        Matrix {
            n: self.n,
            entries: entries.collect(),
        }
    }

    pub(super) fn plus(&self, other: &Matrix) -> Matrix {
        let both = self.entries.iter().zip(&other.entries);
        Matrix {
            n: self.n,
            entries: both.map(|(x, y)| x.plus(y)).collect(),
        }
    }

    pub(super) fn plus_identity(mut self) -> Matrix {
        let one = Value::constant(1.0);
        for i in 0..self.n {
            let entry = &mut self.entries[i * self.n + i];
            *entry = entry.plus(&one);
        }
        self
    }

    pub(super) fn times(&self, other: &Matrix, monomials: &Monomials) -> Matrix {
        let n = self.n;
        let mut result = Matrix::zero(n);
        for i in 0..n {
            for m in 0..n {
                let left = &self.entries[i * n + m];
                if left.is_zero() {
                    continue;
                }
                for l in 0..n {
                    let right = &other.entries[m * n + l];
                    if !right.is_zero() {
                        let entry = &mut result.entries[i * n + l];
                        *entry = entry.plus(&left.times(right, monomials));
                    }
                }
            }
        }
        result
    }

    /// Times a column.
    pub(super) fn applied(&self, column: &[Value], monomials: &Monomials) -> Vec<Value> {
        let rows = self.entries.chunks_exact(self.n);
        rows.map(|row| {
            let parts = row.iter().zip(column);
            let parts = parts.filter(|(a, x)| !a.is_zero() && !x.is_zero());
            parts.fold(Value::constant(0.0), |sum, (a, x)| {
                sum.plus(&a.times(x, monomials))
            })
        })
        .collect()
    }
}

/// An interval matrix times a box.
pub(super) fn image(n: usize, matrix: &[Interval], x: &[Interval]) -> Vec<Interval> {
    let rows = matrix.chunks_exact(n);
    rows.map(|row| {
        let parts = row
            .iter()
            .zip(x)
            .filter(|(a, x)| !is_zero(**a) && !is_zero(**x));
        parts.fold(Interval::ZERO, |sum, (a, x)| sum + *a * *x)
    })
    .collect()
}

/// The product of two interval matrices.
pub(super) fn product(n: usize, a: &[Interval], b: &[Interval]) -> Vec<Interval> {
    let mut result = vec![Interval::ZERO; n * n];
    for i in 0..n {
        for m in (0..n).filter(|m| !is_zero(a[i * n + m])) {
            for l in (0..n).filter(|l| !is_zero(b[m * n + l])) {
                result[i * n + l] += a[i * n + m] * b[m * n + l];
            }
        }
    }
    result
}

fn is_zero(x: Interval) -> bool {
    x == Interval::ZERO
}
