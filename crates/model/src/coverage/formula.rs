//! The claim "some guard holds" as a formula over exact comparisons, and its cells.

use crate::coverage::affine::Affine;
use crate::graph::{Binary, ExprId, Graph, Names, Node, Unary};
use crate::model::{Guard, Relation};
use num_rational::BigRational;
use num_traits::{Signed, Zero};
use std::collections::BTreeMap;
use veribound_interval::Truth;

/// Comparisons after `abs`, `min` and `max` are resolved.
const MOST_COMPARISONS: usize = 400;
/// Partly filled cells that are looked at.
const MOST_VISITS: usize = 20_000;
/// Cells without a guard that are looked into.
const MOST_CELLS: usize = 200;

/// A linear combination without constant, its first coefficient `1`.
type Direction = BTreeMap<ExprId, BigRational>;

enum Formula {
    Constant(bool),
    /// `direction relation threshold`
    Comparison {
        direction: usize,
        threshold: BigRational,
        relation: Relation,
    },
    All(Vec<Formula>),
    Any(Vec<Formula>),
}

/// That some guard holds.
pub(crate) struct Claim {
    formula: Formula,
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

impl Claim {
    /// `None` when the guards are too long to be examined.
    pub fn of(graph: &Graph, guards: &[Guard]) -> Option<Claim> {
        let mut builder = Builder {
            graph,
            directions: Vec::new(),
            comparisons: 0,
        };
        let parts: Option<Vec<Formula>> = guards.iter().map(|guard| builder.guard(guard)).collect();
        let formula = Formula::Any(parts?);
        let mut thresholds = vec![Vec::new(); builder.directions.len()];
        collect(&formula, &mut thresholds);
        for list in &mut thresholds {
            list.sort();
            list.dedup();
        }
        Some(Claim {
            formula,
            directions: builder.directions,
            thresholds,
        })
    }

    /// The cells where no guard holds; `None` when there are too many to look at.
    pub fn uncovered_cells(&self) -> Option<Vec<Cell>> {
        let mut found = Vec::new();
        let mut visits = 0;
        let mut open: Vec<Cell> = vec![vec![None; self.directions.len()]];
        while let Some(cell) = open.pop() {
            visits += 1;
            if visits > MOST_VISITS || found.len() > MOST_CELLS {
                return None;
            }
            match self.truth(&self.formula, &cell) {
                Truth::True => {}
                Truth::False => found.push(cell),
                Truth::Unknown => {
                    // Every comparison of a filled cell is decided, so one direction is open.
                    let Some(next) = cell.iter().position(Option::is_none) else {
                        continue;
                    };
                    let pieces = 2 * self.thresholds.get(next).map_or(0, Vec::len) + 1;
                    for piece in 0..pieces {
                        let mut finer = cell.clone();
                        if let Some(slot) = finer.get_mut(next) {
                            *slot = Some(piece);
                        }
                        open.push(finer);
                    }
                }
            }
        }
        Some(found)
    }

    fn truth(&self, formula: &Formula, cell: &Cell) -> Truth {
        match formula {
            Formula::Constant(value) => {
                if *value {
                    Truth::True
                } else {
                    Truth::False
                }
            }
            Formula::All(list) => list
                .iter()
                .fold(Truth::True, |all, part| all.and(self.truth(part, cell))),
            Formula::Any(list) => list
                .iter()
                .fold(Truth::False, |any, part| any.or(self.truth(part, cell))),
            Formula::Comparison {
                direction,
                threshold,
                relation,
            } => {
                let piece = cell.get(*direction).copied().flatten();
                let list = self.thresholds.get(*direction);
                let (Some(piece), Some(Ok(index))) =
                    (piece, list.map(|list| list.binary_search(threshold)))
                else {
                    return Truth::Unknown;
                };
                let holds = relation.admits(piece.cmp(&(2 * index + 1)));
                if holds { Truth::True } else { Truth::False }
            }
        }
    }

