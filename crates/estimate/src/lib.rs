//! Set-valued estimation: the observer over a list of boxes, with its verdicts, and identification over whole records ([`identify`]).
//!
//! All numbers are in the units that the model gives to its quantities, times in seconds.

mod batch;
mod cell;
mod engine;
mod history;
pub mod identify;
mod measure;
mod merge;
mod observer;
mod options;
mod polytope;
mod signals;
mod split;
mod verdict;

pub use cell::Cell;
pub use observer::{Misuse, Observer};
pub use options::{Method, ObserverOptions, ParameterRule};
pub use verdict::{Contradiction, Estimate, Refutation, Undecided, Verdict};
