//! A model and a record, compiled for identification.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one stretch between two samples, lists as long as those of the model"
)]

use super::answer::{Conclusion, Refuted};
use super::region::Region;
use crate::signals::Signals;
use veribound_flow::form::{Flow, Output, Stretch};
use veribound_interval::{Decimal, Interval};
use veribound_model::{Layout, Model, Sample};

/// What a sample tells.
#[derive(Debug, Clone)]
pub(crate) struct Instant {
    /// Time stamp.
    pub(crate) time: Decimal,
    /// Line in the file.
    pub(crate) line: usize,
    /// Quantities, by position in [`Problem::quantities`], with every value each can have.
    pub(crate) told: Vec<(usize, Interval)>,
    /// Inputs from now on.
    pub(crate) inputs: Vec<Interval>,
    /// Parameters that may be new from now on.
    pub(crate) resets: Vec<usize>,
}

/// One record, with the start states that are its own.
#[derive(Debug, Clone)]
pub(crate) struct Course {
    pub(crate) instants: Vec<Instant>,
    pub(crate) stretches: Vec<Stretch>,
    /// Start values that are believed before the record.
    pub(crate) start: Vec<Interval>,
}

impl Course {
    /// The last sample up to which parameters are the same as at the first.
    pub(crate) fn horizon(&self) -> usize {
        let mut instants = self.instants.iter();
        let reset = instants.position(|instant| !instant.resets.is_empty());
        reset.unwrap_or(self.instants.len()).saturating_sub(1)
    }

    /// The same with what these samples tell alone.
    fn with(&self, is_kept: &dyn Fn(usize) -> bool) -> Course {
        let mut course = self.clone();
        for (sample, instant) in course.instants.iter_mut().enumerate() {
            if !is_kept(sample) {
                instant.told.clear();
            }
        }
        course
    }

    /// The inputs that may act at a sample: those until then, and those from then on.
    pub(crate) fn inputs_at(&self, sample: usize) -> Vec<Interval> {
        let now = &self.instants[sample].inputs;
        match sample.checked_sub(1) {
            None => now.clone(),
            Some(before) => {
                let before = self.instants[before].inputs.iter();
                before.zip(now).map(|(a, b)| a.hull(*b)).collect()
            }
        }
    }
}

/// Samples that refute a model together are named if there are no more.
const MOST_NAMED: usize = 24;

/// So often it is tried to do with fewer.
const MOST_PROOFS: usize = 60;

/// Of `samples`, which refute together with `others`, those that are needed, about (Junker, QuickXplain, 2004).
fn needed(
    refutes: &mut dyn FnMut(&[usize]) -> bool,
    others: &[usize],
    is_new: bool,
    samples: &[usize],
) -> Vec<usize> {
    if is_new && refutes(others) {
        return Vec::new();
    }
    if samples.len() < 2 {
        return samples.to_vec();
    }
    let (early, late) = samples.split_at(samples.len() / 2);
    let with_early = [others, early].concat();
    let late = needed(refutes, &with_early, true, late);
    let with_late = [others, &late].concat();
    let early = needed(refutes, &with_late, !late.is_empty(), early);
    [early, late].concat()
}

/// A model with all its records.
#[derive(Debug)]
pub(crate) struct Problem {
    pub(crate) flow: Flow,
    pub(crate) layout: Layout,
    /// Outputs first, then what signals prove to be zero.
    pub(crate) quantities: Vec<Output>,
    /// Number of outputs among them.
    pub(crate) outputs: usize,
    pub(crate) courses: Vec<Course>,
    /// Bounds of the parameters that are believed before the records.
    pub(crate) prior: Vec<Interval>,
}

