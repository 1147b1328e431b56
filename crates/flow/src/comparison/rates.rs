//! Rates of states with their slopes, and what depends on what.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: states, modes, groups and quantities are named by positions in the model's lists"
)]

use crate::form::surfaces::Surfaces;
use crate::system::agree_on_guards;
use std::ops::Range;
use veribound_interval::Interval;
use veribound_model::{ExprId, Graph, Layout, Model, Tape, Var};

/// States that switch together.
#[derive(Debug, Clone)]
pub(super) struct Group {
    pub(super) states: Vec<usize>,
    pub(super) modes: Range<usize>,
    /// The surfaces that its guards ask for.
    pub(super) surfaces: Vec<usize>,
}

impl Group {
    pub(super) fn all(model: &Model, surfaces: &Surfaces) -> Vec<Group> {
        let groups = model.groups.iter().map(|group| {
            let mut asked = Vec::new();
            for mode in group.modes.clone() {
                surfaces.modes[mode].surfaces(&mut asked);
            }
            Group {
                states: group.states.clone(),
                modes: group.modes.clone(),
                surfaces: asked,
            }
        });
        groups.collect()
    }
}

/// One rate of a state.
#[derive(Debug, Clone)]
pub(super) struct Rate {
    pub(super) expr: ExprId,
    value: Tape,
    /// The quantities it depends on.
    pub(super) by: Vec<usize>,
    slopes: Tape,
}

impl Rate {
    fn compile(graph: &mut Graph, layout: Layout, expr: ExprId) -> Rate {
        let by = graph.variables(expr);
        let slopes: Vec<ExprId> = by.iter().map(|var| graph.derivative(expr, *var)).collect();
        Rate {
            expr,
            value: Tape::compile(graph, layout, &[expr]),
            by: by.into_iter().map(|var| layout.index(var)).collect(),
            slopes: Tape::compile(graph, layout, &slopes),
        }
    }

    /// Its values on a box, where it is continuous all over it.
    pub(super) fn value(&self, quantities: &[Interval]) -> Option<Interval> {
        let mut registers = self.value.registers();
        let regular = self.value.eval(quantities, &mut registers);
        regular
            .is_continuous()
            .then(|| self.value.output::<Interval>(0, &registers))
    }

    /// Its slopes on a box, one for every quantity of `by`.
    pub(super) fn slopes(&self, quantities: &[Interval]) -> Vec<Interval> {
        let mut registers = self.slopes.registers();
        self.slopes.eval(quantities, &mut registers);
        let slopes = 0..self.by.len();
        slopes
            .map(|index| self.slopes.output::<Interval>(index, &registers))
            .collect()
    }
}

/// The rates that the modes of a model give its states.
#[derive(Debug, Clone)]
pub(super) struct Rates {
    /// The distinct rates of every state.
    pub(super) list: Vec<Vec<Rate>>,
    /// For every mode the states it governs, each with a position in `list[state]`.
    pub(super) of_mode: Vec<Vec<(usize, usize)>>,
}

impl Rates {
    pub(super) fn compile(graph: &mut Graph, model: &Model) -> Rates {
        let layout = model.layout();
        let mut rates: Vec<Vec<(usize, ExprId)>> = (0..model.modes.len())
            .map(|mode| model.governed(mode).collect())
            .collect();
        agree_on_guards(graph, model, &mut rates);
        let mut list: Vec<Vec<Rate>> = vec![Vec::new(); layout.states];
        let mut of_mode = Vec::with_capacity(rates.len());
        for governed in rates {
            let mut own = Vec::with_capacity(governed.len());
            for (state, rate) in governed {
                let rate = graph.elementary(rate);
                let known = list[state].iter().position(|known| known.expr == rate);
                let position = known.unwrap_or_else(|| {
                    list[state].push(Rate::compile(graph, layout, rate));
                    list[state].len() - 1
                });
                own.push((state, position));
            }
            of_mode.push(own);
        }
        Rates { list, of_mode }
    }

    /// The rate that a mode gives a state it governs, by its position.
    pub(super) fn of(&self, mode: usize, state: usize) -> Option<usize> {
        let own = self.of_mode[mode].iter().find(|rate| rate.0 == state);
        own.map(|rate| rate.1)
    }
}

/// What the motion of every state can depend on at once: `on[state]` are quantities.
#[derive(Debug, Clone)]
pub(super) struct Influences {
    pub(super) on: Vec<Vec<usize>>,
}

impl Influences {
    pub(super) fn of(
        graph: &Graph,
        layout: Layout,
        rates: &Rates,
        surfaces: &Surfaces,
        groups: &[Group],
    ) -> Influences {
        let mut on: Vec<Vec<usize>> = vec![Vec::new(); layout.states];
        for group in groups {
            let mut guards = Vec::new();
            for surface in &group.surfaces {
                let vars: Vec<Var> = graph.variables(surfaces.list[*surface].expr);
                guards.extend(vars.into_iter().map(|var| layout.index(var)));
            }
            for state in &group.states {
                let list = &rates.list[*state];
                on[*state].extend(list.iter().flat_map(|rate| rate.by.iter().copied()));
                if list.len() > 1 {
                    on[*state].extend(guards.iter().copied());
                }
            }
        }
        for list in &mut on {
            list.sort_unstable();
            list.dedup();
        }
        Influences { on }
    }

    /// Extends a set of states by all that their motion depends on.
    pub(super) fn close(&self, kept: &mut [bool]) {
        let states = self.on.len();
        let mut open: Vec<usize> = (0..states).filter(|state| kept[*state]).collect();
        while let Some(state) = open.pop() {
            for &quantity in self.on[state].iter().filter(|quantity| **quantity < states) {
                if !std::mem::replace(&mut kept[quantity], true) {
                    open.push(quantity);
                }
            }
        }
    }
}
