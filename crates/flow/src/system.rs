//! A model compiled for integration: shared, immutable.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: positions are made here from the model's own lists"
)]

use crate::guard::{GuardRegisters, Guards};
use crate::jump::{JumpRegisters, Jumps};
use crate::modes::ModeMasks;
use std::ops::Range;
use veribound_interval::Interval;
use veribound_interval::lanes::{Interval8, Mask};
use veribound_model::{
    Coefficients, Coverage, ExprId, Graph, Guard, Layout, Model, Node, Relation, SeriesTape, Tape,
    Var,
};

/// One right-hand side of one state; modes with the same expression share it.
#[derive(Debug, Clone)]
pub(crate) struct RightHandSide {
    pub(crate) expr: ExprId,
    pub(crate) value: Tape,
    /// Partial derivatives with respect to `others`, in that order.
    pub(crate) gradient: Tape,
    /// All partial derivatives are constants.
    pub(crate) linear: bool,
    /// The quantities it depends on, without the state it is the derivative of.
    pub(crate) others: Vec<usize>,
    pub(crate) series: SeriesTape,
    /// Quantities of `series`, by position.
    pub(crate) series_quantities: Vec<usize>,
    /// Positions of the states among them.
    pub(crate) moving_positions: Vec<usize>,
}

/// A model compiled for integration.
///
/// Immutable and shared between threads; what a thread writes is in its
/// [`Workspace`](crate::Workspace).
///
/// ```
/// use veribound_flow::{StepOptions, System, Workspace};
/// # use veribound_interval::{Decimal, Interval};
/// # let text = "format = 1\nstates = [\"x\"]\ninit.x = 1\nparams.k = [0.5, 1]\nder.x = \"-k*x\"\noutputs.y = \"x +- 0.01\"";
/// # let model = veribound_model::Model::from_text("decay.toml", text)?;
/// let system = System::new(&model);
/// let mut workspace = Workspace::new(&system, StepOptions::default());
/// let mut x = [model.states[0].init];
/// let dt = Decimal::parse("0.1").unwrap().to_interval();
/// system.step(&mut x, &[model.params[0].bounds], &[], dt, &mut workspace).expect("a proof");
/// // Both ends of the prior, after a tenth of a second.
/// assert!(x[0].contains((-0.05_f64).exp()) && x[0].contains((-0.1_f64).exp()));
/// assert!(x[0].width() < 0.051);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct System {
    pub(crate) layout: Layout,
    pub(crate) guards: Guards,
    /// `right_hand_sides[i]` are the distinct derivatives of state `i`.
    pub(crate) right_hand_sides: Vec<Vec<RightHandSide>>,
    /// What mode `m` gives the states it governs.
    pub(crate) governed: Vec<Vec<Choice>>,
    /// `governing[i]` are the modes that govern state `i`, each with the position in
    /// `right_hand_sides[i]` that it uses.
    pub(crate) governing: Vec<Vec<(usize, usize)>>,
    /// Modes of which at any time one acts, group by group.
    pub(crate) groups: Vec<Range<usize>>,
    /// Where the guards are proved to leave no gap; `None` when that is everywhere, or unproved
    /// (then the model's own text has to be trusted, and `check` says so).
    pub(crate) domain: Option<Domain>,
    pub(crate) jumps: Jumps,
    /// See [`System::integrals`].
    integrals: Vec<Integral>,
}

/// The right-hand side a mode gives a state.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Choice {
    pub(crate) state: usize,
    /// Position in `right_hand_sides[state]`.
    pub(crate) rhs: usize,
}

/// One state is the integral of another one in every mode, as an angle is of its angular velocity,
/// and never jumps; the other one may.
///
/// ```
/// use veribound_flow::{Integral, System};
///
/// let text = "format = 1\nstates = [\"x\", \"v\"]\ninit = { x = 0, v = 0 }\nder = { x = \"v\", v = \"-x\" }\noutputs.y = \"x +- 0.1\"";
/// let model = veribound_model::Model::from_text("m.toml", text)?;
/// assert_eq!(System::new(&model).integrals(), [Integral { state: 0, rate: 1 }]);
/// # Ok::<(), veribound_model::Diagnostics>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Integral {
    /// The state whose derivative is the other one.
    pub state: usize,
    /// The other one.
    pub rate: usize,
}

