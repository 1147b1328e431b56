//! The constants with which guards compare a state.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: zones are counted by the cells made from them"
)]

use veribound_interval::Interval;
use veribound_model::Relation;

/// The levels of one state cut its axis into cells: cell `2k` lies below level `k`, cell `2k+1` is
/// the level itself (a zone, as wide as the rounding of its number).
#[derive(Debug, Clone, Default)]
pub(crate) struct Levels {
    pub(crate) zones: Vec<Interval>,
}

impl Levels {
    /// The points of `cell` as a closed interval.
    pub(crate) fn range(&self, cell: usize) -> Interval {
        if cell % 2 == 1 {
            return self.zones[cell / 2];
        }
        let k = cell / 2;
        let lo = if k == 0 {
            f64::NEG_INFINITY
        } else {
            self.zones[k - 1].hi()
        };
        let hi = self.zones.get(k).map_or(f64::INFINITY, |zone| zone.lo());
        Interval::new(lo, hi).unwrap_or(Interval::ENTIRE)
    }

    /// The cell that contains `x`; a zone wins over the regions it borders.
    pub(crate) fn cell(&self, x: f64) -> usize {
        for (k, zone) in self.zones.iter().enumerate() {
            if x < zone.lo() {
                return 2 * k;
            }
            if x <= zone.hi() {
                return 2 * k + 1;
            }
        }
        2 * self.zones.len()
    }

    /// Adds a zone; zones that overlap become one, on which their guards are undecided.
    pub(crate) fn insert(&mut self, level: Interval) {
        let zones = &mut self.zones;
        let mut merged = level;
        zones.retain(|zone| {
            let apart = !zone.intersects(merged);
            if !apart {
                merged = merged.hull(*zone);
            }
            apart
        });
        zones.push(merged);
        zones.sort_by(|a, b| a.lo().total_cmp(&b.lo()));
    }
}

/// The values of a state that compare with a level as `relation` says, boundaries included.
pub(crate) fn allowed(level: Interval, relation: Relation) -> Interval {
    let half = |lo, hi| Interval::new(lo, hi).unwrap_or(Interval::ENTIRE);
    match relation {
        Relation::Less | Relation::LessEqual => half(f64::NEG_INFINITY, level.hi()),
        Relation::Greater | Relation::GreaterEqual => half(level.lo(), f64::INFINITY),
        Relation::Equal => level,
        Relation::NotEqual => Interval::ENTIRE,
    }
}

/// The relation of every point of `cell` to the level whose zone is `level_cell`.
pub(crate) fn in_cell_relation(cell: usize, level_cell: usize, relation: Relation) -> bool {
    match relation {
        _ if cell == level_cell => true,
        Relation::Less | Relation::LessEqual => cell < level_cell,
        Relation::Greater | Relation::GreaterEqual => cell > level_cell,
        Relation::Equal => false,
        Relation::NotEqual => true,
    }
}
