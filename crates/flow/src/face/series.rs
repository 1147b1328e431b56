//! Bounds that move as the solution of their comparison equation.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: states, right-hand sides and quantities are positions in the system's lists"
)]

use super::bound::{Bound, Source, assign, groups};
use super::{Face, Faces, Step};
use crate::side::Side;
use crate::system::{Registers, System};
use veribound_interval::Interval;
use veribound_interval::lanes::{Arithmetic, Interval8, Kernel, LANES, Mask, Value};

/// Rounds of Picard's iteration for the comparison equations: the second accepts mostly, and what
/// grows for eight moves with constant rates instead.
const SERIES_ROUNDS: usize = 8;

impl Face<'_> {
    /// Chooses how both bounds of the state advance: as a series where one smooth right-hand side
    /// is certain.
    pub(super) fn begin(&mut self, bounds: &mut [Bound; 2], lanes: Mask) {
        let mut inside = [Mask::NONE; 2];
        let runs = Side::BOTH.map(|side| {
            let bound = &mut bounds[side.index()];
            bound.reset();
            bound.origin = side.ends(&self.q[self.state]);
            bound.start = bound.origin;
            let mut run = self.start_roughly(side, bound, lanes);
            bound.cell = run.cell;
            for (cell, group) in groups(run.cell, lanes) {
                inside[side.index()] |= if cell % 2 == 1 {
                    let next = self.at_zone(side, cell / 2, group);
                    let at_once = Mask::at_most(&next.after, &[0.0; LANES]);
                    let entering = group & next.enter & at_once;
                    assign(&mut bound.cell, entering, &next.cell);
                    assign(&mut bound.start, entering, &next.from);
                    self.pass_zone(&mut run, cell, group.without(entering), &next);
                    entering
                } else {
                    group
                };
            }
            run
        });
        // Bounds in the same cell share what is found out about it.
        let mut surveyed = [Mask::NONE; 2];
        for side in Side::BOTH {
            let cells = bounds[side.index()].cell;
            for (cell, group) in groups(cells, inside[side.index()]) {
                if group.without(surveyed[side.index()]).none() {
                    continue;
                }
                let both = |side: Side| {
                    let cells = &bounds[side.index()].cell;
                    inside[side.index()] & Mask::from_fn(|lane| cells[lane] == cell)
                };
                let each = Side::BOTH.map(both);
                for (surveyed, now) in surveyed.iter_mut().zip(each) {
                    *surveyed |= now;
                }
                self.survey_cell(cell, each, bounds);
            }
        }
        for (run, bound) in runs.into_iter().zip(bounds) {
            let rough = lanes.without(bound.series);
            if !rough.none() {
                self.finish_run(run, bound, rough);
            }
        }
    }

    /// Plans series in `cell` for the lower and upper bounds of the given boxes, where one
    /// right-hand side is the only one possible there and smooth on the whole face.
    fn survey_cell(&mut self, cell: usize, lanes: [Mask; 2], bounds: &mut [Bound; 2]) {
        let levels = &self.system.guards.levels[self.state];
        let tube = &self.apriori.tube[self.state];
        let domain = tube.intersect(&Interval8::splat(levels.range(cell)));
        let either = (lanes[0] | lanes[1]).without(domain.is_empty());
        self.set_face(&domain);
        let mut chosen = [usize::MAX; LANES];
        let mut single = Mask::NONE;
        if self.system.right_hand_sides[self.state].len() == 1 {
            chosen = [0; LANES];
            single = either;
        } else {
            let mut several = Mask::NONE;
            for (mode, has_mode) in self.apriori.modes.on(either) {
                self.unclip();
                let in_cell = Some((self.state, cell));
                let guards = &mut self.registers.guards;
                let clip = &self.system.guards;
                let active = clip.clip(mode, self.clipped, has_mode, in_cell, guards);
                let choice = self.system.choice[mode][self.state];
                let other = Mask::from_fn(|lane| chosen[lane] != choice);
                several |= single & active & other;
                assign(&mut chosen, active, &[choice; LANES]);
                single |= active;
            }
            single = single.without(several);
        }
        for (rhs, group) in groups(chosen, single) {
            self.unclip();
            let value = &self.system.right_hand_sides[self.state][rhs].value;
            let registers = &mut self.registers.value[self.state][rhs];
            let smooth = group & value.eval(self.clipped, registers).is_smooth();
            if smooth.none() {
                continue;
            }
            self.slopes(rhs);
            self.survey.base.clone_from(&self.survey.slopes);
            let mut fresh = true;
            for side in Side::BOTH {
                let wanted = smooth & lanes[side.index()];
                if wanted.none() {
                    continue;
                }
                if !fresh {
                    self.unclip();
                    self.survey.slopes.clone_from(&self.survey.base);
                }
                fresh = false;
                self.plan_series(side, cell, rhs, wanted, &mut bounds[side.index()]);
            }
        }
    }

    /// Sets up the comparison equations from the bounds' starts inside `cell`.
    fn plan_series(&mut self, side: Side, cell: usize, rhs: usize, lanes: Mask, bound: &mut Bound) {
        let tapes = &self.system.right_hand_sides[self.state][rhs];
        let plan = &mut bound.plans[rhs];
        if let Some(own) = tapes.moving_position(self.state) {
            plan.sources[own].follow(side, lanes);
        }
        let slack = self.fix_corners(side, rhs, lanes, Some(plan));
        let scratch = &mut self.registers.series[self.state][rhs][side.index()];
        for (position, &quantity) in tapes.series_quantities.iter().enumerate() {
            if quantity >= self.system.layout.states {
                let known = tapes.series.quantity(position, scratch);
                known.assign(lanes, &self.clipped[quantity]);
            }
        }
        let smooth = tapes.series.compute_constants(scratch).is_smooth();
        let planned = lanes & smooth & slack.is_bounded();
        plan.lanes |= planned;
        bound.slack.assign(planned, &slack);
        assign(&mut bound.cell, planned, &[cell; LANES]);
        bound.range.assign(planned, &Interval8::point(bound.start));
        bound.series |= planned;
    }
}

