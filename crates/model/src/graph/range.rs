//! Ranges of expressions, straight from the graph.

use super::{Choice, ExprId, Graph, Node, Var};
use std::collections::HashMap;
use veribound_interval::lanes::{Arithmetic, Kernel, Value};
use veribound_interval::{Interval, rational_to_interval};

impl Graph {
    /// Every value of `e` when each quantity lies in its interval.
    pub fn eval_interval(&self, e: ExprId, value: &dyn Fn(Var) -> Interval) -> Interval {
        Interval::run(Range {
            graph: self,
            of: e,
            value,
        })
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
                Node::Choose(Choice { test, yes, no }) => {
                    let (test, yes, no) = (done[&test], done[&yes], done[&no]);
                    if test.lo() > 0.0 {
                        yes
                    } else if test.hi() < 0.0 {
                        no
                    } else {
                        yes.hull(no)
                    }
                }
            };
            done.insert(at, result);
        }
        done[&self.of]
    }
}
