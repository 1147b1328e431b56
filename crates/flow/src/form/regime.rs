//! Which smooth right-hand side acts, and why no other one does.
//!
//! A [`Regime`] is a smooth right-hand side with expressions to *watch*. What is proved:
//!
//! *Lemma (sides).* Let a solution satisfy `g >= 0` at the start of a stretch, and at every time of it
//! `g > 0` or `g' > 0` along the right-hand side of the regime. Let further every velocity that the
//! inclusion allows where `g = 0` have `g' > 0`, if `g = 0` at the start. Then `g > 0` after the start,
//! for as long as nothing but the regime acts where `g > 0`.
//!
//! *Proof.* At the start `g` is positive or grows. Were there a first later time with `g = 0`, the regime
//! acts before it, and `g > 0` just before with `g' > 0`, so `g` grows to zero from above: a contradiction.
//!
//! *Lemma (holding).* Let `g = 0` at the start, `g' > 0` along all right-hand sides possible where `g < 0` and
//! `g' < 0` along all possible where `g > 0`. Then `g = 0` throughout.
//!
//! *Proof.* As long as `g > 0`, `g` decreases; it starts at zero, so it never is. Likewise below.
//!
//! On `g = 0` almost everywhere `g' = 0`; where only one state has several rates that fixes it, and where
//! there are two right-hand sides it fixes their convex combination. That is the right-hand side of a
//! regime that *holds* `g`. It ends when one of the rates `g'` off the surface changes its sign, so these are
//! watched, as any other expression.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: surfaces, modes, groups and states are named by positions in the model's lists; modes of a group govern the same states, \
        and one of them at least acts on what is held"
)]

use std::ops::Range;

use super::output::Output;
use super::piece::{drift, gradient};
use super::resting::{Idle, idle_jumps};
use super::surfaces::{Signs, Surfaces};
use crate::modes::ModeSet;
use crate::system::agree_on_guards;
use veribound_interval::Interval;
use veribound_model::{ExprId, Graph, Layout, Model, Tape, Var};

/// Why an expression is watched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reason {
    /// It is a surface, and other modes lie behind it.
    Side { surface: usize },
    /// It is how fast the mode on that side drives solutions back to the surface that is held.
    Hold { surface: usize, side: Signs },
    /// An absolute value, a minimum or a maximum has its kink there.
    Kink,
}

/// An expression that must keep its sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Watch {
    pub(super) expr: ExprId,
    pub(super) sign: Signs,
    pub(super) reason: Reason,
}

/// A smooth right-hand side that acts while what is watched keeps its sign.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Regime {
    pub(super) rates: Vec<ExprId>,
    pub(super) watches: Vec<Watch>,
    /// Velocities are, at almost all times, convex combinations of those of these modes, group by group.
    pub(super) modes: ModeSet,
    /// What is known of the surfaces.
    pub(super) signs: Vec<Signs>,
    /// Surfaces that are held, each with the side that a jump bars.
    pub(super) bars: Vec<(usize, Signs)>,
    /// Whether there may be kinks on the set.
    pub(super) has_kinks: bool,
}

/// Modes, surfaces and jumps of a model, compiled.
#[derive(Debug, Clone)]
pub(super) struct Switching {
    layout: Layout,
    pub(super) surfaces: Surfaces,
    groups: Vec<Group>,
    /// The group of every state.
    pub(super) group_of: Vec<usize>,
    /// `rates[mode]` are the states it governs, each with its rate.
    pub(super) rates: Vec<Vec<(usize, ExprId)>>,
    /// What every jump sets.
    pub(super) sets: Vec<Set>,
    /// Jumps that change nothing on some surface.
    pub(super) idle: Vec<Idle>,
    tape: Tape,
}

#[derive(Debug, Clone)]
struct Group {
    modes: Range<usize>,
    surfaces: Vec<usize>,
    /// Other surfaces at which jumps may leave its states where they are.
    stops: Vec<usize>,
}

/// What a jump sets.
#[derive(Debug, Clone)]
pub(super) struct Set {
    pub(super) states: Vec<usize>,
    pub(super) values: Vec<Output>,
    /// State that is set, and state that its value depends on.
    slopes: Vec<(usize, usize)>,
    /// The values, and the slopes.
    tape: Tape,
}

