//! Taylor coefficients in time of expressions along a trajectory.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: registers as in `tape`; every register owns `stride` coefficients, and the \
              order asked for is below `stride`"
)]

use crate::graph::{Binary, ExprId, Graph, Unary};
use crate::tape::{Compiler, Instruction, Layout, Op, Regularity, Tape};
use veribound_interval::Interval;

/// A tape that evaluates Taylor coefficients in time.
///
/// States are series; parameters and inputs are constants. Source: the classical recurrences of
/// automatic differentiation in Taylor arithmetic (Moore 1966).
#[derive(Debug, Clone)]
pub struct SeriesTape {
    tape: Tape,
}

/// The coefficients of every register of one [`SeriesTape`].
#[derive(Debug, Clone)]
pub struct Coefficients {
    stride: usize,
    values: Vec<Interval>,
}

impl Coefficients {
    #[inline]
    fn at(&self, register: u32, order: usize) -> Interval {
        self.values[register as usize * self.stride + order]
    }

    #[inline]
    fn set(&mut self, register: u32, order: usize, value: Interval) {
        self.values[register as usize * self.stride + order] = value;
    }

    /// `Σ a_j b_(k-j)` for `j` from `from` to `to`, both included.
    fn convolve(&self, a: u32, b: u32, k: usize, from: usize, to: usize) -> Interval {
        let mut sum = Interval::ZERO;
        for j in from..=to {
            sum += self.at(a, j) * self.at(b, k - j);
        }
        sum
    }

    /// `Σ j a_j b_(k-j) / k` for `j` from 1 to `to`: coefficient of `∫ a' b`.
    fn integrate(&self, a: u32, b: u32, k: usize, to: usize) -> Interval {
        let mut sum = Interval::ZERO;
        for j in 1..=to {
            sum += Interval::point(j as f64) * self.at(a, j) * self.at(b, k - j);
        }
        if k == 1 {
            sum
        } else {
            sum / Interval::point(k as f64)
        }
    }
}

impl SeriesTape {
    /// A tape whose outputs are `roots`, in order.
    pub fn compile(graph: &Graph, layout: Layout, roots: &[ExprId]) -> SeriesTape {
        SeriesTape {
            tape: Compiler::compile(graph, layout, roots, true),
        }
    }

    /// Coefficients up to `order` for this tape, with its constants in place.
    pub fn coefficients(&self, order: usize) -> Coefficients {
        let stride = order + 1;
        let values = vec![Interval::ZERO; self.tape.register_count * stride];
        let mut coefficients = Coefficients { stride, values };
        for &(register, value) in &self.tape.constants {
            coefficients.set(register, 0, value);
        }
        coefficients
    }

    /// The quantities the outputs depend on, in the order of the [`Layout`]; pass each one's
    /// coefficients to [`SeriesTape::set_quantity`] by its position here.
    pub fn quantities(&self) -> impl Iterator<Item = usize> + '_ {
        self.tape
            .quantities
            .iter()
            .map(|&(_, quantity)| quantity as usize)
    }

    /// Sets coefficient `order` of the quantity at `position` of [`SeriesTape::quantities`].
    pub fn set_quantity(
        &self,
        position: usize,
        order: usize,
        value: Interval,
        coefficients: &mut Coefficients,
    ) {
        coefficients.set(self.tape.quantities[position].0, order, value);
    }

    /// Coefficient `order` of output `index`, once computed.
    pub fn output(&self, index: usize, order: usize, coefficients: &Coefficients) -> Interval {
        coefficients.at(self.tape.outputs[index], order)
    }

    /// Computes everything that depends on parameters and inputs alone; call it after setting
    /// those, before [`SeriesTape::compute`].
    pub fn compute_constants(&self, coefficients: &mut Coefficients) -> Regularity {
        let mut regularity = Regularity::Smooth;
        for step in self.tape.instructions.iter().filter(|step| !step.moving) {
            regularity = regularity.min(step.compute(0, coefficients));
        }
        regularity
    }

    /// Computes coefficient `k` of everything that moves, from the coefficients up to `k` of the
    /// quantities and below `k` of everything else.
    ///
    /// Guarantee: with coefficient 0 of the quantities enclosing their values and the others
    /// enclosing their true coefficients, the results enclose the true coefficients, provided the
    /// return value is `Smooth` (as it was for the constants); otherwise the results mean nothing.
    pub fn compute(&self, k: usize, coefficients: &mut Coefficients) -> Regularity {
        let mut regularity = Regularity::Smooth;
        for step in self.tape.instructions.iter().filter(|step| step.moving) {
            regularity = regularity.min(step.compute(k, coefficients));
        }
        regularity
    }
}

