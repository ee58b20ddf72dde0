//! The few SIMD operations that traversal needs, over the instruction set found at run time.
//!
//! Every operation is one IEEE 754 operation per lane, and nothing is contracted, so that each instruction set computes
//! the same bits.

#[cfg(target_arch = "x86_64")]
pub(super) mod avx2;
pub(super) mod portable;

use super::node::{Leaf, WIDTH};
use super::stack::{Len, Stack};

/// Eight single-precision lanes. The implementor is a token that proves that the processor has the instructions.
pub(super) trait Lanes: Copy {
    /// Eight numbers.
    type F: Copy;
    /// Eight truth values.
    type M: Copy;

    fn splat(self, x: f32) -> Self::F;
    fn load(self, from: &[f32; WIDTH]) -> Self::F;
    fn store(self, x: Self::F) -> [f32; WIDTH];
    /// One coordinate of the first, second and third vertices of a leaf's triangles. `axis` is below 3.
    fn vertices(self, leaf: Leaf, axis: usize) -> [Self::F; 3];
    fn add(self, a: Self::F, b: Self::F) -> Self::F;
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    fn div(self, a: Self::F, b: Self::F) -> Self::F;
    /// `if a < b { a } else { b }`, which settles what becomes of NaN and -0.
    fn min(self, a: Self::F, b: Self::F) -> Self::F;
    /// `if a > b { a } else { b }`
    fn max(self, a: Self::F, b: Self::F) -> Self::F;
    /// `a <= b`
    fn le(self, a: Self::F, b: Self::F) -> Self::M;
    /// `a < b`
    fn lt(self, a: Self::F, b: Self::F) -> Self::M;
    fn and(self, a: Self::M, b: Self::M) -> Self::M;
    fn or(self, a: Self::M, b: Self::M) -> Self::M;
    /// `if m { a } else { b }`
    fn select(self, m: Self::M, a: Self::F, b: Self::F) -> Self::F;
    /// `a` with the sign of `sign`.
    fn copysign(self, a: Self::F, sign: Self::F) -> Self::F;
    /// Bit `i` is the sign of lane `i`.
    fn signs(self, a: Self::F) -> u32;
    /// The first `count` lanes, at most all of them.
    fn first(self, count: usize) -> Self::M;
    /// Bit `i` is lane `i`.
    fn bits(self, a: Self::M) -> u32;

    /// Pushes the children whose lane is set in `hit`, the farthest first, except for the nearest, whose lane it
    /// returns. At least one lane is set, and no set lane's `near` is below 0.
    fn push_sorted(
        self,
        near: Self::F,
        hit: Self::M,
        children: &[u32; WIDTH],
        stack: &mut Stack,
        len: &mut Len,
    ) -> usize;
}
