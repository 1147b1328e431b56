//! Moving faces: each bound of the box advances with the right-hand side on its own face.
//!
//! # What is proved
//!
//! Let `B` be the a-priori box (every solution stays in it for the whole step). For each state `i`
//! and each side a function `V(t)` is built, starting at or outside the bound of the start box,
//! such that no solution passes it. Written for the upper bound:
//!
//! > (*) for almost every `t` and every `x` in `B` whose other states lie between their own bounds
//! > and whose `x_i` is just beyond `V(t)`: every velocity of state `i` in the Filippov hull at `x`
//! > is at most `V'(t) + L (x_i - V(t))`.
//!
//! Let `e(t)` be the largest distance by which a solution lies beyond any of the bounds. By (*) and
//! because the right-hand sides used with *moving* bounds of other states are Lipschitz in those
//! states, `e' <= L e` almost everywhere, and `e(0) = 0`; hence `e = 0`. (Müller's theorem, in the
//! form for differential inclusions; jumps of `V` outward do no harm, inward ones never happen.)
//!
//! The levels at which guards compare state `i` with a constant cut its axis into open regions and
//! thin zones. The rule is one-sided: only the modes possible *beyond* the bound count.
//!
//! * **Region.** `V` moves with a bound of the velocity over `x_i` between `V` and the end of `B`,
//!   inside the region, the other states anywhere in `B`: either as the solution of the
//!   comparison equation (a Taylor series, [`Bound`] of kind series) or with one constant rate.
//! * **Reaching a level from inside** (outward): `V` is put on the far side of the zone no later
//!   than the straight line reaches it. This is a jump outward.
//! * **Reaching a level from outside** (inward): `V` is put on the near edge of the zone no earlier
//!   than the line reaches it.
//! * **At a zone.** Solutions beyond it have the velocities of the region outside. If those push
//!   back, nothing passes: `V` may rest at the outer edge. It may move in only when every velocity
//!   possible *in* the zone points inward too; then it crosses the zone with the slowest of them
//!   and goes on in the region behind, which solutions cannot leave outward through the zone.
//!
//! A standing rig is the case in point: at velocity 0 the region above has the forward mode alone,
//! which brakes while `u <= T`, the region below has the backward mode alone, so both bounds rest
//! at exactly zero; the plain hull of the three modes would let them drift apart.
//!
//! Parameters are constants, so a right-hand side that is monotone in one is largest at its end;
//! one that is not keeps the whole interval, which is sound for every fixed value. Inputs and
//! states may change in time; where the monotonicity is unknown, the mean value theorem turns them
//! into a constant slack.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: states, right-hand sides and quantities are positions in the system's lists"
)]

use crate::apriori::Apriori;
use crate::side::{Side, earliest, latest};
use crate::system::{Registers, System};
use veribound_interval::{Interval, round};
use veribound_model::Regularity;

/// Phases one bound may pass through in one step before it falls back to the a-priori box.
const PHASES: usize = 8;

/// Rounds of the search for signs of the gradient: fixing one argument can decide another's sign.
const SIGN_ROUNDS: usize = 3;

/// Rounds of Picard's iteration for the comparison equations.
const SERIES_ROUNDS: usize = 8;

/// Where the value of a quantity in a comparison equation comes from.
#[derive(Debug, Clone, Copy)]
enum Source {
    /// A bound of a state, moving in time.
    Bound { state: usize, side: Side },
    /// Constant for the whole step.
    Constant(Interval),
}

/// One bound of one state during a step.
#[derive(Debug, Clone)]
struct Bound {
    /// The box's own bound.
    origin: f64,
    /// Where the comparison solution starts: `origin`, or the far edge of the zone it lies in.
    start: f64,
    /// Advances as a Taylor series; else `end` and `range` are final.
    series: bool,
    rhs: usize,
    cell: usize,
    /// Per quantity of the series tape; used for the states.
    sources: Vec<Source>,
    /// What unknown monotonicity adds to the velocity.
    slack: Interval,
    /// Values during the step.
    range: Interval,
    /// Taylor coefficients of the comparison solution.
    coefficients: Vec<Interval>,
    remainder: Interval,
    end: f64,
}