impl Faces {
    /// Coefficient `k` of what a comparison equation reads of a state; over the whole step where
    /// `ranges`.
    #[inline(always)]
    fn source(&self, state: usize, source: &Source, k: usize, ranges: bool) -> Interval8 {
        let mut value = if k == 0 {
            source.constant
        } else {
            Interval8::ZERO
        };
        for (side, lanes) in [(Side::Lower, source.lower), (Side::Upper, source.upper)] {
            if lanes.none() {
                continue;
            }
            let bound = &self.bounds[state][side.index()];
            let moving = lanes & bound.series;
            let resting = lanes.without(bound.series);
            if k == 0 && ranges {
                value.assign(moving, &bound.range);
            } else {
                value.assign(moving, &bound.coefficients[k]);
            }
            if !resting.none() {
                let rest = if k == 0 {
                    Interval8::point(side.ends(&bound.range))
                } else {
                    Interval8::ZERO
                };
                value.assign(resting, &rest);
            }
        }
        value
    }
}

impl System {
    /// Range of every comparison solution over the step, by Picard's iteration for all of them
    /// together; those for which it fails, or that reach a level, move with constant rates.
    pub(super) fn enclose_series_ranges(
        &self,
        step: &Step<'_>,
        faces: &mut Faces,
        registers: &mut Registers,
    ) {
        let span = Interval::ZERO.hull(step.dt);
        let mut open = step.lanes;
        for round in 0..SERIES_ROUNDS {
            let mut unsettled = Mask::NONE;
            for state in 0..self.layout.states {
                for side in Side::BOTH {
                    let series = open & faces.bounds[state][side.index()].series;
                    if series.none() {
                        continue;
                    }
                    let (image, velocity, known) = Interval8::run(Picard {
                        system: self,
                        which: Which {
                            state,
                            side,
                            lanes: series,
                        },
                        span,
                        faces,
                        registers,
                    });
                    let bound = &mut faces.bounds[state][side.index()];
                    let tube = &step.apriori.tube[state];
                    let good = known
                        & image.is_subset_of(tube)
                        & self.keeps_to_cell(state, side, bound, &image, series);
                    let settled = good & image.is_subset_of(&bound.range);
                    // The last round is the one in which no range changed any more.
                    bound.coefficients[1].assign(settled, &velocity);
                    unsettled |= series.without(settled);
                    let mut lost = series.without(good);
                    let growing = good.without(settled);
                    if round + 1 < SERIES_ROUNDS {
                        if !growing.none() {
                            let range = generous(&image).intersect(tube);
                            bound.range.assign(growing, &range);
                        }
                    } else {
                        lost |= growing;
                    }
                    self.give_up_series(step, (state, side), lost, faces, registers);
                }
            }
            open = unsettled;
            if open.none() {
                return;
            }
        }
        // Some range was still growing in the last round: no series is proved.
        for state in 0..self.layout.states {
            for side in Side::BOTH {
                let lost = open & faces.bounds[state][side.index()].series;
                self.give_up_series(step, (state, side), lost, faces, registers);
            }
        }
    }

