//! The interval type: constructors, set operations, and the numbers that describe an interval.

use crate::round::{sub_down, sub_up};

/// A closed set of real numbers `[lo, hi]`, possibly unbounded, possibly empty.
///
/// NaN cannot be stored. A bounded end belongs to the set; an infinite end means "unbounded", so
/// `lo < +inf` and `hi > -inf` except for [`Interval::EMPTY`]. The sign of a zero end has no meaning.
///
/// ```
/// use veribound_interval::Interval;
/// let x = Interval::new(1.0, 2.0).unwrap();
/// assert!((x * x - x).contains(2.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    lo: f64,
    hi: f64,
}

impl Interval {
    /// The empty set, stored as `[+inf, -inf]`.
    pub const EMPTY: Interval = Interval {
        lo: f64::INFINITY,
        hi: f64::NEG_INFINITY,
    };
    /// All real numbers.
    pub const ENTIRE: Interval = Interval {
        lo: f64::NEG_INFINITY,
        hi: f64::INFINITY,
    };
    /// The number 0.
    pub const ZERO: Interval = Interval { lo: 0.0, hi: 0.0 };
    /// The number 1.
    pub const ONE: Interval = Interval { lo: 1.0, hi: 1.0 };
    /// The smallest enclosure of π: the nearest float is below π, its neighbour above.
    pub const PI: Interval = Interval {
        lo: std::f64::consts::PI,
        hi: std::f64::consts::PI.next_up(),
    };
    /// All numbers `>= 0`.
    pub(crate) const NON_NEGATIVE: Interval = Interval {
        lo: 0.0,
        hi: f64::INFINITY,
    };
    /// All numbers `>= 1`.
    pub(crate) const FROM_ONE: Interval = Interval {
        lo: 1.0,
        hi: f64::INFINITY,
    };
    /// The range of sine, cosine and sign.
    pub(crate) const UNIT: Interval = Interval { lo: -1.0, hi: 1.0 };

    /// The set `[lo, hi]`; `None` for NaN, `lo > hi`, `lo = +inf` or `hi = -inf`.
    #[inline]
    pub fn new(lo: f64, hi: f64) -> Option<Interval> {
        (lo <= hi && lo < f64::INFINITY && hi > f64::NEG_INFINITY).then_some(Interval { lo, hi })
    }

    /// An enclosure of what the float stands for: `{x}` for a finite number, the numbers beyond the
    /// largest float for an infinity, all numbers for NaN.
    #[inline]
    pub fn point(x: f64) -> Interval {
        if x.is_finite() {
            Interval { lo: x, hi: x }
        } else if x.is_nan() {
            Interval::ENTIRE
        } else if x > 0.0 {
            Interval {
                lo: f64::MAX,
                hi: x,
            }
        } else {
            Interval {
                lo: x,
                hi: f64::MIN,
            }
        }
    }

    /// The smallest interval with both numbers, `[-r, r]` around zero; NaN gives all numbers.
    #[inline]
    pub fn symmetric(r: f64) -> Interval {
        if r.is_nan() {
            return Interval::ENTIRE;
        }
        Interval {
            lo: -r.abs(),
            hi: r.abs(),
        }
    }

    /// The set `[lo, hi]`, or the empty set if `lo > hi`. Required: no NaN, and not both ends the
    /// same infinity.
    #[inline(always)]
    pub(crate) fn ordered(lo: f64, hi: f64) -> Interval {
        debug_assert!(!lo.is_nan() && !hi.is_nan());
        if lo <= hi {
            Interval { lo, hi }
        } else {
            Interval::EMPTY
        }
    }

    /// The set `[lo, hi]` for ends that are known to be in order.
    #[inline(always)]
    pub(crate) const fn raw(lo: f64, hi: f64) -> Interval {
        debug_assert!(lo <= hi && lo < f64::INFINITY && hi > f64::NEG_INFINITY);
        Interval { lo, hi }
    }

    /// Ends that were taken from an interval.
    #[inline(always)]
    pub(crate) fn stored(lo: f64, hi: f64) -> Interval {
        Interval { lo, hi }
    }

    /// Lower and upper end.
    #[inline(always)]
    pub(crate) const fn ends(self) -> (f64, f64) {
        (self.lo, self.hi)
    }

    /// The lower end; `+inf` for the empty set.
    #[inline]
    pub fn lo(self) -> f64 {
        self.lo
    }

    /// The upper end; `-inf` for the empty set.
    #[inline]
    pub fn hi(self) -> f64 {
        self.hi
    }

    /// True for the set without elements.
    #[inline]
    pub fn is_empty(self) -> bool {
        self.lo > self.hi
    }

