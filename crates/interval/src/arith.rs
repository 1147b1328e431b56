//! Interval `+ - * /`, square root, absolute value, sign, minimum, maximum.
//!
//! *Guarantee* of every function here: the result contains `f(x, ..)` for all elements of the
//! arguments where `f` is defined; it is empty exactly where there is none. Ends are the tight
//! directed values of [`crate::round`], so all results are the smallest possible.

use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use crate::Interval;
use crate::interval::{larger, smaller};
use crate::round::{
    Elementwise, Pair, add_down, add_up, div_down, div_up, mul_down, mul_up, product_up,
    quotient_up, sqrt_down, sqrt_up, sum_up,
};

impl Neg for Interval {
    type Output = Interval;

    /// `-[a, b] = [-b, -a]`, exactly; `[+inf, -inf]` (empty) stays what it is.
    #[inline]
    fn neg(self) -> Interval {
        if self.is_empty() {
            self
        } else {
            Interval::raw(-self.hi(), -self.lo())
        }
    }
}

/// `[-lo, hi]`, so that both ends are rounded up by one vector operation.
#[inline(always)]
pub(crate) fn outward(x: Interval) -> Pair {
    Pair::new(-x.lo(), x.hi())
}

#[inline(always)]
pub(crate) fn inward(pair: Pair) -> Interval {
    Interval::raw(-pair.first(), pair.second())
}

impl Add for Interval {
    type Output = Interval;

    /// `[a, b] + [c, d] = [a + c, b + d]`. The infinite ends of the empty set never pass the fast way.
    #[inline]
    fn add(self, other: Interval) -> Interval {
        match sum_up(outward(self), outward(other)) {
            (sum, true) => inward(sum),
            _ => self.add_extreme(other),
        }
    }
}

impl Sub for Interval {
    type Output = Interval;

    /// `[a, b] - [c, d] = [a - d, b - c]`.
    #[inline]
    fn sub(self, other: Interval) -> Interval {
        match sum_up(outward(self), Pair::new(other.hi(), -other.lo())) {
            (sum, true) => inward(sum),
            _ => self.add_extreme(-other),
        }
    }
}

impl Mul for Interval {
    type Output = Interval;

    /// The products of `[a, b]` and `[c, d]`, by the signs of the ends:
    ///
    /// |            | `c >= 0`   | `d <= 0`   | `c < 0 < d`                    |
    /// |------------|------------|------------|--------------------------------|
    /// | `a >= 0`   | `[ac, bd]` | `[bc, ad]` | `[bc, bd]`                     |
    /// | `b <= 0`   | `[ad, bc]` | `[bd, ac]` | `[ad, ac]`                     |
    /// | `a < 0 < b`| `[ad, bd]` | `[bc, ac]` | `[min(ad, bc), max(ac, bd)]`   |
    ///
    /// Each choice contains an end of each factor, and the empty set has infinite ends only, which
    /// never pass the fast way.
    #[inline]
    fn mul(self, other: Interval) -> Interval {
        let ((a, b), (c, d)) = ((self.lo(), self.hi()), (other.lo(), other.hi()));
        let (product, holds) = if a >= 0.0 {
            let from = if c >= 0.0 { a } else { b };
            let to = if d <= 0.0 { a } else { b };
            product_up(Pair::new(-from, to), Pair::new(c, d))
        } else if b <= 0.0 {
            let from = if d <= 0.0 { b } else { a };
            let to = if c >= 0.0 { b } else { a };
            product_up(Pair::new(-from, to), Pair::new(d, c))
        } else if c >= 0.0 {
            product_up(Pair::new(-a, b), Pair::splat(d))
        } else if d <= 0.0 {
            product_up(Pair::new(-b, a), Pair::splat(c))
        } else {
            let (first, first_holds) = product_up(Pair::new(-a, a), Pair::new(d, c));
            let (second, second_holds) = product_up(Pair::new(-b, b), Pair::new(c, d));
            let most = Pair::new(
                larger(first.first(), second.first()),
                larger(first.second(), second.second()),
            );
            (most, first_holds & second_holds)
        };
        if holds {
            inward(product)
        } else {
            self.mul_extreme(other)
        }
    }
}

impl Div for Interval {
    type Output = Interval;

    /// All quotients `x / y` with `y != 0`, as their interval hull (IEEE 1788).
    ///
    /// A divisor `[0, 0]` gives the empty set; a divisor with zero inside gives all numbers, or
    /// `[0, 0]` for a zero dividend. A negative divisor is turned round: `x / y = -x / -y`.
    #[inline]
    fn div(self, other: Interval) -> Interval {
        let ((a, b), (c, d)) = ((self.lo(), self.hi()), (other.lo(), other.hi()));
        let (quotient, holds) = if c > 0.0 {
            let (under_a, under_b) = (if a >= 0.0 { d } else { c }, if b <= 0.0 { d } else { c });
            quotient_up(Pair::new(-a, b), Pair::new(under_a, under_b))
        } else if d < 0.0 {
            let (under_a, under_b) = (if a >= 0.0 { c } else { d }, if b <= 0.0 { c } else { d });
            quotient_up(Pair::new(-b, a), Pair::new(under_b, under_a))
        } else {
            return self.div_extreme(other);
        };
        if holds {
            inward(quotient)
        } else {
            self.div_extreme(other)
        }
    }
}

