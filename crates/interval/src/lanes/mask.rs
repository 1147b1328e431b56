//! Truth values, one per lane.

use std::ops::{BitAnd, BitOr, Not};

use super::LANES;

/// One truth value for every lane of a [`super::Value`]: `bool` for one interval,
/// [`Mask`] for eight.
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

    /// True in the first `count` lanes.
    #[inline]
    pub fn first(count: usize) -> Mask {
        Mask::from_fn(|lane| lane < count)
    }

    /// True in one lane.
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

    /// The truth value of one lane.
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

impl Lanewise for Mask {
    #[inline(always)]
    fn splat(value: bool) -> Mask {
        if value { Mask::ALL } else { Mask::NONE }
    }

    #[inline(always)]
    fn any(self) -> bool {
        self.0 != 0
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
