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
use crate::regular::Regular;
use std::collections::HashMap;
use veribound_interval::lanes::{Arithmetic, Kernel, Lanewise, MaskOf, Value};
use veribound_interval::{Interval, Regularity, domain, rational_to_interval};

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
    /// `a^n`; in series tapes `b` holds the same as a product, for the coefficients after the first.
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
        let moving_operands = (
            self.moving[a as usize],
            b != NO_REGISTER && self.moving[b as usize],
        );
        let moving = moving_operands.0 || moving_operands.1;
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
    pub fn registers<V: Value>(&self) -> Vec<V> {
        let mut registers = vec![V::splat(Interval::ZERO); self.register_count];
        for &(register, value) in &self.constants {
            registers[register as usize] = V::splat(value);
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
    /// regular the outputs are on that box; on one box, or on eight side by side.
    ///
    /// Guarantee: for every point of the box at which an output is defined, its value lies in the
    /// result read by [`Tape::output`].
    pub fn eval<V: Value>(&self, quantities: &[V], registers: &mut [V]) -> Regular<V::Mask> {
        for &(register, quantity) in &self.quantities {
            registers[register as usize] = quantities[quantity as usize];
        }
        // Many a right-hand side is a state; there is nothing to choose a path for.
        if self.instructions.is_empty() {
            return Regular::smooth();
        }
        V::run(Evaluate {
            tape: self,
            registers,
        })
    }

    /// Value of output `index` after [`Tape::eval`].
    pub fn output<V: Value>(&self, index: usize, registers: &[V]) -> V {
        registers[self.outputs[index] as usize]
    }

    /// Removes from `quantities` values for which output 0 cannot lie in `target`.
    ///
    /// Guarantee: every point of the box at which the output is defined and lies in `target` is
    /// kept. Where the result is false no such point exists; `quantities` is then meaningless.
    /// Source: forward-backward propagation (HC4), Benhamou et al. 1999.
    pub fn contract<V: Value>(
        &self,
        quantities: &mut [V],
        target: Interval,
        registers: &mut [V],
    ) -> V::Mask {
        self.eval(quantities, registers);
        let possible = V::run(PropagateBack {
            tape: self,
            target,
            registers,
        });
        if possible.any() {
            for &(register, quantity) in &self.quantities {
                quantities[quantity as usize] = registers[register as usize];
            }
        }
        // The way back narrows constants too; the next evaluation needs them whole.
        for &(register, value) in &self.constants {
            registers[register as usize] = V::splat(value);
        }
        possible
    }
}

struct Evaluate<'a, V> {
    tape: &'a Tape,
    registers: &'a mut [V],
}

impl<V: Value> Kernel<V> for Evaluate<'_, V> {
    type Output = Regular<V::Mask>;

    #[inline(always)]
    fn run<A: Arithmetic<Value = V>>(self) -> Regular<V::Mask> {
        let registers = self.registers;
        let mut regular = Regular::smooth();
        for step in &self.tape.instructions {
            let a = &registers[step.a as usize];
            let value = match step.op {
                Op::Unary(function) => {
                    regular = regular.and(unary_regularity::<A>(function, a));
                    function.apply::<A>(a)
                }
                Op::Binary(function) => {
                    let b = &registers[step.b as usize];
                    regular = regular.and(binary_regularity::<A>(function, a, b));
                    function.apply::<A>(a, b)
                }
                Op::Square => A::sqr(a),
                Op::Power(n) => {
                    if n < 0 {
                        regular = regular.and(Regular::undefined(A::contains_zero(a)));
                    }
                    A::powi(a, n)
                }
            };
            registers[step.out as usize] = value;
        }
        regular
    }
}

struct PropagateBack<'a, V> {
    tape: &'a Tape,
    target: Interval,
    registers: &'a mut [V],
}

impl<V: Value> Kernel<V> for PropagateBack<'_, V> {
    type Output = V::Mask;

    #[inline(always)]
    fn run<A: Arithmetic<Value = V>>(self) -> V::Mask {
        let registers = self.registers;
        let root = self.tape.outputs[0] as usize;
        registers[root] = A::intersect(&registers[root], &V::splat(self.target));
        let mut possible = !A::is_empty(&registers[root]);
        for step in self.tape.instructions.iter().rev() {
            if !possible.any() {
                break;
            }
            let out = registers[step.out as usize];
            let a = registers[step.a as usize];
            let a = match step.op {
                Op::Binary(function) => {
                    let b = registers[step.b as usize];
                    let (a, b) = binary_reverse::<A>(function, &out, &a, &b);
                    // Both operands in one register: both conditions hold.
                    let b = if step.a == step.b {
                        A::intersect(&a, &b)
                    } else {
                        b
                    };
                    possible = possible & !A::is_empty(&b);
                    registers[step.b as usize] = b;
                    if step.a == step.b { b } else { a }
                }
                Op::Unary(function) => unary_reverse::<A>(function, &out, &a),
                Op::Square => A::map2(&out, &a, Interval::sqr_rev),
                Op::Power(n) => A::map2(&out, &a, |out, a| Interval::powi_rev(n, out, a)),
            };
            possible = possible & !A::is_empty(&a);
            registers[step.a as usize] = a;
        }
        possible
    }
}

