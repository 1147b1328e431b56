//! What rows say of tiles inside of one that was moved through the records, without moving them.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one interval per coordinate of a tile, unknowns and rows of the same region"
)]

use super::super::answer::Reason;
use super::super::cell::{BELIEVED, BORDER, Cell, is_well_inside};
use super::super::frame::{inverse, open};
use super::super::problem::Problem;
use super::super::rows::{Rows, SEVERAL};
use super::shares::{any_share, between};
use super::turn::Turn;
use super::{reason_of, widest};
use serde::{Deserialize, Serialize};
use veribound_interval::Interval;

/// Rows hide the answer where this share of a tile's reach is not affine.
const HIDDEN: f64 = 0.5;

/// What rows say of tiles, in coordinates of these.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Local {
    /// Rows in the coordinates, from `base` on: outer ones for all start states, inner ones for one of them.
    rows: Rows,
    /// How much of each row is not affine.
    gaps: Vec<f64>,
    base: Vec<f64>,
    /// What widths of the coordinates are compared with.
    sizes: Vec<f64>,
    /// Whether inner rows prove that all records are met.
    is_complete: bool,
    /// So many of the last rows are borders of the upright tile around.
    borders: usize,
}

/// What rows say of a tile.
pub(super) enum Said {
    Inside,
    Outside(Reason),
    /// No point of it is in the upright tile that it divides.
    Beyond,
    /// Not decided; the coordinate to halve.
    Halve(usize),
    /// What is not affine hides the answer.
    Hidden(usize),
}

impl Local {
    /// Whether its lists have the lengths of so many coordinates.
    pub(super) fn fits(&self, coordinates: usize) -> bool {
        self.rows.unknowns() == coordinates
            && self.gaps.len() == self.rows.len()
            && self.base.len() == coordinates
            && self.sizes.len() == coordinates
    }

