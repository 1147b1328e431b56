//! Parallelotopes of start values and parameters.
//!
//! A region is a set of `z` (the start states of every record, then the parameters) with
//! `|z_i - c_i - M_i·δ| <= ρ_i` for some `δ` in the unit box. What samples tell are rows in `δ`; so what they leave is
//! a polytope, and a parallelotope that lies along a thin one is much smaller than a box around it. Then what is
//! not linear in `δ` is small, too.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one row of axes per quantity, one entry per axis"
)]

use serde::{Deserialize, Serialize};
use veribound_flow::form::Parallelotope;
use veribound_interval::Interval;

/// Uncertainty below this share of a value is no axis of its own.
const THIN: f64 = 1e-13;

/// Whether a quantity is known up to rounding, as a decimal that no float is.
pub(crate) fn is_thin(x: Interval) -> bool {
    x.rad() <= THIN * x.mid().abs()
}

/// A set of start values and parameters.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Region {
    pub(crate) centre: Vec<f64>,
    /// One row per quantity, one column per axis.
    pub(crate) axes: Vec<Vec<f64>>,
    pub(crate) rest: Vec<f64>,
}

impl Region {
    /// A box.
    pub(crate) fn of_box(quantities: &[Interval]) -> Region {
        let count = quantities.iter().filter(|x| !is_thin(**x)).count();
        let mut region = Region {
            centre: quantities.iter().map(|x| x.mid()).collect(),
            axes: vec![vec![0.0; count]; quantities.len()],
            rest: vec![0.0; quantities.len()],
        };
        let mut axis = 0;
        for (i, x) in quantities.iter().enumerate() {
            if is_thin(*x) {
                region.rest[i] = x.rad();
            } else {
                region.axes[i][axis] = x.rad();
                axis += 1;
            }
        }
        region
    }

    /// Number of axes.
    pub(crate) fn axes(&self) -> usize {
        self.axes.first().map_or(0, Vec::len)
    }

    /// What is added to `M_i·δ`.
    pub(crate) fn offset(&self, quantity: usize) -> Interval {
        Interval::point(self.centre[quantity]) + Interval::symmetric(self.rest[quantity])
    }

    /// Encloses a quantity for `δ` in `part`.
    pub(crate) fn range(&self, quantity: usize, part: &[Interval]) -> Interval {
        let row = self.axes[quantity].iter().zip(part);
        row.fold(self.offset(quantity), |sum, (slope, x)| {
            sum + Interval::point(*slope) * *x
        })
    }

    /// Encloses all quantities for all `δ`.
    pub(crate) fn hull(&self) -> Vec<Interval> {
        let whole = vec![Interval::symmetric(1.0); self.axes()];
        (0..self.centre.len())
            .map(|i| self.range(i, &whole))
            .collect()
    }

    /// The same set in other unknowns: `δ_a = middle_a + radius_a δ'_a` with some numbers of these intervals.
    pub(crate) fn rescaled(&self, scales: &[(Interval, Interval)]) -> Region {
        let same = (Interval::ZERO, Interval::ONE);
        let unit = Interval::symmetric(1.0);
        let mut region = self.clone();
        for i in 0..self.centre.len() {
            let mut moved = Interval::point(self.centre[i]);
            let mut lost = Interval::symmetric(self.rest[i]);
            for (axis, scale) in scales.iter().enumerate() {
                let old = self.axes[i][axis];
                if old == 0.0 || *scale == same {
                    continue;
                }
                let product = Interval::point(old) * scale.1;
                let rounded = product.mid();
                moved += Interval::point(old) * scale.0;
                lost += (product - Interval::point(rounded)) * unit;
                region.axes[i][axis] = rounded;
            }
            region.centre[i] = moved.mid();
            lost += moved - Interval::point(region.centre[i]);
            region.rest[i] = lost.mag();
        }
        region
    }

    /// The part of the region with `δ` in `part`.
    pub(crate) fn part(&self, part: &[Interval]) -> Region {
        self.rescaled(&scales_of(part))
    }

    /// The same with about the values `x` of a quantity, and the axis that these are; `None` where it has no axis of its own.
    pub(crate) fn reaching(&self, quantity: usize, x: Interval) -> Option<(Region, usize)> {
        let mut moves = (0..self.axes()).filter(|axis| self.axes[quantity][*axis] != 0.0);
        let axis = moves.next()?;
        let mut others = (0..self.centre.len()).filter(|other| *other != quantity);
        let is_own = moves.next().is_none() && others.all(|other| self.axes[other][axis] == 0.0);
        is_own.then(|| {
            let mut region = self.clone();
            region.centre[quantity] = x.mid();
            region.axes[quantity][axis] = x.rad();
            region.rest[quantity] = 0.0;
            (region, axis)
        })
    }

