//! Eight floats in a register of AVX-512, whose instructions round upward by themselves.
//!
//! The rounding is part of each instruction; no state of the processor is touched. So every bound
//! is the tight one, below the normal range and above the largest float, too.
#![allow(
    unused_unsafe,
    reason = "the instructions are safe where the whole program is compiled for them"
)]

use std::arch::x86_64::*;

use super::elementary;
use super::vector::Vector;
use super::{Floats, Interval8, power};

const UP: i32 = _MM_FROUND_TO_POS_INF | _MM_FROUND_NO_EXC;
const DOWN: i32 = _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC;

/// Eight floats.
#[derive(Clone, Copy)]
pub(super) struct F64x8(__m512d);

/// One or more instructions on registers.
macro_rules! simd {
    ($($instructions:tt)+) => {
        // SAFETY: values of this type exist only in kernels that `Path::run` has started after it found
        // AVX-512 in this processor, and the instructions have no other requirement.
        unsafe { $($instructions)+ }
    };
}

mod wide;

impl F64x8 {
    /// 0 for NaN: products of zero and an infinity.
    #[inline(always)]
    fn or_zero(self) -> F64x8 {
        F64x8(simd!({
            let number = _mm512_cmp_pd_mask::<_CMP_ORD_Q>(self.0, self.0);
            _mm512_maskz_mov_pd(number, self.0)
        }))
    }
}

impl Vector for F64x8 {
    type Mask = __mmask8;
    type Upper = F64x8;
    const WIDTH: usize = 8;

    #[inline(always)]
    fn load(from: &Floats, _: usize) -> F64x8 {
        // SAFETY: there are eight floats; no alignment is required.
        F64x8(unsafe { _mm512_loadu_pd(from.as_ptr()) })
    }

    #[inline(always)]
    fn store(self, to: &mut Floats, _: usize) {
        // SAFETY: there is room for eight floats; no alignment is required.
        unsafe { _mm512_storeu_pd(to.as_mut_ptr(), self.0) }
    }

    #[inline(always)]
    fn splat(x: f64) -> F64x8 {
        F64x8(simd!(_mm512_set1_pd(x)))
    }

    #[inline(always)]
    fn negated(self) -> F64x8 {
        F64x8(simd!(_mm512_xor_pd(self.0, _mm512_set1_pd(-0.0))))
    }

    #[inline(always)]
    fn abs(self) -> F64x8 {
        F64x8(simd!(_mm512_andnot_pd(_mm512_set1_pd(-0.0), self.0)))
    }

    #[inline(always)]
    fn larger(self, other: F64x8) -> F64x8 {
        F64x8(simd!(_mm512_max_pd(self.0, other.0)))
    }

    #[inline(always)]
    fn smaller(self, other: F64x8) -> F64x8 {
        F64x8(simd!(_mm512_min_pd(self.0, other.0)))
    }

    #[inline(always)]
    fn above(self, other: F64x8) -> __mmask8 {
        simd!(_mm512_cmp_pd_mask::<_CMP_GT_OQ>(self.0, other.0))
    }

    #[inline(always)]
    fn at_most(self, other: F64x8) -> __mmask8 {
        simd!(_mm512_cmp_pd_mask::<_CMP_LE_OQ>(self.0, other.0))
    }

    #[inline(always)]
    fn equals(self, other: F64x8) -> __mmask8 {
        simd!(_mm512_cmp_pd_mask::<_CMP_EQ_OQ>(self.0, other.0))
    }

    #[inline(always)]
    fn both(a: __mmask8, b: __mmask8) -> __mmask8 {
        a & b
    }

    #[inline(always)]
    fn either(a: __mmask8, b: __mmask8) -> __mmask8 {
        a | b
    }

    #[inline(always)]
    fn without(a: __mmask8, b: __mmask8) -> __mmask8 {
        a & !b
    }

    #[inline(always)]
    fn select(mask: __mmask8, a: F64x8, b: F64x8) -> F64x8 {
        F64x8(simd!(_mm512_mask_blend_pd(mask, b.0, a.0)))
    }

    #[inline(always)]
    fn bits(mask: __mmask8) -> u32 {
        u32::from(mask)
    }

    #[inline(always)]
    fn mask(bits: u32) -> __mmask8 {
        bits as u8
    }

    /// A finite sum that is rounded up is never `-inf`.
    #[inline(always)]
    fn floor(_: __mmask8) -> F64x8 {
        F64x8::splat(f64::NEG_INFINITY)
    }

    #[inline(always)]
    fn or_lowest(self) -> F64x8 {
        self
    }

    #[inline(always)]
    fn sum_up(self, other: F64x8) -> F64x8 {
        F64x8(simd!(_mm512_add_round_pd::<UP>(self.0, other.0)))
    }

    #[inline(always)]
    fn product(self, other: F64x8) -> F64x8 {
        F64x8(simd!(_mm512_mul_round_pd::<UP>(self.0, other.0))).or_zero()
    }

    /// The fused operation `-(x y) - 0` is rounded once.
    #[inline(always)]
    fn negated_product(self, other: F64x8) -> F64x8 {
        let product = simd!(_mm512_fnmsub_round_pd::<UP>(
            self.0,
            other.0,
            _mm512_setzero_pd()
        ));
        F64x8(product).or_zero()
    }

    #[inline(always)]
    fn larger_upper(a: F64x8, b: F64x8) -> F64x8 {
        a.larger(b)
    }

    #[inline(always)]
    fn proved<const N: usize>(products: [F64x8; N], _: [(F64x8, F64x8); N]) -> ([F64x8; N], u32) {
        (products, 0)
    }

    #[inline(always)]
    fn quotient(self, divisor: F64x8) -> (F64x8, __mmask8) {
        let quotient = simd!(_mm512_div_round_pd::<UP>(self.0, divisor.0));
        (F64x8(quotient), 0)
    }

    #[inline(always)]
    fn root(self) -> (F64x8, __mmask8) {
        (F64x8(simd!(_mm512_sqrt_round_pd::<UP>(self.0))), 0)
    }

    #[inline(always)]
    fn negated_root(self) -> (F64x8, __mmask8) {
        let root = F64x8(simd!(_mm512_sqrt_round_pd::<DOWN>(self.0)));
        (root.negated(), 0)
    }

    #[inline(always)]
    fn round_up(value: F64x8) -> F64x8 {
        value
    }

    outlined! {
            #[target_feature(enable = "avx512f,avx512dq,avx512vl")]
            exp(a: &Interval8) = elementary::exp::<F64x8>(a);
            ln(a: &Interval8) = elementary::ln::<F64x8>(a);
            sin(a: &Interval8) = elementary::sin::<F64x8>(a);
            cos(a: &Interval8) = elementary::cos::<F64x8>(a);
            tan(a: &Interval8) = elementary::tan::<F64x8>(a);
            atan(a: &Interval8) = elementary::atan::<F64x8>(a);
            tanh(a: &Interval8) = elementary::tanh::<F64x8>(a);
            powi(a: &Interval8, n: i32) = match u32::try_from(n) {
        Ok(n @ 2..=power::MOST) => power::powi::<F64x8>(a, n),
        _ => a.map(|x| x.powi(n)),
    };
        }
}