impl Set {
    fn compile(graph: &mut Graph, layout: Layout, set: &[(usize, ExprId)]) -> Set {
        let mut slopes = Vec::new();
        let mut roots: Vec<ExprId> = set.iter().map(|(_, e)| graph.elementary(*e)).collect();
        for (position, (state, _)) in set.iter().enumerate() {
            for (from, slope) in gradient(graph, roots[position]) {
                slopes.push((*state, from));
                roots.push(slope);
            }
        }
        let values = roots[..set.len()].iter();
        Set {
            states: set.iter().map(|(state, _)| *state).collect(),
            values: values
                .map(|e| Output::compile(graph, layout.states, *e))
                .collect(),
            slopes,
            tape: Tape::compile(graph, layout, &roots),
        }
    }

    /// The values on a box of states, parameters and inputs, and for every slope the state that is set, the
    /// state that its value depends on, and how. `None` where they are undefined.
    pub(super) fn on_box(&self, quantities: &[Interval]) -> Option<(Vec<Interval>, Vec<SetSlope>)> {
        let mut registers = self.tape.registers();
        if !self.tape.eval(quantities, &mut registers).is_defined() {
            return None;
        }
        let mut outputs = (0..).map(|index| self.tape.output::<Interval>(index, &registers));
        let values = outputs.by_ref().take(self.states.len()).collect();
        let slopes = self.slopes.iter().zip(outputs);
        let slopes = slopes.map(|(&(state, from), slope)| (state, from, slope));
        Some((values, slopes.collect()))
    }
}

/// State that is set, state that its value depends on, and how.
type SetSlope = (usize, usize, Interval);

/// Surfaces and right-hand sides on a box.
pub(super) struct Field {
    pub(super) surfaces: Vec<Interval>,
    gradients: Vec<Vec<(usize, Interval)>>,
    pub(super) rates: Vec<Vec<(usize, Interval)>>,
    /// Whether the box knows of no error of these inputs.
    exact: Vec<bool>,
    /// Surfaces and modes: signs of rates of change that the box does not tell.
    pub(super) drifts: Vec<(usize, usize, Signs)>,
    /// The box.
    pub(super) quantities: Vec<Interval>,
}

impl Field {
    /// The signs of all surfaces, as far as the box tells.
    pub(super) fn signs(&self) -> Vec<Signs> {
        self.surfaces
            .iter()
            .map(|value| Signs::of(*value))
            .collect()
    }

    /// How surfaces whose signs are open depend on the states, about.
    pub(super) fn open_gradients(&self) -> Vec<Vec<(usize, f64)>> {
        let open = self.surfaces.iter().zip(&self.gradients);
        let open = open.filter(|(value, _)| value.lo() < 0.0 && value.hi() > 0.0);
        let middle = |(state, slope): &(usize, Interval)| (*state, slope.mid());
        open.map(|(_, gradient)| gradient.iter().map(middle).collect())
            .collect()
    }
}

/// Velocities of a state.
#[derive(Debug, Clone, Default)]
pub(super) struct Velocity {
    /// Rates of modes, and their values.
    pub(super) rates: Vec<(ExprId, Interval)>,
    /// Values while some surface is zero.
    pub(super) held: Vec<Interval>,
}

/// How a group is decided.
enum Decision {
    Mode(usize),
    Hold(Hold),
}

struct Hold {
    surface: usize,
    /// The side that a jump bars: no mode is asked there.
    bar: Option<Signs>,
    below: Vec<usize>,
    above: Vec<usize>,
    /// All that act on the surface.
    all: Vec<usize>,
}

/// The surfaces that are held.
fn held(decisions: &[Decision]) -> Vec<usize> {
    let held = decisions.iter().filter_map(|decision| match decision {
        Decision::Mode(_) => None,
        Decision::Hold(hold) => Some(hold.surface),
    });
    held.collect()
}

