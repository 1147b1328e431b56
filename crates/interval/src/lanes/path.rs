//! The instruction sets on which eight intervals run, and the choice among them.

use super::portable::Portable;
use super::{Interval8, Kernel, Mask, Value};
use crate::Interval;

/// How operations on [`Interval8`] are carried out. All paths give the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// Error-free transformations in whatever the compilation target has.
    Portable,
}

impl Path {
    /// The paths this processor has, the widest first.
    pub fn available() -> impl Iterator<Item = Path> {
        [Path::Portable].into_iter()
    }

    /// The path that [`Value::run`] takes.
    pub fn chosen() -> Path {
        Path::Portable
    }

    /// Runs a kernel on this path; `None` where the processor does not have it.
    pub fn run<K: Kernel<Interval8>>(self, kernel: K) -> Option<K::Output> {
        match self {
            Path::Portable => Some(kernel.run::<Portable>()),
        }
    }
}

impl Value for Interval8 {
    type Mask = Mask;

    #[inline(always)]
    fn splat(x: Interval) -> Interval8 {
        Interval8::splat(x)
    }

    #[inline]
    fn run<K: Kernel<Interval8>>(kernel: K) -> K::Output {
        kernel.run::<Portable>()
    }
}
