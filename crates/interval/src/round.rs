//! Directed rounding of `+ - * / sqrt` on `f64` without touching the rounding mode.
//!
//! Every operation is first done in round-to-nearest; an error-free transform then tells on which
//! side of the true value the result lies, and the result is moved by one float where needed (the
//! private module `upward`, with the proofs). Where the transform could be inexact (very small or very
//! large operands) exact integers decide instead. Both ways give the tight bound: the largest float not
//! above, or the smallest float not below, the true value.
//!
//! *Guarantee*: for operands that are not NaN, `op_down(a, b) <= a op b <= op_up(a, b)` in the reals,
//! and no float lies strictly between the bound and the true value. A zero factor makes a product
//! zero, also beside an infinity, and a finite number over an infinity is zero: infinities are bounds
//! of sets of real numbers here. Where nothing can be said (NaN, `inf - inf`, division by zero, root
//! of a negative number) the result is `-inf` downward and `+inf` upward.

mod elementwise;
mod exact;
mod pair;
mod upward;

pub(crate) use elementwise::Elementwise;
pub(crate) use exact::{from_scaled, parts};
pub(crate) use pair::Pair;
#[cfg(target_arch = "x86_64")]
pub(crate) use upward::STEP;
pub(crate) use upward::{LEAST, MOST, SMALL, product_up, quotient_up, sum_up};

use upward::{root_bounds, sum_error};

/// Largest float not above `a + b`.
#[inline]
pub fn add_down(a: f64, b: f64) -> f64 {
    let (negated, holds) = sum_up(-a, -b);
    if holds {
        -negated
    } else {
        add_extreme(a, b, false)
    }
}

/// Smallest float not below `a + b`.
#[inline]
pub fn add_up(a: f64, b: f64) -> f64 {
    let (sum, holds) = sum_up(a, b);
    if holds { sum } else { add_extreme(a, b, true) }
}

/// Largest float not above `a - b`.
#[inline]
pub fn sub_down(a: f64, b: f64) -> f64 {
    add_down(a, -b)
}

/// Smallest float not below `a - b`.
#[inline]
pub fn sub_up(a: f64, b: f64) -> f64 {
    add_up(a, -b)
}

/// Sums with an infinity, a NaN or an overflow somewhere, and very small ones.
#[inline(never)]
fn add_extreme(a: f64, b: f64, up: bool) -> f64 {
    let s = a + b;
    if s.is_nan() {
        return unknown(up);
    }
    if a.is_infinite() || b.is_infinite() {
        return s;
    }
    if s.is_infinite() {
        // The true sum is finite and beyond MAX on the side of `s`.
        return match (s > 0.0, up) {
            (true, false) => f64::MAX,
            (false, true) => f64::MIN,
            _ => s,
        };
    }
    // An intermediate of the transform overflows only for an operand of magnitude MAX in one place
    // (Boldo, Graillat, Muller 2017), so one order of the operands is free of overflow; if both had
    // that magnitude, the sum would be zero or overflow itself. The last branch is sound without this
    // theorem. A sum that is not exact is not zero, so its neighbours are on the same side.
    let mut e = sum_error(a, b, s);
    if !e.is_finite() {
        e = sum_error(b, a, s);
    }
    match up {
        true if e > 0.0 || !e.is_finite() => s.next_up(),
        false if e < 0.0 || !e.is_finite() => s.next_down(),
        _ => s,
    }
}

/// Largest float not above `a * b` (zero when a factor is zero).
#[inline]
pub fn mul_down(a: f64, b: f64) -> f64 {
    let (negated, holds) = product_up(-a, b);
    if holds {
        -negated
    } else {
        mul_extreme(a, b, false)
    }
}

/// Smallest float not below `a * b` (zero when a factor is zero).
#[inline]
pub fn mul_up(a: f64, b: f64) -> f64 {
    let (product, holds) = product_up(a, b);
    if holds {
        product
    } else {
        mul_extreme(a, b, true)
    }
}

#[inline(never)]
fn mul_extreme(a: f64, b: f64, up: bool) -> f64 {
    if a.is_nan() || b.is_nan() {
        return unknown(up);
    }
    if a == 0.0 || b == 0.0 {
        return 0.0;
    }
    if a.is_infinite() || b.is_infinite() {
        return a * b;
    }
    exact::product(a, b, up)
}

/// Largest float not above `a / b`.
#[inline]
pub fn div_down(a: f64, b: f64) -> f64 {
    let (negated, holds) = quotient_up(-a, b);
    if holds {
        -negated
    } else {
        div_extreme(a, b, false)
    }
}

/// Smallest float not below `a / b`.
#[inline]
pub fn div_up(a: f64, b: f64) -> f64 {
    let (quotient, holds) = quotient_up(a, b);
    if holds {
        quotient
    } else {
        div_extreme(a, b, true)
    }
}

#[inline(never)]
fn div_extreme(a: f64, b: f64, up: bool) -> f64 {
    if a.is_nan() || b.is_nan() || b == 0.0 || (a.is_infinite() && b.is_infinite()) {
        return unknown(up);
    }
    if a == 0.0 || b.is_infinite() {
        return 0.0;
    }
    if a.is_infinite() {
        return if (a < 0.0) == (b < 0.0) {
            f64::INFINITY
        } else {
            f64::NEG_INFINITY
        };
    }
    exact::quotient(a, b, up)
}

/// Largest float not above the square root of `a`.
#[inline]
pub fn sqrt_down(a: f64) -> f64 {
    let (down, _, holds) = root_bounds(a);
    if holds { down } else { sqrt_extreme(a, false) }
}

/// Smallest float not below the square root of `a`.
#[inline]
pub fn sqrt_up(a: f64) -> f64 {
    let (_, up, holds) = root_bounds(a);
    if holds { up } else { sqrt_extreme(a, true) }
}

#[inline(never)]
fn sqrt_extreme(a: f64, up: bool) -> f64 {
    if a == 0.0 {
        0.0
    } else if a.is_nan() || a < 0.0 {
        unknown(up)
    } else if a.is_infinite() {
        a
    } else {
        exact::root(a, up)
    }
}

/// The bound that claims nothing.
fn unknown(up: bool) -> f64 {
    if up { f64::INFINITY } else { f64::NEG_INFINITY }
}
