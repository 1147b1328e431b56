//! The model language: expressions, modes, parameters, outputs, diagnostics.

pub mod build;
mod coverage;
mod describe;
pub mod diagnostic;
pub mod facts;
mod file;
pub mod graph;
mod held;
pub mod model;
mod ratios;
mod regular;
mod rewrite;
pub mod series;
mod syntax;
pub mod tape;
pub mod units;

pub use coverage::{Doubt, Overlap, Overlaps};
pub use diagnostic::{Diagnostic, Diagnostics, SourceText};
pub use facts::{Facts, ModeFacts};
pub use file::MOST_MODES;
pub use graph::{Binary, Choice, ExprId, Graph, Level, Names, Node, Unary, Var};
pub use model::{
    Coverage, ErrorBound, Guard, Hold, Input, Jump, Mode, ModeGroup, Model, Outliers, Output,
    Param, Relation, Reset, Sample, Signal, State, Term,
};
pub use ratios::Ratio;
pub use regular::Regular;
pub use series::{Coefficients, SeriesTape};
pub use tape::{Layout, Tape};
pub use units::Unit;
