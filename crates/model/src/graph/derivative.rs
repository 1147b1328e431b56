//! Symbolic derivatives, and what they tell about comparisons.

use super::{Binary, Choice, ExprId, Graph, Node, Unary, Var};
use num_rational::BigRational;
use num_traits::{Signed, Zero};
use std::collections::HashMap;
use veribound_interval::Interval;

/// A state's value at which a comparison changes.
///
/// Example: [`Graph`].
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

#[allow(
    clippy::indexing_slicing,
    reason = "PROOF: every ExprId is made by `intern` of this graph, so its index is inside `nodes`"
)]
impl Graph {
    /// Partial derivative of `e`.
    ///
    /// At kinks of `abs`, `min` and `max` the enclosure of the result is the generalised (Clarke)
    /// derivative, because `sign` is the set `[-1, 1]` at zero. `sign` itself jumps: the enclosure of its
    /// derivative is 0 on boxes on which it cannot change, and everything on the others
    /// ([`Unary::Impulse`]); the same holds for `floor`, `atan2` and choices. So derivatives may be taken of derivatives.
    ///
    /// Guarantee: where `e` is defined on the whole segment between two points of a box that differ in
    /// `var` alone, the enclosure of the result on the box contains the difference quotient of `e`. An empty
    /// enclosure, as of the slope of a root at exactly zero, says nothing.
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
                Node::Choose(Choice { test, yes, no }) => {
                    // Where the test can change its sign the value may jump.
                    let smooth = self.choose(test, done[&yes], done[&no]);
                    let impulse = self.unary(Unary::Impulse, test);
                    let jump = self.mul(impulse, done[&test]);
                    self.add(smooth, jump)
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
        let square = self.powi(a, 2);
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
                let denominator = self.add(one, square);
                return self.div(da, denominator);
            }
            Unary::Atanh => {
                let denominator = self.sub(one, square);
                return self.div(da, denominator);
            }
            Unary::Asin | Unary::Acos | Unary::Asinh | Unary::Acosh => {
                let under_root = match function {
                    Unary::Asinh => self.add(one, square),
                    Unary::Acosh => self.sub(square, one),
                    _ => self.sub(one, square),
                };
                let root = self.unary(Unary::Sqrt, under_root);
                let slope = self.div(da, root);
                return if function == Unary::Acos {
                    self.neg(slope)
                } else {
                    slope
                };
            }
            Unary::Sinh => self.unary(Unary::Cosh, a),
            Unary::Cosh => self.unary(Unary::Sinh, a),
            Unary::Tanh => {
                let square = self.powi(value, 2);
                self.sub(one, square)
            }
            Unary::Abs => self.unary(Unary::Sign, a),
            // Where it can change, any slope; that slope jumps as `sign` does.
            Unary::Sign | Unary::Impulse => self.unary(Unary::Impulse, a),
            Unary::Cbrt => {
                let (three, square) = (self.integer(3), self.powi(value, 2));
                let denominator = self.mul(three, square);
                return self.div(da, denominator);
            }
            Unary::Floor => self.unary(Unary::FloorSlope, a),
            // Zero without a jump, and everything with one.
            Unary::FloorSlope => {
                let two = self.integer(2);
                let twice = self.mul(two, value);
                self.sub(value, twice)
            }
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
        if self.is_zero(da) && self.is_zero(db) {
            return da;
        }
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
                let towards_a = if function == Binary::Max {
                    sign
                } else {
                    self.neg(sign)
                };
                // Where one argument is constant, the share of the other in the derivative is between 0
                // and 1; multiplied out, an undecided sign would give shares from -1/2 on.
                if self.is_zero(da) || self.is_zero(db) {
                    let one = self.integer(1);
                    let (twice_share, slope) = if self.is_zero(db) {
                        (self.add(one, towards_a), da)
                    } else {
                        (self.sub(one, towards_a), db)
                    };
                    let share = self.halved(twice_share);
                    return self.mul(share, slope);
                }
                let slope_gap = self.sub(da, db);
                let switched = self.mul(towards_a, slope_gap);
                let sum = self.add(da, db);
                let twice = self.add(sum, switched);
                self.halved(twice)
            }
            Binary::Pow => {
                // (a^b)' = b a^(b-1) a' + ln(a) a^b b'
                let one = self.integer(1);
                let lower = self.sub(b, one);
                let power = self.binary(Binary::Pow, a, lower);
                let outer = self.mul(b, power);
                let left = self.mul(outer, da);
                if self.is_zero(db) {
                    return left;
                }
                let (log, power) = (self.unary(Unary::Ln, a), self.binary(function, a, b));
                let outer = self.mul(log, power);
                let right = self.mul(outer, db);
                self.add(left, right)
            }
            Binary::Atan2 => {
                // (b a' - a b') / (a² + b²), and the step at the cut
                let (left, right) = (self.mul(b, da), self.mul(a, db));
                let numerator = self.sub(left, right);
                let squares = (self.powi(a, 2), self.powi(b, 2));
                let denominator = self.add(squares.0, squares.1);
                let slope = self.div(numerator, denominator);
                let cut = self.binary(Binary::Atan2Cut, a, b);
                self.add(slope, cut)
            }
            Binary::Atan2Cut => self.binary(function, a, b),
        }
    }

    fn halved(&mut self, e: ExprId) -> ExprId {
        let half = self.constant(BigRational::new(1.into(), 2.into()));
        self.mul(e, half)
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
}