impl Switching {
    pub(super) fn compile(graph: &mut Graph, model: &Model) -> Switching {
        let layout = model.layout();
        let mut rates: Vec<Vec<(usize, ExprId)>> = (0..model.modes.len())
            .map(|mode| model.governed(mode).collect())
            .collect();
        agree_on_guards(graph, model, &mut rates);
        for (_, rate) in rates.iter_mut().flatten() {
            *rate = graph.elementary(*rate);
        }
        let sets = model
            .jumps
            .iter()
            .map(|jump| Set::compile(graph, layout, &jump.set));
        let sets = sets.collect();
        let surfaces = Surfaces::of(graph, model);
        let idle = idle_jumps(graph, model, &surfaces, &rates);
        let mut group_of = vec![0; layout.states];
        let groups = model.groups.iter().enumerate().map(|(index, group)| {
            for state in &group.states {
                group_of[*state] = index;
            }
            let mut asked = Vec::new();
            for mode in group.modes.clone() {
                surfaces.modes[mode].surfaces(&mut asked);
            }
            let stops = idle
                .iter()
                .filter(|idle| group.states.contains(&idle.state));
            let mut stops: Vec<usize> = stops.map(|idle| idle.surface).collect();
            stops.sort_unstable();
            stops.dedup();
            stops.retain(|surface| !asked.contains(surface));
            Group {
                modes: group.modes.clone(),
                surfaces: asked,
                stops,
            }
        });
        let groups = groups.collect();
        let roots: Vec<ExprId> = surfaces
            .list
            .iter()
            .map(|surface| surface.expr)
            .chain(
                surfaces
                    .list
                    .iter()
                    .flat_map(|s| s.gradient.iter().map(|g| g.1)),
            )
            .chain(rates.iter().flatten().map(|r| r.1))
            .collect();
        Switching {
            tape: Tape::compile(graph, layout, &roots),
            layout,
            surfaces,
            groups,
            group_of,
            rates,
            sets,
            idle,
        }
    }

    /// Evaluates everything on a box of states, parameters and inputs; `None` where something is undefined.
    pub(super) fn field(&self, quantities: &[Interval]) -> Option<Field> {
        let mut registers = self.tape.registers();
        if !self.tape.eval(quantities, &mut registers).is_defined() {
            return None;
        }
        let mut next = 0;
        let mut take = || {
            next += 1;
            self.tape.output::<Interval>(next - 1, &registers)
        };
        let list = &self.surfaces.list;
        let inputs = &quantities[self.layout.states + self.layout.params..];
        Some(Field {
            surfaces: list.iter().map(|_| take()).collect(),
            gradients: list
                .iter()
                .map(|s| s.gradient.iter().map(|g| (g.0, take())).collect())
                .collect(),
            rates: self
                .rates
                .iter()
                .map(|list| list.iter().map(|r| (r.0, take())).collect())
                .collect(),
            exact: inputs.iter().map(|u| u.is_point()).collect(),
            drifts: Vec::new(),
            quantities: quantities.to_vec(),
        })
    }

    /// `signs` less what is `known` not to be: of surfaces that inputs do not move.
    pub(super) fn narrowed(&self, mut signs: Vec<Signs>, known: &[Signs]) -> Vec<Signs> {
        for ((own, known), surface) in signs.iter_mut().zip(known).zip(&self.surfaces.list) {
            if surface.inputs.is_empty() {
                *own = own.and(*known);
            }
        }
        signs
    }

    /// True if the surface is a function of the state alone during a stretch.
    pub(super) fn is_steady(&self, surface: usize, field: &Field) -> bool {
        let inputs = self.surfaces.list[surface].inputs.iter();
        inputs.copied().all(|input| field.exact[input])
    }

    /// The regime that acts on the box of `field` where surfaces have `signs`, from now on and as long as
    /// its watches last; `None` if that is not proved.
    pub(super) fn resolve(
        &self,
        graph: &mut Graph,
        field: &Field,
        signs: Vec<Signs>,
    ) -> Option<Regime> {
        let mut regime = self.unbent(graph, field, signs)?;
        self.straighten(graph, field, None, &mut regime);
        Some(regime)
    }

    /// As [`Switching::resolve`], with all kinks in place.
    pub(super) fn unbent(
        &self,
        graph: &mut Graph,
        field: &Field,
        mut signs: Vec<Signs>,
    ) -> Option<Regime> {
        let mut decisions = Vec::with_capacity(self.groups.len());
        for group in 0..self.groups.len() {
            decisions.push(self.decide(group, field, &mut signs)?);
        }
        if self.may_change(&held(&decisions), &signs) {
            return None;
        }
        self.assemble(graph, field, &decisions, signs)
    }

    /// Whether some jump may happen.
    pub(super) fn jump_possible(&self, signs: &[Signs]) -> bool {
        self.surfaces.jumps.iter().any(|jump| jump.possible(signs))
    }

    /// The jump that certainly happens where surfaces have the signs `far`, if it is the only one possible
    /// at `signs`.
    pub(super) fn certain_jump(&self, signs: &[Signs], far: &[Signs]) -> Option<usize> {
        let jumps = &self.surfaces.jumps;
        let mut possible = (0..jumps.len()).filter(|jump| jumps[*jump].possible(signs));
        let jump = possible.next()?;
        (possible.next().is_none() && jumps[jump].certain(far)).then_some(jump)
    }