/// What is known about a state's right-hand side in one cell; both bounds of a box that lies in
/// the cell share it.
#[derive(Debug, Clone, Default)]
struct Survey {
    /// State, cell and right-hand side, when it is the only one and smooth.
    found: Option<(usize, usize, usize)>,
    /// Slopes on the whole face.
    base: Vec<Interval>,
    /// Slopes on the face as far as its corners are fixed.
    slopes: Vec<Interval>,
}

/// Scratch and result of [`System::move_faces`].
#[derive(Debug, Clone)]
pub(crate) struct Faces {
    bounds: Vec<[Bound; 2]>,
    face: Vec<Interval>,
    clipped: Vec<Interval>,
    /// `1 / (k + 1)`
    reciprocals: Vec<Interval>,
    survey: Survey,
    order: usize,
}

impl Faces {
    pub(crate) fn new(system: &System, order: usize) -> Faces {
        let bound = Bound {
            origin: 0.0,
            start: 0.0,
            series: false,
            rhs: 0,
            cell: 0,
            sources: Vec::new(),
            slack: Interval::ZERO,
            range: Interval::ZERO,
            coefficients: vec![Interval::ZERO; order + 2],
            remainder: Interval::ZERO,
            end: 0.0,
        };
        Faces {
            bounds: vec![[bound.clone(), bound]; system.layout.states],
            face: vec![Interval::ZERO; system.layout.len()],
            clipped: Vec::new(),
            reciprocals: (0..order + 2)
                .map(|k| Interval::point((k + 1) as f64).recip())
                .collect(),
            survey: Survey::default(),
            order,
        }
    }

    /// Coefficient `k` of what a comparison equation reads; over the whole step where `ranges`.
    fn source(&self, source: Source, k: usize, ranges: bool) -> Interval {
        let constant = |value| if k == 0 { value } else { Interval::ZERO };
        match source {
            Source::Constant(value) => constant(value),
            Source::Bound { state, side } => {
                let bound = &self.bounds[state][side.index()];
                if !bound.series {
                    constant(Interval::point(side.end(bound.range)))
                } else if k == 0 && ranges {
                    bound.range
                } else {
                    bound.coefficients[k]
                }
            }
        }
    }
}

/// What a bound that starts or arrives at a zone does next.
enum AtZone {
    Rest,
    Enter { cell: usize, from: f64, after: f64 },
}

/// One bound of one state, the step's data, and scratch.
struct Face<'a> {
    system: &'a System,
    /// States (start box), parameters and inputs.
    q: &'a [Interval],
    apriori: &'a Apriori,
    state: usize,
    side: Side,
    /// The box on the face; scratch.
    face: &'a mut Vec<Interval>,
    clipped: &'a mut Vec<Interval>,
    survey: &'a mut Survey,
    registers: &'a mut Registers,
}

