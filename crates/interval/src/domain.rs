//! Where an operation is defined and continuous on the whole argument.
//!
//! Interval evaluation of a partial function leaves out the elements where it is undefined. Existence
//! theorems (Picard, Brouwer) need a function that is defined and continuous on the whole set, so a
//! caller that relies on them asks here first. All answers are false for the empty set.

use crate::Interval;

impl Interval {
    /// The square root is defined and continuous on every element: `lo >= 0`.
    #[inline]
    pub fn sqrt_defined(self) -> bool {
        self.lo() >= 0.0 && !self.is_empty()
    }

    /// The square root is differentiable on every element: `lo > 0`.
    #[inline]
    pub fn sqrt_smooth(self) -> bool {
        self.lo() > 0.0 && !self.is_empty()
    }

    /// The logarithm is defined and continuous on every element: `lo > 0`.
    #[inline]
    pub fn ln_defined(self) -> bool {
        self.sqrt_smooth()
    }

    /// Division by every element is defined and continuous: 0 is no element.
    #[inline]
    pub fn recip_defined(self) -> bool {
        (self.lo() > 0.0 || self.hi() < 0.0) && !self.is_empty()
    }

    /// The `n`-th power is defined and continuous on every element.
    #[inline]
    pub fn powi_defined(self, n: i32) -> bool {
        !self.is_empty() && (n >= 0 || self.recip_defined())
    }

    /// The tangent is defined and continuous on every element: no pole is proved or suspected inside.
    #[inline]
    pub fn tan_continuous(self) -> bool {
        !self.is_empty() && self.tan() != Interval::ENTIRE
    }

    /// The sign is one constant on the whole set: 0 is no element.
    #[inline]
    pub fn sign_continuous(self) -> bool {
        self.recip_defined()
    }

    /// The absolute value is differentiable on every element: 0 is no element.
    #[inline]
    pub fn abs_smooth(self) -> bool {
        self.recip_defined()
    }
}
