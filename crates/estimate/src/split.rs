//! Step 2 of the observer: which box to split, along which coordinate, and where.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: coordinates are positions in the model's states and parameters, and every \
              box holds one interval for each"
)]

mod structure;
#[cfg(test)]
mod tests;

use crate::cell::{Cell, cut};
use crate::options::{ObserverOptions, ParameterRule};
use structure::{ParameterGuard, Slope, SwitchingState, Term};
use veribound_interval::Interval;
use veribound_model::{Layout, Model};

/// How far the middle one of three parts reaches beyond the level on both sides, as a share of the
/// width. Any share above zero does what the three parts are for: the outer ones do not touch the
/// level, so that one mode alone is possible on each. With a twentieth the middle part, on which
/// all modes stay possible, keeps about a tenth of the width.
const AROUND_LEVEL: f64 = 0.05;

/// What is known of a model about splitting.
#[derive(Debug, Clone)]
pub(crate) struct Splitter {
    layout: Layout,
    guards: Vec<ParameterGuard>,
    /// States that guards compare with constants; without any, the states that no output measures.
    switching: Vec<SwitchingState>,
    /// States that an output measures directly; the widths of the others are compared with theirs.
    measured: Vec<usize>,
    /// `terms[mode]` of the velocities of the switching states (of all states when none switches).
    terms: Vec<Vec<Term>>,
    /// `slopes[mode]`: derivatives of the same velocities with respect to the parameters.
    slopes: Vec<Vec<Slope>>,
    prior_width: Vec<f64>,
}

impl Splitter {
    pub(crate) fn new(model: &Model) -> Splitter {
        let layout = model.layout();
        let mut graph = model.graph.clone();
        let (guards, mut switching) = structure::comparisons(model, &mut graph, layout);
        let measured = structure::measured_states(model);
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
        Splitter {
            layout,
            terms: structure::terms(model, layout, &moved, &guards),
            slopes: structure::slopes(model, &mut graph, layout, &moved),
            guards,
            switching,
            measured,
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
        for guard in &mut self.guards {
            let difference = guard.difference.range(q);
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
                    if !guard.difference.contract(&mut part, half) {
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
            let reach = AROUND_LEVEL * width;
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

    /// The parameter to split where neither a guard nor a state asks for a split.
    fn parameter(&mut self, cell: &Cell, q: &[Interval], rule: ParameterRule) -> Option<usize> {
        let chosen = match rule {
            ParameterRule::WidestInfluence => self.most_influential(cell, q),
            ParameterRule::WidestTerm => self
                .terms_on(cell, q)
                .iter()
                .max_by(|a, b| a.1.width().total_cmp(&b.1.width()).then(b.0.cmp(&a.0)))
                .map(|(param, _)| *param),
            ParameterRule::OverlappingTerms => {
                let terms = self.terms_on(cell, q);
                terms.split_last().map(|(last, rest)| {
                    let overlap = rest
                        .iter()
                        .any(|term| term.0 != last.0 && term.1.intersects(last.1));
                    if overlap {
                        last.0
                    } else {
                        rest.first().unwrap_or(last).0
                    }
                })
            }
        };
        // Where no velocity depends on a free parameter: the widest share of its prior.
        let all = 0..self.layout.params;
        chosen.or_else(|| widest(all, &q[self.layout.states..], &self.prior_width))
    }

    /// The parameter whose width widens a velocity most, in any mode possible on the box.
    fn most_influential(&mut self, cell: &Cell, q: &[Interval]) -> Option<usize> {
        let mut best: Option<(f64, usize)> = None;
        for mode in cell.modes.iter() {
            for slope in self.slopes.get_mut(mode).into_iter().flatten() {
                let width = q[self.layout.states + slope.param].width();
                let influence = slope.value.range(q).mag() * width;
                if influence > 0.0 && best.is_none_or(|(known, _)| influence > known) {
                    best = Some((influence, slope.param));
                }
            }
        }
        best.map(|(_, param)| param)
    }

    /// The terms of all modes possible on the box, each as its widest parameter and its range.
    fn terms_on(&mut self, cell: &Cell, q: &[Interval]) -> Vec<(usize, Interval)> {
        let known = &q[self.layout.states..];
        let mut found = Vec::new();
        for mode in cell.modes.iter() {
            for term in self.terms.get_mut(mode).into_iter().flatten() {
                if let Some(param) = widest(term.params.iter().copied(), known, &self.prior_width) {
                    found.push((param, term.value.range(q)));
                }
            }
        }
        found
    }
}

/// The parameter with the largest share left of its prior; none where all are points.
fn widest(
    params: impl Iterator<Item = usize>,
    known: &[Interval],
    prior_width: &[f64],
) -> Option<usize> {
    params
        .map(|param| (known[param].width(), param))
        .filter(|(width, _)| *width > 0.0)
        .map(|(width, param)| (width / prior_width[param], param))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, param)| param)
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
