//! Settings of the observer.

use veribound_flow::StepOptions;
use veribound_flow::engine::Engine;

/// How the parameter to split is chosen where no guard is ambiguous (talk, step 2). The slide
/// compares the terms of a velocity, `[α][x2]` and `[β]([u] - [T])`; its relation is not legible,
/// so both probable readings can be chosen.
///
/// ```
/// use veribound_estimate::{ObserverOptions, ParameterRule};
///
/// let talk = ObserverOptions { parameter_rule: ParameterRule::WidestTerm, ..Default::default() };
/// assert_ne!(talk, ObserverOptions::default());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ParameterRule {
    /// Split the parameter of the term that is widest: `β` if `[β]([u] - [T])` is wider, else `α`.
    WidestTerm,
    /// Split the parameter of the last term if it overlaps another one, else of the first term:
    /// `β` if `[α][x2] ∩ [β]([u] - [T])` is not empty, else `α`.
    OverlappingTerms,
    /// Split the parameter, guarded ones included, whose own width contributes most to the width
    /// of a velocity: largest `|∂f/∂p|` times width. Not from the slides.
    WidestInfluence,
}

/// How the observer keeps what samples say.
///
/// ```
/// use veribound_estimate::{Method, ObserverOptions};
///
/// assert_eq!(ObserverOptions::default().method, Method::Boxes);
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Method {
    /// A list of boxes alone.
    #[default]
    Boxes,
    /// Boxes, and beside them what all samples say together: strips in a bounded number of rows, over a form that is moved
    /// through earlier samples again when much less of the parameters is left, with a fixed budget of work for every
    /// sample.
    Polytope,
}

/// Settings of the observer over a list of boxes. None of them changes what is proved; they change
/// how tight the bounds are and what they cost.
///
/// ```
/// use veribound_estimate::{ObserverOptions, ParameterRule};
///
/// let quick = ObserverOptions { boxes: 8, bisections: 4, ..ObserverOptions::default() };
/// assert_eq!(quick.parameter_rule, ParameterRule::WidestInfluence);
/// assert_eq!(quick.windows, [4, 16, 64]);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ObserverOptions {
    /// Number of boxes `L` that merging reduces the list to.
    pub boxes: usize,
    /// Number of bisections `M` in a row.
    pub bisections: usize,
    /// Samples between two rounds of bisection and merging.
    pub every: usize,
    /// How far beyond the deciding value of a parameter an ambiguous guard is split, as a share of
    /// the parameter's prior width (the ±ε rule).
    pub epsilon: f64,
    /// A switching state is split when its width, times this many sampling times, reaches the
    /// width of the measured states: the slide's `diam[x2] >= diam[x1]` with both sides in the
    /// same unit. Larger values split velocities more and parameters less.
    pub velocity_horizon: f64,
    /// Split a switching state into three, around its level, while several modes are possible.
    pub trisect: bool,
    /// How the parameter to split is chosen.
    pub parameter_rule: ParameterRule,
    /// Lengths, in samples, of the stretches of the past that bound a rate by how far its integral
    /// moved (an unmeasured velocity by the measured angle); none switches this off.
    pub windows: Vec<u64>,
    /// Let merging join boxes with different active modes.
    pub merge_across_modes: bool,
    /// Settings of the integration step.
    pub step: StepOptions,
    /// What moves boxes besides their own step: forms, by closed forms or not, keep from sample to sample how they
    /// depend on parameters; comparison bounds are asked for every sample. [`Engine::Auto`] leaves it at boxes.
    pub engine: Engine,
    /// How what samples say is kept.
    pub method: Method,
    /// [`Method::Polytope`]: number of rows that are kept when there are twice so many.
    pub rows: usize,
    /// [`Method::Polytope`]: how many samples each of two forms may meet when one comes in.
    pub replay: usize,
    /// [`Method::Polytope`]: number of samples that may be met again; the oldest are forgotten.
    pub history: usize,
    /// [`Method::Polytope`]: work that a sample may take, in products of coefficients; a million of them are about a millisecond.
    /// What takes longer is put aside, and goes on with the next sample.
    pub budget: usize,
}

impl Default for ObserverOptions {
    fn default() -> Self {
        ObserverOptions {
            boxes: 50,
            bisections: 25,
            every: 10,
            epsilon: 1e-3,
            velocity_horizon: 3.0,
            trisect: false,
            parameter_rule: ParameterRule::WidestInfluence,
            windows: vec![4, 16, 64],
            merge_across_modes: false,
            step: StepOptions::default(),
            engine: Engine::Auto,
            method: Method::Boxes,
            rows: 128,
            replay: 8,
            history: 20_000,
            budget: 750_000,
        }
    }
}
