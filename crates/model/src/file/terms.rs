//! The terms of right-hand sides as they are written, to be named in messages.

use crate::diagnostic::SourceText;
use crate::file::equations::WrittenMode;
use crate::file::lower::Lowering;
use crate::file::scope::Equation;
use crate::model::Term;
use crate::syntax::ast::{Arithmetic, Ast, Kind};

/// The terms that the right-hand sides are sums of, state by state; a term of several modes stands once.
pub(crate) fn of(source: &SourceText, lowering: &mut Lowering, modes: &[WrittenMode]) -> Vec<Term> {
    let mut terms: Vec<Term> = Vec::new();
    for mode in modes {
        let equations = mode.der.iter().enumerate();
        let equations = equations.filter_map(|(state, e)| Some((state, e.as_ref()?)));
        for (state, equation) in equations {
            let mut parts = Vec::new();
            summands(&equation.ast, &mut parts);
            for part in parts {
                let Some(expr) = lowering.spanned(part) else {
                    continue;
                };
                let is_known = |term: &Term| term.state == state && term.expr == expr;
                if !terms.iter().any(is_known) {
                    terms.push(written(source, equation, part, (state, expr)));
                }
            }
        }
    }
    terms.sort_by_key(|term| term.state);
    terms
}

fn summands<'a>(ast: &'a Ast, parts: &mut Vec<&'a Ast>) {
    match &ast.kind {
        Kind::Arithmetic(Arithmetic::Add | Arithmetic::Subtract, a, b) => {
            summands(a, parts);
            summands(b, parts);
        }
        Kind::Negate(a) => summands(a, parts),
        _ => parts.push(ast),
    }
}

fn written(
    source: &SourceText,
    equation: &Equation,
    part: &Ast,
    (state, expr): (usize, crate::graph::ExprId),
) -> Term {
    let range = part.range.clone();
    let start = equation.text.place(range.clone()).start;
    let before = source.text.get(..start).unwrap_or_default();
    let text = equation.text.value.get(range).unwrap_or_default().trim();
    Term {
        state,
        expr,
        text: text.to_owned(),
        line: before.matches('\n').count() + 1,
    }
}
