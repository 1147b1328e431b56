//! Reverse operations of elementary functions that are monotone, or even.

use super::both_signs;
use crate::Interval;

/// `[-π/2, π/2]` and `[0, π]`, rounded outward: the values of arc sine and arc cosine.
const ARC_SINES: Interval = Interval::raw(
    -std::f64::consts::FRAC_PI_2.next_up(),
    std::f64::consts::FRAC_PI_2.next_up(),
);
const ARC_COSINES: Interval = Interval::raw(0.0, std::f64::consts::PI.next_up());

macro_rules! inverse {
    ($($(#[doc = $what:literal])+ $name:ident $inverse:ident;)+) => {
        impl Interval {$(
            $(#[doc = $what])+
            #[inline]
            pub fn $name(c: Interval, x: Interval) -> Interval {
                x.intersect(c.$inverse())
            }
        )+}
    };
}

inverse! {
    /// `{x : exp(x) in c}`.
    exp_rev ln;
    /// `{x : 2^x in c}`.
    exp2_rev log2;
    /// `{x : 10^x in c}`.
    exp10_rev log10;
    /// `{x : exp(x) - 1 in c}`.
    expm1_rev log1p;
    /// `{x : ln(x) in c}`.
    ln_rev exp;
    /// `{x : log2(x) in c}`.
    log2_rev exp2;
    /// `{x : log10(x) in c}`.
    log10_rev exp10;
    /// `{x : ln(1 + x) in c}`.
    log1p_rev expm1;
    /// `{x : sinh(x) in c}`.
    sinh_rev asinh;
    /// `{x : tanh(x) in c}`.
    tanh_rev atanh;
    /// `{x : asinh(x) in c}`.
    asinh_rev sinh;
    /// `{x : atanh(x) in c}`.
    atanh_rev tanh;
}

impl Interval {
    /// `{x : cosh(x) in c}`.
    #[inline]
    pub fn cosh_rev(c: Interval, x: Interval) -> Interval {
        both_signs(c.acosh(), x)
    }

    /// `{x : acosh(x) in c}`.
    #[inline]
    pub fn acosh_rev(c: Interval, x: Interval) -> Interval {
        x.intersect(c.intersect(Interval::NON_NEGATIVE).cosh())
    }

    /// `{x : asin(x) in c}`: the sine is increasing on the values of the arc sine.
    #[inline]
    pub fn asin_rev(c: Interval, x: Interval) -> Interval {
        x.intersect(c.intersect(ARC_SINES).sin())
    }

    /// `{x : acos(x) in c}`: the cosine is decreasing on the values of the arc cosine.
    #[inline]
    pub fn acos_rev(c: Interval, x: Interval) -> Interval {
        x.intersect(c.intersect(ARC_COSINES).cos())
    }

    /// `{x : atan(x) in c}`: the tangents of `c` inside `(-π/2, π/2)`.
    pub fn atan_rev(c: Interval, x: Interval) -> Interval {
        // The float below π/2 is the last one where the tangent is on the branch of the arc tangent.
        let last = std::f64::consts::FRAC_PI_2;
        if c.is_empty() || c.lo() > last || c.hi() < -last {
            return Interval::EMPTY;
        }
        let lo = if c.lo() < -last {
            f64::NEG_INFINITY
        } else {
            Interval::point(c.lo()).tan().lo()
        };
        let hi = if c.hi() > last {
            f64::INFINITY
        } else {
            Interval::point(c.hi()).tan().hi()
        };
        x.intersect(Interval::ordered(lo, hi))
    }
}
