//! Eight intervals as a structure of arrays.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::arithmetic::{Arithmetic, Kernel, Value};
use super::{Floats, LANES, Lanewise, Mask};
use crate::Interval;
use crate::interval::{larger, smaller};

/// Eight intervals side by side; lane by lane what [`Interval`] is.
///
/// Stored as negated lower ends and upper ends, so that both are rounded up.
///
/// ```
/// use veribound_interval::{Interval, Interval8};
///
/// let x = Interval8::from_fn(|lane| Interval::point(lane as f64));
/// let sum = x + Interval8::splat(Interval::new(0.0, 1.0).unwrap());
/// assert_eq!(sum.get(3), Interval::new(3.0, 4.0).unwrap());
/// assert_eq!(sum.contains_zero().bits(), 1);
/// ```
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval8 {
    pub(super) neg_lo: Floats,
    pub(super) hi: Floats,
}

/// All bits of the lanes that a mask of four names: it costs less than to take the mask apart.
const WHOLE: [[u64; LANES / 2]; 16] = {
    let mut table = [[0; LANES / 2]; 16];
    let mut bits = 0;
    while bits < 16 {
        let mut lane = 0;
        while lane < LANES / 2 {
            if bits >> lane & 1 == 1 {
                table[bits][lane] = u64::MAX;
            }
            lane += 1;
        }
        bits += 1;
    }
    table
};

impl Interval8 {
    /// The empty set in every lane.
    pub const EMPTY: Interval8 = Interval8::splat(Interval::EMPTY);
    /// All numbers in every lane.
    pub const ENTIRE: Interval8 = Interval8::splat(Interval::ENTIRE);
    /// The number 0 in every lane.
    pub const ZERO: Interval8 = Interval8::splat(Interval::ZERO);

    /// The same interval in every lane.
    #[inline(always)]
    pub const fn splat(x: Interval) -> Interval8 {
        let (lo, hi) = x.ends();
        Interval8 {
            neg_lo: [-lo; LANES],
            hi: [hi; LANES],
        }
    }

    /// Each lane by its number.
    #[inline(always)]
    pub fn from_fn(mut value: impl FnMut(usize) -> Interval) -> Interval8 {
        let mut all = Interval8::EMPTY;
        for lane in 0..LANES {
            all.set(lane, value(lane));
        }
        all
    }

    /// The smallest enclosure of one float per lane, as [`Interval::point`].
    #[inline(always)]
    pub fn point(x: Floats) -> Interval8 {
        const LARGEST: Floats = [f64::MAX; LANES];
        if Mask::at_most(&x.map(f64::abs), &LARGEST).all() {
            Interval8 {
                neg_lo: x.map(|x| -x),
                hi: x,
            }
        } else {
            Interval8::from_fn(|lane| Interval::point(x[lane]))
        }
    }

    /// The set `[lo, hi]` in each lane, empty where `lo <= hi` does not hold or both are the same
    /// infinity.
    #[inline(always)]
    pub fn between(lo: Floats, hi: Floats) -> Interval8 {
        let valid = |lane: usize| {
            lo[lane] <= hi[lane] && lo[lane] < f64::INFINITY && hi[lane] > f64::NEG_INFINITY
        };
        let mut all = Interval8::EMPTY;
        for lane in 0..LANES {
            let valid = valid(lane);
            all.neg_lo[lane] = if valid { -lo[lane] } else { f64::NEG_INFINITY };
            all.hi[lane] = if valid { hi[lane] } else { f64::NEG_INFINITY };
        }
        all
    }

