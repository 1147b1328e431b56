//! A moment in which no smooth right-hand side is certain.
//!
//! Boxes go on for it (`crate::step`), for Filippov solutions of all modes that are possible, with jumps. The form
//! keeps what it can: it follows one of the right-hand sides, and how far the others are from it on the
//! tube of the boxes is added to its defect. Where the box at the end is narrower than the form, as after capture, the
//! state is put to it and forgets what it depends on.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one entry per state, from the same lists"
)]

use super::journey::{Acting, Journey};
use super::piece::Piece;
use super::regime::{Field, Regime};
use super::set::Form;
use super::step::Obstacle;
use crate::modes::ModeSet;
use crate::step::{StepOptions, Workspace};
use veribound_interval::Interval;
use veribound_model::ExprId;

/// A state is put to its box when that is narrower than the form by this factor.
const NARROWER: f64 = 0.9;

/// So many moments at least go into a stretch.
const PARTS: f64 = 4.0;

/// What a moment takes, in multiplications of polynomials.
const MOMENT: f64 = 16.0;

/// A moment is shortened at most so often.
const SHORTENINGS: usize = 12;

impl Journey<'_> {
    /// Goes on for a moment; the regime that cannot go on, and how long its crossing takes, is a hint.
    ///
    /// Errors: `why` it was asked, where boxes cannot go on either.
    pub(super) async fn mixed(
        &mut self,
        hint: Option<(Acting, f64)>,
        why: Obstacle,
    ) -> Result<(), Obstacle> {
        self.spend(MOMENT).await;
        let (flow, inputs) = (self.flow, self.inputs());
        let workspace = self.workspace.take();
        let mut workspace =
            workspace.unwrap_or_else(|| Workspace::new(&flow.system, StepOptions::default()));
        let whole = self.stretches[self.current].dt.hi();
        let takes = hint
            .as_ref()
            .map_or(f64::INFINITY, |(_, takes)| 0.25 * takes);
        let mut length = takes
            .max(whole / 1024.0)
            .min(whole / PARTS)
            .min(2.0 * self.moment);
        let start = self.form.hull();
        let params = self.form.param_box();
        let mut tries = 0;
        let (end, tube, moved) = loop {
            let moved = if 1.1 * length >= self.left.hi() {
                self.left
            } else {
                Interval::point(length)
            };
            let mut states = start.clone();
            match flow
                .system
                .step(&mut states, &params, inputs, moved, &mut workspace)
            {
                Ok(_) => break (states, workspace.tube().to_vec(), moved),
                Err(_) if tries < SHORTENINGS && length > self.shortest() => {
                    tries += 1;
                    length = moved.hi() * 0.25;
                }
                Err(_) => return Err(why),
            }
        };
        self.workspace = Some(workspace);
        let last = moved == self.left;
        if !last {
            self.moment = moved.hi();
        }
        let followed = self.follow(hint, &tube, moved);
        let mut form = followed.unwrap_or_else(|| boxed(&self.form, &end));
        form.restrict(&end);
        form.tube = self
            .form
            .tube
            .iter()
            .zip(&tube)
            .map(|(a, b)| a.hull(*b))
            .collect();
        form.elapsed = self.form.elapsed + moved;
        let outputs = self.outputs_on(&tube, inputs);
        self.proved.pass(&outputs, self.modes_on(&tube));
        self.proved.steps += 1;
        let ended = flow.switching.field(&self.quantities(&end, inputs));
        form.signs = ended.map_or(Vec::new(), |field| field.signs());
        form.settle()?;
        form.tear(&self.form.excesses(), &self.open_by(&tube));
        self.earlier.clear();
        self.form = form;
        self.left = if last {
            Interval::ZERO
        } else {
            self.left - moved
        };
        self.acting = None;
        Ok(())
    }

    /// How much each unknown decides the signs that are open on a box.
    fn open_by(&self, states: &[Interval]) -> Vec<f64> {
        let quantities = self.quantities(states, self.inputs());
        let field = self.flow.switching.field(&quantities);
        let gradients = field.as_ref().map_or(Vec::new(), Field::open_gradients);
        let mut shares = vec![0.0; self.form.unknowns.len()];
        for gradient in gradients {
            let mut slopes = vec![0.0; shares.len()];
            for (state, slope) in gradient {
                let own = &self.form.states[state][1..];
                let own = slopes.iter_mut().zip(own);
                own.for_each(|(sum, x)| *sum += slope * x);
            }
            let all: f64 = slopes.iter().map(|x| x.abs()).sum();
            let own = shares.iter_mut().zip(&slopes);
            own.for_each(|(share, x)| *share += x.abs() / (all + 1e-300));
        }
        let all: f64 = shares.iter().sum();
        shares.iter().map(|x| x / (all + 1e-300)).collect()
    }

    /// The modes of all groups whose guards, border included, can hold on a box.
    fn modes_on(&self, states: &[Interval]) -> ModeSet {
        let flow = self.flow;
        let field = flow
            .switching
            .field(&self.quantities(states, self.inputs()));
        let signs = field.map(|field| field.signs());
        let mut modes = ModeSet::EMPTY;
        for (mode, guard) in flow.switching.surfaces.modes.iter().enumerate() {
            if signs.as_ref().is_none_or(|signs| guard.possible(signs)) {
                modes.insert(mode);
            }
        }
        modes
    }

    /// The form after `moved`, along one right-hand side of those possible on the tube.
    fn follow(
        &self,
        hint: Option<(Acting, f64)>,
        tube: &[Interval],
        moved: Interval,
    ) -> Option<Form> {
        let (flow, inputs) = (self.flow, self.inputs());
        let quantities = self.quantities(tube, inputs);
        let field = flow.switching.field(&quantities)?;
        let signs = field.signs();
        if flow.switching.jump_possible(&signs) {
            return None;
        }
        let velocities = flow.switching.velocities(&field, &signs)?;
        let mut middle = quantities.clone();
        for (x, now) in middle.iter_mut().zip(self.form.hull()) {
            *x = Interval::point(now.mid());
        }
        let middle = flow.switching.field(&middle)?.signs();
        let hinted = hint.map(|(acting, _)| acting.regime.rates);
        let mut rates = Vec::with_capacity(velocities.len());
        for (state, velocity) in velocities.iter().enumerate() {
            let hinted = hinted.as_ref().map(|rates| rates[state]);
            let own = flow.switching.rate_at(state, &middle);
            let known = |rate: &ExprId| velocity.rates.iter().any(|own| own.0 == *rate);
            let rate = hinted.filter(known).or(own.filter(known));
            rates.push(rate.or(velocity.rates.first().map(|own| own.0))?);
        }
        let regime = Regime {
            rates,
            watches: Vec::new(),
            modes: ModeSet::EMPTY,
            signs: Vec::new(),
            bars: Vec::new(),
            has_kinks: true,
        };
        let mut acting = Acting::new(flow, regime, &self.form);
        let own = acting.piece.on_box(&quantities)?.rates;
        let extra: Vec<f64> = velocities
            .iter()
            .enumerate()
            .map(|(state, velocity)| {
                let others = velocity.rates.iter();
                let others = others.filter(|other| other.0 != acting.regime.rates[state]);
                let others = others
                    .map(|other| other.1)
                    .chain(velocity.held.iter().copied());
                others.fold(0.0, |most: f64, other| most.max((other - own[state]).mag()))
            })
            .collect();
        let shortest = moved.hi() * 0.9;
        let piece = &acting.piece;
        let given = (inputs, &extra[..]);
        let prepared = piece.prepare(&self.form, &mut acting.scratch, given, moved, shortest);
        let prepared = prepared.ok()?;
        if !prepared.last {
            return None;
        }
        let end = Piece::last(moved, prepared.unit);
        let arrival = piece
            .arrival(&self.form, &acting.scratch, &prepared, &end)
            .ok()?;
        let mut form = self.form.clone();
        arrival.land(&mut form);
        Some(form)
    }
}

