//! Bounds that move with constant rates, level by level.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: arrays have one element per lane; zones and cells come from the levels"
)]

use super::Face;
use super::bound::{Bound, assign, groups};
use crate::side::{Side, earliest, latest};
use veribound_interval::lanes::{Floats, Interval8, LANES, Mask};
use veribound_interval::{Interval, round};

/// Phases one bound may pass through in one step before it falls back to the a-priori box: four
/// levels with the zones at them.
const PHASES: usize = 8;

const ZERO: Floats = [0.0; LANES];

/// What bounds that start or arrive at a zone do next: those in `enter` go on, the others rest.
pub(super) struct AtZone {
    pub(super) enter: Mask,
    pub(super) cell: [usize; LANES],
    pub(super) from: Floats,
    pub(super) after: Floats,
}

/// Bounds under way.
pub(super) struct Run {
    side: Side,
    /// The a-priori boxes' bounds.
    limit: Floats,
    v: Floats,
    pub(super) cell: [usize; LANES],
    elapsed: Floats,
    range: Interval8,
    active: Mask,
    end: Floats,
}

impl Run {
    /// Puts bounds at `v`.
    fn put(&mut self, lanes: Mask, v: &Floats) {
        assign(&mut self.v, lanes, v);
        let range = self.range.hull(&Interval8::point(*v));
        self.range.assign(lanes, &range);
    }

    /// Bounds that stay where they are for the rest of the step.
    fn stop(&mut self, lanes: Mask) {
        assign(&mut self.end, lanes, &self.v);
        self.active = self.active.without(lanes);
    }
}

