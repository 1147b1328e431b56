//! Boxes of the observer, moved by an engine besides.
//!
//! A step of boxes forgets at every sample how states depend on start values and parameters. A *form* ([`Form`]) keeps it: a
//! box that is followed has one that contains all solutions of the box. It is moved along with the box, and both are cut with each
//! other; what is measured narrows its unknowns, and so parameters too. Where a box is no longer what its form was made for
//! (boxes were joined, a parameter or the state may be a new one) the form begins anew.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: every box holds one interval per state and parameter, and a sample's lengths \
              are checked when it comes in"
)]

use crate::cell::Cell;
use crate::verdict::{Contradiction, distance};
use std::sync::Arc;
use veribound_flow::engine::{Engine, Engines, Task};
use veribound_flow::form::{Effort, Form, FormOptions, Output, Stretch, Unknown};
use veribound_interval::Interval;
use veribound_model::{Model, Sample};

/// A form begins anew where it is so many times as wide as its box.
const WORSE: f64 = 2.0;

/// Boxes are small, and dependence on what is far from linear is not worth more.
const DEGREE: usize = 2;

/// A form around all solutions of a box; it is no part of what the box says.
#[derive(Debug, Clone, Default)]
pub(crate) struct Kept(Option<Arc<Form>>);

impl PartialEq for Kept {
    fn eq(&self, _: &Kept) -> bool {
        true
    }
}

/// An engine that moves boxes.
pub(crate) struct Follower {
    engines: Engines,
    engine: Engine,
    options: FormOptions,
    outputs: Vec<Output>,
    states: usize,
}

impl Follower {
    /// `None` where boxes do alone.
    pub(crate) fn new(model: &Model, engine: Engine) -> Option<Follower> {
        if matches!(engine, Engine::Auto | Engine::Boxes) {
            return None;
        }
        let outputs = model.outputs.iter();
        Some(Follower {
            engines: Engines::new(model),
            options: FormOptions {
                degree: Some(DEGREE),
                closed: engine == Engine::Closed,
                ..FormOptions::default()
            },
            outputs: outputs.map(|o| Output::new(model, o.expr)).collect(),
            states: model.states.len(),
            engine,
        })
    }

    /// Cuts `moved`, which is `cell` after the step, with what the engine proves of the same solutions.
    pub(crate) fn advance(
        &self,
        cell: &Cell,
        moved: &mut Cell,
        (inputs, dt): (&[Interval], Interval),
    ) {
        moved.kept = Kept::default();
        let (states, params) = cell.z.split_at(self.states);
        if self.engine == Engine::Comparison {
            let stretch = Stretch {
                inputs: inputs.to_vec(),
                dt,
            };
            let task = Task {
                states,
                params,
                stretches: &[stretch],
                options: self.options,
                effort: Effort {
                    parts: 1,
                    ..Effort::default()
                },
            };
            let found = self.engines.enclose(self.engine, task, &|_| true);
            if let Some(end) = found.enclosure.ends.first() {
                cut(&mut moved.z, end);
            }
            return;
        }
        let flow = self.engines.flow();
        let kept = cell.kept.0.as_ref();
        let mut form = kept
            .and_then(|form| self.narrowed(form, &cell.z))
            .unwrap_or_else(|| flow.start(states, params, self.options));
        if flow.advance(&mut form, inputs, dt).is_ok() && cut(&mut moved.z, &form.hull()) {
            moved.kept = Kept(Some(Arc::new(form)));
        }
    }

    /// A form less what its box leaves out; `None` where it had better begin anew.
    fn narrowed(&self, form: &Form, z: &[Interval]) -> Option<Form> {
        let mut form = form.clone();
        let unit = Interval::symmetric(1.0);
        let parts: Vec<Interval> = form
            .scales()
            .into_iter()
            .map(|(unknown, middle, radius)| match unknown {
                Unknown::Param(i) => {
                    let within = (z[self.states + i] - middle) / radius;
                    unit.intersect(within)
                }
                Unknown::Start(_) | Unknown::Axis(_) => unit,
            })
            .collect();
        if parts.iter().any(|part| part.is_empty()) {
            return None;
        }
        form.narrow(&parts);
        for (state, known) in z[..self.states].iter().enumerate() {
            let own = form.state(state);
            if !own.hull.is_subset_of(*known) {
                form.contract(&own, *known).ok()?;
            }
        }
        let wide = form.hull().into_iter().zip(z);
        let mut wide = wide.map(|(own, z)| own.width() > WORSE * z.width() + 1e-9 * own.mag());
        (!wide.any(|is_worse| is_worse)).then_some(form)
    }

    /// Narrows the form of a box to what agrees with a sample, and the box to the form.
    ///
    /// Errors: a measurement that no solution in the form has.
    pub(crate) fn measure(&self, cell: &mut Cell, sample: &Sample) -> Result<(), Contradiction> {
        let Some(kept) = cell.kept.0.take() else {
            return Ok(());
        };
        let mut form = Arc::unwrap_or_clone(kept);
        let mut last = None;
        for (output, measured) in sample.outputs.iter().enumerate() {
            let Some(measured) = *measured else { continue };
            let Ok(own) = form.output(&self.outputs[output], &sample.inputs) else {
                continue;
            };
            let contradiction = Contradiction::Output {
                output,
                enclosure: own.hull,
                measured,
                gap: distance(own.hull, measured),
            };
            if form.contract(&own, measured).is_err() {
                return Err(contradiction);
            }
            last = Some(contradiction);
        }
        let Some(last) = last else {
            cell.kept = Kept(Some(Arc::new(form)));
            return Ok(());
        };
        let mut bounds = form.hull();
        bounds.resize(cell.z.len(), Interval::ENTIRE);
        for (unknown, range) in form.unknowns() {
            if let Unknown::Param(i) = unknown {
                bounds[self.states + i] = range;
            }
        }
        // All solutions of the box are in the form, and in the box.
        if !cut(&mut cell.z, &bounds) {
            return Err(last);
        }
        cell.kept = Kept(Some(Arc::new(form)));
        Ok(())
    }
}

/// Cuts intervals with others; false, and nothing is cut, where that leaves nothing.
fn cut(z: &mut [Interval], with: &[Interval]) -> bool {
    let left: Vec<Interval> = z.iter().zip(with).map(|(x, y)| x.intersect(*y)).collect();
    let some = left.iter().all(|x| !x.is_empty());
    if some {
        z[..left.len()].copy_from_slice(&left);
    }
    some
}