/// The exact ways, end by end, for empty, unbounded, very large and very small arguments.
impl Interval {
    #[inline(never)]
    fn add_extreme(self, other: Interval) -> Interval {
        if self.is_empty() || other.is_empty() {
            return Interval::EMPTY;
        }
        Interval::raw(
            add_down(self.lo(), other.lo()),
            add_up(self.hi(), other.hi()),
        )
    }

    /// The table of [`Mul`] with `0 * inf = 0`: the infinity is a bound of real numbers. The ends that
    /// the table leaves out cannot be beyond the others.
    #[inline(never)]
    fn mul_extreme(self, other: Interval) -> Interval {
        if self.is_empty() || other.is_empty() {
            return Interval::EMPTY;
        }
        let ((a, b), (c, d)) = ((self.lo(), self.hi()), (other.lo(), other.hi()));
        let lo = smaller(
            smaller(mul_down(a, c), mul_down(a, d)),
            smaller(mul_down(b, c), mul_down(b, d)),
        );
        let hi = larger(
            larger(mul_up(a, c), mul_up(a, d)),
            larger(mul_up(b, c), mul_up(b, d)),
        );
        Interval::raw(lo, hi)
    }

    #[inline(never)]
    fn div_extreme(self, other: Interval) -> Interval {
        if self.is_empty() || other.is_empty() || other == Interval::ZERO {
            return Interval::EMPTY;
        }
        if self == Interval::ZERO {
            return Interval::ZERO;
        }
        if other.lo() >= 0.0 {
            self.over_positive(other)
        } else if other.hi() <= 0.0 {
            (-self).over_positive(-other)
        } else {
            Interval::ENTIRE
        }
    }

    /// `[a, b] / [c, d]` for `0 <= c <= d`, `d > 0`, over the divisors that are not zero.
    ///
    /// The lower end is `a / d` for `a >= 0` and else `a / c`; the upper end `b / d` for `b <= 0` and
    /// else `b / c`. For `c = 0` the quotients over `c` are unbounded.
    fn over_positive(self, divisor: Interval) -> Interval {
        let ((a, b), (c, d)) = ((self.lo(), self.hi()), (divisor.lo(), divisor.hi()));
        let lo = if a >= 0.0 {
            div_down(a, d)
        } else if c > 0.0 {
            div_down(a, c)
        } else {
            f64::NEG_INFINITY
        };
        let hi = if b <= 0.0 {
            div_up(b, d)
        } else if c > 0.0 {
            div_up(b, c)
        } else {
            f64::INFINITY
        };
        Interval::raw(lo, hi)
    }
}

impl Interval {
    /// `1 / x` over the elements that are not zero.
    #[inline]
    pub fn recip(self) -> Interval {
        Interval::ONE / self
    }

    /// The square roots of the elements that are not negative.
    #[inline]
    pub fn sqrt(self) -> Interval {
        let x = self.intersect(Interval::NON_NEGATIVE);
        if x.is_empty() {
            x
        } else {
            Interval::raw(sqrt_down(x.lo()), sqrt_up(x.hi()))
        }
    }

    /// The absolute values of the elements, exactly.
    #[inline]
    pub fn abs(self) -> Interval {
        if self.is_empty() {
            self
        } else {
            Interval::raw(self.mig(), self.mag())
        }
    }

    /// The signs of the elements, where the sign of 0 is every number of `[-1, 1]` (the Filippov
    /// reading of a switching function).
    #[inline]
    pub fn sign(self) -> Interval {
        if self.is_empty() {
            return self;
        }
        let lo = if self.lo() > 0.0 { 1.0 } else { -1.0 };
        let hi = if self.hi() < 0.0 { -1.0 } else { 1.0 };
        Interval::raw(lo, hi)
    }

    /// The smaller of an element of each, exactly.
    #[inline]
    pub fn min(self, other: Interval) -> Interval {
        if self.is_empty() || other.is_empty() {
            return Interval::EMPTY;
        }
        Interval::raw(
            smaller(self.lo(), other.lo()),
            smaller(self.hi(), other.hi()),
        )
    }

    /// The larger of an element of each, exactly.
    #[inline]
    pub fn max(self, other: Interval) -> Interval {
        if self.is_empty() || other.is_empty() {
            return Interval::EMPTY;
        }
        Interval::raw(larger(self.lo(), other.lo()), larger(self.hi(), other.hi()))
    }
}

macro_rules! assign {
    ($($trait:ident $method:ident $operator:tt),+) => {$(
        impl $trait for Interval {
            #[inline]
            fn $method(&mut self, other: Interval) {
                *self = *self $operator other;
            }
        }
    )+};
}

assign!(AddAssign add_assign +, SubAssign sub_assign -, MulAssign mul_assign *, DivAssign div_assign /);
