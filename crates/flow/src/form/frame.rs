//! What dependence could not keep: a parallelepiped `Q r` with a nearly orthogonal matrix `Q`, cut with a
//! box.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: matrices are `n * n`, row by row, vectors `n` long"
)]

use super::outward::{UNIT, raised};
use veribound_interval::Interval;

/// All `Q r` with `r` in a box, as far as they lie in another box.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Frame {
    n: usize,
    axes: Vec<f64>,
    reach: Vec<Interval>,
    around: Vec<Interval>,
}

impl Frame {
    /// A box.
    pub(super) fn upright(reach: Vec<Interval>) -> Frame {
        let n = reach.len();
        let mut axes = vec![0.0; n * n];
        for i in 0..n {
            axes[i * n + i] = 1.0;
        }
        Frame {
            n,
            axes,
            around: reach.clone(),
            reach,
        }
    }

    pub(super) fn is_bounded(&self) -> bool {
        self.reach
            .iter()
            .chain(&self.around)
            .all(|r| r.is_bounded() && !r.is_empty())
    }

    /// The matrix, row by row, and the box of its coordinates.
    pub(super) fn coordinates(&self) -> (&[f64], &[Interval]) {
        (&self.axes, &self.reach)
    }

    /// A box around it.
    pub(super) fn hull(&self) -> Vec<Interval> {
        (0..self.n)
            .map(|i| {
                let row = &self.axes[i * self.n..(i + 1) * self.n];
                row.iter()
                    .zip(&self.reach)
                    .map(|(q, r)| Interval::point(*q) * *r)
                    .fold(Interval::ZERO, |sum, x| sum + x)
                    .intersect(self.around[i])
            })
            .collect()
    }

    /// The image under the matrix `map`, plus `offset`, less the vector returned, which is about the
    /// middle of it; [`Moved::completed`] adds what else there is.
    pub(super) fn moved(&self, map: &[Interval], offset: &[Interval]) -> (Moved, Vec<f64>) {
        let n = self.n;
        let mut image = vec![Interval::ZERO; n * n];
        for i in 0..n {
            for l in 0..n {
                let m = map[i * n + l];
                if m == Interval::ZERO {
                    continue;
                }
                let axes = &self.axes[l * n..(l + 1) * n];
                for (slot, axis) in image[i * n..(i + 1) * n].iter_mut().zip(axes) {
                    if *axis != 0.0 {
                        *slot += m * Interval::point(*axis);
                    }
                }
            }
        }
        let middle: Vec<f64> = self.reach.iter().map(|r| r.mid()).collect();
        let centred: Vec<Interval> = self
            .reach
            .iter()
            .zip(&middle)
            .map(|(r, m)| *r - Interval::point(*m))
            .collect();
        let rest: Vec<Interval> = (0..n)
            .map(|i| {
                (0..n).fold(offset[i], |sum, c| {
                    sum + image[i * n + c] * Interval::point(middle[c])
                })
            })
            .collect();
        let shift: Vec<f64> = rest.iter().map(|x| x.mid()).collect();
        let around = (0..n)
            .map(|i| {
                let start = offset[i] - Interval::point(shift[i]);
                let row = &map[i * n..(i + 1) * n];
                let image = row.iter().zip(&self.around).map(|(m, x)| *m * *x);
                image.fold(start, |sum, x| sum + x)
            })
            .collect();
        let rest = rest
            .iter()
            .zip(&shift)
            .map(|(x, s)| *x - Interval::point(*s))
            .collect();
        let moved = Moved {
            n,
            image,
            centred,
            rest,
            around,
        };
        (moved, shift)
    }
}

/// A frame on its way: `image * centred + rest`.
pub(super) struct Moved {
    n: usize,
    image: Vec<Interval>,
    centred: Vec<Interval>,
    rest: Vec<Interval>,
    around: Vec<Interval>,
}

