//! The way back: from a condition on a result to the operands.
#![allow(clippy::indexing_slicing, reason = "PROOF: registers as in `tape`")]

use super::{Op, Tape, decided};
use crate::graph::{Binary, Unary, jump};
use veribound_interval::Interval;
use veribound_interval::lanes::{Arithmetic, Kernel, Lanewise, MaskOf, Value};

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
        // Where the branches of choices are taken for sure.
        let mut taken = vec![V::Mask::splat(false); self.tape.scopes()];
        for step in self.tape.instructions.iter().rev() {
            if !possible.any() {
                break;
            }
            let counts = match step.scope {
                0 => V::Mask::splat(true),
                scope => taken[scope as usize - 1],
            };
            if !counts.any() {
                continue;
            }
            let out = registers[step.out as usize];
            let a = registers[step.a as usize];
            let narrowed = match step.op {
                Op::Choose(number) => {
                    let branches = &self.tape.branches[number as usize];
                    let (yes, no) = (step.b as usize, branches.no.0 as usize);
                    let (certain, refused) = decided::<A>(&a);
                    let sides = [(yes, no, certain, refused), (no, yes, refused, certain)];
                    for (side, scope) in sides
                        .into_iter()
                        .zip([branches.scopes.0, branches.scopes.1])
                    {
                        let (own, other, is_taken, is_not) = side;
                        let other = registers[other];
                        // The other one has none of the values: what is left has the test at zero, or this one.
                        let alone = A::is_empty(&A::intersect(&other, &out)) & !is_taken & !is_not;
                        let at_most = A::map3(&registers[own], &other, &out, beside);
                        let exact = A::intersect(&registers[own], &out);
                        let narrow = A::select(is_taken, &exact, &at_most);
                        let counts = counts & (is_taken | alone);
                        possible = possible & !(counts & A::is_empty(&narrow));
                        registers[own] = A::select(counts, &narrow, &registers[own]);
                        taken[scope as usize - 1] = counts;
                    }
                    // One of the branches may be the test itself.
                    let test = registers[step.a as usize];
                    choice_reverse::<A>(&out, &test, (&registers[yes], &registers[no]))
                }
                Op::Binary(function) => {
                    let b = registers[step.b as usize];
                    let (a, b) = binary_reverse::<A>(function, &out, &a, &b);
                    // Both operands in one register: both conditions hold.
                    let b = if step.a == step.b {
                        A::intersect(&a, &b)
                    } else {
                        b
                    };
                    possible = possible & !(counts & A::is_empty(&b));
                    keep::<A>(step.scope, counts, &b, &mut registers[step.b as usize]);
                    if step.a == step.b { b } else { a }
                }
                Op::Unary(function) => unary_reverse::<A>(function, &out, &a),
                Op::Square => A::map2(&out, &a, Interval::sqr_rev),
                Op::Power(n) => A::map2(&out, &a, |out, a| Interval::powi_rev(n, out, a)),
            };
            possible = possible & !(counts & A::is_empty(&narrowed));
            keep::<A>(
                step.scope,
                counts,
                &narrowed,
                &mut registers[step.a as usize],
            );
        }
        possible
    }
}

/// Puts a narrowed operand in its place, in a branch of a choice only where that is taken.
#[inline(always)]
fn keep<A: Arithmetic>(scope: u32, counts: MaskOf<A>, narrowed: &A::Value, place: &mut A::Value) {
    *place = if scope == 0 {
        *narrowed
    } else {
        A::select(counts, narrowed, place)
    };
}

/// The values of a branch for which a choice can have one of the values `out` where the other branch has none of
/// them, and the test is not of the sign of the other one: the branch's own, or at zero, what lies between.
fn beside(own: Interval, other: Interval, out: Interval) -> Interval {
    let reach = if other.is_empty() {
        Some(out)
    } else if other.hi() < out.lo() {
        Interval::new(out.lo(), f64::INFINITY)
    } else {
        Interval::new(f64::NEG_INFINITY, out.hi())
    };
    own.intersect(reach.unwrap_or(Interval::ENTIRE))
}

/// Tests of a choice for which it can have one of the values `out`: a branch that has none of them is not taken.
/// At zero everything between the branches is a value.
#[inline(always)]
fn choice_reverse<A: Arithmetic>(
    out: &A::Value,
    test: &A::Value,
    (yes, no): (&A::Value, &A::Value),
) -> A::Value {
    let half = |lo, hi| A::Value::splat(Interval::new(lo, hi).unwrap_or(Interval::ENTIRE));
    let (certain, refused) = decided::<A>(test);
    let without_yes = A::intersect(test, &half(f64::NEG_INFINITY, 0.0));
    let without_no = A::intersect(test, &half(0.0, f64::INFINITY));
    let yes = certain | !A::is_empty(&A::intersect(yes, out));
    let no = refused | !A::is_empty(&A::intersect(no, out));
    let test = A::select(yes | refused, test, &without_yes);
    let without_both = A::intersect(&test, &without_no);
    A::select(no | certain, &test, &without_both)
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