    /// A region that contains all of this one with `Q' δ` in `along`, for a nearly orthogonal matrix `Q` given by
    /// its columns; `None` where that is not proved.
    ///
    /// Proof. With `y = Q' δ` in `along` and `Q'Q = I + D`, `|D| <= d < 1/2` in the maximum norm, `δ = Q r` for
    /// `r = (Q'Q)^-1 y`, and `|r - y| <= d |y| / (1 - d)`.
    pub(crate) fn turned(&self, columns: &[Vec<f64>], along: &[Interval]) -> Option<Region> {
        let n = columns.len();
        let mut skew = Interval::ZERO;
        for (a, left) in columns.iter().enumerate() {
            let mut row = Interval::ZERO;
            for (b, right) in columns.iter().enumerate() {
                let wanted = if a == b {
                    Interval::ONE
                } else {
                    Interval::ZERO
                };
                let product = left.iter().zip(right);
                let sum = product.fold(Interval::ZERO, |sum, (x, y)| {
                    sum + Interval::point(*x) * Interval::point(*y)
                });
                row += Interval::point((sum - wanted).mag());
            }
            skew = skew.hull(row);
        }
        if skew.hi() >= 0.5 {
            return None;
        }
        let largest = along.iter().map(|x| x.mag()).fold(0.0, f64::max);
        let skew = Interval::point(skew.hi());
        let wider = (skew / (Interval::ONE - skew) * Interval::point(largest)).hi();
        let along: Vec<Interval> = along.iter().map(|x| x.inflate(wider)).collect();
        let unit = Interval::symmetric(1.0);
        let mut region = self.clone();
        for (i, old) in self.axes.iter().enumerate() {
            let mut moved = Interval::point(self.centre[i]);
            let mut lost = Interval::symmetric(self.rest[i]);
            for axis in 0..n {
                let column = &columns[axis];
                let slope = old.iter().zip(column).fold(Interval::ZERO, |sum, (m, q)| {
                    sum + Interval::point(*m) * Interval::point(*q)
                });
                let (middle, radius) = along[axis].mid_rad();
                let product = slope * Interval::point(radius);
                moved += slope * Interval::point(middle);
                lost += (product - Interval::point(product.mid())) * unit;
                region.axes[i][axis] = product.mid();
            }
            region.centre[i] = moved.mid();
            lost += moved - Interval::point(region.centre[i]);
            region.rest[i] = lost.mag();
        }
        Some(region)
    }

    /// The rows of the quantities `list`, in that order, without axes that none of them depends on, and which
    /// axes are left.
    pub(crate) fn rows_of(&self, list: &[usize]) -> (Parallelotope, Vec<usize>) {
        let used = |axis: &usize| list.iter().any(|i| self.axes[*i][*axis] != 0.0);
        let kept: Vec<usize> = (0..self.axes()).filter(used).collect();
        let set = Parallelotope {
            centre: list.iter().map(|i| self.centre[*i]).collect(),
            axes: list
                .iter()
                .map(|i| kept.iter().map(|axis| self.axes[*i][*axis]).collect())
                .collect(),
            rest: list.iter().map(|i| self.rest[*i]).collect(),
        };
        (set, kept)
    }
}

/// Parts of the unit box as middles and radii.
pub(crate) fn scales_of(part: &[Interval]) -> Vec<(Interval, Interval)> {
    let unit = Interval::symmetric(1.0);
    part.iter()
        .map(|x| {
            if *x == unit {
                return (Interval::ZERO, Interval::ONE);
            }
            let (middle, radius) = x.mid_rad();
            (Interval::point(middle), Interval::point(radius))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn interval(lo: f64, hi: f64) -> Interval {
        Interval::new(lo, hi).unwrap_or(Interval::EMPTY)
    }

    /// Points of a turned part lie in the turned region.
    #[test]
    fn turned_regions_contain_their_parts() {
        let region = Region::of_box(&[interval(1.0, 3.0), interval(-0.1, 0.3), interval(2.0, 2.0)]);
        assert_eq!(region.axes(), 2);
        let (c, s) = (0.6, 0.8);
        let columns = vec![vec![c, s], vec![-s, c]];
        let along = [interval(-0.2, 0.7), interval(-0.05, 0.01)];
        let turned = region.turned(&columns, &along);
        let Some(turned) = turned else { unreachable!() };
        for k in 0..=10 {
            for l in 0..=10 {
                let r = [-0.2 + 0.09 * f64::from(k), -0.05 + 0.006 * f64::from(l)];
                let d = [c * r[0] - s * r[1], s * r[0] + c * r[1]];
                // The same point in both, found through the middle and radius of the turned one.
                let z: Vec<f64> = (0..2)
                    .map(|i| region.centre[i] + region.axes[i][0] * d[0] + region.axes[i][1] * d[1])
                    .collect();
                let own: Vec<Interval> = along
                    .iter()
                    .zip(r)
                    .map(|(x, r)| Interval::point((r - x.mid()) / x.rad()).inflate(1e-12))
                    .collect();
                for (i, z) in z.iter().enumerate() {
                    assert!(turned.range(i, &own).inflate(1e-12).contains(*z));
                }
            }
        }
        // It is not much larger than its part either.
        assert!(
            turned.range(1, &[interval(-1.0, 1.0); 2]).width()
                < 0.2 * 0.8 * 0.9 + 0.2 * 0.6 * 0.06 + 1e-9
        );
    }
}
