//! The smallest intervals for functions that inari encloses more widely or does not have, straight on
//! MPFR: a value rounded in a direction by `mpfr_sin` and its like is the float next to the true one.

use gmp_mpfr_sys::mpfr::{self, rnd_t};
use inari::Interval;
use rug::Float;
use rug::float::Constant;
use std::ffi::c_ulong;

/// Bits for counting quarter turns: the largest float has 1024 before the point, and no float is nearer
/// than 2^-70 to a multiple of π/2, relative to it.
const BITS: u32 = 1400;

type Function = unsafe extern "C" fn(*mut mpfr::mpfr_t, *const mpfr::mpfr_t, rnd_t) -> i32;

/// `f(x)` rounded down and up.
fn bounds(f: Function, x: f64) -> (f64, f64) {
    let argument = Float::with_val(f64::MANTISSA_DIGITS, x);
    let rounded = |direction: rnd_t| {
        let mut value = Float::new(f64::MANTISSA_DIGITS);
        // SAFETY: both numbers are initialised and differ.
        unsafe {
            f(value.as_raw_mut(), argument.as_raw(), direction);
            mpfr::get_d(value.as_raw(), direction)
        }
    };
    (rounded(rnd_t::RNDD), rounded(rnd_t::RNDU))
}

/// How many multiples of π/2 lie at or below a finite float.
fn quarter_turns(x: f64) -> Float {
    thread_local! {
        static HALF_PI: Float = Float::with_val(BITS, Constant::Pi) / 2;
    }
    HALF_PI.with(|half_pi| (Float::with_val(BITS, x) / half_pi).floor())
}

/// For multiples `k π/2` in `(lo, hi]`: whether `k mod 4` is 0, 1, 2, 3 for one of them. Required: bounded.
fn multiples(x: Interval) -> [bool; 4] {
    let (first, last) = (quarter_turns(x.inf()), quarter_turns(x.sup()));
    let period = Float::with_val(BITS, &first / 4u32).floor() * 4u32;
    let start = Float::with_val(BITS, &first - period).to_f64() as usize;
    let count = (last - first).to_f64().min(4.0) as usize;
    let mut met = [false; 4];
    for step in 1..=count {
        met[(start + step) % 4] = true;
    }
    met
}

fn interval(lo: f64, hi: f64) -> Interval {
    Interval::try_from((lo, hi)).unwrap_or(Interval::EMPTY)
}

/// A function with range `[-1, 1]`, its maxima at `maximum + 4m` quarter turns.
fn wave(x: Interval, f: Function, maximum: usize) -> Interval {
    if x.is_empty() {
        return x;
    }
    if !x.is_common_interval() {
        return interval(-1.0, 1.0);
    }
    let met = multiples(x);
    let (first, last) = (bounds(f, x.inf()), bounds(f, x.sup()));
    let lo = if met[(maximum + 2) % 4] {
        -1.0
    } else {
        first.0.min(last.0)
    };
    let hi = if met[maximum] {
        1.0
    } else {
        first.1.max(last.1)
    };
    interval(lo, hi)
}

/// The result, if the wider one of inari contains it; else all numbers, which no test can take for tight.
fn confirmed(tight: Interval, wide: Interval) -> Interval {
    if tight.subset(wide) {
        tight
    } else {
        Interval::ENTIRE
    }
}

pub fn sin(x: Interval) -> Interval {
    confirmed(wave(x, mpfr::sin, 1), x.sin())
}

pub fn cos(x: Interval) -> Interval {
    confirmed(wave(x, mpfr::cos, 0), x.cos())
}

pub fn tan(x: Interval) -> Interval {
    if x.is_empty() {
        return x;
    }
    let met = if x.is_common_interval() {
        multiples(x)
    } else {
        [true; 4]
    };
    if met[1] || met[3] {
        return Interval::ENTIRE;
    }
    let (first, last) = (bounds(mpfr::tan, x.inf()), bounds(mpfr::tan, x.sup()));
    confirmed(interval(first.0, last.1), x.tan())
}

/// A size as an interval; NaN, inari's size of the empty set, gives that set.
pub fn around_zero(size: f64) -> Interval {
    interval(-size, size)
}

/// `e^x - 1`.
pub fn expm1(x: Interval) -> Interval {
    increasing(x, mpfr::expm1)
}

/// `ln(1 + x)` for `x > -1`.
pub fn log1p(x: Interval) -> Interval {
    if x.sup() <= -1.0 {
        return Interval::EMPTY;
    }
    increasing(x.intersection(interval(-1.0, f64::INFINITY)), mpfr::log1p)
}

fn increasing(x: Interval, f: Function) -> Interval {
    if x.is_empty() {
        return x;
    }
    interval(bounds(f, x.inf()).0, bounds(f, x.sup()).1)
}

/// The `n`-th roots, also of negative numbers for odd `n`; for negative `n` the reciprocals of the roots.
pub fn rootn(x: Interval, n: i32) -> Interval {
    let domain = if n % 2 == 0 {
        interval(0.0, f64::INFINITY)
    } else {
        Interval::ENTIRE
    };
    let x = x.intersection(domain);
    if n == 0 || x.is_empty() {
        return Interval::EMPTY;
    }
    let end = |x: f64, direction: rnd_t| {
        let argument = Float::with_val(f64::MANTISSA_DIGITS, x);
        // Wide enough for the reciprocal to be rounded once in practice: a root is either a short
        // number or irrational.
        let mut value = Float::new(if n < 0 { BITS } else { f64::MANTISSA_DIGITS });
        // SAFETY: both numbers are initialised and differ; an infinite end has an infinite root.
        unsafe {
            let degree = c_ulong::from(n.unsigned_abs());
            mpfr::rootn_ui(value.as_raw_mut(), argument.as_raw(), degree, direction);
            if n < 0 {
                let mut inverse = Float::new(f64::MANTISSA_DIGITS);
                mpfr::ui_div(inverse.as_raw_mut(), 1, value.as_raw(), direction);
                value = inverse;
            }
            mpfr::get_d(value.as_raw(), direction)
        }
    };
    if n > 0 {
        return interval(end(x.inf(), rnd_t::RNDD), end(x.sup(), rnd_t::RNDU));
    }
    let (a, b) = (x.inf(), x.sup());
    match (a < 0.0, b > 0.0) {
        (false, false) => Interval::EMPTY,
        (true, true) => Interval::ENTIRE,
        // A zero end is approached from inside.
        (false, true) => interval(
            end(b, rnd_t::RNDD),
            if a == 0.0 {
                f64::INFINITY
            } else {
                end(a, rnd_t::RNDU)
            },
        ),
        (true, false) => interval(
            if b == 0.0 {
                f64::NEG_INFINITY
            } else {
                end(b, rnd_t::RNDD)
            },
            end(a, rnd_t::RNDU),
        ),
    }
}
