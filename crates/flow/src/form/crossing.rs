//! All solutions cross a surface, each at its own time.
//!
//! Let `e` be watched, with the wrong sign ahead: `e < 0` at the start of a window, say, and `e' >= G > 0` along
//! the right-hand side `f` at all times of the window, also beyond the surface. So every solution of `x' = f`
//! meets `e = 0` once.
//!
//! 1. A polynomial `σ(δ)` in the unknowns is computed that nearly solves `e(X(δ, σ(δ))) = 0`; no claim is made.
//! 2. At the time `σ(δ)` the solution of `x' = f`, continued beyond the surface if need be, lies in
//!    `x ∈ X(δ, σ(δ)) + d`; from this follows `|e(x)| <= γ`.
//! 3. *Lemma.* The true solution meets the surface at a time `τ` with `σ(δ) - τ = e(x) / G'` for some mean `G'` of
//!    `e'` between. Let `R` be what happens there (nothing, or a jump), and `f2` the right-hand side
//!    afterwards. The solution of `y' = f2` through `R` at time `τ` is at time `σ(δ)` in
//!    `R(X) + (DR + J ∇e / G) d + J e(X) / G`, where `J` contains `f2 - DR f` near the surface.
//!
//!    *Proof.* `y(σ) = R(x(σ)) + ∫_τ^σ (f2(y) - DR f(x)) dt`, the integral is `(σ - τ)` times a mean, and
//!    `e(x) = e(X) + ∇e d` with a mean slope.
//! 4. From there the form goes on along `f2`, for every `δ` as long as is left to a common end after the
//!    last crossing. Before `τ` that solution is only imagined; after `τ` it is the true one, because what the
//!    new regime watches keeps its sign (`regime.rs`).
//!
//! So dependence on the unknowns survives, also in second and higher order; `DR + J ∇e / G` is the saltation matrix, which
//! erases what capture into a surface erases. Inputs that change during the window are taken as any
//! function within their hull, where they are not taken sample by sample (`sampled.rs`); so a set that straddles a sample is not torn.
//!
//! A surface that is held is left where a watched rate off it changes its sign: `e` is that rate then.
//! Afterwards `e` goes on growing along both right-hand sides, so nothing is held any more, and the side
//! opposite still drives solutions back; almost everywhere the mode on the new side acts.
//!
//! Source: the saltation matrix is Aizerman and Gantmacher's, 1958; times as polynomials are own.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one entry per state, matrices `n * n`, probes and watches in the same order"
)]

use super::ahead::{around, later};
use super::creeping::{Creep, Leaving};
use super::frame::Frame;
use super::journey::{Acting, Arriving, Journey};
use super::merging::Slice;
use super::monomials::Monomials;
use super::outward::{UNIT, raised};
use super::parting::{Turn, Undecided};
use super::piece::{OnBox, Piece};
use super::range::range;
use super::regime::{Field, Reason, Regime, Watch};
use super::set::Form;
use super::step::{Arrival, End, Prepared};
use super::surfaces::Signs;
use veribound_interval::Interval;
use veribound_interval::round::{add_up, sub_down, sub_up};
use veribound_model::Level;

/// Windows are longer than they should have to be by the first share, or else by the second.
const SPARE: [f64; 2] = [0.3, 1.5];

/// What a try takes, in multiplications of polynomials.
const TRY: f64 = 8.0;

/// Steps across may be so many times as long for how steep right-hand sides are.
const HURRY: f64 = 4.0;

impl Beyond {
    fn without_jump(regime: Regime, near: &[Interval]) -> Beyond {
        Beyond {
            regime,
            jump: None,
            after: near.to_vec(),
            leaving: None,
        }
    }
}

/// What happens on the surface.
pub(super) struct Passage {
    pub(super) regime: Regime,
    jump: Option<usize>,
    /// The rates afterwards, near the surface.
    pub(super) rates: Vec<Interval>,
    /// How far solutions go between crossing and the time computed for it.
    nearby: Vec<Interval>,
    /// What moves solutions away that may not be held.
    pub(super) leaving: Option<Leaving>,
}

/// What comes after a surface.
struct Beyond {
    regime: Regime,
    jump: Option<usize>,
    /// The box solutions start from there.
    after: Vec<Interval>,
    leaving: Option<Leaving>,
}

