//! Whether the order holds on a box: slopes, and what happens at levels at which rates switch.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: states, modes, surfaces and quantities are named by positions in the model's lists"
)]

use super::Comparison;
use super::implied::conditions;
use super::order::{Order, Slopes};
use super::rates::{Group, Rate};
use super::run::Cause;
use crate::form::surfaces::Signs;
use crate::modes::ModeSet;
use std::sync::PoisonError;
use veribound_interval::Interval;
use veribound_model::{ExprId, Graph, Level, Tape, Var};

/// At most so many levels of kept states are looked at one by one.
const MOST_KEPT_LEVELS: usize = 4;

/// The box `T` of the theorem, and `T'`.
pub(super) struct Place {
    /// States, parameters and inputs.
    pub(super) exact: Vec<Interval>,
    /// The same with larger states.
    pub(super) near: Vec<Interval>,
}

impl Place {
    /// The box of `states`, with what surrounds it.
    pub(super) fn new(states: &[Interval], params: &[Interval], inputs: &[Interval]) -> Place {
        let rest = [params, inputs].concat();
        let around = |x: &Interval| x.inflate(1e-9 * x.width() + 1e-12 * x.mag() + 1e-200);
        let near: Vec<Interval> = states.iter().map(around).collect();
        Place {
            exact: [states, &rest].concat(),
            near: [near, rest].concat(),
        }
    }
}

/// Modes that are possible with some signs of the surfaces.
struct Signed<'a> {
    comparison: &'a Comparison,
    group: &'a Group,
    signs: Vec<Signs>,
}

impl Signed<'_> {
    fn modes(&self) -> Vec<usize> {
        let formulas = &self.comparison.surfaces.modes;
        let modes = self.group.modes.clone();
        modes
            .filter(|mode| formulas[*mode].possible(&self.signs))
            .collect()
    }

    /// The modes that are possible, and the rates they give a state.
    fn rates(&self, state: usize) -> (Vec<usize>, Vec<usize>) {
        let modes = self.modes();
        let of = |mode: &usize| self.comparison.rates.of(*mode, state);
        let mut rates: Vec<usize> = modes.iter().filter_map(of).collect();
        rates.sort_unstable();
        rates.dedup();
        (modes, rates)
    }

    fn with(&self, surface: usize, sign: Signs) -> Signed<'_> {
        let mut signs = self.signs.clone();
        signs[surface] = sign;
        Signed { signs, ..*self }
    }
}

impl Comparison {
    /// The slopes on the box of `place`, if there `order` has what the theorem asks of switches and of
    /// regularity; whether the slopes fit to it is not asked.
    pub(super) fn slopes(&self, place: &Place, order: &Order) -> Result<Slopes, Cause> {
        let states = self.layout.states;
        let signs = self.signs(&place.near);
        let mut jumps = self.surfaces.jumps.iter();
        if jumps.any(|jump| jump.possible(&signs)) {
            return Err(Cause::Jump);
        }
        let mut slopes = Slopes::new(states, self.layout.len());
        for group in &self.groups {
            let ordered = |state: &&usize| order.sign[**state] != 0;
            for &state in group.states.iter().filter(ordered) {
                let here = Signed {
                    comparison: self,
                    group,
                    signs: signs.clone(),
                };
                let (_, rates) = here.rates(state);
                if rates.is_empty() {
                    return Err(Cause::Undefined { state });
                }
                if rates.len() > 1 {
                    self.switches(state, &here, place, order)?;
                }
                let switching = |i: usize| self.is_switching(i, &signs);
                for rate in rates {
                    let rate = &self.rates.list[state][rate];
                    self.add(state, rate, (place, order), &switching, &mut slopes)?;
                }
            }
        }
        Ok(slopes)
    }

    /// The signs of all surfaces on a box.
    fn signs(&self, quantities: &[Interval]) -> Vec<Signs> {
        let sign = |tape: &Tape| {
            let mut registers = tape.registers();
            let defined = tape.eval(quantities, &mut registers).is_defined();
            let value = tape.output::<Interval>(0, &registers);
            if defined {
                Signs::of(value)
            } else {
                Signs::ANY
            }
        };
        self.tape.iter().map(sign).collect()
    }

    /// The modes that are possible on a box.
    pub(super) fn modes(&self, quantities: &[Interval]) -> ModeSet {
        let signs = self.signs(quantities);
        let mut modes = ModeSet::EMPTY;
        for (mode, formula) in self.surfaces.modes.iter().enumerate() {
            if formula.possible(&signs) {
                modes.insert(mode);
            }
        }
        modes
    }

    /// Whether a state has several rates.
    fn is_switching(&self, state: usize, signs: &[Signs]) -> bool {
        let of = |group: &&Group| group.states.contains(&state);
        self.groups.iter().find(of).is_some_and(|group| {
            let here = Signed {
                comparison: self,
                group,
                signs: signs.to_vec(),
            };
            here.rates(state).1.len() > 1
        })
    }

