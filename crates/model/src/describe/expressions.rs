//! Expressions and guards in the user's names.

use crate::graph::{Binary, Choice, ExprId, Names, Node};
use crate::model::{Guard, Model, Relation};
use std::collections::HashMap;

/// Longer expressions are not printed: sharing inside of them can make the text exponential.
const LONGEST_SHOWN: usize = 400;

impl Model {
    pub(super) fn shown_guard(&self, guard: &Guard, names: &Names, is_inside: bool) -> String {
        let (list, word) = match guard {
            Guard::Always => return "true".to_string(),
            Guard::Atom { expr, relation } => {
                return self.shown_comparison(*expr, *relation, names);
            }
            Guard::All(list) => (list, " and "),
            Guard::Any(list) => (list, " or "),
        };
        let parts: Vec<String> = list
            .iter()
            .map(|part| self.shown_guard(part, names, true))
            .collect();
        let text = parts.join(word);
        if is_inside { format!("({text})") } else { text }
    }

    /// `a relation b` for `a - b relation 0`.
    pub(super) fn shown_comparison(
        &self,
        expr: ExprId,
        relation: Relation,
        names: &Names,
    ) -> String {
        let symbol = match relation {
            Relation::Less => "<",
            Relation::LessEqual => "<=",
            Relation::Greater => ">",
            Relation::GreaterEqual => ">=",
            Relation::Equal => "==",
            Relation::NotEqual => "!=",
        };
        match *self.graph.node(expr) {
            Node::Binary(Binary::Sub, a, b) => {
                format!("{} {symbol} {}", self.shown(a, names), self.shown(b, names))
            }
            Node::Binary(Binary::Add, a, b) if self.graph.as_constant(b).is_some() => {
                format!(
                    "{} {symbol} -{}",
                    self.shown(a, names),
                    self.shown(b, names)
                )
            }
            Node::Binary(Binary::Add, b, a) if self.graph.as_constant(b).is_some() => {
                format!(
                    "{} {symbol} -{}",
                    self.shown(a, names),
                    self.shown(b, names)
                )
            }
            _ => format!("{} {symbol} 0", self.shown(expr, names)),
        }
    }

    /// The expression, or its size where it is too long to be read.
    pub(super) fn shown(&self, e: ExprId, names: &Names) -> String {
        let mut sizes: HashMap<ExprId, usize> = HashMap::new();
        for at in self.graph.reachable(&[e]) {
            let size = |e: &ExprId| sizes.get(e).copied().unwrap_or(0);
            let total = match self.graph.node(at) {
                Node::Constant(value) => {
                    // A fraction without a short decimal is printed with all its digits.
                    1 + (value.numer().bits().max(value.denom().bits()) / 64) as usize
                }
                Node::Pi | Node::Var(_) => 1,
                Node::Unary(_, a) | Node::Power(a, _) => size(a).saturating_add(1),
                Node::Binary(_, a, b) => size(a).saturating_add(size(b)).saturating_add(1),
                Node::Choose(Choice { test, yes, no }) => {
                    let branches = size(yes).saturating_add(size(no));
                    branches.saturating_add(size(test)).saturating_add(1)
                }
            };
            sizes.insert(at, total);
        }
        match sizes.get(&e) {
            Some(size) if *size > LONGEST_SHOWN => format!("(an expression of {size} terms)"),
            _ => self.graph.show(e, names),
        }
    }
}