/// A form of the same unknowns in which states depend on nothing.
fn boxed(form: &Form, states: &[Interval]) -> Form {
    let mut form = form.clone();
    let all: Vec<Option<Interval>> = states.iter().map(|x| Some(*x)).collect();
    form.put(&all);
    form
}

impl Form {
    /// Blames unknowns, by their shares, for what is no function of any, where it was less `before`.
    pub(super) fn tear(&mut self, before: &[f64], shares: &[f64]) {
        let pairs = self.excesses().into_iter().zip(before);
        let lost: f64 = pairs.map(|(now, before)| (now - before).max(0.0)).sum();
        let torn = self.torn.iter_mut().zip(shares);
        torn.for_each(|(torn, share)| *torn += lost * share);
    }

    /// Puts states to intervals where these are narrower than the form.
    ///
    /// Guarantee: that of [`Form`] for the solutions whose states lie in `states` now.
    pub fn restrict(&mut self, states: &[Interval]) {
        let own = self.quick_hull();
        let both = own.iter().zip(states);
        let narrower = both.map(|(own, known)| {
            let is_narrower = known.width() < NARROWER * own.width();
            is_narrower.then_some(*known)
        });
        let narrower: Vec<Option<Interval>> = narrower.collect();
        if narrower.iter().any(Option::is_some) {
            self.put(&narrower);
        }
    }

    /// Some states lie in these intervals, and nothing else is known of them.
    pub(super) fn put(&mut self, known: &[Option<Interval>]) {
        let n = self.states.len();
        let mut map = vec![Interval::ZERO; n * n];
        let mut more = vec![Interval::ZERO; n];
        for (state, known) in known.iter().enumerate() {
            let Some(x) = known else {
                map[state * n + state] = Interval::ONE;
                continue;
            };
            let middle = x.mid();
            self.states[state].fill(0.0);
            self.states[state][0] = middle;
            more[state] = *x - Interval::point(middle);
        }
        self.transport(&map, &vec![0.0; n], &more);
    }
}
