//! The cells in which every comparison of the guards is decided.

use crate::coverage::affine::Affine;
use crate::coverage::formula::{Builder, Direction, Formula};
use crate::graph::{Binary, Graph, Names, Node};
use crate::model::Guard;
use num_rational::BigRational;
use num_traits::Zero;
use std::cmp::Ordering;
use veribound_interval::Truth;

/// Partly filled cells that are looked at.
const MOST_VISITS: usize = 20_000;
/// Cells that are looked into.
const MOST_CELLS: usize = 200;

/// Guards over the pieces of their directions.
pub(crate) struct Cells {
    guards: Vec<Formula>,
    directions: Vec<Direction>,
    /// For each direction, sorted.
    thresholds: Vec<Vec<BigRational>>,
}

/// One piece of each direction; `None` where it does not matter. With thresholds `t0 < t1 < ...`
/// piece 0 is below `t0`, piece 1 is `t0` itself, piece 2 lies between `t0` and `t1`, and so on.
pub(crate) type Cell = Vec<Option<usize>>;

/// A piece of one direction.
#[derive(Debug, Clone)]
pub(crate) struct Piece {
    pub direction: Affine,
    pub lower: Option<BigRational>,
    pub upper: Option<BigRational>,
    /// Whether the ends belong to the piece.
    pub is_closed: bool,
}

impl Cells {
    /// `None` when the guards are too long to be examined.
    pub fn of(graph: &Graph, guards: &[Guard]) -> Option<Cells> {
        let mut builder = Builder::new(graph);
        let guards = guards.iter().map(|guard| builder.guard(guard));
        let guards: Vec<Formula> = guards.collect::<Option<_>>()?;
        let directions = builder.directions;
        let mut thresholds = vec![Vec::new(); directions.len()];
        for guard in &guards {
            guard.collect(&mut thresholds);
        }
        for list in &mut thresholds {
            list.sort();
            list.dedup();
        }
        Some(Cells {
            guards,
            directions,
            thresholds,
        })
    }

