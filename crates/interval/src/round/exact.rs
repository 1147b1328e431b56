//! Directed rounding through exact integers: slow, for every finite operand.

/// Sign (true if negative), significand and exponent: `|x| = m 2^e` with `2^52 <= m < 2^53`. Required: finite, not zero.
pub(crate) fn parts(x: f64) -> (bool, u128, i32) {
    let bits = x.to_bits();
    let fraction = bits & ((1 << 52) - 1);
    let biased = ((bits >> 52) & 0x7ff) as i32;
    let (m, e) = if biased == 0 {
        let up = fraction.leading_zeros() as i32 - 11;
        (fraction << up, -1074 - up)
    } else {
        (fraction | (1 << 52), biased - 1075)
    };
    (bits >> 63 == 1, u128::from(m), e)
}

/// The float next to `±(m + s) 2^e` in the wanted direction, where `s = 0`, or `0 < s < 1` if `more`.
///
/// The result is tight: the largest float not above the value, or (`up`) the smallest not below.
/// Required: `m >= 2^54` if `more`.
///
/// Proof. Let `t` be the exponent of the last bit of the floats around the value: 53 bits are kept,
/// but nothing below 2^-1074. `q` is the value over `2^t` cut to an integer. For a left shift the cut
/// is exact (`more` is excluded: then 54 bits force a right shift); for a right shift the rest is
/// nonzero exactly when a dropped bit or `more` is set. The magnitude grows by one unit only when the
/// wanted direction is away from zero. `q <= 2^53`, and `(t + 1074) 2^52 + q` is the bit pattern of
/// `q 2^t`: for `q < 2^52` (only with `t = -1074`) a subnormal, else the leading bit of `q` adds one to
/// the exponent field, and `q = 2^53` adds two and leaves the fraction zero.
pub(crate) fn from_scaled(negative: bool, m: u128, e: i64, more: bool, up: bool) -> f64 {
    debug_assert!(!more || m >> 54 != 0);
    if m == 0 {
        return 0.0;
    }
    let away = up != negative;
    let length = 128 - i64::from(m.leading_zeros());
    let t = (e + length - 53).max(-1074);
    let shift = t - e;
    let (mut q, rest) = if shift <= 0 {
        (m << -shift, false)
    } else if shift < 128 {
        (m >> shift, m & ((1 << shift) - 1) != 0)
    } else {
        (0, true)
    };
    if away && (rest || more) {
        q += 1;
    }
    let bits = if t > 971 {
        u64::MAX
    } else {
        (((t + 1074) as u64) << 52) + q as u64
    };
    let magnitude = if bits < f64::INFINITY.to_bits() {
        f64::from_bits(bits)
    } else if away {
        f64::INFINITY
    } else {
        f64::MAX
    };
    if negative { -magnitude } else { magnitude }
}

/// Directed `a * b` for finite factors other than zero: the product has at most 106 bits.
pub(super) fn product(a: f64, b: f64, up: bool) -> f64 {
    let ((na, ma, ea), (nb, mb, eb)) = (parts(a), parts(b));
    from_scaled(na != nb, ma * mb, i64::from(ea + eb), false, up)
}

/// Directed `a / b` for finite operands other than zero: 2^63 < quotient of the shifted significands.
pub(super) fn quotient(a: f64, b: f64, up: bool) -> f64 {
    let ((na, ma, ea), (nb, mb, eb)) = (parts(a), parts(b));
    let shifted = ma << 64;
    from_scaled(
        na != nb,
        shifted / mb,
        i64::from(ea - eb - 64),
        shifted % mb != 0,
        up,
    )
}

/// Directed square root of a finite positive number: the integer root has at least 62 bits.
pub(super) fn root(a: f64, up: bool) -> f64 {
    let (_, m, e) = parts(a);
    let odd = e & 1;
    let shifted = m << (72 + odd);
    let whole = shifted.isqrt();
    from_scaled(
        false,
        whole,
        i64::from((e - 72 - odd) / 2),
        whole * whole != shifted,
        up,
    )
}