    /// The box of states after a jump, and whether it leaves a surface as it is.
    pub(super) fn image(
        &self,
        jump: usize,
        surface: usize,
        quantities: &[Interval],
    ) -> Option<(Vec<Interval>, bool)> {
        let set = &self.sets[jump];
        let mut states = quantities[..self.layout.states].to_vec();
        for (state, value) in set.states.iter().zip(set.on_box(quantities)?.0) {
            states[*state] = value;
        }
        let touched = |entry: &(usize, ExprId)| set.states.contains(&entry.0);
        let keeps = !self.surfaces.list[surface].gradient.iter().any(touched);
        Some((states, keeps))
    }

    /// What velocities are possible, at almost all times, on the box of `field` with surfaces of `signs`.
    ///
    /// Proof. Almost everywhere on the times at which a surface is zero its rate of change is zero. Where only
    /// one state of a group has several rates, that fixes its velocity. At all other times the surface has
    /// one of its strict signs.
    pub(super) fn velocities(&self, field: &Field, signs: &[Signs]) -> Option<Vec<Velocity>> {
        let mut velocities = vec![Velocity::default(); self.layout.states];
        for (index, group) in self.groups.iter().enumerate() {
            let mut modes = self.possible(index, signs);
            let first = *modes.first()?;
            let agreed: Vec<usize> = self.agreed(&modes).iter().map(|rate| rate.0).collect();
            let states = self.rates[first].iter().map(|rate| rate.0);
            let open: Vec<usize> = states.filter(|state| !agreed.contains(state)).collect();
            if let [state] = open[..] {
                let mut strict = signs.to_vec();
                for &surface in &group.surfaces {
                    if signs[surface].has(Signs::ZERO)
                        && self.is_steady(surface, field)
                        && let Some(held) =
                            self.tangent(surface, state, (index, first), field, signs)
                    {
                        strict[surface] = signs[surface].and(Signs::NEGATIVE.or(Signs::POSITIVE));
                        velocities[state].held.push(held);
                    }
                }
                modes = self.possible(index, &strict);
                if modes.is_empty() {
                    // The surface is zero all the time; any rate may lead the way.
                    modes.push(first);
                }
            }
            for mode in modes {
                for ((state, rate), (_, value)) in self.rates[mode].iter().zip(&field.rates[mode]) {
                    let known = &mut velocities[*state].rates;
                    if !known.contains(&(*rate, *value)) {
                        known.push((*rate, *value));
                    }
                }
            }
        }
        Some(velocities)
    }

    /// The velocity of a state while a surface stays zero, if all others of its group have the rates of `mode`.
    fn tangent(
        &self,
        surface: usize,
        state: usize,
        mode: (usize, usize),
        field: &Field,
        signs: &[Signs],
    ) -> Option<Interval> {
        let gradient = &field.gradients[surface];
        let own = gradient.iter().find(|entry| entry.0 == state)?.1;
        if own.contains(0.0) {
            return None;
        }
        let others = gradient.iter().filter(|entry| entry.0 != state);
        let sum = others.fold(Interval::ZERO, |sum, &(other, slope)| {
            sum + slope * self.rate_in(other, Some(mode), field, signs)
        });
        Some(-(sum / own))
    }

    /// The rate of a state where surfaces have these signs, if one mode comes first.
    pub(super) fn rate_at(&self, state: usize, signs: &[Signs]) -> Option<ExprId> {
        let mode = *self.possible(self.group_of[state], signs).first()?;
        self.expression(mode, state)
    }

    /// The rate a mode gives a state, if it governs it.
    fn expression(&self, mode: usize, state: usize) -> Option<ExprId> {
        let mut rates = self.rates[mode].iter();
        rates.find(|rate| rate.0 == state).map(|rate| rate.1)
    }

    pub(super) fn possible(&self, group: usize, signs: &[Signs]) -> Vec<usize> {
        let modes = self.groups[group].modes.clone();
        modes
            .filter(|mode| self.surfaces.modes[*mode].possible(signs))
            .collect()
    }

    fn possible_with(
        &self,
        group: usize,
        signs: &[Signs],
        (surface, sign): (usize, Signs),
    ) -> Vec<usize> {
        let mut signs = signs.to_vec();
        signs[surface] = sign;
        self.possible(group, &signs)
    }

