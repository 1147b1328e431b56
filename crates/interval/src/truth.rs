//! Three-valued truth, and comparisons of intervals.

use std::ops::Not;

use crate::Interval;

/// What is known about a claim on unknown numbers that lie in known intervals.
///
/// ```
/// use veribound_interval::{Interval, Truth};
///
/// let (x, y) = (Interval::new(0.0, 2.0).unwrap(), Interval::new(1.0, 3.0).unwrap());
/// assert_eq!(x.less(y), Truth::Unknown);
/// assert_eq!(x.less(y + Interval::point(2.0)), Truth::True);
/// assert!(Truth::True.and(Truth::Unknown).is_possible());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Truth {
    /// The claim holds for all numbers in the intervals.
    True,
    /// The claim holds for no numbers in the intervals.
    False,
    /// Neither is proved.
    Unknown,
}

impl Truth {
    /// True if the claim is proved.
    #[inline]
    pub fn is_true(self) -> bool {
        self == Truth::True
    }

    /// True if the claim is refuted.
    #[inline]
    pub fn is_false(self) -> bool {
        self == Truth::False
    }

    /// True unless the claim is refuted.
    #[inline]
    pub fn is_possible(self) -> bool {
        self != Truth::False
    }

    /// Both claims hold.
    #[inline]
    pub fn and(self, other: Truth) -> Truth {
        match (self, other) {
            (Truth::False, _) | (_, Truth::False) => Truth::False,
            (Truth::True, Truth::True) => Truth::True,
            _ => Truth::Unknown,
        }
    }

    /// At least one claim holds.
    #[inline]
    pub fn or(self, other: Truth) -> Truth {
        !(!self).and(!other)
    }

    #[inline]
    fn decide(proved: bool, refuted: bool) -> Truth {
        if proved {
            Truth::True
        } else if refuted {
            Truth::False
        } else {
            Truth::Unknown
        }
    }
}

impl Not for Truth {
    type Output = Truth;

    #[inline]
    fn not(self) -> Truth {
        match self {
            Truth::True => Truth::False,
            Truth::False => Truth::True,
            Truth::Unknown => Truth::Unknown,
        }
    }
}

impl From<bool> for Truth {
    fn from(claim: bool) -> Truth {
        if claim { Truth::True } else { Truth::False }
    }
}

/// Comparisons. *Guarantee*: `True` means the relation holds for every pair of elements, `False` for
/// none. An empty argument gives `Unknown`: nothing is claimed about numbers that do not exist.
impl Interval {
    /// `x < y`.
    #[inline]
    pub fn less(self, other: Interval) -> Truth {
        if self.is_empty() || other.is_empty() {
            return Truth::Unknown;
        }
        Truth::decide(self.hi() < other.lo(), self.lo() >= other.hi())
    }

    /// `x <= y`.
    #[inline]
    pub fn less_equal(self, other: Interval) -> Truth {
        !other.less(self)
    }

    /// `x > y`.
    #[inline]
    pub fn greater(self, other: Interval) -> Truth {
        other.less(self)
    }

    /// `x >= y`.
    #[inline]
    pub fn greater_equal(self, other: Interval) -> Truth {
        !self.less(other)
    }

    /// `x = y`: proved for two equal points, refuted for disjoint intervals.
    #[inline]
    pub fn equal(self, other: Interval) -> Truth {
        if self.is_empty() || other.is_empty() {
            return Truth::Unknown;
        }
        let points = self.is_point() && self == other;
        Truth::decide(points, !self.intersects(other))
    }
}
