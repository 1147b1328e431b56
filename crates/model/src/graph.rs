//! Expressions as a shared graph: equal expressions are one node, constants are exact rationals.

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};
use std::collections::HashMap;
use veribound_interval::lanes::{Arithmetic, Kernel, Value};
use veribound_interval::{Interval, rational_to_interval};

/// A node of a [`Graph`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ExprId(u32);

impl ExprId {
    /// Position of the node; operands come before what uses them.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A quantity an expression can depend on, by its position in the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Var {
    /// Index into [`crate::Model::states`].
    State(usize),
    /// Index into [`crate::Model::params`].
    Param(usize),
    /// Index into [`crate::Model::inputs`].
    Input(usize),
}

/// Functions of one argument.
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
    /// `abs(a)`
    Abs,
    /// `sign(a)`, with the set `[-1, 1]` at zero
    Sign,
}

/// Functions of two arguments.
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
}

/// One operation of a [`Graph`].
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Node {
    /// An exact number.
    Constant(BigRational),
    /// The circle constant.
    Pi,
    /// A state, parameter or input.
    Var(Var),
    /// A function of one argument.
    Unary(Unary, ExprId),
    /// A function of two arguments.
    Binary(Binary, ExprId, ExprId),
    /// An integer power.
    Power(ExprId, i32),
}

/// Names of all quantities, to write an expression in the user's words.
#[derive(Debug, Clone, Default)]
pub struct Names {
    /// State names.
    pub states: Vec<String>,
    /// Parameter names.
    pub params: Vec<String>,
    /// Input names.
    pub inputs: Vec<String>,
}

/// A state's value at which a comparison changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Level {
    /// The state.
    pub state: usize,
    /// The value.
    pub expr: ExprId,
    /// The value, enclosed.
    pub value: Interval,
    /// The compared expression grows with the state.
    pub rising: bool,
}

/// All expressions of a model.
///
/// Building an expression simplifies it by rules that hold for all real arguments for which the
/// unsimplified expression is defined; where it was not defined, the simplified one may be, so an
/// enclosure of it still contains every value of the original.
#[derive(Debug, Clone, Default)]
pub struct Graph {
    nodes: Vec<Node>,
    ids: HashMap<Node, ExprId>,
}

/// Exponents beyond this are not folded into constants: the digits would not fit a page.
const LARGEST_FOLDED_POWER: i32 = 64;

#[allow(
    clippy::indexing_slicing,
    reason = "PROOF: every ExprId is made by `intern` of this graph, so its index is inside `nodes`"
)]
impl Graph {
    fn intern(&mut self, node: Node) -> ExprId {
        if let Some(&id) = self.ids.get(&node) {
            return id;
        }
        let id = ExprId(self.nodes.len() as u32);
        self.nodes.push(node.clone());
        self.ids.insert(node, id);
        id
    }

