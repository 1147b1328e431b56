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
        // What the branches of choices say of themselves.
        let mut inside = vec![Regular::smooth(); self.tape.scopes()];
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
                Op::Binary(_) | Op::Choose(_) => operand(step.b, step.from.1),
                _ => a,
            };
            let own = if let Op::Choose(number) = step.op {
                let branches = &self.tape.branches[number as usize];
                let no = operand(branches.no.0, branches.no.1);
                let (taken, refused) = decided::<A>(a);
                *out = choose::<A>((taken, refused), b, no);
                let jump = Regular::jump(!(taken | refused));
                let yes = inside[branches.scopes.0 as usize - 1].unless(refused);
                let no = inside[branches.scopes.1 as usize - 1].unless(taken);
                jump.and(Regular::undefined(A::is_empty(a)))
                    .and(yes)
                    .and(no)
            } else {
                step.op.evaluate::<A>(a, b, out)
            };
            if step.scope == 0 {
                regular = regular.and(own);
            } else {
                let inside = &mut inside[step.scope as usize - 1];
                *inside = inside.and(own);
            }
        }
        regular
    }
}

/// Where the test of a choice is positive, and where it is negative; neither where a smaller box could decide it
/// otherwise.
#[inline(always)]
pub(crate) fn decided<A: Arithmetic>(test: &A::Value) -> (MaskOf<A>, MaskOf<A>) {
    (A::is_positive(test), A::is_positive(&A::neg(test)))
}

/// The value of a choice with such a test.
#[inline(always)]
pub(crate) fn choose<A: Arithmetic>(
    (taken, refused): (MaskOf<A>, MaskOf<A>),
    yes: &A::Value,
    no: &A::Value,
) -> A::Value {
    let other = A::select(refused, no, &A::hull(yes, no));
    A::select(taken, yes, &other)
}

#[inline(always)]
fn unary_regularity<A: Arithmetic>(function: Unary, a: &A::Value) -> Regular<MaskOf<A>> {
    // The frequent ones are asked for all boxes at once; each box by itself is asked the same in `domain`.
    let unknown = || Regular::undefined(A::is_empty(a));
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
        Unary::Ln => return unknown().and(Regular::undefined(!A::is_positive(a))),
        Unary::Abs => {
            let kink = A::test(a, |a| a.lo() < 0.0 && a.hi() > 0.0);
            return unknown().and(Regular::kink(kink));
        }
        Unary::Sign => return unknown().and(Regular::jump(A::contains_zero(a))),
        Unary::Tan => domain::tan,
        Unary::Asin => domain::asin,
        Unary::Acos => domain::acos,
        Unary::Acosh => domain::acosh,
        Unary::Atanh => domain::atanh,
    };
    Regular::by_lane(|wanted| A::test(a, |a| of(a) == wanted))
}

impl Op {
    /// One instruction: the value, and how regular the operation is there.
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
            // Made with its branches, where they are known.
            Op::Choose(_) => {}
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

/// How regular the smaller and the larger of two are, as [`domain::min`].
#[inline(always)]
fn meeting<A: Arithmetic>(a: &A::Value, b: &A::Value) -> Regular<MaskOf<A>> {
    let kink = A::test2(a, b, |a, b| a.lo() < b.hi() && b.lo() < a.hi());
    Regular::kink(kink).and(Regular::undefined(A::is_empty(a) | A::is_empty(b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use veribound_interval::lanes::{Interval8, LANES};

    const SIDES: [Option<(f64, f64)>; LANES] = [
        None,
        Some((-1.0, 2.0)),
        Some((0.0, 1.0)),
        Some((-1.0, 0.0)),
        Some((0.0, 0.0)),
        Some((1.0, 2.0)),
        Some((-2.0, -1.0)),
        Some((f64::NEG_INFINITY, f64::INFINITY)),
    ];

    struct Ask<'a>(&'a Interval8, &'a Interval8);

    impl Kernel<Interval8> for Ask<'_> {
        type Output = Vec<Regular<MaskOf8>>;

        #[inline(always)]
        fn run<A: Arithmetic<Value = Interval8>>(self) -> Self::Output {
            let alone = [Unary::Sqrt, Unary::Ln, Unary::Abs, Unary::Sign];
            let mut all = alone.map(|f| unary_regularity::<A>(f, self.0)).to_vec();
            all.push(meeting::<A>(self.0, self.1));
            all
        }
    }

    type MaskOf8 = <Interval8 as Value>::Mask;

    #[test]
    fn boxes_side_by_side_are_asked_what_each_is_asked() {
        let of = |side: Option<(f64, f64)>| {
            side.and_then(|(lo, hi)| Interval::new(lo, hi))
                .unwrap_or(Interval::EMPTY)
        };
        for turn in 0..LANES {
            let a = Interval8::from_fn(|lane| of(SIDES[lane]));
            let b = Interval8::from_fn(|lane| of(SIDES[(lane + turn) % LANES]));
            let found = Interval8::run(Ask(&a, &b));
            for lane in 0..LANES {
                let (a, b) = (a.get(lane), b.get(lane));
                let exact = [
                    domain::sqrt(a),
                    domain::ln(a),
                    domain::abs(a),
                    domain::sign(a),
                    domain::min(a, b),
                ];
                for (found, exact) in found.iter().zip(exact) {
                    assert_eq!(
                        found.is_smooth().get(lane),
                        exact >= Regularity::Smooth,
                        "{a} {b}"
                    );
                    assert_eq!(
                        found.is_continuous().get(lane),
                        exact >= Regularity::Kink,
                        "{a} {b}"
                    );
                    assert_eq!(
                        found.is_defined().get(lane),
                        exact >= Regularity::Jump,
                        "{a} {b}"
                    );
                }
            }
        }
    }
}
