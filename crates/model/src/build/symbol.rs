//! Values of an equation under construction.

use super::condition::Condition;
use super::number::Number;
use super::tree::{Flaw, Tree};
use crate::graph::Unary;
use crate::model::Relation;
use crate::syntax::ast::{Arithmetic, Ast, Function, Kind};
use std::fmt;
use std::iter::Sum;
use std::ops::{Add, Div, Mul, Neg, Sub};
use std::sync::Arc;
use veribound_interval::Decimal;

/// A value in an equation: a quantity, a number, or an operation on such.
///
/// `+ - * /` work on symbols, references to symbols, whole numbers and decimals in text (`"0.1"` is a
/// tenth; floats are not taken, see [`Number`]). What an operation means, and where it is
/// defined, is the same as in a model file: a symbol is the text of an equation, and
/// [`ModelBuilder::build`](super::ModelBuilder::build) reads it.
///
/// ```
/// use veribound_model::build::ModelBuilder;
///
/// let mut model = ModelBuilder::new("pendulum");
/// let angle = model.state("angle").unit("rad").init("0.1", "0.2").symbol();
/// let rate = model.state("rate").unit("rad/s").init(0, 0).symbol();
/// let damping = model.param("damping", 0, "0.5").symbol();
///
/// let torque = "-9.81" * angle.sin() - &damping * &rate * rate.abs();
/// assert_eq!(torque.to_string(), "-9.81*sin(angle) - damping*rate*abs(rate)");
/// assert_eq!((2 * (&angle + 1)).pow(3).to_string(), "(2*(angle + 1))^3");
/// ```
#[derive(Debug, Clone)]
pub struct Symbol(pub(super) Tree);

impl Symbol {
    pub(super) fn name(name: &str) -> Symbol {
        Symbol(Tree::leaf(Kind::Name(name.to_string())))
    }

    /// A call of `function`.
    pub(super) fn call(function: Function, arguments: &[&Symbol]) -> Symbol {
        let trees: Vec<&Tree> = arguments.iter().map(|symbol| &symbol.0).collect();
        Symbol(Tree::of(&trees, |asts| {
            let arguments: Vec<Ast> = asts.iter().map(|ast| (**ast).clone()).collect();
            Some(Kind::Call(function, arguments))
        }))
    }

    fn plain(&self, function: Unary) -> Symbol {
        Symbol::call(Function::Plain(function), &[self])
    }

    fn compared(&self, other: Symbol, kind: fn([Arc<Ast>; 2]) -> Kind) -> Condition {
        Condition(Tree::join([&self.0, &other.0], kind))
    }
}

