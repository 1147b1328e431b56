//! Samples on the way of a set to where the same has happened to all its solutions: there some have done it, others have not.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: a journey ends before its last stretch does"
)]

use super::journey::{Arriving, Ended, Journey};
use super::set::Form;
use crate::modes::ModeSet;
use veribound_interval::Interval;

/// All solutions at a sample.
#[derive(Debug, Clone)]
pub(super) struct Passing {
    /// A box around them.
    pub(super) hull: Vec<Interval>,
    /// States and modes since the sample before.
    pub(super) tube: Vec<Interval>,
    pub(super) modes: ModeSet,
    pub(super) steps: u64,
    /// A form of them, for who meets it.
    pub(super) copy: Option<(Form, Option<Arriving>)>,
}

impl Passing {
    /// Of nobody.
    pub(super) fn new(states: usize) -> Passing {
        let none = vec![Interval::EMPTY; states];
        Passing {
            hull: none.clone(),
            tube: none,
            modes: ModeSet::EMPTY,
            steps: 0,
            copy: None,
        }
    }

    /// Solutions that are in `hull` at the sample, too.
    pub(super) fn at(&mut self, hull: &[Interval]) {
        for (all, x) in self.hull.iter_mut().zip(hull) {
            *all = all.hull(*x);
        }
    }

    /// Solutions that were in `tube` since the sample before, too.
    pub(super) fn through(&mut self, tube: &[Interval], modes: ModeSet, steps: u64) {
        for (all, x) in self.tube.iter_mut().zip(tube) {
            *all = all.hull(*x);
        }
        self.modes = self.modes.union(modes);
        self.steps += steps;
    }
}

impl Journey<'_> {
    /// Goes to the end of the stretch at hand, and encloses the states there; what happened on the way is added to what is told of the
    /// sample.
    pub(super) async fn go_to_sample(&mut self, passing: &mut Passing) -> Option<&[Interval]> {
        let (next, before) = (self.current + 1, self.proved.steps);
        self.until = next;
        self.run_beside().await.ok()?;
        if !self.is_at(next) || !self.parts.is_empty() {
            return None;
        }
        let proved = &self.proved;
        let steps = proved.steps - before;
        passing.through(proved.tubes.last()?, *proved.modes.last()?, steps);
        proved.ends.last().map(Vec::as_slice)
    }

    /// Goes on over these samples, to `form` at the last one.
    pub(super) fn pass_samples(&mut self, samples: Vec<Passing>, mut form: Form) {
        let mut tube = std::mem::take(&mut self.form.tube);
        self.earlier.clear();
        self.passed_by.clear();
        let count = samples.len();
        for (number, sample) in samples.into_iter().enumerate() {
            let outputs = self.outputs_on(&sample.tube, self.inputs());
            self.proved.pass(&outputs, sample.modes);
            self.proved.steps += sample.steps;
            for (all, x) in tube.iter_mut().zip(&sample.tube) {
                *all = all.hull(*x);
            }
            if number + 1 == count {
                self.ended = Some(Ended {
                    states: form.states.clone(),
                    rest: form.frame.hull(),
                    hull: sample.hull,
                });
                break;
            }
            let (stretch, next) = (&self.stretches[self.current], self.current + 1);
            let outputs = self.outputs_on(&sample.hull, &self.stretches[next].inputs);
            let none = vec![Interval::EMPTY; tube.len()];
            self.proved
                .end(sample.hull, std::mem::replace(&mut tube, none));
            self.proved.begin(outputs);
            self.form.elapsed = self.begin + stretch.dt;
            self.enter(next);
            if let Some((copy, arriving)) = sample.copy {
                self.passed_by.push((next, copy, arriving));
            }
        }
        form.tube = tube;
        self.form = form;
        self.left = Interval::ZERO;
    }
}
