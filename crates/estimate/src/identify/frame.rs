//! Frames of parameters: axes along what is left of them, with proved inverses and volumes.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: matrices have one row per parameter and one column per axis, and square ones as many of both"
)]

use serde::{Deserialize, Serialize};
use veribound_interval::Interval;

/// Coordinates of parameters: unknowns `y` stand for the parameters `centre + axes·y`, with exactly these numbers.
///
/// ```
/// use veribound_estimate::identify::Frame;
/// use veribound_interval::Interval;
///
/// // A square on its corner, with sides of the root of two.
/// let frame = Frame { centre: vec![1.0, 2.0], axes: vec![vec![1.0, -1.0], vec![1.0, 1.0]] };
/// let whole = [Interval::symmetric(0.5), Interval::symmetric(0.5)];
/// assert!(frame.hull(&whole)[0].contains(2.0) && !frame.hull(&whole)[1].contains(0.9));
/// assert!(frame.volume(&whole).contains(2.0) && frame.volume(&whole).width() < 1e-12);
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// One number per parameter.
    pub centre: Vec<f64>,
    /// One row per parameter, one column per axis.
    pub axes: Vec<Vec<f64>>,
}

impl Frame {
    /// Encloses the parameters that belong to these unknowns.
    pub fn hull(&self, unknowns: &[Interval]) -> Vec<Interval> {
        let rows = self.axes.iter().zip(&self.centre);
        rows.map(|(row, centre)| {
            let terms = row.iter().zip(unknowns);
            terms.fold(Interval::point(*centre), |sum, (slope, y)| {
                sum + Interval::point(*slope) * *y
            })
        })
        .collect()
    }

    /// A box of parameters that all belong to these unknowns, about in their middle; nothing where it is not proved.
    ///
    /// ```
    /// # use veribound_estimate::identify::Frame;
    /// # use veribound_interval::Interval;
    /// let frame = Frame { centre: vec![1.0, 2.0], axes: vec![vec![1.0, -1.0], vec![1.0, 1.0]] };
    /// let inner = frame.inner_box(&[Interval::symmetric(0.5); 2]).unwrap();
    /// assert!(inner[0].contains(1.49) && !inner[0].contains(1.51));
    /// ```
    pub fn inner_box(&self, unknowns: &[Interval]) -> Option<Vec<Interval>> {
        let open = open(&self.axes);
        let matrix: Vec<&[f64]> = open.iter().map(|p| self.axes[*p].as_slice()).collect();
        if open.len() != unknowns.len() {
            return None;
        }
        let inverse = inverse(&matrix)?;
        let middles: Vec<Interval> = unknowns.iter().map(|y| Interval::point(y.mid())).collect();
        let around = self.hull(&middles);
        let hull = self.hull(unknowns);
        // So much of the hull fits.
        let reach = |row: &Vec<Interval>| -> f64 {
            row.iter()
                .zip(&open)
                .map(|(share, p)| share.mag() * hull[*p].rad())
                .sum()
        };
        let fits = inverse
            .iter()
            .zip(unknowns)
            .map(|(row, y)| y.rad() / reach(row));
        let share = fits.fold(1.0, f64::min) * (1.0 - 1e-6);
        let inner: Vec<Interval> = { around.iter().zip(&hull) }
            .map(|(middle, hull)| {
                let (at, by) = (middle.mid(), share * hull.rad());
                Interval::new(at - by, at + by)
            })
            .collect::<Option<_>>()?;
        let is_inside = inverse.iter().zip(unknowns).all(|(row, y)| {
            let terms = row.iter().zip(&open);
            let own = terms.fold(Interval::ZERO, |sum, (by, p)| {
                sum + *by * (inner[*p] - Interval::point(self.centre[*p]))
            });
            own.is_subset_of(*y)
        });
        is_inside.then_some(inner)
    }

    /// Encloses the volume of the parameters that belong to these unknowns. Parameters that no axis changes do not count;
    /// nothing is told where there are not as many axes as others.
    pub fn volume(&self, unknowns: &[Interval]) -> Interval {
        let open = open(&self.axes).into_iter();
        let open: Vec<&[f64]> = open.map(|p| self.axes[p].as_slice()).collect();
        let widths = unknowns
            .iter()
            .map(|y| Interval::point(y.hi()) - Interval::point(y.lo()));
        widths.fold(determinant(&open), |volume, width| volume * width)
    }
}

/// The parameters that some axis changes.
pub(super) fn open(axes: &[Vec<f64>]) -> Vec<usize> {
    let is_open = |p: &usize| axes[*p].iter().any(|slope| *slope != 0.0);
    (0..axes.len()).filter(is_open).collect()
}

