//! The same operations in plain Rust, which the compiler vectorises as far as the target allows.

use std::array::from_fn;

use super::super::node::{Leaf, WIDTH};
use super::super::stack::{Len, Stack};
use super::Lanes;

/// Needs no particular processor.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Portable;

type F = [f32; WIDTH];
type M = [bool; WIDTH];

impl Lanes for Portable {
    type F = F;
    type M = M;

    #[inline(always)]
    fn splat(self, x: f32) -> F {
        [x; WIDTH]
    }
    #[inline(always)]
    fn load(self, from: &F) -> F {
        *from
    }
    #[inline(always)]
    fn store(self, x: F) -> F {
        x
    }
    #[inline(always)]
    fn vertices(self, leaf: Leaf, axis: usize) -> [F; 3] {
        from_fn(|vertex| {
            let row = &leaf.rows[(vertex * 3 + axis) * leaf.count..][..WIDTH];
            from_fn(|lane| row[lane])
        })
    }
    #[inline(always)]
    fn add(self, a: F, b: F) -> F {
        from_fn(|i| a[i] + b[i])
    }
    #[inline(always)]
    fn sub(self, a: F, b: F) -> F {
        from_fn(|i| a[i] - b[i])
    }
    #[inline(always)]
    fn mul(self, a: F, b: F) -> F {
        from_fn(|i| a[i] * b[i])
    }
    #[inline(always)]
    fn div(self, a: F, b: F) -> F {
        from_fn(|i| a[i] / b[i])
    }
    #[inline(always)]
    fn min(self, a: F, b: F) -> F {
        from_fn(|i| if a[i] < b[i] { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn max(self, a: F, b: F) -> F {
        from_fn(|i| if a[i] > b[i] { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn le(self, a: F, b: F) -> M {
        from_fn(|i| a[i] <= b[i])
    }
    #[inline(always)]
    fn lt(self, a: F, b: F) -> M {
        from_fn(|i| a[i] < b[i])
    }
    #[inline(always)]
    fn and(self, a: M, b: M) -> M {
        from_fn(|i| a[i] & b[i])
    }
    #[inline(always)]
    fn or(self, a: M, b: M) -> M {
        from_fn(|i| a[i] | b[i])
    }
    #[inline(always)]
    fn select(self, m: M, a: F, b: F) -> F {
        from_fn(|i| if m[i] { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn copysign(self, a: F, sign: F) -> F {
        from_fn(|i| a[i].copysign(sign[i]))
    }
    #[inline(always)]
    fn signs(self, a: F) -> u32 {
        a.iter().rev().fold(0, |bits, x| bits << 1 | x.to_bits() >> 31)
    }
    #[inline(always)]
    fn first(self, count: usize) -> M {
        from_fn(|i| i < count)
    }
    #[inline(always)]
    fn bits(self, a: M) -> u32 {
        a.iter().rev().fold(0, |bits, &set| bits << 1 | u32::from(set))
    }

    fn push_sorted(self, near: F, hit: M, children: &[u32; WIDTH], stack: &mut Stack, len: &mut Len) -> usize {
        let mut lanes = [0; WIDTH];
        let mut count = 0;
        for lane in (0..WIDTH).filter(|&lane| hit[lane]) {
            let at = lanes[..count].iter().position(|&other: &usize| near[other] < near[lane]).unwrap_or(count);
            lanes.copy_within(at..count, at + 1);
            lanes[at] = lane;
            count += 1;
        }
        for &lane in &lanes[..count - 1] {
            stack.push(len, near[lane], children[lane]);
        }
        lanes[count - 1]
    }
}
