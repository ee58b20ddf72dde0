//! From a binary tree to the cheapest eight-wide one.
//!
//! Ylitie, Karras & Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", section 3.1:
//! dynamic programming, from the leaves up, finds the least surface area cost of showing a subtree to a wide node as at
//! most so many children; a walk from the root then reads the tree off.

use super::node::WIDTH;

use obvhs::bvh2::Bvh2;

/// What it costs, per area, to test a leaf against a ray, where a node costs 1.
const LEAF: f32 = 1.0;
/// What each triangle adds to it. The vector does not care; but a box that holds several distant walls is entered by
/// rays that would have met none of them.
const TRIANGLE: f32 = 0.07;

/// A child of a wide node.
#[derive(Clone, Copy)]
pub(super) enum Child {
    /// A wide node, made of this binary one.
    Node(u32),
    /// The triangles below this binary node.
    Leaf(u32),
}

impl Child {
    pub fn is_node(self) -> bool {
        matches!(self, Self::Node(_))
    }

    /// The binary node.
    pub fn source(self) -> u32 {
        match self {
            Self::Node(source) | Self::Leaf(source) => source,
        }
    }
}

/// How to show a subtree to the wide node above it.
#[derive(Clone, Copy)]
enum Form {
    /// As one leaf.
    Leaf,
    /// As one node.
    Node,
    /// As the children of its two halves: the first half gets this many of the slots.
    Halves(u8),
}

/// The best forms of one binary node.
#[derive(Clone, Copy)]
struct Best {
    /// `cost[i]` and `form[i]`, with at most `i + 1` slots.
    cost: [f32; WIDTH - 1],
    form: [Form; WIDTH - 1],
    /// Slots of the first half, once the node has all eight of its own.
    first_half: u8,
    triangles: u32,
}

/// A binary tree and how to collapse it.
pub(super) struct Collapse<'a> {
    tree: &'a Bvh2,
    best: Vec<Best>,
}

impl<'a> Collapse<'a> {
    /// Weighs all forms. `tree` has at least one node, and one triangle per leaf.
    pub fn new(tree: &'a Bvh2) -> Self {
        let unknown = Best { cost: [0.0; WIDTH - 1], form: [Form::Leaf; WIDTH - 1], first_half: 0, triangles: 0 };
        let mut best = vec![unknown; tree.nodes.len()];
        let mut parents_first = Vec::with_capacity(tree.nodes.len());
        let mut todo = vec![0];
        while let Some(i) = todo.pop() {
            parents_first.push(i);
            let node = &tree.nodes[i];
            if !node.is_leaf() {
                todo.extend([node.first_index as usize, node.first_index as usize + 1]);
            }
        }
        for &i in parents_first.iter().rev() {
            let node = &tree.nodes[i];
            let area = node.aabb.half_area();
            best[i] = if node.is_leaf() {
                Best { cost: [area * (LEAF + TRIANGLE); WIDTH - 1], triangles: 1, ..unknown }
            } else {
                let first = node.first_index as usize;
                Best::of(area, &best[first], &best[first + 1])
            };
        }
        Self { tree, best }
    }

    /// The children of the wide node made of binary node `i`.
    pub fn children(&self, i: u32, children: &mut Vec<Child>) {
        children.clear();
        let node = &self.tree.nodes[i as usize];
        if node.is_leaf() {
            children.push(Child::Leaf(i));
            return;
        }
        let first_half = usize::from(self.best[i as usize].first_half);
        self.show(node.first_index, first_half, children);
        self.show(node.first_index + 1, WIDTH - first_half, children);
    }

    fn show(&self, i: u32, slots: usize, children: &mut Vec<Child>) {
        match self.best[i as usize].form[slots - 1] {
            Form::Leaf => children.push(Child::Leaf(i)),
            Form::Node => children.push(Child::Node(i)),
            Form::Halves(first_half) => {
                let (first, first_half) = (self.tree.nodes[i as usize].first_index, usize::from(first_half));
                self.show(first, first_half, children);
                self.show(first + 1, slots - first_half, children);
            }
        }
    }

    /// The triangles, as indices of the boxes that the tree was built from, below binary node `i`.
    pub fn triangles(&self, i: u32, triangles: &mut Vec<u32>) {
        let node = &self.tree.nodes[i as usize];
        if node.is_leaf() {
            triangles.push(self.tree.primitive_indices[node.first_index as usize]);
        } else {
            self.triangles(node.first_index, triangles);
            self.triangles(node.first_index + 1, triangles);
        }
    }
}

impl Best {
    /// Of a node with this half area, from its two halves.
    fn of(area: f32, a: &Best, b: &Best) -> Self {
        let share = |slots: usize| {
            let mut best = (f32::INFINITY, 1);
            for first in 1..slots {
                let cost = a.cost[first - 1] + b.cost[slots - first - 1];
                if cost < best.0 {
                    best = (cost, first as u8);
                }
            }
            best
        };
        let triangles = a.triangles + b.triangles;
        let (below, first_half) = share(WIDTH);
        let as_leaf = area * (LEAF + TRIANGLE * triangles as f32);
        let as_one = if triangles as usize <= WIDTH && as_leaf <= below + area {
            (as_leaf, Form::Leaf)
        } else {
            (below + area, Form::Node)
        };
        let mut best = Self { cost: [as_one.0; WIDTH - 1], form: [as_one.1; WIDTH - 1], first_half, triangles };
        let mut least = as_one;
        for slots in 2..WIDTH {
            let (cost, first) = share(slots);
            if cost < least.0 {
                least = (cost, Form::Halves(first));
            }
            // What fits fewer slots fits these: more slots never make a half dearer.
            (best.cost[slots - 1], best.form[slots - 1]) = least;
        }
        best
    }
}