    /// The rows of a cell in the coordinates `y` of tiles inside of it; nothing where these do not belong to unknowns.
    ///
    /// Proof. With `p = c + A y` and `p = c' + A' δ + r` for the parameters and the unknowns that they depend on alone,
    /// `δ = A'^-1 A (y - base) + A'^-1 (c + A base - c' - r)`. A row `g·δ` is one of `y` then; of unknowns of start states it
    /// must hold for some in the cell, and for inner rows it is enough that it does so for one.
    pub(super) fn of(
        cell: &Cell,
        turn: Option<&Turn>,
        within: &[Interval],
        problem: &Problem,
    ) -> Option<Local> {
        let first = problem.first_param();
        let region = &cell.region;
        let rows = open(&region.axes[first..]);
        let is_used = |axis: &usize| rows.iter().any(|p| region.axes[first + p][*axis] != 0.0);
        let columns: Vec<usize> = (0..region.axes()).filter(is_used).collect();
        if rows.len() != columns.len() {
            return None;
        }
        let square: Vec<Vec<f64>> = rows
            .iter()
            .map(|p| {
                columns
                    .iter()
                    .map(|axis| region.axes[first + p][*axis])
                    .collect()
            })
            .collect();
        let inverse = inverse(&square.iter().map(Vec::as_slice).collect::<Vec<_>>())?;
        let base: Vec<f64> = within.iter().map(|x| x.mid()).collect();
        let points: Vec<Interval> = base.iter().map(|x| Interval::point(*x)).collect();
        let begin = turn.map_or_else(|| points.clone(), |turn| turn.frame.hull(&points));
        let slope = |p: usize, at: usize| match turn {
            None => f64::from(u8::from(p == at)),
            Some(turn) => turn.frame.axes[p][at],
        };
        let around: Vec<Interval> = within
            .iter()
            .zip(&points)
            .map(|(x, base)| *x - *base)
            .collect();
        // Each unknown as slopes of the coordinates, and the rest.
        let unknowns: Vec<(Vec<Interval>, Interval)> = inverse
            .iter()
            .map(|row| {
                let slopes = (0..base.len()).map(|at| {
                    let terms = row.iter().zip(&rows);
                    terms.fold(Interval::ZERO, |sum, (share, p)| {
                        sum + *share * Interval::point(slope(*p, at))
                    })
                });
                let terms = row.iter().zip(&rows);
                let rest = terms.fold(Interval::ZERO, |sum, (share, p)| {
                    sum + *share * (begin[*p] - region.offset(first + p))
                });
                (slopes.collect(), rest)
            })
            .collect();
        // A sum of these with rounded slopes.
        let rounded = |shares: &[f64]| {
            let mut rest = Interval::ZERO;
            let mut slopes = vec![Interval::ZERO; base.len()];
            for (share, (own, by)) in shares.iter().zip(&unknowns) {
                rest += Interval::point(*share) * *by;
                for (slope, own) in slopes.iter_mut().zip(own) {
                    *slope += Interval::point(*share) * *own;
                }
            }
            let middles: Vec<f64> = slopes.iter().map(|slope| slope.mid()).collect();
            for ((slope, middle), x) in slopes.iter().zip(&middles).zip(&around) {
                rest += (*slope - Interval::point(*middle)) * *x;
            }
            (middles, rest)
        };
        let starts = cell.deepest().0;
        let is_own = |axis: &usize| columns.contains(axis);
        let others: Vec<usize> = (0..region.axes()).filter(|axis| !is_own(axis)).collect();
        let mut told = Rows::new(base.len());
        let mut gaps = Vec::with_capacity(cell.rows.len());
        for row in 0..cell.rows.len() {
            let all = cell.rows.slopes(row);
            let own: Vec<f64> = columns.iter().map(|axis| all[*axis]).collect();
            let (slopes, rest) = rounded(&own);
            let (mut wide, mut narrow) = (rest, rest);
            for axis in &others {
                wide += Interval::point(all[*axis]) * cell.part[*axis];
                narrow += Interval::point(all[*axis]) * Interval::point(starts[*axis]);
            }
            let sides = (cell.rows.outer(row), cell.rows.inner(row));
            told.push_moved(&slopes, (wide, narrow), sides, cell.rows.origin(row));
            // Of one that may be an outlier nothing is known but what proves that it is none.
            gaps.push(match sides {
                (outer, _) if outer == Interval::ENTIRE => 0.0,
                (outer, inner) if inner.is_empty() => outer.width(),
                (outer, inner) => outer.width() - inner.width(),
            });
        }
        for (position, axis) in columns.iter().enumerate() {
            let mut unit = vec![0.0; columns.len()];
            unit[position] = 1.0;
            let (slopes, rest) = rounded(&unit);
            let sides = (cell.part[*axis], Interval::symmetric(1.0 - BORDER));
            told.push_moved(&slopes, (rest, rest), sides, (SEVERAL, 0));
        }
        let own = told.len();
        if let Some(turn) = turn {
            for p in open(&turn.frame.axes) {
                told.push(&turn.frame.axes[p], begin[p], turn.clip[p], BELIEVED, 0);
            }
        }
        let borders = told.len() - own;
        gaps.resize(told.len(), 0.0);
        let sizes = match turn {
            None => problem.prior.iter().map(|x| x.width()).collect(),
            Some(_) => vec![1.0; base.len()],
        };
        let is_inside = |axis: &usize| is_well_inside(Interval::point(starts[*axis]));
        Some(Local {
            rows: told,
            gaps,
            base,
            sizes,
            is_complete: cell.is_complete && others.iter().all(is_inside),
            borders,
        })
    }

    /// What it takes in memory, about.
    pub(super) fn bytes(&self) -> usize {
        (8 * self.base.len() + 40) * self.rows.len() + 16 * self.base.len() + 100
    }

