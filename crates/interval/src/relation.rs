//! Relations of two intervals as sets, with the meaning of IEEE 1788: plain truth values about the ends.
//!
//! For claims about unknown elements see [`crate::Truth`]. All answers are exact.

use std::cmp::Ordering;

use crate::Interval;

/// How two intervals lie to each other (IEEE 1788 `overlap`, after Allen): the name tells where the first
/// one is.
///
/// ```
/// use veribound_interval::{Interval, Overlap};
///
/// let of = |lo, hi| Interval::new(lo, hi).unwrap();
/// assert_eq!(of(1.0, 2.0).overlap(of(2.0, 3.0)), Overlap::Meets);
/// assert_eq!(of(1.0, 2.0).overlap(of(0.0, 3.0)), Overlap::ContainedBy);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Overlap {
    /// Neither has an element.
    BothEmpty,
    /// Only the second has elements.
    FirstEmpty,
    /// Only the first has elements.
    SecondEmpty,
    /// All elements are below those of the second.
    Before,
    /// It ends where the second begins, and nothing else is common.
    Meets,
    /// It begins below the second and ends inside.
    Overlaps,
    /// Same lower end, ends inside the second.
    Starts,
    /// It lies inside the second, with no common end.
    ContainedBy,
    /// Same upper end, begins inside the second.
    Finishes,
    /// The same set.
    Equals,
    /// Same upper end, begins below the second.
    FinishedBy,
    /// The second lies inside, with no common end.
    Contains,
    /// Same lower end, ends above the second.
    StartedBy,
    /// It begins inside the second and ends above.
    OverlappedBy,
    /// It begins where the second ends, and nothing else is common.
    MetBy,
    /// All elements are above those of the second.
    After,
}

impl Interval {
    /// True if no element is common; true for an empty set.
    #[inline]
    pub fn is_disjoint_from(self, other: Interval) -> bool {
        !self.intersects(other)
    }

    /// True for the set of all real numbers.
    #[inline]
    pub fn is_entire(self) -> bool {
        self == Interval::ENTIRE
    }

    /// IEEE 1788 `less`: for every element of each set there is one of the other on the right side,
    /// `lo <= lo'` and `hi <= hi'`. Two empty sets are so related, one is not.
    #[inline]
    pub fn is_weakly_less(self, other: Interval) -> bool {
        self.is_empty() == other.is_empty() && {
            self.is_empty() || (self.lo() <= other.lo() && self.hi() <= other.hi())
        }
    }

    /// IEEE 1788 `strictLess`: as [`Interval::is_weakly_less`] with strict inequalities, where ends that
    /// are the same infinity count as less.
    #[inline]
    pub fn is_strictly_less(self, other: Interval) -> bool {
        let less = |a: f64, b: f64| a < b || (a == b && a.is_infinite());
        self.is_empty() == other.is_empty()
            && (self.is_empty() || (less(self.lo(), other.lo()) && less(self.hi(), other.hi())))
    }

    /// IEEE 1788 `precedes`: no element is above one of the other set; true for an empty set.
    #[inline]
    pub fn precedes(self, other: Interval) -> bool {
        self.is_empty() || other.is_empty() || self.hi() <= other.lo()
    }

    /// IEEE 1788 `strictPrecedes`: all elements are below all of the other set; true for an empty set.
    #[inline]
    pub fn strictly_precedes(self, other: Interval) -> bool {
        self.is_empty() || other.is_empty() || self.hi() < other.lo()
    }

    /// How `self` lies to `other`: exactly one of sixteen answers.
    pub fn overlap(self, other: Interval) -> Overlap {
        match (self.is_empty(), other.is_empty()) {
            (true, true) => return Overlap::BothEmpty,
            (true, false) => return Overlap::FirstEmpty,
            (false, true) => return Overlap::SecondEmpty,
            (false, false) => {}
        }
        let ((a, b), (c, d)) = ((self.lo(), self.hi()), (other.lo(), other.hi()));
        if b < c {
            return Overlap::Before;
        }
        if d < a {
            return Overlap::After;
        }
        if b == c && a < b && c < d {
            return Overlap::Meets;
        }
        if d == a && c < d && a < b {
            return Overlap::MetBy;
        }
        // Ends are never NaN.
        let order = |x: f64, y: f64| x.partial_cmp(&y).unwrap_or(Ordering::Equal);
        match (order(a, c), order(b, d)) {
            (Ordering::Less, Ordering::Less) => Overlap::Overlaps,
            (Ordering::Equal, Ordering::Less) => Overlap::Starts,
            (Ordering::Greater, Ordering::Less) => Overlap::ContainedBy,
            (Ordering::Greater, Ordering::Equal) => Overlap::Finishes,
            (Ordering::Equal, Ordering::Equal) => Overlap::Equals,
            (Ordering::Less, Ordering::Equal) => Overlap::FinishedBy,
            (Ordering::Less, Ordering::Greater) => Overlap::Contains,
            (Ordering::Equal, Ordering::Greater) => Overlap::StartedBy,
            (Ordering::Greater, Ordering::Greater) => Overlap::OverlappedBy,
        }
    }
}
