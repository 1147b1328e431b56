//! Expressions as instructions of the few kinds that Taylor models need.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: registers are positions of instructions made before; slopes are set before use"
)]

use std::collections::HashMap;

use veribound_interval::{Interval, rational_to_interval};
use veribound_model::{Binary, ExprId, Graph, Node, Unary, Var};

/// What an instruction computes; operands are positions of earlier instructions.
#[derive(Debug, Clone, Copy)]
pub(super) enum Op {
    Constant(Interval),
    State(usize),
    Param(usize),
    Input(usize),
    Add(usize, usize),
    Sub(usize, usize),
    Neg(usize),
    Mul(usize, usize),
    Square(usize),
    /// `1 / a`
    Recip(usize),
    /// A smooth function of one argument; `slope` holds its derivative there, maybe a later register.
    Call {
        function: Unary,
        operand: usize,
        slope: usize,
    },
    Abs(usize),
    Sign(usize),
    /// The slope of a sign: zero where it is decided.
    Impulse(usize),
}

/// One instruction and what is known of its result.
#[derive(Debug, Clone, Copy)]
pub(super) struct Instruction {
    pub(super) op: Op,
    /// Depends on a state that moves, hence changes in time.
    pub(super) moving: bool,
    /// Depends on a state or a parameter, hence differs over the set.
    pub(super) uncertain: bool,
    /// Needed for the first group of roots; the others may be computed less exactly.
    pub(super) primary: bool,
}

/// Instructions for several expressions.
#[derive(Debug, Clone)]
pub(super) struct Code {
    pub(super) instructions: Vec<Instruction>,
    /// Registers of the roots, the primary ones first.
    pub(super) roots: Vec<usize>,
    /// Registers of the states.
    pub(super) states: Vec<usize>,
}

impl Code {
    /// Instructions for `primary` and `secondary`, and for every state, of which some stand `still`.
    pub(super) fn compile(
        graph: &mut Graph,
        still: &[bool],
        primary: &[ExprId],
        secondary: &[ExprId],
    ) -> Code {
        let mut roots: Vec<ExprId> = primary.iter().chain(secondary).copied().collect();
        let states = 0..still.len();
        let variables: Vec<ExprId> = states.map(|i| graph.var(Var::State(i))).collect();
        let mut all = [&roots[..], &variables[..]].concat();
        // Slopes of functions bring other functions; the family of each function is small and closed.
        let mut slopes: HashMap<ExprId, ExprId> = HashMap::new();
        loop {
            let mut grown = false;
            for e in graph.reachable(&all) {
                if let Node::Unary(function, a) = *graph.node(e)
                    && is_call(function)
                    && !slopes.contains_key(&e)
                {
                    let slope = slope_at(graph, function, a);
                    slopes.insert(e, slope);
                    all.push(slope);
                    grown = true;
                }
            }
            if !grown {
                break;
            }
        }
        // States are moved with all orders, also those that no rate depends on.
        let mut first = [primary, &variables[..]].concat();
        loop {
            let reached = graph.reachable(&first);
            let count = first.len();
            let more: Vec<ExprId> = reached
                .iter()
                .filter_map(|e| slopes.get(e).copied())
                .filter(|slope| !reached.contains(slope))
                .collect();
            first.extend(more);
            if first.len() == count {
                break;
            }
        }
        let mut is_primary = vec![false; graph.len()];
        for e in graph.reachable(&first) {
            is_primary[e.index()] = true;
        }
        let mut builder = Builder {
            still,
            instructions: Vec::new(),
            primary: false,
        };
        let mut register_of: HashMap<ExprId, usize> = HashMap::new();
        for e in graph.reachable(&all) {
            builder.primary = is_primary[e.index()];
            let register = builder.lower(graph, e, &register_of);
            register_of.insert(e, register);
        }
        for (e, slope) in &slopes {
            let target = register_of[slope];
            if let Op::Call { slope, .. } = &mut builder.instructions[register_of[e]].op {
                *slope = target;
            }
        }
        Code {
            roots: roots.drain(..).map(|e| register_of[&e]).collect(),
            states: variables.iter().map(|e| register_of[e]).collect(),
            instructions: builder.instructions,
        }
    }
}

/// Functions that are computed by their slope.
fn is_call(function: Unary) -> bool {
    !matches!(
        function,
        Unary::Neg | Unary::Abs | Unary::Sign | Unary::Impulse
    )
}

/// The derivative of `function` at `a`, where it is smooth.
fn slope_at(graph: &mut Graph, function: Unary, a: ExprId) -> ExprId {
    if matches!(function, Unary::Floor | Unary::FloorSlope) {
        return graph.integer(0);
    }
    let variable = Var::State(0);
    let x = graph.var(variable);
    let value = graph.unary(function, x);
    let slope = graph.derivative(value, variable);
    graph.substitute(slope, &|_| Some(a))
}

