//! Wide priors: the observer over a list of boxes narrows them before forms can.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: an estimate has one interval per parameter"
)]

use std::ops::Range;

use super::cell::Clash;
use super::pass::Conflict;
use super::problem::Problem;
use crate::observer::Observer;
use crate::options::ObserverOptions;
use crate::verdict::Verdict;
use veribound_interval::Interval;
use veribound_model::{Model, Sample};

/// Samples between two questions whether to go on.
const ASKS: usize = 256;

/// Narrows the user's parameters in `box_`, which is of all that the problem tells, by observers over the records, and tells
/// for every record the states at its samples, as far as the observer came.
///
/// Guarantee: no parameters that agree with all records are lost, nor values after resets, nor states; a clash proves that
/// there are none.
pub(crate) fn narrow(
    problem: &Problem,
    model: &Model,
    records: &[Vec<Sample>],
    box_: &mut [Interval],
    go_on: &dyn Fn() -> bool,
) -> Result<Vec<Vec<Vec<Interval>>>, Clash> {
    let mut seen = vec![Vec::new(); records.len()];
    for (record, samples) in records.iter().enumerate() {
        let mut observer = Observer::new(model, ObserverOptions::default());
        let params = problem.told_params();
        let known = params.iter().map(|at| box_[*at]).collect();
        observer.start_from(&[known]);
        let course = &problem.courses[record];
        // Positions of the parameter and of the quantity, and the samples at which it has this value.
        let first = params.into_iter().enumerate();
        let first = first.map(|(param, quantity)| (param, quantity, 0..course.first_reset(param)));
        let later = problem.after_resets(record);
        let later = later.map(|(later, quantity)| (later.param, quantity, later.from..later.until));
        let values: Vec<(usize, usize, Range<usize>)> = first.chain(later).collect();
        for (position, sample) in samples.iter().enumerate() {
            if position % ASKS == 0 && !go_on() {
                break;
            }
            match observer.step(sample) {
                Ok(Verdict::Consistent(estimate)) => {
                    let own = values.iter().filter(|own| own.2.contains(&position));
                    for (param, quantity, _) in own {
                        box_[*quantity] = box_[*quantity].intersect(estimate.params[*param]);
                    }
                    seen[record].push(estimate.states);
                }
                Ok(Verdict::Inconsistent(_)) => {
                    let samples = (0..=position).map(|sample| (sample, record)).collect();
                    return Err(Clash {
                        record,
                        conflict: Conflict::Rows { samples },
                        passes: 0,
                    });
                }
                // What was proved until then stays.
                Ok(Verdict::Undecided(_)) | Err(_) => break,
            }
        }
    }
    Ok(seen)
}
