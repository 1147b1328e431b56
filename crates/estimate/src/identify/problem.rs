//! A model and a record, compiled for identification.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one stretch between two samples, lists as long as those of the model"
)]

use crate::signals::Signals;
use veribound_flow::form::{Flow, Output, Stretch};
use veribound_interval::{Decimal, Interval};
use veribound_model::{Layout, Model, Sample};

/// What a sample tells.
#[derive(Debug)]
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
#[derive(Debug)]
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
