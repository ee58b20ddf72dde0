//! Rays that start close together and run anywhere, such as those that leave the surface under one pixel. Most of them
//! leave the part for good: the root's boxes and the triangles beside them, tested for eight rays at a time, tell.
//! The others go on alone.

use super::bundle::{Bundle, Hits};
use super::lanes::Lanes;
use super::node::{Child, Leaf, Node, WIDTH};
use super::octet::Octet;
use super::traverse;
use crate::vectors::{BLOCK, lanes as lanes_of};

/// The nearest hits of the rays of a bundle.
#[inline(always)]
pub(super) fn closest<L: Lanes>(lanes: L, nodes: &[Node], leaves: &[f32], rays: &Bundle, hits: &mut Hits) {
    let rays = &rays.filled();
    let mut octets = [Octet::new::<0, L>(lanes, rays), Octet::new::<WIDTH, L>(lanes, rays)];
    let alive = (octets[0].valid | octets[1].valid << WIDTH) & rays.used;
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
    for child in (0..WIDTH).filter(|child| used(*child) && Child(root.children[*child]).is_leaf()) {
        let leaf = Leaf::of(leaves, Child(root.children[child]));
        for (group, octet) in octets.iter_mut().enumerate() {
            let active = (alive & !alone) >> (group * WIDTH) & 0xff;
            if active != 0 && active & octet.enter(lanes, root, child) != 0 {
                octet.closest::<L, true>(lanes, [0, 1, 2], leaf, active);
            }
        }
    }
    for octet in &octets {
        octet.write(lanes, hits);
    }
    // What has no direction has hit nothing, whatever the arithmetic says.
    for lane in lanes_of(rays.used & !alive) {
        hits.set(lane, None);
    }
    while alone != 0 {
        let lane = alone.trailing_zeros() as usize % BLOCK;
        alone &= alone - 1;
        hits.set(lane, traverse::closest(lanes, nodes, leaves, &rays.ray(lane)));
    }
}
