//! Calls of functions, and what tables, saturation and dead zones stand for.

use super::{Lowering, Switch, undefined};
use crate::graph::{Binary, ExprId, Unary};
use crate::syntax::Problem;
use crate::syntax::ast::{Ast, Function};
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

impl Lowering<'_> {
    pub(super) fn call(
        &mut self,
        function: Function,
        arguments: &[Ast],
        ast: &Ast,
        problems: &mut Vec<Problem>,
    ) -> Option<ExprId> {
        let values: Vec<Option<ExprId>> = arguments
            .iter()
            .map(|argument| self.value(argument, problems))
            .collect();
        let values: Vec<ExprId> = values.into_iter().collect::<Option<_>>()?;
        match (function, values.as_slice()) {
            (Function::Plain(Unary::Sign), [a]) if self.depends_on_state(*a) => {
                Some(self.switch(Switch::Sign(*a)))
            }
            (Function::Plain(plain), [a]) => {
                let constant = self.graph.as_constant(*a);
                let outside = constant.is_some_and(|c| is_outside(plain, c));
                if outside {
                    let what = format!("`{}` of a number outside of its domain", plain.name());
                    problems.push(undefined(&what, ast, "undefined"));
                    return None;
                }
                Some(self.graph.unary(plain, *a))
            }
            (Function::Min | Function::Max, [first, rest @ ..]) => {
                let mut result = *first;
                for value in rest {
                    result = match function {
                        Function::Min => self.graph.min(result, *value),
                        _ => self.graph.max(result, *value),
                    };
                }
                Some(result)
            }
            (Function::LogTo(base), [a]) => {
                let base = self.graph.integer(base);
                let (above, below) = (
                    self.graph.unary(Unary::Ln, *a),
                    self.graph.unary(Unary::Ln, base),
                );
                Some(self.graph.div(above, below))
            }
            (Function::Ceil, [a]) => Some(self.ceil(*a)),
            (Function::Round, [a]) => Some(self.round(*a)),
            (Function::Trunc, [a]) => {
                let zero = self.graph.integer(0);
                let (below, above) = (self.graph.unary(Unary::Floor, *a), self.ceil(*a));
                let (positive, negative) =
                    (self.graph.max(below, zero), self.graph.min(above, zero));
                Some(self.graph.add(positive, negative))
            }
            (Function::Atan2, [y, x]) => {
                let is_zero = |e| self.graph.as_constant(e).is_some_and(Zero::is_zero);
                if is_zero(*y) && is_zero(*x) {
                    problems.push(undefined("the angle of the origin", ast, "undefined"));
                    return None;
                }
                Some(self.graph.binary(Binary::Atan2, *y, *x))
            }
            (Function::Saturation | Function::DeadZone, [x, limits @ ..]) => {
                let (lower, upper) = match limits {
                    [limit] => (self.graph.neg(*limit), *limit),
                    [lower, upper] => (*lower, *upper),
                    _ => return None,
                };
                if self.are_reversed(lower, upper) {
                    problems.push(Problem::new(
                        "E0231",
                        "the lower limit is above the upper one",
                        ast.range.clone(),
                        "limits in the wrong order",
                        "write the lower limit first",
                    ));
                    return None;
                }
                Some(match function {
                    Function::Saturation => self.saturation(*x, lower, upper),
                    _ => self.dead_zone(*x, lower, upper),
                })
            }
            (Function::Table, [x, points @ ..]) => self.table(*x, points, arguments, ast, problems),
            (Function::Friction, [velocity, drive, sliding, rest @ ..]) => {
                let (velocity, drive, sliding) = (*velocity, *drive, *sliding);
                let breakaway = rest.first().copied().unwrap_or(sliding);
                if !self.depends_on_state(velocity) {
                    problems.push(Problem::new(
                        "E0219",
                        "the velocity of `friction` depends on no state",
                        arguments.first().unwrap_or(ast).range.clone(),
                        "expected a velocity",
                        "write friction(velocity, drive, level)",
                    ));
                    return None;
                }
                Some(self.switch(Switch::Friction {
                    velocity,
                    drive,
                    sliding,
                    breakaway,
                }))
            }
            // A wrong number of arguments was reported by the parser.
            _ => None,
        }
    }

    fn ceil(&mut self, a: ExprId) -> ExprId {
        let minus = self.graph.neg(a);
        let floor = self.graph.unary(Unary::Floor, minus);
        self.graph.neg(floor)
    }

    /// The nearest integer: halves of numbers go away from zero, as in C and MATLAB; for all else a half is
    /// a jump, where the set of both neighbours leaves nothing to be chosen.
    fn round(&mut self, a: ExprId) -> ExprId {
        if let Some(number) = self.graph.as_constant(a) {
            let nearest = number.round();
            return self.graph.constant(nearest);
        }
        let half = self.graph.constant(BigRational::new(1.into(), 2.into()));
        let above = self.graph.add(a, half);
        self.graph.unary(Unary::Floor, above)
    }

    fn are_reversed(&self, lower: ExprId, upper: ExprId) -> bool {
        let ends = (self.graph.as_constant(lower), self.graph.as_constant(upper));
        matches!(ends, (Some(lower), Some(upper)) if lower > upper)
    }

    fn saturation(&mut self, x: ExprId, lower: ExprId, upper: ExprId) -> ExprId {
        let above = self.graph.max(x, lower);
        self.graph.min(above, upper)
    }

    /// Zero between the limits, beyond them the distance to them.
    fn dead_zone(&mut self, x: ExprId, lower: ExprId, upper: ExprId) -> ExprId {
        let zero = self.graph.integer(0);
        let (above, below) = (self.graph.sub(x, upper), self.graph.sub(x, lower));
        let (above, below) = (self.graph.max(above, zero), self.graph.min(below, zero));
        self.graph.add(above, below)
    }

    /// Straight lines between points, constant beyond the first and the last; two points above each
    /// other are a jump.
    ///
    /// As a sum of saturated pieces, one per line: where the table is monotone so is each piece, and
    /// ranges stay tight.
    fn table(
        &mut self,
        x: ExprId,
        points: &[ExprId],
        arguments: &[Ast],
        ast: &Ast,
        problems: &mut Vec<Problem>,
    ) -> Option<ExprId> {
        let (pairs, []) = points.as_chunks::<2>() else {
            problems.push(Problem::new(
                "E0114",
                "the last point of the table has no value",
                arguments.last().unwrap_or(ast).range.clone(),
                "no value for this",
                "write points in pairs: table(x, x0, y0, x1, y1, ...)",
            ));
            return None;
        };
        let mut sum = pairs.first()?[1];
        let (mut jumped, mut fine) = (false, true);
        for (pair, position) in pairs.windows(2).zip((3..).step_by(2)) {
            let [[from, before], [to, after]] = *pair else {
                continue;
            };
            let width = self.graph.sub(to, from);
            let width = self.graph.as_constant(width).cloned();
            let rise = self.graph.sub(after, before);
            let piece = match width {
                Some(width) if width.is_positive() => {
                    let run = self.graph.constant(width);
                    let slope = self.graph.div(rise, run);
                    let along = self.saturation(x, from, to);
                    let along = self.graph.sub(along, from);
                    jumped = false;
                    self.graph.mul(slope, along)
                }
                Some(width) if width.is_zero() && !jumped => {
                    jumped = true;
                    self.step_at(x, from, rise)
                }
                _ => {
                    problems.push(Problem::new(
                        "E0230",
                        "the points of the table are not in order",
                        arguments.get(position).unwrap_or(ast).range.clone(),
                        "not a number above the one before",
                        "write numbers that grow; a number may stand twice for a jump",
                    ));
                    fine = false;
                    continue;
                }
            };
            sum = self.graph.add(sum, piece);
        }
        fine.then_some(sum)
    }

    /// 0 below `at`, `rise` above it, everything between at it.
    fn step_at(&mut self, x: ExprId, at: ExprId, rise: ExprId) -> ExprId {
        let gap = self.graph.sub(x, at);
        let side = if self.depends_on_state(gap) {
            self.switch(Switch::Sign(gap))
        } else {
            self.graph.unary(Unary::Sign, gap)
        };
        let (one, two) = (self.graph.integer(1), self.graph.integer(2));
        let double = self.graph.add(one, side);
        let share = self.graph.div(double, two);
        self.graph.mul(rise, share)
    }
}

/// Whether a function has no value at a number.
fn is_outside(function: Unary, x: &BigRational) -> bool {
    let one = BigRational::one();
    match function {
        Unary::Sqrt => x.is_negative(),
        Unary::Ln => !x.is_positive(),
        Unary::Asin | Unary::Acos => x.abs() > one,
        Unary::Acosh => *x < one,
        Unary::Atanh => x.abs() >= one,
        _ => false,
    }
}
