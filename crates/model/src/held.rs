//! Inputs that are constant for a while, as parameters.

use crate::graph::{ExprId, Var};
use crate::model::{Model, Param};
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
        model.each_expression(&mut |expr, _| *expr = graph.substitute(*expr, &replacement));
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
