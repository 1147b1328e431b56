//! Bounds that move as the solution of their comparison equation.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: states, right-hand sides and quantities are positions in the system's lists"
)]

use super::bound::{Along, Bound, Source, assign, groups};
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
        let levels = &self.system.guards.levels[self.state];
        let mut inside = [Mask::NONE; 2];
        let mut runs = [None, None];
        for side in Side::BOTH {
            let bound = &mut bounds[side.index()];
            bound.reset();
            bound.origin = side.ends(&self.q[self.state]);
            bound.start = bound.origin;
            bound.cell = bound.origin.map(|origin| levels.cell(origin));
            for (cell, group) in groups(bound.cell, lanes) {
                inside[side.index()] |= if cell % 2 == 1 {
                    let next = self.at_zone(side, cell / 2, group);
                    let at_once = Mask::at_most(&next.after, &[0.0; LANES]);
                    let entering = group & next.enter & at_once;
                    assign(&mut bound.cell, entering, &next.cell);
                    assign(&mut bound.start, entering, &next.from);
                    let others = group.without(entering);
                    if !others.none() {
                        let run = runs[side.index()]
                            .get_or_insert_with(|| self.start_roughly(side, bound, lanes));
                        self.pass_zone(run, cell, others, &next);
                    }
                    entering
                } else {
                    group
                };
            }
        }
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
        for (side, run) in Side::BOTH.into_iter().zip(runs) {
            let bound = &mut bounds[side.index()];
            let rough = lanes.without(bound.series);
            if !rough.none() {
                let run = run.unwrap_or_else(|| self.start_roughly(side, bound, lanes));
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
            for &(mode, choice) in &self.system.governing[self.state] {
                let has_mode = either & self.apriori.modes.of(mode);
                if has_mode.none() {
                    continue;
                }
                self.unclip();
                let in_cell = Some((self.state, cell));
                let guards = &mut self.registers.guards;
                let clip = &self.system.guards;
                let active = clip.clip(mode, self.clipped, has_mode, in_cell, guards);
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
        bound.slack_in |= planned.without(slack.is_subset_of(&Interval8::ZERO));
        assign(&mut bound.cell, planned, &[cell; LANES]);
        bound.series |= planned;
    }
}

impl Faces {
    /// Coefficient `k` of what a comparison equation reads of a state.
    #[inline(always)]
    fn source(&self, state: usize, source: &Source, k: usize, along: Along) -> Interval8 {
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
            value.assign(lanes & bound.series, &bound.coefficients(along)[k]);
            let resting = lanes.without(bound.series);
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
    /// Moves every bound with a comparison equation to the end of the step, as a Taylor series:
    /// `V(dt) ∈ Σ_(k<=ν) c_k dt^k + c_(ν+1) dt^(ν+1)`, the last coefficient taken over its whole
    /// range. Bounds for whose range there is no proof, or that reach a level, move with constant
    /// rates.
    pub(super) fn move_series(
        &self,
        step: &Step<'_>,
        faces: &mut Faces,
        registers: &mut Registers,
    ) {
        let order = faces.order;
        let expand = |along, from, to, faces: &mut Faces, registers: &mut Registers| {
            Interval8::run(Expansion {
                system: self,
                span: Interval::ZERO.hull(step.dt),
                lanes: step.lanes,
                along,
                from,
                to,
                faces,
                registers,
            });
        };
        expand(Along::Start, 0, order, faces, registers);
        let lost = self.enclose_ranges(step, faces, registers);
        if !lost.none() {
            // Other bounds were expanded along with those that move with constant rates now.
            expand(Along::Start, 0, order, faces, registers);
            expand(Along::Range, 0, 1, faces, registers);
        }
        expand(Along::Range, 1, order + 1, faces, registers);
        Interval8::run(Sum { dt: step.dt, faces });
    }

    /// Range of every comparison solution over the step, by Picard's iteration for all of them
    /// together. Returns the boxes with a bound that lost its series.
    ///
    /// Afterwards the velocities on these ranges are the first coefficients of [`Along::Range`], and the
    /// registers hold the order 0 that the next orders build upon.
    fn enclose_ranges(
        &self,
        step: &Step<'_>,
        faces: &mut Faces,
        registers: &mut Registers,
    ) -> Mask {
        for (pair, tube) in faces.bounds.iter_mut().zip(&step.apriori.tube) {
            for bound in pair {
                let guess = generous(&bound.image).intersect(tube);
                bound.range.assign(bound.series, &guess);
            }
        }
        let (mut open, mut all_lost) = (step.lanes, Mask::NONE);
        for round in 0..SERIES_ROUNDS {
            Interval8::run(Expansion {
                system: self,
                span: Interval::ZERO.hull(step.dt),
                lanes: open,
                along: Along::Range,
                from: 0,
                to: 1,
                faces,
                registers,
            });
            let mut unsettled = Mask::NONE;
            for state in 0..self.layout.states {
                for side in Side::BOTH {
                    let bound = &mut faces.bounds[state][side.index()];
                    let series = open & bound.series;
                    if series.none() {
                        continue;
                    }
                    let image = bound.image;
                    let tube = &step.apriori.tube[state];
                    let good = image.is_bounded()
                        & image.is_subset_of(tube)
                        & self.keeps_to_cell(state, side, bound, &image, series);
                    // The last round is the one in which no range changed any more.
                    let settled = good & image.is_subset_of(&bound.range);
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
                    all_lost |= lost;
                    self.give_up_series(step, (state, side), lost, faces, registers);
                }
            }
            open = unsettled;
            if open.none() {
                return all_lost;
            }
        }
        // Some range was still growing in the last round: no series is proved.
        for state in 0..self.layout.states {
            for side in Side::BOTH {
                let lost = open & faces.bounds[state][side.index()].series;
                self.give_up_series(step, (state, side), lost, faces, registers);
            }
        }
        all_lost | open
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

    /// Coefficient `k` of the right-hand side of a comparison equation; everything where it is not
    /// smooth.
    #[inline(always)]
    fn comparison<A: Arithmetic<Value = Interval8>>(
        &self,
        (state, side): (usize, Side),
        k: usize,
        along: Along,
        faces: &Faces,
        registers: &mut Registers,
    ) -> Interval8 {
        let bound = &faces.bounds[state][side.index()];
        let mut velocity = Interval8::ENTIRE;
        for (rhs, plan) in bound.plans.iter().enumerate() {
            let group = plan.lanes & bound.series;
            if group.none() {
                continue;
            }
            let tapes = &self.right_hand_sides[state][rhs];
            let scratch = &mut registers.series[state][rhs][side.index()];
            for (source, &position) in plan.sources.iter().zip(&tapes.moving_positions) {
                let quantity = tapes.series_quantities[position];
                let value = faces.source(quantity, source, k, along);
                tapes.series.set_quantity(position, k, value, scratch);
            }
            let regular = tapes.series.compute::<A>(k, scratch);
            let value = tapes.series.output(0, k, scratch);
            velocity.assign(group & regular.is_smooth(), &value);
        }
        if k == 0 && !bound.slack_in.none() {
            velocity = A::add(&velocity, &bound.slack);
        }
        velocity
    }
}

/// Taylor coefficients `from + 1` to `to` of all comparison solutions side by side; from 0 on also
/// coefficient 0 of all bounds, and their images.
///
/// Those of the boxes in `lanes` are wanted; the others get the ones they have already.
struct Expansion<'a> {
    system: &'a System,
    /// Times of the step.
    span: Interval,
    lanes: Mask,
    along: Along,
    from: usize,
    to: usize,
    faces: &'a mut Faces,
    registers: &'a mut Registers,
}

impl Kernel<Interval8> for Expansion<'_> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic<Value = Interval8>>(self) {
        let Expansion {
            system,
            span,
            lanes,
            along,
            from,
            to,
            faces,
            registers,
        } = self;
        if from == 0 {
            for bound in faces.bounds.iter_mut().flatten() {
                bound.coefficients_mut(along)[0] = match along {
                    Along::Start => Interval8::point(bound.start),
                    Along::Range => bound.range,
                };
            }
        }
        for k in from..to {
            for state in 0..system.layout.states {
                for side in Side::BOTH {
                    if (lanes & faces.bounds[state][side.index()].series).none() {
                        continue;
                    }
                    let mut value =
                        system.comparison::<A>((state, side), k, along, faces, registers);
                    if k > 0 {
                        value = A::scale(&value, faces.reciprocals[k]);
                    }
                    let bound = &mut faces.bounds[state][side.index()];
                    bound.coefficients_mut(along)[k + 1] = value;
                    if k == 0 {
                        let start = Interval8::point(bound.start);
                        bound.image = A::add(&start, &A::scale(&value, span));
                    }
                }
            }
        }
    }
}

/// The end of every comparison solution.
struct Sum<'a> {
    dt: Interval,
    faces: &'a mut Faces,
}

impl Kernel<Interval8> for Sum<'_> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic<Value = Interval8>>(self) {
        let order = self.faces.order;
        for pair in &mut self.faces.bounds {
            for side in Side::BOTH {
                let bound = &mut pair[side.index()];
                if bound.series.none() {
                    continue;
                }
                let mut sum = bound.coefficients(Along::Range)[order + 1];
                for coefficient in bound.coefficients(Along::Start)[..=order].iter().rev() {
                    sum = A::add(coefficient, &A::scale(&sum, self.dt));
                }
                assign(&mut bound.end, bound.series, &side.ends(&sum));
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
