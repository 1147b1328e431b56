//! Inputs that are constant for a while, as parameters.

use crate::graph::{ExprId, Var};
use crate::model::{Guard, Model, Param};
use veribound_interval::Interval;

impl Model {
    /// The same equations with these inputs as parameters, in this order, behind the others: nothing depends on the
    /// inputs of that name any more, and the parameters may have any value.
    pub fn with_inputs_as_params(&self, inputs: &[usize]) -> Model {
        let mut model = self.clone();
        let first = self.params.len();
        let mut graph = self.graph.clone();
        let params: Vec<ExprId> = (0..inputs.len())
            .map(|position| graph.var(Var::Param(first + position)))
            .collect();
        let replacement = |var: Var| match var {
            Var::Input(input) => {
                let position = inputs.iter().position(|own| *own == input)?;
                params.get(position).copied()
            }
            _ => None,
        };
        let mut move_over = |expr: &mut ExprId| *expr = graph.substitute(*expr, &replacement);
        for mode in &mut model.modes {
            move_guard(&mut mode.guard, &mut move_over);
            mode.der.iter_mut().for_each(&mut move_over);
        }
        for jump in &mut model.jumps {
            move_guard(&mut jump.guard, &mut move_over);
            jump.set.iter_mut().for_each(|(_, expr)| move_over(expr));
        }
        move_guard(&mut model.flows, &mut move_over);
        for output in &mut model.outputs {
            move_over(&mut output.expr);
        }
        for signal in &mut model.signals {
            signal.proves_zero.iter_mut().for_each(&mut move_over);
        }
        for term in &mut model.terms {
            move_over(&mut term.expr);
        }
        let named = inputs.iter().filter_map(|input| self.inputs.get(*input));
        model.params.extend(named.map(|input| Param {
            name: input.name.clone(),
            unit: input.unit.clone(),
            bounds: Interval::ENTIRE,
            nominal: None,
        }));
        model.graph = graph;
        model
    }
}

fn move_guard(guard: &mut Guard, move_over: &mut dyn FnMut(&mut ExprId)) {
    match guard {
        Guard::Always => {}
        Guard::Atom { expr, .. } => move_over(expr),
        Guard::All(parts) | Guard::Any(parts) => {
            parts
                .iter_mut()
                .for_each(|part| move_guard(part, move_over));
        }
    }
}
