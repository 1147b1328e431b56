//! Set-valued functions become modes.
//!
//! `sign(e)` is `+1` where `e >= 0` and `-1` where `e <= 0`: at `e = 0` both modes are active, and
//! the convex hull of the two right-hand sides is the set that `sign(0) = [-1, 1]` gives.
//! `friction(v, d, T)` is dry friction of level `T` at velocity `v` under the drive `d`: `T` and
//! `-T` in the sliding modes, and `d` itself while it can hold, at `v = 0` and `|d| <= T`. With a
//! fourth argument it holds up to that level; the closures of the sliding modes contain `v = 0`, so where
//! the drive is between the two levels the mass may also start: both solutions are enclosed.
//! `if c then a else b` is a mode with `a` where `c` holds and one with `b` elsewhere; on the border both
//! are active.

use crate::file::lower::{Lowering, Switch, both, either, negated};
use crate::graph::{ExprId, Graph, Unary, Var};
use crate::model::{Guard, Mode, Relation};
use num_traits::Zero;

/// A model with more modes than this is refused: five frictions that multiply, or eighty that do not.
pub const MOST_MODES: usize = 243;

/// One way a set-valued function can be.
struct Branch {
    name: &'static str,
    guard: Guard,
    value: ExprId,
    /// A state with what it equals in this branch.
    fixed: Option<(Var, ExprId)>,
}

/// States that switch together: those whose right-hand sides share a set-valued function, or a
/// condition. States that do not switch join the only group there is; beside several groups they are
/// one of their own, the last.
pub(crate) fn groups(lowering: &Lowering, der: &[ExprId]) -> Vec<Vec<usize>> {
    let mut switching: Vec<(Vec<usize>, Vec<Question>)> = Vec::new();
    let mut smooth = Vec::new();
    for (state, e) in der.iter().enumerate() {
        let used = lowering.switches_in(*e);
        if used.is_empty() {
            smooth.push(state);
            continue;
        }
        let asked = used.into_iter().map(|index| Question::of(lowering, index));
        let mut group = (vec![state], asked.collect::<Vec<_>>());
        switching.retain_mut(|known| {
            let shares = known.1.iter().any(|question| group.1.contains(question));
            if shares {
                group.0.append(&mut known.0);
                group.1.append(&mut known.1);
            }
            !shares
        });
        switching.push(group);
    }
    let mut groups: Vec<Vec<usize>> = switching.into_iter().map(|(states, _)| states).collect();
    match &mut groups[..] {
        [only] => only.append(&mut smooth),
        _ if smooth.is_empty() => {}
        _ => groups.push(smooth),
    }
    for group in &mut groups {
        group.sort_unstable();
    }
    groups
}

/// What decides between modes; the answer is the same wherever it is asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Question {
    Condition(usize),
    Switch(usize),
}

impl Question {
    fn of(lowering: &Lowering, index: usize) -> Question {
        match lowering.switches.get(index) {
            Some(Switch::Choice { condition, .. }) => Question::Condition(*condition),
            _ => Question::Switch(index),
        }
    }
}

/// The modes of a group of states that one written mode (name, guard, right-hand sides of all states)
/// stands for: one for each combination of branches of the set-valued functions in the right-hand
/// sides of the group.
///
/// # Errors
/// The number of modes, if it is more than [`MOST_MODES`].
pub(crate) fn expand(
    lowering: &mut Lowering,
    (name, guard, all): (&str, &Guard, &[ExprId]),
    group: &[usize],
    notes: &mut Vec<String>,
) -> Result<Vec<Mode>, usize> {
    let of = |state: &usize| all.get(*state).copied();
    let der: Vec<ExprId> = group.iter().filter_map(of).collect();
    let mut used: Vec<usize> = der.iter().flat_map(|e| lowering.switches_in(*e)).collect();
    used.sort_unstable();
    used.dedup();
    let mut asked = Vec::new();
    let mut count = 1_usize;
    for index in &used {
        count = count.saturating_mul(match lowering.switches.get(*index) {
            Some(Switch::Friction { .. }) => 3,
            // One answer to a condition is the answer for every `if` that asks it.
            Some(Switch::Choice { condition, .. }) if asked.contains(condition) => 1,
            Some(Switch::Choice { condition, .. }) => {
                asked.push(*condition);
                2
            }
            _ => 2,
        });
    }
    if count > MOST_MODES {
        return Err(count);
    }
    let mut modes = Vec::new();
    for number in 0..count {
        modes.push(combination(lowering, name, guard, &der, &used, number));
    }
    if let ([index], "") = (used.as_slice(), name) {
        notes.extend(sliding_note(lowering, *index, all));
    }
    Ok(modes)
}

