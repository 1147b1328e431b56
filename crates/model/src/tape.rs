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

mod compile;
mod contract;
mod evaluate;
mod scopes;

pub(crate) use compile::Compiler;
pub(crate) use evaluate::{choose, decided};

use crate::graph::{Binary, ExprId, Graph, Unary, Var};
use crate::regular::Regular;
use contract::PropagateBack;
use evaluate::Evaluate;
use veribound_interval::Interval;
use veribound_interval::lanes::{Lanewise, Value};

/// Numbers of states, parameters and inputs: where each quantity stands in a flat list of them.
///
/// Example: [`Tape`].
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

    /// The quantity at a position of the flat list.
    pub fn var(self, index: usize) -> Var {
        let after = |count: usize| index.checked_sub(count);
        match (after(self.states), after(self.states + self.params)) {
            (None, _) => Var::State(index),
            (Some(param), None) => Var::Param(param),
            (_, Some(input)) => Var::Input(input),
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
    /// [`crate::Choice`] with the test `a` and the yes `b`.
    Choose(u32),
}

/// What a [`Op::Choose`] has beside its test and its yes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Branches {
    /// Register of the no, and the quantity in it, where it is one.
    pub(crate) no: (u32, u32),
    /// The scopes of the yes and of the no.
    pub(crate) scopes: (u32, u32),
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Instruction {
    pub(crate) op: Op,
    pub(crate) a: u32,
    pub(crate) b: u32,
    pub(crate) out: u32,
    /// The operands among the quantities, where they are some.
    from: (u32, u32),
    /// Register of the companion series (the cosine of a sine, say); only in series tapes.
    pub(crate) companion: u32,
    /// Depends on a state, hence changes in time.
    pub(crate) moving: bool,
    /// The branch of a choice outside of which the result is not used; 0 where there is no such branch.
    pub(crate) scope: u32,
    /// The same as `moving` for each operand.
    pub(crate) moving_operands: (bool, bool),
}

/// Instructions that evaluate some expressions on intervals.
///
/// ```
/// use veribound_interval::Interval;
/// use veribound_model::{Graph, Layout, Regular, Tape, Var};
///
/// let layout = Layout { states: 1, params: 1, inputs: 0 };
/// let mut graph = Graph::default();
/// let (x, k) = (graph.var(Var::State(0)), graph.var(Var::Param(0)));
/// let product = graph.mul(k, x);
/// let tape = Tape::compile(&graph, layout, &[product]);
/// let mut registers = tape.registers();
/// let mut quantities = [Interval::new(1.0, 2.0).unwrap(), Interval::new(-3.0, 3.0).unwrap()];
/// let regular: Regular = tape.eval(&quantities, &mut registers);
/// assert!(regular.is_smooth());
/// assert_eq!(tape.output(0, &registers), Interval::new(-6.0, 6.0).unwrap());
/// // What the quantities must be for a product of 4.
/// tape.contract(&mut quantities, Interval::point(4.0), &mut registers);
/// assert_eq!(quantities[layout.index(Var::Param(0))], Interval::new(2.0, 3.0).unwrap());
/// ```
#[derive(Debug, Clone)]
pub struct Tape {
    pub(crate) quantities: Vec<(u32, u32)>,
    pub(crate) constants: Vec<(u32, Interval)>,
    pub(crate) instructions: Vec<Instruction>,
    /// Of every choice.
    pub(crate) branches: Vec<Branches>,
    pub(crate) outputs: Vec<u32>,
    /// Outputs that are quantities, as in `quantities`.
    passed: Vec<(u32, u32)>,
    pub(crate) register_count: usize,
}

/// Register of an instruction without a second operand or a companion.
pub(crate) const NO_REGISTER: u32 = u32::MAX;

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
        for &(register, quantity) in &self.passed {
            registers[register as usize] = quantities[quantity as usize];
        }
        // Many a right-hand side is a state; there is nothing to choose a path for.
        if self.instructions.is_empty() {
            return Regular::smooth();
        }
        V::run(Evaluate {
            tape: self,
            quantities,
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
        for &(register, quantity) in &self.quantities {
            registers[register as usize] = quantities[quantity as usize];
        }
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