    /// The pieces that make up a cell.
    pub fn bounds(&self, cell: &Cell) -> Vec<Piece> {
        let mut found = Vec::new();
        for ((direction, list), piece) in self.directions.iter().zip(&self.thresholds).zip(cell) {
            let Some(piece) = *piece else { continue };
            let is_point = piece % 2 == 1;
            let at = |index: Option<usize>| index.and_then(|index| list.get(index).cloned());
            found.push(Piece {
                direction: Affine {
                    terms: direction.clone(),
                    constant: BigRational::zero(),
                },
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

fn collect(formula: &Formula, thresholds: &mut [Vec<BigRational>]) {
    match formula {
        Formula::Constant(_) => {}
        Formula::Comparison {
            direction,
            threshold,
            ..
        } => {
            if let Some(list) = thresholds.get_mut(*direction) {
                list.push(threshold.clone());
            }
        }
        Formula::All(list) | Formula::Any(list) => {
            for part in list {
                collect(part, thresholds);
            }
        }
    }
}

impl Relation {
    /// Whether a quantity that compares to the threshold like `order` fulfils the relation.
    fn admits(self, order: std::cmp::Ordering) -> bool {
        match self {
            Relation::Less => order.is_lt(),
            Relation::LessEqual => order.is_le(),
            Relation::Greater => order.is_gt(),
            Relation::GreaterEqual => order.is_ge(),
            Relation::Equal => order.is_eq(),
            Relation::NotEqual => order.is_ne(),
        }
    }

    /// The relation of the two sides exchanged.
    fn mirrored(self) -> Relation {
        match self {
            Relation::Less => Relation::Greater,
            Relation::LessEqual => Relation::GreaterEqual,
            Relation::Greater => Relation::Less,
            Relation::GreaterEqual => Relation::LessEqual,
            Relation::Equal | Relation::NotEqual => self,
        }
    }
}

struct Builder<'g> {
    graph: &'g Graph,
    directions: Vec<Direction>,
    comparisons: usize,
}

impl Builder<'_> {
    fn guard(&mut self, guard: &Guard) -> Option<Formula> {
        let list = |builder: &mut Self, list: &[Guard]| -> Option<Vec<Formula>> {
            list.iter().map(|part| builder.guard(part)).collect()
        };
        Some(match guard {
            Guard::Always => Formula::Constant(true),
            Guard::All(parts) => Formula::All(list(self, parts)?),
            Guard::Any(parts) => Formula::Any(list(self, parts)?),
            Guard::Atom { expr, relation } => {
                let form = Affine::of(self.graph, *expr)?;
                self.comparison(form, *relation)?
            }
        })
    }

    /// `form relation 0`
    fn comparison(&mut self, form: Affine, relation: Relation) -> Option<Formula> {
        self.comparisons += 1;
        if self.comparisons > MOST_COMPARISONS {
            return None;
        }
        if form.terms.is_empty() {
            return Some(Formula::Constant(
                relation.admits(form.constant.cmp(&BigRational::zero())),
            ));
        }
        if let Some((is_larger, a, b)) = self.resolved(&form)? {
            return self.one_of_two(is_larger, a, b, relation);
        }
        let Some(first) = form.terms.values().next().cloned() else {
            return Some(Formula::Constant(false));
        };
        let relation = if first.is_negative() {
            relation.mirrored()
        } else {
            relation
        };
        let unit = form.scaled(&first.recip());
        let known = self
            .directions
            .iter()
            .position(|direction| *direction == unit.terms);
        let direction = known.unwrap_or(self.directions.len());
        if known.is_none() {
            self.directions.push(unit.terms);
        }
        Some(Formula::Comparison {
            direction,
            threshold: -unit.constant,
            relation,
        })
    }

    /// The first term that is an `abs`, `min` or `max`: the form is then the larger (or smaller) of
    /// two forms without it.
    fn resolved(&self, form: &Affine) -> Option<Option<(bool, Affine, Affine)>> {
        for &term in form.terms.keys() {
            let (is_larger, a, b) = match *self.graph.node(term) {
                Node::Unary(Unary::Abs, a) => {
                    let a = Affine::of(self.graph, a)?;
                    let negative = a.scaled(&BigRational::from_integer((-1).into()));
                    (true, a, negative)
                }
                Node::Binary(which @ (Binary::Min | Binary::Max), a, b) => (
                    which == Binary::Max,
                    Affine::of(self.graph, a)?,
                    Affine::of(self.graph, b)?,
                ),
                _ => continue,
            };
            let (rest, factor) = form.split(term)?;
            let (a, b) = (rest.plus(&a.scaled(&factor)), rest.plus(&b.scaled(&factor)));
            return Some(Some((is_larger == factor.is_positive(), a, b)));
        }
        Some(None)
    }

    /// `max(a, b) relation 0`, or with `min`.
    fn one_of_two(
        &mut self,
        is_larger: bool,
        a: Affine,
        b: Affine,
        relation: Relation,
    ) -> Option<Formula> {
        let is_below = match relation {
            Relation::Less | Relation::LessEqual => true,
            Relation::Greater | Relation::GreaterEqual => false,
            Relation::Equal | Relation::NotEqual => {
                let (below, above) = if relation == Relation::Equal {
                    (Relation::LessEqual, Relation::GreaterEqual)
                } else {
                    (Relation::Less, Relation::Greater)
                };
                let parts = vec![
                    self.one_of_two(is_larger, a.clone(), b.clone(), below)?,
                    self.one_of_two(is_larger, a, b, above)?,
                ];
                let both = relation == Relation::Equal;
                return Some(if both {
                    Formula::All(parts)
                } else {
                    Formula::Any(parts)
                });
            }
        };
        let parts = vec![self.comparison(a, relation)?, self.comparison(b, relation)?];
        Some(if is_below == is_larger {
            Formula::All(parts)
        } else {
            Formula::Any(parts)
        })
    }
}