    /// The operation at `e`.
    pub fn node(&self, e: ExprId) -> &Node {
        &self.nodes[e.index()]
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// True when no expression was built yet.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// An exact number.
    pub fn constant(&mut self, value: BigRational) -> ExprId {
        self.intern(Node::Constant(value))
    }

    /// A small integer.
    pub fn integer(&mut self, value: i64) -> ExprId {
        self.constant(BigRational::from_integer(value.into()))
    }

    /// The circle constant.
    pub fn pi(&mut self) -> ExprId {
        self.intern(Node::Pi)
    }

    /// A state, parameter or input.
    pub fn var(&mut self, var: Var) -> ExprId {
        self.intern(Node::Var(var))
    }

    /// The number at `e`, if it is one.
    pub fn as_constant(&self, e: ExprId) -> Option<&BigRational> {
        match self.node(e) {
            Node::Constant(value) => Some(value),
            _ => None,
        }
    }

    fn is_zero(&self, e: ExprId) -> bool {
        self.as_constant(e).is_some_and(Zero::is_zero)
    }

    fn is_one(&self, e: ExprId) -> bool {
        self.as_constant(e).is_some_and(One::is_one)
    }

    fn negated(&self, e: ExprId) -> Option<ExprId> {
        match self.node(e) {
            Node::Unary(Unary::Neg, inner) => Some(*inner),
            _ => None,
        }
    }

    /// `a + b`
    pub fn add(&mut self, a: ExprId, b: ExprId) -> ExprId {
        if let (Some(x), Some(y)) = (self.as_constant(a), self.as_constant(b)) {
            let sum = x + y;
            return self.constant(sum);
        }
        if self.is_zero(a) {
            return b;
        }
        if self.is_zero(b) {
            return a;
        }
        if let Some(b) = self.negated(b) {
            return self.sub(a, b);
        }
        if let Some(a) = self.negated(a) {
            return self.sub(b, a);
        }
        self.intern(Node::Binary(Binary::Add, a.min(b), a.max(b)))
    }

    /// `a - b`
    pub fn sub(&mut self, a: ExprId, b: ExprId) -> ExprId {
        if let (Some(x), Some(y)) = (self.as_constant(a), self.as_constant(b)) {
            let difference = x - y;
            return self.constant(difference);
        }
        if a == b {
            return self.integer(0);
        }
        if self.is_zero(b) {
            return a;
        }
        if self.is_zero(a) {
            return self.neg(b);
        }
        if let Some(b) = self.negated(b) {
            return self.add(a, b);
        }
        self.intern(Node::Binary(Binary::Sub, a, b))
    }

    /// `-a`
    pub fn neg(&mut self, a: ExprId) -> ExprId {
        if let Some(x) = self.as_constant(a) {
            let negative = -x;
            return self.constant(negative);
        }
        if let Some(inner) = self.negated(a) {
            return inner;
        }
        if let Node::Binary(Binary::Sub, x, y) = *self.node(a) {
            return self.sub(y, x);
        }
        self.intern(Node::Unary(Unary::Neg, a))
    }

    /// `a * b`
    pub fn mul(&mut self, a: ExprId, b: ExprId) -> ExprId {
        if let (Some(x), Some(y)) = (self.as_constant(a), self.as_constant(b)) {
            let product = x * y;
            return self.constant(product);
        }
        if self.is_zero(a) || self.is_zero(b) {
            return self.integer(0);
        }
        if self.is_one(a) {
            return b;
        }
        if self.is_one(b) {
            return a;
        }
        if self.as_constant(a).is_some_and(|x| (-x).is_one()) {
            return self.neg(b);
        }
        if self.as_constant(b).is_some_and(|x| (-x).is_one()) {
            return self.neg(a);
        }
        match (self.negated(a), self.negated(b)) {
            (Some(a), Some(b)) => return self.mul(a, b),
            (Some(a), None) => {
                let product = self.mul(a, b);
                return self.neg(product);
            }
            (None, Some(b)) => {
                let product = self.mul(a, b);
                return self.neg(product);
            }
            (None, None) => {}
        }
        if a == b {
            return self.powi(a, 2);
        }
        self.intern(Node::Binary(Binary::Mul, a.min(b), a.max(b)))
    }

    /// `a / b`
    pub fn div(&mut self, a: ExprId, b: ExprId) -> ExprId {
        if let (Some(x), Some(y)) = (self.as_constant(a), self.as_constant(b))
            && !y.is_zero()
        {
            let quotient = x / y;
            return self.constant(quotient);
        }
        if self.is_one(b) || (self.is_zero(a) && !self.is_zero(b)) {
            return a;
        }
        if let Some(y) = self.as_constant(b)
            && !y.is_zero()
            && y.is_negative()
        {
            let positive = -y;
            let positive = self.constant(positive);
            let quotient = self.div(a, positive);
            return self.neg(quotient);
        }
        if let Some(a) = self.negated(a) {
            let quotient = self.div(a, b);
            return self.neg(quotient);
        }
        self.intern(Node::Binary(Binary::Div, a, b))
    }

    /// The smaller of `a` and `b`.
    pub fn min(&mut self, a: ExprId, b: ExprId) -> ExprId {
        self.smaller_or_larger(Binary::Min, a, b)
    }

    /// The larger of `a` and `b`.
    pub fn max(&mut self, a: ExprId, b: ExprId) -> ExprId {
        self.smaller_or_larger(Binary::Max, a, b)
    }

    fn smaller_or_larger(&mut self, which: Binary, a: ExprId, b: ExprId) -> ExprId {
        if let (Some(x), Some(y)) = (self.as_constant(a), self.as_constant(b)) {
            let pick_a = (x <= y) == (which == Binary::Min);
            return if pick_a { a } else { b };
        }
        if a == b {
            return a;
        }
        self.intern(Node::Binary(which, a.min(b), a.max(b)))
    }

    /// `a^n`
    pub fn powi(&mut self, a: ExprId, n: i32) -> ExprId {
        if n == 0 {
            return self.integer(1);
        }
        if n == 1 {
            return a;
        }
        if let Some(x) = self.as_constant(a)
            && n.abs() <= LARGEST_FOLDED_POWER
            && !(n < 0 && x.is_zero())
        {
            let power = x.pow(n);
            return self.constant(power);
        }
        if let Some(inner) = self.negated(a) {
            let power = self.powi(inner, n);
            return if n % 2 == 0 { power } else { self.neg(power) };
        }
        self.intern(Node::Power(a, n))
    }

    /// A function of one argument.
    pub fn unary(&mut self, function: Unary, a: ExprId) -> ExprId {
        if function == Unary::Neg {
            return self.neg(a);
        }
        if let Some(x) = self.as_constant(a) {
            let (zero, negative) = (x.is_zero(), x.is_negative());
            match function {
                Unary::Abs => {
                    let size = x.abs();
                    return self.constant(size);
                }
                Unary::Sign if !zero => return self.integer(if negative { -1 } else { 1 }),
                Unary::Sqrt | Unary::Sin | Unary::Tan | Unary::Atan | Unary::Tanh if zero => {
                    return a;
                }
                Unary::Exp | Unary::Cos if zero => return self.integer(1),
                _ => {}
            }
        }
        self.intern(Node::Unary(function, a))
    }

    /// A function of two arguments.
    pub fn binary(&mut self, function: Binary, a: ExprId, b: ExprId) -> ExprId {
        match function {
            Binary::Add => self.add(a, b),
            Binary::Sub => self.sub(a, b),
            Binary::Mul => self.mul(a, b),
            Binary::Div => self.div(a, b),
            Binary::Min => self.min(a, b),
            Binary::Max => self.max(a, b),
        }
    }

    /// The nodes that `roots` need, operands first.
    pub fn reachable(&self, roots: &[ExprId]) -> Vec<ExprId> {
        let mut needed = vec![false; self.nodes.len()];
        let mut open: Vec<ExprId> = roots.to_vec();
        while let Some(e) = open.pop() {
            if std::mem::replace(&mut needed[e.index()], true) {
                continue;
            }
            match *self.node(e) {
                Node::Constant(_) | Node::Pi | Node::Var(_) => {}
                Node::Unary(_, a) | Node::Power(a, _) => open.push(a),
                Node::Binary(_, a, b) => open.extend([a, b]),
            }
        }
        (0..self.nodes.len() as u32)
            .map(ExprId)
            .filter(|e| needed[e.index()])
            .collect()
    }

    /// Every quantity `e` depends on, sorted.
    pub fn variables(&self, e: ExprId) -> Vec<Var> {
        let mut found: Vec<Var> = self
            .reachable(&[e])
            .into_iter()
            .filter_map(|e| match self.node(e) {
                Node::Var(var) => Some(*var),
                _ => None,
            })
            .collect();
        found.sort();
        found
    }

    /// True when `var` occurs in `e`.
    pub fn depends_on(&self, e: ExprId, var: Var) -> bool {
        self.variables(e).contains(&var)
    }

    /// `e` with every quantity for which `replacement` gives an expression replaced by it.
    pub fn substitute(&mut self, e: ExprId, replacement: &dyn Fn(Var) -> Option<ExprId>) -> ExprId {
        let mut done: HashMap<ExprId, ExprId> = HashMap::new();
        for old in self.reachable(&[e]) {
            let new = match *self.node(old) {
                Node::Var(var) => replacement(var).unwrap_or(old),
                Node::Constant(_) | Node::Pi => old,
                Node::Unary(function, a) => {
                    let a = done[&a];
                    self.unary(function, a)
                }
                Node::Power(a, n) => {
                    let a = done[&a];
                    self.powi(a, n)
                }
                Node::Binary(function, a, b) => {
                    let (a, b) = (done[&a], done[&b]);
                    self.binary(function, a, b)
                }
            };
            done.insert(old, new);
        }
        done[&e]
    }

    /// Partial derivative of `e`.
    ///
    /// At kinks of `abs`, `min` and `max` the enclosure of the result is the generalised (Clarke)
    /// derivative, because `sign` is the set `[-1, 1]` at zero. `sign` itself jumps; its derivative
    /// is taken as zero, so the result may be used only where no `sign` in `e` can change.
    pub fn derivative(&mut self, e: ExprId, var: Var) -> ExprId {
        let zero = self.integer(0);
        let one = self.integer(1);
        let mut done: HashMap<ExprId, ExprId> = HashMap::new();
        for at in self.reachable(&[e]) {
            let slope = match *self.node(at) {
                Node::Constant(_) | Node::Pi => zero,
                Node::Var(v) => {
                    if v == var {
                        one
                    } else {
                        zero
                    }
                }
                Node::Power(a, n) => {
                    let factor = self.integer(i64::from(n));
                    let power = self.powi(a, n - 1);
                    let outer = self.mul(factor, power);
                    self.mul(outer, done[&a])
                }
                Node::Unary(function, a) => self.unary_derivative(function, a, at, done[&a]),
                Node::Binary(function, a, b) => {
                    self.binary_derivative(function, a, b, done[&a], done[&b])
                }
            };
            done.insert(at, slope);
        }
        done[&e]
    }

    fn unary_derivative(
        &mut self,
        function: Unary,
        a: ExprId,
        value: ExprId,
        da: ExprId,
    ) -> ExprId {
        if self.is_zero(da) {
            return da;
        }
        let one = self.integer(1);
        let outer = match function {
            Unary::Neg => return self.neg(da),
            Unary::Sqrt => {
                let two = self.integer(2);
                let twice = self.mul(two, value);
                return self.div(da, twice);
            }
            Unary::Exp => value,
            Unary::Ln => return self.div(da, a),
            Unary::Sin => self.unary(Unary::Cos, a),
            Unary::Cos => {
                let sine = self.unary(Unary::Sin, a);
                self.neg(sine)
            }
            Unary::Tan => {
                let square = self.powi(value, 2);
                self.add(one, square)
            }
            Unary::Atan => {
                let square = self.powi(a, 2);
                let denominator = self.add(one, square);
                return self.div(da, denominator);
            }
            Unary::Tanh => {
                let square = self.powi(value, 2);
                self.sub(one, square)
            }
            Unary::Abs => self.unary(Unary::Sign, a),
            Unary::Sign => return self.integer(0),
        };
        self.mul(outer, da)
    }

    fn binary_derivative(
        &mut self,
        function: Binary,
        a: ExprId,
        b: ExprId,
        da: ExprId,
        db: ExprId,
    ) -> ExprId {
        match function {
            Binary::Add => self.add(da, db),
            Binary::Sub => self.sub(da, db),
            Binary::Mul => {
                let left = self.mul(da, b);
                let right = self.mul(a, db);
                self.add(left, right)
            }
            Binary::Div => {
                // (a/b)' = (a' - (a/b) b') / b
                let quotient = self.div(a, b);
                let right = self.mul(quotient, db);
                let numerator = self.sub(da, right);
                if self.is_zero(numerator) {
                    numerator
                } else {
                    self.div(numerator, b)
                }
            }
            Binary::Min | Binary::Max => {
                // max(a,b) = (a + b + |a - b|)/2 and min with a minus sign, hence
                // (a' + b' ± sign(a - b) (a' - b'))/2: a at a > b, b at a < b, their segment at a tie.
                let gap = self.sub(a, b);
                let sign = self.unary(Unary::Sign, gap);
                let slope_gap = self.sub(da, db);
                let switched = self.mul(sign, slope_gap);
                let sum = self.add(da, db);
                let twice = if function == Binary::Max {
                    self.add(sum, switched)
                } else {
                    self.sub(sum, switched)
                };
                let two = self.integer(2);
                self.div(twice, two)
            }
        }
    }

    /// Where an expression crosses zero, if it is affine in one state and depends on nothing else.
    pub fn level(&mut self, e: ExprId) -> Option<Level> {
        let [Var::State(state)] = self.variables(e)[..] else {
            return None;
        };
        let slope = self.derivative(e, Var::State(state));
        let slope_value = self.as_constant(slope)?;
        if slope_value.is_zero() {
            return None;
        }
        let rising = slope_value.is_positive();
        let zero = self.integer(0);
        let at_zero = self.substitute(e, &|_| Some(zero));
        let minus = self.neg(at_zero);
        let expr = self.div(minus, slope);
        let value = self.eval_interval(expr, &|_| Interval::ENTIRE);
        value.is_bounded().then_some(Level {
            state,
            expr,
            value,
            rising,
        })
    }

    /// Every value of `e` when each quantity lies in its interval.
    pub fn eval_interval(&self, e: ExprId, value: &dyn Fn(Var) -> Interval) -> Interval {
        Interval::run(Range {
            graph: self,
            of: e,
            value,
        })
    }

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
            Node::Binary(function, a, b) => {
                let (symbol, strength, right) = match function {
                    Binary::Add => (" + ", 1, 1),
                    Binary::Sub => (" - ", 1, 2),
                    Binary::Mul => ("*", 2, 2),
                    Binary::Div => ("/", 2, 3),
                    Binary::Min | Binary::Max => {
                        let name = if *function == Binary::Min {
                            "min"
                        } else {
                            "max"
                        };
                        let a = self.show_inside(*a, names, 0);
                        let b = self.show_inside(*b, names, 0);
                        return format!("{name}({a}, {b})");
                    }
                };
                let left = self.show_inside(*a, names, strength);
                let right = self.show_inside(*b, names, right);
                (format!("{left}{symbol}{right}"), strength)
            }
        };
        if strength < outer {
            format!("({text})")
        } else {
            text
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
            Unary::Abs => "abs",
            Unary::Sign => "sign",
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
            Unary::Abs => A::abs(a),
            Unary::Sign => A::sign(a),
        }
    }
}

impl Binary {
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
        }
    }
}

/// [`Graph::eval_interval`]
struct Range<'a> {
    graph: &'a Graph,
    of: ExprId,
    value: &'a dyn Fn(Var) -> Interval,
}

#[allow(
    clippy::indexing_slicing,
    reason = "PROOF: `reachable` lists operands before what uses them"
)]
impl Kernel<Interval> for Range<'_> {
    type Output = Interval;

    #[inline(always)]
    fn run<A: Arithmetic<Value = Interval>>(self) -> Interval {
        let mut done: HashMap<ExprId, Interval> = HashMap::new();
        for at in self.graph.reachable(&[self.of]) {
            let result = match *self.graph.node(at) {
                Node::Constant(ref exact) => rational_to_interval(exact),
                Node::Pi => Interval::PI,
                Node::Var(var) => (self.value)(var),
                Node::Unary(function, a) => function.apply::<A>(&done[&a]),
                Node::Binary(function, a, b) => function.apply::<A>(&done[&a], &done[&b]),
                Node::Power(a, n) => done[&a].powi(n),
            };
            done.insert(at, result);
        }
        done[&self.of]
    }
}
