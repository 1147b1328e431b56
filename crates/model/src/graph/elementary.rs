//! Functions of two arguments by functions of one.

use super::{Binary, ExprId, Graph, Node, Unary};

impl Graph {
    /// `e` without `atan2` and real powers, for evaluators that know functions of one argument only.
    ///
    /// Guarantee: equal to `e` wherever it is defined: not at the origin nor on the cut of an `atan2`, nor where
    /// the base of a real power is zero.
    pub fn elementary(&mut self, e: ExprId) -> ExprId {
        self.rebuilt(e, &mut |graph, node| match *node {
            Node::Binary(Binary::Pow, a, b) => {
                // a^b = exp(b log(a))
                let log = graph.unary(Unary::Ln, a);
                let product = graph.mul(b, log);
                Some(graph.unary(Unary::Exp, product))
            }
            Node::Binary(Binary::Atan2, y, x) => {
                // Half the angle is seen from the other end of the circle's diameter.
                let squares = (graph.powi(x, 2), graph.powi(y, 2));
                let sum = graph.add(squares.0, squares.1);
                let radius = graph.unary(Unary::Sqrt, sum);
                let beside = graph.add(radius, x);
                let slope = graph.div(y, beside);
                let half = graph.unary(Unary::Atan, slope);
                let two = graph.integer(2);
                Some(graph.mul(two, half))
            }
            _ => None,
        })
    }

    /// Whether an absolute value, a minimum or a maximum stands in `e`.
    pub fn has_kinks(&self, e: ExprId) -> bool {
        let nodes = self.reachable(&[e]).into_iter();
        nodes.map(|e| self.node(e)).any(|node| {
            matches!(
                node,
                Node::Unary(Unary::Abs, _) | Node::Binary(Binary::Min | Binary::Max, ..)
            )
        })
    }

    /// `e` without the absolute values, minima and maxima of which `is_positive` knows the side: it is asked
    /// for the argument of an absolute value, or for the first operand less the second one.
    ///
    /// Guarantee: equal to `e` where all that it was asked for has the sign it answered, or is zero.
    pub fn straightened(
        &mut self,
        e: ExprId,
        is_positive: &mut dyn FnMut(&Graph, ExprId) -> Option<bool>,
    ) -> ExprId {
        // Of a choice both branches are possible where the test is zero, so a side does not decide it.
        self.rebuilt(e, &mut |graph, node| match *node {
            Node::Unary(Unary::Abs, a) => match is_positive(graph, a)? {
                true => Some(a),
                false => Some(graph.neg(a)),
            },
            Node::Binary(function @ (Binary::Min | Binary::Max), a, b) => {
                let gap = graph.sub(a, b);
                let is_first = is_positive(graph, gap)? == (function == Binary::Max);
                Some(if is_first { a } else { b })
            }
            _ => None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::Var;
    use veribound_interval::Interval;

    #[test]
    fn the_values_are_the_same() {
        let mut graph = Graph::default();
        let (x, y) = (graph.var(Var::State(0)), graph.var(Var::State(1)));
        let angle = graph.binary(Binary::Atan2, y, x);
        let exponent = graph.integer(3);
        let exponent = graph.div(exponent, x);
        let square = graph.powi(x, 2);
        let power = graph.binary(Binary::Pow, square, exponent);
        let e = graph.mul(angle, power);
        let other = graph.elementary(e);
        assert!(
            graph
                .reachable(&[other])
                .into_iter()
                .all(|e| !matches!(graph.node(e), Node::Binary(Binary::Atan2 | Binary::Pow, ..)))
        );
        for (x, y) in [
            (1.0, 2.0),
            (-1.0, 2.0),
            (-1.5, -0.3),
            (2.0, -0.5),
            (3.0, 0.0),
        ] {
            let at = |e| {
                graph.eval_interval(e, &|var| match var {
                    Var::State(0) => Interval::point(x),
                    _ => Interval::point(y),
                })
            };
            let (one, two) = (at(e), at(other));
            assert!(
                !one.is_disjoint_from(two) && two.width() < 1e-12,
                "{one} {two}"
            );
        }
        // On the cut it has no value.
        let cut = graph.eval_interval(other, &|var| match var {
            Var::State(0) => Interval::point(-1.0),
            _ => Interval::ZERO,
        });
        assert!(cut.is_empty() || !cut.is_point(), "{cut}");
    }
}