macro_rules! functions {
    ($($(#[$doc:meta])* $name:ident = $function:expr;)*) => {
        /// Functions; what each means stands in the documentation of the model file.
        impl Symbol {$(
            $(#[$doc])*
            pub fn $name(&self) -> Symbol {
                Symbol::call($function, &[self])
            }
        )*}
    };
}

functions! {
    /// Square root.
    sqrt = Function::Plain(Unary::Sqrt);
    /// The exponential function.
    exp = Function::Plain(Unary::Exp);
    /// The natural logarithm.
    ln = Function::Plain(Unary::Ln);
    /// The logarithm to the base 2.
    log2 = Function::LogTo(2);
    /// The logarithm to the base 10.
    log10 = Function::LogTo(10);
    /// The sine of an angle in radian.
    sin = Function::Plain(Unary::Sin);
    /// The cosine of an angle in radian.
    cos = Function::Plain(Unary::Cos);
    /// The tangent of an angle in radian.
    tan = Function::Plain(Unary::Tan);
    /// The arc sine, in radian.
    asin = Function::Plain(Unary::Asin);
    /// The arc cosine, in radian.
    acos = Function::Plain(Unary::Acos);
    /// The arc tangent, in radian.
    atan = Function::Plain(Unary::Atan);
    /// The hyperbolic sine.
    sinh = Function::Plain(Unary::Sinh);
    /// The hyperbolic cosine.
    cosh = Function::Plain(Unary::Cosh);
    /// The hyperbolic tangent.
    tanh = Function::Plain(Unary::Tanh);
    /// The inverse of the hyperbolic sine.
    asinh = Function::Plain(Unary::Asinh);
    /// The inverse of the hyperbolic cosine.
    acosh = Function::Plain(Unary::Acosh);
    /// The inverse of the hyperbolic tangent.
    atanh = Function::Plain(Unary::Atanh);
    /// The cube root, of negative numbers too.
    cbrt = Function::Plain(Unary::Cbrt);
    /// The next whole number below.
    floor = Function::Plain(Unary::Floor);
    /// The next whole number above.
    ceil = Function::Ceil;
    /// The nearest whole number.
    round = Function::Round;
    /// The next whole number towards zero.
    trunc = Function::Trunc;
}

impl Symbol {
    /// The absolute value.
    pub fn abs(&self) -> Symbol {
        self.plain(Unary::Abs)
    }

    /// 1 where the value is positive, -1 where it is negative, everything between at 0.
    pub fn sign(&self) -> Symbol {
        self.plain(Unary::Sign)
    }

    /// The smaller one.
    pub fn min(&self, other: impl Into<Symbol>) -> Symbol {
        Symbol::call(Function::Min, &[self, &other.into()])
    }

    /// The larger one.
    pub fn max(&self, other: impl Into<Symbol>) -> Symbol {
        Symbol::call(Function::Max, &[self, &other.into()])
    }

    /// The angle of the point `(x, self)`, in radian.
    pub fn atan2(&self, x: impl Into<Symbol>) -> Symbol {
        Symbol::call(Function::Atan2, &[self, &x.into()])
    }

    /// A power of a value that is not negative.
    pub fn power(&self, exponent: impl Into<Symbol>) -> Symbol {
        let kind = |[base, exponent]: [Arc<Ast>; 2]| Kind::Power(base, exponent);
        Symbol(Tree::join([&self.0, &exponent.into().0], kind))
    }

    /// An integer power.
    pub fn pow(&self, exponent: i32) -> Symbol {
        self.power(exponent)
    }

    /// The value, cut off at the limits.
    pub fn sat(&self, lower: impl Into<Symbol>, upper: impl Into<Symbol>) -> Symbol {
        Symbol::call(Function::Saturation, &[self, &lower.into(), &upper.into()])
    }

    /// 0 between the limits, beyond them the distance to them.
    pub fn deadzone(&self, lower: impl Into<Symbol>, upper: impl Into<Symbol>) -> Symbol {
        Symbol::call(Function::DeadZone, &[self, &lower.into(), &upper.into()])
    }

    /// Straight lines between points, constant before the first and after the last; two points one
    /// above the other are a jump.
    ///
    /// ```
    /// # let mut model = veribound_model::build::ModelBuilder::new("lamp");
    /// # let u = model.input("u").symbol();
    /// let brightness = u.table([("0", "0"), ("1.5", "0.2"), ("2", "1")]);
    /// assert_eq!(brightness.to_string(), "table(u, 0, 0, 1.5, 0.2, 2, 1)");
    /// ```
    pub fn table<X: Into<Symbol>, Y: Into<Symbol>>(
        &self,
        points: impl IntoIterator<Item = (X, Y)>,
    ) -> Symbol {
        let mut arguments = vec![self.clone()];
        for (x, y) in points {
            arguments.extend([x.into(), y.into()]);
        }
        Symbol::call(Function::Table, &arguments.iter().collect::<Vec<_>>())
    }
}

/// Comparisons: conditions for guards of modes and for [`if_else`](super::if_else).
///
/// ```
/// # let mut model = veribound_model::build::ModelBuilder::new("rig");
/// # let omega = model.state("omega").init(0, 0).symbol();
/// # let (u, level) = (model.input("u").symbol(), model.param("T", 0, 1).symbol());
/// let stick = omega.equals(0).and(u.abs().at_most(&level));
/// assert_eq!(stick.to_string(), "omega == 0 and abs(u) <= T");
/// ```
impl Symbol {
    /// `self < other`
    pub fn below(&self, other: impl Into<Symbol>) -> Condition {
        self.compared(other.into(), |[a, b]| Kind::Compare(Relation::Less, a, b))
    }

    /// `self <= other`
    pub fn at_most(&self, other: impl Into<Symbol>) -> Condition {
        self.compared(other.into(), |[a, b]| {
            Kind::Compare(Relation::LessEqual, a, b)
        })
    }

    /// `self > other`
    pub fn above(&self, other: impl Into<Symbol>) -> Condition {
        self.compared(other.into(), |[a, b]| {
            Kind::Compare(Relation::Greater, a, b)
        })
    }

    /// `self >= other`
    pub fn at_least(&self, other: impl Into<Symbol>) -> Condition {
        self.compared(other.into(), |[a, b]| {
            Kind::Compare(Relation::GreaterEqual, a, b)
        })
    }

    /// `self == other`
    pub fn equals(&self, other: impl Into<Symbol>) -> Condition {
        self.compared(other.into(), |[a, b]| Kind::Compare(Relation::Equal, a, b))
    }

    /// `self != other`
    pub fn differs(&self, other: impl Into<Symbol>) -> Condition {
        self.compared(other.into(), |[a, b]| {
            Kind::Compare(Relation::NotEqual, a, b)
        })
    }
}

impl From<Number> for Symbol {
    fn from(number: Number) -> Symbol {
        Symbol(match number.0 {
            Ok(decimal) if decimal.is_negative() => {
                let positive = Tree::leaf(Kind::Number(-&decimal));
                Tree::join([&positive], |[a]| Kind::Negate(a))
            }
            Ok(decimal) => Tree::leaf(Kind::Number(decimal)),
            Err(flaw) => Tree::flawed(flaw),
        })
    }
}

impl From<&Symbol> for Symbol {
    fn from(symbol: &Symbol) -> Symbol {
        symbol.clone()
    }
}

macro_rules! operators {
    ($($operator:ident $method:ident $kind:expr;)*) => {$(
        impl<T: Into<Symbol>> $operator<T> for &Symbol {
            type Output = Symbol;

            fn $method(self, other: T) -> Symbol {
                Symbol(Tree::join([&self.0, &other.into().0], |[a, b]| {
                    Kind::Arithmetic($kind, a, b)
                }))
            }
        }

        impl<T: Into<Symbol>> $operator<T> for Symbol {
            type Output = Symbol;

            fn $method(self, other: T) -> Symbol {
                (&self).$method(other)
            }
        }
    )*};
}

operators! {
    Add add Arithmetic::Add;
    Sub sub Arithmetic::Subtract;
    Mul mul Arithmetic::Multiply;
    Div div Arithmetic::Divide;
}

macro_rules! numbers {
    ($($number:ty),*) => {$(
        impl From<$number> for Symbol {
            fn from(value: $number) -> Symbol {
                Symbol::from(Number::from(value))
            }
        }
    )*};
}

numbers!(i32, i64, u32, u64, usize, &str, String, Decimal, &Decimal);

/// Numbers on the left of an operator. Of the whole ones `i32` alone, so that the type of `2 * x` is known.
macro_rules! numbers_before {
    ($($number:ty: $($operator:ident $method:ident),*;)*) => {$($(
        impl $operator<Symbol> for $number {
            type Output = Symbol;

            fn $method(self, other: Symbol) -> Symbol {
                Symbol::from(self).$method(other)
            }
        }

        impl $operator<&Symbol> for $number {
            type Output = Symbol;

            fn $method(self, other: &Symbol) -> Symbol {
                Symbol::from(self).$method(other)
            }
        }
    )*)*};
}

numbers_before! {
    i32: Add add, Sub sub, Mul mul, Div div;
    &str: Add add, Sub sub, Mul mul, Div div;
}

impl Neg for &Symbol {
    type Output = Symbol;

    fn neg(self) -> Symbol {
        Symbol(Tree::join([&self.0], |[a]| Kind::Negate(a)))
    }
}

impl Neg for Symbol {
    type Output = Symbol;

    fn neg(self) -> Symbol {
        -&self
    }
}

impl Sum for Symbol {
    /// The sum from left to right; 0 of nothing.
    fn sum<I: Iterator<Item = Symbol>>(symbols: I) -> Symbol {
        symbols
            .reduce(|sum, symbol| sum + symbol)
            .unwrap_or_else(|| Symbol::from(0))
    }
}

impl fmt::Display for Symbol {
    /// The text of the equation.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0.ast {
            Ok(ast) => ast.fmt(f),
            Err(Flaw::NoNumber(text)) => f.write_str(text),
            Err(Flaw::TooLong) => f.write_str("..."),
        }
    }
}
