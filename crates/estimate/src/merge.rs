//! Step 8 of the observer: fewer boxes, by hulls with small overestimation.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: positions stay below the length of the list they were taken from"
)]

use crate::cell::{Cell, remove_contained};
use veribound_interval::Interval;

/// Widths below this share of the scale count as this share, so that boxes that are thin in one
/// direction can still be compared.
const THINNEST: f64 = 1e-6;

fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The boxes in units of the scale, one coordinate after another, and their volumes. It only ranks
/// pairs, so plain floating point will do.
struct Shapes {
    /// Per coordinate the ends of all boxes.
    lo: Vec<Vec<f64>>,
    hi: Vec<Vec<f64>>,
    volumes: Vec<f64>,
    /// Scratch and result of [`Shapes::overestimations`].
    costs: Vec<f64>,
}

impl Shapes {
    fn new(cells: &[Cell], scale: &[f64]) -> Shapes {
        let ends = |end: fn(Interval) -> f64| -> Vec<Vec<f64>> {
            let of = |k: usize| cells.iter().map(move |cell| end(cell.z[k]) / scale[k]);
            (0..scale.len()).map(|k| of(k).collect()).collect()
        };
        let mut shapes = Shapes {
            lo: ends(Interval::lo),
            hi: ends(Interval::hi),
            volumes: Vec::new(),
            costs: Vec::new(),
        };
        shapes.volumes = (0..cells.len()).map(|i| shapes.volume(i)).collect();
        shapes
    }

    fn volume(&self, i: usize) -> f64 {
        let width = |(lo, hi): (&Vec<f64>, &Vec<f64>)| larger(hi[i] - lo[i], THINNEST);
        self.lo.iter().zip(&self.hi).map(width).product()
    }

    /// For every box from `first` on the volume of its hull with box `i` over the volume of the two;
    /// small means little is added.
    fn overestimations(&mut self, i: usize, first: usize) -> &[f64] {
        self.costs.clear();
        self.costs.resize(self.volumes.len() - first, 1.0);
        for (lo, hi) in self.lo.iter().zip(&self.hi) {
            let (lo_i, hi_i) = (lo[i], hi[i]);
            for ((cost, lo), hi) in self.costs.iter_mut().zip(&lo[first..]).zip(&hi[first..]) {
                // No NaN is among these, so a comparison will do where `f64::max` takes several.
                let width = larger(hi_i, *hi) + larger(-lo_i, -lo);
                *cost *= larger(width, THINNEST);
            }
        }
        let volume = self.volumes[i];
        for (cost, other) in self.costs.iter_mut().zip(&self.volumes[first..]) {
            *cost /= volume + other;
        }
        &self.costs
    }

    /// Box `keep` becomes the hull with box `gone`, whose place the last box takes.
    fn join(&mut self, keep: usize, gone: usize) {
        for (lo, hi) in self.lo.iter_mut().zip(&mut self.hi) {
            lo[keep] = lo[keep].min(lo[gone]);
            hi[keep] = hi[keep].max(hi[gone]);
            lo.swap_remove(gone);
            hi.swap_remove(gone);
        }
        self.volumes.swap_remove(gone);
        self.volumes[keep] = self.volume(keep);
    }
}