impl Instruction {
    fn compute(&self, k: usize, c: &mut Coefficients) -> Regularity {
        let (a, b, out) = (self.a, self.b, self.out);
        let value = match self.op {
            Op::Square | Op::Power(_) => square(c, a, k),
            Op::Binary(Binary::Add) => c.at(a, k) + c.at(b, k),
            Op::Binary(Binary::Sub) => c.at(a, k) - c.at(b, k),
            // A constant factor has one coefficient only.
            Op::Binary(Binary::Mul) if !self.moving_operands.0 => c.at(a, 0) * c.at(b, k),
            Op::Binary(Binary::Mul) if !self.moving_operands.1 => c.at(a, k) * c.at(b, 0),
            Op::Binary(Binary::Mul) => c.convolve(a, b, k, 0, k),
            Op::Binary(Binary::Div) if !self.moving_operands.1 => {
                let divisor = c.at(b, 0);
                if divisor.contains(0.0) {
                    return Regularity::Undefined;
                }
                c.at(a, k) / divisor
            }
            Op::Binary(Binary::Div) => {
                let divisor = c.at(b, 0);
                if divisor.contains(0.0) {
                    return Regularity::Undefined;
                }
                let known = if k == 0 {
                    Interval::ZERO
                } else {
                    c.convolve(out, b, k, 0, k - 1)
                };
                (c.at(a, k) - known) / divisor
            }
            // What does not move has no second coefficient to get wrong.
            Op::Binary(function @ (Binary::Min | Binary::Max)) if !self.moving => {
                function.apply(c.at(a, 0), c.at(b, 0))
            }
            Op::Binary(Binary::Min) => match decided_order(c.at(a, 0), c.at(b, 0)) {
                Some(a_smaller) => c.at(if a_smaller { a } else { b }, k),
                None => return Regularity::Kink,
            },
            Op::Binary(Binary::Max) => match decided_order(c.at(a, 0), c.at(b, 0)) {
                Some(a_smaller) => c.at(if a_smaller { b } else { a }, k),
                None => return Regularity::Kink,
            },
            Op::Unary(function) => return self.compute_unary(function, k, c),
        };
        c.set(out, k, value);
        Regularity::Smooth
    }

    fn compute_unary(&self, function: Unary, k: usize, c: &mut Coefficients) -> Regularity {
        let (a, out, companion) = (self.a, self.out, self.companion);
        let start = c.at(a, 0);
        let value = match function {
            Unary::Neg => -c.at(a, k),
            Unary::Abs if !self.moving => start.abs(),
            // Strict: a box and a box inside it must not take different branches.
            Unary::Abs if start.lo() > 0.0 => c.at(a, k),
            Unary::Abs if start.hi() < 0.0 => -c.at(a, k),
            Unary::Abs => return Regularity::Kink,
            Unary::Sign if start.contains(0.0) => return Regularity::Jump,
            Unary::Sign if k == 0 => start.sign(),
            Unary::Sign => Interval::ZERO,
            Unary::Sqrt | Unary::Ln if start.lo() <= 0.0 => return Regularity::Undefined,
            Unary::Tan if !start.tan().is_bounded() => return Regularity::Undefined,
            Unary::Sqrt if k == 0 => start.sqrt(),
            Unary::Sqrt => {
                let known = c.convolve(out, out, k, 1, k - 1);
                (c.at(a, k) - known) / (Interval::point(2.0) * c.at(out, 0))
            }
            Unary::Exp if k == 0 => start.exp(),
            Unary::Exp => c.integrate(a, out, k, k),
            Unary::Ln if k == 0 => start.ln(),
            Unary::Ln => (c.at(a, k) - c.integrate(out, a, k, k - 1)) / start,
            Unary::Sin | Unary::Cos if k == 0 => {
                let (value, other) = if function == Unary::Sin {
                    (start.sin(), start.cos())
                } else {
                    (start.cos(), start.sin())
                };
                c.set(companion, 0, other);
                value
            }
            Unary::Sin => {
                // sin' = cos, cos' = -sin; the companion is the cosine.
                let value = c.integrate(a, companion, k, k);
                let other = -c.integrate(a, out, k, k);
                c.set(companion, k, other);
                value
            }
            Unary::Cos => {
                let value = -c.integrate(a, companion, k, k);
                let other = c.integrate(a, out, k, k);
                c.set(companion, k, other);
                value
            }
            Unary::Tan | Unary::Tanh => {
                // The companion is the outer derivative: 1 + tan², 1 - tanh².
                let value = match (k, function) {
                    (0, Unary::Tan) => start.tan(),
                    (0, _) => start.tanh(),
                    _ => c.integrate(a, companion, k, k),
                };
                c.set(out, k, value);
                let square = square(c, out, k);
                let signed = if function == Unary::Tan {
                    square
                } else {
                    -square
                };
                c.set(
                    companion,
                    k,
                    if k == 0 {
                        Interval::ONE + signed
                    } else {
                        signed
                    },
                );
                value
            }
            Unary::Atan => {
                // atan' = a' / (1 + a²); the companion is the denominator.
                let square = square(c, a, k);
                c.set(
                    companion,
                    k,
                    if k == 0 {
                        Interval::ONE + square
                    } else {
                        square
                    },
                );
                if k == 0 {
                    start.atan()
                } else {
                    (c.at(a, k) - c.integrate(out, companion, k, k - 1)) / c.at(companion, 0)
                }
            }
        };
        c.set(out, k, value);
        Regularity::Smooth
    }
}

/// Coefficient `k` of `a²`; symmetric pairs are taken once so that squares stay tight.
fn square(c: &Coefficients, a: u32, k: usize) -> Interval {
    let mut sum = Interval::ZERO;
    for j in 0..k.div_ceil(2) {
        sum += c.at(a, j) * c.at(a, k - j);
    }
    sum = Interval::point(2.0) * sum;
    if k.is_multiple_of(2) {
        sum + c.at(a, k / 2).sqr()
    } else {
        sum
    }
}

/// Which of the two is smaller; `None` where they touch, since a smaller box could then decide it
/// the other way.
fn decided_order(a: Interval, b: Interval) -> Option<bool> {
    if a.hi() < b.lo() {
        Some(true)
    } else if b.hi() < a.lo() {
        Some(false)
    } else {
        None
    }
}