impl Face<'_> {
    /// Puts the a-priori box into `face`, with `range` for the state's own coordinate.
    fn set_face(&mut self, range: Interval) {
        self.face.clear();
        self.face.extend_from_slice(self.q);
        self.face[..self.system.layout.states].copy_from_slice(&self.apriori.tube);
        self.face[self.state] = range;
    }

    /// A bound of the velocity towards this side, over `x_i` in `range` inside `cell` and the
    /// other states in the a-priori box; `None` when no solution can be there.
    fn rate(&mut self, cell: usize, range: Interval) -> Option<f64> {
        if range.is_empty() {
            return None;
        }
        self.set_face(range);
        let mut worst: Option<f64> = None;
        let mut seen_all = false;
        for mode in self.apriori.modes.iter() {
            let rhs = self.system.choice[mode][self.state];
            let shared = self.system.right_hand_sides[self.state].len() == 1;
            if shared && seen_all {
                break;
            }
            self.clipped.clear();
            self.clipped.extend_from_slice(self.face);
            if !shared {
                let in_cell = Some((self.state, cell));
                let guards = &mut self.registers.guards;
                if !self.system.guards.clip(mode, self.clipped, in_cell, guards) {
                    continue;
                }
            }
            seen_all = true;
            let rate = self.rate_of(rhs);
            worst = Some(worst.map_or(rate, |known| self.side.outer(known, rate)));
        }
        worst
    }

    /// The velocity towards this side of one right-hand side on the box in `clipped`.
    fn rate_of(&mut self, rhs: usize) -> f64 {
        let tapes = &self.system.right_hand_sides[self.state][rhs];
        let registers = &mut self.registers.value[self.state][rhs];
        let regularity = tapes.value.eval(self.clipped, registers);
        let plain = self.side.end(tapes.value.output(0, registers));
        if regularity < Regularity::Kink || tapes.others.is_empty() {
            return plain;
        }
        self.slopes(rhs);
        let slack = self.fix_corners(rhs, None);
        let registers = &mut self.registers.value[self.state][rhs];
        tapes.value.eval(self.clipped, registers);
        let corner = self.side.end(tapes.value.output(0, registers) + slack);
        self.side.inner(plain, corner)
    }

    /// Partial derivatives of one right-hand side on the box in `clipped`.
    fn slopes(&mut self, rhs: usize) {
        let tapes = &self.system.right_hand_sides[self.state][rhs];
        let registers = &mut self.registers.gradient[self.state][rhs];
        tapes.gradient.eval(self.clipped, registers);
        // Where a derivative exists nowhere on the box, as that of a root at exactly zero, nothing
        // is known about it.
        let slopes = (0..tapes.others.len()).map(|i| {
            let slope = tapes.gradient.output(i, registers);
            if slope.is_empty() {
                Interval::ENTIRE
            } else {
                slope
            }
        });
        self.survey.slopes.clear();
        self.survey.slopes.extend(slopes);
    }

    /// The right-hand side of the state in `cell`, if it is the only one possible there and smooth
    /// on the whole face; leaves the face in `clipped` and its slopes in the survey.
    fn survey(&mut self, cell: usize) -> Option<usize> {
        let levels = &self.system.guards.levels[self.state];
        let domain = self.apriori.tube[self.state].intersect(levels.range(cell));
        if domain.is_empty() {
            return None;
        }
        self.set_face(domain);
        if let Some((state, known, rhs)) = self.survey.found
            && (state, known) == (self.state, cell)
        {
            self.clipped.clear();
            self.clipped.extend_from_slice(self.face);
            self.survey.slopes.clone_from(&self.survey.base);
            return Some(rhs);
        }
        let candidates = &self.system.right_hand_sides[self.state];
        let mut rhs = None;
        if candidates.len() == 1 {
            rhs = Some(0);
        } else {
            for mode in self.apriori.modes.iter() {
                self.clipped.clear();
                self.clipped.extend_from_slice(self.face);
                let in_cell = Some((self.state, cell));
                let guards = &mut self.registers.guards;
                if !self.system.guards.clip(mode, self.clipped, in_cell, guards) {
                    continue;
                }
                let choice = self.system.choice[mode][self.state];
                if rhs.is_some_and(|known| known != choice) {
                    return None;
                }
                rhs = Some(choice);
            }
        }
        let rhs = rhs?;
        self.clipped.clear();
        self.clipped.extend_from_slice(self.face);
        let registers = &mut self.registers.value[self.state][rhs];
        if candidates[rhs].value.eval(self.clipped, registers) != Regularity::Smooth {
            return None;
        }
        self.slopes(rhs);
        self.survey.found = Some((self.state, cell, rhs));
        self.survey.base.clone_from(&self.survey.slopes);
        Some(rhs)
    }

    /// Replaces in `clipped` every quantity in which the right-hand side is monotone by the end
    /// that makes it extreme towards this side, and every other state or input by its midpoint;
    /// returns the slack that covers the latter.
    ///
    /// With `sources` (by position in the series tape) moving states keep their whole range in
    /// `clipped` and are recorded as bounds instead. [`Face::slopes`] on `clipped` comes before.
    fn fix_corners(&mut self, rhs: usize, mut sources: Option<&mut Vec<Source>>) -> Interval {
        let layout = self.system.layout;
        let tapes = &self.system.right_hand_sides[self.state][rhs];
        let moving =
            |quantity: usize| quantity < layout.states || quantity >= layout.states + layout.params;
        let mut open: u128 = if tapes.others.len() >= 128 {
            u128::MAX
        } else {
            (1_u128 << tapes.others.len()) - 1
        };
        let mut current = true;
        for _ in 0..SIGN_ROUNDS {
            if !current {
                self.slopes(rhs);
            }
            let mut narrowed = false;
            for (position, &quantity) in tapes.others.iter().enumerate().take(128) {
                if open & (1 << position) == 0 {
                    continue;
                }
                let slope = self.survey.slopes[position];
                let towards = if slope.lo() >= 0.0 {
                    self.side
                } else if slope.hi() <= 0.0 {
                    self.side.other()
                } else {
                    continue;
                };
                open &= !(1 << position);
                let is_state = quantity < layout.states;
                match (&mut sources, is_state) {
                    (Some(sources), true) => {
                        record(
                            tapes,
                            sources,
                            quantity,
                            Source::Bound {
                                state: quantity,
                                side: towards,
                            },
                        );
                    }
                    _ => {
                        let end = Interval::point(towards.end(self.clipped[quantity]));
                        narrowed |= end != self.clipped[quantity];
                        self.clipped[quantity] = end;
                    }
                }
            }
            // Constant slopes, or slopes on an unchanged box, need no second look.
            current = !narrowed || tapes.linear;
            if open == 0 || current {
                break;
            }
        }
        let mut slack = Interval::ZERO;
        if open == 0 {
            return slack;
        }
        if !current {
            self.slopes(rhs);
        }
        for (position, &quantity) in tapes.others.iter().enumerate() {
            if (position < 128 && open & (1 << position) == 0) || !moving(quantity) {
                continue;
            }
            let range = self.clipped[quantity];
            let centre = Interval::point(range.mid());
            slack += self.survey.slopes[position] * (range - centre);
            self.clipped[quantity] = centre;
            if let Some(sources) = &mut sources {
                record(tapes, sources, quantity, Source::Constant(centre));
            }
        }
        Interval::point(self.side.end(slack))
    }

    /// Chooses how the bound advances: as a series where one smooth right-hand side is certain.
    fn begin(&mut self, bound: &mut Bound, dt: Interval) {
        let levels = &self.system.guards.levels[self.state];
        bound.origin = self.side.end(self.q[self.state]);
        bound.series = false;
        let mut cell = levels.cell(bound.origin);
        let mut start = bound.origin;
        if cell % 2 == 1 {
            match self.at_zone(cell / 2) {
                AtZone::Enter {
                    cell: next,
                    from,
                    after: 0.0,
                } => {
                    cell = next;
                    start = from;
                }
                _ => return self.finish_roughly(bound, dt),
            }
        }
        if !self.plan_series(cell, start, bound) {
            self.finish_roughly(bound, dt);
        }
    }

    fn finish_roughly(&mut self, bound: &mut Bound, dt: Interval) {
        let limit = self.side.end(self.apriori.tube[self.state]);
        let (end, range) = self.move_roughly(bound.origin, dt);
        // No solution passes the a-priori box, so a bound beyond it may be put there.
        bound.series = false;
        bound.end = self.side.inner(end, limit);
        bound.range = range.intersect(
            self.side
                .other()
                .between(limit, self.side.other().end(range)),
        );
        if bound.range.is_empty() {
            bound.range = Interval::point(bound.end);
        }
    }

    /// Decides what a bound at the outer edge of zone `zone` does.
    fn at_zone(&mut self, zone: usize) -> AtZone {
        let levels = &self.system.guards.levels[self.state];
        let cell = 2 * zone + 1;
        let range = levels.range(cell);
        let (edge, far) = (self.side.end(range), self.side.other().end(range));
        let (outside, inside) = match self.side {
            Side::Upper => (cell + 1, cell - 1),
            Side::Lower => (cell - 1, cell + 1),
        };
        let beyond = self
            .side
            .between(edge, self.side.end(self.apriori.tube[self.state]));
        let beyond = beyond.intersect(levels.range(outside));
        if let Some(rate) = self.rate(outside, beyond)
            && self.side.beyond(rate, 0.0)
        {
            return AtZone::Enter {
                cell: outside,
                from: edge,
                after: 0.0,
            };
        }
        match self.rate(cell, range) {
            Some(rate) if self.side.other().beyond(rate, 0.0) => {
                let width = Interval::point(edge) - Interval::point(far);
                AtZone::Enter {
                    cell: inside,
                    from: far,
                    after: latest(width, rate),
                }
            }
            _ => AtZone::Rest,
        }
    }

    /// Tries to set up the comparison equation from `from` inside `cell`.
    fn plan_series(&mut self, cell: usize, from: f64, bound: &mut Bound) -> bool {
        let Some(rhs) = self.survey(cell) else {
            return false;
        };
        let tapes = &self.system.right_hand_sides[self.state][rhs];
        let mut sources = std::mem::take(&mut bound.sources);
        sources.clear();
        sources.resize(
            tapes.series_quantities.len(),
            Source::Constant(Interval::ZERO),
        );
        record(
            tapes,
            &mut sources,
            self.state,
            Source::Bound {
                state: self.state,
                side: self.side,
            },
        );
        let slack = self.fix_corners(rhs, Some(&mut sources));
        let scratch = &mut self.registers.series[self.state][rhs][self.side.index()];
        for (position, &quantity) in tapes.series_quantities.iter().enumerate() {
            if quantity >= self.system.layout.states {
                tapes
                    .series
                    .set_quantity(position, 0, self.clipped[quantity], scratch);
            }
        }
        if tapes.series.compute_constants(scratch) != Regularity::Smooth {
            return false;
        }
        bound.sources = sources;
        bound.slack = slack;
        bound.rhs = rhs;
        bound.cell = cell;
        bound.start = from;
        bound.range = Interval::point(from);
        bound.series = slack.is_bounded();
        bound.series
    }

    /// Moves the bound with constant rates, phase by phase.
    fn move_roughly(&mut self, start: f64, dt: Interval) -> (f64, Interval) {
        let side = self.side;
        let state = self.state;
        let limit = side.end(self.apriori.tube[state]);
        let levels = &self.system.guards.levels[state];
        let mut cell = levels.cell(start);
        let mut v = start;
        let mut elapsed = 0.0_f64;
        let mut range = Interval::point(v);
        for _ in 0..PHASES {
            range = range.hull(Interval::point(v));
            let rest = dt - Interval::point(elapsed);
            if cell % 2 == 1 {
                v = side.end(levels.range(cell));
                range = range.hull(Interval::point(v));
                match self.at_zone(cell / 2) {
                    AtZone::Rest => return (v, range),
                    AtZone::Enter {
                        cell: next,
                        from,
                        after,
                    } => {
                        elapsed = round::add_up(elapsed, after);
                        if elapsed >= dt.lo() {
                            return (v, range);
                        }
                        cell = next;
                        v = from;
                        continue;
                    }
                }
            }
            let region = levels.range(cell);
            let Some(outward) = self.rate(cell, side.between(v, limit).intersect(region)) else {
                return (v, range);
            };
            if !side.other().beyond(outward, 0.0) {
                let reach = side.end(Interval::point(v) + Interval::point(outward) * rest);
                let edge = side.end(region);
                if !side.beyond(reach, edge) {
                    return (reach, range.hull(Interval::point(reach)));
                }
                let distance = Interval::point(edge) - Interval::point(v);
                elapsed = round::add_down(elapsed, earliest(distance, outward));
                v = edge;
                cell = outer_cell(side, cell);
                continue;
            }
            // Inward: the rate must hold for every place the bound will sweep.
            let slowest = Interval::point(side.other().end(self.apriori.velocity[state]));
            let sweep = side
                .other()
                .end(Interval::point(v) + Interval::ZERO.hull(rest) * slowest);
            let swept = side.between(sweep, limit).intersect(region);
            let inward = self.rate(cell, swept).unwrap_or(0.0);
            if !side.other().beyond(inward, 0.0) {
                return (v, range);
            }
            let reach = side.end(Interval::point(v) + Interval::point(inward) * rest);
            let edge = side.other().end(region);
            if !side.beyond(edge, reach) {
                return (reach, range.hull(Interval::point(reach)));
            }
            let distance = Interval::point(v) - Interval::point(edge);
            elapsed = round::add_up(elapsed, latest(distance, inward));
            v = edge;
            range = range.hull(Interval::point(v));
            if elapsed >= dt.lo() {
                return (v, range);
            }
            cell = outer_cell(side.other(), cell);
        }
        (limit, range.hull(Interval::point(limit)))
    }
}