impl Journey<'_> {
    /// Takes the form across the zero of a watched expression; `None`, and nothing is changed, if that is
    /// not proved.
    pub(super) async fn cross(
        &mut self,
        acting: &mut Acting,
        watch: usize,
        unit: f64,
    ) -> Option<()> {
        let (root, spread) = acting.estimate(watch, unit)?;
        let window = root + (0.5 + SPARE[0]) * spread;
        if self.cross_by_samples(acting, watch, window).await.is_some() {
            return Some(());
        }
        for spare in SPARE {
            self.spend(TRY).await;
            if self
                .cross_within(acting, watch, (root, spread, spare))
                .is_some()
            {
                return Some(());
            }
        }
        None
    }

    fn cross_within(
        &mut self,
        acting: &mut Acting,
        watch: usize,
        (root, spread, spare): (f64, f64, f64),
    ) -> Option<()> {
        let flow = self.flow;
        let seconds = root + (0.5 + spare) * spread;
        let (inputs, seconds) = self.window(seconds, root + 0.5 * spread)?;
        if !acting.steady(&inputs)[watch] || !acting.holds_on(&inputs) {
            return None;
        }
        let begin = &self.form;
        let prepared = acting.prepare_seconds((begin, begin), &inputs, seconds)?;
        let (unit, span) = (prepared.unit, prepared.bounds.span);
        let asked = acting.regime.watches[watch];
        let speed = acting.speed_across(begin, &inputs, watch, span)?;
        let scaled = acting.times(begin, watch, root / unit)?;
        let times = range(&begin.monomials, &scaled);
        if times.lo() < 0.0 || times.hi() > span {
            return None;
        }
        let end = End::Own {
            scaled: scaled.clone(),
            last: span,
        };
        let arrival = acting
            .piece
            .arrival(begin, &acting.scratch, &prepared, &end)
            .ok()?;
        let deviation = arrival.deviation(&begin.frame.hull());
        let slopes = acting.slopes_of(watch);
        let left_over = acting.left_over(begin, watch, &scaled);
        let off = slopes
            .iter()
            .zip(&deviation)
            .fold(left_over, |sum, (slope, d)| sum + *slope * *d);
        // Seconds between a crossing and the time computed for it.
        let apart = (off / speed).mag();
        if add_up((times * Interval::point(unit)).hi(), apart) > span * unit {
            return None;
        }
        let passage = self.passage((&*acting, &inputs), asked, (&arrival, &deviation), apart);
        let passage = match passage {
            Ok(passage) => passage,
            Err(undecided) => {
                self.undecided = undecided;
                return None;
            }
        };
        let form = self.landed(
            (&*acting, &inputs),
            &arrival,
            &passage,
            (&slopes, speed, left_over),
        )?;
        // Afterwards, to a common end.
        // What is held must be left by so much that it can be seen.
        let clear = if matches!(asked.reason, Reason::Hold { .. }) {
            4.0
        } else {
            1.1
        };
        let margin = (clear * apart / unit)
            .max(0.02 * times.width())
            .max(1e-12 * span);
        let last = times.hi() + margin;
        if last > span {
            return None;
        }
        let mut next = Acting::new(flow, passage.regime.clone(), &form);
        let mut rest: Vec<f64> = scaled.iter().map(|x| -x).collect();
        rest[0] = last - scaled[0];
        let moved = (Interval::point(scaled[0]) + Interval::point(rest[0])) * Interval::point(unit);
        let next_one = (&mut next, form, &inputs[..]);
        let (landing, second) = self.afterwards(next_one, asked, (rest, unit), &passage)?;
        let creep = match &passage.leaving {
            None => None,
            Some(leaving) => {
                // Times are long beside what is between them: their difference is rounded outward, not raised.
                let first = sub_down(times.lo() * unit, apart).max(0.0);
                let creep = Creep::new(&next, leaving.clone(), landing.clone())?;
                let since = sub_up(moved.hi(), first);
                Some(self.crept(creep, &inputs, since)?)
            }
        };
        let before = (&*acting, &prepared, &arrival);
        let times = (&scaled[..], moved, apart);
        self.pass(
            before,
            (&next, &second.0, &second.1),
            (landing, creep),
            times,
            (&passage, self.captured(asked, &passage)),
        )
    }

    /// The level of a state that all solutions cross to and stay on.
    pub(super) fn captured(&self, asked: Watch, passage: &Passage) -> Option<Captured> {
        let Reason::Side { surface } = asked.reason else {
            return None;
        };
        if passage.regime.signs[surface] != Signs::ZERO || passage.jump.is_some() {
            return None;
        }
        let level = self.flow.switching.surfaces.list[surface].level?;
        Some(Captured {
            state: level.state,
            value: level.value,
            from_above: (asked.sign == Signs::POSITIVE) == level.rising,
        })
    }

    /// The hull of the inputs from now on for at least `least` and at most `seconds`, and for how long.
    pub(super) fn window(&self, seconds: f64, least: f64) -> Option<(Vec<Interval>, f64)> {
        let mut inputs = self.inputs().to_vec();
        let mut reach = self.left;
        for stretch in &self.stretches[self.current + 1..] {
            if reach.lo() >= seconds {
                break;
            }
            reach += stretch.dt;
            for (hull, input) in inputs.iter_mut().zip(&stretch.inputs) {
                *hull = hull.hull(*input);
            }
        }
        // Beyond the last stretch the last inputs go on, where the form need not stop there.
        if reach.lo() >= seconds || !self.whole_at_end {
            return Some((inputs, seconds));
        }
        (reach.lo() >= least).then_some((inputs, reach.lo()))
    }

    /// What happens on the surface.
    ///
    /// Errors: what is undecided there, if only that stands in the way.
    pub(super) fn passage(
        &self,
        (acting, inputs): (&Acting, &[Interval]),
        asked: Watch,
        (arrival, deviation): (&Arrival, &[Interval]),
        apart: f64,
    ) -> Result<Passage, Option<Undecided>> {
        let flow = self.flow;
        let on_it: Vec<Interval> = arrival
            .states
            .iter()
            .zip(deviation)
            .map(|(polynomial, d)| around(polynomial) + d.hull(Interval::ZERO))
            .collect();
        let mut reach: Vec<f64> = vec![0.0; on_it.len()];
        for _ in 0..4 {
            let near = inflated(&on_it, &reach);
            let quantities = self.quantities(&near, inputs);
            let mut field = flow.switching.field(&quantities).ok_or(None)?;
            let before = acting.piece.on_box(&quantities).ok_or(None)?.rates;
            let form = || self.near((arrival, deviation), &reach);
            let Beyond {
                regime,
                jump,
                after,
                leaving,
            } = self.beyond((acting, asked), &mut field, (&near, inputs), &form)?;
            let piece = flow.piece(&regime);
            let after = inflated(&after, &reach);
            let quantities = self.quantities(&after, inputs);
            let OnBox { rates, watched } = piece.on_box(&quantities).ok_or(None)?;
            let wider: Vec<f64> = before
                .iter()
                .zip(&rates)
                .map(|(a, b)| raised(1.1 * apart * (a.mag() + b.mag()), 4))
                .collect();
            // Both solutions stay in the box between the two times.
            if wider.iter().zip(&reach).all(|(w, r)| *w <= 1.1 * r) {
                let form = jump.is_none().then_some(&form as &dyn Fn() -> Form);
                if !self.keeps_to((&regime, &leaving), asked, &watched, (form, inputs)) {
                    return Err(None);
                }
                return Ok(Passage {
                    regime,
                    jump,
                    rates,
                    nearby: near,
                    leaving,
                });
            }
            reach = wider.iter().map(|w| 1.2 * w).collect();
        }
        Err(None)
    }

    /// All solutions at the times computed for their crossings, and `reach` around.
    fn near(&self, (arrival, deviation): (&Arrival, &[Interval]), reach: &[f64]) -> Form {
        let mut form = self.form.clone();
        form.states.clone_from(&arrival.states);
        let off = deviation.iter().map(|d| d.hull(Interval::ZERO));
        let off: Vec<Interval> = off.collect();
        form.frame = Frame::upright(inflated(&off, reach));
        form
    }

    /// Whether a regime lasts from the crossing to the time computed for it, where what it watches has these
    /// values and rates, and solutions are in `form`, if there is one.
    fn keeps_to(
        &self,
        (regime, leaving): (&Regime, &Option<Leaving>),
        asked: Watch,
        watched: &[[Interval; 2]],
        (form, inputs): (Option<&dyn Fn() -> Form>, &[Interval]),
    ) -> bool {
        let mut watches = regime.watches.iter().zip(watched);
        watches.all(|(own, [value, rate])| {
            let is_exact = |input: usize| inputs[input].is_point();
            let is_steady = || self.flow.inputs_of(own.expr).into_iter().all(is_exact);
            let is_left = || leaving.as_ref().is_some_and(|leaving| leaving.asks(own));
            let moving = || Watch {
                expr: self.flow.rate_of(own.expr, regime),
                ..*own
            };
            let on_form = || {
                form.is_some_and(|form| {
                    let form = form();
                    self.has_sign(&form, *own, inputs)
                        || (is_steady() && self.has_sign(&form, moving(), inputs))
                })
            };
            follows(asked, *own)
                || Signs::strict(*value) == Some(own.sign)
                || (Signs::strict(*rate) == Some(own.sign) && is_steady())
                || is_left()
                || on_form()
        })
    }

    /// What comes after the surface.
    ///
    /// Errors: what is undecided there, if only that stands in the way.
    fn beyond(
        &self,
        (acting, asked): (&Acting, Watch),
        field: &mut Field,
        (near, inputs): (&[Interval], &[Interval]),
        form: &dyn Fn() -> Form,
    ) -> Result<Beyond, Option<Undecided>> {
        let flow = self.flow;
        let mut signs = flow.switching.narrowed(field.signs(), &acting.regime.signs);
        if let Reason::Side { surface } = asked.reason {
            let way = asked.sign.flipped();
            signs[surface] = Signs::ZERO;
            if !flow.switching.jump_possible(&signs) {
                let regime = match self.resolve_on((field, &signs), form, inputs) {
                    Ok(regime) => regime,
                    Err(open) => {
                        let undecided = self.undecided_at(surface, field, &signs, open);
                        let undecided = undecided.ok_or(None)?;
                        if let Some((regime, leaving)) = self.leaving(field, signs, &undecided) {
                            return Ok(Beyond {
                                regime,
                                jump: None,
                                after: near.to_vec(),
                                leaving: Some(leaving),
                            });
                        }
                        return Err(Some(undecided));
                    }
                };
                // What acts on both sides is not watched any more.
                let goes_on = [way, Signs::ZERO, Signs::ANY].contains(&regime.signs[surface]);
                return goes_on
                    .then(|| Beyond::without_jump(regime, near))
                    .ok_or(None);
            }
        }
        let next = self.certain_beyond((acting, asked), field, (near, inputs), signs);
        next.ok_or(None)
    }

    /// As [`Journey::beyond`], where something jumps on a surface, or it is none.
    fn certain_beyond(
        &self,
        (acting, asked): (&Acting, Watch),
        field: &Field,
        (near, inputs): (&[Interval], &[Interval]),
        mut signs: Vec<Signs>,
    ) -> Option<Beyond> {
        let flow = self.flow;
        match asked.reason {
            Reason::Kink => {
                // The same modes go on; only the kink is on the other side.
                let mut regime = flow.unbent(field, &signs)?;
                flow.straighten(field, (asked.expr, asked.sign.flipped()), &mut regime);
                Some(Beyond::without_jump(regime, near))
            }
            Reason::Side { surface } => {
                let mut far = signs.clone();
                far[surface] = asked.sign.flipped();
                let jump = flow.switching.certain_jump(&signs, &far)?;
                let (after, keeps) =
                    flow.switching
                        .image(jump, surface, &self.quantities(near, inputs))?;
                let field = flow.switching.field(&self.quantities(&after, inputs))?;
                let mut signs = field.signs();
                if keeps {
                    signs[surface] = Signs::ZERO;
                }
                let mut regime = flow.resolve(Some(&field), &signs)?;
                // Where solutions leave the surface, they stay on that side of it for the window.
                if keeps
                    && regime.signs[surface] == Signs::ANY
                    && let Some(way) = flow.switching.leaves(surface, &field, &signs)
                {
                    regime.signs[surface] = way;
                    regime.watches.push(Watch {
                        expr: asked.expr,
                        sign: way,
                        reason: asked.reason,
                    });
                }
                Some(Beyond {
                    regime,
                    jump: Some(jump),
                    after,
                    leaving: None,
                })
            }
            Reason::Hold { surface, side } => {
                signs[surface] = side;
                let mut regime = flow.resolve(Some(field), &signs)?;
                if flow.switching.jump_possible(&signs) || regime.signs[surface] != side {
                    return None;
                }
                // It has to go on growing, and the other side has to drive back.
                regime.watches.push(Watch {
                    sign: asked.sign.flipped(),
                    ..asked
                });
                let other = acting.regime.watches.iter().filter(|watch| {
                    matches!(watch.reason, Reason::Hold { surface: held, side: own }
                        if held == surface && own != side)
                });
                regime.watches.extend(other);
                let barred = flow.back_from_bar(surface, &acting.regime, Some(asked.expr))?;
                regime.watches.extend(barred);
                let same_side = |watch: &&Watch| watch.reason == asked.reason;
                let alone = acting.regime.watches.iter().filter(same_side).count() == 1;
                alone.then(|| Beyond::without_jump(regime, near))
            }
        }
    }

    /// The form at the time of its own for every `δ`, on the other right-hand side.
    pub(super) fn landed(
        &self,
        (acting, inputs): (&Acting, &[Interval]),
        arrival: &Arrival,
        passage: &Passage,
        (slopes, speed, left_over): (&[Interval], Interval, Interval),
    ) -> Option<Form> {
        let n = slopes.len();
        let quantities = self.quantities(&passage.nearby, inputs);
        let before = acting.piece.on_box(&quantities)?.rates;
        let mut states = arrival.states.clone();
        // DR, and what rounding takes from R(X).
        let mut change = vec![Interval::ZERO; n * n];
        for i in 0..n {
            change[i * n + i] = Interval::ONE;
        }
        let mut more = vec![Interval::ZERO; n];
        if let Some(jump) = passage.jump {
            let set = &self.flow.switching.sets[jump];
            let (_, slopes) = set.on_box(&quantities)?;
            let mut still = self.form.without_rest();
            still.states.clone_from(&states);
            for (position, &state) in set.states.iter().enumerate() {
                let (polynomial, off) = still.evaluate(&set.values[position], inputs).ok()?;
                states[state] = polynomial;
                more[state] = Interval::symmetric(off);
                change[state * n..(state + 1) * n].fill(Interval::ZERO);
            }
            for (state, from, slope) in slopes {
                change[state * n + from] = slope;
            }
        }
        let mut saltation = change.clone();
        for i in 0..n {
            let row = &change[i * n..(i + 1) * n];
            let moved = row
                .iter()
                .zip(&before)
                .fold(Interval::ZERO, |sum, (m, f)| sum + *m * *f);
            let jump = (passage.rates[i] - moved) / speed;
            more[i] += jump * left_over;
            for (l, slope) in slopes.iter().enumerate() {
                saltation[i * n + l] += jump * *slope;
            }
        }
        for i in 0..n {
            let row = &saltation[i * n..(i + 1) * n];
            let terms = row.iter().zip(&arrival.more);
            more[i] += terms.fold(Interval::ZERO, |sum, (m, x)| sum + *m * *x);
        }
        let mut map = vec![Interval::ZERO; n * n];
        for i in 0..n {
            for l in 0..n {
                let m = saltation[i * n + l];
                if m != Interval::ZERO {
                    for c in 0..n {
                        map[i * n + c] += m * arrival.map[l * n + c];
                    }
                }
            }
        }
        let mut landing = Arrival {
            states,
            lows: vec![0.0; n],
            map,
            more,
            during: Vec::new(),
        };
        self.hold(&passage.regime, &mut landing);
        let mut form = self.form.clone();
        landing.land(&mut form);
        Some(form)
    }

    /// Along the next regime, for every `δ` as long as `rest` says in units of `unit`.
    fn afterwards(
        &self,
        (next, form, inputs): (&mut Acting, Form, &[Interval]),
        asked: Watch,
        (rest, unit): (Vec<f64>, f64),
        passage: &Passage,
    ) -> Option<(Form, (Form, Prepared))> {
        let longest = around(&rest).hi() * unit;
        let forms = (&form, &self.form);
        let prepared = next.prepare_seconds(forms, inputs, raised(longest, 2))?;
        if !prepared.last || !next.lasts((&form, inputs), &prepared, asked, passage) {
            return None;
        }
        let ratio = unit / prepared.unit;
        let end = End::Own {
            scaled: rest.iter().map(|x| x * ratio).collect(),
            last: prepared.bounds.span,
        };
        let arrival = next
            .piece
            .arrival(&form, &next.scratch, &prepared, &end)
            .ok()?;
        let mut after = form.clone();
        after.tube.clone_from(&arrival.during);
        arrival.land(&mut after);
        after.settle().ok()?;
        Some((after, (form, prepared)))
    }

    /// Takes the landing over, and tells where solutions are at the ends of stretches within the window.
    fn pass(
        &mut self,
        (acting, prepared, arrival): (&Acting, &Prepared, &Arrival),
        (next, second, after): (&Acting, &Form, &Prepared),
        (mut landing, creep): (Form, Option<Creep>),
        (scaled, moved, apart): (&[f64], Interval, f64),
        (passage, captured): (&Passage, Option<Captured>),
    ) -> Option<()> {
        // The second step begins at the time computed, which may be `apart` after the crossing.
        if let Some(creep) = &creep {
            landing = creep.form();
            for (tube, by) in landing.tube.iter_mut().zip(&creep.spread) {
                *tube += by.hull(Interval::ZERO);
            }
        }
        let mut signs = next.regime.signs.clone();
        if let Some(leaving) = &passage.leaving {
            signs[leaving.surface] = Signs::ANY;
        }
        let early = passage
            .rates
            .iter()
            .map(|rate| raised(apart * rate.mag(), 1));
        let after_it = landing.tube.iter().zip(early);
        let tube: Vec<Interval> = arrival
            .during
            .iter()
            .zip(after_it)
            .map(|(before, (after, early))| before.hull(after.inflate(early)))
            .collect();
        let unit = prepared.unit;
        let times = around(scaled) * Interval::point(unit);
        let (mut current, mut left, mut since) = (self.current, self.left, Interval::ZERO);
        let (mut passed, mut passing) = (Vec::new(), Vec::new());
        // Who meets forms asks them for what is wanted.
        let turn = self.meet.is_none().then(|| Turn::new(&self.form, scaled));
        let turn = turn.flatten();
        let already = self.form.tube.iter().zip(&tube);
        let mut tube_now: Vec<Interval> = already.map(|(a, b)| a.hull(*b)).collect();
        while current < self.stretches.len() && (since + left).lo() < moved.hi() {
            since += left;
            if since.hi() > moved.lo() {
                return None;
            }
            let mut before = None;
            if since.lo() <= times.hi() + apart {
                // Nobody is on this side after the last crossing.
                let last = since.hi().min(raised(times.hi() + apart, 1));
                let end = Piece::last(Interval::new(since.lo(), last)?, unit);
                let place = acting
                    .piece
                    .arrival(&self.form, &acting.scratch, prepared, &end);
                before = Some(place.ok()?.place(&self.form));
            }
            let mut behind = None;
            if since.hi() >= times.lo() - apart {
                let late = (next, second, after);
                let mut place = self.late(late, (scaled, unit), since, (apart, passage))?;
                if let Some(creep) = &creep {
                    for (off, by) in place.deviation.iter_mut().zip(&creep.spread) {
                        *off += *by;
                    }
                }
                behind = Some(place);
            }
            // Those that cross then or later, and those that have crossed.
            let share = turn.as_ref().map(|turn| {
                let scaled_time = since.inflate(apart) / Interval::point(unit);
                let since_middle = scaled_time - Interval::point(scaled[0]);
                // Coefficients of the new unknown add up to at most one, and are rounded.
                let share = since_middle / Interval::point(turn.size);
                share.inflate(2.0 * f64::EPSILON)
            });
            let hull = |place: &Option<Place>, is_early: bool| {
                let Some(place) = place.as_ref() else {
                    return Vec::new();
                };
                let (from, to) = match share {
                    Some(share) if is_early => (share.lo().max(-1.0), 1.0),
                    Some(share) => (-1.0, share.hi().min(1.0)),
                    None => (-1.0, 1.0),
                };
                match (&turn, Interval::new(from, to)) {
                    (Some(turn), Some(at)) => {
                        let form = &place.clone().of(&self.form);
                        turn.hull(&Slice { form, place: at })
                    }
                    _ => place.hull(&self.form.monomials),
                }
            };
            let (mut early, mut late) = (hull(&before, true), hull(&behind, false));
            self.clip(&acting.regime.signs, &mut early);
            self.clip(&signs, &mut late);
            let end: Vec<Interval> = match (early.is_empty(), late.is_empty()) {
                (false, false) => early.iter().zip(&late).map(|(a, b)| a.hull(*b)).collect(),
                (true, _) => late,
                (_, true) => early,
            };
            if self.meet.is_some() {
                let is_ahead = since.hi() <= times.hi() + apart;
                let arriving = match (&captured, &before) {
                    (Some(captured), Some(place)) if is_ahead => {
                        Some(captured.arriving(&place.clone().of(&self.form)))
                    }
                    _ => None,
                };
                let are_late = before.is_none();
                let copy = before.into_iter().chain(behind).reduce(Place::either);
                let mut copy = copy.map(|place| place.of(&self.form));
                if let (Some(copy), Some(captured), true) = (&mut copy, &captured, are_late) {
                    let mut known = vec![None; copy.states.len()];
                    known[captured.state] = Some(captured.value);
                    copy.put(&known);
                }
                passing.extend(copy.map(|copy| (current + 1, copy, arriving)));
            }
            passed.push((end, std::mem::replace(&mut tube_now, tube.clone())));
            current += 1;
            left = self
                .stretches
                .get(current)
                .map_or(Interval::ZERO, |stretch| stretch.dt);
        }
        let mut modes = acting.regime.modes.union(next.regime.modes);
        if let Some(leaving) = &passage.leaving {
            modes = modes.union(leaving.regime.modes);
        }
        self.proved.steps += 2;
        self.passed_by = passing;
        for (stretch, (end, whole)) in (self.current..).zip(passed) {
            let outputs = self.outputs_on(&tube, &self.stretches[stretch].inputs);
            self.proved.pass(&outputs, modes);
            let next = self.stretches.get(stretch + 1);
            let outputs = next.map(|next| self.outputs_on(&end, &next.inputs));
            self.proved.end(end, whole);
            outputs
                .into_iter()
                .for_each(|outputs| self.proved.begin(outputs));
        }
        if let Some(stretch) = self.stretches.get(current) {
            let outputs = self.outputs_on(&tube, &stretch.inputs);
            self.proved.pass(&outputs, modes);
        }
        let begin = self.form.elapsed;
        let begun = current != self.current;
        self.earlier.clear();
        self.form = landing;
        self.form.elapsed = begin + since;
        if begun {
            self.enter(current);
        }
        self.form.elapsed = begin + moved;
        self.form.tube = tube_now;
        self.form.signs = signs;
        self.left = left - (moved - since);
        self.creep = creep;
        Some(())
    }

    /// Where solutions are at a time of the window that have crossed before it.
    ///
    /// Those that cross up to `apart` before the time computed for them are told by how far any goes in
    /// that time.
    pub(super) fn late(
        &self,
        (next, second, after): (&Acting, &Form, &Prepared),
        (scaled, unit): (&[f64], f64),
        since: Interval,
        (apart, passage): (f64, &Passage),
    ) -> Option<Place> {
        let scale = unit / after.unit;
        let mut own: Vec<f64> = scaled.iter().map(|x| -x * scale).collect();
        let middle = since.mid();
        own[0] = middle / after.unit - scaled[0] * scale;
        let size = since.mag() + (scaled[0] * unit).abs();
        let off = raised(
            (since - Interval::point(middle)).mag() + 4.0 * f64::EPSILON * size,
            4,
        );
        let end = End::Own {
            scaled: own,
            last: after.bounds.span,
        };
        let mut place = next
            .piece
            .arrival(second, &next.scratch, after, &end)
            .ok()?;
        for (i, more) in place.more.iter_mut().enumerate() {
            let rate = next.piece.rates[i];
            let speed = next.scratch.errors.sizes[rate].total + next.scratch.radii[1][rate];
            let by = (off + 2.0 * apart) * speed + apart * passage.rates[i].mag();
            *more += Interval::symmetric(raised(by, 8));
        }
        Some(place.place(second))
    }

    /// Cuts a box of states with what is known of the surfaces.
    pub(super) fn clip(&self, signs: &[Signs], states: &mut [Interval]) {
        if states.is_empty() {
            return;
        }
        for (surface, signs) in signs.iter().enumerate() {
            if !matches!(*signs, Signs::NEGATIVE | Signs::ZERO | Signs::POSITIVE) {
                continue;
            }
            let Some(Level {
                state,
                value,
                rising,
                ..
            }) = self.flow.switching.surfaces.list[surface].level
            else {
                continue;
            };
            let above = if rising { *signs } else { signs.flipped() };
            let part = match above {
                Signs::POSITIVE => Interval::new(value.lo(), f64::INFINITY),
                Signs::NEGATIVE => Interval::new(f64::NEG_INFINITY, value.hi()),
                _ => Some(value),
            };
            let clipped = part.map_or(Interval::EMPTY, |part| states[state].intersect(part));
            if !clipped.is_empty() {
                states[state] = clipped;
            }
        }
    }
}

