//! The model language: expressions, modes, parameters, outputs, diagnostics.

pub mod diagnostic;
pub mod graph;
pub mod model;

pub use diagnostic::{Diagnostic, Diagnostics, SourceText};
pub use graph::{Binary, ExprId, Graph, Names, Node, Unary, Var};
pub use model::{
    ErrorBound, Guard, Input, Mode, Model, Output, Param, Relation, Reset, Sample, Signal, State,
};
