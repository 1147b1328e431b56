//! Records in, results out.
//!
//! - [`Record`]: a CSV file, checked as a whole, then read one [`Sample`](veribound_model::Sample) at
//!   a time; every number means the decimal it spells.
//! - [`ResultFolder`]: where the files of a run go; a file is there whole or not at all.
//! - [`TableWriter`]: `states.csv`, `params.csv`, `boxes.csv`; [`Summary`]: `summary.json`;
//!   [`RunInfo`]: `run.toml`.
//! - [`Start`]: the parameters of an earlier run, to go on from.
//!
//! *Guarantee*: intervals are printed rounded outward, so that what is printed contains what was
//! proved.

mod digest;
mod failure;
mod outward;
mod record;
mod results;

pub use digest::{sha256_of_file, sha256_of_text};
pub use outward::spelled;
pub use record::{Record, RecordOptions, Samples};
pub use results::folder::{ResultFile, ResultFolder};
pub use results::run_info::{FileInfo, Platform, Program, RecordInfo, RunInfo};
pub use results::start::Start;
pub use results::summary::{ParameterSummary, Refutation, StateSummary, Summary, Verdict, Work};
pub use results::table::{Cell, Column, TableWriter};
