//! Wide priors: the observer over a list of boxes narrows them before forms can.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: an estimate has one interval per parameter"
)]

use super::cell::Clash;
use super::pass::Conflict;
use super::problem::Problem;
use crate::observer::Observer;
use crate::options::ObserverOptions;
use crate::signals::Signals;
use crate::verdict::Verdict;
use veribound_interval::Interval;
use veribound_model::{Model, Sample};

/// Samples between two questions whether to go on.
const ASKS: usize = 256;

/// Narrows the parameters of `box_`, all quantities of the problem, by observers over the records.
///
/// Guarantee: no parameters that agree with all records are lost; a clash proves that there are none. Parameters
/// that a signal can reset are left as they are, since an observer tells only their last values.
pub(crate) fn narrow(
    problem: &Problem,
    model: &Model,
    records: &[Vec<Sample>],
    box_: &mut [Interval],
    go_on: &dyn Fn() -> bool,
) -> Result<(), Clash> {
    let first = problem.first_param();
    let signals = Signals::new(model);
    for (record, samples) in records.iter().enumerate() {
        let mut observer = Observer::new(model, ObserverOptions::default());
        let known = box_[first..].to_vec();
        observer.start_from(&[known]);
        let mut params = None;
        for (position, sample) in samples.iter().enumerate() {
            if position % ASKS == 0 && !go_on() {
                break;
            }
            match observer.step(sample) {
                Ok(Verdict::Consistent(estimate)) => params = Some(estimate.params),
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
        for (param, known) in params.into_iter().flatten().enumerate() {
            if !signals.can_reset(param) {
                box_[first + param] = box_[first + param].intersect(known);
            }
        }
    }
    Ok(())
}
