//! The box engine over whole runs.

use super::{Engines, Task};
use crate::form::{Diverged, Enclosure, Obstacle, Part, Standing};
use crate::step::{StepFailure, StepOptions, Workspace};
use veribound_interval::Interval;

impl Engines {
    /// One box from stretch to stretch.
    pub(super) fn boxes(
        &self,
        task: Task<'_>,
        go_on: &(dyn Fn(Standing) -> bool + Sync),
    ) -> Enclosure {
        let system = self.flow.system();
        let mut workspace = Workspace::new(system, StepOptions::default());
        let mut result = Enclosure {
            shares: vec![Vec::new(); task.states.len()],
            ..Enclosure::default()
        };
        let outputs = |states: &[Interval], inputs: &[Interval]| {
            let quantities = [states, task.params, inputs].concat();
            self.flow.outputs_on(&quantities)
        };
        let mut states = task.states.to_vec();
        let mut reached = Interval::ZERO;
        for stretch in task.stretches {
            let inputs = &stretch.inputs;
            result.outputs.push(outputs(&states, inputs));
            let standing = Standing {
                reached: reached.mid(),
                done: 0,
                waiting: 0,
                unknowns: 0,
                cost: 1.0,
            };
            let mut failed = (!go_on(standing)).then_some((Obstacle::Interrupted, 0));
            if failed.is_none() {
                let step =
                    system.step(&mut states, task.params, inputs, stretch.dt, &mut workspace);
                match step {
                    Ok(report) => {
                        result.steps += 1;
                        result.modes.push(report.modes_during);
                    }
                    Err(failure) => failed = Some(obstacle(failure, &states)),
                }
            }
            if let Some((obstacle, state)) = failed {
                result.stopped = Some(Diverged {
                    obstacle,
                    state,
                    reached,
                });
                break;
            }
            reached += stretch.dt;
            result.output_tubes.push(outputs(workspace.tube(), inputs));
            result.tubes.push(workspace.tube().to_vec());
            result.ends.push(states.clone());
        }
        result.parts.push(Part {
            states: task.states.to_vec(),
            params: task.params.to_vec(),
            passed: result.ends.len(),
            end: result.ends.last().cloned().unwrap_or_default(),
        });
        result
    }
}

/// What stood in the way, and of which state: the widest, where none is named.
fn obstacle(failure: StepFailure, states: &[Interval]) -> (Obstacle, usize) {
    let widest = (0..states.len()).max_by(|a, b| {
        let width = |i: usize| states.get(i).map_or(0.0, |x| x.width());
        width(*a).total_cmp(&width(*b))
    });
    let widest = widest.unwrap_or(0);
    match failure {
        StepFailure::Apriori(_) => (Obstacle::TooLong, widest),
        StepFailure::Unbounded => (Obstacle::Unbounded, widest),
        StepFailure::LeavesDomain { state } => (Obstacle::LeavesDomain, state),
        StepFailure::InputOutsideDomain { .. } => (Obstacle::LeavesDomain, widest),
    }
}
