//! Which multiples of π/2 lie in an interval, proved for floats of every magnitude.
//!
//! No reduction of a large argument by π is needed. Number the quarter turns by
//! `k(x) = floor(x / (π/2))`; then `k mod 4` is told by the signs of `sin x` and `cos x`, which a
//! correctly rounded library gives exactly (a nonzero value never rounds to zero here: the sine of a
//! float is at least as large as a subnormal, and only the cosine of no float is zero). The multiples
//! of π/2 in `(lo, hi]` are `k(lo) + 1 .. k(hi)`. If the width is below 2π their number is at most 4,
//! and it is known modulo 4; 0 and 4 are told apart by the width, below π/2 or above 3π/2.
//! The only float that is a multiple of π/2 is 0, and 0 as the lower end is no loss: the value at
//! the end itself is used by the caller.

use crate::Interval;

/// The multiples of π/2 in `(lo, hi]`, for an interval narrower than 2π.
pub(crate) struct Extremes {
    /// Quarter turn of the lower end, modulo 4.
    start: u8,
    /// How many multiples of π/2 there are, 0 to 4.
    count: u8,
}

impl Extremes {
    /// `None` where the interval is unbounded or may have a width of 2π or more.
    #[inline]
    pub(crate) fn of(x: Interval) -> Option<Extremes> {
        let width = x.width();
        // The constant is twice the float below π, hence below 2π.
        if !x.is_bounded() || width > 2.0 * std::f64::consts::PI {
            return None;
        }
        let start = quarter(x.lo());
        let turned = quarter(x.hi()).wrapping_sub(start) & 3;
        // Halfway between π/2 and 3π/2: the rounded width cannot be on the wrong side.
        let count = if turned == 0 && width > 3.0 {
            4
        } else {
            turned
        };
        Some(Extremes { start, count })
    }

    /// True if a multiple `k` of π/2 with `k = residue` modulo 4 is among them.
    #[inline]
    pub(crate) fn include(&self, residue: u8) -> bool {
        (residue.wrapping_sub(self.start + 1) & 3) < self.count
    }
}

/// `floor(x / (π/2)) mod 4` for a finite float.
///
/// Short way: `t`, the rounded product with the rounded constant, has a relative error below 2^-51;
/// for `|x| <= 2^20` it is within 2^-30 of the true quotient, so the floors agree unless `t` is nearer
/// than 2^-29 to an integer. The subtraction `t - whole` errs by less than 2^-53.
#[inline]
fn quarter(x: f64) -> u8 {
    if x.abs() <= 1_048_576.0 {
        let t = x * std::f64::consts::FRAC_2_PI;
        let cut = t as i64;
        let whole = if (cut as f64) > t { cut - 1 } else { cut };
        let rest = t - whole as f64;
        if rest > 2e-9 && rest < 1.0 - 2e-9 {
            return (whole & 3) as u8;
        }
    }
    quarter_by_signs(x)
}

/// The same from the signs of sine and cosine. Required: finite.
fn quarter_by_signs(x: f64) -> u8 {
    if x == 0.0 {
        return 0;
    }
    match (core_math::sin(x) > 0.0, core_math::cos(x) > 0.0) {
        (true, true) => 0,
        (true, false) => 1,
        (false, false) => 2,
        (false, true) => 3,
    }
}
