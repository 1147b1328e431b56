//! Forms: sets of solutions that keep how they depend on start values and parameters.
//!
//! A [`Form`] says of every solution at one time: `x ∈ P(δ) + E`, with a polynomial `P` in the unknowns
//! `δ` (start values and parameters, scaled to `[-1, 1]`, the same for all times), and a small set
//! `E = { Q r }` for what dependence could not keep. [`Flow::advance`] moves it.
//!
//! # One step
//!
//! 1. `series.rs` computes, in plain floating point, a polynomial `X(δ, t)` in the unknowns and time with
//!    `X(δ, 0) = P(δ)` that is nearly a solution for every `δ`. No claim is made about it.
//! 2. `error.rs` bounds the *defect* `d` of this polynomial, as the floats say it, `|f(X, p, u) - X'| <= d`
//!    for all `δ`, all `t` of the step and all values of the inputs, and the entries of `∂f/∂x` for all
//!    states that differ from `X` by at most a trial bound `D`. The polynomials of all intermediate
//!    results are at hand; only what rounding and truncation lose has to be bounded, by sums of absolute
//!    coefficients. Higher orders in time need no enclosure of their own.
//! 3. *Theorem (deviation).* Let `C >= |∂f/∂x|` off the diagonal and `C_ii >= max(0, ∂f_i/∂x_i)`, for all
//!    states within `D` of `X`. If `exp(C h) |e| + ∫_0^h exp(C (h - t)) d dt < D` for all `e ∈ E`, in every
//!    component, then every solution that starts in `P(δ) + E` exists up to time `h` and stays within
//!    `D` of `X`.
//!
//!    *Proof.* As long as a solution `x` stays within `D`, its deviation `e = x - X` satisfies
//!    `e' = A e + g` almost everywhere with `|g| <= d` and `A` an average of `∂f/∂x` on the segment from
//!    `X` to `x` (mean value theorem; at kinks its set-valued form, for which the generalised derivative
//!    is enclosed). So `|e|' <= C |e| + d`, and since `C >= 0` the bound is that of the linear comparison
//!    equation, which grows with `h` and is smaller than `D`: `e` can never reach `D`, so the solution
//!    remains in a compact set on which `f` is continuous, and goes on. Inputs may be any measurable
//!    functions, since nothing was asked of `g` but its bound.
//! 4. *Theorem (transport).* Let `V(t)` be any matrix polynomial with `V(0) = I` and
//!    `G >= |A V - V'|` for all such `A` and all times. Then
//!    `|e(h) - V(h) e(0)| <= ∫_0^h exp(C (h - t)) (G |e(0)| + d) dt`.
//!
//!    *Proof.* `w = e - V e(0)` satisfies `w(0) = 0` and `w' = A w + (A V - V') e(0) + g`.
//!
//!    `V` is the Taylor polynomial of the variational equation along `δ = 0`. So the small set is moved by
//!    one point matrix and widened by a box: `E` goes to `V Q r + w`, enclosed by a new orthogonal frame
//!    (`frame.rs`). Dependence on start values and parameters is kept in `P(δ) = X(δ, h)` as far as its degree
//!    reaches; terms of higher degree are in `d`.
//!
//! Over wide sets the matrix differs from one `δ` to the next. Therefore what is in `E` becomes *fresh
//! unknowns* of `P` when it has grown to a share of those before (`absorb.rs`); products with the others
//! then tell each `δ` its own matrix. [`Flow::enclose`] raises the degree, and divides the set at last, until
//! the result is nearly a function of the unknowns.
//!
//! A step that finds no `D` is shortened; a form never changes unless the step is proved.
//!
//! # Switches
//!
//! All this is about one smooth right-hand side. Which one acts, and why no other does, is proved from the
//! signs of the expressions in guards (`regime.rs`); they are watched along every step (`watching.rs`). Where
//! one may change, all solutions cross its zero together, each at a time of its own that is a polynomial in
//! the unknowns (`crossing.rs`): into another mode, into one that holds the surface (stick), out of it, over a kink, or
//! through a jump of the state; in as many stretches as that takes, each with its own inputs (`sampled.rs`).
//! Those that rest and leave at samples of their own are one form again once all have left (`breakaway.rs`). So states stay functions of the unknowns. Where what comes next depends on the solution, as
//! where some stick and others turn, the set is divided along what decides (`open.rs`, `parting.rs`), and those that
//! hesitate stay within bounds of their own (`creeping.rs`). Where a crossing cannot be proved, because some
//! solutions graze or stay behind, boxes go on for a moment (`mixed.rs`).
//!
//! Where a regime is affine in the states its solution has a closed form: one step of any length instead of many
//! (`closed/`, [`FormOptions::closed`]).
//!
//! Sources: Taylor models, Makino and Berz 1996; Lohner's frames, Lohner 1988; the comparison of defects is
//! Müller's theorem for linear systems. Bounding the defect of a point polynomial instead of enclosing
//! every Taylor coefficient is own.

mod absorb;
mod ahead;
mod allowance;
mod breakaway;
mod closed;
mod code;
mod compare;
mod compose;
mod convolve;
mod creeping;
mod crossing;
#[cfg(test)]
mod draw;
mod error;
mod flow;
mod frame;
mod function;
mod journey;
mod merging;
mod mixed;
mod monomials;
mod open;
mod output;
mod outward;
mod parting;
mod passing;
mod piece;
mod proved;
mod range;
mod regime;
mod resting;
mod run;
mod sampled;
mod series;
mod set;
mod several;
mod size;
mod step;
pub(crate) mod surfaces;
mod transport;
mod watching;

pub(crate) use allowance::Spent;
pub use allowance::{Allowance, poll};
pub use flow::{BoxAfter, Diverged, Flow};
pub use journey::{Arriving, Meeting};
pub use output::{Contradiction, Output, Strip};
pub use run::{Effort, Enclosure, Part, Standing, Stretch};
pub use set::{Form, FormOptions, OutputForm, Parallelotope, Unknown};
pub use step::Obstacle;
