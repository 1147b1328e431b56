//! Jumps at one instant, when inputs and parameters become new ones.

use super::solve::{Solver, reduced};
use crate::step::{StepFailure, Workspace};
use crate::system::System;
use veribound_interval::Interval;

/// What jumps at one instant.
///
/// ```
/// use veribound_flow::{AtOnce, StepOptions, System, Workspace};
/// use veribound_interval::Interval;
///
/// // A memory that takes what the input says once that is positive.
/// let text = r#"
///     format = 1
///     states = ["x", "m"]
///     init = { x = 0, m = 0 }
///     inputs = ["u"]
///     der = { x = "1", m = "0" }
///     jumps.take = { when = "u >= 1 and m <= 0.5", set.m = "1" }
///     outputs.y = "x +- 0.1"
/// "#;
/// let model = veribound_model::Model::from_text("m.toml", text)?;
/// let system = System::new(&model);
/// let mut workspace = Workspace::new(&system, StepOptions::default());
/// let (states, new) = ([Interval::ZERO; 2], [false, false, true]);
/// let found = system.jump_at_once(&states, &[], &[Interval::point(2.0)], &new, &mut workspace);
/// let AtOnce { ends, jumped } = found.map_err(|failed| format!("{failed:?}"))?.unwrap();
/// assert!(ends.iter().any(|end| end[1].contains(1.0)) && jumped == [1]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
