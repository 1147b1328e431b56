//! The polynomial of a state ahead of time, with what rounding takes from it; ahead by one time, or by a
//! time of its own for every value of the unknowns.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: blocks own `monomials * stride` numbers, of which there are at least two"
)]

use super::monomials::Monomials;
use super::outward::{UNIT, raised};
use super::set::two_sum;
use super::size::Size;
use veribound_interval::Interval;

/// A state at scaled time `end`.
pub(super) struct Ahead {
    /// The polynomial in the unknowns.
    pub(super) polynomial: Vec<f64>,
    /// What rounding took from its constant, as far as it is known.
    pub(super) low: f64,
    /// What rounding can have taken besides.
    pub(super) lost: f64,
}

/// The polynomial of a state ahead of time.
///
/// A coefficient of order `j` passes through at most `2 j` roundings in Horner's rule. For the constant,
/// the sum with order 0 and the product of order 1 are taken without error: rounding then only costs
/// what is of second order in the step.
pub(super) fn ahead(
    block: &[f64],
    size: &Size,
    (orders, end): (usize, f64),
    weights: &[f64],
) -> Ahead {
    let stride = weights.len();
    let tail = |row: &[f64], from: usize| -> f64 {
        let orders = row[from..=orders].iter().rev();
        orders.fold(0.0, |sum, x| sum * end + x)
    };
    let (constant, others) = block.split_at(stride);
    let first = constant[1] * end;
    let first_low = constant[1].mul_add(end, -first);
    let (sum, sum_low) = two_sum(constant[0], first);
    let (sum, tail_low) = two_sum(sum, tail(constant, 2) * end * end);
    let low = first_low + sum_low + tail_low;
    let mut lost = 4.0 * UNIT * (first_low.abs() + sum_low.abs() + tail_low.abs());
    for (j, (x, weight)) in constant.iter().zip(weights).enumerate().skip(2) {
        lost += 2.02 * UNIT * j as f64 * x.abs() * weight;
    }
    let mut polynomial = vec![sum];
    if !others.is_empty() {
        for (j, x) in size.time.iter().enumerate().skip(1) {
            lost += 2.02 * UNIT * j as f64 * x;
        }
    }
    for row in others.chunks_exact(stride) {
        let value = row[0] + tail(row, 1) * end;
        lost += 1.01 * UNIT * value.abs();
        polynomial.push(value);
    }
    Ahead {
        lost: raised(lost, polynomial.len() + 2 * stride + 8),
        polynomial,
        low,
    }
}

/// The polynomial of a state at times that are themselves a polynomial in the unknowns, and what rounding
/// and truncation can have taken.
///
/// Proof. Horner's rule, `acc <- acc t + x_j`: what a product loses is told by [`Size::product`], and what
/// was lost before is multiplied by at most the sum of the absolute coefficients of `t`.
pub(super) fn later(
    monomials: &Monomials,
    block: &[f64],
    (orders, stride): (usize, usize),
    time: &[f64],
) -> (Vec<f64>, f64) {
    let count = monomials.len();
    let (mut time_size, mut acc_size) = (Size::new(monomials, 1), Size::new(monomials, 1));
    time_size.measure(monomials, time, &[1.0], 0);
    let mut acc = vec![0.0; count];
    let mut next = vec![0.0; count];
    let mut lost = 0.0;
    for j in (0..=orders).rev() {
        acc_size.measure(monomials, &acc, &[1.0], 0);
        multiply(monomials, &acc, time, &mut next);
        let product = acc_size.product(&time_size, monomials, 0);
        let mut rounding = 0.0;
        for (a, slot) in next.iter_mut().enumerate() {
            *slot += block[a * stride + j];
            rounding += slot.abs();
        }
        std::mem::swap(&mut acc, &mut next);
        lost = raised(
            lost * time_size.total + product + UNIT * rounding,
            count + 4,
        );
    }
    (acc, lost)
}

/// The product of two polynomials in the unknowns, as far as the table reaches.
pub(super) fn multiply(monomials: &Monomials, a: &[f64], b: &[f64], into: &mut [f64]) {
    for (c, slot) in into.iter_mut().enumerate() {
        let factors = monomials.factors(c).iter();
        *slot = factors.map(|&(x, y)| a[x as usize] * b[y as usize]).sum();
    }
}

/// Encloses a polynomial in the unknowns, quickly.
pub(super) fn around(polynomial: &[f64]) -> Interval {
    let size: f64 = polynomial[1..].iter().map(|x| x.abs()).sum();
    let middle = Interval::point(polynomial[0]);
    if size == 0.0 {
        return middle;
    }
    middle.inflate(raised(size, polynomial.len()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::form::monomials::Monomials;

    /// Integers of 51 bits at time `1 + 2^-20`, against exact integers.
    #[test]
    fn rounding_is_told() {
        let monomials = Monomials::new(&[], 0);
        let mut seed = 3_u64;
        let mut draw = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 24) as i64 - (1 << 39)
        };
        let end = 1.0 + f64::powi(0.5, 20);
        let mut weights = [0.0; 4];
        crate::form::outward::powers(end, &mut weights);
        let mut rounded = 0;
        for _ in 0..500 {
            let block: Vec<i64> = (0..4).map(|_| draw()).collect();
            let floats: Vec<f64> = block.iter().map(|x| *x as f64).collect();
            let mut size = Size::new(&monomials, 4);
            size.measure(&monomials, &floats, &weights, 3);
            let found = ahead(&floats, &size, (3, end), &weights);
            // Everything times 2^60.
            let base = (1_i128 << 20) + 1;
            let exact: i128 = (0..4_u32)
                .map(|j| (i128::from(block[j as usize]) * base.pow(j)) << (20 * (3 - j)))
                .sum();
            let scale = f64::powi(2.0, 60);
            let sum = (found.polynomial[0] * scale) as i128 + (found.low * scale) as i128;
            let off = (exact - sum).abs() as f64;
            assert!(
                off <= found.lost * scale + 1.0,
                "{off} of {}",
                found.lost * scale
            );
            rounded += u32::from(off > 0.01 * found.lost * scale);
        }
        assert!(rounded > 100, "the bound is not idle: {rounded}");
    }
}
