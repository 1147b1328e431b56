//! Tables of elementary functions, computed by the compiler in fixed point with 126 bits after the
//! point.
//!
//! An entry is a pair of floats: the nearest one, and the nearest one to the rest. Each is within
//! `2^-105` of its true value, and within `2^-53` of its nearest float; the tests below prove it with
//! big integers.

/// A number of units `2^-126`, below 4.
pub(super) type Fixed = u128;

pub(super) const POINT: u32 = 126;
pub(super) const ONE: Fixed = 1 << POINT;
const UNIT: f64 = f64::from_bits((1023 - POINT as u64) << 52);

/// `2^(1/128)`, `ln 2`, `π/128` and its cosine and sine.
const STEP_OF_POWERS: Fixed = 0x4058_f6a7_eccc_d5b6_1299_ab8c_db73_7e90;
const LN_2: Fixed = 0x2c5c_85fd_f473_de6a_f278_ece6_00fc_bdac;
const ANGLE: Fixed = 0x0192_1fb5_4442_d184_6989_8cc5_1701_b83a;
const COS_OF_ANGLE: Fixed = 0x3ffb_10c1_099a_1976_5595_d548_d9a5_85cd;
const SIN_OF_ANGLE: Fixed = 0x0192_155f_7a36_67df_938a_73db_97fb_419e;

/// The product, less than one unit too small.
pub(super) const fn times(a: Fixed, b: Fixed) -> Fixed {
    const LOW: u128 = u64::MAX as u128;
    let (a1, a0, b1, b0) = (a >> 64, a & LOW, b >> 64, b & LOW);
    let (low, first, second) = (a0 * b0, a0 * b1, a1 * b0);
    let middle = (low >> 64) + (first & LOW) + (second & LOW);
    let high = a1 * b1 + (first >> 64) + (second >> 64) + (middle >> 64);
    (high << 2) | (middle & LOW) >> 62
}

/// The nearest float, and the nearest one to the rest.
pub(super) const fn pair(x: Fixed) -> Pair {
    let high = x as f64;
    let rest = x.wrapping_sub(high as u128) as i128;
    [high * UNIT, rest as f64 * UNIT]
}

/// The part above the bit `2^-last`, exactly, and the nearest float to the rest.
const fn cut(x: Fixed, last: u32) -> (f64, f64) {
    let rest = x & ((1 << (POINT - last)) - 1);
    ((x - rest) as f64 * UNIT, rest as f64 * UNIT)
}

/// Numbers from the table with a high and a low part each.
pub(super) type Pair = [f64; 2];

/// `2^(j / 128)`
pub(super) static POWERS: [Pair; 128] = {
    let (mut table, mut x, mut j) = ([[0.0; 2]; 128], ONE, 0);
    while j < 128 {
        table[j] = pair(x);
        x = times(x, STEP_OF_POWERS);
        j += 1;
    }
    table
};

/// Sine and cosine of `j π / 128`.
pub(super) static CIRCLE: [[f64; 4]; 256] = {
    let (mut table, mut j) = ([[0.0; 4]; 256], 0);
    while j < 256 {
        let (s, c) = (SINES[j], SINES[(j + 64) % 256]);
        table[j] = [s[0], s[1], c[0], c[1]];
        j += 1;
    }
    table
};

const SINES: [Pair; 256] = {
    let (mut table, mut cos, mut sin, mut j) = ([[0.0; 2]; 256], ONE, 0, 0);
    while j <= 32 {
        let (s, c) = (pair(sin), pair(cos));
        // The same angle, reflected at π/4 and π/2 and turned by π.
        table[j] = s;
        table[64 - j] = c;
        table[64 + j] = c;
        table[128 - j] = s;
        table[128 + j] = [-s[0], -s[1]];
        table[192 - j] = [-c[0], -c[1]];
        table[192 + j] = [-c[0], -c[1]];
        if j > 0 {
            table[256 - j] = [-s[0], -s[1]];
        }
        (cos, sin) = (
            times(cos, COS_OF_ANGLE) - times(sin, SIN_OF_ANGLE),
            times(cos, SIN_OF_ANGLE) + times(sin, COS_OF_ANGLE),
        );
        j += 1;
    }
    table
};

/// Bits of the float 0.6875: from here on, in steps of [`WIDTH`], 128 pieces make up one octave.
pub(super) const FIRST: u64 = 0x3fe6_0000_0000_0000;
/// Bits of the length of a piece.
pub(super) const WIDTH: u32 = 45;