    /// The largest share of a tile, about, that what is not affine leaves undecided by one row.
    pub(super) fn blurred(&self, within: &[Interval]) -> f64 {
        let at = within.iter().zip(&self.base);
        let at: Vec<Interval> = at.map(|(x, base)| *x - Interval::point(*base)).collect();
        let shares = (0..self.rows.len()).map(|row| {
            let sum = self.sum(row, &at);
            if sum.is_subset_of(self.rows.inner(row)) {
                0.0
            } else {
                (self.gaps[row] / sum.width().max(1e-300)).min(1.0)
            }
        });
        shares.fold(0.0, f64::max)
    }

    /// Encloses the share of a tile that agrees: no more than any outer row leaves, no less than what inner rows leave when
    /// each takes away its own.
    pub(super) fn share(&self, within: &[Interval]) -> Interval {
        let at = within.iter().zip(&self.base);
        let at: Vec<Interval> = at.map(|(x, base)| *x - Interval::point(*base)).collect();
        let (mut most, mut least) = (1.0_f64, Interval::ONE);
        for row in 0..self.rows.len() {
            let sum = self.sum(row, &at);
            let (outer, inner) = (self.rows.outer(row), self.rows.inner(row));
            if sum.is_subset_of(inner) {
                continue;
            }
            let slopes = self.rows.slopes(row);
            let between = |bounds| between(slopes, &at, bounds);
            most = most.min(between(outer).hi());
            least -= Interval::ONE - between(inner);
        }
        let least = if self.is_complete {
            least.lo().max(0.0)
        } else {
            0.0
        };
        Interval::new(least.min(most), most).unwrap_or_else(any_share)
    }

    /// Whether a tile has nothing of the upright tile that all are parts of.
    fn is_beyond(&self, at: &[Interval]) -> bool {
        let rows = self.rows.len();
        let mut borders = rows - self.borders..rows;
        borders.any(|row| !self.sum(row, at).intersects(self.rows.outer(row)))
    }

    fn sum(&self, row: usize, at: &[Interval]) -> Interval {
        let terms = self.rows.slopes(row).iter().zip(at);
        terms.fold(Interval::ZERO, |sum, (g, x)| sum + Interval::point(*g) * *x)
    }

    /// What the rows say of a tile inside of that which they were made for: those that cannot be met exclude it, those that
    /// are met by all its points prove that it is inside.
    pub(super) fn says(&self, within: &[Interval]) -> Said {
        let at = within.iter().zip(&self.base);
        let at: Vec<Interval> = at.map(|(x, base)| *x - Interval::point(*base)).collect();
        let mut is_inside = self.is_complete;
        let mut worst = None;
        let mut missing = 0.0;
        for row in 0..self.rows.len() {
            let sum = self.sum(row, &at);
            let outer = self.rows.outer(row);
            if !sum.intersects(outer) {
                let (sample, record) = self.rows.origin(row);
                return if sample == BELIEVED && self.is_beyond(&at) {
                    Said::Beyond
                } else {
                    Said::Outside(reason_of(record, &[(sample, record)]))
                };
            }
            let inner = self.rows.inner(row);
            if sum.is_subset_of(inner) {
                continue;
            }
            is_inside = false;
            let reach = sum.width().max(1e-300);
            let below = (inner.lo() - sum.lo()).max(sum.hi() - inner.hi());
            let below = if below.is_finite() { below } else { reach };
            if below > missing || worst.is_none() {
                missing = below.max(0.0);
                // How much of what is missing no halving brings.
                worst = Some((row, self.gaps[row] / reach));
            }
        }
        if is_inside {
            return Said::Inside;
        }
        let Some((row, gap)) = worst else {
            return Said::Hidden(widest(within, &self.sizes));
        };
        let slopes = self.rows.slopes(row);
        let reach = |axis: usize| (slopes[axis] * at[axis].width()).abs();
        let axis = (0..within.len())
            .max_by(|a, b| reach(*a).total_cmp(&reach(*b)))
            .filter(|axis| reach(*axis) > 0.0)
            .unwrap_or_else(|| widest(within, &self.sizes));
        if gap > HIDDEN || !self.is_complete {
            Said::Hidden(axis)
        } else {
            Said::Halve(axis)
        }
    }
}
