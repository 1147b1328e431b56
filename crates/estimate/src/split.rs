//! Step 2 of the observer: which box to split, along which coordinate, and where.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: coordinates are positions in the model's states and parameters, and every \
              box holds one interval for each"
)]

use crate::cell::{Cell, cut};
use crate::options::{ObserverOptions, ParameterRule};
use veribound_interval::Interval;
use veribound_model::{Binary, ExprId, Graph, Guard, Layout, Model, Node, Tape, Unary, Var};

/// A comparison in a guard that depends on parameters.
#[derive(Debug, Clone)]
struct ParameterGuard {
    difference: Tape,
    params: Vec<usize>,
}

/// One summand of a velocity, with the parameters in it that no guard compares.
#[derive(Debug, Clone)]
struct Term {
    value: Tape,
    params: Vec<usize>,
}

/// A state whose guards compare it with a constant.
#[derive(Debug, Clone)]
struct SwitchingState {
    state: usize,
    levels: Vec<Interval>,
}

/// What is known of a model about splitting.
#[derive(Debug, Clone)]
pub(crate) struct Splitter {
    layout: Layout,
    guards: Vec<ParameterGuard>,
    switching: Vec<SwitchingState>,
    /// States that an output measures directly; the widths of the others are compared with theirs.
    measured: Vec<usize>,
    /// `slopes[mode]`: derivatives of the same velocities, each with its parameter.
    slopes: Vec<Vec<(usize, Tape)>>,
    /// `terms[mode]` of the velocities of the switching states (of all states when none switches).
    terms: Vec<Vec<Term>>,
    registers: Vec<Interval>,
    prior_width: Vec<f64>,
}

impl Splitter {
    pub(crate) fn new(model: &Model) -> Splitter {
        let layout = Layout {
            states: model.states.len(),
            params: model.params.len(),
            inputs: model.inputs.len(),
        };
        let mut graph = model.graph.clone();
        let mut atoms = Vec::new();
        for mode in &model.modes {
            collect_atoms(&mode.guard, &mut atoms);
        }
        atoms.sort();
        atoms.dedup();
        let mut guards = Vec::new();
        let mut switching: Vec<SwitchingState> = Vec::new();
        for &expr in &atoms {
            let variables = graph.variables(expr);
            let params = params_of(&variables);
            if !params.is_empty() {
                let difference = Tape::compile(&graph, layout, &[expr]);
                guards.push(ParameterGuard { difference, params });
            } else if let Some(level) = graph.level(expr) {
                match switching
                    .iter_mut()
                    .find(|known| known.state == level.state)
                {
                    Some(known) => known.levels.push(level.value),
                    None => switching.push(SwitchingState {
                        state: level.state,
                        levels: vec![level.value],
                    }),
                }
            }
        }
        let guarded: Vec<usize> = guards
            .iter()
            .flat_map(|guard| guard.params.clone())
            .collect();
        let measured: Vec<usize> = model
            .outputs
            .iter()
            .filter_map(|output| match graph.node(output.expr) {
                Node::Var(Var::State(state)) => Some(*state),
                _ => match graph.variables(output.expr)[..] {
                    [Var::State(state)] => Some(state),
                    _ => None,
                },
            })
            .collect();
        if switching.is_empty() {
            let hidden = (0..layout.states).filter(|state| !measured.contains(state));
            switching = hidden
                .map(|state| SwitchingState {
                    state,
                    levels: Vec::new(),
                })
                .collect();
        }
        let moved: Vec<usize> = if switching.is_empty() {
            (0..layout.states).collect()
        } else {
            switching.iter().map(|known| known.state).collect()
        };
        let mut slopes = Vec::new();
        for mode in &model.modes {
            let mut list = Vec::new();
            for &state in &moved {
                for param in params_of(&graph.variables(mode.der[state])) {
                    let slope = graph.derivative(mode.der[state], Var::Param(param));
                    list.push((param, Tape::compile(&graph, layout, &[slope])));
                }
            }
            slopes.push(list);
        }
        let terms = model
            .modes
            .iter()
            .map(|mode| {
                let mut summands = Vec::new();
                for &state in &moved {
                    additive_terms(&graph, mode.der[state], &mut summands);
                }
                summands
                    .into_iter()
                    .filter_map(|expr| {
                        let mut params = params_of(&graph.variables(expr));
                        let free: Vec<usize> = params
                            .iter()
                            .copied()
                            .filter(|p| !guarded.contains(p))
                            .collect();
                        if !free.is_empty() {
                            params = free;
                        }
                        let value = Tape::compile(&graph, layout, &[expr]);
                        (!params.is_empty()).then_some(Term { value, params })
                    })
                    .collect()
            })
            .collect();
        Splitter {
            layout,
            guards,
            switching,
            measured,
            slopes,
            terms,
            registers: Vec::new(),
            prior_width: model
                .params
                .iter()
                .map(|param| param.bounds.width())
                .collect(),
        }
    }

