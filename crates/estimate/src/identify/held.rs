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
        let all: Vec<usize> = (0..model.inputs.len()).collect();
        let mut left: Vec<usize> = vec![MOST; records.len()];
        let (mut firm, mut free) = (Vec::new(), Vec::new());
        for input in all.iter().filter(is_uncertain) {
            let counts = records.iter().map(|samples| {
                let runs = runs(&model.inputs[*input], *input, samples, true);
                let wide = runs
                    .iter()
                    .filter(|run| is_wide(samples[run.start].inputs[*input]));
                wide.count()
            });
            let counts: Vec<usize> = counts.collect();
            let fits = counts.iter().zip(&left).all(|(count, left)| count <= left);
            if model.inputs[*input].hold != Hold::Free && fits {
                left.iter_mut()
                    .zip(counts)
                    .for_each(|(left, count)| *left -= count);
                firm.push(*input);
            } else {
                free.push(*input);
            }
        }
        Held {
            firm: firm.len(),
            inputs: [firm, free].concat(),
        }
    }

    /// Adds the values that inputs have for a while to a record.
    pub(crate) fn add(&self, model: &Model, samples: &[Sample], course: &mut Course) {
        let (mut firm, mut free) = (std::mem::take(&mut course.later), Vec::new());
        for (position, &input) in self.inputs.iter().enumerate() {
            let is_firm = position < self.firm;
            let param = model.params.len() + position;
            let runs = runs(&model.inputs[input], input, samples, is_firm);
            let is_wide = |run: &&Range<usize>| is_wide(samples[run.start].inputs[input]);
            let are_few =
                is_firm || firm.len() + free.len() + runs.iter().filter(is_wide).count() <= MOST;
            for run in &runs {
                let believed = samples[run.start].inputs[input];
                if run.start > 0 {
                    course.instants[run.start].changes.push(param);
                }
                let is_quantity = is_wide(&run) && are_few;
                for instant in &mut course.instants[run.clone()] {
                    instant.held.push(if is_wide(&run) && !is_firm {
                        Interval::point(believed.mid())
                    } else {
                        believed
                    });
                }
                if is_quantity {
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

fn is_wide(x: Interval) -> bool {
    x.rad() > EXACT * x.mag()
}

/// Samples during which an input is constant, or may be taken for constant.
fn runs(input: &Input, at: usize, samples: &[Sample], is_firm: bool) -> Vec<Range<usize>> {
    let count = samples.len();
    let begins: Vec<usize> = match (input.hold, is_firm) {
        (Hold::Sample, true) => (0..count).collect(),
        _ if input.within.is_some() => {
            let parts = PARTS.min(count);
            (0..parts).map(|part| part * count / parts).collect()
        }
        _ => (0..count)
            .filter(|k| *k == 0 || samples[*k].inputs[at] != samples[k - 1].inputs[at])
            .collect(),
    };
    let ends = begins.iter().skip(1).copied().chain([count]);
    begins
        .iter()
        .copied()
        .zip(ends)
        .map(|(from, until)| from..until)
        .collect()
}
