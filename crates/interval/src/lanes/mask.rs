//! Truth values, one per lane.

use std::ops::{BitAnd, BitOr, Not};

use super::{Floats, LANES};

/// One truth value for every lane of a [`super::Value`]: `bool` for one interval,
/// [`Mask`] for eight.
///
/// Example: [`Mask`].
pub trait Lanewise:
    Copy
    + PartialEq
    + std::fmt::Debug
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + Not<Output = Self>
{
    /// The same truth value in every lane.
    fn splat(value: bool) -> Self;

    /// True where at least one lane is.
    fn any(self) -> bool;

    /// True where every lane is.
    #[inline(always)]
    fn all(self) -> bool {
        !(!self).any()
    }
}

impl Lanewise for bool {
    #[inline(always)]
    fn splat(value: bool) -> bool {
        value
    }

    #[inline(always)]
    fn any(self) -> bool {
        self
    }
}

/// Eight truth values, lane `i` in bit `i`.
///
/// ```
/// use veribound_interval::lanes::{Floats, LANES, Lanewise, Mask};
///
/// let ones: Floats = [1.0; LANES];
/// let small = Mask::below(&[0.0, 0.5, 1.0, 2.0, 3.0, 4.0, 5.0, f64::NAN], &ones);
/// assert_eq!(small.lanes().collect::<Vec<_>>(), [0, 1]);
/// assert!(small.any() && !small.all());
/// assert_eq!(small.without(Mask::lane(1)), Mask::lane(0));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mask(u8);

impl Mask {
    /// False in every lane.
    pub const NONE: Mask = Mask(0);
    /// True in every lane.
    pub const ALL: Mask = Mask(u8::MAX);

    /// The truth value of every lane by its number.
    #[inline(always)]
    pub fn from_fn(value: impl Fn(usize) -> bool) -> Mask {
        let mut bits = 0;
        for lane in 0..LANES {
            bits |= u8::from(value(lane)) << lane;
        }
        Mask(bits)
    }

    /// `a <= b`; false for NaN.
    #[inline(always)]
    pub fn at_most(a: &Floats, b: &Floats) -> Mask {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: SSE2 belongs to every x86-64 processor.
        return Mask(unsafe { sse2::at_most(a, b) });
        #[cfg(not(target_arch = "x86_64"))]
        Mask::from_fn(|lane| a[lane] <= b[lane])
    }

    /// `a < b`; false for NaN.
    #[inline(always)]
    pub fn below(a: &Floats, b: &Floats) -> Mask {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: SSE2 belongs to every x86-64 processor.
        return Mask(unsafe { sse2::below(a, b) });
        #[cfg(not(target_arch = "x86_64"))]
        Mask::from_fn(|lane| a[lane] < b[lane])
    }

    /// True in the first `count` lanes.
    #[inline]
    pub fn first(count: usize) -> Mask {
        Mask::from_fn(|lane| lane < count)
    }

    /// True in one lane. Required: `lane < LANES`; other numbers are taken modulo [`LANES`], so that
    /// nothing here can panic.
    #[inline]
    pub fn lane(lane: usize) -> Mask {
        Mask(1 << (lane % LANES))
    }

    /// Lane `i` in bit `i`.
    #[inline(always)]
    pub fn bits(self) -> u8 {
        self.0
    }

    /// Lane `i` from bit `i`.
    #[inline(always)]
    pub fn from_bits(bits: u8) -> Mask {
        Mask(bits)
    }

    /// The truth value of one lane. Required: `lane < LANES`, as for [`Mask::lane`].
    #[inline(always)]
    pub fn get(self, lane: usize) -> bool {
        self.0 >> (lane % LANES) & 1 == 1
    }

    /// True where no lane is.
    #[inline(always)]
    pub fn none(self) -> bool {
        self.0 == 0
    }

    /// The lanes of `self` that are not in `other`.
    #[inline(always)]
    pub fn without(self, other: Mask) -> Mask {
        Mask(self.0 & !other.0)
    }

    /// The numbers of the lanes that are true, in order.
    #[inline]
    pub fn lanes(self) -> impl Iterator<Item = usize> {
        let mut rest = self.0;
        std::iter::from_fn(move || {
            if rest == 0 {
                return None;
            }
            let lane = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            Some(lane)
        })
    }
}

/// Comparisons whose bits the compiler does not collect by itself in one instruction.
#[cfg(target_arch = "x86_64")]
mod sse2 {
    use super::Floats;
    use std::arch::x86_64::{_mm_cmple_pd, _mm_cmplt_pd, _mm_movemask_pd, _mm_set_pd};

    macro_rules! comparison {
        ($name:ident, $compare:ident) => {
            #[target_feature(enable = "sse2")]
            #[inline]
            pub(super) fn $name(a: &Floats, b: &Floats) -> u8 {
                let mut bits = 0;
                for lane in [0, 2, 4, 6] {
                    let a = _mm_set_pd(a[lane + 1], a[lane]);
                    let b = _mm_set_pd(b[lane + 1], b[lane]);
                    bits |= _mm_movemask_pd($compare(a, b)) << lane;
                }
                bits as u8
            }
        };
    }

    comparison!(at_most, _mm_cmple_pd);
    comparison!(below, _mm_cmplt_pd);
}

impl Lanewise for Mask {
    #[inline(always)]
    fn splat(value: bool) -> Mask {
        if value { Mask::ALL } else { Mask::NONE }
    }

    #[inline(always)]
    fn any(self) -> bool {
        self.0 != 0
    }

    #[inline(always)]
    fn all(self) -> bool {
        self.0 == u8::MAX
    }
}

impl BitAnd for Mask {
    type Output = Mask;

    #[inline(always)]
    fn bitand(self, other: Mask) -> Mask {
        Mask(self.0 & other.0)
    }
}

impl BitOr for Mask {
    type Output = Mask;

    #[inline(always)]
    fn bitor(self, other: Mask) -> Mask {
        Mask(self.0 | other.0)
    }
}

impl Not for Mask {
    type Output = Mask;

    #[inline(always)]
    fn not(self) -> Mask {
        Mask(!self.0)
    }
}

impl std::ops::BitAndAssign for Mask {
    #[inline(always)]
    fn bitand_assign(&mut self, other: Mask) {
        self.0 &= other.0;
    }
}

impl std::ops::BitOrAssign for Mask {
    #[inline(always)]
    fn bitor_assign(&mut self, other: Mask) {
        self.0 |= other.0;
    }
}