    /// What splitting this box could teach, for choosing the box to split: its volume over the
    /// parameters (those with a prior) and the switching states, each as a share of `scale`. At a
    /// standstill it is zero, and splitting would teach nothing.
    pub(crate) fn volume(&self, cell: &Cell, scale: &[f64]) -> f64 {
        // It only ranks boxes, so plain floating point will do.
        let share = |coordinate: usize| {
            let x = cell.z[coordinate];
            (x.hi() - x.lo()) / scale[coordinate]
        };
        let params = self
            .prior_width
            .iter()
            .enumerate()
            .filter(|(_, width)| **width > 0.0);
        let params: f64 = params
            .map(|(param, _)| share(self.layout.states + param))
            .product();
        params
            * self
                .switching
                .iter()
                .map(|known| share(known.state))
                .product::<f64>()
    }

    /// The parts of `cell`; one part when no split is possible.
    pub(crate) fn split(
        &mut self,
        cell: &Cell,
        inputs: &[Interval],
        dt: f64,
        options: &ObserverOptions,
    ) -> Vec<Cell> {
        let mut q = cell.z.clone();
        q.extend_from_slice(inputs);
        if let Some((param, point)) = self.ambiguous_guard(&q, options.epsilon)
            && let Some(parts) = split_at(cell, self.layout.states + param, &[point])
        {
            return parts;
        }
        if let Some((state, points)) = self.wide_state(cell, dt, options)
            && let Some(parts) = split_at(cell, state, &points)
        {
            return parts;
        }
        let param = self.parameter(cell, &q, options.parameter_rule);
        param
            .and_then(|param| {
                let coordinate = self.layout.states + param;
                split_at(cell, coordinate, &[cell.z[coordinate].mid()])
            })
            .unwrap_or_else(|| vec![cell.clone()])
    }

    /// A parameter on which the truth of a guard depends, and where to cut it: just beyond the
    /// value that decides the guard for one part, else in the middle.
    fn ambiguous_guard(&mut self, q: &[Interval], epsilon: f64) -> Option<(usize, f64)> {
        let mut middle = None;
        for guard in &self.guards {
            self.registers = guard.difference.registers();
            guard.difference.eval(q, &mut self.registers);
            let difference = guard.difference.output(0, &self.registers);
            if !(difference.lo() < 0.0 && difference.hi() > 0.0) {
                continue;
            }
            for &param in &guard.params {
                let coordinate = self.layout.states + param;
                let whole = q[coordinate];
                if whole.width() <= 0.0 {
                    continue;
                }
                let reach = epsilon * self.prior_width[param];
                for half in [(0.0, f64::INFINITY), (f64::NEG_INFINITY, 0.0)] {
                    let Some(half) = Interval::new(half.0, half.1) else {
                        continue;
                    };
                    let mut part = q.to_vec();
                    if !guard
                        .difference
                        .contract(&mut part, half, &mut self.registers)
                    {
                        continue;
                    }
                    // Beyond the part's upper end the comparison has one outcome only.
                    let point = part[coordinate].hi() + reach;
                    if part[coordinate].hi() < whole.hi() && point < whole.hi() {
                        return Some((param, point));
                    }
                }
                middle.get_or_insert((param, whole.mid()));
            }
        }
        middle
    }

    /// A switching state that is wide compared with what is measured, and where to cut it.
    fn wide_state(
        &self,
        cell: &Cell,
        dt: f64,
        options: &ObserverOptions,
    ) -> Option<(usize, Vec<f64>)> {
        let reference = self
            .measured
            .iter()
            .map(|state| cell.z[*state].width())
            .fold(0.0_f64, f64::max);
        let (width, known) = self
            .switching
            .iter()
            .map(|known| (cell.z[known.state].width(), known))
            .max_by(|a, b| a.0.total_cmp(&b.0))?;
        if width <= 0.0 || width * dt * options.velocity_horizon < reference {
            return None;
        }
        let x = cell.z[known.state];
        if options.trisect && cell.modes.len() > 1 {
            let reach = 0.05 * width;
            let inside = known
                .levels
                .iter()
                .find(|level| x.lo() < level.lo() && level.hi() < x.hi());
            if let Some(level) = inside {
                return Some((known.state, vec![level.lo() - reach, level.hi() + reach]));
            }
        }
        Some((known.state, vec![x.mid()]))
    }

