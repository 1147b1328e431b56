//! Validated integration of one step across mode switches.
//!
//! A model is compiled once into a [`System`]; [`System::step`] then moves boxes of states over
//! stretches of time such that no Filippov solution is lost. [`form`] moves sets that keep how states
//! depend on start values and parameters, across switches too; [`comparison`] bounds monotone systems by two
//! solutions. [`engine`] chooses between all of them. [`balance`] integrates equations against functions of time, without any
//! solution.

mod acting;
mod advance;
mod apriori;
pub mod balance;
pub mod comparison;
pub mod engine;
mod face;
pub mod form;
mod guard;
mod jump;
mod levels;
mod modes;
mod side;
mod step;
mod system;

pub use acting::Acting;
pub use apriori::AprioriFailure;
pub use jump::{AtOnce, reduced};
pub use modes::ModeSet;
pub use step::{Branch, StepFailure, StepOptions, StepReport, Workspace};
pub use system::{Integral, System};
