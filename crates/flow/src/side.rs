//! Lower and upper bounds treated by one piece of code.

use veribound_interval::lanes::{Floats, Interval8, Mask};
use veribound_interval::{Interval, round};

/// Which bound of an interval. *Out* is away from the interval: down for the lower bound, up for
/// the upper one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Side {
    Lower,
    Upper,
}

impl Side {
    pub(crate) const BOTH: [Side; 2] = [Side::Lower, Side::Upper];

    pub(crate) fn index(self) -> usize {
        match self {
            Side::Lower => 0,
            Side::Upper => 1,
        }
    }

    pub(crate) fn other(self) -> Side {
        match self {
            Side::Lower => Side::Upper,
            Side::Upper => Side::Lower,
        }
    }

    /// The end of `x` on this side.
    pub(crate) fn end(self, x: Interval) -> f64 {
        match self {
            Side::Lower => x.lo(),
            Side::Upper => x.hi(),
        }
    }

    /// True when `a` lies further out than `b`.
    pub(crate) fn beyond(self, a: f64, b: f64) -> bool {
        match self {
            Side::Lower => a < b,
            Side::Upper => a > b,
        }
    }

    /// [`Side::beyond`] in every lane.
    pub(crate) fn all_beyond(self, a: &Floats, b: &Floats) -> Mask {
        match self {
            Side::Lower => Mask::below(a, b),
            Side::Upper => Mask::below(b, a),
        }
    }

    /// The one of `a` and `b` that lies further out.
    pub(crate) fn outer(self, a: f64, b: f64) -> f64 {
        if self.beyond(a, b) { a } else { b }
    }

    /// The one of `a` and `b` that lies further in.
    pub(crate) fn inner(self, a: f64, b: f64) -> f64 {
        self.other().outer(a, b)
    }

    /// The ends of `x` on this side.
    pub(crate) fn ends(self, x: &Interval8) -> Floats {
        match self {
            Side::Lower => x.lo(),
            Side::Upper => x.hi(),
        }
    }

    /// From `a` out to `b`; empty where `b` lies further in than `a`.
    pub(crate) fn between(self, a: &Floats, b: &Floats) -> Interval8 {
        match self {
            Side::Lower => Interval8::between(*b, *a),
            Side::Upper => Interval8::between(*a, *b),
        }
    }
}

/// A time no later than the one at which something of the speed `rate` has covered `distance`.
pub(crate) fn earliest(distance: Interval, rate: f64) -> f64 {
    round::div_down(distance.mig(), rate.abs())
}

/// A time no earlier than the one at which something of the speed `rate` has covered `distance`.
pub(crate) fn latest(distance: Interval, rate: f64) -> f64 {
    round::div_up(distance.mag(), rate.abs())
}