/// Intervals that states and inputs must not leave.
#[derive(Debug, Clone)]
pub(crate) struct Domain {
    pub(crate) states: Vec<Interval>,
    pub(crate) inputs: Vec<Interval>,
}

/// Registers of all tapes of a [`System`], for eight boxes side by side.
#[derive(Debug, Clone)]
pub(crate) struct Registers {
    pub(crate) value: Vec<Vec<Vec<Interval8>>>,
    pub(crate) gradient: Vec<Vec<Vec<Interval8>>>,
    /// Two per state (lower, upper bound) and right-hand side, since bounds advance side by side.
    pub(crate) series: Vec<Vec<[Coefficients<Interval8>; 2]>>,
    pub(crate) guards: GuardRegisters,
    pub(crate) jumps: JumpRegisters,
}

impl System {
    /// Compiles `model`.
    ///
    /// Cost: one symbolic derivative per right-hand side and quantity it depends on.
    pub fn new(model: &Model) -> System {
        let layout = model.layout();
        let mut graph = model.graph.clone();
        let mut derivatives: Vec<Vec<(usize, ExprId)>> = (0..model.modes.len())
            .map(|mode| model.governed(mode).collect())
            .collect();
        agree_on_guards(&mut graph, model, &mut derivatives);
        let mut right_hand_sides: Vec<Vec<RightHandSide>> = vec![Vec::new(); layout.states];
        let mut governing = vec![Vec::new(); layout.states];
        let mut governed = Vec::new();
        for (mode, der) in derivatives.iter().enumerate() {
            let mut choices = Vec::new();
            for &(state, expr) in der {
                let known = &mut right_hand_sides[state];
                let position = known.iter().position(|rhs| rhs.expr == expr);
                let rhs = position.unwrap_or_else(|| {
                    known.push(RightHandSide::compile(&mut graph, layout, state, expr));
                    known.len() - 1
                });
                governing[state].push((mode, rhs));
                choices.push(Choice { state, rhs });
            }
            governed.push(choices);
        }
        let mut integrals: Vec<Integral> = (0..layout.states)
            .filter_map(|state| match right_hand_sides[state][..] {
                [ref only] => match *graph.node(only.expr) {
                    Node::Var(Var::State(rate)) => Some(Integral { state, rate }),
                    _ => None,
                },
                _ => None,
            })
            .collect();
        let of_modes: Vec<&Guard> = model.modes.iter().map(|mode| &mode.guard).collect();
        let of_jumps: Vec<&Guard> = model.jumps.iter().map(|jump| &jump.guard).collect();
        let jumping: Vec<bool> = (0..layout.states)
            .map(|state| model.jumps_in(state))
            .collect();
        let domain = match &model.coverage {
            Coverage::InDomain { states, inputs } => Some(Domain {
                states: states.clone(),
                inputs: inputs.clone(),
            }),
            Coverage::Everywhere | Coverage::Unproved(_) => None,
        };
        let guards = Guards::compile(
            &mut graph,
            layout,
            (&of_modes, &of_jumps, &model.flows),
            &jumping,
        );
        let jumps = Jumps::compile(&mut graph, layout, model, &integrals);
        integrals.retain(|pair| !model.jumps_in(pair.state));
        System {
            layout,
            guards,
            right_hand_sides,
            governed,
            governing,
            groups: model
                .groups
                .iter()
                .map(|group| group.modes.clone())
                .collect(),
            domain,
            jumps,
            integrals,
        }
    }

    /// Where states, parameters and inputs stand in a flat list.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// Whether states can jump.
    pub fn jumps(&self) -> bool {
        !self.jumps.is_empty()
    }

    /// The pairs of states of which one is the integral of the other.
    pub fn integrals(&self) -> &[Integral] {
        &self.integrals
    }

    /// Number of modes.
    pub fn mode_count(&self) -> usize {
        self.governed.len()
    }

    pub(crate) fn registers(&self, order: usize) -> Registers {
        let per_rhs = |make: &dyn Fn(&RightHandSide) -> Vec<Interval8>| {
            self.right_hand_sides
                .iter()
                .map(|list| list.iter().map(make).collect())
                .collect()
        };
        Registers {
            value: per_rhs(&|rhs| rhs.value.registers()),
            gradient: per_rhs(&|rhs| rhs.gradient.registers()),
            series: self
                .right_hand_sides
                .iter()
                .map(|list| {
                    list.iter()
                        .map(|rhs| {
                            [
                                rhs.series.coefficients(order),
                                rhs.series.coefficients(order),
                            ]
                        })
                        .collect()
                })
                .collect(),
            guards: self.guards.registers(),
            jumps: self.jumps.registers(),
        }
    }

