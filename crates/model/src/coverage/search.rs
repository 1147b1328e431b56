//! Does a cell contain a point of the domain?

use crate::coverage::affine::Affine;
use crate::coverage::cells::Piece;
use crate::graph::{ExprId, Graph, Names, Node, Var};
use num_rational::BigRational;
use num_traits::Zero;
use std::collections::VecDeque;
use veribound_interval::{Interval, Truth, rational_to_interval, text};

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
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Example(pub Vec<(Var, Interval)>);

impl Example {
    /// The box rounded inward, so that it stays inside of what was proved.
    pub fn describe(&self, names: &Names) -> Option<String> {
        let mut parts = Vec::new();
        for (var, value) in &self.0 {
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
    let Some(question) = Question::of(graph, conditions, domain) else {
        return Settled::Empty;
    };
    let mut is_complete = true;
    let found = question.boxes(graph, question.start.clone(), budget, 1, &mut is_complete);
    match found.into_iter().next() {
        Some(example) => Settled::Contains(example),
        None if is_complete => Settled::Empty,
        None => Settled::Unknown,
    }
}

/// At most `most` boxes of the domain all points of which are in all pieces, the largest first; boxes with an
/// inside, as far as the domain has one.
pub(crate) fn inside(
    graph: &mut Graph,
    pieces: &[Piece],
    domain: &Domain,
    (budget, most): (usize, usize),
) -> Vec<Example> {
    let conditions = pieces.iter().cloned();
    let conditions = conditions
        .map(|piece| Condition::of(graph, piece))
        .collect();
    let Some(question) = Question::of(graph, conditions, domain) else {
        return Vec::new();
    };
    let start = question.narrowed(graph);
    let mut sides = start.iter().zip(&question.start);
    if sides.any(|(narrow, whole)| narrow.is_point() && !whole.is_point()) {
        return Vec::new();
    }
    question.boxes(graph, start, budget, most, &mut true)
}

/// Conditions on quantities in their domain.
struct Question {
    conditions: Vec<Condition>,
    vars: Vec<Var>,
    start: Vec<Interval>,
}

impl Question {
    /// `None` when a condition holds nowhere.
    fn of(graph: &Graph, conditions: Vec<Condition>, domain: &Domain) -> Option<Question> {
        let mut open = Vec::new();
        for condition in conditions {
            match graph.as_constant(condition.expr) {
                Some(value) if condition.admits(value) => {}
                Some(_) => return None,
                None => open.push(condition),
            }
        }
        let vars = open
            .iter()
            .flat_map(|condition| graph.variables(condition.expr));
        let mut vars: Vec<Var> = vars.collect();
        vars.sort();
        vars.dedup();
        Some(Question {
            start: vars.iter().map(|var| domain.interval(*var)).collect(),
            conditions: open,
            vars,
        })
    }

    /// The domain without what conditions on one quantity exclude.
    fn narrowed(&self, graph: &Graph) -> Vec<Interval> {
        let mut narrow = self.start.clone();
        for condition in &self.conditions {
            let Node::Var(var) = graph.node(condition.expr) else {
                continue;
            };
            let index = self.vars.iter().position(|known| known == var);
            let Some(value) = index.and_then(|index| narrow.get_mut(index)) else {
                continue;
            };
            let step = |inside: f64, beyond: f64| if condition.is_closed { inside } else { beyond };
            let lower = condition.lower.as_ref().map_or(value.lo(), |end| {
                let end = rational_to_interval(end).hi();
                step(end, end.next_up())
            });
            let upper = condition.upper.as_ref().map_or(value.hi(), |end| {
                let end = rational_to_interval(end).lo();
                step(end, end.next_down())
            });
            let (lo, hi) = (value.lo().max(lower), value.hi().min(upper));
            if let Some(inner) = Interval::new(lo, hi) {
                *value = inner;
            }
        }
        narrow
    }

    /// At most `most` boxes inside of `start` in which all conditions hold everywhere, by bisection. Where
    /// the budget ends before it is known that there are no others, `is_complete` becomes false.
    fn boxes(
        &self,
        graph: &Graph,
        start: Vec<Interval>,
        budget: usize,
        most: usize,
        is_complete: &mut bool,
    ) -> Vec<Example> {
        let mut found = Vec::new();
        let mut open = VecDeque::from([start]);
        let mut left = budget;
        while let Some(values) = open.pop_front() {
            let rest = left.checked_sub(self.conditions.len().max(1));
            let Some(rest) = rest.filter(|_| found.len() < most) else {
                *is_complete = false;
                break;
            };
            left = rest;
            let (truth, undecided) = self.ask(graph, &values);
            match truth {
                Truth::False => {}
                Truth::True => {
                    let box_ = self.vars.iter().copied().zip(values);
                    found.push(Example(box_.collect()));
                }
                Truth::Unknown => match halves(&self.vars, &values, &self.start, &undecided) {
                    Some((left, right)) => open.extend([left, right]),
                    None => *is_complete = false,
                },
            }
        }
        found
    }

    /// Whether all conditions hold for all, or for no, values in a box; and the quantities in those of which
    /// that is not known.
    fn ask(&self, graph: &Graph, values: &[Interval]) -> (Truth, Vec<Var>) {
        let value = |var: Var| {
            let index = self.vars.iter().position(|known| *known == var);
            let value = index.and_then(|index| values.get(index).copied());
            value.unwrap_or(Interval::ENTIRE)
        };
        let mut all = Truth::True;
        let mut undecided = Vec::new();
        for condition in &self.conditions {
            let truth = condition.truth(graph.eval_interval(condition.expr, &value));
            if truth == Truth::Unknown {
                undecided.extend(graph.variables(condition.expr));
            }
            all = all.and(truth);
        }
        (all, undecided)
    }
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
    let conditions = done.into_iter();
    Some(
        conditions
            .map(|piece| Condition::of(graph, piece))
            .collect(),
    )
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
    fn of(graph: &mut Graph, piece: Piece) -> Condition {
        Condition {
            expr: piece.direction.build(graph),
            lower: piece.lower,
            upper: piece.upper,
            is_closed: piece.is_closed,
        }
    }

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
