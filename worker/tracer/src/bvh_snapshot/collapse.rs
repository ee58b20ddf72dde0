//! From a binary hierarchy to an eight-wide one.
//!
//! Ylitie, Karras & Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", section 3.1:
//! `cost[i]` of a binary subtree is the least surface-area cost of showing it to a wide node as at most `i + 1` children;
//! dynamic programming from the leaves up finds it, and one walk down reads the tree off.

use super::bounds::Bounds;
use super::node::{BLOCK, WIDTH};
use obvhs::bvh2::Bvh2;

pub(super) struct Costs { pub node: f32, pub block: f32 }

/// How a subtree is best shown as at most so many children.
#[derive(Clone, Copy, Default)]
enum Choice {
    #[default]
    Leaf,
    Node,
    /// The first child gets this many of the slots.
    Split(u8),
}

#[derive(Clone, Copy)]
struct Entry {
    cost: [f32; WIDTH - 1],
    choice: [Choice; WIDTH - 1],
    /// How the wide node at this subtree splits its eight slots.
    split: u8,
    count: u32,
}

/// The collapse plan
pub(super) struct Plan<'a> {
    tree: &'a Bvh2,
    entries: Vec<Entry>,
}

pub(super) enum Slot {
    /// binary node that becomes a wide node
    Node(usize),
    /// binary node whose triangles become a block
    Leaf(usize),
}

impl<'a> Plan<'a> {
    pub fn new(tree: &'a Bvh2, costs: Costs) -> Self {
        let mut entries = vec![Entry { cost: [0.0; 7], choice: [Choice::Leaf; 7], split: 0, count: 0 }; tree.nodes.len()];
        // children before parents
        let mut order = Vec::with_capacity(tree.nodes.len());
        let mut todo = vec![0usize];
        while let Some(i) = todo.pop() {
            order.push(i);
            let n = &tree.nodes[i];
            if !n.is_leaf() { todo.push(n.first_index as usize); todo.push(n.first_index as usize + 1); }
        }
        for &i in order.iter().rev() {
            let n = &tree.nodes[i];
            let area = n.aabb.half_area();
            if n.is_leaf() {
                entries[i] = Entry { cost: [area * costs.block; 7], choice: [Choice::Leaf; 7], split: 0, count: n.prim_count };
                continue;
            }
            let (l, r) = (entries[n.first_index as usize], entries[n.first_index as usize + 1]);
            let distribute = |slots: usize| {
                let mut best = (f32::INFINITY, 0u8);
                for k in 1..slots {
                    let c = l.cost[k - 1] + r.cost[slots - k - 1];
                    if c < best.0 { best = (c, k as u8); }
                }
                best
            };
            let count = l.count + r.count;
            let (inner, split) = distribute(WIDTH);
            let node_cost = inner + area * costs.node;
            let leaf_cost = if count as usize <= BLOCK { area * costs.block } else { f32::INFINITY };
            let e = &mut entries[i];
            e.split = split;
            e.count = count;
            (e.cost[0], e.choice[0]) = if leaf_cost <= node_cost { (leaf_cost, Choice::Leaf) } else { (node_cost, Choice::Node) };
            for slots in 2..WIDTH {
                let (c, k) = distribute(slots);
                if c < e.cost[slots - 2] { e.cost[slots - 1] = c; e.choice[slots - 1] = Choice::Split(k); }
                else { e.cost[slots - 1] = e.cost[slots - 2]; e.choice[slots - 1] = e.choice[slots - 2]; }
            }
        }
        Self { tree, entries }
    }

    pub fn root_is_leaf(&self) -> bool { self.tree.nodes[0].is_leaf() }

    /// children of the wide node made of binary node i
    pub fn children(&self, i: usize) -> Vec<Slot> {
        let mut out = Vec::with_capacity(8);
        let n = &self.tree.nodes[i];
        let split = self.entries[i].split as usize;
        let mut todo = vec![(n.first_index as usize + 1, WIDTH - split), (n.first_index as usize, split)];
        while let Some((i, slots)) = todo.pop() {
            match self.entries[i].choice[slots - 1] {
                Choice::Leaf => out.push(Slot::Leaf(i)),
                Choice::Node => out.push(Slot::Node(i)),
                Choice::Split(k) => {
                    // slots actually used may be fewer
                    let mut slots = slots;
                    while slots > 2 && self.entries[i].cost[slots - 2] <= self.entries[i].cost[slots - 1] { slots -= 1; }
                    let f = self.tree.nodes[i].first_index as usize;
                    todo.push((f + 1, slots - k as usize));
                    todo.push((f, k as usize));
                }
            }
        }
        out
    }

    pub fn triangles(&self, i: usize) -> Vec<u32> {
        let mut out = vec![];
        let mut todo = vec![i];
        while let Some(i) = todo.pop() {
            let n = &self.tree.nodes[i];
            if n.is_leaf() {
                out.extend((0..n.prim_count).map(|k| self.tree.primitive_indices[(n.first_index + k) as usize]));
            } else { todo.push(n.first_index as usize + 1); todo.push(n.first_index as usize); }
        }
        out
    }
    pub fn bounds(&self, i: usize) -> Bounds {
        let b = &self.tree.nodes[i].aabb;
        Bounds { low: b.min.into(), high: b.max.into() }
    }
}
