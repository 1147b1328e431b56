//! The model language: expressions, modes, parameters, outputs, diagnostics.

pub mod diagnostic;
pub mod graph;
pub mod model;
pub mod series;
pub mod tape;

pub use diagnostic::{Diagnostic, Diagnostics, SourceText};
pub use graph::{Binary, ExprId, Graph, Names, Node, Unary, Var};
pub use model::{
    Coverage, ErrorBound, Guard, Input, Mode, Model, Output, Param, Relation, Reset, Sample, Signal, State,
};
pub use series::{Coefficients, SeriesTape};
pub use tape::{Layout, Regularity, Tape};
