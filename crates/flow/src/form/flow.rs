//! A model with one smooth right-hand side, compiled for forms.
#![allow(clippy::indexing_slicing, reason = "PROOF: one entry per state")]

use super::code::Code;
use super::function::Functions;
use super::set::{Form, FormOptions};
use super::step::{Obstacle, Scratch};
use veribound_interval::Interval;
use veribound_model::{ExprId, Model, Var};

/// Shortest step, as share of the time to go.
const SHORTEST: f64 = 1e-7;

/// A model of one mode, compiled. Immutable and shared between threads.
#[derive(Debug, Clone)]
pub struct Flow {
    pub(super) code: Code,
    pub(super) functions: Functions,
    pub(super) states: usize,
    /// Registers of the rates of the states.
    pub(super) rates: Vec<usize>,
    /// The entries of `∂f/∂x` that are not zero: row, column, register.
    pub(super) slopes: Vec<(usize, usize, usize)>,
}

/// Forms are made for models with one right-hand side and without jumps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SeveralModes {
    /// So many modes the model has.
    pub modes: usize,
    /// So many jumps.
    pub jumps: usize,
}

/// A stretch of time could not be proved. It says nothing about the existence of solutions.
#[derive(Debug, Clone, PartialEq)]
pub struct Diverged {
    /// Why.
    pub obstacle: Obstacle,
    /// Where the width is largest, compared to what it was at the start of the stretch.
    pub state: usize,
    /// Time since the start up to which the form was moved.
    pub reached: Interval,
}

impl Flow {
    /// Compiles `model`.
    ///
    /// Cost: one symbolic derivative per pair of states.
    pub fn new(model: &Model) -> Result<Flow, SeveralModes> {
        let ([mode], []) = (&model.modes[..], &model.jumps[..]) else {
            return Err(SeveralModes {
                modes: model.modes.len(),
                jumps: model.jumps.len(),
            });
        };
        let mut graph = model.graph.clone();
        let layout = model.layout();
        let mut entries: Vec<(usize, usize, ExprId)> = Vec::new();
        let rates: Vec<ExprId> = mode.der.iter().map(|e| graph.elementary(*e)).collect();
        for (i, rate) in rates.iter().enumerate() {
            for l in 0..layout.states {
                let slope = graph.derivative(*rate, Var::State(l));
                if slope != graph.integer(0) {
                    entries.push((i, l, slope));
                }
            }
        }
        let secondary: Vec<ExprId> = entries.iter().map(|entry| entry.2).collect();
        let code = Code::compile(&mut graph, layout.states, &rates, &secondary);
        let functions = Functions::of(&code);
        let (rates, slopes) = code.roots.split_at(layout.states);
        Ok(Flow {
            rates: rates.to_vec(),
            slopes: entries
                .iter()
                .zip(slopes)
                .map(|(&(i, l, _), &register)| (i, l, register))
                .collect(),
            functions,
            states: layout.states,
            code,
        })
    }

    /// The form of all start values in `states` and parameters in `params`.
    ///
    /// Quantities whose width is not negligible become unknowns that dependence is kept on.
    pub fn start(&self, states: &[Interval], params: &[Interval], options: FormOptions) -> Form {
        Form::new(states, params, options)
    }

    /// Moves a form over `dt` seconds, in as many steps as it takes.
    ///
    /// Guarantee: for all unknowns, and for inputs that are any measurable functions of time in
    /// `inputs`, every solution of the model exists that long and lies in the form afterwards, and in
    /// [`Form::tube`] at all times between; the end may lie anywhere in `dt`. On failure the form stands
    /// where it was.
    ///
    /// Errors: [`Diverged`] where no step could be proved.
    pub fn advance(
        &self,
        form: &mut Form,
        inputs: &[Interval],
        dt: Interval,
    ) -> Result<(), Diverged> {
        let mut next = form.clone();
        self.go(&mut next, inputs, dt, f64::INFINITY)?;
        *form = next;
        Ok(())
    }

    /// As [`Flow::advance`], but on failure the form stands somewhere on the way; and it is a failure when
    /// the share of a width that is no function of the unknowns passes `most`.
    pub(super) fn go(
        &self,
        form: &mut Form,
        inputs: &[Interval],
        dt: Interval,
        most: f64,
    ) -> Result<(), Diverged> {
        let before = form.quick_hull();
        form.tube.copy_from_slice(&before);
        let mut scratch = Scratch::new(self, form);
        let begin = form.elapsed;
        let mut left = dt;
        while left.hi() > 0.0 {
            let shortest = SHORTEST * dt.hi();
            let step = self.single_step(form, &mut scratch, inputs, left, shortest);
            let step = match step {
                Ok(_) if most < 1.0 && form.excess() > most => Err(Obstacle::TooLong),
                step => step,
            };
            match step {
                Ok(moved) => {
                    let done = moved == left;
                    form.elapsed += moved;
                    if done {
                        break;
                    }
                    left -= moved;
                }
                Err(obstacle) => {
                    return Err(Diverged {
                        obstacle,
                        state: widest_growth(&before, &form.quick_hull()),
                        reached: form.elapsed,
                    });
                }
            }
        }
        form.elapsed = begin + dt;
        Ok(())
    }
}

/// The state whose width grew most.
fn widest_growth(before: &[Interval], after: &[Interval]) -> usize {
    let growth = |i: usize| {
        let start = before[i].width() + 1e-12 * before[i].mag() + 1e-300;
        after[i].width() / start
    };
    (0..before.len())
        .max_by(|a, b| growth(*a).total_cmp(&growth(*b)))
        .unwrap_or(0)
}
