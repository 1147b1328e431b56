//! Eight intervals side by side.
//!
//! [`Interval8`] has the operations of [`crate::Interval`], lane by lane, and *exactly* its results:
//! every basic operation is tight, elementary functions round to nearest before they step outward, and
//! whatever a lane cannot prove is left to the scalar operation. So the bits of a result depend
//! neither on the machine nor on the neighbours of a lane.
//!
//! An operation on an [`Interval8`] runs on the widest instruction set the processor has (a
//! [`Path`]), chosen once at run time. Whole loops over many operations are written once, as a
//! [`Kernel`] over an [`Arithmetic`], and [`Value::run`] compiles and chooses them per path.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: every array has LANES elements, and lanes are counted below LANES; places in tables are cut to the length of the table"
)]

/// Functions of their own for a path, instead of a copy in every kernel that calls them.
#[cfg(target_arch = "x86_64")]
macro_rules! outlined {
    (
        #[$features:meta]
        $($name:ident($($argument:ident: $of:ty),+) = $body:expr;)+
    ) => {
        $(#[inline(always)]
        fn $name($($argument: $of),+) -> Interval8 {
            #[$features]
            #[inline(never)]
            fn outlined($($argument: $of),+) -> Interval8 {
                $body
            }
            // SAFETY: only a kernel that was started after the processor was found to have the
            // instructions comes here.
            unsafe { outlined($($argument),+) }
        })+
    };
}

mod arithmetic;
#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod basic;
#[cfg(target_arch = "x86_64")]
mod elementary;
mod engine;
mod interval8;
mod mask;
mod path;
mod portable;
#[cfg(target_arch = "x86_64")]
mod power;
mod scalar;
mod vector;

pub use arithmetic::{Arithmetic, Kernel, MaskOf, Value};
pub use interval8::Interval8;
pub use mask::{Lanewise, Mask};
pub use path::Path;

/// Number of intervals in an [`Interval8`].
pub const LANES: usize = 8;

/// One float per lane.
pub type Floats = [f64; LANES];
