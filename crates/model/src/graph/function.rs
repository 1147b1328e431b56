//! Functions of one and two arguments.

use super::jump;
use veribound_interval::Interval;
use veribound_interval::lanes::Arithmetic;

/// Functions of one argument.
///
/// Example: [`Graph`](crate::Graph).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Unary {
    /// `-a`
    Neg,
    /// `sqrt(a)`
    Sqrt,
    /// `exp(a)`
    Exp,
    /// Natural logarithm.
    Ln,
    /// `sin(a)`, a in radian
    Sin,
    /// `cos(a)`, a in radian
    Cos,
    /// `tan(a)`, a in radian
    Tan,
    /// `atan(a)`
    Atan,
    /// `tanh(a)`
    Tanh,
    /// `asin(a)`
    Asin,
    /// `acos(a)`
    Acos,
    /// `sinh(a)`
    Sinh,
    /// `cosh(a)`
    Cosh,
    /// `asinh(a)`
    Asinh,
    /// `acosh(a)`
    Acosh,
    /// `atanh(a)`
    Atanh,
    /// `abs(a)`
    Abs,
    /// `sign(a)`, with the set `[-1, 1]` at zero
    Sign,
    /// The slope of `sign(a)`: 0 where `a` is not zero; at zero, where `sign` jumps, every number. Not a
    /// word of the language: only second derivatives at kinks hold it.
    Impulse,
    /// The cube root, of negative numbers too.
    Cbrt,
    /// `floor(a)`, with the set `[n - 1, n]` at an integer `n`
    Floor,
    /// The slope of `floor(a)`: 0 where it is constant, every number that is not negative where it jumps. Not
    /// a word of the language.
    FloorSlope,
}

/// Functions of two arguments.
///
/// Example: [`Graph`](crate::Graph).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Binary {
    /// `a + b`
    Add,
    /// `a - b`
    Sub,
    /// `a * b`
    Mul,
    /// `a / b`
    Div,
    /// The smaller one.
    Min,
    /// The larger one.
    Max,
    /// `a^b` for `a >= 0`; the exponent is a number.
    Pow,
    /// The angle of the point `(b, a)`, with the set `[-pi, pi]` where `a = 0` and `b < 0`
    Atan2,
    /// Zero where the box holds no point with `a = 0` and `b < 0`, everything elsewhere.
    Atan2Cut,
}

impl Unary {
    /// The function's name in a model file.
    pub fn name(self) -> &'static str {
        match self {
            Unary::Neg => "-",
            Unary::Sqrt => "sqrt",
            Unary::Exp => "exp",
            Unary::Ln => "log",
            Unary::Sin => "sin",
            Unary::Cos => "cos",
            Unary::Tan => "tan",
            Unary::Atan => "atan",
            Unary::Tanh => "tanh",
            Unary::Asin => "asin",
            Unary::Acos => "acos",
            Unary::Sinh => "sinh",
            Unary::Cosh => "cosh",
            Unary::Asinh => "asinh",
            Unary::Acosh => "acosh",
            Unary::Atanh => "atanh",
            Unary::Abs => "abs",
            Unary::Sign => "sign",
            Unary::Impulse => "impulse",
            Unary::Cbrt => "cbrt",
            Unary::Floor => "floor",
            Unary::FloorSlope => "floor_slope",
        }
    }

    /// Every value of the function on `a`.
    #[inline(always)]
    pub(crate) fn apply<A: Arithmetic>(self, a: &A::Value) -> A::Value {
        match self {
            Unary::Neg => A::neg(a),
            Unary::Sqrt => A::sqrt(a),
            Unary::Exp => A::exp(a),
            Unary::Ln => A::ln(a),
            Unary::Sin => A::sin(a),
            Unary::Cos => A::cos(a),
            Unary::Tan => A::tan(a),
            Unary::Atan => A::atan(a),
            Unary::Tanh => A::tanh(a),
            Unary::Asin => A::map(a, Interval::asin),
            Unary::Acos => A::map(a, Interval::acos),
            Unary::Sinh => A::map(a, Interval::sinh),
            Unary::Cosh => A::map(a, Interval::cosh),
            Unary::Asinh => A::map(a, Interval::asinh),
            Unary::Acosh => A::map(a, Interval::acosh),
            Unary::Atanh => A::map(a, Interval::atanh),
            Unary::Abs => A::abs(a),
            Unary::Sign => A::sign(a),
            Unary::Impulse => A::map(a, impulse),
            Unary::Cbrt => A::map(a, |a| a.rootn(3)),
            Unary::Floor => A::map(a, jump::floor),
            Unary::FloorSlope => A::map(a, jump::floor_slope),
        }
    }
}

/// [`Unary::Impulse`]
fn impulse(a: Interval) -> Interval {
    if a.is_empty() {
        a
    } else if a.contains(0.0) {
        Interval::ENTIRE
    } else {
        Interval::ZERO
    }
}

impl Binary {
    /// The function's name in a model file, where it is not an operator.
    pub(crate) fn name(self) -> Option<&'static str> {
        match self {
            Binary::Min => Some("min"),
            Binary::Max => Some("max"),
            Binary::Atan2 => Some("atan2"),
            Binary::Atan2Cut => Some("atan2_cut"),
            Binary::Add | Binary::Sub | Binary::Mul | Binary::Div | Binary::Pow => None,
        }
    }

    /// Every value of the function on `a` and `b`.
    #[inline(always)]
    pub(crate) fn apply<A: Arithmetic>(self, a: &A::Value, b: &A::Value) -> A::Value {
        match self {
            Binary::Add => A::add(a, b),
            Binary::Sub => A::sub(a, b),
            Binary::Mul => A::mul(a, b),
            Binary::Div => A::div(a, b),
            Binary::Min => A::min(a, b),
            Binary::Max => A::max(a, b),
            Binary::Pow => A::map2(a, b, Interval::pow),
            Binary::Atan2 => A::map2(a, b, jump::atan2),
            Binary::Atan2Cut => A::map2(a, b, jump::atan2_cut),
        }
    }
}
