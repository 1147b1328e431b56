//! Results out: the files of one run.

pub(crate) mod described;
pub(crate) mod enclosed;
pub(crate) mod folder;
pub(crate) mod identified;
pub(crate) mod number;
mod parquet;
pub(crate) mod printed;
pub(crate) mod run_info;
pub(crate) mod start;
pub(crate) mod summary;
pub(crate) mod table;