    /// True where both ends are finite; false for the empty set.
    #[inline]
    pub fn is_bounded(self) -> bool {
        self.lo > f64::NEG_INFINITY && self.hi < f64::INFINITY && !self.is_empty()
    }

    /// True for a set of exactly one number.
    #[inline]
    pub fn is_point(self) -> bool {
        self.lo == self.hi
    }

    /// True if the finite number `x` is an element; false for infinities and NaN.
    #[inline]
    pub fn contains(self, x: f64) -> bool {
        self.lo <= x && x <= self.hi && x.is_finite()
    }

    /// True if every element of `self` is an element of `other`; the empty set is a subset of all.
    #[inline]
    pub fn is_subset_of(self, other: Interval) -> bool {
        self.is_empty() || (other.lo <= self.lo && self.hi <= other.hi)
    }

    /// True if `self` lies in the topological interior of `other` (an unbounded end has no border).
    #[inline]
    pub fn is_interior_of(self, other: Interval) -> bool {
        let below = other.lo < self.lo || other.lo == f64::NEG_INFINITY;
        let above = self.hi < other.hi || other.hi == f64::INFINITY;
        self.is_empty() || (below && above && !other.is_empty())
    }

    /// True if the two sets have a common element.
    #[inline]
    pub fn intersects(self, other: Interval) -> bool {
        self.lo <= other.hi && other.lo <= self.hi && !self.is_empty() && !other.is_empty()
    }

    /// The common elements, exactly.
    #[inline]
    pub fn intersect(self, other: Interval) -> Interval {
        Interval::ordered(larger(self.lo, other.lo), smaller(self.hi, other.hi))
    }

    /// The smallest interval with all elements of both.
    #[inline]
    pub fn hull(self, other: Interval) -> Interval {
        Interval {
            lo: smaller(self.lo, other.lo),
            hi: larger(self.hi, other.hi),
        }
    }

    /// A finite float in the set, the nearest to the middle of a bounded one.
    ///
    /// 0 for all numbers, the largest float of the right sign for a half line, 0 for the empty set.
    /// Proof of membership: rounding is monotone and keeps floats, so half of the rounded sum stays
    /// between the ends; where the sum overflows, both halves are exact and the same holds.
    #[inline]
    pub fn mid(self) -> f64 {
        let sum = self.lo + self.hi;
        if sum.is_finite() {
            return 0.5 * sum;
        }
        if self.is_empty() || (self.lo.is_infinite() && self.hi.is_infinite()) {
            0.0
        } else if self.lo.is_infinite() {
            f64::MIN
        } else if self.hi.is_infinite() {
            f64::MAX
        } else {
            0.5 * self.lo + 0.5 * self.hi
        }
    }

    /// `hi - lo` rounded up; 0 for the empty set.
    #[inline]
    pub fn width(self) -> f64 {
        if self.is_empty() {
            0.0
        } else {
            sub_up(self.hi, self.lo)
        }
    }

    /// A radius such that `[mid - rad, mid + rad]` covers the set, rounded up; 0 for the empty set.
    #[inline]
    pub fn rad(self) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        let mid = self.mid();
        larger(sub_up(self.hi, mid), sub_up(mid, self.lo))
    }

    /// [`Interval::mid`] and [`Interval::rad`] together: `[mid - rad, mid + rad]` covers the set.
    #[inline]
    pub fn mid_rad(self) -> (f64, f64) {
        (self.mid(), self.rad())
    }

    /// The largest absolute value of an element, exactly; 0 for the empty set.
    #[inline]
    pub fn mag(self) -> f64 {
        if self.is_empty() {
            0.0
        } else {
            larger(self.lo.abs(), self.hi.abs())
        }
    }

    /// The smallest absolute value of an element, exactly; 0 for the empty set.
    #[inline]
    pub fn mig(self) -> f64 {
        if self.lo > 0.0 && !self.is_empty() {
            self.lo
        } else if self.hi < 0.0 && !self.is_empty() {
            -self.hi
        } else {
            0.0
        }
    }

    /// All numbers whose distance from the set is at most `r`, rounded outward; the empty set stays
    /// empty, and a NaN or negative `r` counts as unbounded and zero.
    #[inline]
    pub fn inflate(self, r: f64) -> Interval {
        if self.is_empty() {
            return self;
        }
        let r = if r.is_nan() {
            f64::INFINITY
        } else {
            larger(r, 0.0)
        };
        Interval {
            lo: sub_down(self.lo, r),
            hi: crate::round::add_up(self.hi, r),
        }
    }
}

/// The smaller of two floats that are not NaN: one comparison, unlike `f64::min`.
#[inline(always)]
pub(crate) fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The larger of two floats that are not NaN.
#[inline(always)]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}
