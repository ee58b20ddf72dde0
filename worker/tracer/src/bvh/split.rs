//! The binary tree: from the top down by the surface area heuristic.
//!
//! Wald 2007, "On fast Construction of SAH-based Bounding Volume Hierarchies": large sets are split between bins of
//! their centroids, small ones after every sorted centroid. Rays visit about a tenth fewer nodes than in the tree that
//! obvhs merges from the bottom up (PLOC) in the same time; obvhs's reinsertion then improves this one, too.

use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;

/// Bins per axis.
const BINS: usize = 32;
/// Sets up to this size are split exactly.
const EXACT: usize = 32;
/// Sets from this size on are worth a task of their own.
const PARALLEL: usize = 4096;

/// A box to be sorted into the tree.
#[derive(Clone, Copy)]
struct Item {
    bounds: Aabb,
    index: u32,
}

impl Item {
    /// Twice the centroid.
    fn centroid(&self, axis: usize) -> f32 {
        self.bounds.min[axis] + self.bounds.max[axis]
    }
}

/// A tree with one box per leaf. From `depth_limit` on, sets are halved, whatever it costs: that bounds the depth to
/// `depth_limit + log2(boxes)`.
pub(super) fn tree(boxes: &[Aabb], depth_limit: usize) -> Bvh2 {
    let mut items: Vec<Item> = boxes.iter().zip(0..).map(|(&bounds, index)| Item { bounds, index }).collect();
    let mut nodes = vec![Bvh2Node::default(); (2 * items.len()).saturating_sub(1)];
    if let Some((root, descendants)) = nodes.split_first_mut() {
        split(&mut items, 0, root, descendants, 1, depth_limit);
    }
    Bvh2 { nodes, primitive_indices: items.iter().map(|item| item.index).collect(), ..Bvh2::default() }
}

/// Fills `node` and its descendants, whose first has the index `at`; the first item is the `first` of all.
fn split(
    items: &mut [Item],
    first: u32,
    node: &mut Bvh2Node,
    descendants: &mut [Bvh2Node],
    at: u32,
    depth_limit: usize,
) {
    let bounds = items.iter().fold(Aabb::INVALID, |bounds, item| bounds.union(&item.bounds));
    let [left, right, descendants @ ..] = descendants else {
        *node = Bvh2Node::new(bounds, 1, first);
        return;
    };
    *node = Bvh2Node::new(bounds, 0, at);
    let count = if depth_limit == 0 {
        halve(items)
    } else if items.len() <= EXACT {
        split_exactly(items)
    } else {
        split_by_bins(items).unwrap_or_else(|| halve(items))
    };
    let count = count.clamp(1, items.len() - 1);
    let parallel = items.len() >= PARALLEL;
    let (left_items, right_items) = items.split_at_mut(count);
    let (left_below, right_below) = descendants.split_at_mut(2 * count - 2);
    let (at, depth_limit) = (at + 2, depth_limit.saturating_sub(1));
    let (right_first, right_at) = (first + count as u32, at + left_below.len() as u32);
    let mut go_left = || split(left_items, first, left, left_below, at, depth_limit);
    let mut go_right = || split(right_items, right_first, right, right_below, right_at, depth_limit);
    if parallel {
        rayon::join(go_left, go_right);
    } else {
        go_left();
        go_right();
    }
}

/// The middle of the items along the axis on which their centroids spread most.
fn halve(items: &mut [Item]) -> usize {
    let spread = items.iter().fold(Aabb::INVALID, |spread, item| {
        let centroid = item.bounds.min + item.bounds.max;
        spread.union(&Aabb::from_point(centroid))
    });
    sort(items, spread.largest_axis());
    items.len() / 2
}

fn sort(items: &mut [Item], axis: usize) {
    // The index makes the order, and so the tree, unique.
    items.sort_unstable_by(|a, b| a.centroid(axis).total_cmp(&b.centroid(axis)).then(a.index.cmp(&b.index)));
}

/// Tries every place on every axis; leaves the items in the order of the best.
fn split_exactly(items: &mut [Item]) -> usize {
    let (mut best, mut best_axis, mut count) = (f32::INFINITY, 0, items.len() / 2);
    let mut right_cost = [0.0; EXACT];
    for axis in 0..3 {
        sort(items, axis);
        let mut bounds = Aabb::INVALID;
        for i in (1..items.len()).rev() {
            bounds = bounds.union(&items[i].bounds);
            right_cost[i] = bounds.half_area() * (items.len() - i) as f32;
        }
        let mut bounds = Aabb::INVALID;
        for i in 1..items.len() {
            bounds = bounds.union(&items[i - 1].bounds);
            let cost = bounds.half_area() * i as f32 + right_cost[i];
            if cost < best {
                (best, best_axis, count) = (cost, axis, i);
            }
        }
    }
    if best_axis != 2 {
        sort(items, best_axis);
    }
    count
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Aabb,
    count: usize,
}

/// `None` where all centroids share one bin.
fn split_by_bins(items: &mut [Item]) -> Option<usize> {
    let spread = items
        .iter()
        .fold(Aabb::INVALID, |spread, item| spread.union(&Aabb::from_point(item.bounds.min + item.bounds.max)));
    let scale = glam::Vec3A::splat(BINS as f32 * 0.999_999) / (spread.max - spread.min);
    let bin = |item: &Item| ((item.bounds.min + item.bounds.max - spread.min) * scale).to_array();
    let mut bins = [[Bin { bounds: Aabb::INVALID, count: 0 }; BINS]; 3];
    for item in items.iter() {
        for (bins, at) in bins.iter_mut().zip(bin(item)) {
            // NaN, on an axis without extent, becomes 0.
            let bin = &mut bins[(at as usize).min(BINS - 1)];
            bin.bounds = bin.bounds.union(&item.bounds);
            bin.count += 1;
        }
    }
    let (mut best, mut best_axis, mut edge) = (f32::INFINITY, 0, 0);
    for (axis, bins) in bins.iter().enumerate() {
        let mut right_cost = [0.0; BINS];
        let mut right = Bin { bounds: Aabb::INVALID, count: 0 };
        for i in (1..BINS).rev() {
            right = Bin { bounds: right.bounds.union(&bins[i].bounds), count: right.count + bins[i].count };
            right_cost[i] =
                if right.count == 0 { f32::INFINITY } else { right.bounds.half_area() * right.count as f32 };
        }
        let mut left = Bin { bounds: Aabb::INVALID, count: 0 };
        for i in 1..BINS {
            left = Bin { bounds: left.bounds.union(&bins[i - 1].bounds), count: left.count + bins[i - 1].count };
            let cost = left.bounds.half_area() * left.count as f32 + right_cost[i];
            if left.count > 0 && cost < best {
                (best, best_axis, edge) = (cost, axis, i);
            }
        }
    }
    if best == f32::INFINITY {
        return None;
    }
    let mut count = 0;
    for i in 0..items.len() {
        if ((bin(&items[i])[best_axis] as usize).min(BINS - 1)) < edge {
            items.swap(i, count);
            count += 1;
        }
    }
    Some(count)
}
