//! AVX2: eight lanes for boxes, four for triangles.
#![allow(unsafe_code)]

use std::arch::x86_64::*;

use super::super::node::WIDTH;
use super::super::stack::Stack;
use super::{Lanes, Sorter};

/// Proof that the processor has AVX2.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Avx2(());

impl Avx2 {
    /// `None` where the processor lacks it.
    pub fn detect() -> Option<Self> {
        is_x86_feature_detected!("avx2").then_some(Self(()))
    }
}

macro_rules! lanes {
    ($width:literal, $vector:ty, $p:ident) => {
        // SAFETY of every call below: `self` exists only where `detect` found AVX2, and loads and stores are unaligned
        // ones on arrays of the vector's size.
        impl Lanes<$width> for Avx2 {
            type F = $vector;
            type M = $vector;

            #[inline(always)]
            fn splat(self, x: f32) -> $vector {
                unsafe { $p!(set1_ps)(x) }
            }
            #[inline(always)]
            fn load(self, from: &[f32; $width]) -> $vector {
                unsafe { $p!(loadu_ps)(from.as_ptr()) }
            }
            #[inline(always)]
            fn store(self, x: $vector) -> [f32; $width] {
                let mut to = [0.0; $width];
                unsafe { $p!(storeu_ps)(to.as_mut_ptr(), x) };
                to
            }
            #[inline(always)]
            fn add(self, a: $vector, b: $vector) -> $vector {
                unsafe { $p!(add_ps)(a, b) }
            }
            #[inline(always)]
            fn sub(self, a: $vector, b: $vector) -> $vector {
                unsafe { $p!(sub_ps)(a, b) }
            }
            #[inline(always)]
            fn mul(self, a: $vector, b: $vector) -> $vector {
                unsafe { $p!(mul_ps)(a, b) }
            }
            #[inline(always)]
            fn div(self, a: $vector, b: $vector) -> $vector {
                unsafe { $p!(div_ps)(a, b) }
            }
            #[inline(always)]
            fn min(self, a: $vector, b: $vector) -> $vector {
                unsafe { $p!(min_ps)(a, b) }
            }
            #[inline(always)]
            fn max(self, a: $vector, b: $vector) -> $vector {
                unsafe { $p!(max_ps)(a, b) }
            }
            #[inline(always)]
            fn le(self, a: $vector, b: $vector) -> $vector {
                unsafe { $p!(cmp_le_ps)(a, b) }
            }
            #[inline(always)]
            fn lt(self, a: $vector, b: $vector) -> $vector {
                unsafe { $p!(cmp_lt_ps)(a, b) }
            }
            #[inline(always)]
            fn and(self, a: $vector, b: $vector) -> $vector {
                unsafe { $p!(and_ps)(a, b) }
            }
            #[inline(always)]
            fn or(self, a: $vector, b: $vector) -> $vector {
                unsafe { $p!(or_ps)(a, b) }
            }
            #[inline(always)]
            fn bits(self, a: $vector) -> u32 {
                unsafe { $p!(movemask_ps)(a).cast_unsigned() }
            }
        }
    };
}

macro_rules! wide {
    (set1_ps) => { _mm256_set1_ps };
    (loadu_ps) => { _mm256_loadu_ps };
    (storeu_ps) => { _mm256_storeu_ps };
    (add_ps) => { _mm256_add_ps };
    (sub_ps) => { _mm256_sub_ps };
    (mul_ps) => { _mm256_mul_ps };
    (div_ps) => { _mm256_div_ps };
    (min_ps) => { _mm256_min_ps };
    (max_ps) => { _mm256_max_ps };
    (cmp_le_ps) => { _mm256_cmp_ps::<_CMP_LE_OQ> };
    (cmp_lt_ps) => { _mm256_cmp_ps::<_CMP_LT_OQ> };
    (and_ps) => { _mm256_and_ps };
    (or_ps) => { _mm256_or_ps };
    (movemask_ps) => { _mm256_movemask_ps };
}
macro_rules! narrow {
    (set1_ps) => { _mm_set1_ps };
    (loadu_ps) => { _mm_loadu_ps };
    (storeu_ps) => { _mm_storeu_ps };
    (add_ps) => { _mm_add_ps };
    (sub_ps) => { _mm_sub_ps };
    (mul_ps) => { _mm_mul_ps };
    (div_ps) => { _mm_div_ps };
    (min_ps) => { _mm_min_ps };
    (max_ps) => { _mm_max_ps };
    (cmp_le_ps) => { _mm_cmp_ps::<_CMP_LE_OQ> };
    (cmp_lt_ps) => { _mm_cmp_ps::<_CMP_LT_OQ> };
    (and_ps) => { _mm_and_ps };
    (or_ps) => { _mm_or_ps };
    (movemask_ps) => { _mm_movemask_ps };
}
lanes!(8, __m256, wide);
lanes!(4, __m128, narrow);

impl Sorter for Avx2 {
    /// Sorts the eight lanes at once (a bitonic network in six steps, no branch to mispredict) by distance, whose three
    /// lowest bits give way to the lane's number; that only moves a box nearer.
    #[inline(always)]
    fn push_sorted(self, near: __m256, hit: __m256, children: &[u32; WIDTH], stack: &mut Stack) {
        /// Orders each lane with its partner, the larger in the lower lane; `$keep_less` marks the upper lanes.
        macro_rules! exchange {
            ($keys:expr, $partner:expr, $keep_less:literal) => {{
                let (keys, partner) = ($keys, $partner);
                _mm256_blend_epi32::<$keep_less>(_mm256_max_epi32(keys, partner), _mm256_min_epi32(keys, partner))
            }};
        }
        // SAFETY: AVX2 by `self`; the load reads the eight children.
        unsafe {
            let lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
            let distance = _mm256_and_si256(_mm256_castps_si256(near), _mm256_set1_epi32(0x7fff_fff8));
            let missed = _mm256_xor_si256(_mm256_castps_si256(hit), _mm256_set1_epi32(-1));
            let mut keys = _mm256_or_si256(_mm256_or_si256(distance, lane), missed);
            keys = exchange!(keys, _mm256_shuffle_epi32::<0b10_11_00_01>(keys), 0b1010_1010);
            keys = exchange!(keys, _mm256_shuffle_epi32::<0b00_01_10_11>(keys), 0b1100_1100);
            keys = exchange!(keys, _mm256_shuffle_epi32::<0b10_11_00_01>(keys), 0b1010_1010);
            let reversed = _mm256_shuffle_epi32::<0b00_01_10_11>(_mm256_permute2x128_si256::<1>(keys, keys));
            keys = exchange!(keys, reversed, 0b1111_0000);
            keys = exchange!(keys, _mm256_shuffle_epi32::<0b01_00_11_10>(keys), 0b1100_1100);
            keys = exchange!(keys, _mm256_shuffle_epi32::<0b10_11_00_01>(keys), 0b1010_1010);
            let children = _mm256_loadu_si256(children.as_ptr().cast());
            let children = _mm256_permutevar8x32_epi32(children, keys);
            let count = Lanes::<8>::bits(self, hit).count_ones() as usize;
            let (near_slots, child_slots) = stack.reserve(count);
            _mm256_storeu_si256(near_slots.as_mut_ptr().cast(), keys);
            _mm256_storeu_si256(child_slots.as_mut_ptr().cast(), children);
        }
    }
}
