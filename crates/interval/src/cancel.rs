//! Taking a summand back out of a sum: `z` from `x = y + z` and `y`.

use std::cmp::Ordering;

use num_rational::BigRational;

use crate::Interval;
use crate::round::{sub_down, sub_up};

impl Interval {
    /// The smallest `z` such that `other + z`, in exact arithmetic, contains `self` (IEEE 1788
    /// `cancelMinus`): `[a - c, b - d]` for `[a, b]` and `[c, d]`, with tight ends.
    ///
    /// All numbers where there is no such `z`: if `other` is wider, unbounded, or empty beside a
    /// nonempty `self`. Empty for an empty `self` and a bounded or empty `other`.
    ///
    /// Unlike `self - other` this is no function of unknown elements. It is right only if `self` is known
    /// to be a sum with `other` as one summand.
    pub fn cancel_minus(self, other: Interval) -> Interval {
        let ((a, b), (c, d)) = ((self.lo(), self.hi()), (other.lo(), other.hi()));
        if self.is_empty() && (other.is_empty() || other.is_bounded()) {
            Interval::EMPTY
        } else if !self.is_bounded()
            || !other.is_bounded()
            || compare_widths(self, other) == Ordering::Less
        {
            Interval::ENTIRE
        } else {
            Interval::raw(sub_down(a, c), sub_up(b, d))
        }
    }

    /// The smallest `z` such that `z - other` contains `self` (IEEE 1788 `cancelPlus`):
    /// [`Interval::cancel_minus`] of `-other`.
    pub fn cancel_plus(self, other: Interval) -> Interval {
        self.cancel_minus(-other)
    }
}

/// The exact order of the widths of two bounded intervals. Tight bounds that differ tell it; those of equal
/// or nearly equal widths do not.
fn compare_widths(x: Interval, y: Interval) -> Ordering {
    let bounds = |x: Interval| (sub_down(x.hi(), x.lo()), sub_up(x.hi(), x.lo()));
    let ((least_x, most_x), (least_y, most_y)) = (bounds(x), bounds(y));
    if most_x < least_y {
        return Ordering::Less;
    }
    if most_y < least_x {
        return Ordering::Greater;
    }
    // All ends are finite, so there is an exact width.
    let width = |x: Interval| {
        let end = BigRational::from_float;
        end(x.hi()).zip(end(x.lo())).map(|(hi, lo)| hi - lo)
    };
    width(x).cmp(&width(y))
}
