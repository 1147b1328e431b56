//! A box that contains every solution for the whole step.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: all slices have the lengths of the system's layout"
)]

use crate::guard::InCell;
use crate::modes::ModeSet;
use crate::system::{Registers, System};
use veribound_interval::Interval;
use veribound_model::Regularity;

/// Iterations before a step is called too long.
const ROUNDS: usize = 12;

/// Why no a-priori box was found.
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

/// What holds on the a-priori box.
#[derive(Debug, Clone, Default)]
pub(crate) struct Apriori {
    /// Encloses every state at every time of the step.
    pub(crate) tube: Vec<Interval>,
    /// Encloses every velocity on the tube.
    pub(crate) velocity: Vec<Interval>,
    /// Modes that belong to the Filippov hull somewhere on the tube.
    pub(crate) modes: ModeSet,
}

impl System {
    /// Encloses `F(q)` into `velocity`: for each state the hull of the right-hand sides of all
    /// modes whose closed guard meets the box, each taken on the part of the box it is active on.
    /// `clipped` is scratch. Returns those modes.
    pub(crate) fn velocity(
        &self,
        q: &[Interval],
        velocity: &mut [Interval],
        clipped: &mut Vec<Interval>,
        registers: &mut Registers,
    ) -> Result<ModeSet, AprioriFailure> {
        velocity.fill(Interval::EMPTY);
        let in_cell: InCell = None;
        let mut modes = ModeSet::EMPTY;
        for mode in 0..self.mode_count() {
            clipped.clear();
            clipped.extend_from_slice(q);
            if !self
                .guards
                .clip(mode, clipped, in_cell, &mut registers.guards)
            {
                continue;
            }
            modes.insert(mode);
            for (state, &choice) in self.choice[mode].iter().enumerate() {
                let rhs = &self.right_hand_sides[state][choice];
                let tape_registers = &mut registers.value[state][choice];
                if rhs.value.eval(clipped, tape_registers) == Regularity::Undefined {
                    return Err(AprioriFailure::Undefined { state });
                }
                let value = rhs.value.output(0, tape_registers);
                if !value.is_bounded() {
                    return Err(AprioriFailure::TooLong);
                }
                velocity[state] = velocity[state].hull(value);
            }
        }
        if modes.is_empty() {
            Err(AprioriFailure::NoMode)
        } else {
            Ok(modes)
        }
    }

    /// Finds a box that contains every solution from the states in `q` for all times in `[0, dt]`.
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
        q: &mut [Interval],
        dt: Interval,
        result: &mut Apriori,
        clipped: &mut Vec<Interval>,
        registers: &mut Registers,
    ) -> Result<(), AprioriFailure> {
        let n = self.layout.states;
        let span = Interval::ZERO.hull(dt);
        let start: &mut Vec<Interval> = &mut result.tube;
        start.clear();
        start.extend_from_slice(&q[..n]);
        result.velocity.resize(n, Interval::EMPTY);
        let mut outcome = Err(AprioriFailure::TooLong);
        for _ in 0..ROUNDS {
            match self.velocity(q, &mut result.velocity, clipped, registers) {
                Ok(modes) => result.modes = modes,
                Err(failure) => {
                    outcome = Err(failure);
                    break;
                }
            }
            let mapped = |i: usize, velocity: &[Interval]| start[i] + span * velocity[i];
            if (0..n).all(|i| mapped(i, &result.velocity).is_interior_of(q[i])) {
                outcome = Ok(());
                break;
            }
            for i in 0..n {
                let image = mapped(i, &result.velocity);
                q[i] = inflated(image, start[i]);
            }
        }
        if outcome.is_ok() {
            for i in 0..n {
                q[i] = start[i] + span * result.velocity[i];
            }
            result.tube.swap_with_slice(&mut q[..n]);
            // `q` again holds the start box; `tube` the enclosure for all times.
        } else {
            q[..n].copy_from_slice(start);
        }
        outcome
    }
}

/// A little more than `image`: a tenth of its growth over the start box, and enough to have an
/// interior.
fn inflated(image: Interval, start: Interval) -> Interval {
    let growth = 0.1 * (image.width() - start.width()).max(0.0);
    let least = 1e-12 * image.mag() + 1e-150;
    let reach = growth + least;
    Interval::new(-reach, reach).map_or(Interval::ENTIRE, |more| image + more)
}
