//! The instruction sets on which eight intervals run, and the choice among them.

use std::sync::OnceLock;

use super::engine::Engine;
use super::portable::Array;
use super::{Interval8, Kernel, Mask, Value};
use crate::Interval;

#[cfg(target_arch = "x86_64")]
use super::{avx2::F64x4, avx512::F64x8};

/// The environment variable that chooses a path by its [`Path::name`].
const VARIABLE: &str = "VERIBOUND_LANES";

/// How operations on [`Interval8`] are carried out.
///
/// All paths give the same bits, those of [`Interval`] (the sign of a zero end aside): by proof where
/// operations are tight, and for elementary functions if CORE-MATH returns the nearest float.
///
/// ```
/// use veribound_interval::lanes::Path;
///
/// assert!(Path::available().any(|path| path == Path::Portable));
/// assert!(Path::chosen().is_available());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// Error-free transformations in whatever the compilation target has.
    Portable,
    /// Error-free transformations in AVX2 with fused multiplication.
    Avx2,
    /// Rounding upward in the instructions of AVX-512.
    Avx512,
}

/// What was chosen, and what could not be.
struct Choice {
    path: Path,
    refused: Option<String>,
}

impl Path {
    /// All paths, the widest first.
    pub const ALL: [Path; 3] = [Path::Avx512, Path::Avx2, Path::Portable];

    /// The paths this processor has, the widest first.
    pub fn available() -> impl Iterator<Item = Path> {
        Path::ALL.into_iter().filter(|path| path.is_available())
    }

    /// True if this processor has the instructions.
    pub fn is_available(self) -> bool {
        match self {
            Path::Portable => true,
            #[cfg(target_arch = "x86_64")]
            Path::Avx2 => is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma"),
            #[cfg(target_arch = "x86_64")]
            Path::Avx512 => {
                is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512vl")
            }
            #[cfg(not(target_arch = "x86_64"))]
            _ => false,
        }
    }

    /// The name of the path in the environment variable `VERIBOUND_LANES`.
    pub fn name(self) -> &'static str {
        match self {
            Path::Portable => "portable",
            Path::Avx2 => "avx2",
            Path::Avx512 => "avx512",
        }
    }

    /// The path that [`Value::run`] takes: the one that the environment variable `VERIBOUND_LANES`
    /// named when it was first needed, or the widest if there is no such variable or it is
    /// [`Path::refused`].
    #[inline]
    pub fn chosen() -> Path {
        Path::choice().path
    }

    /// The value of `VERIBOUND_LANES` if it names no path or one that this processor does not have.
    pub fn refused() -> Option<&'static str> {
        Path::choice().refused.as_deref()
    }

    #[inline]
    fn choice() -> &'static Choice {
        static CHOICE: OnceLock<Choice> = OnceLock::new();
        CHOICE.get_or_init(|| Path::choose(std::env::var_os(VARIABLE)))
    }

    fn choose(wish: Option<std::ffi::OsString>) -> Choice {
        let widest = Path::available().next().unwrap_or(Path::Portable);
        let Some(wish) = wish.filter(|wish| !wish.is_empty()) else {
            return Choice {
                path: widest,
                refused: None,
            };
        };
        match Path::available().find(|path| wish == path.name()) {
            Some(path) => Choice {
                path,
                refused: None,
            },
            None => Choice {
                path: widest,
                refused: Some(wish.to_string_lossy().into_owned()),
            },
        }
    }

    /// Runs a kernel on this path; `None` where the processor does not have it.
    #[inline]
    pub fn run<K: Kernel<Interval8>>(self, kernel: K) -> Option<K::Output> {
        self.is_available().then(|| self.run_available(kernel))
    }

    /// Required: the path is available.
    #[inline]
    fn run_available<K: Kernel<Interval8>>(self, kernel: K) -> K::Output {
        match self {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: the processor has the instructions of an available path.
            Path::Avx2 => unsafe { run_avx2(kernel) },
            #[cfg(target_arch = "x86_64")]
            // SAFETY: the processor has the instructions of an available path.
            Path::Avx512 => unsafe { run_avx512(kernel) },
            Path::Portable => run_portable(kernel),
            #[cfg(not(target_arch = "x86_64"))]
            _ => run_portable(kernel),
        }
    }
}

/// Floats side by side on the path for all processors: four were the fastest.
///
/// A function of its own, so that the choice of the path is short enough to stand where a kernel is started, and
/// the kernel is not moved on the way.
#[inline(never)]
fn run_portable<K: Kernel<Interval8>>(kernel: K) -> K::Output {
    kernel.run::<Engine<Array<4>>>()
}

/// A kernel with all that is inlined into it, compiled for the instruction set.
///
/// # Safety
/// The processor has AVX2 and FMA.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
unsafe fn run_avx2<K: Kernel<Interval8>>(kernel: K) -> K::Output {
    kernel.run::<Engine<F64x4>>()
}

/// # Safety
/// The processor has AVX-512 with the extensions DQ and VL.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl")]
unsafe fn run_avx512<K: Kernel<Interval8>>(kernel: K) -> K::Output {
    kernel.run::<Engine<F64x8>>()
}

impl Value for Interval8 {
    type Mask = Mask;

    #[inline(always)]
    fn splat(x: Interval) -> Interval8 {
        Interval8::splat(x)
    }

    #[inline]
    fn run<K: Kernel<Interval8>>(kernel: K) -> K::Output {
        Path::chosen().run_available(kernel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_variable_chooses_and_nonsense_is_refused() {
        let widest = Path::available().next().unwrap();
        for path in Path::available() {
            let choice = Path::choose(Some(path.name().into()));
            assert_eq!((choice.path, choice.refused), (path, None));
        }
        for (wish, refused) in [(None, None), (Some(""), None), (Some("sse"), Some("sse"))] {
            let choice = Path::choose(wish.map(Into::into));
            assert_eq!(choice.path, widest);
            assert_eq!(choice.refused.as_deref(), refused);
        }
    }
}
