//! What acts on a state during a step: modes, and levels at which it rests.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: a workspace's slices have the lengths of its system's layout"
)]

use crate::guard::InCell;
use crate::modes::ModeSet;
use crate::step::Workspace;
use crate::system::System;
use veribound_interval::Interval;
use veribound_interval::lanes::{Interval8, Mask};

/// What acts on a state during a step.
///
/// Guarantee: at almost every time of the step the derivative of the state is a convex combination of those of `modes`, or the state
/// is on one of the `levels`, and its derivative is zero.
///
/// Proof. At times at which the state is on none of the levels that guards compare it with, the former is Filippov's definition. The state is
/// absolutely continuous, and so has the derivative zero at almost all times at which it has one certain value; where no convex
/// combination on the level is zero, there are almost no such times.
///
/// ```
/// use veribound_flow::{StepOptions, System, Workspace};
/// # use veribound_interval::Interval;
///
/// // What is at zero stays there: neither mode is written to hold it, both together do.
/// let text = r#"
///     format = 1
///     states = ["v"]
///     init.v = [0, 1]
///     outputs.y = "v +- 0.01"
///     modes.slower = { when = "v >= 0", der.v = "-1" }
///     modes.faster = { when = "v < 0", der.v = "1" }
/// "#;
/// let model = veribound_model::Model::from_text("m.toml", text)?;
/// let system = System::new(&model);
/// let mut workspace = Workspace::new(&system, StepOptions::default());
/// let tube = [Interval::new(0.0, 1.0).unwrap()];
/// let acting = system.acting_on((&tube, &[], &[]), 0, &mut workspace);
/// assert!(acting.modes.contains(0) && !acting.modes.contains(1));
/// assert_eq!(acting.levels, [0.0]);
/// # Ok::<(), veribound_model::Diagnostics>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Acting {
    /// Modes that may act while it is between levels, or on one that is no floating-point number.
    pub modes: ModeSet,
    /// The other levels, where it may stay.
    pub levels: Vec<f64>,
}

impl System {
    /// What acts on a state that does not jump, while states, parameters and inputs are in these boxes.
    pub fn acting_on(
        &self,
        (states, params, inputs): (&[Interval], &[Interval], &[Interval]),
        state: usize,
        workspace: &mut Workspace,
    ) -> Acting {
        let Workspace {
            q,
            apriori,
            registers,
            ..
        } = workspace;
        let (flowing, clipped) = apriori.candidate.scratch();
        q.clear();
        let all = states.iter().chain(params).chain(inputs);
        q.extend(all.map(|x| Interval8::splat(*x)));
        let one = Mask::lane(0);
        let tube = states[state];
        let levels = &self.guards.levels[state];
        let mut acting = Acting::default();
        for cell in levels.cell(tube.lo())..=levels.cell(tube.hi()) {
            let part = levels.range(cell).intersect(tube);
            let in_cell: InCell = Some((state, cell));
            flowing.clear();
            flowing.extend_from_slice(q);
            flowing[state] = Interval8::splat(part);
            let guards = &mut registers.guards;
            if self
                .guards
                .clip_to_flow(flowing, one, in_cell, guards)
                .none()
            {
                continue;
            }
            let is_level = cell % 2 == 1 && levels.range(cell).width() == 0.0;
            let mut rate = Interval::EMPTY;
            for &(mode, choice) in &self.governing[state] {
                clipped.clear();
                clipped.extend_from_slice(flowing);
                let guards = &mut registers.guards;
                if self.guards.clip(mode, clipped, one, in_cell, guards).none() {
                    continue;
                }
                if !is_level {
                    acting.modes.insert(mode);
                    continue;
                }
                let value = &self.right_hand_sides[state][choice].value;
                let registers = &mut registers.value[state][choice];
                let is_defined = value.eval(clipped, registers).is_defined().get(0);
                let own = value.output(0, registers).get(0);
                rate = rate.hull(if is_defined { own } else { Interval::ENTIRE });
            }
            if is_level && rate.contains(0.0) {
                acting.levels.push(part.lo());
            }
        }
        acting
    }
}