    /// Adds the slopes of a rate, if it is regular.
    fn add(
        &self,
        state: usize,
        rate: &Rate,
        (place, order): (&Place, &Order),
        switching: &dyn Fn(usize) -> bool,
        slopes: &mut Slopes,
    ) -> Result<(), Cause> {
        let undefined = Cause::Undefined { state };
        rate.value(&place.near).ok_or(undefined)?;
        // Every one is finite, of its own state from above.
        for (&by, slope) in rate.by.iter().zip(rate.slopes(&place.near)) {
            if by >= self.layout.states || order.sign[by] == 0 {
                continue;
            }
            let regular = if by == state {
                !slope.is_empty() && slope.hi() < f64::INFINITY
            } else {
                !slope.is_empty() && slope.is_bounded()
            };
            if !regular {
                return Err(undefined);
            }
        }
        let mut here = place.exact.clone();
        for (i, x) in here.iter_mut().enumerate().take(self.layout.states) {
            if order.sign[i] != 0 && switching(i) {
                *x = place.near[i];
            }
        }
        for (&by, slope) in rate.by.iter().zip(rate.slopes(&here)) {
            if by != state {
                // What is empty has no sign.
                let slope = if slope.is_empty() {
                    Interval::ENTIRE
                } else {
                    slope
                };
                slopes.add((state, by), slope, 0.0);
            }
        }
        Ok(())
    }

    /// Whether a state with several rates is switching in the sense of the theorem, whatever side of the
    /// levels of kept states acts.
    fn switches(
        &self,
        state: usize,
        here: &Signed<'_>,
        place: &Place,
        order: &Order,
    ) -> Result<(), Cause> {
        let switch = Cause::Switch { state };
        let mut graph = self.graph.lock().unwrap_or_else(PoisonError::into_inner);
        let mut levels = Vec::new();
        let mut kept = Vec::new();
        for &surface in &here.group.surfaces {
            if !here.signs[surface].has(Signs::ZERO) {
                continue;
            }
            let Some(level) = self.surfaces.list[surface].level else {
                continue;
            };
            if level.state == state {
                levels.push((surface, level));
            } else if order.sign[level.state] == 0 && self.moves(level.state, &place.near) {
                kept.push(surface);
            }
        }
        if kept.len() > MOST_KEPT_LEVELS {
            return Err(switch);
        }
        for sides in 0..1_usize << kept.len() {
            let mut here = Signed {
                signs: here.signs.clone(),
                ..*here
            };
            for (bit, surface) in kept.iter().enumerate() {
                let positive = sides >> bit & 1 == 1;
                here.signs[*surface] = if positive {
                    Signs::POSITIVE
                } else {
                    Signs::NEGATIVE
                };
            }
            if here.modes().is_empty() || here.rates(state).1.len() == 1 {
                continue;
            }
            // A kept state that switches beside it could choose together with it.
            let beside = |other: &&usize| order.sign[**other] == 0;
            let mut beside = here.group.states.iter().filter(beside);
            let own = |(surface, level): &(usize, Level)| {
                self.falls(&mut graph, &here, (state, *surface, *level), place)
            };
            if beside.any(|other| here.rates(*other).1.len() > 1) || !levels.iter().any(own) {
                return Err(switch);
            }
        }
        Ok(())
    }

    /// Whether a state moves with a speed of one sign.
    fn moves(&self, state: usize, quantities: &[Interval]) -> bool {
        let rates = self.rates.list[state].iter();
        let speeds = rates.map(|rate| rate.value(quantities).unwrap_or(Interval::ENTIRE));
        !speeds.fold(Interval::EMPTY, Interval::hull).contains(0.0)
    }

    /// Whether the rate of a state falls where it passes its own level, and every rate on the level lies between
    /// those on both sides.
    fn falls(
        &self,
        graph: &mut Graph,
        here: &Signed<'_>,
        (state, surface, level): (usize, usize, Level),
        place: &Place,
    ) -> bool {
        let (mut above, mut below) = (Signs::POSITIVE, Signs::NEGATIVE);
        if !level.rising {
            std::mem::swap(&mut above, &mut below);
        }
        let only = |sign: Signs| match here.with(surface, sign).rates(state).1[..] {
            [only] => Some(only),
            _ => None,
        };
        let (Some(above), Some(below)) = (only(above), only(below)) else {
            return false;
        };
        let at = |graph: &mut Graph, e: ExprId| {
            graph.substitute(e, &|var| (var == Var::State(state)).then_some(level.expr))
        };
        let list = &self.rates.list[state];
        let (upper, lower) = (at(graph, list[below].expr), at(graph, list[above].expr));
        let fall = graph.sub(upper, lower);
        if !self.never_negative(graph, fall, &[], place) {
            return false;
        }
        let (modes, _) = here.with(surface, Signs::ZERO).rates(state);
        modes.into_iter().all(|mode| {
            let Some(rate) = self.rates.of(mode, state) else {
                return false;
            };
            if rate == above || rate == below {
                return true;
            }
            let mut atoms = Vec::new();
            conditions(graph, &self.guards[mode], &mut atoms);
            let atoms: Vec<ExprId> = atoms.into_iter().map(|e| at(graph, e)).collect();
            let rate = at(graph, list[rate].expr);
            let gaps = [graph.sub(upper, rate), graph.sub(rate, lower)];
            gaps.into_iter()
                .all(|gap| self.never_negative(graph, gap, &atoms, place))
        })
    }
}
