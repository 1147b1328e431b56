//! Settings of the observer.

use veribound_flow::StepOptions;

/// How the parameter to split is chosen where no guard is ambiguous (talk, step 2). The slide
/// compares the terms of a velocity, `[α][x2]` and `[β]([u] - [T])`; its relation is not legible,
/// so both probable readings can be chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ParameterRule {
    /// Split the parameter of the term that is widest: `β` if `[β]([u] - [T])` is wider, else `α`.
    WidestTerm,
    /// Split the parameter of the last term if it overlaps another one, else of the first term:
    /// `β` if `[α][x2] ∩ [β]([u] - [T])` is not empty, else `α`.
    OverlappingTerms,
}

/// Settings of the observer over a list of boxes. None of them changes what is proved; they change
/// how tight the bounds are and what they cost.
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
    /// A switching state is split when its width is at least this many times the width of the
    /// measured states, each in units of its scale; see [`ObserverOptions::state_horizon`].
    pub velocity_ratio: f64,
    /// Seconds over which a width of a switching state is taken to act on the measured states.
    pub state_horizon: f64,
    /// Split a switching state into three, around its level, while several modes are possible.
    pub trisect: bool,
    /// How the parameter to split is chosen.
    pub parameter_rule: ParameterRule,
    /// Let merging join boxes with different active modes.
    pub merge_across_modes: bool,
    /// Settings of the integration step.
    pub step: StepOptions,
}

impl Default for ObserverOptions {
    fn default() -> Self {
        ObserverOptions {
            boxes: 50,
            bisections: 25,
            every: 10,
            epsilon: 1e-3,
            velocity_ratio: 1.0,
            state_horizon: 1.0,
            trisect: false,
            parameter_rule: ParameterRule::WidestTerm,
            merge_across_modes: false,
            step: StepOptions::default(),
        }
    }
}
