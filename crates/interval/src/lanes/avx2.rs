//! Four floats in a register of AVX2 with fused multiplication.
//!
//! Rounding to nearest everywhere; an error-free transform tells on which side of the true value a
//! result lies.
#![allow(
    unused_unsafe,
    reason = "the instructions are safe where the whole program is compiled for them"
)]

use std::arch::x86_64::*;

use super::elementary;
use super::vector::Vector;
use super::{Floats, Interval8, basic, power};
use crate::Interval;
use crate::round::{SMALL, STEP};

/// Four floats.
#[derive(Clone, Copy)]
pub(super) struct F64x4(__m256d);

/// A nearest float, and the true value minus this float (of which the sign counts).
#[derive(Clone, Copy)]
pub(super) struct Nearest {
    value: F64x4,
    error: F64x4,
}

/// One or more instructions on registers.
macro_rules! simd {
    ($($instructions:tt)+) => {
        // SAFETY: values of this type exist only in kernels that `Path::run` has started after it found
        // AVX2 and FMA in this processor, and the instructions have no other requirement.
        unsafe { $($instructions)+ }
    };
}

mod wide;

impl F64x4 {
    /// The floats where the mask is set, 0 elsewhere.
    #[inline(always)]
    fn kept(self, mask: __m256d) -> F64x4 {
        F64x4(simd!(_mm256_and_pd(self.0, mask)))
    }
}

impl Vector for F64x4 {
    type Mask = __m256d;
    type Upper = Nearest;
    const WIDTH: usize = 4;

    #[inline(always)]
    fn load(from: &Floats, chunk: usize) -> F64x4 {
        let part = &from[4 * chunk..4 * chunk + 4];
        // SAFETY: `part` has four floats; no alignment is required.
        F64x4(unsafe { _mm256_loadu_pd(part.as_ptr()) })
    }

    #[inline(always)]
    fn store(self, to: &mut Floats, chunk: usize) {
        let part = &mut to[4 * chunk..4 * chunk + 4];
        // SAFETY: `part` has room for four floats; no alignment is required.
        unsafe { _mm256_storeu_pd(part.as_mut_ptr(), self.0) }
    }

    #[inline(always)]
    fn splat(x: f64) -> F64x4 {
        F64x4(simd!(_mm256_set1_pd(x)))
    }

    #[inline(always)]
    fn negated(self) -> F64x4 {
        F64x4(simd!(_mm256_xor_pd(self.0, _mm256_set1_pd(-0.0))))
    }