/// The neighbouring cell on `side`.
fn outer_cell(side: Side, cell: usize) -> usize {
    match side {
        Side::Upper => cell + 1,
        Side::Lower => cell.saturating_sub(1),
    }
}

fn record(
    tapes: &crate::system::RightHandSide,
    sources: &mut [Source],
    quantity: usize,
    source: Source,
) {
    if let Some(position) = tapes.series_quantities.iter().position(|q| *q == quantity) {
        sources[position] = source;
    }
}

/// The start box, parameters and inputs of a step, its length, and what holds for all of it.
pub(crate) struct Step<'a> {
    pub(crate) q: &'a [Interval],
    pub(crate) dt: Interval,
    pub(crate) apriori: &'a Apriori,
}

impl System {
    /// Encloses the states at the end of the step into `end`, and at all its times into `tube`.
    ///
    /// Source: own; see the module's comment.
    pub(crate) fn move_faces(
        &self,
        step: &Step<'_>,
        faces: &mut Faces,
        registers: &mut Registers,
        end: &mut [Interval],
        tube: &mut [Interval],
    ) {
        faces.survey.found = None;
        for state in 0..self.layout.states {
            for side in Side::BOTH {
                self.with_face(step, state, side, faces, registers, |face, bound| {
                    face.begin(bound, step.dt);
                });
            }
        }
        self.enclose_series_ranges(step, faces, registers);
        self.expand_series(step.dt, faces, registers);
        let whole = Interval::ZERO.hull(step.dt);
        for state in 0..self.layout.states {
            let [lower, upper] = &faces.bounds[state];
            // The plain bound with the hull of all velocities holds as well.
            let velocity = step.apriori.velocity[state];
            let plain = step.q[state] + step.dt * velocity;
            let plain_tube = step.q[state] + whole * velocity;
            let box_of = |lo, hi| Interval::new(lo, hi).unwrap_or(Interval::EMPTY);
            end[state] = box_of(lower.end, upper.end).intersect(plain);
            tube[state] = box_of(lower.range.lo(), upper.range.hi()).intersect(plain_tube);
        }
    }

