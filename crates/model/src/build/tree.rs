//! Equations as they grow, and what cannot be written into a model.

use crate::syntax::ast::{Ast, Kind};
use crate::syntax::parse::DEEPEST_TREE;
use std::sync::Arc;

/// Operations of one equation. A part that is used twice is written twice, so that doubling thirty
/// times asks for more text than any memory holds.
const MOST_OPERATIONS: usize = 100_000;

/// Why there is no text for something; found when the model is built, where there is a place for it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Flaw {
    /// Text that is not a decimal number.
    NoNumber(String),
    /// Too deep or too long to be read.
    TooLong,
}

/// The syntax of a value or condition.
#[derive(Debug, Clone)]
pub(super) struct Tree {
    pub ast: Result<Arc<Ast>, Flaw>,
    operations: usize,
}

impl Tree {
    pub fn leaf(kind: Kind) -> Tree {
        Tree {
            ast: Ok(Arc::new(Ast::new(kind, 0..0))),
            operations: 1,
        }
    }

    pub fn flawed(flaw: Flaw) -> Tree {
        Tree {
            ast: Err(flaw),
            operations: 1,
        }
    }

    /// `kind` of the parts; flawed as the first of them that is.
    pub fn join<const N: usize>(parts: [&Tree; N], kind: fn([Arc<Ast>; N]) -> Kind) -> Tree {
        Self::of(&parts, |asts| match <[Arc<Ast>; N]>::try_from(asts) {
            Ok(asts) => Some(kind(asts)),
            Err(_) => None,
        })
    }

    /// A node above any number of parts.
    pub fn of(parts: &[&Tree], kind: impl FnOnce(Vec<Arc<Ast>>) -> Option<Kind>) -> Tree {
        let operations = parts
            .iter()
            .fold(1_usize, |sum, part| sum.saturating_add(part.operations));
        let asts: Result<Vec<Arc<Ast>>, Flaw> = parts.iter().map(|part| part.ast.clone()).collect();
        let ast = asts.and_then(|asts| {
            let deepest = asts.iter().map(|ast| ast.depth).max().unwrap_or(0);
            if deepest >= DEEPEST_TREE || operations > MOST_OPERATIONS {
                return Err(Flaw::TooLong);
            }
            let ast = kind(asts).map(|kind| Arc::new(Ast::new(kind, 0..0)));
            ast.ok_or(Flaw::TooLong)
        });
        Tree { ast, operations }
    }
}
