//! Sine, cosine, tangent, arc sine and arc cosine.

use super::Value;
use crate::Interval;
use crate::interval::{larger, smaller};
use crate::period::Extremes;

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
        Value::near(core_math::tan(x))
    }
}

#[inline]
fn asin_at(x: f64) -> Value {
    if x == 0.0 {
        Value::ZERO
    } else {
        Value::with_sign_of(x, core_math::asin(x))
    }
}

#[inline]
fn acos_at(x: f64) -> Value {
    if x == 1.0 {
        Value::ZERO
    } else {
        Value::around(core_math::acos(x), 0.0, f64::INFINITY)
    }
}

impl Interval {
    /// The sines of the elements. Not a float but for 0 at 0 (Lindemann).
    ///
    /// The maxima lie at `π/2 + 2πm`, the minima at `3π/2 + 2πm`; between them sine is monotone, so
    /// the ends of the interval give the other bounds.
    #[inline]
    pub fn sin(self) -> Interval {
        self.wave(sin_at, 1)
    }

    /// The cosines of the elements; maxima at `2πm`, minima at `π + 2πm`. Not a float but for 1 at 0
    /// (Lindemann).
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

    /// The tangents of the elements; all numbers if a pole `π/2 + πm` lies in the interval. Not a float
    /// but for 0 at 0 (Lindemann).
    #[inline]
    pub fn tan(self) -> Interval {
        if self.is_empty() {
            return self;
        }
        if self.has_pole_of_tan() {
            Interval::ENTIRE
        } else {
            Interval::raw(tan_at(self.lo()).lo, tan_at(self.hi()).hi)
        }
    }

    /// True if an element is a pole `π/2 + πm` of the tangent. (No float is one.)
    #[inline]
    pub(crate) fn has_pole_of_tan(self) -> bool {
        Extremes::of(self).is_none_or(|extremes| extremes.include(1) || extremes.include(3))
    }

    /// The principal arc sines of the elements in `[-1, 1]`, inside `[-π/2, π/2]` rounded outward. Not a
    /// float but for 0 at 0 (Lindemann).
    #[inline]
    pub fn asin(self) -> Interval {
        self.increasing(Interval::UNIT, asin_at)
    }

    /// The principal arc cosines of the elements in `[-1, 1]`, inside `[0, π]` rounded outward. Not a
    /// float but for 0 at 1 (Lindemann).
    #[inline]
    pub fn acos(self) -> Interval {
        let x = self.intersect(Interval::UNIT);
        if x.is_empty() {
            return x;
        }
        Interval::raw(acos_at(x.hi()).lo, acos_at(x.lo()).hi)
    }
}