    #[inline(always)]
    fn abs(self) -> F64x4 {
        F64x4(simd!(_mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0)))
    }

    #[inline(always)]
    fn larger(self, other: F64x4) -> F64x4 {
        F64x4(simd!(_mm256_max_pd(self.0, other.0)))
    }

    #[inline(always)]
    fn smaller(self, other: F64x4) -> F64x4 {
        F64x4(simd!(_mm256_min_pd(self.0, other.0)))
    }

    #[inline(always)]
    fn above(self, other: F64x4) -> __m256d {
        simd!(_mm256_cmp_pd::<_CMP_GT_OQ>(self.0, other.0))
    }

    #[inline(always)]
    fn at_most(self, other: F64x4) -> __m256d {
        simd!(_mm256_cmp_pd::<_CMP_LE_OQ>(self.0, other.0))
    }

    #[inline(always)]
    fn equals(self, other: F64x4) -> __m256d {
        simd!(_mm256_cmp_pd::<_CMP_EQ_OQ>(self.0, other.0))
    }

    #[inline(always)]
    fn both(a: __m256d, b: __m256d) -> __m256d {
        simd!(_mm256_and_pd(a, b))
    }

    #[inline(always)]
    fn either(a: __m256d, b: __m256d) -> __m256d {
        simd!(_mm256_or_pd(a, b))
    }

    #[inline(always)]
    fn without(a: __m256d, b: __m256d) -> __m256d {
        simd!(_mm256_andnot_pd(b, a))
    }

    #[inline(always)]
    fn select(mask: __m256d, a: F64x4, b: F64x4) -> F64x4 {
        F64x4(simd!(_mm256_blendv_pd(b.0, a.0, mask)))
    }

    #[inline(always)]
    fn bits(mask: __m256d) -> u32 {
        (simd!(_mm256_movemask_pd(mask))) as u32
    }

    #[inline(always)]
    fn mask(bits: u32) -> __m256d {
        simd!({
            let places = _mm256_setr_epi64x(1, 2, 4, 8);
            let bits = _mm256_set1_epi64x(i64::from(bits));
            _mm256_castsi256_pd(_mm256_cmpeq_epi64(_mm256_and_si256(bits, places), places))
        })
    }

    /// The largest negative number that is finite: `larger` takes it for NaN, too.
    #[inline(always)]
    fn floor(empty: __m256d) -> F64x4 {
        F64x4::select(
            empty,
            F64x4::splat(f64::NEG_INFINITY),
            F64x4::splat(f64::MIN),
        )
    }

    #[inline(always)]
    fn or_lowest(self) -> F64x4 {
        self.larger(F64x4::splat(f64::MIN))
    }

    /// Knuth's TwoSum of the larger operand `p` and the smaller one `q`, for all finite operands.
    ///
    /// `s` is the nearest float to `p + q`, and the error `e` is exact if nothing overflows (sums
    /// below the normal range are exact). If `e > 0` the true sum lies strictly between `s` and the
    /// next float.
    ///
    /// *Overflow.* If `s` is infinite, it is either `+inf`, which no step changes, or `-inf`, from
    /// which comes `-inf` or NaN and so the floor. Let `s` be finite.
    /// - Same signs: `s` is the one of largest magnitude, `s - p` and `s - (s - p)` lie between 0
    ///   and `s`, and the differences from `p` and `q` are smaller.
    /// - `p >= 0 >= q`, so that `q <= s <= p`. `p - s` is `|q| + e` rounded, which overflows only
    ///   if `q = f64::MIN` and `e` is at least half the distance of the largest floats, hence
    ///   positive; then `s - p = -inf`, `p - inf = -inf`, `q + inf = inf`, and their sum is NaN:
    ///   the step is made for NaN. Otherwise `t = p - s` is finite. `s + t` cannot overflow for
    ///   `s <= 0`; for `s >= p / 2` the difference `t` is exact (Sterbenz), and `s + t = p`. For
    ///   `0 < s < p / 2` it could only if `p` were so large that `|q| >= p / 2` had bits of the
    ///   weight of half of the last bit of `p` and higher only; then `s = p + q` is exact
    ///   (Sterbenz), `t = -q` too, and `s + t = p`. The last differences are of the size of errors.
    ///
    /// NaN comes from infinite operands, too: with `s = +inf` the step leaves `s`, and the rest is
    /// the floor.
    #[inline(always)]
    fn sum_up(self, other: F64x4) -> F64x4 {
        let (p, q) = (self.larger(other), self.smaller(other));
        simd!({
            let s = _mm256_add_pd(p.0, q.0);
            let from_q = _mm256_sub_pd(s, p.0);
            let from_p = _mm256_sub_pd(s, from_q);
            let e = _mm256_add_pd(_mm256_sub_pd(p.0, from_p), _mm256_sub_pd(q.0, from_q));
            let above = _mm256_cmp_pd::<_CMP_NLE_UQ>(e, _mm256_setzero_pd());
            F64x4(s).raised(above)
        })
    }

    /// `x y - p` is exact if `|p| >= 2^-960`: a multiple of `ulp(x) ulp(y) > 2^-1068` of at most 53
    /// bits.
    #[inline(always)]
    fn product(self, other: F64x4) -> Nearest {
        simd!({
            let p = _mm256_mul_pd(self.0, other.0);
            let e = _mm256_fmsub_pd(self.0, other.0, p);
            Nearest {
                value: F64x4(p),
                error: F64x4(e),
            }
        })
    }

    /// The same for `-x y`, as one fused operation `-(x y) - 0`.
    #[inline(always)]
    fn negated_product(self, other: F64x4) -> Nearest {
        simd!({
            let p = _mm256_fnmsub_pd(self.0, other.0, _mm256_setzero_pd());
            let e = _mm256_fnmsub_pd(self.0, other.0, p);
            Nearest {
                value: F64x4(p),
                error: F64x4(e),
            }
        })
    }

    /// Where the nearest products are equal, the larger error tells whether the larger true product
    /// is above. Errors of the smaller one count as zero.
    #[inline(always)]
    fn larger_upper(a: Nearest, b: Nearest) -> Nearest {
        let error_a = a.error.kept(b.value.at_most(a.value));
        let error_b = b.error.kept(a.value.at_most(b.value));
        Nearest {
            value: a.value.larger(b.value),
            error: error_a.larger(error_b),
        }
    }

    /// The first question finds products that are NaN or small, zero among them; then it is seen
    /// whether these come from a factor zero.
    ///
    /// Elsewhere the error is exact, or the product overflowed: then `+inf` has the error `-inf` or NaN
    /// and stays, `-inf` gives `-inf` or NaN and so the floor.
    #[inline(always)]
    fn proved<const N: usize>(
        mut products: [Nearest; N],
        factors: [(F64x4, F64x4); N],
    ) -> ([Nearest; N], u32) {
        let small = F64x4::splat(SMALL);
        let mut unusual = simd!(_mm256_setzero_pd());
        for product in &products {
            let size = product.value.abs();
            let not_large = simd!(_mm256_cmp_pd::<_CMP_NGE_UQ>(size.0, small.0));
            unusual = F64x4::either(unusual, not_large);
        }
        if F64x4::bits(unusual) == 0 {
            return (products, 0);
        }
        let zero = F64x4::splat(0.0);
        let mut open = simd!(_mm256_setzero_pd());
        for (product, (x, y)) in products.iter_mut().zip(factors) {
            let tiny = F64x4::without(small.above(product.value.abs()), x.equals(zero));
            open = F64x4::either(open, F64x4::without(tiny, y.equals(zero)));
            let number = product.value.equals(product.value);
            product.value = product.value.kept(number);
            product.error = product.error.kept(number);
        }
        (products, F64x4::bits(open))
    }

    /// With `r = n - q d`: `n / d - q = r / d` has the sign of `r`.
    ///
    /// Let `|n|, |q| >= 2^-960`, `n` and `q` finite, `u = ulp(q) ulp(d)`.
    /// `|r| <= d ulp(q) / 2 < 2^52 u`, and `|n|` is nearly `|q| d >= 2^52 u`, so `n` and `q d` are
    /// multiples of `u > |q| d 2^-106 > 2^-1068`: `r` is a float, and the fused operation gives it.
    /// `q = +inf` has the remainder `-inf` or NaN and stays; `q = -inf` gives `-inf` or NaN and so
    /// the floor. `n = 0` and `d = inf` give the exact quotient 0 and the remainder 0 or NaN.
    #[inline(always)]
    fn quotient(self, divisor: F64x4) -> (Nearest, __m256d) {
        let value = F64x4(simd!(_mm256_div_pd(self.0, divisor.0)));
        let error = F64x4(simd!(_mm256_fnmadd_pd(value.0, divisor.0, self.0)));
        let size = self.abs().smaller(value.abs());
        let small = F64x4::splat(SMALL).above(size);
        let exact = self.equals(F64x4::splat(0.0));
        let finite = F64x4::splat(f64::INFINITY).above(divisor);
        let open = F64x4::both(F64x4::without(small, exact), finite);
        (Nearest { value, error }, open)
    }

    /// With `r = a - s^2`: `sqrt(a) - s` has the sign of `r`, which is a float for `a >= 2^-960`: a
    /// multiple of `ulp(s)^2 > 2^-1068`, at most `2^53` of them. For `a = inf` it is NaN.
    #[inline(always)]
    fn root(self) -> (Nearest, __m256d) {
        let value = F64x4(simd!(_mm256_sqrt_pd(self.0)));
        let error = F64x4(simd!(_mm256_fnmadd_pd(value.0, value.0, self.0)));
        let small = F64x4::splat(SMALL).above(self);
        let open = F64x4::both(small, self.above(F64x4::splat(0.0)));
        (Nearest { value, error }, open)
    }

    #[inline(always)]
    fn negated_root(self) -> (Nearest, __m256d) {
        let (root, open) = self.root();
        let negated = Nearest {
            value: root.value.negated(),
            error: root.error.negated(),
        };
        (negated, open)
    }

    #[inline(always)]
    fn round_up(value: Nearest) -> F64x4 {
        let above = value.error.above(F64x4::splat(0.0));
        value.value.raised(above)
    }

    outlined! {
            #[target_feature(enable = "avx2,fma")]
            mul(a: &Interval8, b: &Interval8) = basic::mul::<F64x4>(a, b);
            scale(a: &Interval8, factor: Interval) = basic::scale::<F64x4>(a, factor);
        div(a: &Interval8, b: &Interval8) = basic::div::<F64x4>(a, b);
            sqr(a: &Interval8) = basic::sqr::<F64x4>(a);
            sqrt(a: &Interval8) = basic::sqrt::<F64x4>(a);
            exp(a: &Interval8) = elementary::exp::<F64x4>(a);
            ln(a: &Interval8) = elementary::ln::<F64x4>(a);
            sin(a: &Interval8) = elementary::sin::<F64x4>(a);
            cos(a: &Interval8) = elementary::cos::<F64x4>(a);
            tan(a: &Interval8) = elementary::tan::<F64x4>(a);
            atan(a: &Interval8) = elementary::atan::<F64x4>(a);
            tanh(a: &Interval8) = elementary::tanh::<F64x4>(a);
            powi(a: &Interval8, n: i32) = match u32::try_from(n) {
        Ok(n @ 2..=power::MOST) => power::powi::<F64x4>(a, n),
        _ => a.map(|x| x.powi(n)),
    };
        }
}

