//! Ranges of all instructions, in order.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: registers as in `tape`; quantities as in the layout that the tape was compiled for"
)]

use super::{NO_REGISTER, Op, Tape};
use crate::graph::{Binary, Unary, jump};
use crate::regular::Regular;
use veribound_interval::lanes::{Arithmetic, Kernel, Lanewise, MaskOf, Value};
use veribound_interval::{Interval, Regularity, domain};

/// Quantities are read where they are: eight intervals are 128 bytes, and to move them takes as long as to add.
pub(super) struct Evaluate<'a, V> {
    pub(super) tape: &'a Tape,
    pub(super) quantities: &'a [V],
    pub(super) registers: &'a mut [V],
}

impl<V: Value> Kernel<V> for Evaluate<'_, V> {
    type Output = Regular<V::Mask>;

    #[inline(always)]
    fn run<A: Arithmetic<Value = V>>(self) -> Regular<V::Mask> {
        let mut regular = Regular::smooth();
        for step in &self.tape.instructions {
            // Operands come before what uses them.
            let (before, rest) = self.registers.split_at_mut(step.out as usize);
            let out = &mut rest[0];
            let operand = |register: u32, quantity: u32| {
                if quantity == NO_REGISTER {
                    &before[register as usize]
                } else {
                    &self.quantities[quantity as usize]
                }
            };
            let a = operand(step.a, step.from.0);
            let b = match step.op {
                Op::Binary(_) => operand(step.b, step.from.1),
                _ => a,
            };
            regular = regular.and(step.op.evaluate::<A>(a, b, out));
        }
        regular
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
        Unary::Cbrt if A::is_positive(a).all() => return Regular::smooth(),
        Unary::Cbrt => |a| domain::rootn(a, 3),
        Unary::Floor | Unary::FloorSlope => jump::floor_regularity,
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

impl Op {
    /// Writes the result straight to its place: the operands are elsewhere, and that is known only of
    /// references that are arguments.
    #[inline(always)]
    fn evaluate<A: Arithmetic>(
        self,
        a: &A::Value,
        b: &A::Value,
        out: &mut A::Value,
    ) -> Regular<MaskOf<A>> {
        let mut regular = Regular::smooth();
        match self {
            Op::Binary(Binary::Add) => *out = A::add(a, b),
            Op::Binary(Binary::Sub) => *out = A::sub(a, b),
            Op::Binary(Binary::Mul) => *out = A::mul(a, b),
            Op::Binary(Binary::Div) => {
                regular = Regular::undefined(A::contains_zero(b));
                *out = A::div(a, b);
            }
            Op::Binary(Binary::Min) => {
                regular = meeting::<A>(a, b);
                *out = A::min(a, b);
            }
            Op::Binary(Binary::Max) => {
                regular = meeting::<A>(a, b);
                *out = A::max(a, b);
            }
            Op::Binary(function @ (Binary::Pow | Binary::Atan2 | Binary::Atan2Cut)) => {
                let of = match function {
                    Binary::Pow => domain::pow,
                    _ => jump::atan2_regularity,
                };
                regular = Regular::by_lane(|wanted| A::test2(a, b, |a, b| of(a, b) == wanted));
                *out = function.apply::<A>(a, b);
            }
            Op::Unary(function) => {
                regular = unary_regularity::<A>(function, a);
                *out = function.apply::<A>(a);
            }
            Op::Square => *out = A::sqr(a),
            Op::Power(n) => {
                if n < 0 {
                    regular = Regular::undefined(A::contains_zero(a));
                }
                *out = A::powi(a, n);
            }
        }
        regular
    }
}

/// How regular the smaller and the larger of two are.
#[inline(always)]
fn meeting<A: Arithmetic>(a: &A::Value, b: &A::Value) -> Regular<MaskOf<A>> {
    Regular::by_lane(|wanted| A::test2(a, b, |a, b| domain::min(a, b) == wanted))
}
