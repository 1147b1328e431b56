//! What guards imply: that an expression is not negative where conditions hold.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: quantities are named by positions in the list of the layout"
)]

use super::Comparison;
use super::levels::Place;
use super::order::direction;
use veribound_interval::Interval;
use veribound_model::{Binary, ExprId, Graph, Guard, Node, Relation, Tape, Unary, Var};

impl Comparison {
    /// A lower bound of `e` on a box, with quantities at their ends in which it is monotone; NaN where it may be undefined
    /// or jump.
    fn least(&self, graph: &mut Graph, e: ExprId, quantities: &[Interval]) -> f64 {
        let layout = self.layout;
        let tape = Tape::compile(graph, layout, &[e]);
        let mut registers = tape.registers();
        if !tape.eval(quantities, &mut registers).is_continuous() {
            return f64::NAN;
        }
        let mut corner = quantities.to_vec();
        for var in graph.variables(e) {
            let slope = graph.derivative(e, var);
            let slope = graph.eval_interval(slope, &|v| quantities[layout.index(v)]);
            let x = &mut corner[layout.index(var)];
            match direction(slope) {
                Ok(Some(true)) => *x = Interval::point(x.hi()),
                Ok(_) if !slope.is_empty() => *x = Interval::point(x.lo()),
                _ => {}
            }
        }
        tape.eval(&corner, &mut registers);
        let value = tape.output::<Interval>(0, &registers);
        if value.is_empty() {
            f64::NAN
        } else {
            value.lo()
        }
    }

    /// Whether `e >= 0` on a box, as far as all of `atoms` are not positive.
    ///
    /// Proof. Let an atom be `r w + rest` with a number `r != 0`. It is zero where `w` is `-rest / r`. On the segment from there to
    /// where it is not positive `e` changes as its slope in `w` says.
    pub(super) fn never_negative(
        &self,
        graph: &mut Graph,
        e: ExprId,
        atoms: &[ExprId],
        place: &Place,
    ) -> bool {
        let layout = self.layout;
        let value = |var: Var| place.near[layout.index(var)];
        let positive = |x: Interval| !x.is_empty() && x.lo() >= 0.0;
        if self.least(graph, e, &place.near) >= 0.0 {
            return true;
        }
        for &atom in atoms {
            for var in graph.variables(atom) {
                let slope = graph.derivative(atom, var);
                let zero = graph.integer(0);
                let rest = graph.substitute(atom, &|v| (v == var).then_some(zero));
                if slope == zero
                    || graph.as_constant(slope).is_none()
                    || graph.depends_on(rest, var)
                {
                    continue;
                }
                let root = graph.div(rest, slope);
                let root = graph.neg(root);
                let there = graph.substitute(e, &|v| (v == var).then_some(root));
                let reach = graph.eval_interval(root, &value).hull(value(var));
                let mut segment = place.near.clone();
                segment[layout.index(var)] = reach;
                let tape = Tape::compile(graph, layout, &[e]);
                if !tape.eval(&segment, &mut tape.registers()).is_continuous() {
                    continue;
                }
                let change = graph.derivative(e, var);
                let change = graph.eval_interval(change, &|v| segment[layout.index(v)]);
                // The quantity lies below the root where the atom grows with it.
                let change = match graph.eval_interval(slope, &value).lo() > 0.0 {
                    true => -change,
                    false => change,
                };
                if positive(change) && self.least(graph, there, &place.near) >= 0.0 {
                    return true;
                }
            }
        }
        false
    }
}

/// Expressions that are not positive wherever `guard` holds.
pub(super) fn conditions(graph: &mut Graph, guard: &Guard, into: &mut Vec<ExprId>) {
    match guard {
        Guard::All(parts) => {
            for part in parts {
                conditions(graph, part, into);
            }
        }
        Guard::Atom { expr, relation } => {
            let expr = graph.elementary(*expr);
            let below = matches!(
                relation,
                Relation::Less | Relation::LessEqual | Relation::Equal
            );
            let above = matches!(
                relation,
                Relation::Greater | Relation::GreaterEqual | Relation::Equal
            );
            if below {
                into.push(expr);
                // |d| - c <= 0 says that d - c <= 0 and -d - c <= 0.
                if let Node::Binary(Binary::Sub, size, limit) = *graph.node(expr)
                    && let Node::Unary(Unary::Abs, inside) = *graph.node(size)
                {
                    let over = graph.sub(inside, limit);
                    let opposite = graph.neg(inside);
                    let under = graph.sub(opposite, limit);
                    into.extend([over, under]);
                }
            }
            if above {
                let opposite = graph.neg(expr);
                into.push(opposite);
            }
        }
        Guard::Any(_) | Guard::Always => {}
    }
}