struct Builder<'a> {
    still: &'a [bool],
    instructions: Vec<Instruction>,
    primary: bool,
}

impl Builder<'_> {
    fn emit(&mut self, op: Op) -> usize {
        let of = |a: usize| (self.instructions[a].moving, self.instructions[a].uncertain);
        let (moving, uncertain) = match op {
            Op::Constant(_) | Op::Input(_) => (false, false),
            Op::State(i) => (!self.still[i], true),
            Op::Param(_) => (false, true),
            Op::Add(a, b) | Op::Sub(a, b) | Op::Mul(a, b) => {
                (of(a).0 || of(b).0, of(a).1 || of(b).1)
            }
            // Decided on the whole set, or not at all.
            Op::Sign(_) | Op::Impulse(_) => (false, false),
            Op::Neg(a)
            | Op::Square(a)
            | Op::Recip(a)
            | Op::Abs(a)
            | Op::Call { operand: a, .. } => of(a),
        };
        self.instructions.push(Instruction {
            op,
            moving,
            uncertain,
            primary: self.primary,
        });
        self.instructions.len() - 1
    }

    fn constant(&self, a: usize) -> Option<Interval> {
        match self.instructions[a].op {
            Op::Constant(value) => Some(value),
            _ => None,
        }
    }

    fn recip(&mut self, a: usize) -> usize {
        match self.constant(a) {
            Some(value) if !value.contains(0.0) => self.emit(Op::Constant(Interval::ONE / value)),
            _ => self.emit(Op::Recip(a)),
        }
    }

    fn lower(&mut self, graph: &Graph, e: ExprId, register_of: &HashMap<ExprId, usize>) -> usize {
        match *graph.node(e) {
            Node::Constant(ref exact) => self.emit(Op::Constant(rational_to_interval(exact))),
            Node::Pi => self.emit(Op::Constant(Interval::PI)),
            Node::Var(Var::State(i)) => self.emit(Op::State(i)),
            Node::Var(Var::Param(i)) => self.emit(Op::Param(i)),
            Node::Var(Var::Input(i)) => self.emit(Op::Input(i)),
            Node::Power(a, n) => {
                let power = self.power(register_of[&a], n.unsigned_abs());
                if n < 0 { self.recip(power) } else { power }
            }
            Node::Unary(function, a) => {
                let operand = register_of[&a];
                self.emit(match function {
                    Unary::Neg => Op::Neg(operand),
                    Unary::Abs => Op::Abs(operand),
                    Unary::Sign => Op::Sign(operand),
                    Unary::Impulse => Op::Impulse(operand),
                    _ => Op::Call {
                        function,
                        operand,
                        slope: operand,
                    },
                })
            }
            // What may be one of two has no polynomial; without a value, it makes no claim.
            Node::Choose(_) => {
                let zero = self.emit(Op::Constant(Interval::ZERO));
                self.emit(Op::Recip(zero))
            }
            Node::Binary(function, a, b) => {
                let (a, b) = (register_of[&a], register_of[&b]);
                match function {
                    Binary::Add => self.emit(Op::Add(a, b)),
                    Binary::Sub => self.emit(Op::Sub(a, b)),
                    Binary::Mul => self.emit(Op::Mul(a, b)),
                    Binary::Div => {
                        let one = self.constant(a) == Some(Interval::ONE);
                        let below = self.recip(b);
                        if one {
                            below
                        } else {
                            self.emit(Op::Mul(a, below))
                        }
                    }
                    // (a + b ± |a - b|) / 2
                    Binary::Min | Binary::Max => {
                        let gap = self.emit(Op::Sub(a, b));
                        let size = self.emit(Op::Abs(gap));
                        let sum = self.emit(Op::Add(a, b));
                        let twice = self.emit(if function == Binary::Max {
                            Op::Add(sum, size)
                        } else {
                            Op::Sub(sum, size)
                        });
                        let half = self.emit(Op::Constant(Interval::point(0.5)));
                        self.emit(Op::Mul(half, twice))
                    }
                    // Expressions are elementary; without a value, what is not would be no claim.
                    Binary::Pow | Binary::Atan2 | Binary::Atan2Cut => {
                        let zero = self.emit(Op::Constant(Interval::ZERO));
                        self.emit(Op::Recip(zero))
                    }
                }
            }
        }
    }

    fn power(&mut self, a: usize, n: u32) -> usize {
        match n {
            0 => self.emit(Op::Constant(Interval::ONE)),
            1 => a,
            _ => {
                let half = self.power(a, n / 2);
                let square = self.emit(Op::Square(half));
                if n.is_multiple_of(2) {
                    square
                } else {
                    self.emit(Op::Mul(square, a))
                }
            }
        }
    }
}
