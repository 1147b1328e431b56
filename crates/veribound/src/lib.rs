//! Proved parameter and state bounds for dynamic systems with switches.
//!
//! A model file says what is known: equations, bounds of the unknown parameters, how far a
//! measurement can be off. A record says what was measured. The [`Observer`] goes through the record
//! sample by sample and keeps a set of boxes that is *proved* to contain the true states and
//! parameters, if what the model file says is true: no sampling, no linearisation, every rounding
//! error bounded. When nothing is left, model and record contradict each other, and that is proved
//! too.
//!
//! # A first run
//!
//! ```
//! use veribound::{Model, Observer, ObserverOptions, Record, RecordOptions, Verdict};
//!
//! // A mass on a rough table: F moves it, friction stops it. Its mass lies between 0.5 and 5 kg;
//! // the position is measured within 1 mm.
//! let model = Model::from_text(
//!     "sled.toml",
//!     r#"
//!     format = 1
//!     states = ["x [m]", "v [m/s]"]
//!     init   = { x = [-0.01, 0.01], v = 0 }
//!     inputs = ["F [N]"]
//!     [params]
//!     m  = { unit = "kg", bounds = [0.5, 5] }
//!     Fc = { unit = "N",  bounds = [0, 3] }
//!     [der]
//!     x = "v"
//!     v = "(F - friction(v, F, Fc)) / m"
//!     [outputs]
//!     pos = "x +- 0.001"
//!     "#,
//! )?;
//!
//! // The record of a true mass of 2 kg and a friction of 1 N: at rest, then pushed with 5 N.
//! let folder = std::env::temp_dir().join(format!("veribound-doc-{}", std::process::id()));
//! std::fs::create_dir_all(&folder)?;
//! let path = folder.join("push.csv");
//! let mut text = String::from("t,F,pos\n");
//! for k in 0..=200_u32 {
//!     let (t, push) = (f64::from(k) / 100.0, if k < 50 { 0.5 } else { 5.0 });
//!     let moving = (t - 0.5).max(0.0);
//!     text += &format!("{t},{push},{:.4}\n", 0.5 * (5.0 - 1.0) / 2.0 * moving * moving);
//! }
//! std::fs::write(&path, text)?;
//! let record = Record::open(&path, &model, RecordOptions::default())?;
//!
//! // One step per sample. Verdicts are values; errors are misuse.
//! let mut observer = Observer::new(&model, ObserverOptions { every: 1, ..Default::default() });
//! let mut mass = model.params[0].bounds;
//! for sample in record.samples()? {
//!     match observer.step(&sample?)? {
//!         Verdict::Consistent(estimate) => mass = estimate.params[0],
//!         Verdict::Inconsistent(proof) => panic!("refuted at t = {} s", proof.time),
//!         Verdict::Undecided(why) => panic!("stopped at t = {} s: {:?}", why.time, why.reason),
//!     }
//! }
//! assert!(mass.contains(2.0));
//! assert!(mass.width() < 0.5 * model.params[0].bounds.width());
//! println!("the mass lies in {mass} kg"); // printed bounds are rounded outward
//! # std::fs::remove_dir_all(&folder)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Where things are
//!
//! - [`Model`]: the immutable mathematics, read with [`Model::from_file`] or built in Rust code with
//!   [`build::ModelBuilder`]; [`Model::describe`] says what was understood. Problems come as [`Diagnostics`]: place, text, caret, one thing to do.
//! - [`Record`]: a CSV file, checked as a whole, then read sample by sample.
//! - [`Observer`], [`ObserverOptions`], [`Verdict`]: the estimation.
//! - [`identify`]: bounds from both sides, from whole records ([`Record::all_samples`]).
//! - [`Simulation`]: proved simulation with known parameters.
//! - [`System`], [`Workspace`]: single steps of boxes, for estimators of your own.
//! - [`ResultFolder`], [`TableWriter`], [`Summary`]: result files; [`History`], [`png`]: figures.
//!
//! The program `veribound` is made of these parts.

#[doc(hidden)]
pub mod program;
mod simulation;

pub use simulation::{Simulation, Stopped};
pub use veribound_data::{
    Cell as TableCell, Column, IdentifiedSummary, Record, RecordOptions, ResultFolder, RunInfo,
    Samples, Start, Summary, TableSource, TableWriter,
};
pub use veribound_estimate::{
    Cell, Contradiction, Estimate, Misuse, Observer, ObserverOptions, ParameterRule, Refutation,
    Undecided, Verdict, identify,
};
pub use veribound_flow::{ModeSet, StepFailure, StepOptions, StepReport, System, Workspace};
pub use veribound_interval::{Decimal, Interval, SelfTestError, self_test};
pub use veribound_model::{
    Coverage, Diagnostic, Diagnostics, ErrorBound, Guard, Input, Mode, Model, Output, Param, Reset,
    Sample, Signal, SourceText, State, build,
};
pub use veribound_report::{
    Figure, FigureMeta, History, Identification, PavingTile, ProvedParameter, SampleRow,
    TileStatus, png,
};
