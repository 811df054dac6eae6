//! [`Lanes`] with AVX2. Invariant: a value of [`Avx2`], and hence any of its lanes, exists only on a
//! processor with AVX2, which makes each `unsafe` below sound.
#![allow(unsafe_code, reason = "vector instructions, behind a proof that the processor has them")]

use super::simd::{Eight, Kernel, Lanes, Mask, Simd, WIDTH};
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Not, Sub};

/// Proof that the processor has AVX2.
#[derive(Clone, Copy, Debug)]
pub(super) struct Avx2(());

impl Avx2 {
    pub(super) fn detect() -> Option<Self> {
        is_x86_feature_detected!("avx2").then_some(Self(()))
    }

    #[inline]
    pub(super) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        #[target_feature(enable = "avx2")]
        fn compiled<K: Kernel>(simd: Avx2, kernel: K) -> K::Output {
            kernel.run(simd)
        }
        // SAFETY: `self` proves AVX2.
        unsafe { compiled(self, kernel) }
    }
}

/// Lanes of [`Avx2`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Avx2Lanes(__m256);

/// Truth values of [`Avx2Lanes`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Avx2Mask(__m256);

impl Simd for Avx2 {
    type Lanes = Avx2Lanes;
    #[inline(always)]
    fn splat(self, value: f32) -> Avx2Lanes {
        // SAFETY: `self` proves AVX2.
        Avx2Lanes(unsafe { _mm256_set1_ps(value) })
    }
    #[inline(always)]
    fn load(self, values: &Eight) -> Avx2Lanes {
        // SAFETY: `self` proves AVX2; `Eight` is eight singles, aligned to 32 bytes.
        Avx2Lanes(unsafe { _mm256_load_ps(values.0.as_ptr()) })
    }
    #[inline(always)]
    fn store(self, lanes: Avx2Lanes) -> [f32; WIDTH] {
        let mut values = [0.0; WIDTH];
        // SAFETY: `self` proves AVX2; the array holds eight singles and the store needs no alignment.
        unsafe { _mm256_storeu_ps(values.as_mut_ptr(), lanes.0) };
        values
    }
    #[inline(always)]
    fn prefetch<T>(self, soon_read: &T) {
        super::prefetch(soon_read);
    }
}

/// Implements an operator of lanes or masks that is one instruction.
macro_rules! operator {
    ($type:ident, $trait:ident, $method:ident, $instruction:ident) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: lanes and masks exist only where AVX2 does.
                Self(unsafe { $instruction(self.0, other.0) })
            }
        }
    };
}
operator!(Avx2Lanes, Add, add, _mm256_add_ps);
operator!(Avx2Lanes, Sub, sub, _mm256_sub_ps);
operator!(Avx2Lanes, Mul, mul, _mm256_mul_ps);
operator!(Avx2Lanes, Div, div, _mm256_div_ps);
operator!(Avx2Mask, BitAnd, bitand, _mm256_and_ps);
operator!(Avx2Mask, BitOr, bitor, _mm256_or_ps);
operator!(Avx2Mask, BitXor, bitxor, _mm256_xor_ps);

impl Lanes for Avx2Lanes {
    type Mask = Avx2Mask;
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: lanes exist only where AVX2 does.
        Self(unsafe { _mm256_min_ps(self.0, other.0) })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: lanes exist only where AVX2 does.
        Self(unsafe { _mm256_max_ps(self.0, other.0) })
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Avx2Mask {
        // SAFETY: lanes exist only where AVX2 does.
        Avx2Mask(unsafe { _mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn le(self, other: Self) -> Avx2Mask {
        // SAFETY: lanes exist only where AVX2 does.
        Avx2Mask(unsafe { _mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Avx2Mask {
        // SAFETY: lanes exist only where AVX2 does.
        Avx2Mask(unsafe { _mm256_cmp_ps::<_CMP_EQ_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn or_else(self, mask: Avx2Mask, other: Self) -> Self {
        // SAFETY: lanes exist only where AVX2 does.
        Self(unsafe { _mm256_blendv_ps(other.0, self.0, mask.0) })
    }
}

impl Not for Avx2Mask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        // SAFETY: masks exist only where AVX2 does.
        Self(unsafe { _mm256_xor_ps(self.0, _mm256_castsi256_ps(_mm256_set1_epi32(-1))) })
    }
}

impl Mask for Avx2Mask {
    #[inline(always)]
    fn bits(self) -> u32 {
        // SAFETY: masks exist only where AVX2 does.
        (unsafe { _mm256_movemask_ps(self.0) }) as u32
    }
}
