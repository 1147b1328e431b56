//! Solutions that stand, or leave so slowly that it cannot be told.
//!
//! On a surface `g = 0` a mode on one side of it, beyond, drives solutions off it or back to it at a rate so near to zero that
//! its sign is not known, while the other side drives back. Solutions that are held do not move at all.
//!
//! *Theorem.* Let `g` be a state less a level, `x = x0(δ) + Δ` with `g(x0) = 0` and `Δ` in a box `B` with `g >= 0` at
//! the start. Let on a larger box `B'`: the rate of `g` where `g < 0` be positive; where `g > 0` one regime act, `x' = f`;
//! and what is held on `g = 0` not move. With `r_i` at least zero and at least `f_i` on the part of `B'` in which `Δ_i` is at least
//! its upper bound in `B`, and likewise from below, all solutions have `Δ_i <= hi_i + r_i t` for as long as that leaves
//! `Δ` inside `B'`; and `g >= 0`.
//!
//! *Proof.* While `Δ` is in `B'`, `g` grows where it is negative; it starts at zero or above, so it never is negative. Where
//! `g > 0` velocities are `f`; almost everywhere on the times at which `g = 0` nothing moves. So `Δ_i' <= r_i` at almost
//! all times at which `Δ_i >= hi_i`, and `Δ_i - r_i t` cannot pass `hi_i`. Hence `Δ` stays inside of `B'` up to the time at which
//! the bounds leave it.
//!
//! *Theorem (work).* If besides `p' = g` for some states `p`, and all other states rest where `g > 0`, let `r_k` be at least `g'` for
//! all `Δp` in the cell from `x_k` to `x_(k+1)`, beginning with `x_0 = 0`, and `w_0 = 0`, `w_(k+1) >= w_k + 2 r_k (x_(k+1) - x_k)`. If some
//! `w_(k+1) <= 0`, no solution ever has `Δp > x_(k+1)`, nor `g^2` above the largest `w` before.
//!
//! *Proof.* `p` never turns back. Where it moves, `g > 0`, one regime acts and `(g^2)' = 2 g g' = 2 g' p'`: so `g^2` at `Δp = x` is at most
//! `w_k + 2 r_k (x - x_k)` in each cell, one after the other. To pass the end of the last one `g` would have to be positive there.
//!
//! Each bound moves with the rates on its own face, on which what drives back is as large as it may be. The rates are evaluated
//! on the form, so a pull and the friction that it has to overcome remain functions of the same unknowns. So where `x0` is a
//! rest, `Δ` grows like a power of time only, however long solutions hesitate.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one entry per state, surfaces by their positions in the list"
)]

use super::ahead::around;
use super::frame::Frame;
use super::journey::{Acting, Journey};
use super::outward::raised;
use super::parting::Undecided;
use super::regime::{Field, Reason, Regime, Watch};
use super::set::Form;
use super::surfaces::Signs;
use veribound_interval::Interval;
use veribound_model::{ExprId, Level};

/// Solutions stop after about so many cells.
const CELLS: f64 = 16.0;

/// Rounds in which bounds of rates may grow before they are given up.
const ROUNDS: usize = 12;

/// What moves solutions away from a surface if they are not held.
#[derive(Debug, Clone)]
pub(super) struct Leaving {
    pub(super) surface: usize,
    level: Level,
    /// The side they may leave to.
    way: Signs,
    /// How fast the mode there drives them.
    rate: ExprId,
    /// What acts there.
    pub(super) regime: Regime,
}

impl Leaving {
    /// Whether a watch asks for what is not known.
    pub(super) fn asks(&self, watch: &Watch) -> bool {
        watch.expr == self.rate
            && matches!(watch.reason, Reason::Hold { surface, side }
                if surface == self.surface && side == self.way)
    }

    /// Whether a watch asks for the side they leave to.
    fn is_beyond(&self, watch: &Watch) -> bool {
        watch.reason
            == Reason::Side {
                surface: self.surface,
            }
    }
}

/// Solutions that may have crept away.
#[derive(Debug, Clone)]
pub(super) struct Creep {
    leaving: Leaving,
    /// The regime in which they would be held.
    hold: Regime,
    /// Where they would stand.
    base: Form,
    /// How far they can be from there.
    pub(super) spread: Vec<Interval>,
    /// Whether they never are farther away.
    pub(super) is_final: bool,
}

