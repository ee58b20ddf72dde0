//! Rays that stay close together, such as those of neighbouring pixels: they share one walk down the hierarchy.
//!
//! Interval arithmetic tests the eight children of a node against all rays of a packet at once (Boulos, Wald & Shirley
//! 2006, "Geometric and Arithmetic Culling Methods for Entire Ray Packets"). Only where the packet reaches a leaf is
//! each ray tested against the leaf's box, and the rays that pass, against its triangles, by the same arithmetic as a
//! single ray. So the hits are those of single rays to the last bit.

use super::bounds::BOX_SLACK;
use super::lanes::Lanes;
use super::node::{Child, Leaf, Node, WIDTH};
use super::ray::{Frame, Hit, Ray};
use super::stack::{Len, Stack};
use super::triangle::{self, Nearest};

use glam::{Vec2, Vec4};

/// Rays that share a walk.
pub(super) const PACKET: usize = 16;

/// The largest difference of slopes in a packet: beyond, its common volume is so wide that single rays are faster.
const SPREAD: f32 = 0.2;

/// The rays of a packet side by side, eight to a vector; unused lanes have a limit that no box reaches.
struct Bundle {
    origin: [[[f32; WIDTH]; 3]; PACKET / WIDTH],
    inverse: [[[f32; WIDTH]; 3]; PACKET / WIDTH],
    t_min: [[f32; WIDTH]; PACKET / WIDTH],
    limit: [[f32; WIDTH]; PACKET / WIDTH],
}

/// What holds for every ray of a packet.
struct Envelope<L: Lanes> {
    /// Per axis the origin that makes the distance to the plane of entry least, and to that of exit most.
    origin: [[L::F; 2]; 3],
    /// Per axis the least and the greatest reciprocal direction, and both times [`BOX_SLACK`].
    inverse: [[L::F; 2]; 3],
    inverse_out: [[L::F; 2]; 3],
    backward: [usize; 3],
    t_min: L::F,
}

#[inline(always)]
fn splat_axes<L: Lanes>(lanes: L, [a, b]: [Vec4; 2]) -> [[L::F; 2]; 3] {
    [[lanes.splat(a.x), lanes.splat(b.x)], [lanes.splat(a.y), lanes.splat(b.y)], [lanes.splat(a.z), lanes.splat(b.z)]]
}

impl<L: Lanes> Envelope<L> {
    /// `None` where the rays are not coherent. `extent` is the size of the scene.
    #[inline(always)]
    fn new(lanes: L, frames: &[Frame], extent: f32) -> Option<Self> {
        let (first, others) = frames.split_first()?;
        let (mut origin, mut inverse) = ([first.origin; 2], [first.inverse; 2]);
        let mut shear = [Vec2::from(first.shear); 2];
        let mut t_min = first.t_min;
        for frame in others {
            if frame.backward != first.backward || frame.axes != first.axes {
                return None;
            }
            origin = [origin[0].min(frame.origin), origin[1].max(frame.origin)];
            inverse = [inverse[0].min(frame.inverse), inverse[1].max(frame.inverse)];
            shear = [shear[0].min(frame.shear.into()), shear[1].max(frame.shear.into())];
            t_min = t_min.min(frame.t_min);
        }
        let coherent = (shear[1] - shear[0]).max_element() <= SPREAD
            && (origin[1] - origin[0]).max_element() <= SPREAD * SPREAD * extent;
        if !coherent {
            return None;
        }
        let backward = first.backward as usize;
        let backward = [backward & 1, backward >> 1 & 1, backward >> 2 & 1];
        // Forward rays from the greatest origin are the first at a plane, from the least the last; backward ones
        // reversed.
        let (least, most) = (origin[0].to_array(), origin[1].to_array());
        let (mut first, mut last) = (most, least);
        for axis in 0..3 {
            if backward[axis] == 1 {
                (first[axis], last[axis]) = (least[axis], most[axis]);
            }
        }
        let outermost = [Vec4::from_array(first), Vec4::from_array(last)];
        let out = [inverse[0] * BOX_SLACK, inverse[1] * BOX_SLACK];
        Some(Self {
            origin: splat_axes(lanes, outermost),
            inverse: splat_axes(lanes, inverse),
            inverse_out: splat_axes(lanes, out),
            backward,
            t_min: lanes.splat(t_min),
        })
    }