impl Face<'_> {
    /// Moves the bounds in `lanes` from their origin with constant rates.
    pub(super) fn finish_roughly(&mut self, side: Side, bound: &mut Bound, lanes: Mask) {
        let run = self.start_roughly(side, bound, lanes);
        self.finish_run(run, bound, lanes);
    }

    /// Bounds at their origin.
    pub(super) fn start_roughly(&self, side: Side, bound: &Bound, lanes: Mask) -> Run {
        let levels = &self.system.guards.levels[self.state];
        let limit = side.ends(&self.apriori.tube[self.state]);
        Run {
            side,
            limit,
            v: bound.origin,
            cell: bound.origin.map(|origin| levels.cell(origin)),
            elapsed: ZERO,
            range: Interval8::point(bound.origin),
            active: lanes,
            end: limit,
        }
    }

    /// Moves bounds to the end of the step.
    pub(super) fn finish_run(&mut self, mut run: Run, bound: &mut Bound, lanes: Mask) {
        run.active &= lanes;
        let (side, limit) = (run.side, run.limit);
        let (end, range) = self.move_roughly(run);
        // No solution passes the a-priori box, so a bound beyond it may be put there.
        bound.series = bound.series.without(lanes);
        let inner: Floats = std::array::from_fn(|lane| side.inner(end[lane], limit[lane]));
        assign(&mut bound.end, lanes, &inner);
        let inside = side.other().between(&limit, &side.other().ends(&range));
        let range = range.intersect(&inside);
        let range = Interval8::point(inner).or_else(range.is_empty(), &range);
        bound.range.assign(lanes, &range);
    }

    /// Decides what bounds at the outer edge of zone `zone` do.
    pub(super) fn at_zone(&mut self, side: Side, zone: usize, lanes: Mask) -> AtZone {
        let levels = &self.system.guards.levels[self.state];
        let cell = 2 * zone + 1;
        let range = levels.range(cell);
        let (edge, far) = (side.end(range), side.other().end(range));
        let (outside, inside) = match side {
            Side::Upper => (cell + 1, cell - 1),
            Side::Lower => (cell - 1, cell + 1),
        };
        let limit = side.ends(&self.apriori.tube[self.state]);
        let beyond = side.between(&[edge; LANES], &limit);
        let beyond = beyond.intersect(&Interval8::splat(levels.range(outside)));
        let (rate, known) = self.rate(side, outside, &beyond, lanes);
        let out = known & side.all_beyond(&rate, &ZERO);
        let (rate, known) = self.rate(side, cell, &Interval8::splat(range), lanes.without(out));
        let through = known & side.other().all_beyond(&rate, &ZERO);
        let width = Interval::point(edge) - Interval::point(far);
        let choose = |lane: usize| out.get(lane);
        AtZone {
            enter: out | through,
            cell: std::array::from_fn(|lane| if choose(lane) { outside } else { inside }),
            from: std::array::from_fn(|lane| if choose(lane) { edge } else { far }),
            after: std::array::from_fn(|lane| {
                if through.get(lane) {
                    latest(width, rate[lane])
                } else {
                    0.0
                }
            }),
        }
    }

    /// Moves the bounds with constant rates, phase by phase.
    fn move_roughly(&mut self, mut run: Run) -> (Floats, Interval8) {
        for _ in 0..PHASES {
            for (cell, group) in groups(run.cell, run.active) {
                if cell % 2 == 1 {
                    let next = self.at_zone(run.side, cell / 2, group);
                    self.pass_zone(&mut run, cell, group, &next);
                } else {
                    self.pass_region(&mut run, cell, group);
                }
            }
            if run.active.none() {
                return (run.end, run.range);
            }
        }
        let stuck = run.active;
        run.put(stuck, &run.limit.clone());
        run.stop(stuck);
        (run.end, run.range)
    }

    /// One phase of bounds at a zone, at which they do what `next` says.
    pub(super) fn pass_zone(&self, run: &mut Run, cell: usize, group: Mask, next: &AtZone) {
        let levels = &self.system.guards.levels[self.state];
        run.put(group, &[run.side.end(levels.range(cell)); LANES]);
        run.stop(group.without(next.enter));
        let entering = group & next.enter;
        for lane in entering.lanes() {
            run.elapsed[lane] = round::add_up(run.elapsed[lane], next.after[lane]);
        }
        let late = entering & Mask::at_most(&[self.dt.lo(); LANES], &run.elapsed);
        run.stop(late);
        let entering = entering.without(late);
        assign(&mut run.cell, entering, &next.cell);
        run.put(entering, &next.from);
    }

    /// One phase of bounds inside a region.
    fn pass_region(&mut self, run: &mut Run, cell: usize, group: Mask) {
        let side = run.side;
        let levels = &self.system.guards.levels[self.state];
        let region = levels.range(cell);
        let within = Interval8::splat(region);
        let ahead = side.between(&run.v, &run.limit).intersect(&within);
        let (rate, known) = self.rate(side, cell, &ahead, group);
        run.stop(group.without(known));
        let inward = known & side.other().all_beyond(&rate, &ZERO);
        let outward = known.without(inward);
        let rest = Interval8::splat(self.dt) - Interval8::point(run.elapsed);
        let from = Interval8::point(run.v);
        if !outward.none() {
            let reach = side.ends(&(from + Interval8::point(rate) * rest));
            let edge = side.end(region);
            let over = outward & side.all_beyond(&reach, &[edge; LANES]);
            run.put(outward.without(over), &reach);
            run.stop(outward.without(over));
            for lane in over.lanes() {
                let distance = Interval::point(edge) - Interval::point(run.v[lane]);
                let time = earliest(distance, rate[lane]);
                run.elapsed[lane] = round::add_down(run.elapsed[lane], time);
                run.cell[lane] = outer_cell(side, cell);
            }
            run.put(over, &[edge; LANES]);
        }
        if inward.none() {
            return;
        }
        // Inward: the rate must hold for every place the bound will sweep.
        let slowest = side.other().ends(&self.apriori.velocity[self.state]);
        let times = Interval8::ZERO.hull(&rest);
        let sweep = from + times * Interval8::point(slowest);
        let swept = side
            .between(&side.other().ends(&sweep), &run.limit)
            .intersect(&within);
        let (rate, known) = self.rate(side, cell, &swept, inward);
        let moves = known & side.other().all_beyond(&rate, &ZERO);
        run.stop(inward.without(moves));
        if moves.none() {
            return;
        }
        let reach = side.ends(&(from + Interval8::point(rate) * rest));
        let edge = side.other().end(region);
        let over = moves & side.all_beyond(&[edge; LANES], &reach);
        run.put(moves.without(over), &reach);
        run.stop(moves.without(over));
        for lane in over.lanes() {
            let distance = Interval::point(run.v[lane]) - Interval::point(edge);
            let time = latest(distance, rate[lane]);
            run.elapsed[lane] = round::add_up(run.elapsed[lane], time);
            run.cell[lane] = outer_cell(side.other(), cell);
        }
        run.put(over, &[edge; LANES]);
        run.stop(over & Mask::at_most(&[self.dt.lo(); LANES], &run.elapsed));
    }
}

/// The neighbouring cell on `side`.
fn outer_cell(side: Side, cell: usize) -> usize {
    match side {
        Side::Upper => cell + 1,
        Side::Lower => cell.saturating_sub(1),
    }
}
