//! Conditions.

use super::Lowering;
use crate::model::{Guard, Relation};
use crate::syntax::Problem;
use crate::syntax::ast::{Ast, Kind};

impl Lowering<'_> {
    pub(super) fn condition(
        &mut self,
        ast: &Ast,
        negate: bool,
        problems: &mut Vec<Problem>,
    ) -> Option<Guard> {
        match &ast.kind {
            Kind::Always if !negate => Some(Guard::Always),
            Kind::Always => {
                problems.push(Problem::new(
                    "E0116",
                    "a condition is never true",
                    ast.range.clone(),
                    "negated",
                    "remove it",
                ));
                None
            }
            Kind::Not(a) => self.condition(a, !negate, problems),
            Kind::And(a, b) | Kind::Or(a, b) => {
                let conjunction = matches!(ast.kind, Kind::And(..)) != negate;
                let (a, b) = (
                    self.condition(a, negate, problems),
                    self.condition(b, negate, problems),
                );
                Some(if conjunction {
                    both(a?, b?)
                } else {
                    either(a?, b?)
                })
            }
            Kind::Compare(relation, a, b) => {
                let (left, right) = (self.value(a, problems), self.value(b, problems));
                let left = self.refuse_switches(left?, a, problems)?;
                let right = self.refuse_switches(right?, b, problems)?;
                let relation = if negate {
                    opposite(*relation)
                } else {
                    *relation
                };
                Some(Guard::Atom {
                    expr: self.graph.sub(left, right),
                    relation,
                })
            }
            _ => {
                problems.push(Problem::new(
                    "E0116",
                    "expected a condition, found a value",
                    ast.range.clone(),
                    "a value",
                    "compare it with something, as in \"omega > 0\"",
                ));
                None
            }
        }
    }
}

/// Both hold.
pub(crate) fn both(a: Guard, b: Guard) -> Guard {
    match (a, b) {
        (Guard::Always, other) | (other, Guard::Always) => other,
        (Guard::All(mut list), Guard::All(more)) => {
            list.extend(more);
            Guard::All(list)
        }
        (Guard::All(mut list), other) => {
            list.push(other);
            Guard::All(list)
        }
        (first, Guard::All(mut list)) => {
            list.insert(0, first);
            Guard::All(list)
        }
        (a, b) => Guard::All(vec![a, b]),
    }
}

/// At least one holds.
pub(crate) fn either(a: Guard, b: Guard) -> Guard {
    match (a, b) {
        (Guard::Always, _) | (_, Guard::Always) => Guard::Always,
        (Guard::Any(mut list), Guard::Any(more)) => {
            list.extend(more);
            Guard::Any(list)
        }
        (Guard::Any(mut list), other) => {
            list.push(other);
            Guard::Any(list)
        }
        (first, Guard::Any(mut list)) => {
            list.insert(0, first);
            Guard::Any(list)
        }
        (a, b) => Guard::Any(vec![a, b]),
    }
}

/// True where `guard` is not; nothing is true where `guard` always is.
pub(crate) fn negated(guard: &Guard) -> Guard {
    match guard {
        Guard::Always => Guard::Any(Vec::new()),
        Guard::Atom { expr, relation } => Guard::Atom {
            expr: *expr,
            relation: opposite(*relation),
        },
        Guard::All(parts) => Guard::Any(parts.iter().map(negated).collect()),
        Guard::Any(parts) => Guard::All(parts.iter().map(negated).collect()),
    }
}

fn opposite(relation: Relation) -> Relation {
    match relation {
        Relation::Less => Relation::GreaterEqual,
        Relation::LessEqual => Relation::Greater,
        Relation::Greater => Relation::LessEqual,
        Relation::GreaterEqual => Relation::Less,
        Relation::Equal => Relation::NotEqual,
        Relation::NotEqual => Relation::Equal,
    }
}