    /// A bound from below on where the rays enter the children, and which children any ray may enter before `limit`.
    #[inline(always)]
    fn enter(&self, lanes: L, node: &Node, limit: L::F) -> (L::F, L::M) {
        let (mut near, mut far) = (self.t_min, limit);
        for axis in 0..3 {
            let side = self.backward[axis] & 1;
            let into = lanes.sub(lanes.load(&node.planes[axis * 2 + side]), self.origin[axis][0]);
            let out = lanes.sub(lanes.load(&node.planes[axis * 2 + 1 - side]), self.origin[axis][1]);
            let [least, most] = self.inverse[axis];
            near = lanes.max(lanes.min(lanes.mul(into, least), lanes.mul(into, most)), near);
            let [least, most] = self.inverse_out[axis];
            far = lanes.min(lanes.max(lanes.mul(out, least), lanes.mul(out, most)), far);
        }
        (near, lanes.le(near, far))
    }
}

impl Bundle {
    #[inline(always)]
    fn new(frames: &[Frame]) -> Self {
        const NONE: [[f32; WIDTH]; PACKET / WIDTH] = [[0.0; WIDTH]; PACKET / WIDTH];
        const NO_AXES: [[[f32; WIDTH]; 3]; PACKET / WIDTH] = [[[0.0; WIDTH]; 3]; PACKET / WIDTH];
        let limit = [[f32::NEG_INFINITY; WIDTH]; PACKET / WIDTH];
        let mut bundle = Self { origin: NO_AXES, inverse: NO_AXES, t_min: NONE, limit };
        for (i, frame) in frames.iter().enumerate() {
            let (group, lane) = (i / WIDTH, i % WIDTH);
            for axis in 0..3 {
                bundle.origin[group][axis][lane] = frame.origin_on[axis];
                bundle.inverse[group][axis][lane] = frame.inverse_on[axis];
            }
            bundle.t_min[group][lane] = frame.t_min;
            bundle.limit[group][lane] = frame.t_max * BOX_SLACK;
        }
        bundle
    }

    /// The greatest limit of any ray.
    #[inline(always)]
    fn farthest(&self) -> f32 {
        self.limit.iter().flatten().fold(f32::NEG_INFINITY, |most, &limit| if limit > most { limit } else { most })
    }

    /// The rays, as bits, that enter one child box before their limits.
    #[inline(always)]
    fn enter<L: Lanes>(&self, lanes: L, node: &Node, child: usize, backward: [usize; 3]) -> u32 {
        let mut rays = 0;
        for group in 0..PACKET / WIDTH {
            let mut near = lanes.load(&self.t_min[group]);
            let mut far = lanes.splat(f32::INFINITY);
            for (axis, side) in backward.into_iter().enumerate() {
                let origin = lanes.load(&self.origin[group][axis]);
                let inverse = lanes.load(&self.inverse[group][axis]);
                let into = lanes.splat(node.planes[axis * 2 + (side & 1)][child]);
                let out = lanes.splat(node.planes[axis * 2 + 1 - (side & 1)][child]);
                near = lanes.max(lanes.mul(lanes.sub(into, origin), inverse), near);
                far = lanes.min(lanes.mul(lanes.sub(out, origin), inverse), far);
            }
            let far = lanes.min(lanes.mul(far, lanes.splat(BOX_SLACK)), lanes.load(&self.limit[group]));
            rays |= lanes.bits(lanes.le(near, far)) << (group * WIDTH);
        }
        rays
    }
}

