//! Validated integration of one step across mode switches.
//!
//! A model is compiled once into a [`System`]; [`System::step`] then moves boxes of states over
//! stretches of time such that no Filippov solution is lost.

mod advance;
mod apriori;
mod face;
mod guard;
mod levels;
mod modes;
mod side;
mod step;
mod system;

pub use apriori::AprioriFailure;
pub use modes::ModeSet;
pub use step::{StepFailure, StepOptions, StepReport, Workspace};
pub use system::{Integral, System};