impl Moved {
    /// The frame that contains `image * centred + rest + more`, cut with the image of the box.
    ///
    /// Proof. With any matrix `Q` and `y = Q'(image * centred + rest + more)`, the vector
    /// `r = (Q'Q)^-1 y` satisfies `Q r = image * centred + rest + more`. For `Q'Q = I + D` with
    /// `|D| <= d < 1` in the maximum norm, `r = y - D r`, so `|r - y| <= d |y| / (1 - d)`. Whatever `Q`
    /// was computed, `d` is bounded from it; for a singular one there is no such `d`, and the box is
    /// taken instead.
    pub(super) fn completed(self, more: &[Interval]) -> Frame {
        let n = self.n;
        let widened = |part: &[Interval]| -> Vec<Interval> {
            part.iter().zip(more).map(|(a, b)| *a + *b).collect()
        };
        let (rest, around) = (widened(&self.rest), widened(&self.around));
        let edges: Vec<Vec<f64>> = (0..n)
            .map(|c| {
                let radius = self.centred[c].rad();
                (0..n)
                    .map(|i| self.image[i * n + c].mid() * radius)
                    .collect()
            })
            .collect();
        let axes = orthogonal(n, edges);
        let Some(skew) = skewness(n, &axes) else {
            return Frame::upright(around);
        };
        let mut y = vec![Interval::ZERO; n];
        for (c, slot) in y.iter_mut().enumerate() {
            let axis = column(n, &axes, c);
            for l in (0..n).filter(|l| self.centred[*l] != Interval::ZERO) {
                let parts = axis.iter().map(|&(i, q)| q * self.image[i * n + l]);
                let entry = parts.fold(Interval::ZERO, |sum, x| sum + x);
                *slot += entry * self.centred[l];
            }
            for &(i, q) in &axis {
                *slot += q * rest[i];
            }
        }
        let largest = y.iter().map(|x| x.mag()).fold(0.0, f64::max);
        let wider = raised(skew * largest, 2);
        if !wider.is_finite() {
            return Frame::upright(around);
        }
        let reach = y.iter().map(|x| x.inflate(wider)).collect();
        Frame {
            n,
            axes,
            reach,
            around,
        }
    }
}

/// What is not zero in column `c` of a matrix, each with its row: of many states most axes stand upright.
pub(super) fn column(n: usize, matrix: &[f64], c: usize) -> Vec<(usize, Interval)> {
    let rows = (0..n).map(|i| (i, matrix[i * n + c]));
    let rows = rows.filter(|(_, x)| *x != 0.0);
    rows.map(|(i, x)| (i, Interval::point(x))).collect()
}

/// An upper bound of `d / (1 - d)` with `d` the maximum norm of `Q'Q - I`; `None` unless `d < 1/2`.
pub(super) fn skewness(n: usize, q: &[f64]) -> Option<f64> {
    let mut norm: f64 = 0.0;
    for a in 0..n {
        let mut row = 0.0;
        for b in 0..n {
            let (mut sum, mut size) = (0.0, 0.0);
            for i in 0..n {
                sum += q[i * n + a] * q[i * n + b];
                size += (q[i * n + a] * q[i * n + b]).abs();
            }
            let wanted = if a == b { 1.0 } else { 0.0 };
            // The sum is off by at most n u times the sum of sizes; the difference by one rounding more.
            row += (sum - wanted).abs() + (n + 2) as f64 * 2.0 * UNIT * size;
        }
        norm = norm.max(raised(row, 4 * n + 4));
    }
    (norm < 0.5).then(|| raised(norm / (1.0 - norm), 4))
}

/// A nearly orthogonal matrix whose first columns point along the longest of `edges`.
pub(super) fn orthogonal(n: usize, mut edges: Vec<Vec<f64>>) -> Vec<f64> {
    let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    edges.sort_by(|x, y| norm(y).total_cmp(&norm(x)));
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(n);
    let units = (0..n).map(|i| (0..n).map(|l| if i == l { 1.0 } else { 0.0 }).collect());
    let candidates = edges.into_iter().chain(units);
    for candidate in candidates {
        if basis.len() == n {
            break;
        }
        let length = norm(&candidate);
        if !(length > 0.0 && length.is_finite()) {
            continue;
        }
        let mut v: Vec<f64> = candidate.iter().map(|x| x / length).collect();
        for _ in 0..2 {
            for b in &basis {
                let along: f64 = v.iter().zip(b).map(|(x, y)| x * y).sum();
                if along == 0.0 {
                    continue;
                }
                for (x, y) in v.iter_mut().zip(b) {
                    *x -= along * y;
                }
            }
        }
        let left = norm(&v);
        // Nearly dependent columns leave their place to the unit vectors.
        if left > 1e-8 {
            basis.push(v.iter().map(|x| x / left).collect());
        }
    }
    let mut q = vec![0.0; n * n];
    for (c, b) in basis.iter().enumerate() {
        for (i, x) in b.iter().enumerate() {
            q[i * n + c] = *x;
        }
    }
    q
}
