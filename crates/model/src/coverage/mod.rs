//! Do the guards of the modes leave a gap?
//!
//! 1. Every comparison is written as `direction ? threshold`, where a direction is a linear
//!    combination of terms and a threshold an exact rational; `abs`, `min` and `max` are resolved
//!    into the comparisons they stand for (module `formula`).
//! 2. The thresholds cut each direction into points and open intervals. In a cell, one piece of each
//!    direction, every comparison is decided, so the claim "some guard holds" is, too. If it holds in
//!    all cells, the guards cover everything: a proof by logic alone, also where guards touch.
//! 3. A cell where no guard holds may contain no point of the domain. Bisection refutes it, or finds
//!    a box inside of it: then there is a gap, and it is proved (module `search`).

mod affine;
mod cells;
mod formula;
mod overlap;
mod search;

pub use overlap::{Doubt, Overlap, Overlaps};

use crate::coverage::cells::Cells;
use crate::coverage::search::{Domain, Settled};
use crate::graph::{Binary, Graph, Node, Unary};
use crate::model::{Coverage, Guard, Model};
use crate::{Names, Var};
use veribound_interval::Interval;

/// Where a state or input declares no domain.
const DEFAULT_REACH: f64 = 1000.0;

/// What is known about the guards.
pub(crate) enum Finding {
    /// No gap was found; how sure that is.
    Covered(Coverage),
    /// There is a gap; this says where.
    Gap(String),
}

/// Examines whether at least one of `guards` holds at every point of the model's domain.
///
/// *Cost*: bounded by budgets; a question too hard for them is answered by [`Coverage::Unproved`].
pub(crate) fn examine(model: &Model, guards: &[Guard]) -> Finding {
    if guards.contains(&Guard::Always) {
        return Finding::Covered(Coverage::Everywhere);
    }
    let mut graph = model.graph.clone();
    let names = model.names();
    let domain = Domain::of(model);
    let unproved = |why: &str| Finding::Covered(Coverage::Unproved(why.to_string()));
    let Some(cells) = Cells::of(&graph, guards) else {
        return unproved("the guards are too long");
    };
    let Some(mut uncovered) = cells.uncovered() else {
        return unproved("the guards hold too many comparisons");
    };
    let defined = definedness(&graph, guards, &domain);
    if !defined.in_domain {
        return unproved("a guard divides or takes a root or logarithm that may be undefined");
    }
    if uncovered.is_empty() {
        return Finding::Covered(if defined.everywhere {
            Coverage::Everywhere
        } else {
            in_domain(&domain)
        });
    }
    // Cells with fewest equations first: in them a box can be proved to be a gap.
    uncovered.sort_by_key(|cell| {
        cells
            .bounds(cell)
            .iter()
            .filter(|piece| piece.is_closed)
            .count()
    });
    let share = search::BUDGET / uncovered.len();
    let mut open = None;
    for cell in &uncovered {
        match search::settle(&mut graph, &cells.bounds(cell), &domain, share) {
            Settled::Empty => {}
            Settled::Contains(example) => {
                let place = cells.describe(cell, &mut graph, &names);
                return Finding::Gap(match example.describe(&names) {
                    None => place,
                    Some(example) => format!("{place} (for instance {example})"),
                });
            }
            Settled::Unknown => {
                open.get_or_insert_with(|| cells.describe(cell, &mut graph, &names));
            }
        }
    }
    match open {
        None => Finding::Covered(in_domain(&domain)),
        Some(place) => unproved(&place),
    }
}

fn in_domain(domain: &Domain) -> Coverage {
    Coverage::InDomain {
        states: domain.states.clone(),
        inputs: domain.inputs.clone(),
    }
}

struct Definedness {
    everywhere: bool,
    in_domain: bool,
}

/// Where the expressions in the guards have a value at all.
fn definedness(graph: &Graph, guards: &[Guard], domain: &Domain) -> Definedness {
    let mut roots = Vec::new();
    let mut open: Vec<&Guard> = guards.iter().collect();
    while let Some(guard) = open.pop() {
        match guard {
            Guard::Always => {}
            Guard::Atom { expr, .. } => roots.push(*expr),
            Guard::All(list) | Guard::Any(list) => open.extend(list),
        }
    }
    let mut result = Definedness {
        everywhere: true,
        in_domain: true,
    };
    for e in graph.reachable(&roots) {
        let (operand, allowed): (_, fn(Interval) -> bool) = match *graph.node(e) {
            Node::Binary(Binary::Div, _, b) => (b, |v| !v.contains(0.0)),
            Node::Power(a, n) if n < 0 => (a, |v| !v.contains(0.0)),
            Node::Unary(Unary::Sqrt, a) => (a, |v| v.lo() >= 0.0),
            Node::Unary(Unary::Ln, a) => (a, |v| v.lo() > 0.0),
            // Poles of the tangent lie at odd multiples of pi/2, which no float bounds cheaply.
            Node::Unary(Unary::Tan, a) => (a, |v| v.mag() < 1.5),
            Node::Unary(Unary::Asin | Unary::Acos, a) => (a, |v| v.mag() <= 1.0),
            Node::Unary(Unary::Atanh, a) => (a, |v| v.mag() < 1.0),
            Node::Unary(Unary::Acosh, a) => (a, |v| v.lo() >= 1.0),
            Node::Binary(Binary::Pow, a, _) => (a, |v| v.lo() > 0.0),
            // Undefined at the origin, where the other one is zero too.
            Node::Binary(Binary::Atan2, a, _) => (a, |v| !v.contains(0.0)),
            // The set value at zero makes no comparison with it a clear question.
            Node::Unary(Unary::Sign, a) => (a, |v| !v.contains(0.0)),
            _ => continue,
        };
        if graph.as_constant(operand).is_some() {
            continue;
        }
        result.everywhere = false;
        let value = graph.eval_interval(operand, &|var| domain.interval(var));
        result.in_domain &= !value.is_empty() && allowed(value);
    }
    result
}

impl Domain {
    fn of(model: &Model) -> Domain {
        let reach = Interval::new(-DEFAULT_REACH, DEFAULT_REACH).unwrap_or(Interval::ENTIRE);
        Domain {
            states: model
                .states
                .iter()
                .map(|state| state.domain.unwrap_or(reach.hull(state.init)))
                .collect(),
            inputs: model
                .inputs
                .iter()
                .map(|input| input.domain.unwrap_or(reach))
                .collect(),
            params: model.params.iter().map(|param| param.bounds).collect(),
        }
    }

    fn interval(&self, var: Var) -> Interval {
        let (list, index) = match var {
            Var::State(i) => (&self.states, i),
            Var::Input(i) => (&self.inputs, i),
            Var::Param(i) => (&self.params, i),
        };
        list.get(index).copied().unwrap_or(Interval::ENTIRE)
    }
}

impl Model {
    /// The names of all quantities, to show expressions.
    pub fn names(&self) -> Names {
        Names {
            states: self.states.iter().map(|state| state.name.clone()).collect(),
            params: self.params.iter().map(|param| param.name.clone()).collect(),
            inputs: self.inputs.iter().map(|input| input.name.clone()).collect(),
        }
    }
}
