//! How large the polynomials of [`super::series`] are, by order in time and by degree.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: a block owns `monomials * stride` numbers; orders stay below the stride"
)]

use super::monomials::Monomials;
use super::outward::{UNIT, raised};

/// Upper bounds of sums of the absolute coefficients of one polynomial, each times its power of the
/// longest time.
#[derive(Debug, Clone)]
pub(super) struct Size {
    /// Highest order in time.
    pub(super) top: usize,
    /// By order in time.
    pub(super) time: Vec<f64>,
    /// By degree in the unknowns.
    pub(super) degree: Vec<f64>,
    /// All of them: a bound of the polynomial.
    pub(super) total: f64,
    /// All but the constant.
    pub(super) deviation: f64,
    /// The constant itself.
    pub(super) centre: f64,
    /// Each order in time counted as often as its number.
    moment: f64,
}

impl Size {
    pub(super) fn new(monomials: &Monomials, stride: usize) -> Size {
        Size {
            top: 0,
            time: vec![0.0; stride],
            degree: vec![0.0; monomials.degree + 1],
            total: 0.0,
            deviation: 0.0,
            centre: 0.0,
            moment: 0.0,
        }
    }

    /// Of the polynomial in `block`, its orders up to `top`; `weights` bound the powers of time.
    #[inline(always)]
    pub(super) fn measure(
        &mut self,
        monomials: &Monomials,
        block: &[f64],
        weights: &[f64],
        top: usize,
    ) {
        let stride = self.time.len();
        self.top = top;
        self.time.fill(0.0);
        for (m, slot) in self.degree.iter_mut().enumerate() {
            let range = monomials.of_degree(m);
            let operations = range.len() * (top + 1) + 1;
            let mut sum = 0.0;
            for a in range {
                let row = &block[a * stride..=a * stride + top];
                for ((value, weight), slot) in row.iter().zip(weights).zip(&mut self.time) {
                    let size = value.abs() * weight;
                    *slot += size;
                    sum += size;
                }
            }
            *slot = raised(sum, operations);
        }
        let mut moment = 0.0;
        for (j, slot) in self.time.iter_mut().enumerate().take(top + 1) {
            *slot = raised(*slot, monomials.len() + 1);
            moment += j as f64 * *slot;
        }
        self.moment = raised(moment, top + 2);
        self.total = raised(self.degree.iter().sum(), self.degree.len());
        self.centre = block[0];
        // Degree 0 without order 0, and all other degrees.
        let moving: f64 = block[1..=top]
            .iter()
            .zip(&weights[1..])
            .map(|(value, weight)| value.abs() * weight)
            .sum();
        let others: f64 = self.degree[1..].iter().sum();
        self.deviation = raised(moving + others, top + 2 + self.degree.len());
    }

    /// What the product of two polynomials loses when its orders up to `top` and the degrees of the table
    /// are computed by [`super::convolve::convolve`]: the other terms, and rounding.
    ///
    /// Proof. A coefficient of order `j` is a sum of at most `n = P (j + 1)` products, `P` the most pairs
    /// of monomials, none of which passes through more than `n` roundings: its error is at most
    /// `n u / (1 - n u)` times the sum of the absolute products. Over all coefficients these are at most
    /// `P u Σ_il (i + l + 1) A_i B_l`, up to the last factor, which 1.01 pays for. Where one factor has
    /// order 0 only, `n = P`.
    #[inline(always)]
    pub(super) fn product(&self, other: &Size, monomials: &Monomials, top: usize) -> f64 {
        let (a, b) = (self.total, other.total);
        let moments = if self.top == 0 || other.top == 0 {
            0.0
        } else {
            self.moment * b + a * other.moment
        };
        let rounding = 1.01 * UNIT * monomials.most_pairs as f64 * (moments + a * b);
        let by_order = beyond(&self.time[..=self.top], &other.time[..=other.top], top);
        let by_degree = beyond(&self.degree, &other.degree, monomials.degree);
        raised(rounding + by_order + by_degree, 8)
    }
}