impl Acting {
    /// About when the middle of the set meets the zero of what is watched, and how long the whole set takes,
    /// in seconds.
    fn estimate(&self, watch: usize, unit: f64) -> Option<(f64, f64)> {
        let (root, speed) = self.root(watch, unit);
        let takes = self.spread(watch) / speed;
        (root >= 0.0 && root.is_finite() && takes.is_finite()).then_some((root, takes))
    }

    /// About when the middle of the set meets the zero of what is watched, before or after the start, in seconds,
    /// and how fast.
    pub(super) fn root(&self, watch: usize, unit: f64) -> (f64, f64) {
        let probe = &self.piece.probes[watch];
        let [value, rate] = [probe.value, probe.rate].map(|register| {
            let top = self.scratch.errors.sizes[register].top;
            self.scratch.series.block(register)[..=top].to_vec()
        });
        let at = |row: &[f64], s: f64| row.iter().rev().fold(0.0, |sum, x| sum * s + x);
        let mut s = 0.0;
        for _ in 0..12 {
            s -= at(&value, s) / (at(&rate, s) * unit);
        }
        (s * unit, at(&rate, s).abs())
    }

    /// Whether the next regime goes on to the end of a prepared step, from the surface that was `asked` for.
    pub(super) fn lasts(
        &self,
        (form, inputs): (&Form, &[Interval]),
        prepared: &Prepared,
        asked: Watch,
        passage: &Passage,
    ) -> bool {
        let steady = self.steady(inputs);
        let span = prepared.bounds.span;
        let mut watches = self.regime.watches.iter().enumerate();
        watches.all(|(watch, own)| {
            let leaving = passage.leaving.as_ref();
            if leaving.is_some_and(|leaving| leaving.asks(own)) || follows(asked, *own) {
                return true;
            }
            if own.reason == asked.reason && own.expr == asked.expr {
                let rate = self.piece.probes[watch].rate;
                let whole = Interval::new(0.0, span).unwrap_or(Interval::ENTIRE);
                let rate = self
                    .piece
                    .during(&self.scratch, &form.monomials, rate, whole);
                return steady[watch] && Signs::strict(rate) == Some(own.sign);
            }
            let place = (&self.scratch, &*form.monomials);
            let own = (watch, own.sign, steady[watch]);
            self.piece.is_calm(place, own, span)
        })
    }

