//! Tapes: straight-line instructions compiled from expressions.
//!
//! A [`Tape`] is immutable and shared between threads; the registers it works on belong to the
//! caller. One tape evaluates ranges ([`Tape::eval`]) and can push a condition on a result back to
//! the quantities it depends on ([`Tape::contract`]).
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: `compile` gives every operand a register below `register_count`, operands \
              before users; callers pass registers made by `registers()` of the same tape"
)]

use crate::graph::{Binary, ExprId, Graph, Node, Unary, Var};
use std::collections::HashMap;
use veribound_interval::{Interval, rational_to_interval};

/// How regular an expression is on a whole box; later is better.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Regularity {
    /// Not defined somewhere on the box: a division by zero, the root of a negative number.
    Undefined,
    /// Defined, but may jump.
    Jump,
    /// Continuous, but may have a kink.
    Kink,
    /// Infinitely often differentiable.
    Smooth,
}

/// Numbers of states, parameters and inputs: where each quantity stands in a flat list of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    /// Number of states.
    pub states: usize,
    /// Number of parameters.
    pub params: usize,
    /// Number of inputs.
    pub inputs: usize,
}

impl Layout {
    /// States first, then parameters, then inputs.
    pub fn index(self, var: Var) -> usize {
        match var {
            Var::State(i) => i,
            Var::Param(i) => self.states + i,
            Var::Input(i) => self.states + self.params + i,
        }
    }

    /// Number of quantities.
    pub fn len(self) -> usize {
        self.states + self.params + self.inputs
    }

    /// True when there is no quantity at all.
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }
}

#[derive(Debug, Clone, Copy)]
pub(crate) enum Op {
    Unary(Unary),
    Binary(Binary),
    /// `a^n`; only in range tapes.
    Power(i32),
    /// `a^2`
    Square,
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Instruction {
    pub(crate) op: Op,
    pub(crate) a: u32,
    pub(crate) b: u32,
    pub(crate) out: u32,
    /// Register of the companion series (the cosine of a sine, say); only in series tapes.
    pub(crate) companion: u32,
    /// Depends on a state, hence changes in time.
    pub(crate) moving: bool,
    /// The same for each operand.
    pub(crate) moving_operands: (bool, bool),
}

/// Instructions that evaluate some expressions on intervals.
#[derive(Debug, Clone)]
pub struct Tape {
    pub(crate) quantities: Vec<(u32, u32)>,
    pub(crate) constants: Vec<(u32, Interval)>,
    pub(crate) instructions: Vec<Instruction>,
    pub(crate) outputs: Vec<u32>,
    pub(crate) register_count: usize,
}

/// Register of an instruction without a second operand or a companion.
pub(crate) const NO_REGISTER: u32 = u32::MAX;

pub(crate) struct Compiler<'a> {
    graph: &'a Graph,
    layout: Layout,
    /// Series tapes have powers as products and companions for transcendental functions.
    series: bool,
    tape: Tape,
    register_of: HashMap<ExprId, u32>,
    moving: Vec<bool>,
}

