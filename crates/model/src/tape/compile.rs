//! From expressions to instructions.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: `reachable` lists operands before what uses them, so each has a register"
)]

use super::{Branches, Instruction, Layout, NO_REGISTER, Op, Tape};
use crate::graph::{Binary, Choice, ExprId, Graph, Node, Unary, Var};
use std::collections::HashMap;
use veribound_interval::{Interval, rational_to_interval};

pub(crate) struct Compiler<'a> {
    graph: &'a Graph,
    layout: Layout,
    /// Series tapes have powers also as products, and companions for transcendental functions.
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
        let squares = match op {
            Op::Binary(Binary::Atan2) if self.series => self.squares(a, b),
            _ => NO_REGISTER,
        };
        let moving_operands = (
            self.moving[a as usize],
            b != NO_REGISTER && self.moving[b as usize],
        );
        let mut moving = moving_operands.0 || moving_operands.1;
        if let Op::Choose(number) = op {
            moving |= self.moving[self.tape.branches[number as usize].no.0 as usize];
        }
        let out = self.register(moving);
        let needs_companion = matches!(
            op,
            Op::Unary(
                Unary::Sin
                    | Unary::Cos
                    | Unary::Sinh
                    | Unary::Cosh
                    | Unary::Tan
                    | Unary::Atan
                    | Unary::Tanh
            )
        );
        let companion = if self.series && needs_companion {
            self.register(moving)
        } else {
            squares
        };
        self.tape.instructions.push(Instruction {
            op,
            a,
            b,
            out,
            from: (self.quantity_in(a), self.quantity_in(b)),
            companion,
            moving,
            scope: 0,
            moving_operands,
        });
        out
    }

    /// The sum of squares by which the derivative of an angle is divided.
    fn squares(&mut self, a: u32, b: u32) -> u32 {
        let [a, b] = [a, b].map(|side| self.emit(Op::Square, side, NO_REGISTER));
        self.emit(Op::Binary(Binary::Add), a, b)
    }

    /// The quantity that a register holds, if it does.
    fn quantity_in(&self, register: u32) -> u32 {
        let mut quantities = self.tape.quantities.iter();
        let found = quantities.find(|(known, _)| *known == register);
        found.map_or(NO_REGISTER, |(_, quantity)| *quantity)
    }

    fn constant(&mut self, value: Interval) -> u32 {
        let register = self.register(false);
        self.tape.constants.push((register, value));
        register
    }

    fn power(&mut self, a: u32, n: i32) -> u32 {
        match n {
            1 => a,
            2 => self.emit(Op::Square, a, NO_REGISTER),
            _ if self.series => {
                let product = self.product(a, n);
                self.emit(Op::Power(n), a, product)
            }
            _ => self.emit(Op::Power(n), a, NO_REGISTER),
        }
    }

    /// `a^n` by multiplications and squares.
    fn product(&mut self, a: u32, n: i32) -> u32 {
        match n {
            ..=-1 => {
                let one = self.constant(Interval::ONE);
                let product = self.product(a, n.saturating_neg());
                self.emit(Op::Binary(Binary::Div), one, product)
            }
            0 => self.constant(Interval::ONE),
            1 => a,
            _ => {
                let half = self.product(a, n / 2);
                let square = self.emit(Op::Square, half, NO_REGISTER);
                if n % 2 == 0 {
                    square
                } else {
                    self.emit(Op::Binary(Binary::Mul), square, a)
                }
            }
        }
    }

    /// The derivative of a function at `a`, for those whose series is the integral of that times the
    /// velocity of `a`.
    fn slope(&mut self, function: Unary, a: u32) -> u32 {
        if !matches!(
            function,
            Unary::Asin | Unary::Acos | Unary::Asinh | Unary::Acosh | Unary::Atanh
        ) {
            return NO_REGISTER;
        }
        let one = self.constant(Interval::ONE);
        let square = self.emit(Op::Square, a, NO_REGISTER);
        let below = match function {
            Unary::Asinh => self.emit(Op::Binary(Binary::Add), one, square),
            Unary::Acosh => self.emit(Op::Binary(Binary::Sub), square, one),
            _ => self.emit(Op::Binary(Binary::Sub), one, square),
        };
        let below = match function {
            Unary::Atanh => below,
            _ => self.emit(Op::Unary(Unary::Sqrt), below, NO_REGISTER),
        };
        let slope = self.emit(Op::Binary(Binary::Div), one, below);
        match function {
            Unary::Acos => self.emit(Op::Unary(Unary::Neg), slope, NO_REGISTER),
            _ => slope,
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
                let slope = if self.series {
                    self.slope(function, a)
                } else {
                    NO_REGISTER
                };
                self.emit(Op::Unary(function), a, slope)
            }
            Node::Binary(function, a, b) => {
                let (a, b) = (self.register_of[&a], self.register_of[&b]);
                self.emit(Op::Binary(function), a, b)
            }
            Node::Power(a, n) => {
                let a = self.register_of[&a];
                self.power(a, n)
            }
            Node::Choose(Choice { test, yes, no }) => {
                let (test, yes, no) = (
                    self.register_of[&test],
                    self.register_of[&yes],
                    self.register_of[&no],
                );
                let number = self.tape.branches.len() as u32;
                self.tape.branches.push(Branches {
                    no: (no, self.quantity_in(no)),
                    scopes: (2 * number + 1, 2 * number + 2),
                });
                self.emit(Op::Choose(number), test, yes)
            }
        };
        self.register_of.insert(e, register);
    }

    pub(crate) fn compile(graph: &Graph, layout: Layout, roots: &[ExprId], series: bool) -> Tape {
        let tape = Tape {
            quantities: Vec::new(),
            constants: Vec::new(),
            instructions: Vec::new(),
            branches: Vec::new(),
            outputs: Vec::new(),
            passed: Vec::new(),
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
        let outputs = roots.iter().map(|root| compiler.register_of[root]);
        let outputs: Vec<u32> = outputs.collect();
        let mut tape = compiler.tape;
        let passed = tape.quantities.iter().copied();
        tape.passed = passed
            .filter(|(register, _)| outputs.contains(register))
            .collect();
        tape.outputs = outputs;
        tape.set_scopes();
        tape
    }
}
