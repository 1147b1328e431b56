//! Interval elementary functions on top of CORE-MATH.
//!
//! CORE-MATH returns the float nearest to the true value (proved correctly rounded by its authors).
//! The true value of these functions at a nonzero float is never a float (Lindemann, Baker), save
//! for the few points handled by name, so the neighbours of the returned float enclose it. The
//! argument needs an error below one unit in the last place only: a merely faithful library would do.
//!
//! *Guarantee* of every function here: the result contains `f(x)` for all elements `x` where `f` is
//! defined, and each end is at most one float further out than the tight one.

use crate::Interval;
use crate::interval::{larger, smaller};
use crate::period::Extremes;

/// Bounds of one function value at a finite float.
#[derive(Clone, Copy)]
struct Value {
    lo: f64,
    hi: f64,
}

impl Value {
    const ZERO: Value = Value { lo: 0.0, hi: 0.0 };
    const ONE: Value = Value { lo: 1.0, hi: 1.0 };

    /// The neighbours of a float that was rounded to nearest, cut by bounds that are known to hold.
    /// Beyond the largest float `next_up` keeps the infinity and `next_down` gives the largest float.
    #[inline]
    fn around(rounded: f64, least: f64, most: f64) -> Value {
        Value {
            lo: larger(rounded.next_down(), least),
            hi: smaller(rounded.next_up(), most),
        }
    }
}

#[inline]
fn exp_at(x: f64) -> Value {
    if x == 0.0 {
        Value::ONE
    } else if x > 0.0 {
        Value::around(core_math::exp(x), 1.0, f64::INFINITY)
    } else {
        Value::around(core_math::exp(x), 0.0, 1.0)
    }
}

#[inline]
fn ln_at(x: f64) -> Value {
    if x == 1.0 {
        Value::ZERO
    } else {
        Value::around(core_math::log(x), f64::NEG_INFINITY, f64::INFINITY)
    }
}

#[inline]
fn atan_at(x: f64) -> Value {
    between_zero_and(x, core_math::atan(x))
}

#[inline]
fn tanh_at(x: f64) -> Value {
    let value = between_zero_and(x, core_math::tanh(x));
    Value {
        lo: larger(value.lo, -1.0),
        hi: smaller(value.hi, 1.0),
    }
}

/// For the functions with `0 < f(x) < x` for `x > 0` and odd symmetry (`atan`, `tanh`).
#[inline]
fn between_zero_and(x: f64, rounded: f64) -> Value {
    if x == 0.0 {
        Value::ZERO
    } else if x > 0.0 {
        Value::around(rounded, 0.0, x)
    } else {
        Value::around(rounded, x, 0.0)
    }
}

#[inline]
fn sin_at(x: f64) -> Value {
    if x == 0.0 {
        Value::ZERO
    } else {
        Value::around(core_math::sin(x), -1.0, 1.0)
    }
}

#[inline]
fn cos_at(x: f64) -> Value {
    if x == 0.0 {
        Value::ONE
    } else {
        Value::around(core_math::cos(x), -1.0, 1.0)
    }
}

#[inline]
fn tan_at(x: f64) -> Value {
    if x == 0.0 {
        Value::ZERO
    } else {
        Value::around(core_math::tan(x), f64::NEG_INFINITY, f64::INFINITY)
    }
}

impl Interval {
    /// The exponentials of the elements.
    #[inline]
    pub fn exp(self) -> Interval {
        if self.is_empty() {
            return self;
        }
        let lo = if self.lo().is_infinite() {
            0.0
        } else {
            exp_at(self.lo()).lo
        };
        let hi = if self.hi().is_infinite() {
            f64::INFINITY
        } else {
            exp_at(self.hi()).hi
        };
        Interval::raw(lo, hi)
    }

    /// The natural logarithms of the positive elements.
    #[inline]
    pub fn ln(self) -> Interval {
        if self.hi() <= 0.0 {
            return Interval::EMPTY;
        }
        if self.is_empty() {
            return self;
        }
        let lo = if self.lo() <= 0.0 {
            f64::NEG_INFINITY
        } else {
            ln_at(self.lo()).lo
        };
        let hi = if self.hi().is_infinite() {
            f64::INFINITY
        } else {
            ln_at(self.hi()).hi
        };
        Interval::raw(lo, hi)
    }