impl Compiler<'_> {
    fn register(&mut self, moving: bool) -> u32 {
        let register = self.tape.register_count as u32;
        self.tape.register_count += 1;
        self.moving.push(moving);
        register
    }

    fn emit(&mut self, op: Op, a: u32, b: u32) -> u32 {
        let moving_operands = (
            self.moving[a as usize],
            b != NO_REGISTER && self.moving[b as usize],
        );
        let moving = moving_operands.0 || moving_operands.1;
        let out = self.register(moving);
        let needs_companion = matches!(
            op,
            Op::Unary(Unary::Sin | Unary::Cos | Unary::Tan | Unary::Atan | Unary::Tanh)
        );
        let companion = if self.series && needs_companion {
            self.register(moving)
        } else {
            NO_REGISTER
        };
        self.tape.instructions.push(Instruction {
            op,
            a,
            b,
            out,
            companion,
            moving,
            moving_operands,
        });
        out
    }

    fn constant(&mut self, value: Interval) -> u32 {
        let register = self.register(false);
        self.tape.constants.push((register, value));
        register
    }

    fn power(&mut self, a: u32, n: i32) -> u32 {
        if n == 2 {
            return self.emit(Op::Square, a, NO_REGISTER);
        }
        if !self.series {
            return self.emit(Op::Power(n), a, NO_REGISTER);
        }
        if n < 0 {
            let one = self.constant(Interval::ONE);
            let power = self.power(a, n.saturating_neg());
            return self.emit(Op::Binary(Binary::Div), one, power);
        }
        if n == 1 {
            return a;
        }
        let half = self.power(a, n / 2);
        let square = self.emit(Op::Square, half, NO_REGISTER);
        if n % 2 == 0 {
            square
        } else {
            self.emit(Op::Binary(Binary::Mul), square, a)
        }
    }

    fn lower(&mut self, e: ExprId) {
        let register = match *self.graph.node(e) {
            Node::Constant(ref exact) => self.constant(rational_to_interval(exact)),
            Node::Pi => self.constant(Interval::PI),
            Node::Var(var) => {
                let register = self.register(matches!(var, Var::State(_)));
                self.tape
                    .quantities
                    .push((register, self.layout.index(var) as u32));
                register
            }
            Node::Unary(function, a) => {
                let a = self.register_of[&a];
                self.emit(Op::Unary(function), a, NO_REGISTER)
            }
            Node::Binary(function, a, b) => {
                let (a, b) = (self.register_of[&a], self.register_of[&b]);
                self.emit(Op::Binary(function), a, b)
            }
            Node::Power(a, n) => {
                let a = self.register_of[&a];
                self.power(a, n)
            }
        };
        self.register_of.insert(e, register);
    }

    pub(crate) fn compile(graph: &Graph, layout: Layout, roots: &[ExprId], series: bool) -> Tape {
        let tape = Tape {
            quantities: Vec::new(),
            constants: Vec::new(),
            instructions: Vec::new(),
            outputs: Vec::new(),
            register_count: 0,
        };
        let mut compiler = Compiler {
            graph,
            layout,
            series,
            tape,
            register_of: HashMap::new(),
            moving: Vec::new(),
        };
        for e in graph.reachable(roots) {
            compiler.lower(e);
        }
        let outputs = roots
            .iter()
            .map(|root| compiler.register_of[root])
            .collect();
        compiler.tape.outputs = outputs;
        compiler.tape
    }
}

impl Tape {
    /// A tape whose outputs are `roots`, in order.
    pub fn compile(graph: &Graph, layout: Layout, roots: &[ExprId]) -> Tape {
        Compiler::compile(graph, layout, roots, false)
    }

    /// Registers for this tape, with its constants in place.
    pub fn registers(&self) -> Vec<Interval> {
        let mut registers = vec![Interval::ZERO; self.register_count];
        for &(register, value) in &self.constants {
            registers[register as usize] = value;
        }
        registers
    }

    /// Number of instructions.
    pub fn len(&self) -> usize {
        self.instructions.len()
    }

    /// True when every output is a quantity or a constant.
    pub fn is_empty(&self) -> bool {
        self.instructions.is_empty()
    }

    /// Encloses every output for all `quantities` (in the order of the [`Layout`]), and says how
    /// regular the outputs are on that box.
    ///
    /// Guarantee: for every point of the box at which an output is defined, its value lies in the
    /// result read by [`Tape::output`].
    pub fn eval(&self, quantities: &[Interval], registers: &mut [Interval]) -> Regularity {
        for &(register, quantity) in &self.quantities {
            registers[register as usize] = quantities[quantity as usize];
        }
        let mut regularity = Regularity::Smooth;
        for step in &self.instructions {
            let a = registers[step.a as usize];
            let value = match step.op {
                Op::Unary(function) => {
                    regularity = regularity.min(unary_regularity(function, a));
                    function.apply(a)
                }
                Op::Binary(function) => {
                    let b = registers[step.b as usize];
                    regularity = regularity.min(binary_regularity(function, a, b));
                    function.apply(a, b)
                }
                Op::Square => a.sqr(),
                Op::Power(n) => {
                    if n < 0 && a.contains(0.0) {
                        regularity = Regularity::Undefined;
                    }
                    a.powi(n)
                }
            };
            registers[step.out as usize] = value;
        }
        regularity
    }

    /// Value of output `index` after [`Tape::eval`].
    pub fn output(&self, index: usize, registers: &[Interval]) -> Interval {
        registers[self.outputs[index] as usize]
    }