/// Joins boxes until at most `target` are left.
///
/// Guarantee: the union of the boxes does not shrink. Boxes with different active modes are never
/// joined unless `across_modes`; so at least one box per set of active modes is left.
/// `scale` holds one positive length per coordinate. Cost: O(N² d) for N boxes of dimension d.
pub(crate) fn merge(cells: &mut Vec<Cell>, target: usize, across_modes: bool, scale: &[f64]) {
    if cells.len() <= target {
        return;
    }
    remove_contained(cells);
    if cells.len() <= target {
        return;
    }
    let mut shapes = Shapes::new(cells, scale);
    let mut best = partners(cells, &mut shapes, across_modes);
    let mut to_keep = Vec::new();
    while cells.len() > target {
        let cheapest = best
            .iter()
            .enumerate()
            .filter_map(|(i, choice)| choice.map(|(j, cost)| (cost, i, j)))
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let Some((_, i, j)) = cheapest else {
            return;
        };
        let (keep, gone) = (i.min(j), i.max(j));
        let other = cells.swap_remove(gone);
        best.swap_remove(gone);
        cells[keep].join(&other);
        shapes.join(keep, gone);
        to_keep.clear();
        to_keep.extend_from_slice(shapes.overestimations(keep, 0));
        let moved = cells.len();
        for position in 0..cells.len() {
            let stale = position == keep
                || best[position].is_some_and(|(partner, _)| partner == keep || partner == gone);
            if stale {
                best[position] = partner(cells, &mut shapes, position, across_modes);
                continue;
            }
            if let Some((partner, _)) = &mut best[position]
                && *partner == moved
            {
                *partner = gone;
            }
            if across_modes || cells[position].modes == cells[keep].modes {
                let cost = to_keep[position];
                if is_better(cost, best[position]) {
                    best[position] = Some((keep, cost));
                }
            }
        }
    }
}

/// A box to join another one with, and the cost of that.
type Partner = Option<(usize, f64)>;

fn is_better(cost: f64, known: Partner) -> bool {
    known.is_none_or(|(_, known)| cost < known)
}

/// For every box the one that is cheapest to join it with.
fn partners(cells: &[Cell], shapes: &mut Shapes, across_modes: bool) -> Vec<Partner> {
    let mut best: Vec<Partner> = vec![None; cells.len()];
    for i in 0..cells.len() {
        let mut own = best[i];
        for (&cost, j) in shapes.overestimations(i, i + 1).iter().zip(i + 1..) {
            let (for_own, for_other) = (is_better(cost, own), is_better(cost, best[j]));
            if !(for_own || for_other) || !(across_modes || cells[i].modes == cells[j].modes) {
                continue;
            }
            if for_own {
                own = Some((j, cost));
            }
            if for_other {
                best[j] = Some((i, cost));
            }
        }
        best[i] = own;
    }
    best
}

/// The box that is cheapest to join with box `i`.
fn partner(cells: &[Cell], shapes: &mut Shapes, i: usize, across_modes: bool) -> Partner {
    let mut best: Partner = None;
    for (j, &cost) in shapes.overestimations(i, 0).iter().enumerate() {
        if is_better(cost, best) && i != j && (across_modes || cells[i].modes == cells[j].modes) {
            best = Some((j, cost));
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use veribound_flow::ModeSet;

    fn cell(x: (f64, f64), y: (f64, f64), mode: usize) -> Cell {
        let mut modes = ModeSet::EMPTY;
        modes.insert(mode);
        let interval = |(lo, hi)| Interval::new(lo, hi).unwrap();
        Cell {
            modes,
            ..Cell::new(vec![interval(x), interval(y)])
        }
    }

    #[test]
    fn neighbours_are_joined_before_distant_boxes() {
        let mut cells = vec![
            cell((0.0, 1.0), (0.0, 1.0), 0),
            cell((5.0, 6.0), (5.0, 6.0), 0),
            cell((1.0, 2.0), (0.0, 1.0), 0),
        ];
        merge(&mut cells, 2, false, &[1.0, 1.0]);
        cells.sort_by(|a, b| a.z[0].lo().total_cmp(&b.z[0].lo()));
        assert_eq!(cells.len(), 2);
        assert_eq!(cells[0].z[0], Interval::new(0.0, 2.0).unwrap());
    }

    #[test]
    fn different_modes_stay_apart_unless_asked() {
        let list = || {
            vec![
                cell((0.0, 1.0), (0.0, 1.0), 0),
                cell((0.5, 1.5), (0.0, 1.0), 1),
            ]
        };
        let mut cells = list();
        merge(&mut cells, 1, false, &[1.0, 1.0]);
        assert_eq!(cells.len(), 2);
        let mut cells = list();
        merge(&mut cells, 1, true, &[1.0, 1.0]);
        assert_eq!(cells.len(), 1);
        assert_eq!(cells[0].modes.len(), 2);
    }
}