/// Mode `number`: its digits pick one branch of each set-valued function.
fn combination(
    lowering: &mut Lowering,
    name: &str,
    guard: &Guard,
    der: &[ExprId],
    used: &[usize],
    mut number: usize,
) -> Mode {
    let mut values: Vec<(Var, ExprId)> = Vec::new();
    let mut fixed: Vec<(Var, ExprId)> = Vec::new();
    // Conditions with the answers given.
    let mut answers: Vec<(usize, usize)> = Vec::new();
    let mut guard = guard.clone();
    let mut names: Vec<&str> = if name.is_empty() {
        Vec::new()
    } else {
        vec![name]
    };
    for &index in used {
        // Arguments of a set-valued function hold only set-valued functions met before it, so
        // their placeholders are replaced already.
        let Some(switch) = lowering.switches.get(index).copied() else {
            continue;
        };
        let branches = branches(lowering, switch, &values);
        let count = branches.len();
        if let Switch::Choice { condition, .. } = switch {
            let known = answers.iter().find(|(asked, _)| *asked == condition);
            if let Some(branch) = known.and_then(|(_, answer)| branches.get(*answer)) {
                values.push((lowering.placeholder(index), branch.value));
                continue;
            }
            answers.push((condition, number % count));
        }
        if let Some(branch) = branches.into_iter().nth(number % count) {
            names.push(branch.name);
            guard = both(guard, branch.guard);
            values.push((lowering.placeholder(index), branch.value));
            // One state is fixed by one branch only; a second equation for it stays as it is.
            if let Some((state, value)) = branch.fixed
                && fixed.iter().all(|(known, old)| {
                    *known != state
                        && !lowering.graph.depends_on(*old, state)
                        && !lowering.graph.depends_on(value, *known)
                })
            {
                fixed.push((state, value));
            }
        }
        number /= count;
    }
    let mut equations = Vec::new();
    for e in der {
        let e = lowering.replaced(*e, &values);
        equations.push(lowering.replaced(e, &fixed));
    }
    let name = if names.is_empty() {
        "smooth".to_string()
    } else {
        names.join("+")
    };
    Mode {
        name,
        guard,
        der: equations,
    }
}

