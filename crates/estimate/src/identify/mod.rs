//! Identification: the parameters that whole records leave, proved from both sides.

mod answer;
mod cell;
mod eigen;
mod gross;
mod pass;
mod pave;
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

/// Bounds the parameters of `model` that agree with all `records`, each with start states of its own and samples in
/// order of time.
///
/// Guarantee: that of [`Identified`], also where `go_on`, which is asked now and then, ends it early.
pub fn identify(
    model: &Model,
    records: &[Vec<Sample>],
    options: &IdentifyOptions,
    go_on: &(dyn Fn(&Progress) -> bool + Sync),
) -> Identified {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(options.threads.max(1))
        .build();
    let work = || on_these_threads(model, records, options, go_on);
    match pool {
        Ok(pool) => pool.install(work),
        // The system gives no threads: the one at hand does it.
        Err(_) => work(),
    }
}

fn on_these_threads(
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
    if search.reaches(&believed) {
        search.run(None, go_on);
    } else {
        let alive = || go_on(&search.progress());
        match gross::narrow(&problem, model, records, &mut believed, &alive) {
            Ok(()) => search.run(Some(Region::of_box(&believed)), go_on),
            Err(clash) => search.refute(clash),
        }
    }
    let tiles = match options.undecided {
        Some(share) => search.pave(share, go_on),
        None => Vec::new(),
    };
    let mut found = search.answer(tiles);
    if let Conclusion::Inconsistent(refuted) = found.conclusion {
        found.conclusion = problem.confirm(refuted);
    }
    found
}