    /// Where the comparison solution keeps to the cell in which its corners were fixed.
    fn keeps_to_cell(
        &self,
        state: usize,
        side: Side,
        bound: &Bound,
        range: &Interval8,
        lanes: Mask,
    ) -> Mask {
        let mut keeps = Mask::NONE;
        for (cell, group) in groups(bound.cell, lanes) {
            let cell = self.guards.levels[state].range(cell);
            let edge = side.end(cell);
            let inside = group & range.is_subset_of(&Interval8::splat(cell));
            keeps |= if edge.is_infinite() {
                inside
            } else {
                inside & side.all_beyond(&[edge; LANES], &side.ends(range))
            };
        }
        keeps
    }

    /// Taylor series of all comparison solutions side by side, with the remainder taken over
    /// their ranges: `V(dt) ∈ Σ_(k<=ν) c_k dt^k + c_(ν+1)(range) dt^(ν+1)`.
    pub(super) fn expand_series(&self, dt: Interval, faces: &mut Faces, registers: &mut Registers) {
        Interval8::run(Expansion {
            system: self,
            dt,
            faces,
            registers,
        });
    }
}

/// One bound of one state.
#[derive(Clone, Copy)]
struct Which {
    state: usize,
    side: Side,
    /// The boxes for which it is wanted.
    lanes: Mask,
}

impl System {
    /// Coefficient `k` of the right-hand side of a comparison equation, and where it is smooth.
    #[inline(always)]
    fn comparison<A: Arithmetic<Value = Interval8>>(
        &self,
        which: Which,
        k: usize,
        ranges: bool,
        faces: &Faces,
        registers: &mut Registers,
    ) -> (Interval8, Mask) {
        let Which { state, side, lanes } = which;
        let bound = &faces.bounds[state][side.index()];
        let mut velocity = Interval8::ENTIRE;
        let mut smooth = Mask::NONE;
        for (rhs, plan) in bound.plans.iter().enumerate() {
            let group = plan.lanes & lanes;
            if group.none() {
                continue;
            }
            let tapes = &self.right_hand_sides[state][rhs];
            let scratch = &mut registers.series[state][rhs][side.index()];
            for (source, &position) in plan.sources.iter().zip(&tapes.moving_positions) {
                let quantity = tapes.series_quantities[position];
                let value = faces.source(quantity, source, k, ranges);
                tapes.series.set_quantity(position, k, value, scratch);
            }
            let regular = tapes.series.compute::<A>(k, scratch);
            velocity.assign(group, &tapes.series.output(0, k, scratch));
            smooth |= group & regular.is_smooth();
        }
        if k == 0 && bound.slack != Interval8::ZERO {
            velocity = A::add(&velocity, &bound.slack);
        }
        (velocity, smooth)
    }
}

