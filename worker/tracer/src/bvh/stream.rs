//! Rays that start close together and run anywhere, such as those that leave the surface under one pixel. Most of them
//! leave the part for good: the root's boxes and the triangles beside them, tested for eight rays at a time, tell.
//! The others go on alone.

use super::lanes::Lanes;
use super::node::{Child, Leaf, Node, WIDTH};
use super::octet::{Octet, VALID};
use super::ray::{Hit, Ray};
use super::traverse;
use super::triangle::Nearest;

/// Rays that are looked at together.
pub(super) const STREAM: usize = 16;

/// The nearest hits of at most [`STREAM`] rays.
#[inline(always)]
pub(super) fn closest<L: Lanes>(lanes: L, nodes: &[Node], leaves: &[f32], rays: &[Ray], hits: &mut [Option<Hit>]) {
    let rays = &rays[..rays.len().min(STREAM)];
    let Some(first) = rays.first() else { return };
    let mut octets = [Octet::new(rays, first), Octet::new(rays.get(WIDTH..).unwrap_or_default(), first)];
    let mut alive = 0u32;
    for i in 0..rays.len() {
        alive |= u32::from(octets[i / WIDTH].class[i % WIDTH] & VALID != 0) << i;
    }
    let root = &nodes[0];
    // An unused slot's box is inside out.
    let used = |child: usize| root.planes[0][child] <= root.planes[1][child];
    let mut alone = 0u32;
    for child in (0..WIDTH).filter(|child| used(*child) && !Child(root.children[*child]).is_leaf()) {
        for (group, octet) in octets.iter().enumerate() {
            alone |= octet.enter(lanes, root, child) << (group * WIDTH);
        }
    }
    alone &= alive;
    let mut nearest = [Nearest::none(0.0); STREAM];
    for (nearest, ray) in nearest.iter_mut().zip(rays) {
        *nearest = Nearest::none(ray.t_max);
    }
    for child in (0..WIDTH).filter(|child| used(*child) && Child(root.children[*child]).is_leaf()) {
        let leaf = Leaf::of(leaves, Child(root.children[child]));
        for (group, octet) in octets.iter_mut().enumerate() {
            let base = group * WIDTH;
            let active = (alive & !alone) >> base & 0xff;
            if active != 0 && active & octet.enter(lanes, root, child) != 0 {
                let (rays, nearest) = (&rays[base..], &mut nearest[base..base + WIDTH]);
                octet.closest::<L, true>(lanes, [0, 1, 2], leaf, active, rays, nearest);
            }
        }
    }
    for (i, hit) in hits.iter_mut().take(rays.len()).enumerate() {
        *hit = if alone >> i & 1 != 0 {
            traverse::closest(lanes, nodes, leaves, &rays[i])
        } else if alive >> i & 1 != 0 {
            nearest[i].hit()
        } else {
            None
        };
    }
}