    /// The rate of what is watched at all times of a prepared step, if it moves towards its zero at all of them, and
    /// nothing else that is watched may change its sign.
    pub(super) fn speed_across(
        &self,
        form: &Form,
        inputs: &[Interval],
        watch: usize,
        span: f64,
    ) -> Option<Interval> {
        let steady = self.steady(inputs);
        let others = self.regime.watches.iter().enumerate();
        let mut others = others.filter(|(other, _)| *other != watch);
        let place = (&self.scratch, &*form.monomials);
        let all_calm = others.all(|(other, asked)| {
            let asked = (other, asked.sign, steady[other]);
            self.piece.is_calm(place, asked, span)
        });
        if !all_calm {
            return None;
        }
        let whole = Interval::new(0.0, span)?;
        let rate = self.piece.probes[watch].rate;
        let speed = self
            .piece
            .during(&self.scratch, &form.monomials, rate, whole);
        let falls = Signs::strict(speed)? == self.regime.watches[watch].sign.flipped();
        falls.then_some(speed)
    }

    /// How what is watched depends on the states, at all times of a prepared step.
    pub(super) fn slopes_of(&self, watch: usize) -> Vec<Interval> {
        let probe = &self.piece.probes[watch];
        self.piece.slopes_of(&self.scratch, probe)
    }

