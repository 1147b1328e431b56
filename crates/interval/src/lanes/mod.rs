//! Eight intervals side by side.
//!
//! Lane by lane the results are *exactly* those of [`crate::Interval`]:
//! - `+ - * /`, `sqr`, `sqrt`, `abs`, `min`, `max` and the set operations are tight, so that there is
//!   but one result; `sign` is exact;
//! - elementary functions are rounded to the nearest float before they step outward, here where a
//!   bounded error leaves no doubt about that float, there by CORE-MATH;
//! - powers may have an end one float too far out where they are nearly a float; here only ends are
//!   given that are so clear that the scalar one is tight, too.
//!
//! Whatever a lane cannot prove is left to the scalar operation. So the bits of a result depend
//! neither on the machine nor on the neighbours of a lane, if CORE-MATH always returns the nearest
//! float, as its authors prove (an enclosure needs less: an error below one unit in the last place).
//!
//! [`Interval8`] itself has `+ - * /`, the set operations, questions and numbers such as the width.
//! Everything else is in [`Arithmetic`], for a [`Kernel`]: a loop over many operations that is
//! written once; [`Value::run`] compiles it for every instruction set (a [`Path`]) and runs it on
//! the widest one the processor has. The elementary functions are vector code on AVX2 and AVX-512;
//! on the portable path each lane is done by the scalar function.
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
///
/// Example: [`Mask`].
pub type Floats = [f64; LANES];
