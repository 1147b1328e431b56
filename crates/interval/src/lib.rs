//! Sound interval arithmetic: directed rounding, elementary functions, exact decimal text.
//!
//! - [`Interval`]: a closed set of real numbers, with the operations of the set-based IEEE 1788 model,
//!   reverse operations for contractors and three-valued comparisons ([`Truth`]).
//! - [`Interval8`]: eight of them side by side ([`lanes`]), in the vector instructions of the processor.
//! - [`round`]: tight directed `+ - * / sqrt` on floats, without changing the rounding mode.
//! - [`Decimal`]: exact decimal numbers, [`literal`]: fractions, hexadecimal floats and intervals as text,
//!   [`text`]: decimal output rounded outward.
//! - [`domain`]: whether an operation is defined, continuous and smooth on the whole of its arguments.
//! - [`self_test`]: refuses an arithmetic that the proofs do not cover.
//!
//! *Guarantee*: whatever real numbers lie in the arguments, the value of the operation on them lies in
//! the result. Assumed: round-to-nearest arithmetic with subnormal numbers ([`self_test`] checks
//! it), and errors of CORE-MATH below one unit in the last place.
//!
//! *Guarantee*: [`Interval8`] has in every lane, on every machine, the bits of [`Interval`] (the sign of
//! a zero end aside). Assumed for elementary functions: CORE-MATH returns the nearest float.
//!
//! `CONFORMANCE.md` beside this crate's manifest lists every operation with its tightness, and what is
//! proved and what is trusted.

mod arith;
mod cancel;
mod decimal;
pub mod domain;
mod elementary;
mod fused;
mod interval;
pub mod lanes;
pub mod literal;
mod period;
mod power;
mod relation;
mod reverse;
pub mod round;
#[cfg(feature = "serde")]
mod saved;
mod self_test;
mod step;
pub mod text;
mod truth;

pub use decimal::{Decimal, DecimalError, rational_to_interval};
pub use domain::Regularity;
pub use interval::Interval;
pub use lanes::Interval8;
pub use literal::LiteralError;
pub use relation::Overlap;
pub use self_test::{SelfTestError, self_test};
pub use truth::Truth;
