//! Records in, results out.
//!
//! - [`Record`]: a CSV, MATLAB MAT, HDF5 or Parquet file, checked as a whole, then read one
//!   [`Sample`](veribound_model::Sample) at a time; every number means the decimal it spells, or the float it is.
//! - [`TableReader`]: any table of text, row by row, by the same rules; [`TableSource`]: where a table
//!   comes from.
//! - [`ResultFolder`]: where the files of a run go; the results are those of one run, all or none.
//! - [`TableWriter`]: `states.csv`, `params.csv`, `boxes.csv`; `tube.csv`, `parts.csv` of an enclosure;
//!   `points.csv`, `paving.csv` of an identification.
//! - [`Summary`], [`EnclosureSummary`], [`IdentifiedSummary`]: `summary.json`; [`RunInfo`]: `run.toml`;
//!   [`Printed`]: the numbers of a summary as they are printed, for what tells the same elsewhere.
//! - [`Start`]: the parameters of an earlier run, to go on from.
//!
//! *Guarantee*: intervals that hold all values are printed rounded outward, so that what is printed
//! contains what was proved; those that are proved to be reached are printed rounded inward.

mod digest;
mod failure;
mod inward;
mod outward;
mod reader;
mod record;
mod results;

pub use digest::{sha256_of_bytes, sha256_of_file};
pub use reader::source::TableSource;
pub use reader::table::{TableReader, TableRow};
pub use record::{Record, RecordOptions, Samples};
pub use results::described::ModelSummary;
pub use results::enclosed::{
    EnclosureSummary, EnclosureWork, PastUse, RangeSummary, Reach, Trajectories,
};
pub use results::folder::{CompleteFile, ResultFile, ResultFolder};
pub use results::identified::{
    IdentifiedParameter, IdentifiedReset, IdentifiedStart, IdentifiedState, IdentifiedSummary,
    IdentifiedWork, LeastErrors, Paving, RefutedTogether,
};
pub use results::number::Time;
pub use results::printed::Printed;
pub use results::run_info::{FileInfo, Platform, Program, RecordInfo, RunInfo};
pub use results::start::Start;
pub use results::summary::{
    Kind, ParameterSummary, Refutation, StateSummary, Summary, Verdict, Work, to_json,
};
pub use results::table::{Cell, Column, TableWriter};
