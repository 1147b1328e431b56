//! Bounds of solutions of linear inequalities `v' <= C v + d` with `C >= 0`.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: matrices are `n * n`, row by row, vectors `n` long"
)]

use super::outward::raised;

/// No bound is sought beyond this: the step is too long.
const STEEPEST: f64 = 40.0;

/// An upper bound of `Σ_m C^m x / (m + shift)!`, for `C >= 0` and `x >= 0`: of `exp(C) x` with `shift` 0,
/// and of `∫_0^1 exp(C (1 - t)) x dt` with `shift` 1. `None` where `C` is too large.
///
/// Proof of the tail: in the maximum norm the term after the `m`-th is at most `|C| / (m + 1 + shift)`
/// times as large; once that is at most a half, all later terms together are at most the last one.
pub(super) fn exponential(n: usize, c: &[f64], x: &[f64], shift: usize) -> Option<Vec<f64>> {
    let norm = (0..n)
        .map(|i| raised(c[i * n..(i + 1) * n].iter().sum(), n))
        .fold(0.0, f64::max);
    if norm.is_nan() || norm >= STEEPEST {
        return None;
    }
    let (mut term, mut sum) = (x.to_vec(), x.to_vec());
    for m in 1..400 {
        let over = (m + shift) as f64;
        term = (0..n)
            .map(|i| {
                let row = &c[i * n..(i + 1) * n];
                let product: f64 = row.iter().zip(&term).map(|(c, t)| c * t).sum();
                raised(product / over, n + 2)
            })
            .collect();
        let mut largest: f64 = 0.0;
        let mut smallest = f64::INFINITY;
        for (slot, t) in sum.iter_mut().zip(&term) {
            *slot = raised(*slot + t, 1);
            largest = largest.max(*t);
            smallest = smallest.min(*slot);
        }
        if norm <= 0.5 * (m + 1 + shift) as f64 && (largest <= 1e-4 * smallest || m > 60) {
            for slot in &mut sum {
                *slot = raised(*slot + largest, 1);
            }
            return Some(sum);
        }
    }
    None
}
