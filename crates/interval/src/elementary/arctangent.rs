//! The arc tangent, and the angle of a point in the plane.

use super::Value;
use crate::Interval;

/// `π/2`: halves of the bounds of π.
const QUARTER: Value = Value {
    lo: std::f64::consts::FRAC_PI_2,
    hi: std::f64::consts::FRAC_PI_2.next_up(),
};

/// `π`.
const HALF: Value = Value {
    lo: std::f64::consts::PI,
    hi: std::f64::consts::PI.next_up(),
};

/// Also for infinities, where CORE-MATH gives the rounded limits ±π/2, whose neighbours bound them.
#[inline]
fn atan_at(x: f64) -> Value {
    if x == 0.0 {
        Value::ZERO
    } else if x > 0.0 {
        Value::around(core_math::atan(x), 0.0, x)
    } else {
        Value::around(core_math::atan(x), x, 0.0)
    }
}

/// The angle of `(x, y)` with `y >= 0`, not the origin, in the limit at infinities where the other
/// coordinate is finite: `[0, π]`.
///
/// Not a float off the axes: the angle is 0, π or ±π/2 plus the arc tangent of a rational number other
/// than 0, and `tan` of it, again rational, would be transcendental were it a float (Lindemann).
fn angle(y: f64, x: f64) -> Value {
    if y == 0.0 || x.is_infinite() {
        if x > 0.0 { Value::ZERO } else { HALF }
    } else if x == 0.0 || y.is_infinite() {
        QUARTER
    } else {
        let least = if x > 0.0 { 0.0 } else { QUARTER.lo };
        let most = if x > 0.0 { QUARTER.hi } else { HALF.hi };
        Value::around(core_math::atan2(y, x), least, most)
    }
}

impl Interval {
    /// The arc tangents of the elements, inside `[-π/2, π/2]` rounded outward. Not a float but for 0 at 0
    /// (Lindemann).
    #[inline]
    pub fn atan(self) -> Interval {
        self.increasing(Interval::ENTIRE, atan_at)
    }

    /// The angles in `(-π, π]` of the points with `y` in `self` and `x` in the argument, without the
    /// origin, whose angle does not exist.
    ///
    /// The angle is 0 on the positive and π on the negative half of the axis `y = 0`; a set that
    /// crosses the latter, or touches it from below and holds more, has angles up to both `-π` and π.
    /// Ends are at most one float further out than the tight ones.
    ///
    /// Above the axis the angle decreases with `x`, and with `y` it increases for `x > 0` and
    /// decreases for `x < 0`. The extremes over a box are therefore at its corners; where the sign of
    /// `x` changes the corner on the axis holds. Below, `angle(-y, x) = -angle(y, x)`.
    pub fn atan2(self, x: Interval) -> Interval {
        let above = angles_above(self.intersect(Interval::NON_NEGATIVE), x);
        if self.lo() >= 0.0 {
            return above;
        }
        // The points below the axis; where they reach it, their angles have the limits 0 and -π.
        let below = angles_above((-self).intersect(Interval::NON_NEGATIVE), x);
        above.hull(-below)
    }
}

/// The angles of the points other than the origin in a box with `0 <= y`.
fn angles_above(y: Interval, x: Interval) -> Interval {
    if y.is_empty() || x.is_empty() || (y == Interval::ZERO && x == Interval::ZERO) {
        return Interval::EMPTY;
    }
    let ((bottom, top), (left, right)) = ((y.lo(), y.hi()), (x.lo(), x.hi()));
    let lo = if right > 0.0 {
        angle(bottom, right).lo
    } else {
        angle(top, right).lo
    };
    let hi = if left < 0.0 {
        angle(bottom, left).hi
    } else if top == 0.0 {
        // Of the positive half of the axis, which may begin at the origin.
        0.0
    } else {
        angle(top, left).hi
    };
    Interval::raw(lo, hi)
}