    /// A prepared step of at most so many seconds, of a form that was another one before the surface.
    pub(super) fn prepare_seconds(
        &mut self,
        (form, before): (&Form, &Form),
        inputs: &[Interval],
        seconds: f64,
    ) -> Option<Prepared> {
        let longest = Interval::point(seconds);
        // All cross in one step, also where a step on the way would rather be shorter.
        let mut hurried = form.clone();
        // On the surface a state has next to no width, for which a step would be short; at its end it is wide again.
        hurried.neglect_as(before);
        hurried.options.steepest *= HURRY;
        self.prepare(&hurried, inputs, longest, 1e-3 * seconds).ok()
    }

    /// Scaled times at which what is watched is nearly zero, as polynomial in the unknowns.
    pub(super) fn times(&self, form: &Form, watch: usize, root: f64) -> Option<Vec<f64>> {
        let probe = &self.piece.probes[watch];
        let top = self.scratch.errors.sizes[probe.value].top;
        let block = self.scratch.series.block(probe.value);
        let stride = self.scratch.series.stride;
        let mut times = vec![0.0; form.monomials.len()];
        times[0] = root;
        let slope = |s: f64| {
            let orders = block[1..=top].iter().enumerate().rev();
            orders.fold(0.0, |sum, (j, x)| sum * s + (j + 1) as f64 * x)
        };
        // Every round settles one more degree.
        for _ in 0..form.monomials.degree + 4 {
            let (off, _) = later(&form.monomials, block, (top, stride), &times);
            let slope = slope(times[0]);
            for (time, off) in times.iter_mut().zip(off) {
                *time -= off / slope;
            }
        }
        times.iter().all(|x| x.is_finite()).then_some(times)
    }

