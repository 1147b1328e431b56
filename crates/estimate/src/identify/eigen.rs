//! Axes along which rows are thin: a hint, in plain floating point.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: matrices are `n * n`, row by row"
)]

/// Rounds of rotations; each squares what is left off the diagonal.
const ROUNDS: usize = 12;

/// About the eigenvectors of a symmetric matrix, as columns (Jacobi's method).
pub(crate) fn eigenvectors(n: usize, matrix: &[f64]) -> Vec<Vec<f64>> {
    let mut a = matrix.to_vec();
    let mut columns: Vec<Vec<f64>> = (0..n)
        .map(|i| (0..n).map(|l| if i == l { 1.0 } else { 0.0 }).collect())
        .collect();
    for _ in 0..ROUNDS {
        for p in 0..n {
            for q in p + 1..n {
                let off = a[p * n + q];
                if off == 0.0 || !off.is_finite() {
                    continue;
                }
                let theta = (a[q * n + q] - a[p * n + p]) / (2.0 * off);
                let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
                let t = if theta == 0.0 { 1.0 } else { t };
                let c = 1.0 / (t * t + 1.0).sqrt();
                let s = t * c;
                for k in 0..n {
                    let (x, y) = (a[k * n + p], a[k * n + q]);
                    a[k * n + p] = c * x - s * y;
                    a[k * n + q] = s * x + c * y;
                }
                for k in 0..n {
                    let (x, y) = (a[p * n + k], a[q * n + k]);
                    a[p * n + k] = c * x - s * y;
                    a[q * n + k] = s * x + c * y;
                }
                let (before, after) = columns.split_at_mut(q);
                for (x, y) in before[p].iter_mut().zip(&mut after[0]) {
                    (*x, *y) = (c * *x - s * *y, s * *x + c * *y);
                }
            }
        }
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::eigenvectors;

    #[test]
    fn the_axes_of_an_ellipse() {
        // 9 along (0.6, 0.8), 1 across.
        let matrix = [1.0 + 8.0 * 0.36, 8.0 * 0.48, 8.0 * 0.48, 1.0 + 8.0 * 0.64];
        let columns = eigenvectors(2, &matrix);
        let along = columns
            .iter()
            .any(|v| (v[0] * 0.6 + v[1] * 0.8).abs() > 1.0 - 1e-12);
        assert!(along);
    }
}