    /// What is compared.
    pub fn directions(&self) -> impl Iterator<Item = Affine> + '_ {
        self.directions.iter().map(affine)
    }

    /// The cells where no guard holds; `None` when there are too many to look at.
    pub fn uncovered(&self) -> Option<Vec<Cell>> {
        let mut found = Vec::new();
        let mut open = vec![vec![None; self.directions.len()]];
        let mut visits = 0;
        while let Some(cell) = open.pop() {
            visits += 1;
            if visits > MOST_VISITS || found.len() > MOST_CELLS {
                return None;
            }
            let truths = self.guards.iter().map(|guard| self.truth(guard, &cell));
            match truths.fold(Truth::False, Truth::or) {
                Truth::True => {}
                Truth::False => found.push(cell),
                Truth::Unknown => {
                    // Every comparison of a filled cell is decided, so one direction is open.
                    if let Some(next) = cell.iter().position(Option::is_none) {
                        open.extend(self.divided(&cell, next, false));
                    }
                }
            }
        }
        Some(found)
    }

    /// The cells where several guards hold, with these; `None` when there are too many to look at.
    ///
    /// Of directions in `faces` only the open pieces are looked at.
    pub fn shared(&self, faces: &[bool]) -> Option<Vec<(Cell, Vec<usize>)>> {
        let mut found = Vec::new();
        let all: Vec<usize> = (0..self.guards.len()).collect();
        let mut open = vec![(vec![None; self.directions.len()], all)];
        let mut visits = 0;
        while let Some((cell, mut possible)) = open.pop() {
            visits += 1;
            if visits > MOST_VISITS || found.len() > MOST_CELLS {
                return None;
            }
            let mut undecided = None;
            possible.retain(|index| {
                let Some(guard) = self.guards.get(*index) else {
                    return false;
                };
                let truth = self.truth(guard, &cell);
                if truth == Truth::Unknown && undecided.is_none() {
                    undecided = guard.open_direction(&|direction, threshold| {
                        self.order(&cell, direction, threshold)
                    });
                }
                truth != Truth::False
            });
            match undecided {
                _ if possible.len() < 2 => {}
                None => found.push((cell, possible)),
                Some(next) => {
                    let finer = self.divided(&cell, next, faces.get(next) == Some(&true));
                    open.extend(finer.map(|cell| (cell, possible.clone())));
                }
            }
        }
        Some(found)
    }

    /// The cells that `cell` consists of by the pieces, or the open pieces, of one direction; the first last,
    /// since the last that is added is the next to be looked at.
    fn divided(&self, cell: &Cell, by: usize, only_open: bool) -> impl Iterator<Item = Cell> {
        let thresholds = self.thresholds.get(by).map_or(0, Vec::len);
        let pieces = (0..=2 * thresholds).rev();
        let cell = cell.clone();
        pieces
            .filter(move |piece| !only_open || piece % 2 == 0)
            .map(move |piece| {
                let mut finer = cell.clone();
                if let Some(slot) = finer.get_mut(by) {
                    *slot = Some(piece);
                }
                finer
            })
    }

    fn truth(&self, guard: &Formula, cell: &Cell) -> Truth {
        guard.truth(&|direction, threshold| self.order(cell, direction, threshold))
    }

    /// How a direction compares to one of its thresholds in the cell.
    fn order(&self, cell: &Cell, direction: usize, threshold: &BigRational) -> Option<Ordering> {
        let piece = cell.get(direction).copied().flatten()?;
        let index = self.thresholds.get(direction)?.binary_search(threshold);
        Some(piece.cmp(&(2 * index.ok()? + 1)))
    }

    /// The pieces that make up a cell.
    pub fn bounds(&self, cell: &Cell) -> Vec<Piece> {
        let mut found = Vec::new();
        for ((direction, list), piece) in self.directions.iter().zip(&self.thresholds).zip(cell) {
            let Some(piece) = *piece else { continue };
            let is_point = piece % 2 == 1;
            let at = |index: Option<usize>| index.and_then(|index| list.get(index).cloned());
            found.push(Piece {
                direction: affine(direction),
                lower: at(if is_point {
                    Some(piece / 2)
                } else {
                    (piece / 2).checked_sub(1)
                }),
                upper: at(Some(piece / 2)),
                is_closed: is_point,
            });
        }
        found
    }

    /// The cell in the user's names: `x = 0 and u < 1`.
    pub fn describe(&self, cell: &Cell, graph: &mut Graph, names: &Names) -> String {
        let mut parts = Vec::new();
        for piece in self.bounds(cell) {
            let e = piece.direction.build(graph);
            let mut shown = |value: &BigRational| {
                let e = graph.constant(value.clone());
                graph.show(e, names)
            };
            let (lower, upper) = (
                piece.lower.as_ref().map(&mut shown),
                piece.upper.as_ref().map(&mut shown),
            );
            // A difference that is compared with zero is shown by its two sides.
            let sides = match *graph.node(e) {
                Node::Binary(Binary::Sub, a, b) => {
                    Some((graph.show(a, names), graph.show(b, names)))
                }
                _ => None,
            };
            let text = graph.show(e, names);
            let one_sided = |symbol: &str, threshold: String| match &sides {
                Some((a, b)) if threshold == "0" => format!("{a} {symbol} {b}"),
                _ => format!("{text} {symbol} {threshold}"),
            };
            parts.push(match (lower, upper) {
                (Some(at), _) if piece.is_closed => one_sided("=", at),
                (Some(lo), Some(hi)) => format!("{lo} < {text} < {hi}"),
                (Some(lo), None) => one_sided(">", lo),
                (None, Some(hi)) => one_sided("<", hi),
                (None, None) => continue,
            });
        }
        if parts.is_empty() {
            "everywhere".to_string()
        } else {
            parts.join(" and ")
        }
    }
}

fn affine(direction: &Direction) -> Affine {
    Affine {
        terms: direction.clone(),
        constant: BigRational::zero(),
    }
}
