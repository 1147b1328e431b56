//! Step 8 of the observer: fewer boxes, by hulls with small overestimation.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: positions stay below the length of the list they were taken from"
)]

use crate::cell::{Cell, remove_contained};

/// Widths below this share of the scale count as this share, so that boxes that are thin in one
/// direction can still be compared.
const THINNEST: f64 = 1e-6;

fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The boxes in units of the scale, one after another, and their volumes. It only ranks pairs, so
/// plain floating point will do.
struct Shapes {
    dimension: usize,
    lo: Vec<f64>,
    hi: Vec<f64>,
    volumes: Vec<f64>,
}

impl Shapes {
    fn new(cells: &[Cell], scale: &[f64]) -> Shapes {
        let mut shapes = Shapes {
            dimension: scale.len(),
            lo: Vec::new(),
            hi: Vec::new(),
            volumes: Vec::new(),
        };
        for cell in cells {
            for (x, s) in cell.z.iter().zip(scale) {
                shapes.lo.push(x.lo() / s);
                shapes.hi.push(x.hi() / s);
            }
        }
        shapes.volumes = (0..cells.len()).map(|i| shapes.hull_volume(i, i)).collect();
        shapes
    }

    fn hull_volume(&self, i: usize, j: usize) -> f64 {
        let (i, j, d) = (i * self.dimension, j * self.dimension, self.dimension);
        let (lo_i, lo_j) = (&self.lo[i..i + d], &self.lo[j..j + d]);
        let (hi_i, hi_j) = (&self.hi[i..i + d], &self.hi[j..j + d]);
        let mut product = 1.0;
        for k in 0..d {
            // No NaN is among these, so a comparison will do where `f64::max` takes several.
            let hi = larger(hi_i[k], hi_j[k]);
            let lo = -larger(-lo_i[k], -lo_j[k]);
            product *= larger(hi - lo, THINNEST);
        }
        product
    }

    /// Volume of the hull over the volume of the two boxes; small means little is added.
    fn overestimation(&self, i: usize, j: usize) -> f64 {
        self.hull_volume(i, j) / (self.volumes[i] + self.volumes[j])
    }

    /// Box `keep` becomes the hull with box `gone`, whose place the last box takes.
    fn join(&mut self, keep: usize, gone: usize) {
        let d = self.dimension;
        for k in 0..d {
            let (a, b) = (keep * d + k, gone * d + k);
            self.lo[a] = self.lo[a].min(self.lo[b]);
            self.hi[a] = self.hi[a].max(self.hi[b]);
        }
        let last = self.volumes.len() - 1;
        for k in 0..d {
            self.lo.swap(gone * d + k, last * d + k);
            self.hi.swap(gone * d + k, last * d + k);
        }
        self.lo.truncate(last * d);
        self.hi.truncate(last * d);
        self.volumes.swap_remove(gone);
        self.volumes[keep] = self.hull_volume(keep, keep);
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
    let mut best: Vec<Option<(usize, f64)>> = vec![None; cells.len()];
    for i in 0..cells.len() {
        for j in i + 1..cells.len() {
            if !(across_modes || cells[i].modes == cells[j].modes) {
                continue;
            }
            let cost = shapes.overestimation(i, j);
            for (a, b) in [(i, j), (j, i)] {
                if best[a].is_none_or(|(_, known)| cost < known) {
                    best[a] = Some((b, cost));
                }
            }
        }
    }
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
        let moved = cells.len();
        for position in 0..cells.len() {
            let stale = position == keep
                || best[position].is_some_and(|(partner, _)| partner == keep || partner == gone);
            if stale {
                best[position] = partner(cells, &shapes, position, across_modes);
                continue;
            }
            if let Some((partner, _)) = &mut best[position]
                && *partner == moved
            {
                *partner = gone;
            }
            if across_modes || cells[position].modes == cells[keep].modes {
                let cost = shapes.overestimation(position, keep);
                if best[position].is_none_or(|(_, known)| cost < known) {
                    best[position] = Some((keep, cost));
                }
            }
        }
    }
}

/// The box that is cheapest to join with box `i`.
fn partner(cells: &[Cell], shapes: &Shapes, i: usize, across_modes: bool) -> Option<(usize, f64)> {
    let mut best: Option<(usize, f64)> = None;
    for j in 0..cells.len() {
        if i == j || !(across_modes || cells[i].modes == cells[j].modes) {
            continue;
        }
        let cost = shapes.overestimation(i, j);
        if best.is_none_or(|(_, known)| cost < known) {
            best = Some((j, cost));
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use veribound_flow::ModeSet;
    use veribound_interval::Interval;

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
