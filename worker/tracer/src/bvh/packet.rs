//! Rays that stay close together, such as those of neighbouring pixels: they share one walk down the hierarchy.
//!
//! Interval arithmetic tests the eight children of a node against all rays of a packet at once (Boulos, Wald & Shirley
//! 2006, "Geometric and Arithmetic Culling Methods for Entire Ray Packets"). Only where the packet reaches a leaf is
//! each ray tested against the leaf's box, and the rays that pass, against its triangles, by the same arithmetic as a
//! single ray. So the hits are those of single rays to the last bit.

use super::bounds::BOX_SLACK;
use super::bundle::{Bundle, Hits};
use super::lanes::Lanes;
use super::node::{Child, Leaf, Node, WIDTH};
use super::octet::{EIGHT, Octet};
use super::stack::{Len, Stack};
use super::triangle;

use glam::Vec4;

/// Rays that share a walk.
pub(super) const PACKET: usize = 16;

/// The largest difference of slopes in a packet: beyond, its common volume is so wide that single rays are faster.
const SPREAD: f32 = 0.2;

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
    fn new(lanes: L, octets: &[Octet<'_>; GROUPS], extent: f32) -> Option<Self> {
        let [a, b] = octets;
        let uniform = |of: fn(&Octet<'_>, usize) -> u32, axis: usize| {
            let (a, b) = (of(a, axis), of(b, axis));
            (a == b) & ((a == 0) | (a == EIGHT))
        };
        for axis in 0..3 {
            if !uniform(|octet, axis| octet.along[axis], axis) | !uniform(|octet, axis| octet.backward[axis], axis) {
                return None;
            }
        }
        if a.valid & b.valid != EIGHT {
            return None;
        }
        let (x, y, z) = (
            spread(&a.origin[0], &b.origin[0]),
            spread(&a.origin[1], &b.origin[1]),
            spread(&a.origin[2], &b.origin[2]),
        );
        let origin = [Vec4::new(x[0], y[0], z[0], 0.0), Vec4::new(x[1], y[1], z[1], 0.0)];
        let (x, y, z) = (
            spread(&a.inverse[0], &b.inverse[0]),
            spread(&a.inverse[1], &b.inverse[1]),
            spread(&a.inverse[2], &b.inverse[2]),
        );
        let inverse = [Vec4::new(x[0], y[0], z[0], 0.0), Vec4::new(x[1], y[1], z[1], 0.0)];
        let (x, y) = (spread(&a.shear[0], &b.shear[0]), spread(&a.shear[1], &b.shear[1]));
        let coherent = most(x[1] - x[0], y[1] - y[0]) <= SPREAD
            && (origin[1] - origin[0]).max_element() <= SPREAD * SPREAD * extent;
        if !coherent {
            return None;
        }
        let t_min = reduce(&octets[0].t_min, &octets[1].t_min, least);
        let backward = [a.backward[0] as usize & 1, a.backward[1] as usize & 1, a.backward[2] as usize & 1];
        // Forward rays from the greatest origin are the first at a plane, from the least the last; backward ones
        // reversed.
        let (low, high) = (origin[0].to_array(), origin[1].to_array());
        let (mut first, mut last) = (high, low);
        for axis in 0..3 {
            if backward[axis] == 1 {
                (first[axis], last[axis]) = (low[axis], high[axis]);
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

/// Vectors of rays.
const GROUPS: usize = PACKET / WIDTH;

#[inline(always)]
fn least(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn most(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The least or the greatest of sixteen numbers.
#[inline(always)]
fn reduce(a: &[f32; WIDTH], b: &[f32; WIDTH], of: impl Fn(f32, f32) -> f32) -> f32 {
    let mut pairs = [0.0; WIDTH];
    for lane in 0..WIDTH {
        pairs[lane] = of(a[lane], b[lane]);
    }
    // Not by `map`: what is not inlined does without AVX2.
    let [a, b, c, d, e, f, g, h] = pairs;
    of(of(of(a, e), of(c, g)), of(of(b, f), of(d, h)))
}

/// The least and the greatest of sixteen numbers.
#[inline(always)]
fn spread(a: &[f32; WIDTH], b: &[f32; WIDTH]) -> [f32; 2] {
    [reduce(a, b, least), reduce(a, b, most)]
}

/// The greatest limit of any ray.
#[inline(always)]
fn farthest(octets: &[Octet<'_>; GROUPS]) -> f32 {
    reduce(&octets[0].t_max, &octets[1].t_max, most) * BOX_SLACK
}

/// The rays, as bits, that enter one child box before their limits.
#[inline(always)]
fn enter<L: Lanes>(lanes: L, octets: &[Octet<'_>; GROUPS], node: &Node, child: usize, backward: [usize; 3]) -> u32 {
    let mut rays = 0;
    for (group, octet) in octets.iter().enumerate() {
        let mut near = lanes.load(&octet.t_min);
        let mut far = lanes.splat(f32::INFINITY);
        for (axis, side) in backward.into_iter().enumerate() {
            let origin = lanes.load(&octet.origin[axis]);
            let inverse = lanes.load(&octet.inverse[axis]);
            let into = lanes.splat(node.planes[axis * 2 + (side & 1)][child]);
            let out = lanes.splat(node.planes[axis * 2 + 1 - (side & 1)][child]);
            near = lanes.max(lanes.mul(lanes.sub(into, origin), inverse), near);
            far = lanes.min(lanes.mul(lanes.sub(out, origin), inverse), far);
        }
        let slack = lanes.splat(BOX_SLACK);
        let far = lanes.min(lanes.mul(far, slack), lanes.mul(lanes.load(&octet.t_max), slack));
        rays |= lanes.bits(lanes.le(near, far)) << (group * WIDTH);
    }
    rays
}

/// The order of axes of the sheared space of rays that share it.
#[inline(always)]
fn axes(octet: &Octet<'_>) -> [usize; 3] {
    let z = if octet.along[2] != 0 { 2 } else { usize::from(octet.along[1] != 0) };
    [(z + 1) % 3, (z + 2) % 3, z]
}

/// The nearest hits of the rays of a bundle; false, and nothing done, where they are not coherent. `extent` is the
/// size of the scene.
#[inline(always)]
pub(super) fn closest<L: Lanes>(
    lanes: L,
    nodes: &[Node],
    leaves: &[f32],
    extent: f32,
    rays: &Bundle,
    hits: &mut Hits,
) -> bool {
    let rays = &rays.filled();
    let mut octets = [Octet::new::<0, L>(lanes, rays), Octet::new::<WIDTH, L>(lanes, rays)];
    let Some(envelope) = Envelope::new(lanes, &octets, extent) else { return false };
    let axes = axes(&octets[0]);
    let mut limit = farthest(&octets);
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
                for octet in &octets {
                    octet.write(lanes, hits);
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
            let active = enter(lanes, &octets, parent, lane, envelope.backward);
            let mut closer = 0;
            for (group, octet) in octets.iter_mut().enumerate() {
                let mut active = active >> (group * WIDTH) & 0xff;
                if 2 * active.count_ones() as usize >= leaf.count {
                    closer |= octet.closest::<L, false>(lanes, axes, leaf, active);
                    continue;
                }
                while active != 0 {
                    let lane = active.trailing_zeros() as usize % WIDTH;
                    active &= active - 1;
                    let Some(frame) = octet.frame(lane) else { continue };
                    let mut nearest = octet.nearest(lane);
                    if triangle::closest(lanes, &frame, leaf, &mut nearest) {
                        octet.set_nearest(lane, nearest);
                        closer |= 1 << lane;
                    }
                }
            }
            if closer != 0 {
                limit = farthest(&octets);
                limits = lanes.splat(limit);
            }
        }
    }
}

/// Which rays of a bundle hit anything, as bits; `None` where they are not coherent.
#[inline(always)]
pub(super) fn occluded<L: Lanes>(lanes: L, nodes: &[Node], leaves: &[f32], extent: f32, rays: &Bundle) -> Option<u32> {
    let rays = &rays.filled();
    let octets = [Octet::new::<0, L>(lanes, rays), Octet::new::<WIDTH, L>(lanes, rays)];
    let envelope = Envelope::new(lanes, &octets, extent)?;
    let axes = axes(&octets[0]);
    let limits = lanes.splat(farthest(&octets));
    // Rays that have hit nothing yet, as bits.
    let mut open = rays.used;
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
            let active = enter(lanes, &octets, parent, lane, envelope.backward) & open;
            for (group, octet) in octets.iter().enumerate() {
                let base = group * WIDTH;
                let mut active = active >> base & 0xff;
                if 2 * active.count_ones() as usize >= leaf.count {
                    open &= !(octet.occluded(lanes, axes, leaf, active) << base);
                    continue;
                }
                while active != 0 {
                    let lane = active.trailing_zeros() as usize % WIDTH;
                    active &= active - 1;
                    let Some(frame) = octet.frame(lane) else { continue };
                    if triangle::occluded(lanes, &frame, leaf) {
                        open &= !(1 << (base + lane));
                    }
                }
            }
            if open == 0 {
                break 'walk;
            }
        }
    }
    Some(rays.used & !open)
}