impl Creep {
    /// Of solutions that have just come to a surface, if what is held there does not move.
    pub(super) fn new(held: &Acting, leaving: Leaving, base: Form) -> Option<Creep> {
        let code = &held.piece.code;
        let moves = |register: &usize| code.instructions[*register].moving;
        if code.states.iter().any(moves) {
            return None;
        }
        Some(Creep {
            hold: held.regime.clone(),
            leaving,
            spread: vec![Interval::ZERO; base.states.len()],
            is_final: false,
            base,
        })
    }

    /// The form of all solutions.
    pub(super) fn form(&self) -> Form {
        self.within(&self.spread)
    }

    /// The form with so much around where solutions would stand.
    fn within(&self, spread: &[Interval]) -> Form {
        let mut form = self.base.clone();
        let mut reach = self.base.frame.hull();
        for ((reach, by), polynomial) in reach.iter_mut().zip(spread).zip(&mut form.states) {
            // Around the middle, so that what depends on it is not taken on both sides of where it stands.
            let all = *reach + *by;
            let middle = all.mid();
            let moved = polynomial[0] + middle;
            *reach = all + Interval::point(polynomial[0]) - Interval::point(moved);
            polynomial[0] = moved;
        }
        form.frame = Frame::upright(reach);
        form
    }

    /// Whether nobody has left yet.
    fn is_new(&self) -> bool {
        self.spread.iter().all(|x| *x == Interval::ZERO)
    }

    /// Whether solutions leave to where the state is larger.
    fn upward(&self) -> bool {
        (self.leaving.way == Signs::POSITIVE) == self.leaving.level.rising
    }
}

