//! Jumps at one instant, when inputs and parameters become new ones.

use super::solve::{Solver, reduced};
use crate::step::{StepFailure, Workspace};
use crate::system::System;
use veribound_interval::Interval;

/// What jumps at one instant.
#[derive(Debug, Clone, PartialEq)]
pub struct AtOnce {
    /// Boxes of states that together contain every solution after its jumps.
    pub ends: Vec<Vec<Interval>>,
    /// States that may have jumped.
    pub jumped: Vec<usize>,
}

impl System {
    /// Where solutions in `states` may be after jumps at this instant.
    ///
    /// Guarantee: every solution that jumps here, any number of times, is afterwards in one of the
    /// boxes, if its first jump reads one of the quantities that are `changed` (states, parameters and
    /// inputs, in the order of the layout). None is returned where no such jump is possible. What jumps
    /// for other reasons did so at the end of the step before.
    pub fn jump_at_once(
        &self,
        states: &[Interval],
        params: &[Interval],
        inputs: &[Interval],
        changed: &[bool],
        workspace: &mut Workspace,
    ) -> Result<Option<AtOnce>, StepFailure> {
        let is_new = |jump: &super::Jump| {
            let mut reads = jump.reads.iter();
            reads.any(|quantity| changed.get(*quantity).copied().unwrap_or(false))
        };
        let new: Vec<bool> = self.jumps.list.iter().map(is_new).collect();
        if !new.contains(&true) {
            return Ok(None);
        }
        let mut solver = Solver::new(self, states, params, inputs, workspace);
        let mut ends = Vec::new();
        for (jump, image) in solver.images(states)? {
            if new.get(jump) == Some(&true) {
                ends.extend(solver.sweep_apart(&image, 0.0, 1)?);
            }
        }
        if ends.is_empty() {
            return Ok(None);
        }
        Ok(Some(AtOnce {
            ends: reduced(ends),
            jumped: solver.jumped(),
        }))
    }
}
