//! One ray through the hierarchy.

use super::bounds::SLACK;
use super::lanes::{Lanes, Sorter};
use super::node::{BLOCK, Block, Child, Node, WIDTH};
use super::ray::{Frame, Hit, Ray};
use super::stack::Stack;
use super::triangle::{self, Nearest};

/// Boxes are entered up to this factor beyond the limit, so that they let every hit of the triangle test through.
pub(super) const BOX_SLACK: f32 = 1.0 + 4.0 * SLACK;

#[cfg(stats)] pub static COUNT: [std::sync::atomic::AtomicUsize; 12] = [const { std::sync::atomic::AtomicUsize::new(0) }; 12];
#[cfg(stats)] const R: std::sync::atomic::Ordering = std::sync::atomic::Ordering::Relaxed;
struct Slabs<L: Lanes<WIDTH>> {
    origin: [L::F; 3],
    inverse: [L::F; 3],
    inverse_far: [L::F; 3],
    backward: [usize; 3],
    t_min: L::F,
}

impl<L: Lanes<WIDTH>> Slabs<L> {
    #[inline(always)]
    fn new(lanes: L, frame: &Frame) -> Self {
        Self {
            origin: frame.origin.map(|x| lanes.splat(x)),
            inverse: frame.inverse.map(|x| lanes.splat(x)),
            inverse_far: frame.inverse.map(|x| lanes.splat(x * BOX_SLACK)),
            backward: frame.backward,
            t_min: lanes.splat(frame.t_min),
        }
    }

    /// The distances at which the ray enters the children, and which it enters at all before `limit`.
    #[inline(always)]
    fn enter(&self, lanes: L, node: &Node, limit: L::F) -> (L::F, L::M) {
        let plane = |axis: usize, side: usize| {
            let plane = lanes.load(&node.planes[axis * 2 + side]);
            lanes.mul(lanes.sub(plane, self.origin[axis]), self.inverse[axis])
        };
        let plane_far = |axis: usize, side: usize| {
            let plane = lanes.load(&node.planes[axis * 2 + side]);
            lanes.mul(lanes.sub(plane, self.origin[axis]), self.inverse_far[axis])
        };
        let [x, y, z] = self.backward.map(|b| b & 1);
        let near = lanes.max(lanes.max(plane(0, x), plane(1, y)), lanes.max(plane(2, z), self.t_min));
        let far = lanes.min(lanes.min(plane_far(0, 1 - x), plane_far(1, 1 - y)), lanes.min(plane_far(2, 1 - z), limit));
        (near, lanes.le(near, far))
    }
}

#[inline(always)]
pub(super) fn closest<L: Sorter + Lanes<BLOCK>>(lanes: L, nodes: &[Node], blocks: &[Block], ray: &Ray) -> Option<Hit> {
    let frame = Frame::new(ray);
    let slabs: Slabs<L> = Slabs::new(lanes, &frame);
    let mut nearest = Nearest::none(frame.t_max);
    let mut stack = Stack::new();
    let mut limit = nearest.t * BOX_SLACK;
    let mut limits = Lanes::<WIDTH>::splat(lanes, limit);
    let mut child = 0;
    loop {
        if child & Child::LEAF == 0 {
            let node = &nodes[child as usize];
            let (near, hit) = slabs.enter(lanes, node, limits);
            let bits = Lanes::<WIDTH>::bits(lanes, hit);
            #[cfg(stats)] { COUNT[0].fetch_add(1, R); COUNT[2 + bits.count_ones() as usize].fetch_add(1, R); }
            if bits != 0 {
                if bits & (bits - 1) == 0 {
                    child = node.children[bits.trailing_zeros() as usize % WIDTH];
                } else {
                    let rest = bits & (bits - 1);
                    if rest & (rest - 1) == 0 {
                        let near = Lanes::<WIDTH>::store(lanes, near);
                        let (a, b) = (bits.trailing_zeros() as usize % WIDTH, rest.trailing_zeros() as usize % WIDTH);
                        let (ca, cb) = (node.children[a], node.children[b]);
                        if near[a] <= near[b] {
                            stack.push(near[b], cb);
                            child = ca;
                        } else {
                            stack.push(near[a], ca);
                            child = cb;
                        }
                    } else {
                        lanes.push_sorted(near, hit, &node.children, &mut stack);
                        child = stack.pop_top();
                    }
                }
                continue;
            }
        } else if { #[cfg(stats)] COUNT[1].fetch_add(1, R); triangle::closest }(lanes, &frame, &blocks[(child & !Child::LEAF) as usize], &mut nearest) {
            limit = nearest.t * BOX_SLACK;
            limits = Lanes::<WIDTH>::splat(lanes, limit);
        }
        match stack.pop(limit) {
            Some(next) => child = next,
            None => return nearest.hit(),
        }
    }
}

#[inline(always)]
pub(super) fn occluded<L: Sorter + Lanes<BLOCK>>(lanes: L, nodes: &[Node], blocks: &[Block], ray: &Ray) -> bool {
    let frame = Frame::new(ray);
    let slabs: Slabs<L> = Slabs::new(lanes, &frame);
    let mut stack = Stack::new();
    let limit = frame.t_max * BOX_SLACK;
    let limits = Lanes::<WIDTH>::splat(lanes, limit);
    let mut child = 0;
    loop {
        if child & Child::LEAF == 0 {
            let node = &nodes[child as usize];
            let (_, hit) = slabs.enter(lanes, node, limits);
            let bits = Lanes::<WIDTH>::bits(lanes, hit);
            if bits != 0 {
                if bits & (bits - 1) == 0 {
                    child = node.children[bits.trailing_zeros() as usize % WIDTH];
                } else {
                    let mut rest = bits & (bits - 1);
                    child = node.children[bits.trailing_zeros() as usize % WIDTH];
                    while rest != 0 {
                        stack.push(0.0, node.children[rest.trailing_zeros() as usize % WIDTH]);
                        rest &= rest - 1;
                    }
                }
                continue;
            }
        } else if triangle::occluded(lanes, &frame, &blocks[(child & !Child::LEAF) as usize]) {
            return true;
        }
        match stack.pop(limit) {
            Some(next) => child = next,
            None => return false,
        }
    }
}
