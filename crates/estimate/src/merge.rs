//! Step 8 of the observer: fewer boxes, by hulls with small overestimation.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: positions stay below the length of the list they were taken from"
)]

use crate::cell::{Cell, remove_contained};

/// Widths below this share of the scale count as this share, so that boxes that are thin in one
/// direction can still be compared.
const THINNEST: f64 = 1e-6;

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
    let mut volumes: Vec<f64> = cells.iter().map(|cell| volume(cell, scale)).collect();
    let mut best: Vec<Option<(usize, f64)>> =
        (0..cells.len()).map(|i| partner(cells, &volumes, i, across_modes, scale)).collect();
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
        volumes.swap_remove(gone);
        best.swap_remove(gone);
        let moved = cells.len();
        cells[keep].join(&other);
        volumes[keep] = volume(&cells[keep], scale);
        for position in 0..cells.len() {
            let stale = position == keep
                || best[position].is_some_and(|(partner, _)| partner == keep || partner == gone);
            if stale {
                best[position] = partner(cells, &volumes, position, across_modes, scale);
                continue;
            }
            if let Some((partner, _)) = &mut best[position]
                && *partner == moved
            {
                *partner = gone;
            }
            if let Some(cost) = overestimation(cells, &volumes, position, keep, across_modes, scale)
                && best[position].is_none_or(|(_, known)| cost < known)
            {
                best[position] = Some((keep, cost));
            }
        }
    }
}

fn volume(cell: &Cell, scale: &[f64]) -> f64 {
    cell.z.iter().zip(scale).map(|(x, s)| (x.width() / s).max(THINNEST)).product()
}

/// Volume of the hull over the volume of the two boxes; small means little is added.
fn overestimation(
    cells: &[Cell],
    volumes: &[f64],
    i: usize,
    j: usize,
    across_modes: bool,
    scale: &[f64],
) -> Option<f64> {
    if i == j || (!across_modes && cells[i].modes != cells[j].modes) {
        return None;
    }
    let pairs = cells[i].z.iter().zip(&cells[j].z).zip(scale);
    let hull: f64 = pairs.map(|((a, b), s)| (a.hull(*b).width() / s).max(THINNEST)).product();
    Some(hull / (volumes[i] + volumes[j]))
}

/// The box that is cheapest to join with box `i`.
fn partner(
    cells: &[Cell],
    volumes: &[f64],
    i: usize,
    across_modes: bool,
    scale: &[f64],
) -> Option<(usize, f64)> {
    (0..cells.len())
        .filter_map(|j| {
            overestimation(cells, volumes, i, j, across_modes, scale).map(|cost| (j, cost))
        })
        .min_by(|a, b| a.1.total_cmp(&b.1))
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
        Cell { z: vec![interval(x), interval(y)], modes }
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
        let list = || vec![cell((0.0, 1.0), (0.0, 1.0), 0), cell((0.5, 1.5), (0.0, 1.0), 1)];
        let mut cells = list();
        merge(&mut cells, 1, false, &[1.0, 1.0]);
        assert_eq!(cells.len(), 2);
        let mut cells = list();
        merge(&mut cells, 1, true, &[1.0, 1.0]);
        assert_eq!(cells.len(), 1);
        assert_eq!(cells[0].modes.len(), 2);
    }
}
