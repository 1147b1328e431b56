//! Right-hand sides that are affine in the states: the solution in closed form, in one step of any length.
//!
//! Let a regime have `x' = A x + g + w(t)` where `A` and `g` depend on the unknowns `δ` and on inputs that are known
//! exactly, and `|w| <= s` at all times is what other inputs do. With `Φ(t) = ∫_0^t exp(A r) dr`
//!
//! `x(t) = x(0) + Φ(t) (A x(0) + g) + ∫_0^t exp(A (t - r)) w(r) dr`,
//!
//! and two solutions of which one starts at `P(δ)`, the other at `P(δ) + e`, differ by `exp(A t) e` besides. This is an
//! identity: there is no remainder in time, no step to be found, and nothing is divided by eigenvalues, which may be
//! zero, double or complex. The last term is at most `(∫_0^t |exp(A r)| dr) s`, since `w` is any measurable function.
//!
//! `chain.rs` encloses `exp(A t)` and `Φ(t)` as polynomials in `δ` with radii: by their series on a short time, then by
//! doubling it. On the way it finds the same for half the time, a quarter and so on, and bounds for all times up to each.
//! `leap.rs` goes through the stretch in as few windows of these lengths as prove that all that is watched keeps
//! its sign, and that bounds during the stretch are not much wider than what is reached; then the form moves to the end at
//! once. Only what inputs of any course add is taken from window to window where that is narrower: as part of the frame
//! (`frame.rs`) it is turned by the windows that follow. Where a sign may change it moves to a time shortly before, and a crossing with its own time for each solution
//! (`crossing.rs`) follows: stops, break-away and kinks are met as exactly as by any other step.
//!
//! The cost is that of some products of matrices, once for every regime, length and value of the inputs in `A`, and of
//! products with a vector for each window. What rounding takes is about doubled from level to level, and multiplied by how
//! far the eigenvectors are from independent: harmless where this is small or levels are few.
//!
//! Source: scaling and squaring, Moler and Van Loan 2003; for interval matrices Goldsztejn and Neumaier 2014.

mod chain;
mod leap;
mod linear;
mod value;

pub(super) use chain::balanced;
pub(super) use leap::Chains;
pub(super) use linear::{Linear, slopes_of};
