//! Functions with whole-number values: rounding to integers, and the sign of IEEE 1788.
//!
//! *Guarantee*: all results are exact, the hull of the values at the ends, since the functions do not
//! decrease. Their jumps are told by [`crate::domain`].

use crate::Interval;

macro_rules! steps {
    ($($(#[doc = $what:literal])+ $name:ident $at:path;)+) => {
        impl Interval {$(
            $(#[doc = $what])+
            #[inline]
            pub fn $name(self) -> Interval {
                if self.is_empty() {
                    self
                } else {
                    Interval::raw($at(self.lo()), $at(self.hi()))
                }
            }
        )+}
    };
}

steps! {
    /// The elements rounded down to integers.
    floor f64::floor;
    /// The elements rounded up to integers.
    ceil f64::ceil;
    /// The elements rounded toward zero to integers.
    trunc f64::trunc;
    /// The elements rounded to the nearest integer, halves to the even one.
    round_ties_to_even f64::round_ties_even;
    /// The elements rounded to the nearest integer, halves away from zero.
    round_ties_to_away f64::round;
    /// The signs -1, 0 or 1 of the elements with `sign(0) = 0` (IEEE 1788 `sign`). The right-hand side of
    /// an inclusion wants [`Interval::sign`], which has all of `[-1, 1]` there.
    sign_with_zero sign;
}

fn sign(x: f64) -> f64 {
    if x > 0.0 {
        1.0
    } else if x < 0.0 {
        -1.0
    } else {
        0.0
    }
}
