//! One bound of one state during a step.

use crate::side::Side;
use crate::system::RightHandSide;
use veribound_interval::lanes::{Floats, Interval8, LANES, Mask};

/// One bound of one state during a step, of eight boxes side by side.
#[derive(Debug, Clone)]
pub(super) struct Bound {
    /// The boxes' own bounds.
    pub(super) origin: Floats,
    /// Where the comparison solution starts: `origin`, or the far edge of the zone it lies in.
    pub(super) start: Floats,
    /// The cell it starts in.
    pub(super) cell: [usize; LANES],
    /// Advances as a Taylor series; elsewhere `end` and `range` are final.
    pub(super) series: Mask,
    /// The comparison equations, one per right-hand side of the state.
    pub(super) plans: Vec<Plan>,
    /// What unknown monotonicity adds to the velocity.
    pub(super) slack: Interval8,
    /// The boxes in which that is something.
    pub(super) slack_in: Mask,
    /// Values during the step.
    pub(super) range: Interval8,
    /// Picard's operator: where the comparison solution is during the step if its velocity stays in
    /// the first coefficient taken last. A proof only where that one was taken over this image.
    pub(super) image: Interval8,
    /// Taylor coefficients of the comparison solution, see [`Along`].
    coefficients: [Vec<Interval8>; 2],
    pub(super) end: Floats,
}

/// Where the Taylor coefficients of comparison solutions are taken.
#[derive(Debug, Clone, Copy)]
pub(super) enum Along {
    /// Where the bounds start.
    Start,
    /// Everywhere they are during the step.
    Range,
}

/// A comparison equation: where the states that its right-hand side depends on come from.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    /// The boxes whose bound follows it.
    pub(super) lanes: Mask,
    /// Per moving position of the series tape.
    pub(super) sources: Vec<Source>,
}

/// Where the value of a state in a comparison equation comes from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Source {
    /// The state's lower bound, moving in time.
    pub(super) lower: Mask,
    /// Its upper bound.
    pub(super) upper: Mask,
    /// Elsewhere a value that is constant for the whole step.
    pub(super) constant: Interval8,
}

impl Source {
    /// The bound of the state on `side`, in `lanes`.
    pub(super) fn follow(&mut self, side: Side, lanes: Mask) {
        match side {
            Side::Lower => self.lower |= lanes,
            Side::Upper => self.upper |= lanes,
        }
    }
}

impl Bound {
    pub(super) fn new(right_hand_sides: &[RightHandSide], order: usize) -> Bound {
        let source = Source {
            lower: Mask::NONE,
            upper: Mask::NONE,
            constant: Interval8::ZERO,
        };
        let plan = |rhs: &RightHandSide| Plan {
            lanes: Mask::NONE,
            sources: vec![source; rhs.moving_positions.len()],
        };
        Bound {
            origin: [0.0; LANES],
            start: [0.0; LANES],
            cell: [0; LANES],
            series: Mask::NONE,
            plans: right_hand_sides.iter().map(plan).collect(),
            slack: Interval8::ZERO,
            slack_in: Mask::NONE,
            range: Interval8::ZERO,
            image: Interval8::ZERO,
            coefficients: [(); 2].map(|()| vec![Interval8::ZERO; order + 2]),
            end: [0.0; LANES],
        }
    }

    /// Taylor coefficients of the comparison solution.
    #[inline(always)]
    pub(super) fn coefficients(&self, along: Along) -> &[Interval8] {
        let [start, range] = &self.coefficients;
        match along {
            Along::Start => start,
            Along::Range => range,
        }
    }

    #[inline(always)]
    pub(super) fn coefficients_mut(&mut self, along: Along) -> &mut [Interval8] {
        let [start, range] = &mut self.coefficients;
        match along {
            Along::Start => start,
            Along::Range => range,
        }
    }

    /// Forgets the comparison equations of the step before.
    pub(super) fn reset(&mut self) {
        self.series = Mask::NONE;
        self.slack = Interval8::ZERO;
        self.slack_in = Mask::NONE;
        for plan in &mut self.plans {
            plan.lanes = Mask::NONE;
            for source in &mut plan.sources {
                source.lower = Mask::NONE;
                source.upper = Mask::NONE;
            }
        }
    }
}

/// What is known about the right-hand side on a face as far as its corners are fixed.
#[derive(Debug, Clone, Default)]
pub(super) struct Survey {
    /// Slopes on the whole face, the same for both bounds.
    pub(super) base: Vec<Interval8>,
    /// Slopes on the face as far as its corners are fixed.
    pub(super) slopes: Vec<Interval8>,
    /// Per quantity, the boxes on which nothing was put in its place yet.
    pub(super) open: Vec<Mask>,
}

/// The values that occur in `lanes`, each with the lanes that have it.
pub(super) fn groups<T: Copy + PartialEq>(
    values: [T; LANES],
    lanes: Mask,
) -> impl Iterator<Item = (T, Mask)> {
    let mut rest = lanes;
    std::iter::from_fn(move || {
        let first = rest.lanes().next()?;
        let value = *values.get(first)?;
        let group = rest & Mask::from_fn(|lane| values.get(lane) == Some(&value));
        rest = rest.without(group);
        Some((value, group))
    })
}

/// Takes over the numbers of some lanes.
pub(super) fn assign<T: Copy>(target: &mut [T; LANES], lanes: Mask, source: &[T; LANES]) {
    for (lane, (target, source)) in target.iter_mut().zip(source).enumerate() {
        if lanes.get(lane) {
            *target = *source;
        }
    }
}
