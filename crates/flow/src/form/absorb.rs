//! What dependence could not keep becomes unknowns of its own.
//!
//! `E` moves by one matrix, and how `∂f/∂x` varies over the set only widens it, step after step. As
//! *fresh unknowns* `η` of the polynomials it takes part in products with the others, so that it is moved
//! by the matrix that belongs to each `δ`. When the new `E` has grown to a share of the fresh unknowns,
//! both together become the next ones. Fresh unknowns count several degrees, so that there are few
//! products with them.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one polynomial per state, one coefficient per monomial, matrices `n * n`"
)]

use super::frame::{Frame, column, orthogonal, skewness};
use super::outward::{UNIT, raised};
use super::set::Form;
use veribound_interval::Interval;

/// Below this share of the set, what dependence could not keep is not worth the work.
const SMALL: f64 = 1e-9;

impl Form {
    /// Makes fresh unknowns where that is worth it.
    pub(super) fn absorb(&mut self) {
        let (n, kept) = (self.states.len(), self.unknowns.len());
        if self.monomials.variables == kept {
            return;
        }
        let rest = self.frame.hull();
        let mut share: f64 = 0.0;
        for (polynomial, rest) in self.states.iter().zip(&rest) {
            let (mut own, mut fresh) = (0.0, 0.0);
            for (a, x) in polynomial.iter().enumerate().skip(1) {
                if self.is_fresh(a) {
                    fresh += x.abs();
                } else {
                    own += x.abs();
                }
            }
            let before = fresh + SMALL * (own + 1e-3 * polynomial[0].abs()) + 1e-250;
            share = share.max(rest.mag() / before);
        }
        if share > self.options.absorb {
            self.renew(n, kept);
        }
    }

    /// True if a fresh unknown is in monomial `a`.
    pub(super) fn is_fresh(&self, a: usize) -> bool {
        let exponents = self.monomials.exponents(a);
        exponents[self.unknowns.len()..].iter().any(|e| *e > 0)
    }

    /// Encloses the part of the fresh unknowns `L η + ..` and `E` in `Q r`, and calls `r` fresh unknowns.
    ///
    /// Proof. Any `z` of both is `L η + c + e` with `c` in the box of the products with `η`. With any
    /// `Q`, `y = Q' z` lies in the box computed, and `z = Q r` with `r` as near to `y` as the proof in
    /// `frame.rs` says. With the middle `m` and radius `ρ` of the box of `r`, `z = Q m + Q diag(ρ) η'` for
    /// some `η'` in the unit box; the products `Q diag(ρ)` are rounded, and that and `Q m` are the new `E`.
    fn renew(&mut self, n: usize, kept: usize) {
        let mut linear = vec![0.0; n * n];
        let mut products = vec![0.0; n];
        let fresh: Vec<usize> = (0..self.monomials.len())
            .filter(|a| self.is_fresh(*a))
            .collect();
        for (i, polynomial) in self.states.iter().enumerate() {
            for v in 0..n {
                linear[i * n + v] = polynomial[self.monomials.linear(kept + v)];
            }
            let all = fresh.iter().map(|a| polynomial[*a].abs()).sum();
            let alone: f64 = linear[i * n..(i + 1) * n].iter().map(|x| x.abs()).sum();
            // Rounding of a difference of sums: the whole may be off by its own bound.
            let difference = (raised(all, fresh.len()) - alone).max(0.0);
            products[i] = raised(difference + 2.0 * UNIT * all * fresh.len() as f64, 4);
        }
        let (axes, reach) = self.frame.coordinates();
        let scaled = |matrix: &[f64], c: usize, scale: f64| -> Vec<f64> {
            (0..n).map(|i| matrix[i * n + c] * scale).collect()
        };
        let edges = (0..n)
            .map(|c| scaled(&linear, c, 1.0))
            .chain((0..n).map(|c| scaled(axes, c, reach[c].rad())))
            .collect();
        let hull = self.frame.hull();
        let mut best: Option<(f64, Vec<f64>, Vec<Interval>)> = None;
        for q in [
            orthogonal(n, edges),
            Frame::upright(hull.clone()).coordinates().0.to_vec(),
        ] {
            let Some(skew) = skewness(n, &q) else {
                continue;
            };
            let y = within(n, &q, (&linear, &products), (axes, reach, &hull));
            let largest = y.iter().map(|x| x.mag()).fold(0.0, f64::max);
            let wider = raised(skew * largest, 2);
            let r: Vec<Interval> = y.iter().map(|x| x.inflate(wider)).collect();
            // The sum of the widths of the box around, each seen from the width that has to be.
            let size = (0..n).map(|i| {
                let row = &q[i * n..(i + 1) * n];
                let around: f64 = row.iter().zip(&r).map(|(q, r)| q.abs() * r.rad()).sum();
                let least: f64 = linear[i * n..(i + 1) * n].iter().map(|x| x.abs()).sum();
                around / (least + products[i] + hull[i].rad() + 1e-290)
            });
            let size: f64 = size.sum();
            if best.as_ref().is_none_or(|(least, ..)| size < *least) {
                best = Some((size, q, r));
            }
        }
        let Some((_, q, r)) = best else { return };
        let (middles, radii): (Vec<f64>, Vec<f64>) = r.iter().map(|x| x.mid_rad()).unzip();
        let mut rest = Vec::with_capacity(n);
        for (i, polynomial) in self.states.iter_mut().enumerate() {
            for a in &fresh {
                polynomial[*a] = 0.0;
            }
            let mut own = Interval::ZERO;
            for v in 0..n {
                let (axis, radius) = (q[i * n + v], radii[v]);
                let edge = axis * radius;
                polynomial[self.monomials.linear(kept + v)] = edge;
                own += Interval::point(axis) * Interval::point(middles[v]);
                own += Interval::symmetric(raised(UNIT * edge.abs(), 1));
            }
            rest.push(own);
        }
        self.frame = Frame::upright(rest);
    }
}

/// Encloses `Q' (L η + c + e)` for all `η` in the unit box, `c` in the box of `products` and `e` both in the
/// frame (`axes`, `reach`) and in the box `hull`.
fn within(
    n: usize,
    q: &[f64],
    (linear, products): (&[f64], &[f64]),
    (axes, reach, hull): (&[f64], &[Interval], &[Interval]),
) -> Vec<Interval> {
    let unit = Interval::symmetric(1.0);
    let is_empty = |l: usize| (0..n).all(|i| linear[i * n + l] == 0.0);
    let full: Vec<usize> = (0..n).filter(|l| !is_empty(*l)).collect();
    let long: Vec<usize> = (0..n).filter(|l| reach[*l] != Interval::ZERO).collect();
    (0..n)
        .map(|c| {
            let axis = column(n, q, c);
            let along = |matrix: &[f64], l: usize| {
                let parts = axis.iter();
                let parts = parts.map(|&(i, q)| q * Interval::point(matrix[i * n + l]));
                parts.fold(Interval::ZERO, |sum, x| sum + x)
            };
            let mut sum = Interval::ZERO;
            let (mut by_frame, mut by_box) = (Interval::ZERO, Interval::ZERO);
            for &l in &full {
                sum += along(linear, l) * unit;
            }
            for &l in &long {
                by_frame += along(axes, l) * reach[l];
            }
            for &(l, own) in &axis {
                sum += own * Interval::symmetric(products[l]);
                by_box += own * hull[l];
            }
            sum + by_frame.intersect(by_box)
        })
        .collect()
}
