//! The parts of an equation that are in one unit.

use crate::graph::Unary;
use crate::syntax::ast::{Arithmetic, Ast, Function, Kind};
use num_rational::Ratio;
use num_traits::{CheckedDiv, CheckedMul, One, ToPrimitive};

/// A choice between values, or a function that gives one of its arguments or less of it.
pub(super) struct Parts<'e> {
    /// Of one kind, but not what the result is in.
    pub beside: Vec<&'e Ast>,
    /// What the result is in.
    pub results: Vec<&'e Ast>,
}

impl<'e> Parts<'e> {
    pub fn of(kind: &'e Kind) -> Option<Self> {
        let (beside, results) = match kind {
            Kind::If(condition, a, b) => (vec![&**condition], vec![&**a, &**b]),
            Kind::Call(function, arguments) => match (function, arguments.as_slice()) {
                (
                    Function::Plain(Unary::Abs | Unary::Floor)
                    | Function::Ceil
                    | Function::Round
                    | Function::Trunc
                    | Function::Min
                    | Function::Max
                    | Function::Saturation
                    | Function::DeadZone,
                    all,
                ) => (Vec::new(), all.iter().collect()),
                (Function::Friction, [velocity, levels @ ..]) => {
                    (vec![velocity], levels.iter().collect())
                }
                (Function::Table, [x, points @ ..]) => {
                    let abscissas = points.iter().step_by(2);
                    let values = points.iter().skip(1).step_by(2);
                    (
                        std::iter::once(x).chain(abscissas).collect(),
                        values.collect(),
                    )
                }
                _ => return None,
            },
            _ => return None,
        };
        Some(Parts { beside, results })
    }
}

/// The terms of a sum without their signs; one term for what is no sum.
pub(super) fn terms(ast: &Ast) -> Vec<&Ast> {
    match &ast.kind {
        Kind::Arithmetic(Arithmetic::Add | Arithmetic::Subtract, a, b) => {
            let mut all = terms(a);
            all.extend(terms(b));
            all
        }
        Kind::Negate(a) => terms(a),
        _ => vec![ast],
    }
}

/// The value of an exponent that is written as a number or a fraction.
pub(super) fn exponent(ast: &Ast) -> Option<Ratio<i64>> {
    match &ast.kind {
        Kind::Number(number) => {
            let number = number.to_rational();
            Some(Ratio::new(
                number.numer().to_i64()?,
                number.denom().to_i64()?,
            ))
        }
        Kind::Negate(a) => exponent(a)?.checked_mul(&-Ratio::one()),
        Kind::Arithmetic(Arithmetic::Divide, a, b) => exponent(a)?.checked_div(&exponent(b)?),
        _ => None,
    }
}