    /// What is watched, at these times and where nothing deviates.
    pub(super) fn left_over(&self, form: &Form, watch: usize, times: &[f64]) -> Interval {
        let register = self.piece.probes[watch].value;
        let top = self.scratch.errors.sizes[register].top;
        let block = self.scratch.series.block(register);
        let stride = self.scratch.series.stride;
        let (value, lost) = later(&form.monomials, block, (top, stride), times);
        let off = raised(lost + self.scratch.radii[0][register], 1);
        around(&value).inflate(off)
    }
}

impl Arrival {
    /// How far solutions can be from the polynomials; `rest` is what dependence could not keep before.
    pub(super) fn deviation(&self, rest: &[Interval]) -> Vec<Interval> {
        let rows = self.map.chunks_exact(rest.len());
        let moved = rows.map(|row| {
            let terms = row.iter().zip(rest);
            terms.fold(Interval::ZERO, |sum, (m, x)| sum + *m * *x)
        });
        let low = self.lows.iter().map(|x| Interval::point(*x));
        let moved = moved.zip(low).zip(&self.more);
        moved.map(|((x, low), more)| x + low + *more).collect()
    }

    /// Where the states are; `before` is the form that arrives.
    fn place(self, before: &Form) -> Place {
        Place {
            deviation: self.deviation(&before.frame.hull()),
            states: self.states,
            during: self.during,
        }
    }
}