/// Rows and columns of a square matrix as multiples of powers of two, with which its entries are near one.
fn balanced(matrix: &[&[f64]]) -> (Vec<Vec<f64>>, Vec<f64>, Vec<f64>) {
    let power = |largest: f64| {
        if largest > 0.0 && largest.is_finite() {
            largest.log2().floor().clamp(-500.0, 500.0).exp2()
        } else {
            1.0
        }
    };
    let n = matrix.len();
    let columns: Vec<f64> = (0..n)
        .map(|c| power(matrix.iter().map(|row| row[c].abs()).fold(0.0, f64::max)))
        .collect();
    let mut scaled: Vec<Vec<f64>> = matrix
        .iter()
        .map(|row| row.iter().zip(&columns).map(|(x, s)| x / s).collect())
        .collect();
    let rows: Vec<f64> = scaled
        .iter_mut()
        .map(|row| {
            let by = power(row.iter().fold(0.0, |most: f64, x| most.max(x.abs())));
            row.iter_mut().for_each(|x| *x /= by);
            by
        })
        .collect();
    (scaled, rows, columns)
}

/// Encloses the absolute value of the determinant of a square matrix, by elimination.
fn determinant(matrix: &[&[f64]]) -> Interval {
    let n = matrix.len();
    if matrix.iter().any(|row| row.len() != n) {
        return Interval::new(0.0, f64::INFINITY).unwrap_or(Interval::ENTIRE);
    }
    let (scaled, rows, columns) = balanced(matrix);
    // What dividing by the powers of two may have lost is nothing, unless it is next to zero.
    let exact = |(row, own): (&[f64], &Vec<f64>), by: f64| {
        let parts = row.iter().zip(own).zip(&columns);
        let parts = parts.map(|((x, y), s)| {
            Interval::point(*x) / Interval::point(*s) / Interval::point(by) - Interval::point(*y)
        });
        parts.fold(0.0, |most: f64, lost| most.max(lost.mag()))
    };
    let lost = matrix.iter().copied().zip(&scaled).zip(&rows);
    let lost = lost.map(|(pair, by)| exact(pair, *by)).fold(0.0, f64::max);
    let mut left: Vec<Vec<Interval>> = { scaled.iter() }
        .map(|row| {
            row.iter()
                .map(|x| Interval::point(*x).inflate(lost))
                .collect()
        })
        .collect();
    let scales = rows.iter().chain(&columns);
    let mut product = scales.fold(Interval::ONE, |product, s| product * Interval::point(*s));
    for c in 0..n {
        let pivot = (c..n).max_by(|a, b| left[*a][c].mig().total_cmp(&left[*b][c].mig()));
        let Some(pivot) = pivot else { break };
        left.swap(c, pivot);
        if left[c][c].contains(0.0) {
            // Hadamard's bound of what is not known.
            let sizes = left[c..].iter().map(|row| {
                let squares = row[c..].iter().map(|x| *x * *x);
                squares.fold(Interval::ZERO, |sum, x| sum + x)
            });
            let most = sizes.fold(Interval::ONE, |most, size| {
                most * Interval::point(size.hi())
            });
            let most = most.sqrt().hi() * product.hi();
            return Interval::new(0.0, most.next_up()).unwrap_or(Interval::ENTIRE);
        }
        product *= left[c][c].abs();
        let above = left[c].clone();
        for row in &mut left[c + 1..] {
            let share = row[c] / above[c];
            let pairs = row.iter_mut().zip(&above).skip(c + 1);
            pairs.for_each(|(x, own)| *x -= share * *own);
        }
    }
    product
}

/// Encloses the inverse of a square matrix; nothing where that is not proved to exist.
///
/// Proof. For any matrix `W`, with `E = I - W A` and row sums of `|E|` at most `e < 1`, `A` has the inverse
/// `(I - E)^-1 W`, and no entry of `(I - E)^-1 - I = E + E^2 + ...` is larger than `e / (1 - e)`.
pub(crate) fn inverse(matrix: &[&[f64]]) -> Option<Vec<Vec<Interval>>> {
    let n = matrix.len();
    let (scaled, rows, columns) = balanced(matrix);
    let guess = solved(scaled)?;
    // Columns of a balanced matrix are rows of its inverse.
    let guess: Vec<Vec<f64>> = { guess.iter().zip(&columns) }
        .map(|(row, by)| row.iter().zip(&rows).map(|(x, s)| x / s / by).collect())
        .collect();
    let mut far: f64 = 0.0;
    for i in 0..n {
        let mut sum = 0.0;
        for l in 0..n {
            let product = (0..n).fold(Interval::ZERO, |sum, k| {
                sum + Interval::point(guess[i][k]) * Interval::point(matrix[k][l])
            });
            // In units of the axes, so that short and long ones count alike.
            let unit = if i == l {
                Interval::ONE
            } else {
                Interval::ZERO
            };
            let own =
                (product - unit) * (Interval::point(columns[i]) / Interval::point(columns[l]));
            sum = (Interval::point(sum) + Interval::point(own.mag())).hi();
        }
        far = far.max(sum);
    }
    if far.is_nan() || far >= 0.5 {
        return None;
    }
    let far = Interval::point(far);
    let more = (far / (Interval::ONE - far)).hi();
    let sizes: Vec<Interval> = (0..n)
        .map(|j| {
            (0..n).fold(Interval::ZERO, |sum, l| {
                sum + Interval::point(guess[l][j].abs()) * Interval::point(columns[l])
            })
        })
        .collect();
    let entry = |i: usize, j: usize| {
        let by = Interval::point(more) * sizes[j] / Interval::point(columns[i]);
        Interval::point(guess[i][j]).inflate(by.hi())
    };
    Some(
        (0..n)
            .map(|i| (0..n).map(|j| entry(i, j)).collect())
            .collect(),
    )
}

