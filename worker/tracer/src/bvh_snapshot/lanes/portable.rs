//! The same operations in plain Rust, which the compiler vectorises as far as the target allows.

use super::super::node::WIDTH;
use super::super::stack::Stack;
use super::{Lanes, Sorter};

/// Needs no particular processor.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Portable;

#[inline(always)]
fn zip<const N: usize, A: Copy, B>(a: [A; N], b: [A; N], f: impl Fn(A, A) -> B) -> [B; N] {
    std::array::from_fn(|i| f(a[i], b[i]))
}

impl<const N: usize> Lanes<N> for Portable {
    type F = [f32; N];
    type M = [bool; N];

    #[inline(always)]
    fn splat(self, x: f32) -> [f32; N] {
        [x; N]
    }
    #[inline(always)]
    fn load(self, from: &[f32; N]) -> [f32; N] {
        *from
    }
    #[inline(always)]
    fn store(self, x: [f32; N]) -> [f32; N] {
        x
    }
    #[inline(always)]
    fn add(self, a: [f32; N], b: [f32; N]) -> [f32; N] {
        zip(a, b, |a, b| a + b)
    }
    #[inline(always)]
    fn sub(self, a: [f32; N], b: [f32; N]) -> [f32; N] {
        zip(a, b, |a, b| a - b)
    }
    #[inline(always)]
    fn mul(self, a: [f32; N], b: [f32; N]) -> [f32; N] {
        zip(a, b, |a, b| a * b)
    }
    #[inline(always)]
    fn div(self, a: [f32; N], b: [f32; N]) -> [f32; N] {
        zip(a, b, |a, b| a / b)
    }
    #[inline(always)]
    fn min(self, a: [f32; N], b: [f32; N]) -> [f32; N] {
        zip(a, b, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn max(self, a: [f32; N], b: [f32; N]) -> [f32; N] {
        zip(a, b, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn le(self, a: [f32; N], b: [f32; N]) -> [bool; N] {
        zip(a, b, |a, b| a <= b)
    }
    #[inline(always)]
    fn lt(self, a: [f32; N], b: [f32; N]) -> [bool; N] {
        zip(a, b, |a, b| a < b)
    }
    #[inline(always)]
    fn and(self, a: [bool; N], b: [bool; N]) -> [bool; N] {
        zip(a, b, |a, b| a & b)
    }
    #[inline(always)]
    fn or(self, a: [bool; N], b: [bool; N]) -> [bool; N] {
        zip(a, b, |a, b| a | b)
    }
    #[inline(always)]
    fn bits(self, a: [bool; N]) -> u32 {
        a.iter().rev().fold(0, |bits, &set| bits << 1 | u32::from(set))
    }
}

impl Sorter for Portable {
    #[inline(always)]
    fn push_sorted(self, near: [f32; WIDTH], hit: [bool; WIDTH], children: &[u32; WIDTH], stack: &mut Stack) {
        let mut keys = [(0, 0); WIDTH];
        let mut count = 0;
        for lane in (0..WIDTH).filter(|&lane| hit[lane]) {
            let key = (near[lane].to_bits() & 0x7fff_ffff, children[lane]);
            let at = keys[..count].iter().position(|other| other.0 < key.0).unwrap_or(count);
            keys.copy_within(at..count, at + 1);
            keys[at] = key;
            count += 1;
        }
        let (near_slots, child_slots) = stack.reserve(count);
        for (slot, key) in keys[..count].iter().enumerate() {
            near_slots[slot].write(key.0);
            child_slots[slot].write(key.1);
        }
    }
}