    /// The surfaces that decide a group: where its modes switch, and where a jump bars the way.
    fn deciding(&self, group: usize, signs: &[Signs]) -> Vec<usize> {
        let Group {
            surfaces, stops, ..
        } = &self.groups[group];
        let stops = stops.iter().filter(|s| self.barred(**s, signs).is_some());
        surfaces.iter().chain(stops).copied().collect()
    }

    /// The modes on both sides of a surface, but on one that a jump bars.
    fn sides(
        &self,
        group: usize,
        signs: &[Signs],
        (surface, bar): (usize, Option<Signs>),
    ) -> (Vec<usize>, Vec<usize>) {
        let side = |sign: Signs| match bar {
            Some(bar) if bar == sign => Vec::new(),
            _ => self.possible_with(group, signs, (surface, sign)),
        };
        (side(Signs::NEGATIVE), side(Signs::POSITIVE))
    }

    fn decide(&self, group: usize, field: &Field, signs: &mut [Signs]) -> Option<Decision> {
        let (down, up) = (Signs::NEGATIVE, Signs::POSITIVE);
        loop {
            let possible = self.possible(group, signs);
            let first = *possible.first()?;
            let surfaces = self.deciding(group, signs);
            let is_barred = surfaces.iter().any(|s| self.barred(*s, signs).is_some());
            let mut modes = possible.iter();
            if !is_barred && modes.all(|mode| self.rates[*mode] == self.rates[first]) {
                return Some(Decision::Mode(first));
            }
            let mut progress = false;
            for surface in surfaces {
                let known = signs[surface];
                if !known.has(Signs::ZERO) || known == Signs::ANY || !self.is_steady(surface, field)
                {
                    continue;
                }
                let side = |sign: Signs| self.possible_with(group, signs, (surface, sign));
                let drift = |modes: &[usize]| self.common(surface, modes, group, field, signs);
                let all = side(Signs::ZERO);
                let bar = self.barred(surface, signs);
                match drift(&all) {
                    Some(way) if known.within(way.or(Signs::ZERO)) && bar != Some(way) => {
                        signs[surface] = way;
                        progress = true;
                        break;
                    }
                    _ => {}
                }
                if known == Signs::ZERO {
                    let (below, above) = self.sides(group, signs, (surface, bar));
                    let back = |modes: &[usize], from: Signs| {
                        bar == Some(from) || drift(modes) == Some(from.flipped())
                    };
                    if back(&below, down) && back(&above, up) {
                        return Some(Decision::Hold(Hold {
                            surface,
                            bar,
                            below,
                            above,
                            all,
                        }));
                    }
                }
            }
            if !progress {
                return None;
            }
        }
    }

    /// The sign that a surface's rate of change has in all of these modes of a group.
    fn common(
        &self,
        surface: usize,
        modes: &[usize],
        group: usize,
        field: &Field,
        signs: &[Signs],
    ) -> Option<Signs> {
        let mut found = None;
        for mode in modes {
            let on_box = Signs::strict(self.drift(surface, Some((group, *mode)), field, signs));
            let told = |known: &&(usize, usize, Signs)| (known.0, known.1) == (surface, *mode);
            let sign = on_box.or_else(|| field.drifts.iter().find(told).map(|known| known.2))?;
            if found.is_some_and(|known| known != sign) {
                return None;
            }
            found = Some(sign);
        }
        found
    }

    /// Surfaces that may be met or held, each with a mode there: where the box does not tell the sign of the
    /// rate of change.
    pub(super) fn open_drifts(&self, field: &Field, signs: &[Signs]) -> Vec<(usize, usize)> {
        let mut open = Vec::new();
        for index in 0..self.groups.len() {
            for surface in self.deciding(index, signs) {
                let known = signs[surface];
                if !known.has(Signs::ZERO) || known == Signs::ANY || !self.is_steady(surface, field)
                {
                    continue;
                }
                for side in [Signs::NEGATIVE, Signs::ZERO, Signs::POSITIVE] {
                    for mode in self.possible_with(index, signs, (surface, side)) {
                        let is_open = self.common(surface, &[mode], index, field, signs).is_none();
                        if is_open && !open.contains(&(surface, mode)) {
                            open.push((surface, mode));
                        }
                    }
                }
            }
        }
        open
    }