impl Problem {
    pub(crate) fn new(model: &Model) -> Problem {
        let outputs = model.outputs.iter().map(|output| output.expr);
        let zeros = model.signals.iter().flat_map(|signal| &signal.proves_zero);
        Problem {
            flow: Flow::new(model),
            layout: model.layout(),
            quantities: outputs
                .chain(zeros.copied())
                .map(|expr| Output::new(model, expr))
                .collect(),
            outputs: model.outputs.len(),
            courses: Vec::new(),
            prior: model.params.iter().map(|param| param.bounds).collect(),
        }
    }

    /// That nothing agrees with the records, by these samples of one of them if they are enough.
    pub(crate) fn refuted(&self, record: usize, samples: Vec<usize>) -> Conclusion {
        let last = samples.last().copied();
        let instants = self
            .courses
            .get(record)
            .map_or(&[][..], |course| &course.instants);
        let instant = last.and_then(|last| instants.get(last)).or(instants.last());
        Conclusion::Inconsistent(Refuted {
            record,
            samples,
            time: instant.map_or_else(Decimal::zero, |instant| instant.time.clone()),
            line: instant.map_or(0, |instant| instant.line),
        })
    }

    /// Looks for few samples of one record that refute the model together, those of `found` first.
    ///
    /// Guarantee: the samples named refute the model without any other, since that was proved once more with them
    /// alone.
    pub(crate) fn confirm(mut self, found: Refuted) -> Conclusion {
        let whole = std::mem::take(&mut self.courses);
        let count = whole
            .get(found.record)
            .map_or(0, |course| course.instants.len());
        let mut left = MOST_PROOFS;
        let mut refutes = |kept: &[usize]| {
            left = left.saturating_sub(1);
            let courses = whole.iter().enumerate();
            let only = courses.map(|(position, course)| {
                let is_kept = |sample| position == found.record && kept.contains(&sample);
                course.with(&is_kept)
            });
            self.courses = only.collect();
            let prior = Region::of_box(&self.believed());
            left > 0 && self.refine(prior, true).is_err()
        };
        let all: Vec<usize> = (0..count).collect();
        let begin = [found.samples, all]
            .into_iter()
            .find(|samples| refutes(samples));
        let mut kept = begin.map_or(Vec::new(), |samples| {
            needed(&mut refutes, &[], false, &samples)
        });
        kept.sort_unstable();
        // What is left when the budget is spent may be too much, and too many are no help.
        if kept.len() > MOST_NAMED || !refutes(&kept) {
            kept.clear();
        }
        self.courses = whole;
        self.refuted(found.record, kept)
    }

    /// Adds a record, whose samples are in order of time and have the lists of the model.
    pub(crate) fn add(&mut self, model: &Model, samples: &[Sample]) {
        let mut signals = Signals::new(model);
        let mut instants = Vec::with_capacity(samples.len());
        for (k, sample) in samples.iter().enumerate() {
            signals.note(sample);
            let outputs = sample.outputs.iter().enumerate();
            let mut told: Vec<(usize, Interval)> = outputs
                .filter_map(|(output, measured)| Some((output, (*measured)?)))
                .collect();
            let mut quantity = self.outputs;
            for (signal, one) in model.signals.iter().enumerate() {
                for _ in &one.proves_zero {
                    if signals.proves(signal, &sample.time) {
                        told.push((quantity, Interval::ZERO));
                    }
                    quantity += 1;
                }
            }
            let resets = signals.resets(&sample.time).into_iter().enumerate();
            let resets = resets.filter_map(|(param, reset)| (reset && k > 0).then_some(param));
            instants.push(Instant {
                time: sample.time.clone(),
                line: sample.line,
                told,
                inputs: sample.inputs.clone(),
                resets: resets.collect(),
            });
        }
        let stretches = samples.windows(2).map(|pair| Stretch {
            inputs: pair[0].inputs.clone(),
            dt: (&pair[1].time - &pair[0].time).to_interval(),
        });
        self.courses.push(Course {
            instants,
            stretches: stretches.collect(),
            start: model.states.iter().map(|state| state.init).collect(),
        });
    }
}
