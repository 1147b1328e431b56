//! One interval at a time.

use super::{Arithmetic, Kernel, Value};
use crate::Interval;

/// The operations of [`Interval`] themselves.
pub(super) struct Scalar;

impl Value for Interval {
    type Mask = bool;

    #[inline(always)]
    fn splat(x: Interval) -> Interval {
        x
    }

    #[inline(always)]
    fn run<K: Kernel<Interval>>(kernel: K) -> K::Output {
        kernel.run::<Scalar>()
    }
}

macro_rules! forward {
    ($($name:ident),+; $($name2:ident),+) => {
        $(#[inline(always)]
        fn $name(a: &Interval) -> Interval {
            Interval::$name(*a)
        })+
        $(#[inline(always)]
        fn $name2(a: &Interval, b: &Interval) -> Interval {
            Interval::$name2(*a, *b)
        })+
    };
}

impl Arithmetic for Scalar {
    type Value = Interval;

    forward!(sqr, sqrt, abs, sign, exp, ln, sin, cos, tan, atan, tanh; min, max, intersect, hull);

    #[inline(always)]
    fn neg(a: &Interval) -> Interval {
        -*a
    }

    #[inline(always)]
    fn add(a: &Interval, b: &Interval) -> Interval {
        *a + *b
    }

    #[inline(always)]
    fn sub(a: &Interval, b: &Interval) -> Interval {
        *a - *b
    }

    #[inline(always)]
    fn mul(a: &Interval, b: &Interval) -> Interval {
        *a * *b
    }

    #[inline(always)]
    fn scale(a: &Interval, factor: Interval) -> Interval {
        *a * factor
    }

    #[inline(always)]
    fn div(a: &Interval, b: &Interval) -> Interval {
        *a / *b
    }

    #[inline(always)]
    fn powi(a: &Interval, n: i32) -> Interval {
        a.powi(n)
    }

    #[inline(always)]
    fn is_empty(a: &Interval) -> bool {
        a.is_empty()
    }

    #[inline(always)]
    fn is_positive(a: &Interval) -> bool {
        a.lo() > 0.0
    }

    #[inline(always)]
    fn contains_zero(a: &Interval) -> bool {
        a.contains(0.0)
    }

    #[inline(always)]
    fn select(mask: bool, a: &Interval, b: &Interval) -> Interval {
        if mask { *a } else { *b }
    }

    #[inline(always)]
    fn map(a: &Interval, f: impl Fn(Interval) -> Interval) -> Interval {
        f(*a)
    }

    #[inline(always)]
    fn map2(a: &Interval, b: &Interval, f: impl Fn(Interval, Interval) -> Interval) -> Interval {
        f(*a, *b)
    }

    #[inline(always)]
    fn map3(
        a: &Interval,
        b: &Interval,
        c: &Interval,
        f: impl Fn(Interval, Interval, Interval) -> Interval,
    ) -> Interval {
        f(*a, *b, *c)
    }

    #[inline(always)]
    fn test(a: &Interval, f: impl Fn(Interval) -> bool) -> bool {
        f(*a)
    }

    #[inline(always)]
    fn test2(a: &Interval, b: &Interval, f: impl Fn(Interval, Interval) -> bool) -> bool {
        f(*a, *b)
    }
}