    /// The side of a surface on which a mode acts, if it acts on one only.
    pub(super) fn side_of(&self, surface: usize, mode: usize, signs: &[Signs]) -> Option<Signs> {
        let group = self
            .groups
            .iter()
            .position(|group| group.modes.contains(&mode))?;
        let on = |sign: Signs| {
            let possible = self.possible_with(group, signs, (surface, sign));
            possible.contains(&mode)
        };
        match (on(Signs::NEGATIVE), on(Signs::POSITIVE)) {
            (true, false) => Some(Signs::NEGATIVE),
            (false, true) => Some(Signs::POSITIVE),
            _ => None,
        }
    }

    /// The rate of change of a surface in a mode, where that governs all states that the surface depends on.
    pub(super) fn drift_in(
        &self,
        graph: &mut Graph,
        surface: usize,
        mode: usize,
    ) -> Option<ExprId> {
        let gradient = &self.surfaces.list[surface].gradient;
        let mut rates = Vec::with_capacity(gradient.len());
        for &(state, _) in gradient {
            rates.push((state, self.expression(mode, state)?));
        }
        let zero = graph.integer(0);
        Some(drift(graph, gradient, &|state| {
            let rate = rates.iter().find(|rate| rate.0 == state);
            rate.map_or(zero, |rate| rate.1)
        }))
    }

    /// The sign that the rate of change of a surface has in all modes that are possible.
    pub(super) fn leaves(&self, surface: usize, field: &Field, signs: &[Signs]) -> Option<Signs> {
        if !self.is_steady(surface, field) {
            return None;
        }
        Signs::strict(self.drift(surface, None, field, signs))
    }

    /// The rate of change of a surface in any possible modes, of one group in the mode `chosen`.
    fn drift(
        &self,
        surface: usize,
        chosen: Option<(usize, usize)>,
        field: &Field,
        signs: &[Signs],
    ) -> Interval {
        let terms = field.gradients[surface].iter();
        terms.fold(Interval::ZERO, |sum, &(state, slope)| {
            let mut rate = self.rate_in(state, chosen, field, signs);
            // Where a jump holds the state, other surfaces see it rest.
            if self.may_rest(state, signs) && self.barred(surface, signs).is_none() {
                rate = rate.hull(Interval::ZERO);
            }
            sum + slope * rate
        })
    }

    /// The rates of a state in all possible modes, or in the mode `chosen` of its group.
    fn rate_in(
        &self,
        state: usize,
        chosen: Option<(usize, usize)>,
        field: &Field,
        signs: &[Signs],
    ) -> Interval {
        let own = self.group_of[state];
        let modes = match chosen {
            Some((group, mode)) if group == own => vec![mode],
            _ => self.possible(own, signs),
        };
        let rates = modes.into_iter().flat_map(|mode| &field.rates[mode]);
        let rates = rates.filter(|rate| rate.0 == state);
        rates.fold(Interval::EMPTY, |hull, rate| hull.hull(rate.1))
    }

