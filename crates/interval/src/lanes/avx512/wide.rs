//! Nearest arithmetic, bits and tables of eight floats, for the elementary functions.
#![allow(
    unused_unsafe,
    reason = "the instructions are safe where the whole program is compiled for them"
)]

use std::arch::x86_64::*;

use super::F64x8;
use crate::lanes::elementary::Wide;

impl Wide for F64x8 {
    #[inline(always)]
    fn plus(self, other: F64x8) -> F64x8 {
        F64x8(simd!(_mm512_add_pd(self.0, other.0)))
    }

    #[inline(always)]
    fn minus(self, other: F64x8) -> F64x8 {
        F64x8(simd!(_mm512_sub_pd(self.0, other.0)))
    }

    #[inline(always)]
    fn times(self, other: F64x8) -> F64x8 {
        F64x8(simd!(_mm512_mul_pd(self.0, other.0)))
    }

    #[inline(always)]
    fn over(self, other: F64x8) -> F64x8 {
        F64x8(simd!(_mm512_div_pd(self.0, other.0)))
    }

    #[inline(always)]
    fn times_plus(self, a: F64x8, b: F64x8) -> F64x8 {
        F64x8(simd!(_mm512_fmadd_pd(self.0, a.0, b.0)))
    }

    #[inline(always)]
    fn times_minus(self, a: F64x8, b: F64x8) -> F64x8 {
        F64x8(simd!(_mm512_fmsub_pd(self.0, a.0, b.0)))
    }

    #[inline(always)]
    fn times_from(self, a: F64x8, b: F64x8) -> F64x8 {
        F64x8(simd!(_mm512_fnmadd_pd(self.0, a.0, b.0)))
    }

    #[inline(always)]
    fn floor_of(self) -> F64x8 {
        F64x8(simd!(_mm512_roundscale_pd::<
            { _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC },
        >(self.0)))
    }

    #[inline(always)]
    fn bits_plus(self, other: F64x8) -> F64x8 {
        F64x8(simd!(_mm512_castsi512_pd(_mm512_add_epi64(
            _mm512_castpd_si512(self.0),
            _mm512_castpd_si512(other.0)
        ))))
    }

    #[inline(always)]
    fn bits_minus(self, other: F64x8) -> F64x8 {
        F64x8(simd!(_mm512_castsi512_pd(_mm512_sub_epi64(
            _mm512_castpd_si512(self.0),
            _mm512_castpd_si512(other.0)
        ))))
    }

    #[inline(always)]
    fn bits_or(self, other: F64x8) -> F64x8 {
        F64x8(simd!(_mm512_or_pd(self.0, other.0)))
    }

    #[inline(always)]
    fn bits_left<const N: u32>(self) -> F64x8 {
        F64x8(simd!(_mm512_castsi512_pd(_mm512_sll_epi64(
            _mm512_castpd_si512(self.0),
            _mm_cvtsi64_si128(i64::from(N))
        ))))
    }

    #[inline(always)]
    fn bits_right<const N: u32>(self) -> F64x8 {
        F64x8(simd!(_mm512_castsi512_pd(_mm512_srl_epi64(
            _mm512_castpd_si512(self.0),
            _mm_cvtsi64_si128(i64::from(N))
        ))))
    }

    #[inline(always)]
    fn pairs<const M: usize>(self, table: &[[f64; 2]; M]) -> [F64x8; 2] {
        let first = table.as_ptr().cast::<f64>();
        // SAFETY: the places are even and below twice the number of pairs, so two floats are in the
        // table from each on; the instructions are there as for `simd`.
        unsafe {
            let places = _mm512_slli_epi64::<1>(self.places::<M>());
            [
                F64x8(_mm512_i64gather_pd::<8>(places, first)),
                F64x8(_mm512_i64gather_pd::<8>(places, first.add(1))),
            ]
        }
    }

    #[inline(always)]
    fn rows<const M: usize>(self, table: &[[f64; 4]; M]) -> [F64x8; 4] {
        let first = table.as_ptr().cast::<f64>();
        // SAFETY: the places are multiples of four below four times the number of rows, so four
        // floats are in the table from each on; the instructions are there as for `simd`.
        unsafe {
            let places = _mm512_slli_epi64::<2>(self.places::<M>());
            [
                F64x8(_mm512_i64gather_pd::<8>(places, first)),
                F64x8(_mm512_i64gather_pd::<8>(places, first.add(1))),
                F64x8(_mm512_i64gather_pd::<8>(places, first.add(2))),
                F64x8(_mm512_i64gather_pd::<8>(places, first.add(3))),
            ]
        }
    }
}

impl F64x8 {
    /// The lowest bits of each float, a number below `M`.
    #[inline(always)]
    fn places<const M: usize>(self) -> __m512i {
        const { assert!(M.is_power_of_two()) };
        simd!(_mm512_and_si512(
            _mm512_castpd_si512(self.0),
            _mm512_set1_epi64(M as i64 - 1)
        ))
    }
}