impl Journey<'_> {
    /// The regime that would hold solutions at a surface of which it is not known whether they leave it, and
    /// what acts if they do; only where outcomes part so near that it does not matter.
    pub(super) fn leaving(
        &self,
        field: &mut Field,
        mut signs: Vec<Signs>,
        undecided: &Undecided,
    ) -> Option<(Regime, Leaving)> {
        if !self.is_border {
            return None;
        }
        let (surface, way) = (undecided.open.surface, undecided.way?);
        let known = &self.flow.switching.surfaces.list[surface];
        let level = known.level.filter(|_| known.inputs.is_empty())?;
        let back = (surface, undecided.open.mode, way.flipped());
        field.drifts.push(back);
        let held = self.flow.resolve(Some(field), &signs);
        field.drifts.pop();
        let mut held = held.filter(|held| held.signs[surface] == Signs::ZERO)?;
        // A stop bars the way only as long as nobody has left it.
        let back = self.flow.back_from_bar(surface, &held, None)?;
        held.watches.extend(back);
        for (surface, _) in std::mem::take(&mut held.bars) {
            let (rest, _) = self.flow.switching.needed_by_bar(surface, &held.signs);
            rest.into_iter()
                .for_each(|other| held.signs[other] = Signs::ANY);
        }
        signs[surface] = way;
        let regime = self.flow.resolve(Some(field), &signs)?;
        let leaving = Leaving {
            surface,
            level,
            way,
            rate: undecided.open.expr,
            regime,
        };
        Some((held, leaving))
    }

    /// Lets solutions creep that rest, where it is not known whether they leave; nothing happens where they may do something else.
    pub(super) fn creep_from_rest(&mut self) {
        let find = || {
            let undecided = self.regime().err()??;
            let mut field = self.field()?;
            let signs = self.signs(&field);
            let (hold, leaving) = self.leaving(&mut field, signs, &undecided)?;
            // What is held watches all other surfaces it knows of; and nobody is behind this one.
            let mut known = hold.signs.clone();
            known[leaving.surface] = leaving.way.or(Signs::ZERO);
            let held = Acting::new(self.flow, hold, &self.form);
            Some((known, Creep::new(&held, leaving, self.form.clone())?))
        };
        let Some((known, creep)) = find() else {
            return;
        };
        self.form.signs = known;
        self.creep = Some(creep);
    }

    /// Goes on to the end of the stretch.
    pub(super) fn creep_on(&mut self, creep: Creep) -> Option<()> {
        let inputs = self.inputs();
        let before = creep.form();
        let creep = self.crept(creep, inputs, self.left.hi())?;
        let after = creep.form();
        let reached = after.quick_hull();
        let begun = before.quick_hull();
        let tube: Vec<Interval> = begun
            .iter()
            .zip(&reached)
            .map(|(a, b)| a.hull(*b))
            .collect();
        let outputs = self.outputs_on(&tube, inputs);
        let modes = creep.hold.modes.union(creep.leaving.regime.modes);
        self.proved.pass(&outputs, modes);
        self.proved.steps += 1;
        let known = self.form.tube.iter().zip(&tube);
        let tube = known.map(|(a, b)| a.hull(*b)).collect();
        self.form = Form {
            tube,
            elapsed: self.form.elapsed + self.left,
            signs: std::mem::take(&mut self.form.signs),
            ..after
        };
        self.left = Interval::ZERO;
        self.creep = Some(creep);
        Some(())
    }

    /// How far solutions can be after so many seconds, and at all times before.
    pub(super) fn crept(
        &self,
        mut creep: Creep,
        inputs: &[Interval],
        seconds: f64,
    ) -> Option<Creep> {
        if !creep.is_final
            && creep.is_new()
            && let Some(spread) = self.farthest(&creep)
        {
            creep.spread = spread;
            creep.is_final = true;
        }
        if creep.is_final {
            return Some(creep);
        }
        let n = creep.spread.len();
        let standing = creep.leaving.level.state;
        let rates = creep.leaving.regime.rates.iter();
        let rates: Vec<_> = rates.map(|rate| self.flow.quantity(*rate)).collect();
        let time = Interval::new(0.0, seconds)?;
        // How fast bounds move, below and above.
        let mut speeds = vec![Interval::ZERO; n];
        for _ in 0..ROUNDS {
            let reached = creep.spread.iter().zip(&speeds);
            let during: Vec<Interval> = reached
                .map(|(x, speed)| {
                    let all = *x + time * *speed;
                    all.inflate(raised(1e-3 * all.width(), 1).max(1e-200))
                })
                .collect();
            let mut next = Vec::with_capacity(n);
            for (i, rate) in rates.iter().enumerate() {
                let face = |part: Option<Interval>| -> Option<Interval> {
                    let mut on_it = during.clone();
                    on_it[i] = part?;
                    // Nobody is behind the surface.
                    let beyond = if creep.upward() {
                        Interval::new(0.0, f64::INFINITY)
                    } else {
                        Interval::new(f64::NEG_INFINITY, 0.0)
                    };
                    on_it[standing] = on_it[standing].intersect(beyond?);
                    if on_it[standing].is_empty() {
                        return Some(Interval::ZERO);
                    }
                    let found = creep.within(&on_it).evaluate(rate, inputs);
                    let (polynomial, off) = found.ok()?;
                    Some(around(&polynomial).inflate(off))
                };
                let own = creep.spread[i];
                let above = face(Interval::new(own.hi(), during[i].hi()))?.hi().max(0.0);
                let below = face(Interval::new(during[i].lo(), own.lo()))?.lo().min(0.0);
                let (below, above) = match (i == standing, creep.upward()) {
                    (true, true) => (0.0, above),
                    (true, false) => (below, 0.0),
                    (false, _) => (below, above),
                };
                next.push(Interval::new(below, above)?);
            }
            let is_proved = next
                .iter()
                .zip(&speeds)
                .all(|(x, speed)| x.is_subset_of(*speed));
            if is_proved {
                if !self.stays_near(&creep, &during, inputs) {
                    return None;
                }
                let last = Interval::point(seconds);
                // The bounds that these speeds gave hold for what they were computed from.
                for (x, speed) in creep.spread.iter_mut().zip(&next) {
                    *x += last * *speed;
                }
                return Some(creep);
            }
            for (speed, next) in speeds.iter_mut().zip(&next) {
                let all = speed.hull(*next);
                *speed = Interval::new(1.1 * all.lo(), 1.1 * all.hi())?;
            }
        }
        None
    }

    /// How far solutions can ever be, from here to the end of the last stretch.
    fn farthest(&self, creep: &Creep) -> Option<Vec<Interval>> {
        let n = creep.spread.len();
        let level = creep.leaving.level;
        if level.value != Interval::ZERO {
            return None;
        }
        let mut inputs = self.inputs().to_vec();
        for stretch in &self.stretches[self.current..] {
            for (hull, input) in inputs.iter_mut().zip(&stretch.inputs) {
                *hull = hull.hull(*input);
            }
        }
        let rates = creep.leaving.regime.rates.iter();
        let rates: Vec<_> = rates.map(|rate| self.flow.quantity(*rate)).collect();
        let follows = |i: usize| rates[i].state() == Some(level.state);
        let way = if creep.upward() { 1.0 } else { -1.0 };
        // What is so far on the way, and so fast.
        let spread = |far: Interval, fast: f64| -> Vec<Interval> {
            let speed = Interval::point(way) * Interval::new(0.0, fast).unwrap_or(Interval::ENTIRE);
            let states = (0..n).map(|i| {
                if i == level.state {
                    speed
                } else if follows(i) {
                    Interval::point(way) * far
                } else {
                    Interval::ZERO
                }
            });
            states.collect()
        };
        let on = |i: usize, spread: &[Interval]| {
            let found = creep.within(spread).evaluate(&rates[i], &inputs);
            let (polynomial, off) = found.ok()?;
            Some(around(&polynomial).inflate(off))
        };
        let push = |far: Interval, fast: f64| {
            let rate = on(level.state, &spread(far, fast))?;
            Some((Interval::point(way) * rate).hi())
        };
        // A cell is a share of about where they stop.
        let first = push(Interval::ZERO, 0.0)?;
        let scale = creep
            .base
            .quick_hull()
            .iter()
            .map(|x| x.mag())
            .fold(0.0, f64::max);
        let probe = 1e-6 * (scale + 1e-30);
        let slope = (push(Interval::point(probe), 0.0)? - first) / probe;
        let cell = -2.0 * first / (slope * CELLS);
        if !(first > 0.0 && slope < 0.0 && cell.is_finite() && cell > 0.0) {
            return None;
        }
        let (mut far, mut work, mut largest) = (0.0_f64, 0.0_f64, 0.0_f64);
        let fast = 2.0 * (cell * CELLS * first).sqrt();
        for _ in 0..2 * CELLS as usize {
            let next = far + cell;
            let rate = push(Interval::new(far, next)?, fast)?;
            let gained =
                Interval::point(2.0 * rate) * (Interval::point(next) - Interval::point(far));
            let after = (Interval::point(work) + gained).hi();
            if after.max(0.0).sqrt() >= fast * (1.0 - 1e-9) {
                return None;
            }
            largest = largest.max(after);
            (far, work) = (next, after);
            if work <= 0.0 {
                let all = spread(Interval::new(0.0, far)?, raised(largest.sqrt(), 4));
                // Nothing else moves, and everything else watched keeps its sign.
                let others = (0..n).filter(|i| *i != level.state && !follows(*i));
                let rest = others
                    .map(|i| on(i, &all))
                    .all(|rate| rate == Some(Interval::ZERO));
                let near: Vec<Interval> = all
                    .iter()
                    .map(|x| x.inflate(raised(1e-3 * x.width(), 1)))
                    .collect();
                return (rest && self.stays_near(creep, &near, &inputs)).then_some(all);
            }
        }
        None
    }

    /// Whether everything watched has its sign while solutions are so far from where they would stand, but what is
    /// not known.
    fn stays_near(&self, creep: &Creep, during: &[Interval], inputs: &[Interval]) -> bool {
        let form = creep.within(during);
        let held = creep.hold.watches.iter().filter(|w| !creep.leaving.asks(w));
        let beyond = creep.leaving.regime.watches.iter();
        let beyond = beyond.filter(|watch| !creep.leaving.is_beyond(watch));
        held.chain(beyond)
            .all(|watch| self.has_sign(&form, *watch, inputs))
    }

    /// Whether what is watched has its sign on a form.
    pub(super) fn has_sign(&self, form: &Form, watch: Watch, inputs: &[Interval]) -> bool {
        let value = form.evaluate(&self.flow.quantity(watch.expr), inputs);
        value.is_ok_and(|(polynomial, off)| form.sign(&polynomial, off) == Some(watch.sign))
    }
}

