//! Identification: the parameters that whole records leave, proved from both sides.

mod answer;
mod pass;
mod problem;
mod rows;
mod simplex;

pub use answer::{
    Bounds, Conclusion, Identified, IdentifyOptions, Limit, Progress, Reason, Refuted, Status, Tile,
};

use veribound_model::{Model, Sample};

/// Bounds the parameters of `model` that agree with all `records`, each with start states of its own.
///
/// Guarantee: that of [`Identified`]; `go_on` is asked now and then whether to go on.
pub fn identify(
    _model: &Model,
    _records: &[Vec<Sample>],
    _options: &IdentifyOptions,
    _go_on: &dyn Fn(&Progress) -> bool,
) -> Identified {
    Identified {
        conclusion: Conclusion::Undecided,
        params: Vec::new(),
        starts: Vec::new(),
        points: Vec::new(),
        tiles: Vec::new(),
        sets: 0,
        passes: 0,
        interrupted: false,
        limits: Vec::new(),
    }
}