    fn assemble(
        &self,
        graph: &mut Graph,
        field: &Field,
        decisions: &[Decision],
        signs: Vec<Signs>,
    ) -> Option<Regime> {
        let mut rates: Vec<Option<ExprId>> = vec![None; self.layout.states];
        for decision in decisions {
            match decision {
                Decision::Mode(mode) => {
                    for (state, rate) in &self.rates[*mode] {
                        rates[*state] = Some(*rate);
                    }
                }
                Decision::Hold(hold) => {
                    for (state, rate) in self.agreed(&hold.all) {
                        rates[state] = Some(rate);
                    }
                }
            }
        }
        for decision in decisions {
            if let Decision::Hold(hold) = decision {
                self.slide(graph, hold, &mut rates)?;
            }
        }
        let rates: Vec<ExprId> = rates.into_iter().collect::<Option<_>>()?;
        let mut watches = Vec::new();
        let mut needed: Vec<usize> = Vec::new();
        for (group, decision) in decisions.iter().enumerate() {
            let surfaces = &self.groups[group].surfaces;
            match decision {
                Decision::Mode(_) => {
                    let now = self.possible(group, &signs);
                    let same = |signs: &[Signs]| self.possible(group, signs) == now;
                    needed.extend(self.needed(surfaces, &signs, field, &same));
                }
                Decision::Hold(hold) => {
                    let mut free = signs.clone();
                    free[hold.surface] = Signs::ANY;
                    let now = (&hold.below, &hold.above);
                    let same = |signs: &[Signs]| {
                        let sides = self.sides(group, signs, (hold.surface, hold.bar));
                        (&sides.0, &sides.1) == now
                    };
                    let at = |signs: &[Signs]| {
                        let at = self.possible_with(group, signs, (hold.surface, Signs::ZERO));
                        at.iter().all(|mode| hold.all.contains(mode))
                    };
                    let both = |signs: &[Signs]| same(signs) && (at(signs) || self.one_rate(hold));
                    needed.extend(self.needed(surfaces, &free, field, &both));
                    self.holding(graph, hold, &rates, &mut watches);
                }
            }
        }
        let mut asked = Vec::new();
        for jump in &self.surfaces.jumps {
            jump.surfaces(&mut asked);
        }
        let held = held(decisions);
        let still = |signs: &[Signs]| !self.may_change(&held, signs);
        needed.extend(self.needed(&asked, &signs, field, &still));
        let mut kept = vec![Signs::ANY; signs.len()];
        let (mut bars, mut resting) = (Vec::new(), Vec::new());
        for decision in decisions {
            if let Decision::Hold(hold) = decision {
                kept[hold.surface] = Signs::ZERO;
                if let Some(side) = hold.bar {
                    let (rest, watched) = self.needed_by_bar(hold.surface, &signs);
                    resting.extend(rest);
                    needed.extend(watched);
                    bars.push((hold.surface, side));
                }
            }
        }
        needed.sort_unstable();
        needed.dedup();
        needed.retain(|surface| !resting.contains(surface));
        for surface in resting {
            kept[surface] = signs[surface];
        }
        for surface in needed {
            let sign = signs[surface];
            if sign != Signs::POSITIVE && sign != Signs::NEGATIVE {
                return None;
            }
            kept[surface] = sign;
            watches.push(Watch {
                expr: self.surfaces.list[surface].expr,
                sign,
                reason: Reason::Side { surface },
            });
        }
        let mut modes = ModeSet::EMPTY;
        for (group, decision) in decisions.iter().enumerate() {
            let acting = match decision {
                Decision::Mode(_) => self.possible(group, &kept),
                Decision::Hold(hold) => self.holding_modes(hold, &rates),
            };
            acting.into_iter().for_each(|mode| modes.insert(mode));
        }
        Some(Regime {
            modes,
            rates,
            watches,
            bars,
            signs: kept,
            has_kinks: true,
        })
    }

    /// Takes the kinks out of the rates of a regime where their sides are known on the box of `field`, or
    /// given as known.
    pub(super) fn straighten(
        &self,
        graph: &mut Graph,
        field: &Field,
        known: Option<(ExprId, Signs)>,
        regime: &mut Regime,
    ) {
        let layout = self.layout;
        let value = |var: Var| field.quantities[layout.index(var)];
        let mut sides: Vec<(ExprId, Signs)> = known.into_iter().collect();
        let mut open = false;
        for rate in &mut regime.rates {
            *rate = graph.straightened(*rate, &mut |graph, e| {
                let side = sides.iter().find(|side| side.0 == e).map(|side| side.1);
                let side = side.or_else(|| Signs::strict(graph.eval_interval(e, &value)));
                match side {
                    Some(side) => {
                        if !sides.contains(&(e, side)) {
                            sides.push((e, side));
                        }
                        Some(side == Signs::POSITIVE)
                    }
                    None => {
                        open = true;
                        None
                    }
                }
            });
        }
        regime.has_kinks = open;
        regime
            .watches
            .extend(sides.into_iter().map(|(expr, sign)| Watch {
                expr,
                sign,
                reason: Reason::Kink,
            }));
    }

    /// Surfaces whose signs must stay as they are for `same` to stay true, those far from zero if there is
    /// a choice.
    fn needed(
        &self,
        surfaces: &[usize],
        signs: &[Signs],
        field: &Field,
        same: &dyn Fn(&[Signs]) -> bool,
    ) -> Vec<usize> {
        let mut order = surfaces.to_vec();
        let time_left = |surface: usize| {
            let terms = field.gradients[surface].iter().map(|&(state, slope)| {
                let rates = field.rates.iter().flatten().filter(|rate| rate.0 == state);
                slope.mag() * rates.fold(0.0, |most: f64, rate| most.max(rate.1.mag()))
            });
            field.surfaces[surface].mig() / (terms.sum::<f64>() + 1e-300)
        };
        order.sort_by(|a, b| time_left(*a).total_cmp(&time_left(*b)));
        let mut free = signs.to_vec();
        order.retain(|surface| {
            let known = std::mem::replace(&mut free[*surface], Signs::ANY);
            let is_needed = known != Signs::ANY && !same(&free);
            if is_needed {
                free[*surface] = known;
            }
            is_needed
        });
        order
    }