/// An upper bound of `Σ a_i b_l` over `i + l > limit`.
#[inline(always)]
pub(super) fn beyond(a: &[f64], b: &[f64], limit: usize) -> f64 {
    if a.len() + b.len() <= limit + 2 {
        return 0.0;
    }
    let mut sum = 0.0;
    let mut tail = 0.0;
    let mut from = b.len();
    for (i, x) in a.iter().enumerate() {
        // All `b_l` with `l > limit - i`.
        let wanted = (limit + 1).saturating_sub(i);
        while from > wanted {
            from -= 1;
            tail += b[from];
        }
        sum += x * tail;
    }
    raised(sum, a.len() + b.len() + 2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::form::convolve::convolve;

    #[test]
    fn what_lies_beyond() {
        let (a, b) = ([1.0, 2.0, 4.0], [8.0, 16.0, 32.0]);
        for limit in 0..6 {
            let mut exact = 0.0;
            for (i, x) in a.iter().enumerate() {
                for (l, y) in b.iter().enumerate() {
                    exact += if i + l > limit { x * y } else { 0.0 };
                }
            }
            let bound = beyond(&a, &b, limit);
            assert!(bound >= exact && bound <= exact * (1.0 + 1e-12) + 1e-280);
        }
    }

    /// Random polynomials in one unknown and time: the true product differs from the computed one by
    /// no more than said, at random points, in exact integers.
    #[test]
    fn a_product_loses_no_more_than_said() {
        let monomials = Monomials::new(&[1], 2);
        let (stride, top) = (4, 3);
        let mut seed = 9_u64;
        let mut draw = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            ((seed >> 40) as f64 - 8_388_608.0) / 64.0
        };
        let mut widest: f64 = 0.0;
        for _ in 0..2000 {
            let a: Vec<f64> = (0..12).map(|_| draw()).collect();
            let b: Vec<f64> = (0..12).map(|_| draw()).collect();
            let weights = [1.0; 4];
            let mut sizes = [Size::new(&monomials, stride), Size::new(&monomials, stride)];
            sizes[0].measure(&monomials, &a, &weights, top);
            sizes[1].measure(&monomials, &b, &weights, top);
            let said = sizes[0].product(&sizes[1], &monomials, top);
            for (d, s) in [
                (1.0, 1.0),
                (-1.0, 1.0),
                (1.0, -1.0),
                (0.5, 0.5),
                (-1.0, -0.5),
            ] {
                let at = |p: &[f64]| -> f64 {
                    (0..12)
                        .map(|i| p[i] * f64::powi(d, i as i32 / 4) * f64::powi(s, i as i32 % 4))
                        .sum()
                };
                let mut computed = 0.0;
                for c in 0..3 {
                    for j in 0..4 {
                        let mut sum = 0.0;
                        for &(x, y) in monomials.factors(c) {
                            let (x, y) = (x as usize * 4, y as usize * 4);
                            sum += convolve(&a[x..=x + j], &b[y..=y + j]);
                        }
                        computed += sum * f64::powi(d, c as i32) * f64::powi(s, j as i32);
                    }
                }
                let lost = (at(&a) * at(&b) - computed).abs();
                assert!(lost <= said, "{lost} of {said}");
                widest = widest.max(lost / said);
            }
        }
        assert!(widest > 0.3, "the bound is not idle: {widest}");
    }

    /// Products of large integers round; exact integers tell by how much.
    #[test]
    fn rounding_stays_below_what_is_said() {
        let monomials = Monomials::new(&[], 0);
        let (stride, top) = (16, 15);
        let mut seed = 77_u64;
        let mut draw = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 12) as i64 - (1 << 51)
        };
        let mut widest: f64 = 0.0;
        for _ in 0..500 {
            let a: Vec<i64> = (0..8).map(|_| draw()).chain([0; 8]).collect();
            let b: Vec<i64> = (0..8).map(|_| draw()).chain([0; 8]).collect();
            let float = |x: &[i64]| -> Vec<f64> { x.iter().map(|x| *x as f64).collect() };
            let (fa, fb) = (float(&a), float(&b));
            let mut sizes = [Size::new(&monomials, stride), Size::new(&monomials, stride)];
            sizes[0].measure(&monomials, &fa, &[1.0; 16], top);
            sizes[1].measure(&monomials, &fb, &[1.0; 16], top);
            let said = sizes[0].product(&sizes[1], &monomials, top);
            let mut lost = 0.0;
            for j in 0..=14 {
                let exact: i128 = (0..=j)
                    .map(|i| i128::from(a[i]) * i128::from(b[j - i]))
                    .sum();
                lost += (convolve(&fa[..=j], &fb[..=j]) as i128 - exact).abs() as f64;
            }
            assert!(lost <= said, "{lost} of {said}");
            widest = widest.max(lost / said);
        }
        assert!(widest > 0.005, "the bound is not idle: {widest}");
    }
}
