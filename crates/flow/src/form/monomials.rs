//! Monomials of bounded degree, and which of them multiply to which.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: all indices are positions of monomials of this table"
)]

use std::collections::HashMap;

use super::outward::{UNIT, raised};

/// All monomials up to a total degree, by degree, where each variable counts with its own weight; first
/// the constant, then the variables of weight one in their order.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Monomials {
    pub(super) variables: usize,
    pub(super) degree: usize,
    /// Where each variable stands.
    linear: Vec<usize>,
    /// `exponents[a * variables + v]` is the exponent of variable `v` in monomial `a`.
    exponents: Vec<u8>,
    /// `starts[m]..starts[m + 1]` are the monomials of degree `m`.
    starts: Vec<usize>,
    /// Pairs of factors, those of product `c` at `ranges[c]..ranges[c + 1]`.
    pairs: Vec<(u32, u32)>,
    ranges: Vec<usize>,
    /// `quotients[a * variables + v]` is monomial `a` over variable `v`, or `a` itself without it.
    quotients: Vec<u32>,
    /// Most pairs that multiply to one monomial.
    pub(super) most_pairs: usize,
}

impl Monomials {
    /// In as many variables as there are `weights`, none of them zero or above `degree`.
    pub(super) fn new(weights: &[usize], degree: usize) -> Monomials {
        let variables = weights.len();
        let degree = if variables == 0 { 0 } else { degree };
        let mut list: Vec<Vec<u8>> = vec![vec![0; variables]];
        let mut linear = vec![0; variables];
        let mut starts = vec![0, 1];
        for m in 1..=degree {
            for (v, weight) in weights
                .iter()
                .enumerate()
                .filter(|(_, weight)| **weight <= m)
            {
                // Those of the right degree without a later variable, times this one.
                for a in starts[m - weight]..starts[m - weight + 1] {
                    if list[a][v + 1..].iter().all(|e| *e == 0) {
                        let mut next = list[a].clone();
                        next[v] += 1;
                        if a == 0 {
                            linear[v] = list.len();
                        }
                        list.push(next);
                    }
                }
            }
            starts.push(list.len());
        }
        let position: HashMap<&[u8], usize> =
            list.iter().enumerate().map(|(a, e)| (&e[..], a)).collect();
        let mut products: Vec<Vec<(u32, u32)>> = vec![Vec::new(); list.len()];
        for (a, left) in list.iter().enumerate() {
            for (b, right) in list.iter().enumerate() {
                let product: Vec<u8> = left.iter().zip(right).map(|(l, r)| l + r).collect();
                if let Some(&c) = position.get(&product[..]) {
                    products[c].push((a as u32, b as u32));
                }
            }
        }
        let mut quotients = Vec::with_capacity(list.len() * variables);
        for (a, own) in list.iter().enumerate() {
            for v in 0..variables {
                let mut lower = own.clone();
                lower[v] = lower[v].saturating_sub(1);
                quotients.push(position.get(&lower[..]).map_or(a, |b| *b) as u32);
            }
        }
        let mut ranges = vec![0];
        let mut pairs = Vec::new();
        for list in &products {
            pairs.extend(list);
            ranges.push(pairs.len());
        }
        Monomials {
            variables,
            degree,
            linear,
            exponents: list.concat(),
            starts,
            most_pairs: products.iter().map(Vec::len).max().unwrap_or(1),
            pairs,
            ranges,
            quotients,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.ranges.len() - 1
    }

    /// The monomials of degree `m`.
    pub(super) fn of_degree(&self, m: usize) -> std::ops::Range<usize> {
        self.starts[m]..self.starts[m + 1]
    }

    /// Number of products of two monomials: what one multiplication of polynomials costs.
    pub(super) fn products(&self) -> usize {
        self.pairs.len()
    }

    /// The factors of monomial `c`.
    #[inline(always)]
    pub(super) fn factors(&self, c: usize) -> &[(u32, u32)] {
        &self.pairs[self.ranges[c]..self.ranges[c + 1]]
    }

    /// The monomial that is variable `v` alone.
    pub(super) fn linear(&self, v: usize) -> usize {
        self.linear[v]
    }

    /// Monomial `a` over variable `v`, which it must contain.
    pub(super) fn quotient(&self, a: usize, v: usize) -> usize {
        self.quotients[a * self.variables + v] as usize
    }

    /// The exponents of monomial `a`, one for each variable.
    pub(super) fn exponents(&self, a: usize) -> &[u8] {
        &self.exponents[a * self.variables..(a + 1) * self.variables]
    }

    /// True if monomial `a` is a square, which is never negative.
    pub(super) fn is_even(&self, a: usize) -> bool {
        self.exponents(a).iter().all(|e| e % 2 == 0)
    }
}

impl Monomials {
    /// Puts `middle + radius x` for variable `v`; returns a bound of what rounding took.
    ///
    /// A coefficient is a sum of at most `(q + 1)^2` terms none of which passes through more than `4 q`
    /// roundings; the terms together are at most `(|middle| + radius)^q`, or one, times the sum of the
    /// coefficients before.
    pub(super) fn substitute(
        &self,
        polynomial: &mut [f64],
        v: usize,
        middle: f64,
        radius: f64,
    ) -> f64 {
        let mut size = 0.0;
        let mut q = 0;
        for (a, x) in polynomial.iter().enumerate() {
            let exponent = usize::from(self.exponents(a)[v]);
            if exponent > 0 && *x != 0.0 {
                size += x.abs();
                q = q.max(exponent);
            }
        }
        if q == 0 {
            return 0.0;
        }
        for low in 0..q {
            for exponent in (low + 1..=q).rev() {
                for a in 0..self.len() {
                    if usize::from(self.exponents(a)[v]) == exponent {
                        let below = self.quotient(a, v);
                        polynomial[below] += middle * polynomial[a];
                    }
                }
            }
        }
        for (a, x) in polynomial.iter_mut().enumerate() {
            for _ in 0..self.exponents(a)[v] {
                *x *= radius;
            }
        }
        let all: f64 = polynomial.iter().map(|x| x.abs()).sum();
        let growth = (1.0 + middle.abs()).max(radius).powi(q as i32);
        // With `q` the highest power there is.
        let roundings = (4 * q * (q + 1) * (q + 1)) as f64;
        raised(
            roundings * UNIT * (size * growth + all),
            self.len() + 2 * q + 8,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::Monomials;

    #[test]
    fn counts_and_products() {
        let cases = [
            (vec![], 3, 1),
            (vec![1; 1], 4, 5),
            (vec![1; 2], 4, 15),
            (vec![1; 7], 2, 36),
            (vec![1; 3], 1, 4),
            // 1, x, y, x², xy, y², z, x³, .., y³, xz, yz
            (vec![1, 1, 2], 3, 13),
        ];
        for (weights, degree, count) in cases {
            let (table, variables) = (Monomials::new(&weights, degree), weights.len());
            assert_eq!(table.len(), count);
            let mut seen = 0;
            for c in 0..count {
                for &(a, b) in table.factors(c) {
                    seen += 1;
                    for v in 0..variables {
                        let sum = table.exponents(a as usize)[v] + table.exponents(b as usize)[v];
                        assert_eq!(sum, table.exponents(c)[v]);
                    }
                }
            }
            // Pairs of monomials are monomials in twice the variables.
            let twice = [&weights[..], &weights].concat();
            assert_eq!(seen, Monomials::new(&twice, degree).len());
            for (v, weight) in weights.iter().enumerate() {
                assert_eq!(table.exponents(table.linear(v))[v], 1);
                assert!(
                    *weight > 1 || table.linear(v) == 1 + v,
                    "variables come first"
                );
            }
        }
    }
}
