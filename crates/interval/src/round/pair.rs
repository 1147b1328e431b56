//! Two floats side by side: the negated lower end and the upper end of an interval.
//!
//! With `[-lo, hi]` both ends are rounded up by the same operations. Two plain floats, elementwise and
//! without branches: the compiler puts them into one vector register (measured: no slower than the
//! vector instructions written by hand, and no unsafe code).

use super::elementwise::Elementwise;

/// Two floats.
#[derive(Clone, Copy)]
pub(crate) struct Pair(f64, f64);

impl Pair {
    #[inline(always)]
    pub(crate) fn new(first: f64, second: f64) -> Pair {
        Pair(first, second)
    }

    #[inline(always)]
    pub(crate) fn first(self) -> f64 {
        self.0
    }

    #[inline(always)]
    pub(crate) fn second(self) -> f64 {
        self.1
    }
}

impl Elementwise for Pair {
    type Mask = (bool, bool);

    #[inline(always)]
    fn splat(x: f64) -> Pair {
        Pair(x, x)
    }

    #[inline(always)]
    fn plus(self, other: Pair) -> Pair {
        Pair(self.0 + other.0, self.1 + other.1)
    }

    #[inline(always)]
    fn minus(self, other: Pair) -> Pair {
        Pair(self.0 - other.0, self.1 - other.1)
    }

    #[inline(always)]
    fn times(self, other: Pair) -> Pair {
        Pair(self.0 * other.0, self.1 * other.1)
    }

    #[inline(always)]
    fn over(self, other: Pair) -> Pair {
        Pair(self.0 / other.0, self.1 / other.1)
    }

    #[inline(always)]
    fn root(self) -> Pair {
        Pair(self.0.sqrt(), self.1.sqrt())
    }

    #[inline(always)]
    fn negated(self) -> Pair {
        Pair(-self.0, -self.1)
    }

    #[inline(always)]
    fn abs(self) -> Pair {
        Pair(self.0.abs(), self.1.abs())
    }

    #[inline(always)]
    fn above(self, other: Pair) -> (bool, bool) {
        (self.0 > other.0, self.1 > other.1)
    }

    #[inline(always)]
    fn equals(self, other: Pair) -> (bool, bool) {
        (self.0 == other.0, self.1 == other.1)
    }

    #[inline(always)]
    fn kept(self, mask: (bool, bool)) -> Pair {
        Pair(self.0.kept(mask.0), self.1.kept(mask.1))
    }

    #[inline(always)]
    fn both(a: (bool, bool), b: (bool, bool)) -> (bool, bool) {
        (a.0 & b.0, a.1 & b.1)
    }

    #[inline(always)]
    fn either(a: (bool, bool), b: (bool, bool)) -> (bool, bool) {
        (a.0 | b.0, a.1 | b.1)
    }

    #[inline(always)]
    fn all(mask: (bool, bool)) -> bool {
        mask.0 & mask.1
    }

    #[cfg(any(target_feature = "fma", target_arch = "aarch64"))]
    #[inline(always)]
    fn product_error(a: Pair, b: Pair, p: Pair) -> Pair {
        Pair(
            f64::product_error(a.0, b.0, p.0),
            f64::product_error(a.1, b.1, p.1),
        )
    }
}
