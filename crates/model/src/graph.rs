//! Expressions as a shared graph: equal expressions are one node, constants are exact rationals.

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};
use std::collections::{HashMap, HashSet};

mod derivative;
mod elementary;
mod function;
pub(crate) mod jump;
mod range;
mod show;

pub use derivative::Level;
pub use function::{Binary, Unary};
pub use show::Names;

/// A node of a [`Graph`].
///
/// Example: [`Graph`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ExprId(u32);

impl ExprId {
    /// Position of the node; operands come before what uses them.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A quantity an expression can depend on, by its position in the model.
///
/// Example: [`Graph`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Var {
    /// Index into [`crate::Model::states`].
    State(usize),
    /// Index into [`crate::Model::params`].
    Param(usize),
    /// Index into [`crate::Model::inputs`].
    Input(usize),
}

/// One operation of a [`Graph`].
///
/// Example: [`Graph`].
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
    /// One of two, by the sign of a test.
    Choose(Choice),
}

/// `yes` where the test is positive, `no` where it is negative, both and everything between where it is
/// zero. What is not taken need not be defined.
///
/// Example: [`Graph`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Choice {
    /// What is asked.
    pub test: ExprId,
    /// The value where the test is positive.
    pub yes: ExprId,
    /// The value where the test is negative.
    pub no: ExprId,
}

/// All expressions of a model.
///
/// Building an expression simplifies it by rules that hold for all real arguments for which the
/// unsimplified expression is defined; where it was not defined, the simplified one may be, so an
/// enclosure of it still contains every value of the original.
///
/// ```
/// use veribound_interval::Interval;
/// use veribound_model::{Binary, Choice, ExprId, Graph, Level, Names, Node, Unary, Var};
///
/// let names = Names { states: vec!["v".to_owned()], ..Names::default() };
/// let mut graph = Graph::default();
/// let v: ExprId = graph.var(Var::State(0));
/// let (one, friction) = (graph.integer(1), graph.unary(Unary::Sign, v));
/// let drag = graph.binary(Binary::Mul, friction, v);
/// assert_eq!(graph.show(drag, &names), "v*sign(v)");
/// let range = graph.eval_interval(drag, &|_| Interval::new(-2.0, -1.0).unwrap());
/// assert!(range.contains(1.5));
/// assert_eq!(graph.variables(drag), [Var::State(0)]);
///
/// // A choice, and the value of the state at which it changes.
/// let test = graph.sub(v, one);
/// let choice = graph.choose(test, drag, one);
/// assert_eq!(graph.node(choice), &Node::Choose(Choice { test, yes: drag, no: one }));
/// let Level { state, value, .. } = graph.level(test).unwrap();
/// assert_eq!((state, value), (0, Interval::ONE));
/// ```
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

    /// The positive number of which `e` is the negative one.
    fn opposite(&mut self, e: ExprId) -> Option<ExprId> {
        let positive = -self.as_constant(e).filter(|x| x.is_negative())?;
        Some(self.constant(positive))
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
        if let Some(b) = self.negated(b).or_else(|| self.opposite(b)) {
            return self.sub(a, b);
        }
        if let Some(a) = self.negated(a).or_else(|| self.opposite(a)) {
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
        if let Some(b) = self.negated(b).or_else(|| self.opposite(b)) {
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
        if n == i32::MIN {
            // Its size and its neighbour below are no `i32`.
            let half = self.powi(a, n / 2);
            return self.powi(half, 2);
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
                Unary::Impulse if !zero => return self.integer(0),
                Unary::Floor => {
                    let floor = x.floor();
                    return self.constant(floor);
                }
                Unary::Sqrt
                | Unary::Cbrt
                | Unary::Sin
                | Unary::Tan
                | Unary::Asin
                | Unary::Atan
                | Unary::Sinh
                | Unary::Tanh
                | Unary::Asinh
                | Unary::Atanh
                    if zero =>
                {
                    return a;
                }
                Unary::Exp | Unary::Cos | Unary::Cosh if zero => return self.integer(1),
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
            Binary::Pow | Binary::Atan2 | Binary::Atan2Cut => {
                self.intern(Node::Binary(function, a, b))
            }
        }
    }

    /// [`Choice`]
    pub fn choose(&mut self, test: ExprId, yes: ExprId, no: ExprId) -> ExprId {
        if yes == no {
            return yes;
        }
        match self.as_constant(test) {
            Some(test) if test.is_positive() => yes,
            Some(test) if test.is_negative() => no,
            _ => self.intern(Node::Choose(Choice { test, yes, no })),
        }
    }

    /// The nodes that `roots` need, operands first.
    pub fn reachable(&self, roots: &[ExprId]) -> Vec<ExprId> {
        // What a small part of a large graph needs is found without a look at the rest.
        let mut needed: HashSet<ExprId> = HashSet::new();
        let mut open: Vec<ExprId> = roots.to_vec();
        while let Some(e) = open.pop() {
            if !needed.insert(e) {
                continue;
            }
            match *self.node(e) {
                Node::Constant(_) | Node::Pi | Node::Var(_) => {}
                Node::Unary(_, a) | Node::Power(a, _) => open.push(a),
                Node::Binary(_, a, b) => open.extend([a, b]),
                Node::Choose(Choice { test, yes, no }) => open.extend([test, yes, no]),
            }
        }
        let mut list: Vec<ExprId> = needed.into_iter().collect();
        list.sort_unstable();
        list
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
        self.rebuilt(e, &mut |_, node| match node {
            Node::Var(var) => replacement(*var),
            _ => None,
        })
    }

    /// `e` with every node for which `replace` gives an expression replaced by it; it is asked for operands
    /// first, and sees nodes with their new operands.
    fn rebuilt(
        &mut self,
        e: ExprId,
        replace: &mut dyn FnMut(&mut Graph, &Node) -> Option<ExprId>,
    ) -> ExprId {
        let mut done: HashMap<ExprId, ExprId> = HashMap::new();
        for old in self.reachable(&[e]) {
            let moved = match *self.node(old) {
                Node::Constant(_) | Node::Pi => {
                    done.insert(old, old);
                    continue;
                }
                Node::Var(var) => Node::Var(var),
                Node::Unary(function, a) => Node::Unary(function, done[&a]),
                Node::Power(a, n) => Node::Power(done[&a], n),
                Node::Binary(function, a, b) => Node::Binary(function, done[&a], done[&b]),
                Node::Choose(Choice { test, yes, no }) => Node::Choose(Choice {
                    test: done[&test],
                    yes: done[&yes],
                    no: done[&no],
                }),
            };
            let new = replace(self, &moved).unwrap_or_else(|| match moved {
                Node::Constant(_) | Node::Pi | Node::Var(_) => old,
                Node::Unary(function, a) => self.unary(function, a),
                Node::Power(a, n) => self.powi(a, n),
                Node::Binary(function, a, b) => self.binary(function, a, b),
                Node::Choose(Choice { test, yes, no }) => self.choose(test, yes, no),
            });
            done.insert(old, new);
        }
        done[&e]
    }
}
