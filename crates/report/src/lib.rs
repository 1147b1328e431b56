//! Figures of a run, as SVG and PNG, and its page: outputs with an enlarged stretch, parameters, states, modes
//! and work over time.
//!
//! A [`Tube`] does the same for an enclosure without a record: bounds at all times, and the phase plane. An
//! [`Identification`] shows what whole records leave of the parameters: bounds from both sides, and pavings.
//!
//! A [`Page`] shows a run as one file of HTML with [`Plots`] that can be zoomed, made of the same memory.
//!
//! A [`History`] is fed sample by sample and stays small however long the record is; it draws all
//! [`Figure`]s, and [`png`] turns any of them into pixels. No band is ever drawn narrower than the
//! bounds given for it: samples that share a column of the picture are joined into the hull of
//! their bounds, and coordinates are rounded outward.
//!
//! ```
//! use veribound_report::{FigureMeta, History, Quantity, SampleRow, png};
//!
//! let mut history = History::new(FigureMeta {
//!     outputs: vec![Quantity::new("phi_m", "rad")],
//!     ..FigureMeta::default()
//! });
//! for k in 0..100 {
//!     let (t, mid) = (f64::from(k) * 0.01, f64::from(k * k) * 1e-4);
//!     history.push(&SampleRow {
//!         t,
//!         outputs: &[(mid - 0.02, mid + 0.03)],
//!         measured: &[Some((mid - 0.1, mid + 0.1))],
//!         boxes: 1,
//!         milliseconds: 0.2,
//!         ..SampleRow::default()
//!     })?;
//! }
//! let figures = history.render_all();
//! assert_eq!(figures.iter().map(|f| &f.name).collect::<Vec<_>>(), ["outputs", "work"]);
//! assert!(png(&figures[0].svg)?.starts_with(b"\x89PNG"));
//! # Ok::<(), veribound_report::ReportError>(())
//! ```

mod axis;
mod error;
mod figure;
mod history;
mod identification;
mod legend;
mod meta;
mod outline;
mod page;
mod panel;
mod place;
mod png;
mod ribbon;
mod svg;
mod theme;
mod track;
mod tube;
mod zoom;

pub use error::ReportError;
pub use figure::Figure;
pub use history::{History, SampleRow};
pub use identification::{Course, Identification, PavingTile, ProvedParameter, TileStatus};
pub use meta::{FigureMeta, Parameter, Quantity, Zoom};
pub use page::{Block, Entry, Page, Plots, Section, Table, Tone, Value};
pub use png::png;
pub use tube::{Tube, TubeRow};