    /// The interval in one lane. Required: `lane < LANES`; else it panics.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Interval {
        Interval::stored(-self.neg_lo[lane], self.hi[lane])
    }

    /// Puts an interval into one lane. Required: `lane < LANES`; else it panics.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, x: Interval) {
        self.neg_lo[lane] = -x.lo();
        self.hi[lane] = x.hi();
    }

    /// The lower ends.
    #[inline(always)]
    pub fn lo(&self) -> Floats {
        self.neg_lo.map(|x| -x)
    }

    /// The upper ends.
    #[inline(always)]
    pub fn hi(&self) -> Floats {
        self.hi
    }

    /// A choice by the mask: `self` in its lanes, `other` elsewhere. (Arithmetics choose by
    /// [`Arithmetic::select`]; this one needs no arithmetic.)
    #[inline(always)]
    pub fn or_else(&self, mask: Mask, other: &Interval8) -> Interval8 {
        let mut all = *other;
        all.assign(mask, self);
        all
    }

    /// Takes over `other` in the lanes of the mask.
    #[inline(always)]
    pub fn assign(&mut self, mask: Mask, other: &Interval8) {
        // Mostly all boxes take the same way.
        if mask.all() {
            *self = *other;
        } else if !mask.none() {
            let choose = |to: &mut Floats, from: &Floats| {
                let halves = [mask.bits() & 15, mask.bits() >> 4];
                let ends = to
                    .chunks_exact_mut(LANES / 2)
                    .zip(from.chunks_exact(LANES / 2));
                for ((to, from), half) in ends.zip(halves) {
                    for ((to, from), keep) in to.iter_mut().zip(from).zip(WHOLE[usize::from(half)])
                    {
                        *to = f64::from_bits(from.to_bits() & keep | to.to_bits() & !keep);
                    }
                }
            };
            choose(&mut self.neg_lo, &other.neg_lo);
            choose(&mut self.hi, &other.hi);
        }
    }

    /// The common elements, exactly.
    #[inline(always)]
    pub fn intersect(&self, other: &Interval8) -> Interval8 {
        let mut all = Interval8::EMPTY;
        for lane in 0..LANES {
            let neg_lo = smaller(self.neg_lo[lane], other.neg_lo[lane]);
            let hi = smaller(self.hi[lane], other.hi[lane]);
            let empty = -neg_lo > hi;
            all.neg_lo[lane] = if empty { f64::NEG_INFINITY } else { neg_lo };
            all.hi[lane] = if empty { f64::NEG_INFINITY } else { hi };
        }
        all
    }

    /// The smallest intervals with all elements of both.
    #[inline(always)]
    pub fn hull(&self, other: &Interval8) -> Interval8 {
        let mut all = Interval8::EMPTY;
        for lane in 0..LANES {
            all.neg_lo[lane] = larger(self.neg_lo[lane], other.neg_lo[lane]);
            all.hi[lane] = larger(self.hi[lane], other.hi[lane]);
        }
        all
    }

    /// The lanes without elements.
    #[inline(always)]
    pub fn is_empty(&self) -> Mask {
        Mask::below(&self.hi, &self.lo())
    }

    /// The lanes where both ends are finite; false for the empty set.
    #[inline(always)]
    pub fn is_bounded(&self) -> Mask {
        const INFINITE: Floats = [f64::INFINITY; LANES];
        Mask::below(&self.neg_lo, &INFINITE)
            & Mask::below(&self.hi, &INFINITE)
            & Mask::at_most(&self.lo(), &self.hi)
    }

    /// The lanes where every element of `self` is one of `other`; the ends of the empty set are below
    /// all others.
    #[inline(always)]
    pub fn is_subset_of(&self, other: &Interval8) -> Mask {
        Mask::at_most(&self.neg_lo, &other.neg_lo) & Mask::at_most(&self.hi, &other.hi)
    }

    /// The lanes where `self` lies in the topological interior of `other`.
    #[inline(always)]
    pub fn is_interior_of(&self, other: &Interval8) -> Mask {
        const INFINITE: Floats = [f64::INFINITY; LANES];
        let inside = |end: &Floats, other: &Floats| {
            Mask::below(end, other) | Mask::at_most(&INFINITE, other)
        };
        let within = inside(&self.neg_lo, &other.neg_lo) & inside(&self.hi, &other.hi);
        within.without(other.is_empty()) | self.is_empty()
    }

    /// The lanes where the two sets have a common element.
    #[inline(always)]
    pub fn intersects(&self, other: &Interval8) -> Mask {
        !self.intersect(other).is_empty()
    }

    /// The lanes where 0 is an element.
    #[inline(always)]
    pub fn contains_zero(&self) -> Mask {
        const ZERO: Floats = [0.0; LANES];
        Mask::at_most(&ZERO, &self.neg_lo) & Mask::at_most(&ZERO, &self.hi)
    }

    /// A finite float of every lane, as [`Interval::mid`].
    #[inline(always)]
    pub fn mid(&self) -> Floats {
        let sum: Floats = std::array::from_fn(|lane| self.hi[lane] - self.neg_lo[lane]);
        if sum.iter().all(|sum| sum.is_finite()) {
            sum.map(|sum| 0.5 * sum)
        } else {
            std::array::from_fn(|lane| self.get(lane).mid())
        }
    }

    /// `hi - lo` rounded up, as [`Interval::width`].
    #[inline(always)]
    pub fn width(&self) -> Floats {
        let widths = Interval8 {
            neg_lo: self.neg_lo,
            hi: self.hi,
        } + Interval8 {
            neg_lo: self.hi,
            hi: self.neg_lo,
        };
        let empty = self.is_empty();
        let mut width = widths.hi;
        for (lane, width) in width.iter_mut().enumerate() {
            *width = if empty.get(lane) { 0.0 } else { *width };
        }
        width
    }

    /// The largest absolute values, as [`Interval::mag`]: the larger one of `-lo` and `hi`.
    #[inline(always)]
    pub fn mag(&self) -> Floats {
        std::array::from_fn(|lane| larger(larger(self.neg_lo[lane], self.hi[lane]), 0.0))
    }

    /// A scalar operation on each lane.
    #[inline(always)]
    pub fn map(&self, f: impl Fn(Interval) -> Interval) -> Interval8 {
        Interval8::from_fn(|lane| f(self.get(lane)))
    }
}

macro_rules! operator {
    ($($trait:ident $method:ident $kernel:ident),+) => {$(
        struct $kernel<'a>(&'a Interval8, &'a Interval8);

        impl Kernel<Interval8> for $kernel<'_> {
            type Output = Interval8;

            #[inline(always)]
            fn run<A: Arithmetic<Value = Interval8>>(self) -> Interval8 {
                A::$method(self.0, self.1)
            }
        }

        impl $trait for Interval8 {
            type Output = Interval8;

            #[inline]
            fn $method(self, other: Interval8) -> Interval8 {
                Interval8::run($kernel(&self, &other))
            }
        }
    )+};
}

operator!(Add add AddKernel, Sub sub SubKernel, Mul mul MulKernel, Div div DivKernel);

impl Neg for Interval8 {
    type Output = Interval8;

    #[inline(always)]
    fn neg(self) -> Interval8 {
        Interval8 {
            neg_lo: self.hi,
            hi: self.neg_lo,
        }
    }
}