/// Where states are at one time of a window: polynomials in the unknowns, and how far from them.
#[derive(Clone)]
pub(super) struct Place {
    states: Vec<Vec<f64>>,
    deviation: Vec<Interval>,
    /// At all times of the step that leads there.
    pub(super) during: Vec<Interval>,
}

impl Place {
    fn hull(&self, monomials: &Monomials) -> Vec<Interval> {
        let list = self.states.iter().zip(&self.deviation);
        list.map(|(polynomial, d)| range(monomials, polynomial) + *d)
            .collect()
    }

    /// In this place or in that one: the polynomials of this one, and how far the others are from them.
    fn either(mut self, other: Place) -> Place {
        for (i, d) in self.deviation.iter_mut().enumerate() {
            let apart = difference(&other.states[i], &self.states[i]);
            *d = d.hull(apart + other.deviation[i]);
        }
        self
    }

    /// A form of the same unknowns as `form`, there.
    pub(super) fn of(self, form: &Form) -> Form {
        let mut copy = form.clone();
        copy.states = self.states;
        copy.frame = Frame::upright(self.deviation);
        copy
    }
}

/// A level that a state is captured by.
#[derive(Clone, Copy)]
pub(super) struct Captured {
    pub(super) state: usize,
    pub(super) value: Interval,
    /// Solutions come to it from above.
    from_above: bool,
}

