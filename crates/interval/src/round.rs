//! Directed rounding of `+ - * / sqrt` on `f64` without touching the rounding mode.
//!
//! Every operation is first done in round-to-nearest; an error-free transform then tells on which
//! side of the true value the result lies, and the result is moved by one float where needed. Where
//! the transform could be inexact (very small or very large operands) the integers of
//! [`exact`] decide instead. Both ways give the tight bound: the largest float not above, or the
//! smallest float not below, the true value.
//!
//! *Guarantee*: for operands that are not NaN, `op_down(a, b) <= a op b <= op_up(a, b)` in the reals,
//! and no float lies strictly between the bound and the true value. A zero factor makes a product
//! zero, also beside an infinity, and a finite number over an infinity is zero: infinities are bounds
//! of sets of real numbers here. Where nothing can be said (NaN, `inf - inf`, division by zero, root
//! of a negative number) the result is `-inf` downward and `+inf` upward.

mod exact;

/// The exact rounding error of a product, computed in floating point.
///
/// One implementation is chosen at compile time; a kernel compiled for a wider instruction set can
/// name its own.
trait Residual {
    /// `a * b - p` without error, for `p` the product rounded to nearest.
    ///
    /// Required: [`ordinary`] holds for `p`, and both operands are finite and below 2^995.
    fn product(a: f64, b: f64, p: f64) -> f64;
}

/// Dekker's product with Veltkamp's splitting: multiplications and additions only.
///
/// Proof. With `C = 2^27 + 1`, `split` gives `x = h + l` exactly, where `h` has at most 26 and `l` at
/// most 26 significant bits (Veltkamp); `C * x` does not overflow for `|x| < 2^995`. The partial
/// products have at most 52 bits and are exact unless they underflow; they are multiples of
/// `ulp(a) * ulp(b) >= |a b| 2^-106 / 4`, which is above the smallest subnormal because
/// `|a b| >= 2^-481`. The four sums are exact by Dekker's theorem, and end with `a b - p`.
#[cfg_attr(any(target_feature = "fma", target_arch = "aarch64"), allow(dead_code))]
struct Dekker;

impl Residual for Dekker {
    #[inline(always)]
    fn product(a: f64, b: f64, p: f64) -> f64 {
        let (ah, al) = split(a);
        let (bh, bl) = split(b);
        ((ah * bh - p) + ah * bl + al * bh) + al * bl
    }
}

/// The fused operation, used only where the instruction is part of the compilation target, so that
/// it is never a library call: `a b - p` is representable, and one rounding leaves it as it is.
#[cfg(any(target_feature = "fma", target_arch = "aarch64"))]
struct Fused;

#[cfg(any(target_feature = "fma", target_arch = "aarch64"))]
impl Residual for Fused {
    #[inline(always)]
    fn product(a: f64, b: f64, p: f64) -> f64 {
        a.mul_add(b, -p)
    }
}

#[cfg(any(target_feature = "fma", target_arch = "aarch64"))]
type Best = Fused;
#[cfg(not(any(target_feature = "fma", target_arch = "aarch64")))]
type Best = Dekker;

#[inline(always)]
fn split(x: f64) -> (f64, f64) {
    let scaled = 134_217_729.0 * x;
    let high = scaled - (scaled - x);
    (high, x - high)
}

/// True where `2^-480 <= |x| < 2^500`: products, quotients and roots of two such numbers, and all
/// parts of their error-free transforms, neither overflow nor lose bits below the smallest float.
#[inline(always)]
fn ordinary(x: f64) -> bool {
    let exponent = (x.to_bits() >> 52) & 0x7ff;
    exponent.wrapping_sub(1023 - 480) < 980
}

/// The neighbour of `x` below when `wanted`, else `x`. Required: finite, and not zero when `wanted`.
///
/// Proof. Floats of one sign are ordered like their bit patterns; going down is one less for a
/// positive and one more for a negative number. `-MAX` gives `-inf`.
#[inline(always)]
fn step_down(x: f64, wanted: bool) -> f64 {
    let bits = x.to_bits() as i64;
    let away = (bits >> 63) | 1;
    f64::from_bits(bits.wrapping_sub(away & -i64::from(wanted)) as u64)
}

/// The neighbour of `x` above when `wanted`, else `x`; mirror image of [`step_down`].
#[inline(always)]
fn step_up(x: f64, wanted: bool) -> f64 {
    let bits = x.to_bits() as i64;
    let away = (bits >> 63) | 1;
    f64::from_bits(bits.wrapping_add(away & -i64::from(wanted)) as u64)
}

/// `(a + b) - s` for `s` the sum rounded to nearest (Knuth's TwoSum).
///
/// Proof. A sum of two floats that is below the normal range is exact, so only overflow can spoil the
/// transform. If the result is finite, no intermediate overflowed (an infinity would give NaN or an
/// infinity at the end) and Knuth's theorem gives the exact error; the caller checks this.
#[inline(always)]
fn sum_error(a: f64, b: f64, s: f64) -> f64 {
    let from_b = s - a;
    (a - (s - from_b)) + (b - from_b)
}

/// Largest float not above `a + b`.
///
/// Proof. The error `e = (a + b) - s` is exact when finite. If `e < 0` the true sum lies strictly
/// between the neighbour below `s` and `s`, because `s` is the nearest float; otherwise `s` itself is
/// not above it. A zero sum is exact, so the neighbour of zero is never asked for.
#[inline]
pub fn add_down(a: f64, b: f64) -> f64 {
    let s = a + b;
    let e = sum_error(a, b, s);
    if e.is_finite() {
        step_down(s, e < 0.0)
    } else {
        add_extreme(a, b, false)
    }
}