    /// States to which all of these modes give the same rate.
    fn agreed(&self, modes: &[usize]) -> Vec<(usize, ExprId)> {
        let first = &self.rates[modes[0]];
        let same = |index: usize| {
            modes
                .iter()
                .all(|mode| self.rates[*mode][index] == first[index])
        };
        (0..first.len())
            .filter(|index| same(*index))
            .map(|index| first[index])
            .collect()
    }

    /// Whether only one state's rate switches: then any mode that joins leaves the held rate as it is.
    fn one_rate(&self, hold: &Hold) -> bool {
        let agreed = self.agreed(&hold.all).len();
        agreed + 1 == self.rates[hold.all[0]].len() && {
            let group = self.group_of[self.rates[hold.all[0]][0].0];
            let all: Vec<usize> = self.groups[group].modes.clone().collect();
            self.agreed(&all).len() == agreed
        }
    }

    /// The rates on a surface that is held.
    fn slide(&self, graph: &mut Graph, hold: &Hold, rates: &mut [Option<ExprId>]) -> Option<()> {
        let known = &self.surfaces.list[hold.surface];
        if let (Some(_), Some(level)) = (hold.bar, known.level) {
            rates[level.state] = None;
        }
        let gradient = &known.gradient;
        let open: Vec<usize> = self.rates[hold.all[0]]
            .iter()
            .map(|rate| rate.0)
            .filter(|state| rates[*state].is_none())
            .collect();
        if let [state] = open[..] {
            let slope = gradient.iter().find(|entry| entry.0 == state)?.1;
            graph.as_constant(slope)?;
            let mut sum = graph.integer(0);
            for &(other, slope) in gradient.iter().filter(|entry| entry.0 != state) {
                let term = graph.mul(slope, rates[other]?);
                sum = graph.add(sum, term);
            }
            let quotient = graph.div(sum, slope);
            rates[state] = Some(graph.neg(quotient));
            return Some(());
        }
        let ([below], [above]) = (&hold.below[..], &hold.above[..]) else {
            return None;
        };
        if hold.all.iter().any(|mode| mode != below && mode != above) {
            return None;
        }
        let mut drifts = [graph.integer(0); 2];
        for (mode, drift) in [below, above].into_iter().zip(&mut drifts) {
            for &(state, slope) in gradient {
                let rate = self.expression(*mode, state).or(rates[state])?;
                let term = graph.mul(slope, rate);
                *drift = graph.add(*drift, term);
            }
        }
        let apart = graph.sub(drifts[0], drifts[1]);
        for (below, above) in self.rates[*below].iter().zip(&self.rates[*above]) {
            let (first, second) = (graph.mul(drifts[0], above.1), graph.mul(drifts[1], below.1));
            let sum = graph.sub(first, second);
            if rates[below.0].is_none() {
                rates[below.0] = Some(graph.div(sum, apart));
            }
        }
        Some(())
    }

    /// The modes by which a surface is held: one that acts nowhere else and gives these rates, as stick does, or else
    /// all that meet there.
    fn holding_modes(&self, hold: &Hold, rates: &[ExprId]) -> Vec<usize> {
        let beside = |mode: &usize| hold.below.contains(mode) || hold.above.contains(mode);
        let given = |mode: &usize| {
            let mut list = self.rates[*mode].iter();
            list.all(|(state, rate)| rates[*state] == *rate)
        };
        let all = hold.all.iter();
        let own: Vec<usize> = all.filter(|m| !beside(m) && given(m)).copied().collect();
        if own.is_empty() || hold.bar.is_some() {
            hold.all.clone()
        } else {
            own
        }
    }

    /// Watches that keep a surface held.
    fn holding(&self, graph: &mut Graph, hold: &Hold, rates: &[ExprId], watches: &mut Vec<Watch>) {
        let sides = [
            (&hold.below, Signs::NEGATIVE, Signs::POSITIVE),
            (&hold.above, Signs::POSITIVE, Signs::NEGATIVE),
        ];
        for (modes, side, sign) in sides {
            for mode in modes {
                let gradient = &self.surfaces.list[hold.surface].gradient;
                let drift = drift(graph, gradient, &|state| {
                    self.expression(*mode, state).unwrap_or(rates[state])
                });
                let surface = hold.surface;
                let watch = Watch {
                    expr: drift,
                    sign,
                    reason: Reason::Hold { surface, side },
                };
                if !watches.contains(&watch) {
                    watches.push(watch);
                }
            }
        }
    }
}