#[cfg(test)]
#[allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]
mod tests {
    use super::*;
    use crate::form::flow::Flow;
    use crate::form::run::Stretch;
    use crate::form::set::FormOptions;
    use veribound_model::Model;

    /// How far solutions of a body with friction creep that rests at `x` and may leave, in `seconds` of two stretches.
    fn spread(pull: &str, x: f64, friction: [f64; 2], seconds: f64) -> (Vec<Interval>, bool) {
        let text = format!(
            "format = 1\nstates = [\"x\", \"v\"]\n[init]\nx = 0\nv = 0\n[params]\nc = [0, 2]\n[let]\npull = \"{pull}\"\n\
             [der]\nx = \"v\"\nv = \"pull - 2*v - friction(v, pull, c)\"\n[outputs]\ny = \"x +- 1\"\n"
        );
        let model = Model::from_text("creep", text);
        let model = model.unwrap_or_else(|problems| panic!("{}", problems.render(false)));
        let flow = Flow::new(&model);
        let c = Interval::new(friction[0], friction[1]).unwrap();
        let start = [Interval::point(x), Interval::ZERO];
        let form = flow.start(&start, &[c], FormOptions::default());
        let stretch = Stretch {
            inputs: Vec::new(),
            dt: Interval::point(seconds),
        };
        let stretches = [stretch.clone(), stretch];
        let mut journey = Journey::new(&flow, form, &stretches);
        journey.is_border = true;
        journey.creep_from_rest();
        let creep = journey.creep.take().unwrap();
        let crept = journey.crept(creep, &[], seconds).unwrap();
        (crept.spread, crept.is_final)
    }