/// The inverse of a square matrix in plain floating point, by elimination.
fn solved(mut left: Vec<Vec<f64>>) -> Option<Vec<Vec<f64>>> {
    let n = left.len();
    let mut right: Vec<Vec<f64>> = (0..n)
        .map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect())
        .collect();
    for c in 0..n {
        let pivot = (c..n).max_by(|a, b| left[*a][c].abs().total_cmp(&left[*b][c].abs()))?;
        left.swap(c, pivot);
        right.swap(c, pivot);
        let by = left[c][c];
        if by == 0.0 || !by.is_finite() {
            return None;
        }
        for k in 0..n {
            left[c][k] /= by;
            right[c][k] /= by;
        }
        for r in (0..n).filter(|r| *r != c) {
            let share = left[r][c];
            for k in 0..n {
                left[r][k] -= share * left[c][k];
                right[r][k] -= share * right[c][k];
            }
        }
    }
    Some(right)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Matrices of small whole numbers, times powers of two: products and determinants are exact.
    fn matrix(seed: &mut u64, n: usize) -> Vec<Vec<f64>> {
        let mut next = || {
            *seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (*seed >> 33) as i32
        };
        let scales: Vec<i32> = (0..2 * n).map(|_| next() % 30).collect();
        (0..n)
            .map(|i| {
                (0..n)
                    .map(|j| f64::from(next() % 9) * f64::from(scales[i] + scales[n + j]).exp2())
                    .collect()
            })
            .collect()
    }

    /// The determinant, by Leibniz.
    fn exact(matrix: &[Vec<f64>], used: &mut Vec<usize>) -> f64 {
        let row = used.len();
        if row == matrix.len() {
            return 1.0;
        }
        (0..matrix.len())
            .filter(|c| !used.contains(c))
            .collect::<Vec<_>>()
            .into_iter()
            .map(|c| {
                let sign = if used.iter().filter(|before| **before > c).count() % 2 == 0 {
                    1.0
                } else {
                    -1.0
                };
                used.push(c);
                let rest = exact(matrix, used);
                used.pop();
                sign * matrix[row][c] * rest
            })
            .sum()
    }

    #[test]
    fn inverses_and_volumes_are_enclosed() {
        let mut seed = 5;
        let mut found = 0;
        for round in 0..400 {
            let n = 1 + round % 4;
            let a = matrix(&mut seed, n);
            let rows: Vec<&[f64]> = a.iter().map(Vec::as_slice).collect();
            let wanted = exact(&a, &mut Vec::new()).abs();
            let told = determinant(&rows);
            assert!(told.contains(wanted), "{a:?} {told} {wanted}");
            let Some(inverse) = inverse(&rows) else {
                continue;
            };
            found += 1;
            assert!(
                wanted > 0.0 && told.width() < 1e-9 * wanted,
                "{a:?} {told} {wanted}"
            );
            for (i, row) in inverse.iter().enumerate() {
                for (j, told) in row.iter().enumerate() {
                    // Cramer's rule: cofactor over determinant.
                    let minor: Vec<Vec<f64>> = (0..n)
                        .filter(|r| *r != j)
                        .map(|r| (0..n).filter(|c| *c != i).map(|c| a[r][c]).collect())
                        .collect();
                    let sign = if (i + j) % 2 == 0 { 1.0 } else { -1.0 };
                    let cofactor = Interval::point(sign * exact(&minor, &mut Vec::new()));
                    let entry = cofactor / Interval::point(exact(&a, &mut Vec::new()));
                    assert!(entry.intersects(*told), "{a:?}");
                }
            }
        }
        assert!(found > 200, "{found}");
    }
}