impl F64x4 {
    /// The next float above where the mask is set, for normal numbers; `-inf` gives NaN there.
    ///
    /// Proof. Let `2^k <= |s| < 2^(k+1)`, `u = 2^(k-52)` the distance of the floats in that range,
    /// `w = |s| φ` with `φ = 2^-53 (1 + 2^-52)`. So `u/2 < w < u (1 + 2^-52)`, and `s + w` is
    /// rounded once. For `s > 0` it is nearer to `s + u` than to any other float:
    /// `s + u <= 2^(k+1)`, and beyond it the floats are not closer. For `s < 0` and
    /// `|s| >= 2^k + 2u` the number `|s| - w` stays above `2^k` and is nearest to `|s| - u`; for
    /// `|s| = 2^k + u` it is `2^k + u/2` less a little. For `|s| = 2^k` it is
    /// `2^k - u/2 - u 2^-53`, where the floats below are `u/2` apart, or `u` for the smallest
    /// normal number. Above the largest float the sum rounds to infinity, as it shall.
    #[inline(always)]
    fn raised(self, mask: __m256d) -> F64x4 {
        let size = self.kept(mask).abs();
        F64x4(simd!(_mm256_fmadd_pd(size.0, _mm256_set1_pd(STEP), self.0)))
    }
}
