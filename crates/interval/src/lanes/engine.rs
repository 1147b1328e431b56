//! The operations on eight intervals, for one instruction set.

use std::marker::PhantomData;

use super::vector::Vector;
use super::{Arithmetic, Interval8, Mask, basic};
use crate::Interval;

/// [`Arithmetic`] in registers of the kind `V`.
pub(super) struct Engine<V>(PhantomData<V>);

macro_rules! basic {
    ($($name:ident),+; $($name2:ident),+) => {
        $(#[inline(always)]
        fn $name(a: &Interval8) -> Interval8 {
            basic::$name::<V>(a)
        })+
        $(#[inline(always)]
        fn $name2(a: &Interval8, b: &Interval8) -> Interval8 {
            basic::$name2::<V>(a, b)
        })+
    };
}

macro_rules! long {
    ($($name:ident),+; $($name2:ident),+) => {
        $(#[inline(always)]
        fn $name(a: &Interval8) -> Interval8 {
            V::$name(a)
        })+
        $(#[inline(always)]
        fn $name2(a: &Interval8, b: &Interval8) -> Interval8 {
            V::$name2(a, b)
        })+
    };
}

impl<V: Vector> Arithmetic for Engine<V> {
    type Value = Interval8;

    basic!(abs, sign; add, sub, min, max, intersect, hull);
    long!(sqr, sqrt, exp, ln, sin, cos, tan, atan, tanh; mul, div);

    #[inline(always)]
    fn scale(a: &Interval8, factor: Interval) -> Interval8 {
        if factor.lo() >= 0.0 && !factor.is_empty() {
            V::scale(a, factor)
        } else {
            V::mul(a, &Interval8::splat(factor))
        }
    }

    #[inline(always)]
    fn neg(a: &Interval8) -> Interval8 {
        -*a
    }

    #[inline(always)]
    fn powi(a: &Interval8, n: i32) -> Interval8 {
        match n {
            0 => {
                let one = Interval8::splat(Interval::ONE);
                Self::select(Self::is_empty(a), a, &one)
            }
            1 => *a,
            2 => V::sqr(a),
            -1 => V::div(&Interval8::splat(Interval::ONE), a),
            _ => V::powi(a, n),
        }
    }

    #[inline(always)]
    fn is_empty(a: &Interval8) -> Mask {
        Mask::from_bits(basic::is_empty::<V>(a))
    }

    #[inline(always)]
    fn is_positive(a: &Interval8) -> Mask {
        Mask::from_bits(basic::is_positive::<V>(a))
    }

    #[inline(always)]
    fn contains_zero(a: &Interval8) -> Mask {
        Mask::from_bits(basic::contains_zero::<V>(a))
    }

    #[inline(always)]
    fn select(mask: Mask, a: &Interval8, b: &Interval8) -> Interval8 {
        basic::select::<V>(mask.bits(), a, b)
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
