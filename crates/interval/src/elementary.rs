//! Interval elementary functions on top of CORE-MATH.
//!
//! CORE-MATH returns the float nearest to the true value (proved correctly rounded by its authors).
//! Each function here has an argument why its true value is a float only at few points, which are
//! handled by name; elsewhere the true value is not the returned float, so its neighbours enclose it. The
//! argument needs an error below one unit in the last place only: a merely faithful library would do.
//!
//! Two facts carry these arguments. (1) Lindemann: for algebraic `x != 0` the numbers `exp x`, `sin x`,
//! `cos x`, `tan x`, `sinh x`, `cosh x`, `tanh x` are transcendental, and so are the inverse functions at
//! algebraic numbers where their value is not 0 (else the function at that value would be transcendental,
//! but it is the algebraic number). Floats are algebraic, and no float is transcendental. (2) Bases 2
//! and 10: `b^(p/q)` in lowest terms with `q > 1` is irrational, since its `q`-th power `b^p` is no
//! `q`-th power of a rational; and a rational logarithm `p/q` of a rational `x` means `x^q = b^p`,
//! so `x` is an integer power of `b`.
//!
//! *Guarantee* of every function here: the result contains `f(x)` for all elements `x` where `f` is
//! defined, it is empty exactly where there is none, and each end is at most one float further out than
//! the tight one. Larger arguments give larger results.

mod arctangent;
mod exponential;
mod hyperbolic;
mod logarithm;
mod trigonometric;

use crate::Interval;
use crate::interval::{larger, smaller};

/// Bounds of one function value, or of its limit at an infinite end.
#[derive(Clone, Copy)]
pub(crate) struct Value {
    pub(crate) lo: f64,
    pub(crate) hi: f64,
}

impl Value {
    const ZERO: Value = Value::exactly(0.0);
    pub(crate) const ONE: Value = Value::exactly(1.0);
    /// The limit `+inf`.
    pub(crate) const ABOVE: Value = Value {
        lo: f64::MAX,
        hi: f64::INFINITY,
    };

    pub(crate) const fn exactly(x: f64) -> Value {
        Value { lo: x, hi: x }
    }

    /// The neighbours of a float that was rounded to nearest, cut by bounds that are known to hold.
    /// Beyond the largest float `next_up` keeps the infinity and `next_down` gives the largest float.
    #[inline]
    pub(crate) fn around(rounded: f64, least: f64, most: f64) -> Value {
        Value {
            lo: larger(rounded.next_down(), least),
            hi: smaller(rounded.next_up(), most),
        }
    }

    /// The same for a value of which nothing else is known.
    #[inline]
    fn near(rounded: f64) -> Value {
        Value::around(rounded, f64::NEG_INFINITY, f64::INFINITY)
    }

    /// The same for a value that has the sign of `x`.
    #[inline]
    fn with_sign_of(x: f64, rounded: f64) -> Value {
        if x > 0.0 {
            Value::around(rounded, 0.0, f64::INFINITY)
        } else {
            Value::around(rounded, f64::NEG_INFINITY, 0.0)
        }
    }

    /// For a float that was rounded from a value that is not this float: the neighbours on the one side
    /// where the value is known to be.
    #[inline]
    fn beside(rounded: f64, above: bool) -> Value {
        if above {
            Value::around(rounded, rounded, f64::INFINITY)
        } else {
            Value::around(rounded, f64::NEG_INFINITY, rounded)
        }
    }
}

impl Interval {
    /// The range of an increasing function that is defined on `domain`, given at floats and, where
    /// the domain reaches there, in the limit at infinity.
    #[inline]
    fn increasing(self, domain: Interval, at: impl Fn(f64) -> Value) -> Interval {
        let x = self.intersect(domain);
        if x.is_empty() {
            return x;
        }
        Interval::raw(at(x.lo()).lo, at(x.hi()).hi)
    }

    /// The range of an increasing function on an open interval at whose ends it is unbounded.
    #[inline]
    fn increasing_between_poles(
        self,
        first: f64,
        last: f64,
        at: impl Fn(f64) -> Value,
    ) -> Interval {
        if self.is_empty() || self.lo() >= last || self.hi() <= first {
            return Interval::EMPTY;
        }
        let lo = if self.lo() <= first {
            f64::NEG_INFINITY
        } else {
            at(self.lo()).lo
        };
        let hi = if self.hi() >= last {
            f64::INFINITY
        } else {
            at(self.hi()).hi
        };
        Interval::raw(lo, hi)
    }
}
