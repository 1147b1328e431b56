//! A box that contains every solution for the whole step.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: all slices have the lengths of the system's layout"
)]

use crate::advance::advance;
use crate::guard::InCell;
use crate::modes::ModeMasks;
use crate::system::{Choice, Registers, System};
use veribound_interval::Interval;
use veribound_interval::lanes::{Floats, Interval8, LANES, Mask};

/// Iterations before a step is called too long. Growth of a tenth a round triples a box in twelve;
/// what has not come to rest by then is helped by halving the step, not by patience.
const ROUNDS: usize = 12;

/// Why no a-priori box was found.
///
/// ```
/// use veribound_flow::{AprioriFailure, StepFailure, StepOptions, System, Workspace};
/// # use veribound_interval::Interval;
///
/// // x' = x² from 1 is infinite after a second.
/// let text = "format = 1\nstates = [\"x\"]\ninit.x = 1\nder.x = \"x^2\"\noutputs.y = \"x +- 0.01\"";
/// let model = veribound_model::Model::from_text("m.toml", text)?;
/// let system = System::new(&model);
/// let options = StepOptions { halvings: 3, ..StepOptions::default() };
/// let mut workspace = Workspace::new(&system, options);
/// let failed = system.step(&mut [Interval::ONE], &[], &[], Interval::point(2.0), &mut workspace);
/// assert!(matches!(failed, Err(StepFailure::Apriori(AprioriFailure::TooLong))));
/// # Ok::<(), veribound_model::Diagnostics>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AprioriFailure {
    /// Candidate boxes kept growing: the step is too long for this box.
    TooLong,
    /// The right-hand side of this state is not defined on the candidate box.
    Undefined {
        /// Index of the state.
        state: usize,
    },
    /// No mode's guard holds on the candidate box, so the model says nothing there.
    NoMode,
}

/// What holds on the a-priori boxes.
#[derive(Debug, Clone, Default)]
pub(crate) struct Apriori {
    /// Encloses every state at every time of the step.
    pub(crate) tube: Vec<Interval8>,
    /// Encloses every velocity on the tube.
    pub(crate) velocity: Vec<Interval8>,
    /// Modes that belong to the Filippov hull somewhere on the tube.
    pub(crate) modes: ModeMasks,
    /// Why there is none.
    pub(crate) failed: [Option<AprioriFailure>; LANES],
    start: Vec<Interval8>,
    image: Vec<Interval8>,
    pub(crate) candidate: Candidate,
}

/// Velocities and modes on a candidate box; scratch.
#[derive(Debug, Clone, Default)]
pub(crate) struct Candidate {
    pub(crate) velocity: Vec<Interval8>,
    pub(crate) modes: ModeMasks,
    flowing: Vec<Interval8>,
    clipped: Vec<Interval8>,
}

impl Candidate {
    /// Room for a box where solutions flow, and for the part of it on which a mode acts.
    pub(crate) fn scratch(&mut self) -> (&mut Vec<Interval8>, &mut Vec<Interval8>) {
        (&mut self.flowing, &mut self.clipped)
    }
}

impl System {
    /// Encloses `F(q)` on the boxes in `lanes`, as far as solutions flow there: for each state the
    /// hull of the right-hand sides of all modes whose closed guard meets the box, each taken on the
    /// part of the box it is active on. Returns the boxes on which that is bounded; `failed` says why the others have none.
    pub(crate) fn velocity(
        &self,
        q: &[Interval8],
        lanes: Mask,
        candidate: &mut Candidate,
        failed: &mut [Option<AprioriFailure>; LANES],
        registers: &mut Registers,
    ) -> Mask {
        let Candidate {
            velocity,
            modes,
            flowing,
            clipped,
        } = candidate;
        velocity.clear();
        velocity.resize(self.layout.states, Interval8::EMPTY);
        modes.clear(self.mode_count());
        let in_cell: InCell = None;
        let mut left = lanes;
        let mut fail = |left: &mut Mask, lanes: Mask, failure: AprioriFailure| {
            for lane in (*left & lanes).lanes() {
                failed[lane] = Some(failure);
            }
            *left = left.without(lanes);
        };
        flowing.clear();
        flowing.extend_from_slice(q);
        let flows = self
            .guards
            .clip_to_flow(flowing, left, in_cell, &mut registers.guards);
        let only_jumps = left.without(flows);
        fail(&mut left, only_jumps, AprioriFailure::NoMode);
        for mode in 0..self.mode_count() {
            clipped.clear();
            clipped.extend_from_slice(flowing);
            let active = self
                .guards
                .clip(mode, clipped, left, in_cell, &mut registers.guards);
            if active.none() {
                continue;
            }
            modes.insert(mode, active);
            for &Choice { state, rhs: choice } in &self.governed[mode] {
                let rhs = &self.right_hand_sides[state][choice];
                let tape_registers = &mut registers.value[state][choice];
                let regular = rhs.value.eval(clipped, tape_registers);
                let value = rhs.value.output(0, tape_registers);
                let undefined = active.without(regular.is_defined());
                fail(&mut left, undefined, AprioriFailure::Undefined { state });
                let unbounded = active.without(value.is_bounded());
                fail(&mut left, unbounded, AprioriFailure::TooLong);
                let hull = velocity[state].hull(&value);
                velocity[state].assign(active, &hull);
            }
        }
        for group in &self.groups {
            let without_mode = left.without(modes.any_of(group.clone()));
            fail(&mut left, without_mode, AprioriFailure::NoMode);
        }
        left
    }