/// The nearest hits of at most [`PACKET`] rays; false, and nothing done, where they are not coherent. `extent` is the
/// size of the scene.
#[inline(always)]
pub(super) fn closest<L: Lanes>(
    lanes: L,
    nodes: &[Node],
    leaves: &[f32],
    extent: f32,
    rays: &[Ray],
    hits: &mut [Option<Hit>],
) -> bool {
    let Some(first) = rays.first().and_then(Frame::new) else { return false };
    let mut frames = [first; PACKET];
    for (frame, ray) in frames.iter_mut().zip(rays).skip(1) {
        let Some(new) = Frame::new(ray) else { return false };
        *frame = new;
    }
    let used = &frames[..rays.len().min(PACKET)];
    let Some(envelope) = Envelope::new(lanes, used, extent) else { return false };
    let mut bundle = Bundle::new(used);
    let mut nearest = [Nearest::none(0.0); PACKET];
    for (nearest, frame) in nearest.iter_mut().zip(used) {
        *nearest = Nearest::none(frame.t_max);
    }
    let mut limit = bundle.farthest();
    let mut limits = lanes.splat(limit);
    // The stack holds slots: a node's index times 8 plus the child's lane, so that a leaf's box is at hand.
    let (mut stack, mut len) = (Stack::new(), Len::ZERO);
    let mut index = 0;
    loop {
        let node = &nodes[index];
        let (near, hit) = envelope.enter(lanes, node, limits);
        if lanes.bits(hit) != 0 {
            let first = (index * WIDTH) as u32;
            let slots = [first, first + 1, first + 2, first + 3, first + 4, first + 5, first + 6, first + 7];
            let nearest = lanes.push_sorted(near, hit, &slots, &mut stack, &mut len);
            stack.push(&mut len, 0.0, slots[nearest]);
        }
        loop {
            let Some(slot) = stack.pop(&mut len, limit) else {
                for (hit, nearest) in hits.iter_mut().zip(&nearest[..used.len()]) {
                    *hit = nearest.hit();
                }
                return true;
            };
            let (parent, lane) = (&nodes[slot as usize / WIDTH], slot as usize % WIDTH);
            let child = Child(parent.children[lane]);
            if !child.is_leaf() {
                index = child.0 as usize;
                break;
            }
            let leaf = Leaf::of(leaves, child);
            let mut active = bundle.enter(lanes, parent, lane, envelope.backward);
            let mut closer = false;
            while active != 0 {
                let i = active.trailing_zeros() as usize % PACKET;
                active &= active - 1;
                if triangle::closest(lanes, &frames[i], leaf, &mut nearest[i]) {
                    bundle.limit[i / WIDTH][i % WIDTH] = nearest[i].t * BOX_SLACK;
                    closer = true;
                }
            }
            if closer {
                limit = bundle.farthest();
                limits = lanes.splat(limit);
            }
        }
    }
}

/// Whether each of at most [`PACKET`] rays hits anything; false, and nothing done, where they are not coherent.
#[inline(always)]
pub(super) fn occluded<L: Lanes>(
    lanes: L,
    nodes: &[Node],
    leaves: &[f32],
    extent: f32,
    rays: &[Ray],
    blocked: &mut [bool],
) -> bool {
    let Some(first) = rays.first().and_then(Frame::new) else { return false };
    let mut frames = [first; PACKET];
    for (frame, ray) in frames.iter_mut().zip(rays).skip(1) {
        let Some(new) = Frame::new(ray) else { return false };
        *frame = new;
    }
    let used = &frames[..rays.len().min(PACKET)];
    let Some(envelope) = Envelope::new(lanes, used, extent) else { return false };
    let bundle = Bundle::new(used);
    let limits = lanes.splat(bundle.farthest());
    // Rays that have hit nothing yet, as bits.
    let mut open = (1u32 << used.len()) - 1;
    let (mut stack, mut len) = (Stack::new(), Len::ZERO);
    let mut index = 0;
    'walk: loop {
        let node = &nodes[index];
        let mut bits = lanes.bits(envelope.enter(lanes, node, limits).1);
        // The last first, so that children are visited in the order of their slots.
        while bits != 0 {
            let last = bits.ilog2();
            stack.push_any(&mut len, (index * WIDTH) as u32 + last);
            bits ^= 1 << last;
        }
        loop {
            let Some(slot) = stack.pop_any(&mut len) else { break 'walk };
            let (parent, lane) = (&nodes[slot as usize / WIDTH], slot as usize % WIDTH);
            let child = Child(parent.children[lane]);
            if !child.is_leaf() {
                index = child.0 as usize;
                break;
            }
            let leaf = Leaf::of(leaves, child);
            let mut active = bundle.enter(lanes, parent, lane, envelope.backward) & open;
            while active != 0 {
                let i = active.trailing_zeros() as usize % PACKET;
                active &= active - 1;
                if triangle::occluded(lanes, &frames[i], leaf) {
                    open &= !(1 << i);
                }
            }
            if open == 0 {
                break 'walk;
            }
        }
    }
    for (i, blocked) in blocked.iter_mut().enumerate().take(used.len()) {
        *blocked = open >> i & 1 == 0;
    }
    true
}