fn branches(lowering: &mut Lowering, switch: Switch, values: &[(Var, ExprId)]) -> Vec<Branch> {
    match switch {
        Switch::Sign(argument) => {
            let argument = lowering.replaced(argument, values);
            let mut branch = |name, relation, value| Branch {
                name,
                guard: Guard::Atom {
                    expr: argument,
                    relation,
                },
                value: lowering.graph.integer(value),
                fixed: None,
            };
            vec![
                branch("positive", Relation::GreaterEqual, 1),
                branch("negative", Relation::LessEqual, -1),
            ]
        }
        Switch::Choice { condition, yes, no } => {
            let guard = lowering.conditions.get(condition).cloned();
            let guard = guard.unwrap_or(Guard::Always);
            let otherwise = negated(&guard);
            let branch = |name, guard, value| Branch {
                name,
                guard,
                value,
                fixed: None,
            };
            vec![
                branch("then", guard, lowering.replaced(yes, values)),
                branch("else", otherwise, lowering.replaced(no, values)),
            ]
        }
        Switch::Friction {
            velocity,
            drive,
            sliding,
            breakaway,
        } => {
            let velocity = lowering.replaced(velocity, values);
            let drive = lowering.replaced(drive, values);
            let sliding = lowering.replaced(sliding, values);
            let breakaway = lowering.replaced(breakaway, values);
            let graph = &mut lowering.graph;
            let against = graph.neg(sliding);
            let lowest = graph.neg(breakaway);
            let above = graph.sub(drive, breakaway);
            let below = graph.sub(drive, lowest);
            let size = graph.unary(Unary::Abs, drive);
            let beyond = graph.sub(size, breakaway);
            let atom = |expr, relation| Guard::Atom { expr, relation };
            let breaks = |relation, excess, side| {
                both(atom(velocity, Relation::Equal), atom(excess, side)).with(velocity, relation)
            };
            let fixed = holding(graph, velocity);
            vec![
                Branch {
                    name: "forward",
                    guard: breaks(Relation::Greater, above, Relation::Greater),
                    value: sliding,
                    fixed: None,
                },
                Branch {
                    name: "stick",
                    guard: both(
                        atom(velocity, Relation::Equal),
                        atom(beyond, Relation::LessEqual),
                    ),
                    value: drive,
                    fixed,
                },
                Branch {
                    name: "backward",
                    guard: breaks(Relation::Less, below, Relation::Less),
                    value: against,
                    fixed: None,
                },
            ]
        }
    }
}

impl Guard {
    /// `velocity relation 0 or self`.
    fn with(self, velocity: ExprId, relation: Relation) -> Guard {
        either(
            Guard::Atom {
                expr: velocity,
                relation,
            },
            self,
        )
    }
}

/// The state that `velocity = 0` fixes, with its value: for `v - 0.2` the state `v` is `0.2`.
///
/// Only a velocity that is `slope * state + rest` is used, with a constant slope and a rest without
/// that state; there the equation has exactly one solution.
fn holding(graph: &mut Graph, velocity: ExprId) -> Option<(Var, ExprId)> {
    for var in graph.variables(velocity) {
        if !matches!(var, Var::State(_)) {
            continue;
        }
        let slope = graph.derivative(velocity, var);
        if graph.as_constant(slope).is_none_or(Zero::is_zero) {
            continue;
        }
        let zero = graph.integer(0);
        let rest = graph.substitute(velocity, &|v| (v == var).then_some(zero));
        if graph.depends_on(rest, var) {
            continue;
        }
        let root = graph.div(rest, slope);
        return Some((var, graph.neg(root)));
    }
    None
}

/// States that the stick mode is the Filippov sliding mode, where that is proved: the right-hand
/// side is affine in the friction value, which in stick lies between the two sliding values, and it
/// leaves the velocity at zero.
fn sliding_note(lowering: &mut Lowering, index: usize, der: &[ExprId]) -> Option<String> {
    let Some(Switch::Friction {
        velocity,
        drive,
        sliding,
        breakaway,
    }) = lowering.switches.get(index).copied()
    else {
        return None;
    };
    if sliding != breakaway {
        // It holds against more than sliding friction does.
        return None;
    }
    let placeholder = lowering.placeholder(index);
    let fixed = holding(&mut lowering.graph, velocity)?;
    let graph = &mut lowering.graph;
    let mut drift = graph.integer(0);
    for (state, e) in der.iter().enumerate() {
        let slope = graph.derivative(*e, placeholder);
        if graph.depends_on(slope, placeholder) {
            return None;
        }
        let stuck = graph.substitute(*e, &|v| (v == placeholder).then_some(drive));
        let stuck = graph.substitute(stuck, &|v| (v == fixed.0).then_some(fixed.1));
        let gradient = graph.derivative(velocity, Var::State(state));
        let term = graph.mul(gradient, stuck);
        drift = graph.add(drift, term);
    }
    graph
        .as_constant(drift)
        .is_some_and(Zero::is_zero)
        .then(|| "stick is the Filippov sliding mode of forward and backward (proved)".to_string())
}
