//! The boxes a traversal has yet to visit.
#![allow(unsafe_code)]
use std::mem::MaybeUninit;

use super::node::WIDTH;

const DEPTH: usize = 256;

pub(super) struct Stack {
    near: [MaybeUninit<u32>; DEPTH],
    child: [MaybeUninit<u32>; DEPTH],
    len: usize,
}

impl Stack {
    #[inline(always)]
    pub fn new() -> Self {
        Self { near: [const { MaybeUninit::uninit() }; DEPTH], child: [const { MaybeUninit::uninit() }; DEPTH], len: 0 }
    }
    #[inline(always)]
    pub fn reserve(&mut self, count: usize) -> (&mut [MaybeUninit<u32>; WIDTH], &mut [MaybeUninit<u32>; WIDTH]) {
        assert!(self.len + WIDTH <= DEPTH);
        let near = unsafe { &mut *self.near.as_mut_ptr().add(self.len).cast() };
        let child = unsafe { &mut *self.child.as_mut_ptr().add(self.len).cast() };
        self.len += count;
        (near, child)
    }
    #[inline(always)]
    pub fn pop(&mut self, limit: f32) -> Option<u32> {
        while self.len > 0 {
            self.len -= 1;
            let (n, c) = unsafe { (self.near.get_unchecked(self.len).assume_init(), self.child.get_unchecked(self.len).assume_init()) };
            if f32::from_bits(n & 0x7fff_fff8) <= limit {
                return Some(c);
            }
        }
        None
    }
    #[inline(always)]
    pub fn push(&mut self, near: f32, child: u32) {
        assert!(self.len + WIDTH <= DEPTH);
        unsafe {
            self.near.get_unchecked_mut(self.len).write(near.to_bits());
            self.child.get_unchecked_mut(self.len).write(child);
        }
        self.len += 1;
    }
    #[inline(always)]
    pub fn pop_top(&mut self) -> u32 {
        self.len -= 1;
        unsafe { self.child.get_unchecked(self.len).assume_init() }
    }
}