    /// Under a pull of 1 that friction of 0.9 to 1.1 may hold or not, the fastest has friction 0.9: against its exact
    /// solution `v = 0.05 (1 - exp(-2 t))`.
    #[test]
    fn bounds_of_those_that_leave_are_those_of_the_fastest() {
        for seconds in [0.01_f64, 0.05, 0.2] {
            let (spread, is_final) = spread("1", 0.0, [0.9, 1.1], seconds);
            let decayed = -(-2.0 * seconds).exp_m1();
            let (speed, way) = (0.05 * decayed, 0.05 * (seconds - 0.5 * decayed));
            let (x, v) = (spread[0], spread[1]);
            assert!(!is_final && v.lo() == 0.0 && x.lo() == 0.0);
            // A constant bound of the rate, and of the speed.
            assert!(
                v.hi() >= speed && v.hi() < (1.05 + 1.1 * seconds) * speed,
                "{v} {speed}"
            );
            assert!(x.hi() >= way && x.hi() < 3.5 * way, "{x} {way}");
        }
    }

    /// A spring that is stretched to where friction of 0.9 to 1.1 may hold it: the farthest anybody comes, against the motion without
    /// damping from the middle of which it is a half, and with it by fine steps.
    #[test]
    fn work_bounds_how_far_anybody_comes() {
        let (spread, is_final) = spread("-x", 1.0, [0.9, 1.1], 30.0);
        let (mut x, mut v, h) = (1.0_f64, 0.0_f64, 1e-5);
        let mut fastest = 0.0_f64;
        while v <= 0.0 {
            let rate = |x: f64, v: f64| -x - 2.0 * v + 0.9;
            let middle = (x + 0.5 * h * v, v + 0.5 * h * rate(x, v));
            (x, v) = (x + h * middle.1, v + h * rate(middle.0, middle.1));
            fastest = fastest.max(-v);
            if v.abs() < 1e-9 && x < 0.95 {
                break;
            }
        }
        let (way, speed) = (spread[0], spread[1]);
        assert!(is_final && way.hi() == 0.0 && speed.hi() == 0.0);
        assert!(way.lo() <= x - 1.0 && way.lo() > -0.25, "{way} {x}");
        assert!(
            speed.lo() <= -fastest && speed.lo() > -0.12,
            "{speed} {fastest}"
        );
    }
}
