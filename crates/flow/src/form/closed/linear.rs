//! A right-hand side that is affine in the states.

use super::super::output::Output;
use super::super::piece::{Shape, gradient};
use super::super::set::Form;
use super::value::{Matrix, Value};
use veribound_interval::Interval;
use veribound_model::{ExprId, Graph, Layout, Var};

/// `x' = A(p, u) x + g(p, u)`, compiled.
#[derive(Debug)]
pub(in super::super) struct Linear {
    states: usize,
    /// What of `A` is not zero: row, column, entry.
    slopes: Vec<(usize, usize, Output)>,
    /// What of `g` is not zero.
    drive: Vec<(usize, Output)>,
    /// What of `∂g/∂u` is not zero: state, input, entry.
    by_input: Vec<(usize, usize, Output)>,
    /// The inputs that `A` depends on.
    pub(super) steering: Vec<usize>,
}

/// `g` on a form.
pub(super) struct Drive {
    /// With all inputs in the middle.
    pub(super) middle: Vec<Value>,
    /// How far the values inputs can have take it from there.
    pub(super) spread: Vec<f64>,
}

impl Linear {
    /// `None` if slopes depend on states.
    pub(in super::super) fn compile(
        graph: &mut Graph,
        layout: Layout,
        shape: &Shape,
    ) -> Option<Linear> {
        let states = layout.states;
        let rates = shape.held_in(graph, &shape.rates);
        let zero = graph.integer(0);
        let mut linear = Linear {
            states,
            slopes: Vec::new(),
            drive: Vec::new(),
            by_input: Vec::new(),
            steering: Vec::new(),
        };
        for (i, rate) in rates.iter().enumerate() {
            for (l, slope) in slopes_of(graph, *rate)? {
                for var in graph.variables(slope) {
                    if let Var::Input(input) = var
                        && !linear.steering.contains(&input)
                    {
                        linear.steering.push(input);
                    }
                }
                let entry = Output::compile(graph, states, slope);
                linear.slopes.push((i, l, entry));
            }
            let rest = graph.substitute(*rate, &|var| match var {
                Var::State(_) => Some(zero),
                _ => None,
            });
            if rest == zero {
                continue;
            }
            linear.drive.push((i, Output::compile(graph, states, rest)));
            for input in 0..layout.inputs {
                let slope = graph.derivative(rest, Var::Input(input));
                if slope != zero {
                    let entry = Output::compile(graph, states, slope);
                    linear.by_input.push((i, input, entry));
                }
            }
        }
        Some(linear)
    }

    /// `A` on a form; `None` where it is undefined.
    pub(super) fn matrix(&self, form: &Form, inputs: &[Interval]) -> Option<Matrix> {
        let mut matrix = Matrix::zero(self.states);
        for (i, l, entry) in &self.slopes {
            let (polynomial, radius) = form.evaluate(entry, inputs).ok()?;
            if let Some(slot) = matrix.entries.get_mut(i * self.states + l) {
                *slot = Value::of(polynomial, radius);
            }
        }
        Some(matrix)
    }

    /// `g` on a form; `None` where it is undefined or has no slope.
    ///
    /// Proof. By the mean value theorem `g(p, u)` differs from its value with the inputs in the middle by at most
    /// the slopes on the whole box of the inputs times how far they are from the middle.
    pub(super) fn drive(&self, form: &Form, inputs: &[Interval]) -> Option<Drive> {
        let middles: Vec<Interval> = inputs.iter().map(|u| Interval::point(u.mid())).collect();
        let mut drive = Drive {
            middle: vec![Value::constant(0.0); self.states],
            spread: vec![0.0; self.states],
        };
        for (i, entry) in &self.drive {
            let (polynomial, radius) = form.evaluate(entry, &middles).ok()?;
            *drive.middle.get_mut(*i)? = Value::of(polynomial, radius);
        }
        let wide = |input: usize| inputs.get(input).is_none_or(|u| !u.is_point());
        for (i, input, entry) in self.by_input.iter().filter(|entry| wide(entry.1)) {
            let (polynomial, radius) = form.evaluate(entry, inputs).ok()?;
            let slope = Value::of(polynomial, radius).hull().mag();
            let off = Interval::point(slope) * Interval::point(inputs.get(*input)?.rad());
            let spread = drive.spread.get_mut(*i)?;
            *spread = (Interval::point(*spread) + off).hi();
        }
        Some(drive)
    }
}

/// The slopes of a rate in the states, if they depend on no state.
pub(in super::super) fn slopes_of(graph: &mut Graph, rate: ExprId) -> Option<Vec<(usize, ExprId)>> {
    let slopes = gradient(graph, rate);
    let depends = |e: ExprId| {
        let mut variables = graph.variables(e).into_iter();
        variables.any(|var| matches!(var, Var::State(_)))
    };
    (!slopes.iter().any(|(_, slope)| depends(*slope))).then_some(slopes)
}
