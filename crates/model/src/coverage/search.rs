//! Does a cell contain a point of the domain?

use crate::coverage::affine::Affine;
use crate::coverage::formula::Piece;
use crate::graph::{ExprId, Graph, Names, Node, Var};
use num_rational::BigRational;
use num_traits::Zero;
use std::collections::VecDeque;
use veribound_interval::{Interval, Truth, text};

/// Conditions evaluated on boxes for one model, shared by its cells.
pub(crate) const BUDGET: usize = 20_000;

/// Values that are possible.
pub(crate) struct Domain {
    pub states: Vec<Interval>,
    pub inputs: Vec<Interval>,
    pub params: Vec<Interval>,
}

/// Answer to the question.
pub(crate) enum Settled {
    /// It contains none: proved.
    Empty,
    /// It contains all points of this box: proved.
    Contains(Example),
    Unknown,
}

/// A box of points, for the quantities that matter.
pub(crate) struct Example {
    vars: Vec<Var>,
    values: Vec<Interval>,
}

impl Example {
    /// The box rounded inward, so that it stays inside of what was proved.
    pub fn describe(&self, names: &Names) -> Option<String> {
        let mut parts = Vec::new();
        for (var, value) in self.vars.iter().zip(&self.values) {
            let (lo, hi) = (text::upper(value.lo(), 4), text::lower(value.hi(), 4));
            let ordered = lo.parse::<f64>().ok()? < hi.parse::<f64>().ok()?;
            if ordered {
                parts.push(format!("{} in [{lo}, {hi}]", names.of(*var)));
            } else if value.is_point() {
                parts.push(format!("{} = {}", names.of(*var), value.lo()));
            } else {
                return None;
            }
        }
        (!parts.is_empty()).then(|| parts.join(", "))
    }
}

/// A piece whose direction is an expression of the variables that are left.
struct Condition {
    expr: ExprId,
    lower: Option<BigRational>,
    upper: Option<BigRational>,
    is_closed: bool,
}

/// Decides whether the pieces have a common point in the domain.
pub(crate) fn settle(
    graph: &mut Graph,
    pieces: &[Piece],
    domain: &Domain,
    budget: usize,
) -> Settled {
    let Some(conditions) = eliminate(graph, pieces, domain) else {
        return Settled::Unknown;
    };
    let mut open_conditions = Vec::new();
    for condition in conditions {
        match graph.as_constant(condition.expr) {
            Some(value) if condition.admits(value) => {}
            Some(_) => return Settled::Empty,
            None => open_conditions.push(condition),
        }
    }
    let mut vars: Vec<Var> = open_conditions
        .iter()
        .flat_map(|condition| graph.variables(condition.expr))
        .collect();
    vars.sort();
    vars.dedup();
    let start: Vec<Interval> = vars.iter().map(|var| domain.interval(*var)).collect();
    let mut open = VecDeque::from([start.clone()]);
    let mut left = budget;
    while let Some(values) = open.pop_front() {
        let Some(rest) = left.checked_sub(open_conditions.len().max(1)) else {
            return Settled::Unknown;
        };
        left = rest;
        let value = |var: Var| {
            let index = vars.iter().position(|known| *known == var);
            index
                .and_then(|index| values.get(index).copied())
                .unwrap_or(Interval::ENTIRE)
        };
        let mut all = Truth::True;
        let mut undecided = Vec::new();
        for condition in &open_conditions {
            let truth = condition.truth(graph.eval_interval(condition.expr, &value));
            if truth == Truth::Unknown {
                undecided.extend(graph.variables(condition.expr));
            }
            all = all.and(truth);
        }
        match all {
            Truth::False => {}
            Truth::True => return Settled::Contains(Example { vars, values }),
            Truth::Unknown => {
                let Some((left, right)) = halves(&vars, &values, &start, &undecided) else {
                    return Settled::Unknown;
                };
                open.push_back(left);
                open.push_back(right);
            }
        }
    }
    Settled::Empty
}

