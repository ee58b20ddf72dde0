//! Eight lanes of AVX2.
#![allow(unsafe_code)]

use std::arch::x86_64::*;

use super::super::node::{Leaf, WIDTH};
use super::super::stack::{Len, Stack};
use super::Lanes;

/// Proof that the processor has AVX2.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Avx2(());

impl Avx2 {
    /// `None` where the processor lacks it, or the bit instructions that came with it.
    pub fn detect() -> Option<Self> {
        let found = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt");
        found.then_some(Self(()))
    }
}

/// A method that is one instruction.
macro_rules! instruction {
    ($name:ident($($argument:ident: $kind:ty),*) -> $result:ty = $intrinsic:expr) => {
        #[inline(always)]
        fn $name(self, $($argument: $kind),*) -> $result {
            // SAFETY: `self` exists only where `detect` found AVX2.
            unsafe { $intrinsic($($argument),*) }
        }
    };
}

impl Lanes for Avx2 {
    type F = __m256;
    type M = __m256;

    instruction!(splat(x: f32) -> __m256 = _mm256_set1_ps);
    instruction!(add(a: __m256, b: __m256) -> __m256 = _mm256_add_ps);
    instruction!(sub(a: __m256, b: __m256) -> __m256 = _mm256_sub_ps);
    instruction!(mul(a: __m256, b: __m256) -> __m256 = _mm256_mul_ps);
    instruction!(div(a: __m256, b: __m256) -> __m256 = _mm256_div_ps);
    instruction!(min(a: __m256, b: __m256) -> __m256 = _mm256_min_ps);
    instruction!(max(a: __m256, b: __m256) -> __m256 = _mm256_max_ps);
    instruction!(le(a: __m256, b: __m256) -> __m256 = _mm256_cmp_ps::<_CMP_LE_OQ>);
    instruction!(lt(a: __m256, b: __m256) -> __m256 = _mm256_cmp_ps::<_CMP_LT_OQ>);
    instruction!(and(a: __m256, b: __m256) -> __m256 = _mm256_and_ps);
    instruction!(or(a: __m256, b: __m256) -> __m256 = _mm256_or_ps);

    #[inline(always)]
    fn select(self, m: __m256, a: __m256, b: __m256) -> __m256 {
        // SAFETY: AVX2 by `self`.
        unsafe { _mm256_blendv_ps(b, a, m) }
    }

    #[inline(always)]
    fn copysign(self, a: __m256, sign: __m256) -> __m256 {
        // SAFETY: AVX2 by `self`.
        unsafe {
            let bit = _mm256_set1_ps(-0.0);
            _mm256_or_ps(_mm256_andnot_ps(bit, a), _mm256_and_ps(bit, sign))
        }
    }

    #[inline(always)]
    fn signs(self, a: __m256) -> u32 {
        // SAFETY: AVX2 by `self`.
        unsafe { _mm256_movemask_ps(a).cast_unsigned() }
    }

    #[inline(always)]
    fn load(self, from: &[f32; WIDTH]) -> __m256 {
        // SAFETY: AVX2 by `self`; reads the array, with no demand on its alignment.
        unsafe { _mm256_loadu_ps(from.as_ptr()) }
    }

    #[inline(always)]
    fn store(self, x: __m256) -> [f32; WIDTH] {
        let mut to = [0.0; WIDTH];
        // SAFETY: AVX2 by `self`; writes the array, with no demand on its alignment.
        unsafe { _mm256_storeu_ps(to.as_mut_ptr(), x) };
        to
    }

    #[inline(always)]
    fn vertices(self, leaf: Leaf, axis: usize) -> [__m256; 3] {
        assert!(axis < 3 && leaf.rows.len() >= 8 * leaf.count + WIDTH);
        let row = |row: usize| {
            // SAFETY: AVX2 by `self`; row 8 is the last, and by the assertion eight numbers follow its start.
            unsafe { _mm256_loadu_ps(leaf.rows.as_ptr().add(row * leaf.count)) }
        };
        [row(axis), row(3 + axis), row(6 + axis)]
    }

