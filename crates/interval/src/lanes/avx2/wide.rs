//! Nearest arithmetic, bits and tables of four floats, for the elementary functions.
#![allow(
    unused_unsafe,
    reason = "the instructions are safe where the whole program is compiled for them"
)]

use std::arch::x86_64::*;

use super::F64x4;
use crate::lanes::elementary::Wide;

impl Wide for F64x4 {
    #[inline(always)]
    fn plus(self, other: F64x4) -> F64x4 {
        F64x4(simd!(_mm256_add_pd(self.0, other.0)))
    }

    #[inline(always)]
    fn minus(self, other: F64x4) -> F64x4 {
        F64x4(simd!(_mm256_sub_pd(self.0, other.0)))
    }

    #[inline(always)]
    fn times(self, other: F64x4) -> F64x4 {
        F64x4(simd!(_mm256_mul_pd(self.0, other.0)))
    }

    #[inline(always)]
    fn over(self, other: F64x4) -> F64x4 {
        F64x4(simd!(_mm256_div_pd(self.0, other.0)))
    }

    #[inline(always)]
    fn times_plus(self, a: F64x4, b: F64x4) -> F64x4 {
        F64x4(simd!(_mm256_fmadd_pd(self.0, a.0, b.0)))
    }

    #[inline(always)]
    fn times_minus(self, a: F64x4, b: F64x4) -> F64x4 {
        F64x4(simd!(_mm256_fmsub_pd(self.0, a.0, b.0)))
    }

    #[inline(always)]
    fn times_from(self, a: F64x4, b: F64x4) -> F64x4 {
        F64x4(simd!(_mm256_fnmadd_pd(self.0, a.0, b.0)))
    }

    #[inline(always)]
    fn floor_of(self) -> F64x4 {
        F64x4(simd!(_mm256_floor_pd(self.0)))
    }

    #[inline(always)]
    fn bits_plus(self, other: F64x4) -> F64x4 {
        F64x4(simd!(_mm256_castsi256_pd(_mm256_add_epi64(
            _mm256_castpd_si256(self.0),
            _mm256_castpd_si256(other.0)
        ))))
    }

    #[inline(always)]
    fn bits_minus(self, other: F64x4) -> F64x4 {
        F64x4(simd!(_mm256_castsi256_pd(_mm256_sub_epi64(
            _mm256_castpd_si256(self.0),
            _mm256_castpd_si256(other.0)
        ))))
    }

    #[inline(always)]
    fn bits_or(self, other: F64x4) -> F64x4 {
        F64x4(simd!(_mm256_or_pd(self.0, other.0)))
    }

    #[inline(always)]
    fn bits_left<const N: u32>(self) -> F64x4 {
        F64x4(simd!(_mm256_castsi256_pd(_mm256_sll_epi64(
            _mm256_castpd_si256(self.0),
            _mm_cvtsi64_si128(i64::from(N))
        ))))
    }

    #[inline(always)]
    fn bits_right<const N: u32>(self) -> F64x4 {
        F64x4(simd!(_mm256_castsi256_pd(_mm256_srl_epi64(
            _mm256_castpd_si256(self.0),
            _mm_cvtsi64_si128(i64::from(N))
        ))))
    }

    #[inline(always)]
    fn pairs<const M: usize>(self, table: &[[f64; 2]; M]) -> [F64x4; 2] {
        let [a, b, c, d] = self.places::<M>();
        let (a, b, c, d) = (&table[a], &table[b], &table[c], &table[d]);
        // SAFETY: each pair has two floats; the instructions are there as for `simd`.
        unsafe {
            let even = _mm256_loadu2_m128d(c.as_ptr(), a.as_ptr());
            let odd = _mm256_loadu2_m128d(d.as_ptr(), b.as_ptr());
            [
                F64x4(_mm256_unpacklo_pd(even, odd)),
                F64x4(_mm256_unpackhi_pd(even, odd)),
            ]
        }
    }

    #[inline(always)]
    fn rows<const M: usize>(self, table: &[[f64; 4]; M]) -> [F64x4; 4] {
        let [a, b, c, d] = self.places::<M>();
        let (a, b, c, d) = (&table[a], &table[b], &table[c], &table[d]);
        // SAFETY: each row has four floats; the instructions are there as for `simd`.
        unsafe {
            let (a, b) = (_mm256_loadu_pd(a.as_ptr()), _mm256_loadu_pd(b.as_ptr()));
            let (c, d) = (_mm256_loadu_pd(c.as_ptr()), _mm256_loadu_pd(d.as_ptr()));
            let (ab_even, ab_odd) = (_mm256_unpacklo_pd(a, b), _mm256_unpackhi_pd(a, b));
            let (cd_even, cd_odd) = (_mm256_unpacklo_pd(c, d), _mm256_unpackhi_pd(c, d));
            [
                F64x4(_mm256_permute2f128_pd::<0x20>(ab_even, cd_even)),
                F64x4(_mm256_permute2f128_pd::<0x20>(ab_odd, cd_odd)),
                F64x4(_mm256_permute2f128_pd::<0x31>(ab_even, cd_even)),
                F64x4(_mm256_permute2f128_pd::<0x31>(ab_odd, cd_odd)),
            ]
        }
    }
}

impl F64x4 {
    /// The lowest bits of each float, a number below `M`.
    #[inline(always)]
    fn places<const M: usize>(self) -> [usize; 4] {
        const { assert!(M.is_power_of_two()) };
        let mut bits = [0_u64; 4];
        // SAFETY: there is room for four numbers; the instructions are there as for `simd`.
        unsafe { _mm256_storeu_si256(bits.as_mut_ptr().cast(), _mm256_castpd_si256(self.0)) };
        let [a, b, c, d] = bits;
        [
            a as usize & (M - 1),
            b as usize & (M - 1),
            c as usize & (M - 1),
            d as usize & (M - 1),
        ]
    }
}