    /// Removes from `quantities` values for which output 0 cannot lie in `target`.
    ///
    /// Guarantee: every point of the box at which the output is defined and lies in `target` is
    /// kept. Returns false when no such point exists; `quantities` is then meaningless.
    /// Source: forward-backward propagation (HC4), Benhamou et al. 1999.
    pub fn contract(
        &self,
        quantities: &mut [Interval],
        target: Interval,
        registers: &mut [Interval],
    ) -> bool {
        self.eval(quantities, registers);
        let possible = self.propagate_back(target, registers);
        if possible {
            for &(register, quantity) in &self.quantities {
                quantities[quantity as usize] = registers[register as usize];
            }
        }
        // The way back narrows constants too; the next evaluation needs them whole.
        for &(register, value) in &self.constants {
            registers[register as usize] = value;
        }
        possible
    }

    fn propagate_back(&self, target: Interval, registers: &mut [Interval]) -> bool {
        let root = self.outputs[0] as usize;
        registers[root] = registers[root].intersect(target);
        if registers[root].is_empty() {
            return false;
        }
        for step in self.instructions.iter().rev() {
            let out = registers[step.out as usize];
            let a = registers[step.a as usize];
            let a = match step.op {
                Op::Binary(function) => {
                    let b = registers[step.b as usize];
                    let (a, b) = binary_reverse(function, out, a, b);
                    // Both operands in one register: both conditions hold.
                    let b = if step.a == step.b { a.intersect(b) } else { b };
                    if b.is_empty() {
                        return false;
                    }
                    registers[step.b as usize] = b;
                    if step.a == step.b { b } else { a }
                }
                Op::Unary(function) => unary_reverse(function, out, a),
                Op::Square => Interval::sqr_rev(out, a),
                Op::Power(n) => Interval::powi_rev(n, out, a),
            };
            if a.is_empty() {
                return false;
            }
            registers[step.a as usize] = a;
        }
        true
    }
}

fn unary_regularity(function: Unary, a: Interval) -> Regularity {
    let ok = |defined: bool| {
        if defined {
            Regularity::Smooth
        } else {
            Regularity::Undefined
        }
    };
    match function {
        Unary::Neg | Unary::Exp | Unary::Sin | Unary::Cos | Unary::Atan | Unary::Tanh => ok(true),
        Unary::Sqrt if a.lo() == 0.0 => Regularity::Kink,
        Unary::Sqrt | Unary::Ln => ok(a.lo() > 0.0),
        Unary::Tan => ok(a.tan().is_bounded()),
        Unary::Abs if a.lo() < 0.0 && a.hi() > 0.0 => Regularity::Kink,
        Unary::Sign if a.lo() <= 0.0 && a.hi() >= 0.0 => Regularity::Jump,
        Unary::Abs | Unary::Sign => ok(true),
    }
}

fn binary_regularity(function: Binary, a: Interval, b: Interval) -> Regularity {
    match function {
        Binary::Div if b.contains(0.0) => Regularity::Undefined,
        Binary::Min | Binary::Max if a.lo() < b.hi() && b.lo() < a.hi() => Regularity::Kink,
        _ => Regularity::Smooth,
    }
}

fn unary_reverse(function: Unary, out: Interval, a: Interval) -> Interval {
    match function {
        Unary::Neg => a.intersect(-out),
        Unary::Sqrt => Interval::sqrt_rev(out, a),
        Unary::Exp => Interval::exp_rev(out, a),
        Unary::Ln => Interval::ln_rev(out, a),
        Unary::Sin => Interval::sin_rev(out, a),
        Unary::Cos => Interval::cos_rev(out, a),
        Unary::Tan => Interval::tan_rev(out, a),
        Unary::Atan => Interval::atan_rev(out, a),
        Unary::Tanh => Interval::tanh_rev(out, a),
        Unary::Abs => Interval::abs_rev(out, a),
        Unary::Sign => Interval::sign_rev(out, a),
    }
}

fn binary_reverse(
    function: Binary,
    out: Interval,
    a: Interval,
    b: Interval,
) -> (Interval, Interval) {
    match function {
        Binary::Add => (a.intersect(out - b), b.intersect(out - a)),
        Binary::Sub => (a.intersect(out + b), b.intersect(a - out)),
        Binary::Mul => (Interval::mul_rev(b, out, a), Interval::mul_rev(a, out, b)),
        // out = a / b means a = out * b; b then solves out * b = a.
        Binary::Div => (a.intersect(out * b), Interval::mul_rev(out, a, b)),
        Binary::Min => (Interval::min_rev(b, out, a), Interval::min_rev(a, out, b)),
        Binary::Max => (Interval::max_rev(b, out, a), Interval::max_rev(a, out, b)),
    }
}
