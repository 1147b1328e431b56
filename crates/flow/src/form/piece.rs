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
    /// The rates, and what is watched with its rates, to be evaluated on boxes.
    pub(super) tape: Tape,
}

/// What a [`Piece`] is made of.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Shape {
    pub(super) rates: Vec<ExprId>,
    pub(super) watched: Vec<ExprId>,
    /// States that are held at a number.
    pub(super) held: Vec<(usize, ExprId)>,
}

impl Shape {
    /// Expressions with the numbers of the states that are held.
    pub(super) fn held_in(&self, graph: &mut Graph, list: &[ExprId]) -> Vec<ExprId> {
        let held = |var: Var| {
            let own = self.held.iter().find(|held| var == Var::State(held.0));
            own.map(|held| held.1)
        };
        let list = list.iter();
        list.map(|e| graph.substitute(*e, &held)).collect()
    }
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
    /// The right-hand side of `regime` with what it watches; both are elementary.
    ///
    /// States that are held at a number are this number: a form may stand for others, too, but no solution has them.
    /// So what such states alone move does not move, as most of a chain of masses at rest.
    pub(super) fn compile(graph: &mut Graph, layout: Layout, regime: &Shape) -> Piece {
        let rates = &regime.held_in(graph, &regime.rates);
        let watched = &regime.held_in(graph, &regime.watched);
        let mut entries: Vec<(usize, usize, ExprId)> = Vec::new();
        for (i, rate) in rates.iter().enumerate() {
            entries.extend(gradient(graph, *rate).into_iter().map(|(l, e)| (i, l, e)));
        }
        let mut secondary: Vec<ExprId> = entries.iter().map(|entry| entry.2).collect();
        let mut shapes = Vec::with_capacity(watched.len());
        let mut moving = Vec::with_capacity(2 * watched.len());
        for e in watched {
            let slopes = gradient(graph, *e);
            let drift = drift(graph, &slopes, &|state| rates[state]);
            secondary.extend([*e, drift]);
            moving.extend([*e, drift]);
            secondary.extend(slopes.iter().map(|(_, slope)| *slope));
            shapes.push(slopes);
        }
        let zero = graph.integer(0);
        let still: Vec<bool> = rates.iter().map(|rate| *rate == zero).collect();
        let code = Code::compile(graph, &still, rates, &secondary);
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
        let on_boxes: Vec<ExprId> = rates.iter().copied().chain(moving).collect();
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

    /// The rates on a box of states, parameters and inputs, and what is watched there, each with its rate of
    /// change. `None` where they are undefined or jump.
    pub(super) fn on_box(&self, quantities: &[Interval]) -> Option<OnBox> {
        let mut registers = self.tape.registers();
        let regular = self.tape.eval(quantities, &mut registers);
        let output = |index: usize| self.tape.output::<Interval>(index, &registers);
        let n = self.states;
        let watched = |probe: usize| [output(n + 2 * probe), output(n + 2 * probe + 1)];
        regular.is_continuous().then(|| OnBox {
            rates: (0..n).map(output).collect(),
            watched: (0..self.probes.len()).map(watched).collect(),
        })
    }
}

/// A [`Piece`] on a box.
pub(super) struct OnBox {
    pub(super) rates: Vec<Interval>,
    /// Value and rate of change.
    pub(super) watched: Vec<[Interval; 2]>,
}

/// The rate of change of an expression with this gradient where states have these rates.
pub(super) fn drift(
    graph: &mut Graph,
    gradient: &[(usize, ExprId)],
    rate: &dyn Fn(usize) -> ExprId,
) -> ExprId {
    gradient
        .iter()
        .fold(graph.integer(0), |sum, &(state, slope)| {
            let term = graph.mul(slope, rate(state));
            graph.add(sum, term)
        })
}

/// The slopes of an expression in the states, those that are not zero.
pub(super) fn gradient(graph: &mut Graph, e: ExprId) -> Vec<(usize, ExprId)> {
    let zero = graph.integer(0);
    let variables = graph.variables(e).into_iter();
    let states = variables.filter_map(|var| match var {
        Var::State(l) => Some(l),
        _ => None,
    });
    let all = states.map(|l| (l, graph.derivative(e, Var::State(l))));
    all.filter(|(_, slope)| *slope != zero).collect()
}