    /// The parameter whose width widens a velocity most, in any mode possible on the box.
    fn most_influential(&mut self, cell: &Cell, q: &[Interval]) -> Option<usize> {
        let mut best: Option<(f64, usize)> = None;
        for mode in cell.modes.iter() {
            for (param, slope) in self.slopes.get(mode).into_iter().flatten() {
                self.registers = slope.registers();
                slope.eval(q, &mut self.registers);
                let width = q[self.layout.states + param].width();
                let influence = slope.output(0, &self.registers).mag() * width;
                if influence > 0.0 && best.is_none_or(|(known, _)| influence > known) {
                    best = Some((influence, *param));
                }
            }
        }
        best.map(|(_, param)| param)
    }

    fn parameter(&mut self, cell: &Cell, q: &[Interval], rule: ParameterRule) -> Option<usize> {
        let mut terms: Vec<(usize, Interval)> = Vec::new();
        for mode in cell.modes.iter() {
            for term in self.terms.get(mode).into_iter().flatten() {
                self.registers = term.value.registers();
                term.value.eval(q, &mut self.registers);
                let value = term.value.output(0, &self.registers);
                let share = |param: &usize| {
                    let width = q[self.layout.states + param].width();
                    if width > 0.0 {
                        width / self.prior_width[*param]
                    } else {
                        0.0
                    }
                };
                let widest = term
                    .params
                    .iter()
                    .copied()
                    .filter(|param| share(param) > 0.0)
                    .max_by(|a, b| share(a).total_cmp(&share(b)));
                if let Some(param) = widest {
                    terms.push((param, value));
                }
            }
        }
        match rule {
            ParameterRule::WidestInfluence => self.most_influential(cell, q),
            ParameterRule::WidestTerm => terms
                .iter()
                .max_by(|a, b| a.1.width().total_cmp(&b.1.width()).then(b.0.cmp(&a.0)))
                .map(|(param, _)| *param),
            ParameterRule::OverlappingTerms => {
                let (last, rest) = terms.split_last()?;
                let overlap = rest
                    .iter()
                    .any(|term| term.0 != last.0 && term.1.intersects(last.1));
                Some(if overlap {
                    last.0
                } else {
                    terms.first().unwrap_or(last).0
                })
            }
        }
        .or_else(|| {
            // No velocity depends on a free parameter here: the widest share of its prior.
            let share = |param: usize| {
                let width = q[self.layout.states + param].width();
                if width > 0.0 {
                    width / self.prior_width[param]
                } else {
                    0.0
                }
            };
            (0..self.layout.params)
                .filter(|param| share(*param) > 0.0)
                .max_by(|a, b| share(*a).total_cmp(&share(*b)))
        })
    }
}

fn split_at(cell: &Cell, coordinate: usize, points: &[f64]) -> Option<Vec<Cell>> {
    let mut parts = Vec::with_capacity(points.len() + 1);
    let mut rest = cell.clone();
    for point in points {
        let Some((below, above)) = cut(rest.z[coordinate], *point) else {
            continue;
        };
        let mut part = rest.clone();
        part.z[coordinate] = below;
        rest.z[coordinate] = above;
        parts.push(part);
    }
    parts.push(rest);
    (parts.len() > 1).then_some(parts)
}

fn collect_atoms(guard: &Guard, atoms: &mut Vec<ExprId>) {
    match guard {
        Guard::Always => {}
        Guard::Atom { expr, .. } => atoms.push(*expr),
        Guard::All(parts) | Guard::Any(parts) => {
            for part in parts {
                collect_atoms(part, atoms);
            }
        }
    }
}

fn params_of(variables: &[Var]) -> Vec<usize> {
    variables
        .iter()
        .filter_map(|var| {
            if let Var::Param(param) = var {
                Some(*param)
            } else {
                None
            }
        })
        .collect()
}

fn additive_terms(graph: &Graph, e: ExprId, terms: &mut Vec<ExprId>) {
    match *graph.node(e) {
        Node::Binary(Binary::Add | Binary::Sub, a, b) => {
            additive_terms(graph, a, terms);
            additive_terms(graph, b, terms);
        }
        Node::Unary(Unary::Neg, a) => additive_terms(graph, a, terms),
        _ => terms.push(e),
    }
}