/// A float near the reciprocal of the numbers of a piece, a multiple of `2^-9`; 1 for the two
/// pieces at 1.
const fn reciprocal_in_512ths(piece: usize) -> u32 {
    let start = FIRST + ((piece as u64) << WIDTH);
    let (first, last) = (f64::from_bits(start), f64::from_bits(start + (1 << WIDTH)));
    if first == 1.0 || last == 1.0 {
        512
    } else {
        (1024.0 / (first + last) + 0.5) as u32
    }
}

/// For each piece the reciprocal, and minus its logarithm in two parts, the first a multiple of
/// `2^-42`.
pub(super) static PIECES: [[f64; 4]; 128] = {
    let (mut table, mut i) = ([[0.0; 4]; 128], 0);
    while i < 128 {
        let n = reciprocal_in_512ths(i);
        let (high, low) = cut(size_of_log(n), 42);
        let sign = if n > 512 { -1.0 } else { 1.0 };
        table[i] = [n as f64 / 512.0, sign * high, sign * low, 0.0];
        i += 1;
    }
    table
};

/// `|ln(n / 512)| = 2 artanh(|n - 512| / (n + 512))` by the series.
const fn size_of_log(n: u32) -> Fixed {
    let z = (((n.abs_diff(512) as u128) << 116) / (n as u128 + 512)) << 10;
    let square = times(z, z);
    let (mut power, mut sum, mut k) = (z, z, 1);
    while power > 0 {
        power = times(power, square);
        k += 2;
        sum += power / k;
    }
    2 * sum
}

/// `ln 2`: a multiple of `2^-42`, and the rest.
pub(super) const LN_2_PARTS: (f64, f64) = cut(LN_2, 42);
/// `ln 2 / 128`: a multiple of `2^-44`, and the rest.
pub(super) const LN_2_OVER_128: (f64, f64) = {
    let (high, low) = cut(LN_2, 37);
    (high / 128.0, low / 128.0)
};
/// `π / 128`: multiples of `2^-32` and of `2^-59`, and the rest.
pub(super) const PI_OVER_128: (f64, f64, f64) = {
    let first = ANGLE >> (POINT - 32) << (POINT - 32);
    let (second, third) = cut(ANGLE - first, 59);
    (first as f64 * UNIT, second, third)
};

/// Numbers in units of `2^-400`, for the tests of tables.
#[cfg(test)]
pub(super) mod exact {
    use num_bigint::BigInt;
    use num_traits::{One, Signed, Zero};

    pub(in super::super) const BITS: u32 = 400;

    pub(in super::super) fn of(x: f64) -> BigInt {
        let bits = x.to_bits();
        let biased = (bits >> 52 & 0x7ff) as i64;
        if biased == 0 {
            assert!(x == 0.0);
            return BigInt::zero();
        }
        if biased < 1075 - i64::from(BITS) {
            return BigInt::zero();
        }
        let m = BigInt::from(bits & ((1 << 52) - 1) | 1 << 52);
        let shifted = m << (biased - 1075 + i64::from(BITS)) as u64;
        if x < 0.0 { -shifted } else { shifted }
    }

    pub(in super::super) fn sum(parts: &[f64]) -> BigInt {
        parts.iter().map(|&x| of(x)).sum()
    }

    pub(in super::super) fn unit(exponent: i64) -> BigInt {
        BigInt::one() << (i64::from(BITS) + exponent) as u64
    }

    pub(in super::super) fn assert_near(a: &BigInt, b: &BigInt, exponent: i64) {
        assert!((a - b).abs() <= unit(exponent), "{a} {b} 2^{exponent}");
    }

    /// `sum of sign^k z^(2k+1) / (2k+1)` for `z = 1/n` or any `z` in units.
    pub(in super::super) fn series(z: &BigInt, sign: i32) -> BigInt {
        let square = (z * z) >> BITS;
        let (mut power, mut sum, mut k) = (z.clone(), z.clone(), 1);
        while !power.is_zero() {
            power = ((&power * &square) >> BITS) * sign;
            k += 2;
            sum += &power / k;
            if power.abs() <= BigInt::one() {
                break;
            }
        }
        sum
    }

    pub(in super::super) fn inverse(n: u32) -> BigInt {
        unit(0) / n
    }

    pub(in super::super) fn pi() -> BigInt {
        (series(&inverse(5), -1) * 4 - series(&inverse(239), -1)) * 4
    }

    pub(in super::super) fn ln_2() -> BigInt {
        series(&inverse(3), 1) * 2
    }
}

#[cfg(test)]
mod tests {
    use num_bigint::BigInt;
    use num_traits::{One, Signed, Zero};

    use super::exact::{BITS, assert_near, ln_2, of, pi, series, sum, unit};
    use super::*;