impl Captured {
    /// Where the state would be if it were not captured, before or after the crossing, as in `ahead`.
    pub(super) fn arriving(&self, ahead: &Form) -> Arriving {
        let polynomial = &ahead.states[self.state];
        let rest = ahead.frame.hull()[self.state];
        Arriving {
            state: self.state,
            level: self.value,
            ahead: ahead.straight(polynomial, rest),
            from_above: self.from_above,
        }
    }
}

/// Encloses the values of the difference of two polynomials on the unit box.
fn difference(a: &[f64], b: &[f64]) -> Interval {
    let mut reach = 0.0;
    for (x, y) in a.iter().zip(b).skip(1) {
        reach += (x - y).abs() * (1.0 + 2.0 * UNIT);
    }
    let middle = Interval::point(a[0]) - Interval::point(b[0]);
    middle.inflate(raised(reach, a.len()))
}

/// Whether a watch follows from what was watched before going on to grow: a surface that is left.
fn follows(asked: Watch, own: Watch) -> bool {
    matches!(
        (asked.reason, own.reason),
        (Reason::Hold { surface, side }, Reason::Side { surface: other })
            if surface == other && own.sign == side
    )
}

fn inflated(x: &[Interval], by: &[f64]) -> Vec<Interval> {
    x.iter().zip(by).map(|(x, by)| x.inflate(*by)).collect()
}
