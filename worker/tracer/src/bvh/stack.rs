//! The boxes that a traversal has yet to visit.
#![allow(unsafe_code)]

use std::mem::MaybeUninit;

#[cfg(target_arch = "x86_64")]
use super::node::WIDTH;

/// Slots; [`super::layout`] sees to it that no hierarchy needs more.
pub(super) const CAPACITY: usize = 256;

/// Distances and children in arrays of their own, so that eight at once can be stored. Nothing is initialised: 2 KB per
/// ray would take as long as several nodes.
pub(super) struct Stack {
    near: [MaybeUninit<u32>; CAPACITY],
    child: [MaybeUninit<u32>; CAPACITY],
}

/// The number of slots of one [`Stack`] in use, all of which have been written. Beside the stack, not in it: so it stays
/// in a register. A traversal makes one of each and uses either both `push` and `pop`, or `push_any` and `pop_any`.
pub(super) struct Len(usize);

impl Len {
    pub const ZERO: Self = Self(0);
}

/// Room for the distances, as bits, and the children of one node.
#[cfg(target_arch = "x86_64")]
pub(super) type Slots<'a> = (&'a mut [MaybeUninit<u32>; WIDTH], &'a mut [MaybeUninit<u32>; WIDTH]);

impl Stack {
    #[inline(always)]
    pub fn new() -> Self {
        const UNWRITTEN: MaybeUninit<u32> = MaybeUninit::uninit();
        Self { near: [UNWRITTEN; CAPACITY], child: [UNWRITTEN; CAPACITY] }
    }

    #[inline(always)]
    pub fn push(&mut self, len: &mut Len, near: f32, child: u32) {
        self.near[len.0].write(near.to_bits());
        self.child[len.0].write(child);
        len.0 += 1;
    }

    /// Lets `write` fill the next slots, of which the first `count` stay.
    ///
    /// # Safety
    /// `write` must initialise the first `count` slots of both arrays; `len` must belong to this stack.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    pub unsafe fn push_many(&mut self, len: &mut Len, count: usize, write: impl FnOnce(Slots)) {
        assert!(len.0 + WIDTH <= CAPACITY && count <= WIDTH);
        // SAFETY: by the assertion both ranges lie within the arrays.
        let slots = unsafe {
            (&mut *self.near.as_mut_ptr().add(len.0).cast(), &mut *self.child.as_mut_ptr().add(len.0).cast())
        };
        write(slots);
        len.0 += count;
    }

    /// The last child pushed that the ray enters before `limit`.
    #[inline(always)]
    pub fn pop(&self, len: &mut Len, limit: f32) -> Option<u32> {
        while len.0 > 0 {
            len.0 -= 1;
            // SAFETY: only `push` and `push_many` raise `len`, over slots within the capacity that they have written.
            let (near, child) = unsafe {
                (self.near.get_unchecked(len.0).assume_init(), self.child.get_unchecked(len.0).assume_init())
            };
            if f32::from_bits(near) <= limit {
                return Some(child);
            }
        }
        None
    }

    /// Pushes a child wherever it is; for traversals that pop by [`Stack::pop_any`] only.
    #[inline(always)]
    pub fn push_any(&mut self, len: &mut Len, child: u32) {
        self.child[len.0].write(child);
        len.0 += 1;
    }

    /// The last child pushed by [`Stack::push_any`].
    #[inline(always)]
    pub fn pop_any(&self, len: &mut Len) -> Option<u32> {
        if len.0 == 0 {
            return None;
        }
        len.0 -= 1;
        // SAFETY: as in `pop`, for the children.
        Some(unsafe { self.child.get_unchecked(len.0).assume_init() })
    }
}