    #[inline(always)]
    fn first(self, count: usize) -> __m256 {
        const ALL_THEN_NONE: [u32; 2 * WIDTH] = [!0, !0, !0, !0, !0, !0, !0, !0, 0, 0, 0, 0, 0, 0, 0, 0];
        let from = &ALL_THEN_NONE[WIDTH - count..][..WIDTH];
        // SAFETY: AVX2 by `self`; the slice has eight numbers.
        unsafe { _mm256_loadu_ps(from.as_ptr().cast()) }
    }

    #[inline(always)]
    fn bits(self, a: __m256) -> u32 {
        // SAFETY: AVX2 by `self`.
        unsafe { _mm256_movemask_ps(a).cast_unsigned() }
    }

    /// Sorts the eight lanes at once (a bitonic network in six steps, no branch to mispredict) by distance, whose three
    /// lowest bits give way to the lane's number; that only moves a box nearer.
    #[inline(always)]
    fn push_sorted(
        self,
        near: __m256,
        hit: __m256,
        children: &[u32; WIDTH],
        stack: &mut Stack,
        len: &mut Len,
    ) -> usize {
        /// Orders each lane with its partner, the larger in the lower lane; `$upper` marks the upper lanes.
        macro_rules! exchange {
            ($keys:expr, $partner:expr, $upper:literal) => {{
                let (keys, partner) = ($keys, $partner);
                _mm256_blend_epi32::<$upper>(_mm256_max_epi32(keys, partner), _mm256_min_epi32(keys, partner))
            }};
        }
        let others = self.bits(hit).count_ones() as usize - 1;
        // SAFETY: AVX2 by `self`. Whole vectors fill all eight slots. Distances are not negative, so that their bits
        // sort as integers; missed lanes become -1 and sort to the end.
        unsafe {
            let lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
            let distance = _mm256_and_si256(_mm256_castps_si256(near), _mm256_set1_epi32(0x7fff_fff8));
            let missed = _mm256_xor_si256(_mm256_castps_si256(hit), _mm256_set1_epi32(-1));
            let mut keys = _mm256_or_si256(_mm256_or_si256(distance, lane), missed);
            // The nearest by itself: the traversal goes on with it while the rest is still being sorted.
            let nearest = _mm_min_epu32(_mm256_castsi256_si128(keys), _mm256_extracti128_si256::<1>(keys));
            let nearest = _mm_min_epu32(nearest, _mm_shuffle_epi32::<0b01_00_11_10>(nearest));
            let nearest = _mm_min_epu32(nearest, _mm_shuffle_epi32::<0b10_11_00_01>(nearest));
            let nearest = _mm_cvtsi128_si32(nearest) & 7;

            keys = exchange!(keys, _mm256_shuffle_epi32::<0b10_11_00_01>(keys), 0b1010_1010);
            keys = exchange!(keys, _mm256_shuffle_epi32::<0b00_01_10_11>(keys), 0b1100_1100);
            keys = exchange!(keys, _mm256_shuffle_epi32::<0b10_11_00_01>(keys), 0b1010_1010);
            let reversed = _mm256_shuffle_epi32::<0b00_01_10_11>(_mm256_permute2x128_si256::<1>(keys, keys));
            keys = exchange!(keys, reversed, 0b1111_0000);
            keys = exchange!(keys, _mm256_shuffle_epi32::<0b01_00_11_10>(keys), 0b1100_1100);
            keys = exchange!(keys, _mm256_shuffle_epi32::<0b10_11_00_01>(keys), 0b1010_1010);
            let children = _mm256_permutevar8x32_epi32(_mm256_loadu_si256(children.as_ptr().cast()), keys);
            stack.push_many(len, others, |(near_slots, child_slots)| {
                _mm256_storeu_si256(near_slots.as_mut_ptr().cast(), keys);
                _mm256_storeu_si256(child_slots.as_mut_ptr().cast(), children);
            });
            nearest as usize
        }
    }
}