    /// The modes whose guard, as written, holds somewhere on the boxes `q`.
    pub(crate) fn modes_on(
        &self,
        q: &[Interval8],
        lanes: Mask,
        active: &mut ModeMasks,
        registers: &mut Registers,
    ) {
        active.clear(self.mode_count());
        for mode in 0..self.mode_count() {
            let holds = self.guards.holds_somewhere(mode, q, &mut registers.guards);
            active.insert(mode, lanes & holds);
        }
    }
}

impl RightHandSide {
    /// Where a state stands in `moving_positions`.
    pub(crate) fn moving_position(&self, state: usize) -> Option<usize> {
        self.moving_positions
            .iter()
            .position(|position| self.series_quantities[*position] == state)
    }

    fn compile(graph: &mut Graph, layout: Layout, state: usize, expr: ExprId) -> RightHandSide {
        let variables: Vec<Var> = graph
            .variables(expr)
            .into_iter()
            .filter(|var| *var != Var::State(state))
            .collect();
        let partials: Vec<ExprId> = variables
            .iter()
            .map(|var| graph.derivative(expr, *var))
            .collect();
        let series = SeriesTape::compile(graph, layout, &[expr]);
        let linear = partials
            .iter()
            .all(|partial| graph.as_constant(*partial).is_some());
        RightHandSide {
            linear,
            expr,
            value: Tape::compile(graph, layout, &[expr]),
            gradient: Tape::compile(graph, layout, &partials),
            others: variables.iter().map(|var| layout.index(*var)).collect(),
            moving_positions: series
                .quantities()
                .enumerate()
                .filter(|(_, quantity)| *quantity < layout.states)
                .map(|(position, _)| position)
                .collect(),
            series_quantities: series.quantities().collect(),
            series,
        }
    }
}

/// Makes modes share a right-hand side where their guards make them equal.
///
/// A mode whose guard demands `x_j == c` may replace its derivative of a state by the expression
/// another mode has, when both become the same once `c` is put for `x_j`: on the mode's own region
/// they are the same number, and outside of it the mode's right-hand side is never part of the
/// inclusion. The standing rig's `phi' = 0` becomes `phi' = omega` this way, so that the angle has
/// one smooth right-hand side in all modes.
#[allow(
    clippy::needless_range_loop,
    reason = "two modes are indexed by the same position"
)]
pub(crate) fn agree_on_guards(
    graph: &mut Graph,
    model: &Model,
    derivatives: &mut [Vec<(usize, ExprId)>],
) {
    for group in &model.groups {
        for mode in group.modes.clone() {
            let mut equalities = Vec::new();
            demanded_equalities(graph, &model.modes[mode].guard, &mut equalities);
            if equalities.is_empty() {
                continue;
            }
            for position in 0..group.states.len() {
                let own = put_levels(graph, derivatives[mode][position].1, &equalities);
                for other in group.modes.clone() {
                    let candidate = derivatives[other][position].1;
                    if other != mode && put_levels(graph, candidate, &equalities) == own {
                        derivatives[mode][position].1 = candidate;
                        break;
                    }
                }
            }
        }
    }
}

pub(crate) fn put_levels(graph: &mut Graph, e: ExprId, equalities: &[(usize, ExprId)]) -> ExprId {
    graph.substitute(e, &|var| {
        equalities
            .iter()
            .find(|(state, _)| var == Var::State(*state))
            .map(|(_, level)| *level)
    })
}

/// Collects `state == constant` conditions that hold wherever `guard` does.
pub(crate) fn demanded_equalities(
    graph: &mut Graph,
    guard: &Guard,
    found: &mut Vec<(usize, ExprId)>,
) {
    match guard {
        Guard::All(parts) => {
            for part in parts {
                demanded_equalities(graph, part, found);
            }
        }
        Guard::Atom {
            expr,
            relation: Relation::Equal,
        } => {
            if let Some(level) = graph.level(*expr) {
                found.push((level.state, level.expr));
            }
        }
        Guard::Atom { .. } | Guard::Any(_) | Guard::Always => {}
    }
}
