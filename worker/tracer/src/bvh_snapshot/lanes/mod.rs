//! The few SIMD operations that traversal needs, over the instruction set found at run time.
//!
//! Every operation is one IEEE 754 operation per lane, and nothing is contracted, so that each instruction set computes
//! the same bits.

#[cfg(target_arch = "x86_64")]
pub(super) mod avx2;
pub(super) mod portable;

use super::node::WIDTH;
use super::stack::Stack;

/// `N` single-precision lanes. The implementor is a token that proves that the processor has the instructions.
pub(super) trait Lanes<const N: usize>: Copy {
    /// `N` numbers.
    type F: Copy;
    /// `N` truth values.
    type M: Copy;

    fn splat(self, x: f32) -> Self::F;
    fn load(self, from: &[f32; N]) -> Self::F;
    fn store(self, x: Self::F) -> [f32; N];
    fn add(self, a: Self::F, b: Self::F) -> Self::F;
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    fn div(self, a: Self::F, b: Self::F) -> Self::F;
    /// `if a < b { a } else { b }`, which settles what becomes of NaN and -0.
    fn min(self, a: Self::F, b: Self::F) -> Self::F;
    /// `if a > b { a } else { b }`.
    fn max(self, a: Self::F, b: Self::F) -> Self::F;
    /// `a <= b`
    fn le(self, a: Self::F, b: Self::F) -> Self::M;
    /// `a < b`
    fn lt(self, a: Self::F, b: Self::F) -> Self::M;
    fn and(self, a: Self::M, b: Self::M) -> Self::M;
    fn or(self, a: Self::M, b: Self::M) -> Self::M;
    /// Bit `i` is lane `i`.
    fn bits(self, a: Self::M) -> u32;
}

/// Lanes for boxes, and the push that follows a node test.
pub(super) trait Sorter: Lanes<WIDTH> {
    /// Pushes the children whose lane is set in `hit`, the farthest first, so that the nearest is popped next.
    fn push_sorted(self, near: Self::F, hit: Self::M, children: &[u32; WIDTH], stack: &mut Stack);
}
