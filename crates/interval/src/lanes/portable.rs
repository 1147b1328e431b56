//! Eight intervals on any processor.

use super::{Arithmetic, Interval8, Mask};
use crate::Interval;

/// The operations of [`Interval`] on each lane.
pub(super) struct Portable;

macro_rules! lanewise {
    ($($name:ident),+; $($name2:ident),+) => {
        $(#[inline(always)]
        fn $name(a: &Interval8) -> Interval8 {
            Self::map(a, Interval::$name)
        })+
        $(#[inline(always)]
        fn $name2(a: &Interval8, b: &Interval8) -> Interval8 {
            Self::map2(a, b, |a, b| a.$name2(b))
        })+
    };
}

impl Arithmetic for Portable {
    type Value = Interval8;

    lanewise!(sqr, sqrt, abs, exp, ln, sin, cos; min, max);

    #[inline(always)]
    fn neg(a: &Interval8) -> Interval8 {
        -*a
    }

    #[inline(always)]
    fn add(a: &Interval8, b: &Interval8) -> Interval8 {
        Self::map2(a, b, |a, b| a + b)
    }

    #[inline(always)]
    fn sub(a: &Interval8, b: &Interval8) -> Interval8 {
        Self::map2(a, b, |a, b| a - b)
    }

    #[inline(always)]
    fn mul(a: &Interval8, b: &Interval8) -> Interval8 {
        Self::map2(a, b, |a, b| a * b)
    }

    #[inline(always)]
    fn div(a: &Interval8, b: &Interval8) -> Interval8 {
        Self::map2(a, b, |a, b| a / b)
    }

    #[inline(always)]
    fn intersect(a: &Interval8, b: &Interval8) -> Interval8 {
        a.intersect(b)
    }

    #[inline(always)]
    fn hull(a: &Interval8, b: &Interval8) -> Interval8 {
        a.hull(b)
    }

    #[inline(always)]
    fn is_empty(a: &Interval8) -> Mask {
        a.is_empty()
    }

    #[inline(always)]
    fn is_positive(a: &Interval8) -> Mask {
        Mask::from_fn(|lane| a.neg_lo[lane] < 0.0)
    }

    #[inline(always)]
    fn contains_zero(a: &Interval8) -> Mask {
        a.contains_zero()
    }

    #[inline(always)]
    fn select(mask: Mask, a: &Interval8, b: &Interval8) -> Interval8 {
        a.or_else(mask, b)
    }

    #[inline(always)]
    fn map(a: &Interval8, f: impl Fn(Interval) -> Interval) -> Interval8 {
        a.map(f)
    }

    #[inline(always)]
    fn map2(a: &Interval8, b: &Interval8, f: impl Fn(Interval, Interval) -> Interval) -> Interval8 {
        Interval8::from_fn(|lane| f(a.get(lane), b.get(lane)))
    }

    #[inline(always)]
    fn map3(
        a: &Interval8,
        b: &Interval8,
        c: &Interval8,
        f: impl Fn(Interval, Interval, Interval) -> Interval,
    ) -> Interval8 {
        Interval8::from_fn(|lane| f(a.get(lane), b.get(lane), c.get(lane)))
    }

    #[inline(always)]
    fn test(a: &Interval8, f: impl Fn(Interval) -> bool) -> Mask {
        Mask::from_fn(|lane| f(a.get(lane)))
    }

    #[inline(always)]
    fn test2(a: &Interval8, b: &Interval8, f: impl Fn(Interval, Interval) -> bool) -> Mask {
        Mask::from_fn(|lane| f(a.get(lane), b.get(lane)))
    }
}