    #[test]
    fn parts_of_constants() {
        let (high, low) = LN_2_PARTS;
        assert_near(&sum(&[high, low]), &ln_2(), -95);
        assert_eq!((high * 2_f64.powi(42)).fract(), 0.0);
        let (high, low) = LN_2_OVER_128;
        assert_near(&sum(&[high, low]), &(ln_2() >> 7), -97);
        assert_eq!((high * 2_f64.powi(44)).fract(), 0.0);
        assert!(0.0 < low && low < 2_f64.powi(-44));
        // The Sterbenz argument of the exponential for the factor 1.
        assert!(low > 2_f64.powi(-52) * high);
        let (first, second, third) = PI_OVER_128;
        assert_near(&sum(&[first, second, third]), &(pi() >> 7), -113);
        assert_eq!((first * 2_f64.powi(32)).fract(), 0.0);
        assert_eq!((second * 2_f64.powi(59)).fract(), 0.0);
        assert!(0.0 < second && second < 2_f64.powi(-32));
        assert!(0.0 < third && third < 2_f64.powi(-59));
    }

    #[test]
    fn powers_of_two() {
        assert_eq!(POWERS[0], [1.0, 0.0]);
        for (j, [high, low]) in POWERS.into_iter().enumerate() {
            assert!((1.0..2.0).contains(&high) && low.abs() <= 2_f64.powi(-53));
            // x^128 = 2^j (1 + d) with |d| < 2^-98: x has the relative error d / 128.
            let mut power = sum(&[high, low]);
            for _ in 0..7 {
                power = (&power * &power) >> BITS;
            }
            let expected = BigInt::one() << (BITS as usize + j);
            assert!((power - &expected).abs() <= expected >> 98_u32, "{j}");
        }
    }

    #[test]
    fn sines() {
        // The 256th power of the first step is 1 and the step is about π/128: no other root is near.
        let [sin, sin_rest, cos, cos_rest] = CIRCLE[1];
        let (cos, sin) = (sum(&[cos, cos_rest]), sum(&[sin, sin_rest]));
        assert_near(&sin, &(pi() >> 7), -17);
        assert!(cos.is_positive());
        let turn = |(a, b): &(BigInt, BigInt)| -> (BigInt, BigInt) {
            ((a * &cos - b * &sin) >> BITS, (a * &sin + b * &cos) >> BITS)
        };
        let mut point = (unit(0), BigInt::zero());
        for [sin, sin_rest, cos, cos_rest] in CIRCLE {
            let (s, c) = (sum(&[sin, sin_rest]), sum(&[cos, cos_rest]));
            // Each step errs by at most 2^-106 or so, 256 of them by 2^-98.
            assert_near(&s, &point.1, -97);
            assert_near(&c, &point.0, -97);
            // Each entry by itself: s^2 + c^2 = 1 within the error of an entry.
            assert_near(&((&s * &s + &c * &c) >> BITS), &unit(0), -103);
            assert!(sin_rest.abs() <= 2_f64.powi(-53) * sin.abs());
            assert!(cos_rest.abs() <= 2_f64.powi(-53) * cos.abs());
            point = turn(&point);
        }
        assert_near(&point.0, &unit(0), -97);
        assert_near(&point.1, &BigInt::zero(), -97);
        let corners = [
            (0, 0.0, 1.0),
            (64, 1.0, 0.0),
            (128, 0.0, -1.0),
            (192, -1.0, 0.0),
        ];
        for (j, sin, cos) in corners {
            assert_eq!(CIRCLE[j], [sin, 0.0, cos, 0.0]);
        }
    }

    #[test]
    fn logarithms() {
        for (i, [c, high, low, _]) in PIECES.into_iter().enumerate() {
            let start = FIRST + ((i as u64) << WIDTH);
            let (first, last) = (
                f64::from_bits(start),
                f64::from_bits(start + (1 << WIDTH)).next_down(),
            );
            assert_eq!((c * 512.0).fract(), 0.0);
            let most = (first * c - 1.0).abs().max((last * c - 1.0).abs());
            if c == 1.0 {
                assert_eq!((high, low), (0.0, 0.0));
                assert!(most < 2_f64.powi(-7));
            } else {
                assert!(most < 2_f64.powf(-7.4), "{i} {most}");
                // The sums of the logarithm begin with the larger part, and keep half of it.
                assert!(high.abs() > 1.7 * most, "{i} {high} {most}");
            }
            assert_eq!((high * 2_f64.powi(42)).fract(), 0.0);
            let n = of(c);
            let z = ((unit(0) - &n) << BITS) / (unit(0) + &n);
            assert_near(&sum(&[high, low]), &(series(&z, 1) * 2), -94);
        }
    }
}
