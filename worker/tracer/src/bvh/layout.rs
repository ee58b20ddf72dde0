//! From triangles to the arrays that rays traverse.

use super::bounds::padded;
use super::collapse::{Child as Source, Collapse};
use super::memory::Pages;
use super::node::{Child, MOST_TRIANGLES, Node, WIDTH};
use super::split;
use super::stack::CAPACITY;

use glam::Vec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;

/// Depth up to which the tree may split as it likes.
const DEPTH: usize = 64;

/// The share of nodes that reinsertion reconsiders: obvhs's own for a slow build.
const REINSERTION: f32 = 0.2;

/// Coordinates beyond this have products that overflow.
const LARGEST: f32 = 1e12;

/// The nodes, root first, and the rows of the leaves.
pub(super) struct Layout {
    pub nodes: Pages<Node>,
    pub leaves: Pages<f32>,
    /// The longest edge of the root's box.
    pub extent: f32,
}

/// Lays out a hierarchy over the triangles that have an area.
pub(super) fn layout(triangles: &[[Vec3; 3]]) -> Layout {
    let solid: Vec<u32> =
        (0..).zip(triangles).filter(|(_, triangle)| has_area(triangle)).map(|(i, _)| i).take(MOST_TRIANGLES).collect();
    if solid.is_empty() {
        return Layout { nodes: Pages::new(vec![Node::EMPTY]), leaves: Pages::new(Vec::new()), extent: 0.0 };
    }
    let boxes: Vec<Aabb> = solid.iter().map(|&i| padded(&triangles[i as usize])).collect();
    let mut tree = split::tree(&boxes, DEPTH);
    ReinsertionOptimizer::default().run(&mut tree, REINSERTION, None);
    let writer = Writer { triangles, solid: &solid };
    let (nodes, leaves) = writer.write(&tree).unwrap_or_else(|| {
        // Only a tree that nobody has ever met is too deep; one that halves its sets, whatever it costs, is not.
        let tree = split::tree(&boxes, 0);
        writer.write(&tree).unwrap_or_default()
    });
    let extent = tree.nodes[0].aabb.diagonal().max_element();
    Layout { nodes: Pages::new(nodes), leaves: Pages::new(leaves), extent }
}

/// Whether a triangle can be hit: not where its vertices lie on a line or a point, or are out of range.
fn has_area(triangle: &[Vec3; 3]) -> bool {
    let [a, b, c] = triangle.map(Vec3::as_dvec3);
    let (ab, ac) = (b - a, c - a);
    // Products of single-precision differences are exact in double precision, or nearly.
    let in_range = triangle.iter().all(|v| v.is_finite() && v.abs().max_element() <= LARGEST);
    in_range && ab.cross(ac).length() > 1e-14 * ab.length() * ac.length()
}

/// Writes a binary tree as wide nodes and leaves, depth first, so that a ray's path lies close together.
struct Writer<'a> {
    triangles: &'a [[Vec3; 3]],
    /// The triangles of the tree's leaves.
    solid: &'a [u32],
}

/// A wide node yet to be written.
struct Todo {
    source: u32,
    /// The slot that refers to it.
    parent: Option<(usize, usize)>,
    /// Slots of the traversal's stack in use when a ray comes here.
    pending: usize,
}

impl Writer<'_> {
    /// `None` where a ray might need more than the stack's [`CAPACITY`].
    fn write(&self, tree: &Bvh2) -> Option<(Vec<Node>, Vec<f32>)> {
        let collapse = Collapse::new(tree);
        let mut nodes: Vec<Node> = Vec::new();
        let mut leaves = Vec::with_capacity(super::node::ROWS * self.solid.len() + WIDTH);
        let (mut children, mut members, mut stored) = (Vec::new(), Vec::new(), 0);
        let mut todo = vec![Todo { source: 0, parent: None, pending: 0 }];
        while let Some(Todo { source, parent, pending }) = todo.pop() {
            let index = nodes.len();
            if let Some((parent, slot)) = parent {
                nodes[parent].children[slot] = Child::node(index).0;
            }
            collapse.children(source, &mut children);
            let area = |child: &Source| tree.nodes[child.source() as usize].aabb.half_area();
            // Where a ray that asks for any hit looks first: at triangles at hand, then into large boxes.
            children.sort_by(|a, b| a.is_node().cmp(&b.is_node()).then(area(b).total_cmp(&area(a))));
            let pending = pending + children.len();
            if pending + WIDTH > CAPACITY {
                return None;
            }
            let mut node = Node::EMPTY;
            for (slot, child) in children.iter().enumerate() {
                let bounds = &tree.nodes[child.source() as usize].aabb;
                for axis in 0..3 {
                    node.planes[axis * 2][slot] = bounds.min[axis];
                    node.planes[axis * 2 + 1][slot] = bounds.max[axis];
                }
                if let Source::Leaf(source) = *child {
                    members.clear();
                    collapse.triangles(source, &mut members);
                    node.children[slot] = Child::leaf(stored, members.len()).0;
                    stored += members.len();
                    self.write_leaf(&members, &mut leaves);
                }
            }
            nodes.push(node);
            for (slot, child) in children.iter().enumerate().rev() {
                if let Source::Node(source) = *child {
                    todo.push(Todo { source, parent: Some((index, slot)), pending });
                }
            }
        }
        // The last leaf's rows are loaded eight wide, too.
        leaves.extend([0.0; WIDTH]);
        Some((nodes, leaves))
    }

    fn write_leaf(&self, members: &[u32], leaves: &mut Vec<f32>) {
        for vertex in 0..3 {
            for axis in 0..3 {
                let coordinate = |&i: &u32| self.triangles[self.solid[i as usize] as usize][vertex][axis];
                leaves.extend(members.iter().map(coordinate));
            }
        }
        leaves.extend(members.iter().map(|&i| f32::from_bits(self.solid[i as usize])));
    }
}