#[inline(always)]
fn unary_regularity<A: Arithmetic>(function: Unary, a: &A::Value) -> Regular<MaskOf<A>> {
    let of: fn(Interval) -> Regularity = match function {
        Unary::Neg
        | Unary::Exp
        | Unary::Sin
        | Unary::Cos
        | Unary::Atan
        | Unary::Sinh
        | Unary::Cosh
        | Unary::Tanh
        | Unary::Asinh => return Regular::smooth(),
        Unary::Impulse => return Regular::undefined(A::contains_zero(a)),
        Unary::Sqrt | Unary::Ln | Unary::Abs | Unary::Sign if A::is_positive(a).all() => {
            return Regular::smooth();
        }
        Unary::Sqrt => domain::sqrt,
        Unary::Ln => domain::ln,
        Unary::Tan => domain::tan,
        Unary::Asin => domain::asin,
        Unary::Acos => domain::acos,
        Unary::Acosh => domain::acosh,
        Unary::Atanh => domain::atanh,
        Unary::Abs => domain::abs,
        Unary::Sign => domain::sign,
    };
    Regular::by_lane(|wanted| A::test(a, |a| of(a) == wanted))
}

#[inline(always)]
fn binary_regularity<A: Arithmetic>(
    function: Binary,
    a: &A::Value,
    b: &A::Value,
) -> Regular<MaskOf<A>> {
    let of: fn(Interval, Interval) -> Regularity = match function {
        Binary::Add | Binary::Sub | Binary::Mul => return Regular::smooth(),
        Binary::Div => return Regular::undefined(A::contains_zero(b)),
        Binary::Min => domain::min,
        Binary::Max => domain::max,
    };
    Regular::by_lane(|wanted| A::test2(a, b, |a, b| of(a, b) == wanted))
}

#[inline(always)]
fn unary_reverse<A: Arithmetic>(function: Unary, out: &A::Value, a: &A::Value) -> A::Value {
    let reverse: fn(Interval, Interval) -> Interval = match function {
        Unary::Neg => return A::intersect(a, &A::neg(out)),
        Unary::Sqrt => Interval::sqrt_rev,
        Unary::Exp => Interval::exp_rev,
        Unary::Ln => Interval::ln_rev,
        Unary::Sin => Interval::sin_rev,
        Unary::Cos => Interval::cos_rev,
        Unary::Tan => Interval::tan_rev,
        Unary::Atan => Interval::atan_rev,
        Unary::Tanh => Interval::tanh_rev,
        Unary::Asin => Interval::asin_rev,
        Unary::Acos => Interval::acos_rev,
        Unary::Sinh => Interval::sinh_rev,
        Unary::Cosh => Interval::cosh_rev,
        Unary::Asinh => Interval::asinh_rev,
        Unary::Acosh => Interval::acosh_rev,
        Unary::Atanh => Interval::atanh_rev,
        Unary::Abs => Interval::abs_rev,
        Unary::Sign => Interval::sign_rev,
        // Not zero it is at zero alone.
        Unary::Impulse => |out, a| {
            if out.contains(0.0) {
                a
            } else {
                a.intersect(Interval::ZERO)
            }
        },
    };
    A::map2(out, a, reverse)
}

#[inline(always)]
fn binary_reverse<A: Arithmetic>(
    function: Binary,
    out: &A::Value,
    a: &A::Value,
    b: &A::Value,
) -> (A::Value, A::Value) {
    let both = |reverse: fn(Interval, Interval, Interval) -> Interval| {
        (A::map3(b, out, a, reverse), A::map3(a, out, b, reverse))
    };
    match function {
        Binary::Add => (
            A::intersect(a, &A::sub(out, b)),
            A::intersect(b, &A::sub(out, a)),
        ),
        Binary::Sub => (
            A::intersect(a, &A::add(out, b)),
            A::intersect(b, &A::sub(a, out)),
        ),
        Binary::Mul => both(Interval::mul_rev),
        // out = a / b means a = out * b; b then solves out * b = a.
        Binary::Div => (
            A::intersect(a, &A::mul(out, b)),
            A::map3(out, a, b, Interval::mul_rev),
        ),
        Binary::Min => both(Interval::min_rev),
        Binary::Max => both(Interval::max_rev),
    }
}
