//! One smooth right-hand side, compiled.
#![allow(clippy::indexing_slicing, reason = "PROOF: one entry per state")]

use super::code::Code;
use super::function::Functions;
use veribound_interval::Interval;
use veribound_model::{ExprId, Graph, Layout, Tape, Var};

/// A smooth right-hand side, and expressions whose signs are watched along its solutions. Immutable.
#[derive(Debug, Clone)]
pub(super) struct Piece {
    pub(super) code: Code,
    pub(super) functions: Functions,
    pub(super) states: usize,
    /// Registers of the rates of the states.
    pub(super) rates: Vec<usize>,
    /// The entries of `∂f/∂x` that are not zero: row, column, register.
    pub(super) slopes: Vec<(usize, usize, usize)>,
    /// What is watched.
    pub(super) probes: Vec<Probe>,
    /// The rates, the entries of `slopes`, and what is watched with its rates, to be evaluated on boxes.
    pub(super) tape: Tape,
}

/// Registers of a watched expression.
#[derive(Debug, Clone)]
pub(super) struct Probe {
    pub(super) value: usize,
    /// Its rate of change along solutions.
    pub(super) rate: usize,
    /// State and slope.
    pub(super) gradient: Vec<(usize, usize)>,
}

impl Piece {
    /// The right-hand side `rates`, with `watched` expressions; both are elementary.
    pub(super) fn compile(
        graph: &mut Graph,
        layout: Layout,
        rates: &[ExprId],
        watched: &[ExprId],
    ) -> Piece {
        let mut entries: Vec<(usize, usize, ExprId)> = Vec::new();
        for (i, rate) in rates.iter().enumerate() {
            entries.extend(
                gradient(graph, *rate, layout)
                    .into_iter()
                    .map(|(l, e)| (i, l, e)),
            );
        }
        let mut secondary: Vec<ExprId> = entries.iter().map(|entry| entry.2).collect();
        let mut shapes = Vec::with_capacity(watched.len());
        let mut moving = Vec::with_capacity(2 * watched.len());
        for e in watched {
            let slopes = gradient(graph, *e, layout);
            let mut drift = graph.integer(0);
            for &(state, slope) in &slopes {
                let term = graph.mul(slope, rates[state]);
                drift = graph.add(drift, term);
            }
            secondary.extend([*e, drift]);
            moving.extend([*e, drift]);
            secondary.extend(slopes.iter().map(|(_, slope)| *slope));
            shapes.push(slopes);
        }
        let code = Code::compile(graph, layout.states, rates, &secondary);
        let (own, mut rest) = code.roots.split_at(layout.states);
        let mut take = |count: usize| {
            let (first, others) = rest.split_at(count);
            rest = others;
            first
        };
        let slopes = entries
            .iter()
            .zip(take(entries.len()))
            .map(|(&(i, l, _), &register)| (i, l, register))
            .collect();
        let probes = shapes
            .iter()
            .map(|shape| {
                let registers = take(2 + shape.len());
                let states = shape.iter().map(|(state, _)| *state);
                Probe {
                    value: registers[0],
                    rate: registers[1],
                    gradient: states.zip(registers[2..].iter().copied()).collect(),
                }
            })
            .collect();
        let on_boxes: Vec<ExprId> = rates
            .iter()
            .copied()
            .chain(entries.iter().map(|e| e.2))
            .chain(moving)
            .collect();
        Piece {
            rates: own.to_vec(),
            slopes,
            probes,
            tape: Tape::compile(graph, layout, &on_boxes),
            functions: Functions::of(&code),
            states: layout.states,
            code,
        }
    }

    /// The rates on a box of states, parameters and inputs, and how fast they change with the states:
    /// `|∂f/∂x|` row by row. `None` where they are undefined or jump there.
    pub(super) fn on_box(&self, quantities: &[Interval]) -> Option<(Vec<Interval>, Vec<f64>)> {
        let mut registers = self.tape.registers();
        if !self.tape.eval(quantities, &mut registers).is_defined() {
            return None;
        }
        let output = |index: usize| self.tape.output::<Interval>(index, &registers);
        let n = self.states;
        let rates = (0..n).map(output).collect();
        let mut steepness = vec![0.0; n * n];
        for (index, &(i, l, _)) in self.slopes.iter().enumerate() {
            steepness[i * n + l] = output(n + index).mag();
        }
        Some((rates, steepness))
    }

    /// What is watched on a box of states, parameters and inputs, each with its rate of change. `None` as
    /// there.
    pub(super) fn watched_on_box(&self, quantities: &[Interval]) -> Option<Vec<[Interval; 2]>> {
        let mut registers = self.tape.registers();
        if !self.tape.eval(quantities, &mut registers).is_defined() {
            return None;
        }
        let first = self.states + self.slopes.len();
        let output = |index: usize| self.tape.output(first + index, &registers);
        let probes = 0..self.probes.len();
        Some(probes.map(|i| [output(2 * i), output(2 * i + 1)]).collect())
    }
}

/// The slopes of an expression in the states, those that are not zero.
pub(super) fn gradient(graph: &mut Graph, e: ExprId, layout: Layout) -> Vec<(usize, ExprId)> {
    let zero = graph.integer(0);
    let all = (0..layout.states).map(|l| (l, graph.derivative(e, Var::State(l))));
    all.filter(|(_, slope)| *slope != zero).collect()
}
