//! How what dependence could not keep is moved: the second theorem in the comment of [`super`].
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: vectors have one entry per state, matrices `n * n`; orders stay below the stride"
)]

use super::compare::exponential;
use super::convolve::convolve;
use super::outward::{UNIT, raised};
use super::piece::Piece;
use super::set::Form;
use super::size::beyond;
use super::step::{Bounds, Scratch};
use veribound_interval::Interval;

impl Piece {
    /// Solution matrix of the variational equation along the centre, as polynomial in time and at
    /// all times of `end`.
    pub(super) fn fundamental(
        &self,
        form: &Form,
        scratch: &Scratch,
        unit: f64,
        end: Interval,
    ) -> Fundamental {
        let n = self.states;
        let orders = form.slopes();
        let stride = orders + 1;
        let mut values = vec![0.0; n * n * stride];
        for i in 0..n {
            values[(i * n + i) * stride] = 1.0;
        }
        for j in 0..orders {
            let factor = unit / (j + 1) as f64;
            for &(i, l, register) in &self.slopes {
                let slope = &scratch.series.block(register)[..=j];
                for c in 0..n {
                    let column = (l * n + c) * stride;
                    let sum = convolve(slope, &values[column..=column + j]);
                    values[(i * n + c) * stride + j + 1] += factor * sum;
                }
            }
        }
        let weights = &scratch.errors.weights;
        let mut time = vec![0.0; n * n * stride];
        let mut matrix = Vec::with_capacity(n * n);
        for (entry, sizes) in values
            .chunks_exact(stride)
            .zip(time.chunks_exact_mut(stride))
        {
            for (j, (value, slot)) in entry.iter().zip(sizes).enumerate() {
                *slot = raised(value.abs() * weights[j], 1);
            }
            let orders = entry.iter().rev();
            matrix.push(orders.fold(Interval::ZERO, |sum, x| sum * end + Interval::point(*x)));
        }
        Fundamental {
            stride,
            time,
            matrix,
        }
    }

    /// How far solutions can be, at any time of the step, from the polynomial plus the fundamental matrix
    /// times their deviation at the start.
    pub(super) fn leak(
        &self,
        scratch: &Scratch,
        map: &Fundamental,
        unit: f64,
        bounds: &Bounds,
        reach: &[Interval],
    ) -> Option<Vec<f64>> {
        let (n, stride) = (self.states, map.stride);
        let errors = &scratch.errors;
        let mut rate = bounds.defect.clone();
        for &(i, l, register) in &self.slopes {
            let size = &errors.sizes[register];
            let along = scratch.series.block(register);
            let top = size.top;
            let centre: Vec<f64> = along[..=top]
                .iter()
                .zip(&errors.weights)
                .map(|(x, w)| raised(x.abs() * w, 1))
                .collect();
            let others: f64 = size.degree[1..].iter().sum();
            // Rounding of the coefficients of the matrix: n products of up to `stride` terms each.
            let terms = (n * stride + 4) as f64;
            let rounding = 1.01 * UNIT * terms * centre.iter().sum::<f64>();
            let apart = raised(
                others + scratch.radii[1][register] + rounding,
                top + size.degree.len() + 4,
            );
            for (c, from) in reach.iter().enumerate() {
                let from = from.mag();
                if from == 0.0 {
                    continue;
                }
                let column = (l * n + c) * stride;
                let column = &map.time[column..column + stride];
                let total: f64 = column.iter().sum();
                // The derivative of the polynomial matrix has orders below `stride - 1`.
                let open = beyond(&centre, column, stride - 2);
                let gap = raised(apart * total + open, stride + 3);
                rate[i] = raised(rate[i] + unit * gap * from, 3);
            }
        }
        let over: Vec<f64> = rate.iter().map(|r| raised(r * bounds.span, 1)).collect();
        exponential(n, &bounds.steepness, &over, 1)
    }
}

/// The fundamental matrix: sizes of its coefficients by order in time, and its values at the end.
pub(super) struct Fundamental {
    stride: usize,
    time: Vec<f64>,
    pub(super) matrix: Vec<Interval>,
}
