//! Where a right-hand side switches: expressions in guards, and what their signs say about modes.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: surfaces, modes and jumps are named by positions in the lists made here"
)]

use veribound_interval::Interval;
use veribound_model::{ExprId, Graph, Guard, Level, Model, Relation, Var};

/// The signs that an expression can have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Signs(u8);

impl Signs {
    pub(crate) const NONE: Signs = Signs(0);
    pub(crate) const NEGATIVE: Signs = Signs(1);
    pub(crate) const ZERO: Signs = Signs(2);
    pub(crate) const POSITIVE: Signs = Signs(4);
    pub(crate) const ANY: Signs = Signs(7);

    /// Those of the numbers in an interval.
    pub(crate) fn of(x: Interval) -> Signs {
        let mut signs = Signs::NONE;
        if x.lo() < 0.0 {
            signs = signs.or(Signs::NEGATIVE);
        }
        if x.contains(0.0) {
            signs = signs.or(Signs::ZERO);
        }
        if x.hi() > 0.0 {
            signs = signs.or(Signs::POSITIVE);
        }
        signs
    }

    /// The sign that is certain, if it is not zero.
    pub(crate) fn strict(x: Interval) -> Option<Signs> {
        match Signs::of(x) {
            signs @ (Signs::NEGATIVE | Signs::POSITIVE) => Some(signs),
            _ => None,
        }
    }

    pub(crate) const fn or(self, other: Signs) -> Signs {
        Signs(self.0 | other.0)
    }

    pub(crate) fn and(self, other: Signs) -> Signs {
        Signs(self.0 & other.0)
    }

    pub(crate) fn within(self, other: Signs) -> bool {
        self.0 & !other.0 == 0
    }

    pub(crate) fn has(self, other: Signs) -> bool {
        self.and(other) != Signs::NONE
    }

    /// Of the negated expression.
    pub(crate) fn flipped(self) -> Signs {
        Signs(self.0 & 2 | self.0 >> 2 | (self.0 & 1) << 2)
    }
}

/// A guard in terms of signs, border included.
#[derive(Debug, Clone)]
pub(crate) enum Formula {
    Always,
    Sign { surface: usize, allowed: Signs },
    All(Vec<Formula>),
    Any(Vec<Formula>),
}

impl Formula {
    /// False only where the guard holds nowhere, nor on its border.
    pub(crate) fn possible(&self, signs: &[Signs]) -> bool {
        match self {
            Formula::Always => true,
            Formula::Sign { surface, allowed } => signs[*surface].has(*allowed),
            Formula::All(parts) => parts.iter().all(|part| part.possible(signs)),
            Formula::Any(parts) => parts.iter().any(|part| part.possible(signs)),
        }
    }

    /// True only in the inside of the region.
    pub(crate) fn certain(&self, signs: &[Signs]) -> bool {
        match self {
            Formula::Always => true,
            Formula::Sign { surface, allowed } => {
                let open = match *allowed {
                    Signs::ANY => Signs::ANY,
                    allowed => allowed.and(Signs::NEGATIVE.or(Signs::POSITIVE)),
                };
                signs[*surface].within(open)
            }
            Formula::All(parts) => parts.iter().all(|part| part.certain(signs)),
            Formula::Any(parts) => parts.iter().any(|part| part.certain(signs)),
        }
    }

    /// Adds the surfaces it asks for.
    pub(crate) fn surfaces(&self, into: &mut Vec<usize>) {
        match self {
            Formula::Always => {}
            Formula::Sign { surface, .. } => {
                if !into.contains(surface) {
                    into.push(*surface);
                }
            }
            Formula::All(parts) | Formula::Any(parts) => {
                for part in parts {
                    part.surfaces(into);
                }
            }
        }
    }
}

/// An expression whose sign a guard asks for.
#[derive(Debug, Clone)]
pub(crate) struct Surface {
    pub(crate) expr: ExprId,
    /// State and slope.
    pub(crate) gradient: Vec<(usize, ExprId)>,
    /// The inputs it depends on.
    pub(crate) inputs: Vec<usize>,
    /// Where it compares a state with a number.
    pub(crate) level: Option<Level>,
}

/// All surfaces of a model, and its guards in terms of them.
#[derive(Debug, Clone)]
pub(crate) struct Surfaces {
    pub(crate) list: Vec<Surface>,
    /// Of every mode.
    pub(crate) modes: Vec<Formula>,
    /// Of every jump.
    pub(crate) jumps: Vec<Formula>,
}

impl Surfaces {
    pub(crate) fn of(graph: &mut Graph, model: &Model) -> Surfaces {
        let mut list = Vec::new();
        let modes: Vec<&Guard> = model.modes.iter().map(|mode| &mode.guard).collect();
        let jumps: Vec<&Guard> = model.jumps.iter().map(|jump| &jump.guard).collect();
        let mut all = |guards: Vec<&Guard>| -> Vec<Formula> {
            let formulas = guards.into_iter();
            formulas
                .map(|guard| formula(guard, graph, &mut list))
                .collect()
        };
        let (modes, jumps) = (all(modes), all(jumps));
        Surfaces { list, modes, jumps }
    }
}

fn formula(guard: &Guard, graph: &mut Graph, list: &mut Vec<Surface>) -> Formula {
    let mut parts = |parts: &[Guard], list: &mut Vec<Surface>| -> Vec<Formula> {
        parts
            .iter()
            .map(|part| formula(part, graph, list))
            .collect()
    };
    match guard {
        Guard::Always => Formula::Always,
        Guard::All(all) => Formula::All(parts(all, list)),
        Guard::Any(any) => Formula::Any(parts(any, list)),
        Guard::Atom { expr, relation } => {
            let allowed = match relation {
                Relation::Less | Relation::LessEqual => Signs::NEGATIVE.or(Signs::ZERO),
                Relation::Greater | Relation::GreaterEqual => Signs::POSITIVE.or(Signs::ZERO),
                Relation::Equal => Signs::ZERO,
                Relation::NotEqual => Signs::ANY,
            };
            let expr = graph.elementary(*expr);
            let opposite = graph.neg(expr);
            for (surface, known) in list.iter().enumerate() {
                if known.expr == expr {
                    return Formula::Sign { surface, allowed };
                }
                if known.expr == opposite {
                    let allowed = allowed.flipped();
                    return Formula::Sign { surface, allowed };
                }
            }
            let inputs = graph
                .variables(expr)
                .into_iter()
                .filter_map(|var| match var {
                    Var::Input(i) => Some(i),
                    _ => None,
                });
            let inputs = inputs.collect();
            list.push(Surface {
                gradient: super::piece::gradient(graph, expr),
                level: graph.level(expr),
                expr,
                inputs,
            });
            let surface = list.len() - 1;
            Formula::Sign { surface, allowed }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_of_intervals() {
        let cases = [
            (-1.0, 1.0, 7),
            (0.0, 0.0, 2),
            (0.0, 2.0, 6),
            (-1.0, -0.5, 1),
        ];
        for (lo, hi, bits) in cases {
            let x = Interval::new(lo, hi).unwrap();
            assert_eq!(Signs::of(x), Signs(bits));
            assert_eq!(Signs::of(-x), Signs(bits).flipped());
        }
    }
}