    /// The arc tangents of the elements.
    #[inline]
    pub fn atan(self) -> Interval {
        if self.is_empty() {
            return self;
        }
        // CORE-MATH gives the rounded limits ±π/2 and ±1 at infinity, whose neighbours bound them.
        Interval::raw(atan_at(self.lo()).lo, atan_at(self.hi()).hi)
    }

    /// The hyperbolic tangents of the elements.
    #[inline]
    pub fn tanh(self) -> Interval {
        if self.is_empty() {
            return self;
        }
        Interval::raw(tanh_at(self.lo()).lo, tanh_at(self.hi()).hi)
    }

    /// The sines of the elements.
    ///
    /// The maxima lie at `π/2 + 2πm`, the minima at `3π/2 + 2πm`; between them sine is monotone, so
    /// the ends of the interval give the other bounds.
    #[inline]
    pub fn sin(self) -> Interval {
        self.wave(sin_at, 1)
    }

    /// The cosines of the elements; maxima at `2πm`, minima at `π + 2πm`.
    #[inline]
    pub fn cos(self) -> Interval {
        self.wave(cos_at, 0)
    }

    /// A function with range `[-1, 1]`, maxima at the multiples `maximum + 4m` of `π/2` and minima
    /// half a period further.
    #[inline]
    fn wave(self, at: impl Fn(f64) -> Value, maximum: u8) -> Interval {
        if self.is_empty() {
            return self;
        }
        let Some(extremes) = Extremes::of(self) else {
            return Interval::UNIT;
        };
        let (first, last) = (at(self.lo()), at(self.hi()));
        let hi = if extremes.include(maximum) {
            1.0
        } else {
            larger(first.hi, last.hi)
        };
        let lo = if extremes.include(maximum ^ 2) {
            -1.0
        } else {
            smaller(first.lo, last.lo)
        };
        Interval::raw(lo, hi)
    }

    /// The tangents of the elements; all numbers if a pole `π/2 + πm` lies in the interval.
    #[inline]
    pub fn tan(self) -> Interval {
        if self.is_empty() {
            return self;
        }
        match Extremes::of(self) {
            Some(extremes) if !extremes.include(1) && !extremes.include(3) => {
                Interval::raw(tan_at(self.lo()).lo, tan_at(self.hi()).hi)
            }
            _ => Interval::ENTIRE,
        }
    }

    /// The principal arc sines of the elements in `[-1, 1]`, inside `[-π/2, π/2]` rounded outward.
    pub(crate) fn asin(self) -> Interval {
        self.unit_inverse(core_math::asin, 0.0, false)
    }

    /// The principal arc cosines of the elements in `[-1, 1]`, inside `[0, π]` rounded outward.
    pub(crate) fn acos(self) -> Interval {
        self.unit_inverse(core_math::acos, 1.0, true)
    }

    /// A monotone function on `[-1, 1]` that is zero at `root` and transcendental elsewhere.
    fn unit_inverse(self, f: fn(f64) -> f64, root: f64, decreasing: bool) -> Interval {
        let x = self.intersect(Interval::UNIT);
        if x.is_empty() {
            return x;
        }
        let at = |x: f64| {
            if x == root {
                Value::ZERO
            } else {
                Value::around(f(x), f64::NEG_INFINITY, f64::INFINITY)
            }
        };
        let (first, last) = if decreasing {
            (x.hi(), x.lo())
        } else {
            (x.lo(), x.hi())
        };
        Interval::raw(at(first).lo, at(last).hi)
    }

    /// The area tangents of the elements in `(-1, 1)`.
    pub(crate) fn atanh(self) -> Interval {
        if self.is_empty() || self.lo() >= 1.0 || self.hi() <= -1.0 {
            return Interval::EMPTY;
        }
        let at = |x: f64| {
            if x == 0.0 {
                Value::ZERO
            } else {
                Value::around(core_math::atanh(x), f64::NEG_INFINITY, f64::INFINITY)
            }
        };
        let lo = if self.lo() <= -1.0 {
            f64::NEG_INFINITY
        } else {
            at(self.lo()).lo
        };
        let hi = if self.hi() >= 1.0 {
            f64::INFINITY
        } else {
            at(self.hi()).hi
        };
        Interval::raw(lo, hi)
    }
}