/// Smallest float not below `a + b`; mirror image of [`add_down`].
#[inline]
pub fn add_up(a: f64, b: f64) -> f64 {
    let s = a + b;
    let e = sum_error(a, b, s);
    if e.is_finite() {
        step_up(s, e > 0.0)
    } else {
        add_extreme(a, b, true)
    }
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

/// Sums with an infinity, a NaN or an overflow somewhere.
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
    // `s` is finite and an intermediate overflowed: halves are exact here, because an overflow needs
    // one operand near MAX, and the last bit of the other is lost in the sum unless it is large too.
    // The order of operands matters for overflow only; with the smaller one first there is none.
    let (small, large) = if a.abs() < b.abs() { (a, b) } else { (b, a) };
    let e = sum_error(small, large, s);
    if e.is_finite() {
        if up {
            step_up(s, e > 0.0)
        } else {
            step_down(s, e < 0.0)
        }
    } else if up {
        s.next_up()
    } else {
        s.next_down()
    }
}

/// Largest float not above `a * b` (zero when a factor is zero).
///
/// Proof. For ordinary factors `|p| >= 2^-960` and the residual `r = a b - p` is exact
/// ([`Residual`]); the sign of `r` tells on which side of `p` the true product lies, within one float
/// since `p` is nearest. All other factors go through exact integers.
#[inline]
pub fn mul_down(a: f64, b: f64) -> f64 {
    mul_down_by::<Best>(a, b)
}

/// Smallest float not below `a * b` (zero when a factor is zero).
#[inline]
pub fn mul_up(a: f64, b: f64) -> f64 {
    mul_up_by::<Best>(a, b)
}

#[inline(always)]
fn mul_down_by<R: Residual>(a: f64, b: f64) -> f64 {
    if ordinary(a) & ordinary(b) {
        let p = a * b;
        step_down(p, R::product(a, b, p) < 0.0)
    } else {
        mul_extreme(a, b, false)
    }
}

#[inline(always)]
fn mul_up_by<R: Residual>(a: f64, b: f64) -> f64 {
    if ordinary(a) & ordinary(b) {
        let p = a * b;
        step_up(p, R::product(a, b, p) > 0.0)
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
///
/// Proof. Let `q` be the quotient rounded to nearest, `p` the nearest float to `q b` and
/// `e = q b - p` exact. `q b = a (1 + d)` with `|d| <= 2^-53`, so `p` and `a` differ by less than a
/// factor 2 and `a - p` is exact (Sterbenz). `r = a - q b` is a multiple of `ulp(q) ulp(b)` and
/// `|r| <= |b| ulp(q) / 2 < 2^52 ulp(q) ulp(b)`, so it is a float and `(a - p) - e` gives it without
/// error. `a / b - q = r / b`, whose sign decides. Ordinary operands keep `|q|` within 2^±980, where
/// `q` splits exactly and nothing underflows.
#[inline]
pub fn div_down(a: f64, b: f64) -> f64 {
    if ordinary(a) & ordinary(b) {
        let q = a / b;
        let r = quotient_remainder::<Best>(a, b, q);
        step_down(q, (r != 0.0) & ((r < 0.0) != (b < 0.0)))
    } else {
        div_extreme(a, b, false)
    }
}

/// Smallest float not below `a / b`; mirror image of [`div_down`].
#[inline]
pub fn div_up(a: f64, b: f64) -> f64 {
    if ordinary(a) & ordinary(b) {
        let q = a / b;
        let r = quotient_remainder::<Best>(a, b, q);
        step_up(q, (r != 0.0) & ((r < 0.0) == (b < 0.0)))
    } else {
        div_extreme(a, b, true)
    }
}

#[inline(always)]
fn quotient_remainder<R: Residual>(a: f64, b: f64, q: f64) -> f64 {
    let p = q * b;
    (a - p) - R::product(q, b, p)
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
///
/// Proof. Let `s` be the root rounded to nearest, `p` the nearest float to `s^2`, `e = s^2 - p` exact.
/// `a - p` is exact (Sterbenz, as in [`div_down`]). `r = a - s^2` is a multiple of `ulp(s)^2`, and
/// `|r| = |sqrt(a) - s| (sqrt(a) + s) <= s ulp(s) + ulp(s)^2 / 4`, hence at most `2^53 ulp(s)^2`: a
/// float, obtained without error. Its sign is the sign of `sqrt(a) - s`.
#[inline]
pub fn sqrt_down(a: f64) -> f64 {
    if ordinary(a) & (a > 0.0) {
        let s = a.sqrt();
        step_down(s, quotient_remainder::<Best>(a, s, s) < 0.0)
    } else {
        sqrt_extreme(a, false)
    }
}

/// Smallest float not below the square root of `a`; mirror image of [`sqrt_down`].
#[inline]
pub fn sqrt_up(a: f64) -> f64 {
    if ordinary(a) & (a > 0.0) {
        let s = a.sqrt();
        step_up(s, quotient_remainder::<Best>(a, s, s) > 0.0)
    } else {
        sqrt_extreme(a, true)
    }
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

pub(crate) use exact::from_scaled;