    /// Finds boxes that contain every solution from the states in `q` for all times in `[0, dt]`.
    /// Returns the lanes for which it did.
    ///
    /// Steps 1 and 2 of the talk's method: the candidate grows until Picard's operator for the
    /// union of all modes that are active on the candidate maps it into its own interior; modes
    /// that become active on a grown candidate join the union.
    ///
    /// Why it holds: let B be the candidate and X + [0,dt] F(B) ⊂ int B. A Filippov solution from
    /// X has velocities in F(x), a.e., and F(x) ⊂ F(B) while it is in B; so up to the first time
    /// it leaves B it lies in X + [0,dt] F(B), inside the interior, and cannot leave. The hull over
    /// *closed* guards makes F upper semicontinuous, so solutions exist.
    pub(crate) fn apriori(
        &self,
        q: &mut [Interval8],
        lanes: Mask,
        dt: Interval,
        result: &mut Apriori,
        registers: &mut Registers,
    ) -> Mask {
        let n = self.layout.states;
        let span = Interval::ZERO.hull(dt);
        let Apriori {
            tube,
            velocity,
            modes,
            failed,
            start,
            image,
            candidate,
        } = result;
        start.clear();
        start.extend_from_slice(&q[..n]);
        for list in [&mut *tube, &mut *velocity, &mut *image] {
            list.resize(n, Interval8::EMPTY);
        }
        modes.clear(self.mode_count());
        *failed = [Some(AprioriFailure::TooLong); LANES];
        let mut open = lanes;
        for _ in 0..ROUNDS {
            open = self.velocity(q, open, candidate, failed, registers);
            let mut proved = open;
            advance(start, span, &candidate.velocity, image);
            for i in 0..n {
                proved &= image[i].is_interior_of(&q[i]);
            }
            for i in 0..n {
                tube[i].assign(proved, &image[i]);
                velocity[i].assign(proved, &candidate.velocity[i]);
            }
            modes.assign(proved, &candidate.modes);
            for lane in proved.lanes() {
                failed[lane] = None;
            }
            open = open.without(proved);
            if open.none() {
                break;
            }
            for i in 0..n {
                let grown = inflated(&image[i], &start[i]);
                q[i].assign(open, &grown);
            }
        }
        q[..n].copy_from_slice(start);
        Mask::from_fn(|lane| lanes.get(lane) && failed[lane].is_none())
    }
}

/// A little more than `image`: a tenth of its growth over the start box, since on the grown box the
/// velocities are a little larger, and enough to have an interior also where nothing moves (some
/// floats of the size of the box, or a number that is none of a physical quantity). Any choice is
/// sound; this one is accepted in the second round mostly.
fn inflated(image: &Interval8, start: &Interval8) -> Interval8 {
    let (after, before, size) = (image.width(), start.width(), image.mag());
    let reach: Floats = std::array::from_fn(|lane| {
        let growth = 0.1 * (after[lane] - before[lane]).max(0.0);
        growth + (1e-12 * size[lane] + 1e-150)
    });
    *image + Interval8::between(reach.map(|r| -r), reach)
}
