//! Every expression of a model, to be read or replaced.

use crate::graph::ExprId;
use crate::model::{Guard, Model};

/// What an expression is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Use {
    /// Its value.
    Value,
    /// How it compares to zero.
    Sign,
    /// A message.
    Message,
}

impl Model {
    /// Hands out every expression, each to be replaced by one of the same meaning.
    pub(crate) fn each_expression(&mut self, take: &mut dyn FnMut(&mut ExprId, Use)) {
        for mode in &mut self.modes {
            each_of_guard(&mut mode.guard, take);
            mode.der.iter_mut().for_each(|expr| take(expr, Use::Value));
        }
        for jump in &mut self.jumps {
            each_of_guard(&mut jump.guard, take);
            let set = jump.set.iter_mut();
            set.for_each(|(_, expr)| take(expr, Use::Value));
        }
        each_of_guard(&mut self.flows, take);
        for output in &mut self.outputs {
            take(&mut output.expr, Use::Value);
        }
        for expr in self
            .signals
            .iter_mut()
            .flat_map(|signal| &mut signal.proves_zero)
        {
            take(expr, Use::Sign);
        }
        for term in &mut self.terms {
            take(&mut term.expr, Use::Message);
        }
    }
}

fn each_of_guard(guard: &mut Guard, take: &mut dyn FnMut(&mut ExprId, Use)) {
    match guard {
        Guard::Always => {}
        Guard::Atom { expr, .. } => take(expr, Use::Sign),
        Guard::All(parts) | Guard::Any(parts) => {
            parts.iter_mut().for_each(|part| each_of_guard(part, take));
        }
    }
}
