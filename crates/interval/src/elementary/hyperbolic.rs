//! Hyperbolic functions and their inverses.

use super::Value;
use crate::Interval;

/// Also for infinities, where CORE-MATH gives the limit itself.
#[inline]
fn sinh_at(x: f64) -> Value {
    if x == 0.0 {
        Value::ZERO
    } else if x > 0.0 {
        Value::around(core_math::sinh(x), x, f64::INFINITY)
    } else {
        Value::around(core_math::sinh(x), f64::NEG_INFINITY, x)
    }
}

#[inline]
fn cosh_at(x: f64) -> Value {
    if x == 0.0 {
        Value::ONE
    } else {
        Value::around(core_math::cosh(x), 1.0, f64::INFINITY)
    }
}

/// At infinities CORE-MATH gives the limits ±1, beyond which no neighbour passes.
#[inline]
fn tanh_at(x: f64) -> Value {
    if x == 0.0 {
        Value::ZERO
    } else if x > 0.0 {
        Value::around(core_math::tanh(x), 0.0, x.min(1.0))
    } else {
        Value::around(core_math::tanh(x), x.max(-1.0), 0.0)
    }
}

#[inline]
fn asinh_at(x: f64) -> Value {
    if x == 0.0 {
        Value::ZERO
    } else if x > 0.0 {
        Value::around(core_math::asinh(x), 0.0, x)
    } else {
        Value::around(core_math::asinh(x), x, 0.0)
    }
}

#[inline]
fn acosh_at(x: f64) -> Value {
    if x == 1.0 {
        Value::ZERO
    } else {
        Value::around(core_math::acosh(x), 0.0, f64::INFINITY)
    }
}

#[inline]
fn atanh_at(x: f64) -> Value {
    if x == 0.0 {
        Value::ZERO
    } else if x > 0.0 {
        Value::around(core_math::atanh(x), x, f64::INFINITY)
    } else {
        Value::around(core_math::atanh(x), f64::NEG_INFINITY, x)
    }
}

// Lindemann: none of the values is a float but those named.
impl Interval {
    /// The hyperbolic sines of the elements; exact at 0.
    #[inline]
    pub fn sinh(self) -> Interval {
        self.increasing(Interval::ENTIRE, sinh_at)
    }

    /// The hyperbolic cosines of the elements; exact at 0, where the minimum 1 lies.
    #[inline]
    pub fn cosh(self) -> Interval {
        self.abs().increasing(Interval::ENTIRE, cosh_at)
    }

    /// The hyperbolic tangents of the elements; exact at 0.
    #[inline]
    pub fn tanh(self) -> Interval {
        self.increasing(Interval::ENTIRE, tanh_at)
    }

    /// The area hyperbolic sines of the elements; exact at 0.
    #[inline]
    pub fn asinh(self) -> Interval {
        self.increasing(Interval::ENTIRE, asinh_at)
    }

    /// The area hyperbolic cosines `>= 0` of the elements `>= 1`; exact at 1.
    #[inline]
    pub fn acosh(self) -> Interval {
        self.increasing(Interval::FROM_ONE, acosh_at)
    }

    /// The area hyperbolic tangents of the elements in `(-1, 1)`; exact at 0.
    #[inline]
    pub fn atanh(self) -> Interval {
        self.increasing_between_poles(-1.0, 1.0, atanh_at)
    }
}
