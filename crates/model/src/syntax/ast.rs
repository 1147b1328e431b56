//! An equation or condition as it was written.

use crate::graph::Unary;
use crate::model::Relation;
use std::ops::Range;
use std::sync::Arc;
use veribound_interval::Decimal;

/// A piece of an equation with its place.
#[derive(Debug, Clone)]
pub(crate) struct Ast {
    pub kind: Kind,
    /// Bytes of the text it was read from.
    pub range: Range<usize>,
    /// Levels below and including this one; bounds every recursion over the tree.
    pub depth: usize,
}

#[derive(Debug, Clone)]
pub(crate) enum Kind {
    /// Not negative.
    Number(Decimal),
    Name(String),
    /// `true`
    Always,
    Negate(Arc<Ast>),
    Arithmetic(Arithmetic, Arc<Ast>, Arc<Ast>),
    Power(Arc<Ast>, Arc<Ast>),
    Call(Function, Vec<Ast>),
    Compare(Relation, Arc<Ast>, Arc<Ast>),
    And(Arc<Ast>, Arc<Ast>),
    Or(Arc<Ast>, Arc<Ast>),
    Not(Arc<Ast>),
    /// `if condition then value else value`
    If(Arc<Ast>, Arc<Ast>, Arc<Ast>),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Arithmetic {
    Add,
    Subtract,
    Multiply,
    Divide,
}

/// Points of a table in an equation; each costs an operation in every evaluation.
pub(crate) const MOST_POINTS: usize = 100;

/// Arguments of a smallest or largest value; each costs an operation too.
const MOST_ARGUMENTS: usize = 400;

/// Functions an equation can call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Function {
    Plain(Unary),
    /// Logarithm to a base.
    LogTo(i64),
    Ceil,
    Round,
    Trunc,
    Atan2,
    Min,
    Max,
    /// `sat(x, lower, upper)`
    Saturation,
    /// `deadzone(x, lower, upper)`
    DeadZone,
    /// `table(x, x0, y0, x1, y1, ...)`
    Table,
    Friction,
}

impl Function {
    /// All names, also those that are second names.
    pub const NAMES: [(&str, Function); 32] = [
        ("sqrt", Function::Plain(Unary::Sqrt)),
        ("exp", Function::Plain(Unary::Exp)),
        ("log", Function::Plain(Unary::Ln)),
        ("ln", Function::Plain(Unary::Ln)),
        ("sin", Function::Plain(Unary::Sin)),
        ("cos", Function::Plain(Unary::Cos)),
        ("tan", Function::Plain(Unary::Tan)),
        ("atan", Function::Plain(Unary::Atan)),
        ("tanh", Function::Plain(Unary::Tanh)),
        ("asin", Function::Plain(Unary::Asin)),
        ("acos", Function::Plain(Unary::Acos)),
        ("sinh", Function::Plain(Unary::Sinh)),
        ("cosh", Function::Plain(Unary::Cosh)),
        ("asinh", Function::Plain(Unary::Asinh)),
        ("acosh", Function::Plain(Unary::Acosh)),
        ("atanh", Function::Plain(Unary::Atanh)),
        ("log2", Function::LogTo(2)),
        ("log10", Function::LogTo(10)),
        ("cbrt", Function::Plain(Unary::Cbrt)),
        ("atan2", Function::Atan2),
        ("floor", Function::Plain(Unary::Floor)),
        ("ceil", Function::Ceil),
        ("round", Function::Round),
        ("trunc", Function::Trunc),
        ("sat", Function::Saturation),
        ("deadzone", Function::DeadZone),
        ("table", Function::Table),
        ("abs", Function::Plain(Unary::Abs)),
        ("sign", Function::Plain(Unary::Sign)),
        ("min", Function::Min),
        ("max", Function::Max),
        ("friction", Function::Friction),
    ];

    /// The name, the first one of two.
    pub fn name(self) -> &'static str {
        let mut names = Self::NAMES.iter();
        names
            .find(|(_, function)| *function == self)
            .map_or("-", |(name, _)| name)
    }

    pub fn named(name: &str) -> Option<Function> {
        Self::NAMES
            .iter()
            .find(|(known, _)| *known == name)
            .map(|(_, function)| *function)
    }

    /// Fewest and most arguments, and how to write the call.
    pub fn arguments(self) -> (usize, usize, &'static str) {
        match self {
            Function::Plain(_)
            | Function::LogTo(_)
            | Function::Ceil
            | Function::Round
            | Function::Trunc => (1, 1, "one argument"),
            Function::Atan2 => (2, 2, "two arguments: atan2(y, x)"),
            Function::Min | Function::Max => (2, MOST_ARGUMENTS, "two or more arguments"),
            Function::Saturation => (
                2,
                3,
                "two or three arguments: sat(x, limit) or sat(x, lower, upper)",
            ),
            Function::DeadZone => (
                2,
                3,
                "two or three arguments: deadzone(x, limit) or deadzone(x, lower, upper)",
            ),
            Function::Table => (
                5,
                1 + 2 * MOST_POINTS,
                "two or more points: table(x, x0, y0, x1, y1, ...)",
            ),
            Function::Friction => (
                3,
                4,
                "three or four arguments: friction(velocity, drive, level) or \
                 friction(velocity, drive, sliding level, static level)",
            ),
        }
    }
}

/// Words of the language that no quantity can be named.
pub(crate) fn is_reserved(name: &str) -> bool {
    matches!(
        name,
        "pi" | "and" | "or" | "not" | "true" | "false" | "if" | "then" | "else"
    ) || Function::named(name).is_some()
}

impl Ast {
    pub fn new(kind: Kind, range: Range<usize>) -> Self {
        let depth = 1 + kind
            .children()
            .iter()
            .map(|child| child.depth)
            .max()
            .unwrap_or(0);
        Ast { kind, range, depth }
    }

    /// Every name that occurs, in the order of the text, with its place.
    pub fn names(&self) -> Vec<(&str, Range<usize>)> {
        let mut found = Vec::new();
        let mut open = vec![self];
        while let Some(ast) = open.pop() {
            if let Kind::Name(name) = &ast.kind {
                found.push((name.as_str(), ast.range.clone()));
            }
            open.extend(ast.kind.children());
        }
        found.sort_by_key(|(_, range)| range.start);
        found
    }
}

impl Kind {
    pub fn children(&self) -> Vec<&Ast> {
        match self {
            Kind::Number(_) | Kind::Name(_) | Kind::Always => Vec::new(),
            Kind::Negate(a) | Kind::Not(a) => vec![a],
            Kind::Arithmetic(_, a, b)
            | Kind::Power(a, b)
            | Kind::Compare(_, a, b)
            | Kind::And(a, b)
            | Kind::Or(a, b) => vec![a, b],
            Kind::If(a, b, c) => vec![a, b, c],
            Kind::Call(_, arguments) => arguments.iter().collect(),
        }
    }
}