/// Where a comparison solution is during the step, if it is in its range, and its velocity then; and
/// where that is proved.
struct Picard<'a> {
    system: &'a System,
    which: Which,
    span: Interval,
    faces: &'a Faces,
    registers: &'a mut Registers,
}

impl Kernel<Interval8> for Picard<'_> {
    type Output = (Interval8, Interval8, Mask);

    #[inline(always)]
    fn run<A: Arithmetic<Value = Interval8>>(self) -> (Interval8, Interval8, Mask) {
        let Which { state, side, .. } = self.which;
        let (velocity, known) =
            self.system
                .comparison::<A>(self.which, 0, true, self.faces, self.registers);
        let start = Interval8::point(self.faces.bounds[state][side.index()].start);
        let image = A::add(&start, &A::scale(&velocity, self.span));
        (image, velocity, known & velocity.is_bounded())
    }
}

/// [`System::expand_series`]
struct Expansion<'a> {
    system: &'a System,
    dt: Interval,
    faces: &'a mut Faces,
    registers: &'a mut Registers,
}

impl Kernel<Interval8> for Expansion<'_> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic<Value = Interval8>>(mut self) {
        let order = self.faces.order;
        // Over the ranges Picard's iteration has left the velocities.
        for (ranges, first, last) in [(true, 1, order + 1), (false, 0, order)] {
            self.coefficients::<A>(ranges, first, last);
            for bound in self.faces.bounds.iter_mut().flatten() {
                if ranges {
                    bound.remainder = bound.coefficients[last];
                }
            }
        }
        for pair in &mut self.faces.bounds {
            for side in Side::BOTH {
                let bound = &mut pair[side.index()];
                if bound.series.none() {
                    continue;
                }
                let mut sum = bound.remainder;
                for coefficient in bound.coefficients[..=order].iter().rev() {
                    sum = A::add(coefficient, &A::scale(&sum, self.dt));
                }
                assign(&mut bound.end, bound.series, &side.ends(&sum));
            }
        }
    }
}

impl Expansion<'_> {
    /// Coefficients after `first` up to `last` of every comparison solution, along it or over its
    /// whole range.
    #[inline(always)]
    fn coefficients<A: Arithmetic<Value = Interval8>>(
        &mut self,
        ranges: bool,
        first: usize,
        last: usize,
    ) {
        for bound in self.faces.bounds.iter_mut().flatten() {
            bound.coefficients[0] = if ranges {
                bound.range
            } else {
                Interval8::point(bound.start)
            };
        }
        for k in first..last {
            let reciprocal = self.faces.reciprocals[k];
            for state in 0..self.system.layout.states {
                for side in Side::BOTH {
                    let lanes = self.faces.bounds[state][side.index()].series;
                    if lanes.none() {
                        continue;
                    }
                    let which = Which { state, side, lanes };
                    let (value, smooth) =
                        self.system
                            .comparison::<A>(which, k, ranges, self.faces, self.registers);
                    let value = if k == 0 {
                        value
                    } else {
                        A::scale(&value, reciprocal)
                    };
                    // The ranges were accepted with a smooth right-hand side on them; were it
                    // otherwise, the unbounded coefficient says so and loses nothing.
                    let value = value.or_else(smooth, &Interval8::ENTIRE);
                    self.faces.bounds[state][side.index()].coefficients[k + 1] = value;
                }
            }
        }
    }
}

/// A quarter more than `image` on both sides, generous since the range only enters the remainder and
/// fewer rounds are cheaper; and a few floats for a point.
fn generous(image: &Interval8) -> Interval8 {
    let (width, size) = (image.width(), image.mag());
    let more: [f64; LANES] = std::array::from_fn(|lane| 0.25 * width[lane] + 1e-14 * size[lane]);
    *image + Interval8::between(more.map(|m| -m), more)
}
