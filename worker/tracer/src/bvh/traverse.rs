//! One ray through the hierarchy.

use super::bounds::BOX_SLACK;
use super::lanes::Lanes;
use super::node::{Child, Leaf, Node, WIDTH};
use super::ray::{Frame, Hit, Ray};
use super::stack::{Len, Stack};
use super::triangle::{self, Nearest};

/// The box test of one ray: where it passes the planes of eight children.
struct Slabs<L: Lanes> {
    origin: [L::F; 3],
    inverse: [L::F; 3],
    /// The reciprocal direction times [`BOX_SLACK`], for the planes by which the ray leaves.
    inverse_out: [L::F; 3],
    backward: [usize; 3],
    t_min: L::F,
}

impl<L: Lanes> Slabs<L> {
    #[inline(always)]
    fn new(lanes: L, frame: &Frame) -> Self {
        let (origin, inverse, out) = (frame.origin, frame.inverse, frame.inverse * BOX_SLACK);
        let backward = frame.backward as usize;
        Self {
            origin: [lanes.splat(origin.x), lanes.splat(origin.y), lanes.splat(origin.z)],
            inverse: [lanes.splat(inverse.x), lanes.splat(inverse.y), lanes.splat(inverse.z)],
            inverse_out: [lanes.splat(out.x), lanes.splat(out.y), lanes.splat(out.z)],
            backward: [backward & 1, backward >> 1 & 1, backward >> 2 & 1],
            t_min: lanes.splat(frame.t_min),
        }
    }

    /// Where the ray passes one plane of the children.
    #[inline(always)]
    fn pass(&self, lanes: L, node: &Node, axis: usize, side: usize, inverse: L::F) -> L::F {
        lanes.mul(lanes.sub(lanes.load(&node.planes[axis * 2 + side]), self.origin[axis]), inverse)
    }

    /// Where the ray enters the children, and which it enters at all before `limit`.
    #[inline(always)]
    fn enter(&self, lanes: L, node: &Node, limit: L::F) -> (L::F, L::M) {
        let [x, y, z] = [self.backward[0] & 1, self.backward[1] & 1, self.backward[2] & 1];
        let (into, out) = (self.inverse, self.inverse_out);
        let near_x = self.pass(lanes, node, 0, x, into[0]);
        let near_y = self.pass(lanes, node, 1, y, into[1]);
        let near_z = self.pass(lanes, node, 2, z, into[2]);
        let far_x = self.pass(lanes, node, 0, 1 - x, out[0]);
        let far_y = self.pass(lanes, node, 1, 1 - y, out[1]);
        let far_z = self.pass(lanes, node, 2, 1 - z, out[2]);
        let near = lanes.max(lanes.max(near_x, near_y), lanes.max(near_z, self.t_min));
        let far = lanes.min(lanes.min(far_x, far_y), lanes.min(far_z, limit));
        (near, lanes.le(near, far))
    }
}

/// The nearest hit of a ray, children in the order of their distance.
#[inline(always)]
pub(super) fn closest<L: Lanes>(lanes: L, nodes: &[Node], leaves: &[f32], ray: &Ray) -> Option<Hit> {
    let frame = Frame::new(ray)?;
    let slabs = Slabs::new(lanes, &frame);
    let mut nearest = Nearest::none(frame.t_max);
    let mut limit = frame.t_max * BOX_SLACK;
    let mut limits = lanes.splat(limit);
    let (mut stack, mut len) = (Stack::new(), Len::ZERO);
    let mut child = Child::node(0);
    loop {
        if child.is_leaf() {
            if triangle::closest(lanes, &frame, Leaf::of(leaves, child), &mut nearest) {
                limit = nearest.t * BOX_SLACK;
                limits = lanes.splat(limit);
            }
        } else {
            let node = &nodes[child.0 as usize];
            let (near, hit) = slabs.enter(lanes, node, limits);
            let bits = lanes.bits(hit);
            if bits != 0 {
                let first = bits.trailing_zeros() as usize % WIDTH;
                let rest = bits & (bits - 1);
                // One and two children are most of all cases, and quicker without a sort.
                let next = if rest == 0 {
                    first
                } else if rest & (rest - 1) == 0 {
                    let second = rest.trailing_zeros() as usize % WIDTH;
                    let near = lanes.store(near);
                    let (next, later) = if near[first] <= near[second] { (first, second) } else { (second, first) };
                    stack.push(&mut len, near[later], node.children[later]);
                    next
                } else {
                    lanes.push_sorted(near, hit, &node.children, &mut stack, &mut len)
                };
                child = Child(node.children[next]);
                continue;
            }
        }
        match stack.pop(&mut len, limit) {
            Some(next) => child = Child(next),
            None => return nearest.hit(),
        }
    }
}

/// Whether a ray hits anything: no order among children, an end at the first hit.
#[inline(always)]
pub(super) fn occluded<L: Lanes>(lanes: L, nodes: &[Node], leaves: &[f32], ray: &Ray) -> bool {
    let Some(frame) = Frame::new(ray) else { return false };
    let slabs = Slabs::new(lanes, &frame);
    let limits = lanes.splat(frame.t_max * BOX_SLACK);
    let (mut stack, mut len) = (Stack::new(), Len::ZERO);
    let mut child = Child::node(0);
    loop {
        if child.is_leaf() {
            if triangle::occluded(lanes, &frame, Leaf::of(leaves, child)) {
                return true;
            }
        } else {
            let node = &nodes[child.0 as usize];
            let mut bits = lanes.bits(slabs.enter(lanes, node, limits).1);
            if bits != 0 {
                child = Child(node.children[bits.trailing_zeros() as usize % WIDTH]);
                bits &= bits - 1;
                // The last first, so that children are visited in the order of their slots.
                while bits != 0 {
                    let last = bits.ilog2();
                    stack.push_any(&mut len, node.children[last as usize % WIDTH]);
                    bits ^= 1 << last;
                }
                continue;
            }
        }
        match stack.pop_any(&mut len) {
            Some(next) => child = Child(next),
            None => return false,
        }
    }
}