    fn with_face(
        &self,
        step: &Step<'_>,
        state: usize,
        side: Side,
        faces: &mut Faces,
        registers: &mut Registers,
        action: impl FnOnce(&mut Face<'_>, &mut Bound),
    ) {
        let Faces {
            bounds,
            face,
            clipped,
            survey,
            ..
        } = faces;
        let mut face = Face {
            system: self,
            q: step.q,
            apriori: step.apriori,
            state,
            side,
            face,
            clipped,
            survey,
            registers,
        };
        action(&mut face, &mut bounds[state][side.index()]);
    }

    /// Range of every comparison solution over the step, by Picard's iteration for all of them
    /// together; those for which it fails, or that reach a level, move with constant rates.
    fn enclose_series_ranges(&self, step: &Step<'_>, faces: &mut Faces, registers: &mut Registers) {
        let span = Interval::ZERO.hull(step.dt);
        for round in 0..SERIES_ROUNDS {
            let mut settled = true;
            for state in 0..self.layout.states {
                for side in Side::BOTH {
                    let bound = &faces.bounds[state][side.index()];
                    if !bound.series {
                        continue;
                    }
                    let image = self
                        .comparison_velocity(state, side, faces, registers)
                        .map(|velocity| Interval::point(bound.start) + span * velocity)
                        .filter(|image| self.stays(state, side, bound, *image, step.apriori));
                    match image {
                        Some(image) if image.is_subset_of(bound.range) => {}
                        Some(image) if round + 1 < SERIES_ROUNDS => {
                            settled = false;
                            // Generous: the range only enters the remainder, and fewer rounds are
                            // cheaper. But not beyond the tube: velocities are larger there, and
                            // no image would stay in it.
                            let more = 0.25 * image.width() + 1e-14 * image.mag();
                            let more = Interval::new(-more, more).unwrap_or(Interval::ENTIRE);
                            let tube = step.apriori.tube[state];
                            faces.bounds[state][side.index()].range =
                                (image + more).intersect(tube);
                        }
                        _ => {
                            settled = false;
                            self.with_face(step, state, side, faces, registers, |face, bound| {
                                face.finish_roughly(bound, step.dt);
                            });
                        }
                    }
                }
            }
            if settled {
                return;
            }
        }
        // Some range was still growing in the last round: no series is proved.
        for state in 0..self.layout.states {
            for side in Side::BOTH {
                if faces.bounds[state][side.index()].series {
                    self.with_face(step, state, side, faces, registers, |face, bound| {
                        face.finish_roughly(bound, step.dt);
                    });
                }
            }
        }
    }

    /// True while the comparison solution keeps to the domain on which its corners were fixed.
    fn stays(
        &self,
        state: usize,
        side: Side,
        bound: &Bound,
        range: Interval,
        apriori: &Apriori,
    ) -> bool {
        let cell = self.guards.levels[state].range(bound.cell);
        range.is_subset_of(apriori.tube[state])
            && range.is_subset_of(cell)
            && (side.end(cell).is_infinite() || side.beyond(side.end(cell), side.end(range)))
    }

    fn comparison_velocity(
        &self,
        state: usize,
        side: Side,
        faces: &Faces,
        registers: &mut Registers,
    ) -> Option<Interval> {
        let bound = &faces.bounds[state][side.index()];
        let tapes = &self.right_hand_sides[state][bound.rhs];
        let scratch = &mut registers.series[state][bound.rhs][side.index()];
        for &position in &tapes.moving_positions {
            let value = faces.source(bound.sources[position], 0, true);
            tapes.series.set_quantity(position, 0, value, scratch);
        }
        if tapes.series.compute(0, scratch) != Regularity::Smooth {
            return None;
        }
        let velocity = tapes.series.output(0, 0, scratch) + bound.slack;
        velocity.is_bounded().then_some(velocity)
    }

    /// Taylor series of all comparison solutions side by side, with the remainder taken over
    /// their ranges: `V(dt) ∈ Σ_(k<=ν) c_k dt^k + c_(ν+1)(range) dt^(ν+1)`.
    fn expand_series(&self, dt: Interval, faces: &mut Faces, registers: &mut Registers) {
        let order = faces.order;
        self.coefficients(true, order + 1, faces, registers);
        for bound in faces
            .bounds
            .iter_mut()
            .flatten()
            .filter(|bound| bound.series)
        {
            bound.remainder = bound.coefficients[order + 1];
        }
        self.coefficients(false, order, faces, registers);
        for pair in &mut faces.bounds {
            for side in Side::BOTH {
                let bound = &mut pair[side.index()];
                if !bound.series {
                    continue;
                }
                let mut sum = bound.remainder;
                for coefficient in bound.coefficients[..=order].iter().rev() {
                    sum = *coefficient + dt * sum;
                }
                bound.end = side.end(sum);
            }
        }
    }

    /// Coefficients 0 to `last` of every comparison solution, along it or over its whole range.
    fn coefficients(
        &self,
        ranges: bool,
        last: usize,
        faces: &mut Faces,
        registers: &mut Registers,
    ) {
        for bound in faces
            .bounds
            .iter_mut()
            .flatten()
            .filter(|bound| bound.series)
        {
            bound.coefficients[0] = if ranges {
                bound.range
            } else {
                Interval::point(bound.start)
            };
        }
        for k in 0..last {
            let reciprocal = faces.reciprocals[k];
            for state in 0..self.layout.states {
                for side in Side::BOTH {
                    let bound = &faces.bounds[state][side.index()];
                    if !bound.series {
                        continue;
                    }
                    let tapes = &self.right_hand_sides[state][bound.rhs];
                    let scratch = &mut registers.series[state][bound.rhs][side.index()];
                    for &position in &tapes.moving_positions {
                        let value = faces.source(bound.sources[position], k, ranges);
                        tapes.series.set_quantity(position, k, value, scratch);
                    }
                    let regularity = tapes.series.compute(k, scratch);
                    let value = tapes.series.output(0, k, scratch);
                    let value = if k == 0 {
                        value + bound.slack
                    } else {
                        value * reciprocal
                    };
                    // The ranges were accepted with a smooth right-hand side on them; were it
                    // otherwise, the unbounded coefficient says so and loses nothing.
                    let smooth = regularity == Regularity::Smooth;
                    let value = if smooth { value } else { Interval::ENTIRE };
                    faces.bounds[state][side.index()].coefficients[k + 1] = value;
                }
            }
        }
    }
}
