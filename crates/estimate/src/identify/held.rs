//! Inputs that are constant for a while are quantities like parameters after resets, so that what is known of their errors
//! goes on.
//!
//! An input that need not be constant may be so. Points that are proved to agree with one that is are points that
//! agree: for these alone it is taken for one that is constant from one recorded value to the next, a disturbance
//! for one that is constant in each of a few parts of the record.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: samples have one entry per input of the model"
)]

use std::ops::Range;

use super::problem::{Course, Later};
use veribound_interval::Interval;
use veribound_model::{Hold, Input, Model, Sample};

/// Most values of inputs in a record that are quantities: polynomials have products of all of them.
const MOST: usize = 32;

/// Parts of a record in which a disturbance is constant, for points.
const PARTS: usize = 8;

/// What is known better than this, as share of it, is no quantity.
const EXACT: f64 = 1e-9;

/// Inputs as parameters, in their order.
#[derive(Debug, Default)]
pub(crate) struct Held {
    /// Positions of the inputs; those that are constant for a while come first.
    pub(crate) inputs: Vec<usize>,
    /// Number of these.
    pub(crate) firm: usize,
    /// Those that change too often for that. Points are looked for with the middle of what each may be.
    nominal: Vec<usize>,
}

impl Held {
    /// The inputs of a model that are parameters for all these records.
    ///
    /// None where the state can jump: what it is at a sample may be after a jump, which values before decide.
    pub(crate) fn of(model: &Model, records: &[Vec<Sample>]) -> Held {
        if !model.jumps.is_empty() {
            return Held::default();
        }
        let is_uncertain = |input: &&usize| {
            let of = |sample: &Sample| is_wide(sample.inputs[**input]);
            records.iter().flatten().any(of)
        };
        let mut left = vec![MOST; records.len()];
        // Takes a place for each of its values in every record, if there are that many left.
        let mut takes = |input: usize, is_firm: bool| {
            let counts = records.iter().map(|samples| {
                let runs = runs(&model.inputs[input], input, samples, is_firm);
                let wide = runs.iter();
                let wide = wide.filter(|run| is_wide(samples[run.start].inputs[input]));
                wide.count()
            });
            let counts: Vec<usize> = counts.collect();
            let fits = counts.iter().zip(&left).all(|(count, left)| count <= left);
            if fits {
                let each = left.iter_mut().zip(counts);
                each.for_each(|(left, count)| *left -= count);
            }
            fits
        };
        let all: Vec<usize> = (0..model.inputs.len()).collect();
        let uncertain: Vec<usize> = all.iter().filter(is_uncertain).copied().collect();
        let (mut firm, mut others) = (Vec::new(), Vec::new());
        for input in uncertain {
            if model.inputs[input].hold != Hold::Free && takes(input, true) {
                firm.push(input);
            } else {
                others.push(input);
            }
        }
        let (free, nominal) = others.into_iter().partition(|input| takes(*input, false));
        Held {
            firm: firm.len(),
            inputs: [firm, free].concat(),
            nominal,
        }
    }

    /// Whether some input may have any course within what is known of it.
    pub(crate) fn is_free(&self) -> bool {
        self.inputs.len() > self.firm || !self.nominal.is_empty()
    }

    /// What inputs may be for points: of those that are no parameters one value.
    pub(crate) fn for_points(&self, inputs: &[Interval]) -> Vec<Interval> {
        let mut inputs = inputs.to_vec();
        for input in &self.nominal {
            if is_wide(inputs[*input]) {
                inputs[*input] = Interval::point(inputs[*input].mid());
            }
        }
        inputs
    }

    /// Adds the values that inputs have for a while to a record.
    pub(crate) fn add(&self, model: &Model, samples: &[Sample], course: &mut Course) {
        let (mut firm, mut free) = (std::mem::take(&mut course.later), Vec::new());
        for (position, &input) in self.inputs.iter().enumerate() {
            let is_firm = position < self.firm;
            let param = model.params.len() + position;
            let runs = runs(&model.inputs[input], input, samples, is_firm);
            let is_wide = |run: &&Range<usize>| is_wide(samples[run.start].inputs[input]);
            for run in &runs {
                let believed = samples[run.start].inputs[input];
                if run.start > 0 {
                    course.instants[run.start].changes.push(param);
                }
                for instant in &mut course.instants[run.clone()] {
                    instant.held.push(believed);
                }
                if is_wide(&run) {
                    let list = if is_firm { &mut firm } else { &mut free };
                    list.push(Later {
                        param,
                        believed,
                        from: run.start,
                        until: run.end,
                    });
                }
            }
        }
        let order = |later: &Later| (later.from, later.param);
        firm.sort_by_key(order);
        free.sort_by_key(order);
        course.firm = firm.len();
        course.later = [firm, free].concat();
    }
}

/// Whether it is not known but for rounding.
pub(crate) fn is_wide(x: Interval) -> bool {
    x.rad() > EXACT * x.mag()
}

/// Samples during which an input is constant, or may be taken for constant.
fn runs(input: &Input, at: usize, samples: &[Sample], is_firm: bool) -> Vec<Range<usize>> {
    let count = samples.len();
    let begins: Vec<usize> = match (input.hold, is_firm) {
        (Hold::Sample, true) => (0..count).collect(),
        _ => {
            let parts = match input.within {
                Some(_) => PARTS.min(count),
                None => 1,
            };
            let is_part = |k: usize| (0..parts).any(|part| part * count / parts == k);
            let is_new = |k: usize| samples[k].inputs[at] != samples[k - 1].inputs[at];
            (0..count).filter(|k| is_part(*k) || is_new(*k)).collect()
        }
    };
    let ends = begins.iter().skip(1).copied().chain([count]);
    begins
        .iter()
        .copied()
        .zip(ends)
        .map(|(from, until)| from..until)
        .collect()
}
