//! The way back: from a condition on a result to the operands.
#![allow(clippy::indexing_slicing, reason = "PROOF: registers as in `tape`")]

use super::{Op, Tape};
use crate::graph::{Binary, Unary, jump};
use veribound_interval::Interval;
use veribound_interval::lanes::{Arithmetic, Kernel, Lanewise, Value};

pub(super) struct PropagateBack<'a, V> {
    pub(super) tape: &'a Tape,
    pub(super) target: Interval,
    pub(super) registers: &'a mut [V],
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
        Unary::Cbrt => |out, a| Interval::rootn_rev(3, out, a),
        Unary::Floor => jump::floor_rev,
        // Says nothing about its argument that is worth a question.
        Unary::FloorSlope => return *a,
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
        Binary::Pow => (
            A::map3(b, out, a, Interval::pow_rev1),
            A::map3(a, out, b, Interval::pow_rev2),
        ),
        Binary::Atan2 => (
            A::map3(out, a, b, |out, a, b| jump::atan2_rev(out, a, b).0),
            A::map3(out, a, b, |out, a, b| jump::atan2_rev(out, a, b).1),
        ),
        Binary::Atan2Cut => (*a, *b),
    }
}
