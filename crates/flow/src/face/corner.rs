//! Velocities on a face, sharpened by monotonicity.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: states, right-hand sides and quantities are positions in the system's lists"
)]

use super::Face;
use super::bound::Plan;
use crate::side::Side;
use veribound_interval::lanes::{Floats, Interval8, LANES, Mask};

/// Rounds of the search for signs of the gradient: fixing one argument can decide another's sign,
/// and that one a third's; chains that are longer are rare and only cost tightness.
const SIGN_ROUNDS: usize = 3;

impl Face<'_> {
    /// Puts the a-priori boxes into `face`, with `range` for the state's own coordinate.
    pub(super) fn set_face(&mut self, range: &Interval8) {
        self.face.clear();
        self.face.extend_from_slice(self.q);
        self.face[..self.system.layout.states].copy_from_slice(&self.apriori.tube);
        self.face[self.state] = *range;
    }

    /// Puts the whole face into `clipped`.
    pub(super) fn unclip(&mut self) {
        self.clipped.clear();
        self.clipped.extend_from_slice(self.face);
    }

    /// Cuts `face` down to where solutions flow; returns the boxes in which they do somewhere.
    fn keep_flowing(&mut self, cell: usize, lanes: Mask) -> Mask {
        let in_cell = Some((self.state, cell));
        let guards = &mut self.registers.guards;
        let flow = &self.system.guards;
        flow.clip_to_flow(self.face, lanes, in_cell, guards)
    }

    /// Bounds of the velocity towards this side, over `x_i` in `range` inside `cell` and the
    /// other states in the a-priori box, and the boxes that have one: in the others no solution can
    /// be there.
    pub(super) fn rate(
        &mut self,
        side: Side,
        cell: usize,
        range: &Interval8,
        lanes: Mask,
    ) -> (Floats, Mask) {
        let mut worst = [0.0; LANES];
        let mut seen = Mask::NONE;
        let lanes = lanes.without(range.is_empty());
        if lanes.none() {
            return (worst, seen);
        }
        self.set_face(range);
        let lanes = self.keep_flowing(cell, lanes);
        let shared = self.system.right_hand_sides[self.state].len() == 1;
        for &(mode, rhs) in &self.system.governing[self.state] {
            let has_mode = lanes & self.apriori.modes.of(mode);
            if has_mode.none() {
                continue;
            }
            let active = if shared {
                has_mode.without(seen)
            } else {
                self.unclip();
                let in_cell = Some((self.state, cell));
                let guards = &mut self.registers.guards;
                let clip = &self.system.guards;
                clip.clip(mode, self.clipped, has_mode, in_cell, guards)
            };
            if active.none() {
                continue;
            }
            if shared {
                self.unclip();
            }
            let rate = self.rate_of(side, rhs, active);
            for lane in active.lanes() {
                worst[lane] = if seen.get(lane) {
                    side.outer(worst[lane], rate[lane])
                } else {
                    rate[lane]
                };
            }
            seen |= active;
        }
        (worst, seen)
    }

    /// The velocity towards this side of one right-hand side on the boxes in `clipped`.
    fn rate_of(&mut self, side: Side, rhs: usize, lanes: Mask) -> Floats {
        let tapes = &self.system.right_hand_sides[self.state][rhs];
        let registers = &mut self.registers.value[self.state][rhs];
        let regular = tapes.value.eval(self.clipped, registers);
        let plain = side.ends(&tapes.value.output(0, registers));
        let continuous = lanes & regular.is_continuous();
        if continuous.none() || tapes.others.is_empty() {
            return plain;
        }
        self.slopes(rhs);
        let slack = self.fix_corners(side, rhs, continuous, None);
        let registers = &mut self.registers.value[self.state][rhs];
        tapes.value.eval(self.clipped, registers);
        let corner = side.ends(&(tapes.value.output(0, registers) + slack));
        std::array::from_fn(|lane| {
            if continuous.get(lane) {
                side.inner(plain[lane], corner[lane])
            } else {
                plain[lane]
            }
        })
    }

    /// Partial derivatives of one right-hand side on the boxes in `clipped`.
    pub(super) fn slopes(&mut self, rhs: usize) {
        let tapes = &self.system.right_hand_sides[self.state][rhs];
        let registers = &mut self.registers.gradient[self.state][rhs];
        tapes.gradient.eval(self.clipped, registers);
        // Where a derivative exists nowhere on the box, as that of a root at exactly zero, nothing
        // is known about it.
        let slopes = (0..tapes.others.len()).map(|i| {
            let slope = tapes.gradient.output(i, registers);
            Interval8::ENTIRE.or_else(slope.is_empty(), &slope)
        });
        self.survey.slopes.clear();
        self.survey.slopes.extend(slopes);
    }

    /// Replaces in `clipped` every quantity in which the right-hand side is monotone by the end
    /// that makes it extreme towards this side, and every other state or input by its midpoint;
    /// returns the slack that covers the latter. Does so in `lanes`; the other boxes keep theirs.
    ///
    /// With a `plan`, moving states keep their whole range in `clipped` and are recorded as bounds
    /// instead. [`Face::slopes`] on `clipped` comes before.
    pub(super) fn fix_corners(
        &mut self,
        side: Side,
        rhs: usize,
        lanes: Mask,
        mut plan: Option<&mut Plan>,
    ) -> Interval8 {
        let layout = self.system.layout;
        let tapes = &self.system.right_hand_sides[self.state][rhs];
        let position_of = |quantity: usize| tapes.moving_position(quantity);
        let mut open = std::mem::take(&mut self.survey.open);
        open.clear();
        open.resize(tapes.others.len(), lanes);
        // Boxes whose corners changed after their slopes were taken.
        let mut stale = Mask::NONE;
        let mut left = lanes;
        for _ in 0..SIGN_ROUNDS {
            if !stale.none() {
                // On boxes that did not change the slopes stay what they were.
                self.slopes(rhs);
            }
            let mut narrowed = Mask::NONE;
            for (position, &quantity) in tapes.others.iter().enumerate() {
                let wanted = open[position] & left;
                if wanted.none() {
                    continue;
                }
                let slope = &self.survey.slopes[position];
                let rising = wanted & Mask::at_most(&[0.0; LANES], &slope.lo());
                let falling = wanted.without(rising) & Mask::at_most(&slope.hi(), &[0.0; LANES]);
                open[position] = open[position].without(rising | falling);
                for (lanes, towards) in [(rising, side), (falling, side.other())] {
                    if lanes.none() {
                        continue;
                    }
                    match &mut plan {
                        Some(plan) if quantity < layout.states => {
                            if let Some(position) = position_of(quantity) {
                                plan.sources[position].follow(towards, lanes);
                            }
                        }
                        _ => {
                            let end = Interval8::point(towards.ends(&self.clipped[quantity]));
                            let before = self.clipped[quantity];
                            self.clipped[quantity].assign(lanes, &end);
                            narrowed |= lanes.without(before.is_subset_of(&end));
                        }
                    }
                }
            }
            // Constant slopes, or slopes on an unchanged box, need no second look.
            stale = if tapes.linear { Mask::NONE } else { narrowed };
            left = stale & open.iter().fold(Mask::NONE, |all, open| all | *open);
            if left.none() {
                break;
            }
        }
        let mut slack = Interval8::ZERO;
        if open.iter().any(|open| !open.none()) {
            if !stale.none() {
                self.slopes(rhs);
            }
            for (position, &quantity) in tapes.others.iter().enumerate() {
                let is_param = (layout.states..layout.states + layout.params).contains(&quantity);
                if open[position].none() || is_param {
                    continue;
                }
                let range = self.clipped[quantity];
                let centre = Interval8::point(range.mid());
                let more = slack + self.survey.slopes[position] * (range - centre);
                slack.assign(open[position], &more);
                self.clipped[quantity].assign(open[position], &centre);
                if let Some(plan) = &mut plan
                    && let Some(moving) = position_of(quantity)
                {
                    plan.sources[moving]
                        .constant
                        .assign(open[position], &centre);
                }
            }
        }
        self.survey.open = open;
        Interval8::point(side.ends(&slack))
    }
}
