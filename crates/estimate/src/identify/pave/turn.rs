//! Axes of tiles that are divided along what is left of them.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one row of axes and one interval per parameter, unknowns of the same region"
)]

use super::super::answer::Reason;
use super::super::cell::Cell;
use super::super::frame::{Frame, inverse, open};
use super::super::problem::Problem;
use super::volume;
use serde::{Deserialize, Serialize};
use veribound_interval::Interval;

/// Axes of tiles that lie in one upright tile, `clip`, of which they are all that is not excluded.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Turn {
    pub(super) frame: Frame,
    pub(super) clip: Vec<Interval>,
    /// Volume of a unit of the coordinates.
    pub(super) size: f64,
    /// How many of these all are together.
    pub(super) whole: f64,
}

impl Turn {
    /// The axes of a cell that was turned, around what it leaves of the upright tile `clip`, with the coordinates of that.
    pub(super) fn of(
        cell: &Cell,
        problem: &Problem,
        clip: &[Interval],
    ) -> Option<(Turn, Vec<Interval>)> {
        let first = problem.first_param();
        let axes = &cell.region.axes[first..];
        let used = |row: &Vec<f64>| row.iter().filter(|slope| **slope != 0.0).count();
        // Each parameter that is not known has one axis more, or it is upright.
        let open = problem.prior.iter().filter(|x| !x.is_point()).count();
        if cell.region.axes() != open || axes.iter().all(|row| used(row) <= 1) {
            return None;
        }
        let mut turn = Turn {
            frame: Frame {
                centre: cell.region.centre[first..].to_vec(),
                axes: axes.to_vec(),
            },
            clip: clip.to_vec(),
            size: 0.0,
            whole: 0.0,
        };
        turn.size = turn
            .frame
            .volume(&vec![Interval::symmetric(0.5); open])
            .hi();
        let bounds = turn.bounds(cell, first).into_iter();
        let within: Vec<Interval> = bounds
            .map(|(bounds, _)| bounds.inflate(f64::MIN_POSITIVE))
            .collect();
        turn.whole = volume(&within);
        let is_sound = within.iter().all(|x| x.is_bounded() && !x.is_empty());
        (is_sound && turn.size.is_finite()).then_some((turn, within))
    }

    /// Bounds of the coordinates of what the cell leaves, with what excludes those below and above.
    ///
    /// Proof. `p = c + A y` and `p = c' + A' δ + r`, so `y = A^-1 A' δ + A^-1 (c' - c + r)`.
    pub(super) fn bounds(&self, cell: &Cell, first: usize) -> Vec<(Interval, [Reason; 2])> {
        let open = open(&self.frame.axes);
        let matrix: Vec<&[f64]> = open
            .iter()
            .map(|p| self.frame.axes[*p].as_slice())
            .collect();
        let nothing = || [Reason::Budget, Reason::Budget];
        let Some(inverse) = inverse(&matrix) else {
            return matrix
                .iter()
                .map(|_| (Interval::ENTIRE, nothing()))
                .collect();
        };
        let of_row = |row: &Vec<Interval>| {
            let mut rest = Interval::ZERO;
            let mut slopes = vec![Interval::ZERO; cell.part.len()];
            for (share, p) in row.iter().zip(&open) {
                let far = cell.region.offset(first + p) - Interval::point(self.frame.centre[*p]);
                rest += *share * far;
                for (slope, own) in slopes.iter_mut().zip(&cell.region.axes[first + p]) {
                    *slope += *share * Interval::point(*own);
                }
            }
            let direction: Vec<f64> = slopes.iter().map(|slope| slope.mid()).collect();
            for ((slope, rounded), x) in slopes.iter().zip(&direction).zip(&cell.part) {
                rest += (*slope - Interval::point(*rounded)) * *x;
            }
            let (bounds, because) = cell.along(&direction);
            (bounds + rest, because)
        };
        inverse.iter().map(of_row).collect()
    }
}
