//! Identification: the parameters that whole records leave, proved from both sides.

mod answer;
mod cell;
mod eigen;
mod gross;
mod pass;
mod problem;
mod region;
mod rows;
mod search;
mod simplex;

pub use answer::{
    Bounds, Conclusion, Identified, IdentifyOptions, Limit, Progress, Reason, Refuted, Status, Tile,
};

use problem::Problem;
use region::Region;
use search::Search;
use veribound_model::{Model, Sample};

/// Bounds the parameters of `model` that agree with all `records`, each with start states of its own.
///
/// Guarantee: that of [`Identified`], also where `go_on`, which is asked now and then, ends it early.
pub fn identify(
    model: &Model,
    records: &[Vec<Sample>],
    options: &IdentifyOptions,
    go_on: &(dyn Fn(&Progress) -> bool + Sync),
) -> Identified {
    let mut problem = Problem::new(model);
    for samples in records {
        problem.add(model, samples);
    }
    let mut search = Search::new(&problem, options);
    let mut believed = problem.believed();
    if search.is_within_reach(&believed) {
        search.run(Region::of_box(&believed), go_on);
        return search.answer();
    }
    let alive = || go_on(&search.progress());
    match gross::narrow(&problem, model, records, &mut believed, &alive) {
        Ok(()) => search.run(Region::of_box(&believed), go_on),
        Err(clash) => search.refute(clash),
    }
    search.answer()
}