/// Solves each piece that is a single value for one variable and puts it into all others; the
/// variable's domain becomes a condition. `None` when an expression grows too long.
fn eliminate(graph: &mut Graph, pieces: &[Piece], domain: &Domain) -> Option<Vec<Condition>> {
    let mut open: Vec<Piece> = pieces.to_vec();
    let mut done: Vec<Piece> = Vec::new();
    while let Some(index) = open
        .iter()
        .position(|piece| piece.is_closed && piece.lower == piece.upper)
    {
        let piece = open.swap_remove(index);
        let (Some(value), Some((term, var))) = (&piece.lower, solvable(graph, &piece.direction))
        else {
            done.push(piece);
            continue;
        };
        let (rest, factor) = piece.direction.split(term)?;
        let minus_rest = rest.scaled(&BigRational::from_integer((-1).into()));
        let right = minus_rest.plus(&Affine {
            terms: Default::default(),
            constant: value.clone(),
        });
        let root = right.scaled(&factor.recip());
        let root_expr = root.build(graph);
        for other in open.iter_mut().chain(&mut done) {
            let e = other.direction.build(graph);
            let e = graph.substitute(e, &|v| (v == var).then_some(root_expr));
            other.direction = Affine::of(graph, e)?;
        }
        let reach = domain.interval(var);
        done.push(Piece {
            direction: root,
            lower: BigRational::from_float(reach.lo()),
            upper: BigRational::from_float(reach.hi()),
            is_closed: true,
        });
    }
    done.extend(open);
    let conditions = done.into_iter().map(|piece| Condition {
        expr: piece.direction.build(graph),
        lower: piece.lower,
        upper: piece.upper,
        is_closed: piece.is_closed,
    });
    Some(conditions.collect())
}

/// A term that is a variable which occurs in no other term.
fn solvable(graph: &Graph, direction: &Affine) -> Option<(ExprId, Var)> {
    let rank = |var: &Var| match var {
        Var::State(_) => 0,
        Var::Input(_) => 1,
        Var::Param(_) => 2,
    };
    direction
        .terms
        .keys()
        .filter_map(|term| match graph.node(*term) {
            Node::Var(var) => Some((*term, *var)),
            _ => None,
        })
        .filter(|(term, var)| {
            direction
                .terms
                .keys()
                .all(|other| other == term || !graph.depends_on(*other, *var))
        })
        .min_by_key(|(_, var)| rank(var))
}

/// Halves the widest variable, measured by its domain, among those in undecided conditions.
fn halves(
    vars: &[Var],
    values: &[Interval],
    start: &[Interval],
    undecided: &[Var],
) -> Option<(Vec<Interval>, Vec<Interval>)> {
    let (index, _) = vars
        .iter()
        .zip(values)
        .zip(start)
        .enumerate()
        .filter(|(_, ((var, _), _))| undecided.contains(var))
        .map(|(index, ((_, value), start))| (index, value.width() / start.width()))
        .filter(|(_, share)| *share > 0.0)
        .max_by(|(_, a), (_, b)| a.total_cmp(b))?;
    let value = values.get(index)?;
    let middle = value.mid();
    if middle <= value.lo() || middle >= value.hi() {
        return None;
    }
    let mut left = values.to_vec();
    let mut right = values.to_vec();
    *left.get_mut(index)? = Interval::new(value.lo(), middle)?;
    *right.get_mut(index)? = Interval::new(middle, value.hi())?;
    Some((left, right))
}

impl Condition {
    /// Whether one exact value lies in the piece.
    fn admits(&self, value: &BigRational) -> bool {
        let above = self.lower.as_ref().is_none_or(|lo| {
            if self.is_closed {
                value >= lo
            } else {
                value > lo
            }
        });
        let below = self.upper.as_ref().is_none_or(|hi| {
            if self.is_closed {
                value <= hi
            } else {
                value < hi
            }
        });
        above && below
    }

    /// Whether all values, or none, lie in the piece.
    fn truth(&self, values: Interval) -> Truth {
        if values.is_empty() {
            return Truth::Unknown;
        }
        // An end that is not finite is beyond every threshold.
        let (lo, hi) = (
            BigRational::from_float(values.lo()),
            BigRational::from_float(values.hi()),
        );
        let lower = compare(&self.lower, &lo, &hi, self.is_closed);
        let mirror =
            |value: &Option<BigRational>| value.as_ref().map(|value| BigRational::zero() - value);
        let upper = compare(
            &mirror(&self.upper),
            &mirror(&hi),
            &mirror(&lo),
            self.is_closed,
        );
        lower.and(upper)
    }
}

/// Whether `threshold <= x` (or `<`) for all, or no, `x` in `[lo, hi]`; a missing end is infinite.
fn compare(
    threshold: &Option<BigRational>,
    lo: &Option<BigRational>,
    hi: &Option<BigRational>,
    is_closed: bool,
) -> Truth {
    let Some(threshold) = threshold else {
        return Truth::True;
    };
    let reaches = |x: &BigRational| {
        if is_closed {
            x >= threshold
        } else {
            x > threshold
        }
    };
    if lo.as_ref().is_some_and(reaches) {
        Truth::True
    } else if hi.as_ref().is_some_and(|hi| !reaches(hi)) {
        Truth::False
    } else {
        Truth::Unknown
    }
}
