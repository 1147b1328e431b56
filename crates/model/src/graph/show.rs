//! Expressions in the user's words.

use super::{Binary, Choice, ExprId, Graph, Node, Unary, Var};
use num_rational::BigRational;
use num_traits::Signed;

/// Names of all quantities, to write an expression in the user's words.
///
/// Example: [`Graph`].
#[derive(Debug, Clone, Default)]
pub struct Names {
    /// State names.
    pub states: Vec<String>,
    /// Parameter names.
    pub params: Vec<String>,
    /// Input names.
    pub inputs: Vec<String>,
}

#[allow(
    clippy::indexing_slicing,
    reason = "PROOF: every ExprId is made by `intern` of this graph, so its index is inside `nodes`"
)]
impl Graph {
    /// `e` in the user's names, with as few parentheses as its structure needs.
    pub fn show(&self, e: ExprId, names: &Names) -> String {
        self.show_inside(e, names, 0)
    }

    fn show_inside(&self, e: ExprId, names: &Names, outer: u8) -> String {
        // Binding strengths: 1 sums, 2 products, 3 signs, 4 powers.
        let (text, strength) = match self.node(e) {
            Node::Constant(value) => {
                let strength = if !value.is_integer() {
                    2
                } else if value.is_negative() {
                    3
                } else {
                    9
                };
                match plain_decimal(value) {
                    Some(text) => (text, if value.is_negative() { 3 } else { 9 }),
                    None => (value.to_string(), strength),
                }
            }
            Node::Pi => ("pi".to_string(), 9),
            Node::Var(var) => (names.of(*var), 9),
            Node::Unary(Unary::Neg, a) => (format!("-{}", self.show_inside(*a, names, 2)), 2),
            Node::Unary(function, a) => (
                format!("{}({})", function.name(), self.show_inside(*a, names, 0)),
                9,
            ),
            Node::Power(a, n) => (format!("{}^{n}", self.show_inside(*a, names, 5)), 4),
            Node::Binary(Binary::Pow, a, b) => {
                let base = self.show_inside(*a, names, 5);
                (format!("{base}^{}", self.show_inside(*b, names, 5)), 4)
            }
            Node::Binary(function, a, b) => {
                if let Some(name) = function.name() {
                    let (a, b) = (
                        self.show_inside(*a, names, 0),
                        self.show_inside(*b, names, 0),
                    );
                    return format!("{name}({a}, {b})");
                }
                let (symbol, strength, right) = match function {
                    Binary::Add => (" + ", 1, 1),
                    Binary::Sub => (" - ", 1, 2),
                    Binary::Mul => ("*", 2, 2),
                    _ => ("/", 2, 3),
                };
                let left = self.show_inside(*a, names, strength);
                let right = self.show_inside(*b, names, right);
                (format!("{left}{symbol}{right}"), strength)
            }
            Node::Choose(Choice { test, yes, no }) => (
                format!(
                    "if {} then {} else {}",
                    self.show_test(*test, names),
                    self.show_inside(*yes, names, 0),
                    self.show_inside(*no, names, 0)
                ),
                0,
            ),
        };
        if strength < outer {
            format!("({text})")
        } else {
            text
        }
    }

    /// The condition that a test is positive; a smaller one is positive if both are.
    fn show_test(&self, test: ExprId, names: &Names) -> String {
        let compare = |a: ExprId, relation: &str, b: ExprId| {
            let (a, b) = (self.show_inside(a, names, 1), self.show_inside(b, names, 1));
            format!("{a} {relation} {b}")
        };
        match *self.node(test) {
            Node::Binary(which @ (Binary::Min | Binary::Max), a, b) => {
                let part = |e: ExprId| match self.node(e) {
                    Node::Binary(other @ (Binary::Min | Binary::Max), ..) if *other != which => {
                        format!("({})", self.show_test(e, names))
                    }
                    _ => self.show_test(e, names),
                };
                let word = if which == Binary::Min { "and" } else { "or" };
                format!("{} {word} {}", part(a), part(b))
            }
            Node::Binary(Binary::Sub, a, b) => compare(a, ">", b),
            Node::Unary(Unary::Abs, a) => match *self.node(a) {
                Node::Binary(Binary::Sub, a, b) => compare(a, "!=", b),
                _ => format!("{} != 0", self.show_inside(a, names, 1)),
            },
            Node::Unary(Unary::Neg, a) => match *self.node(a) {
                Node::Unary(Unary::Abs, a) => match *self.node(a) {
                    Node::Binary(Binary::Sub, a, b) => compare(a, "==", b),
                    _ => format!("{} == 0", self.show_inside(a, names, 1)),
                },
                _ => format!("{} < 0", self.show_inside(a, names, 1)),
            },
            _ => format!("{} > 0", self.show_inside(test, names, 1)),
        }
    }
}

/// The decimal spelling of a rational, where it has a short one.
fn plain_decimal(value: &BigRational) -> Option<String> {
    let mut scaled = value.clone();
    let ten = BigRational::from_integer(10.into());
    for digits in 0..=18_usize {
        if scaled.is_integer() {
            let whole = scaled.to_integer();
            let sign = if whole.is_negative() { "-" } else { "" };
            let text = format!("{:0>width$}", whole.abs().to_string(), width = digits + 1);
            let (before, after) = text.split_at(text.len() - digits);
            let point = if digits > 0 { "." } else { "" };
            return Some(format!("{sign}{before}{point}{after}"));
        }
        scaled *= &ten;
    }
    None
}

impl Names {
    /// The user's name of `var`.
    pub fn of(&self, var: Var) -> String {
        let (list, index) = match var {
            Var::State(i) => (&self.states, i),
            Var::Param(i) => (&self.params, i),
            Var::Input(i) => (&self.inputs, i),
        };
        list.get(index)
            .cloned()
            .unwrap_or_else(|| format!("{var:?}"))
    }
}
