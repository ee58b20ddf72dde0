//! The ray-triangle test: watertight, and the same bits on every path.
//!
//! Woop, Benthin & Wald 2013, "Watertight Ray/Triangle Intersection": vertices are moved so that the ray becomes the z
//! axis; the signs of three 2D edge functions decide. Rounding is monotone, so a sign computed from rounded products is
//! never wrong, only possibly 0, and 0 counts as inside for both triangles of an edge: a ray cannot slip between them.
//! (The paper's second look in double precision would only take hits away.)

use super::bounds::{SLACK, padded};
use super::lanes::Lanes;
use super::node::{Leaf, WIDTH};
use super::ray::{Frame, Hit};

use glam::Vec3;

/// The nearest hit so far.
#[derive(Clone, Copy)]
pub(super) struct Nearest {
    pub t: f32,
    pub triangle: u32,
    /// Of the second and third vertex, not yet divided by the sum of all three.
    pub weights: [f32; 2],
    pub sum: f32,
}

impl Nearest {
    /// No triangle's index.
    pub const NONE: u32 = u32::MAX;

    #[inline(always)]
    pub fn none(t_max: f32) -> Self {
        Self { t: t_max, triangle: Self::NONE, weights: [0.0; 2], sum: 1.0 }
    }

    /// Keeps the nearer hit; of equally near ones that with the smaller index.
    #[inline(always)]
    pub fn take(&mut self, t: f32, triangle: u32, weights: [f32; 2], sum: f32) {
        if t < self.t || (t == self.t && triangle < self.triangle) {
            *self = Self { t, triangle, weights, sum };
        }
    }

    #[inline(always)]
    pub fn hit(&self) -> Option<Hit> {
        let [v, w] = self.weights;
        (self.triangle != Self::NONE).then(|| Hit {
            t: self.t,
            u: v / self.sum,
            v: w / self.sum,
            triangle: self.triangle,
        })
    }
}

/// Pairs of a ray and a triangle, one in each lane. Axes are those of the sheared space of the lane's ray.
pub(super) trait Pairs<L: Lanes> {
    /// One coordinate of the three vertices, relative to the ray's origin.
    fn relative(&self, lanes: L, axis: usize) -> [L::F; 3];
    fn shear(&self, lanes: L, axis: usize) -> L::F;
    /// The reciprocal direction.
    fn inverse(&self, lanes: L, axis: usize) -> L::F;
    fn t_min(&self, lanes: L) -> L::F;
    fn t_max(&self, lanes: L) -> L::F;
    /// The lanes that hold a pair.
    fn used(&self, lanes: L) -> L::M;
}

/// One ray and the triangles of a leaf.
struct Alone<'a> {
    frame: &'a Frame,
    leaf: Leaf<'a>,
    t_max: f32,
}

impl<L: Lanes> Pairs<L> for Alone<'_> {
    #[inline(always)]
    fn relative(&self, lanes: L, axis: usize) -> [L::F; 3] {
        let axis = self.frame.axes[axis];
        let origin = lanes.splat(self.frame.origin_on[axis]);
        let [a, b, c] = lanes.vertices(self.leaf, axis);
        [lanes.sub(a, origin), lanes.sub(b, origin), lanes.sub(c, origin)]
    }
    #[inline(always)]
    fn shear(&self, lanes: L, axis: usize) -> L::F {
        lanes.splat(self.frame.shear[axis])
    }
    #[inline(always)]
    fn inverse(&self, lanes: L, axis: usize) -> L::F {
        lanes.splat(self.frame.inverse_on[self.frame.axes[axis]])
    }
    #[inline(always)]
    fn t_min(&self, lanes: L) -> L::F {
        lanes.splat(self.frame.t_min)
    }
    #[inline(always)]
    fn t_max(&self, lanes: L) -> L::F {
        lanes.splat(self.t_max)
    }
    #[inline(always)]
    fn used(&self, lanes: L) -> L::M {
        lanes.first(self.leaf.count)
    }
}

/// Lanes whose edge functions have one sign.
pub(super) struct Candidates<L: Lanes> {
    pub t: L::F,
    /// The weights of the vertices: `u`, not needed any more, `v`, `w`, and their sum.
    pub v: L::F,
    pub w: L::F,
    pub sum: L::F,
    /// Lanes with `t` in range, and within the triangle's box.
    pub hit: L::M,
    /// The same as bits.
    pub settled: u32,
    /// Lanes with `t` outside the triangle's box: see [`settle`].
    pub doubtful: u32,
}

// Functions, where closures would read better: only these are sure to be inlined, and what is not inlined into a function
// that enables AVX2 calls out for each single instruction.

/// The coordinate `p` of all vertices, in the space whose z axis is the ray.
#[inline(always)]
fn sheared<L: Lanes>(lanes: L, p: [L::F; 3], shear: L::F, z: [L::F; 3]) -> [L::F; 3] {
    [
        lanes.sub(p[0], lanes.mul(shear, z[0])),
        lanes.sub(p[1], lanes.mul(shear, z[1])),
        lanes.sub(p[2], lanes.mul(shear, z[2])),
    ]
}

/// Twice the area that the edge from vertex `i` to vertex `j` spans with the ray: the weight of the third vertex.
#[inline(always)]
fn edge<L: Lanes>(lanes: L, x: [L::F; 3], y: [L::F; 3], i: usize, j: usize) -> L::F {
    lanes.sub(lanes.mul(x[i], y[j]), lanes.mul(y[i], x[j]))
}

/// Between which parameters the ray passes the planes of all vertices on one axis.
#[inline(always)]
fn interval<L: Lanes>(lanes: L, inverse: L::F, p: [L::F; 3]) -> (L::F, L::F) {
    let [a, b, c] = [lanes.mul(p[0], inverse), lanes.mul(p[1], inverse), lanes.mul(p[2], inverse)];
    (lanes.min(lanes.min(a, b), c), lanes.max(lanes.max(a, b), c))
}

/// The lanes whose ray passes between the vertices; `None` where there are none.
#[inline(always)]
pub(super) fn candidates<L: Lanes>(lanes: L, pairs: &impl Pairs<L>) -> Option<Candidates<L>> {
    let pz = pairs.relative(lanes, 2);
    let px = pairs.relative(lanes, 0);
    let py = pairs.relative(lanes, 1);
    let qx = sheared(lanes, px, pairs.shear(lanes, 0), pz);
    let qy = sheared(lanes, py, pairs.shear(lanes, 1), pz);
    let (u, v, w) = (edge(lanes, qx, qy, 2, 1), edge(lanes, qx, qy, 0, 2), edge(lanes, qx, qy, 1, 0));
    let zero = lanes.splat(0.0);
    let (least, most) = (lanes.min(lanes.min(u, v), w), lanes.max(lanes.max(u, v), w));
    // Both faces count.
    let inside = lanes.and(pairs.used(lanes), lanes.or(lanes.le(zero, least), lanes.le(most, zero)));
    if lanes.bits(inside) == 0 {
        return None;
    }
    let sum = lanes.add(lanes.add(u, v), w);
    let depth = lanes.add(lanes.add(lanes.mul(u, pz[0]), lanes.mul(v, pz[1])), lanes.mul(w, pz[2]));
    let [ix, iy, iz] = [pairs.inverse(lanes, 0), pairs.inverse(lanes, 1), pairs.inverse(lanes, 2)];
    let t = lanes.mul(lanes.div(depth, sum), iz);
    let (x, y, z) = (interval(lanes, ix, px), interval(lanes, iy, py), interval(lanes, iz, pz));
    // Half of what `settle` and the boxes of the hierarchy allow, so that `settle` would leave `t` as it is.
    let pad = lanes.mul(lanes.sub(z.1, z.0), lanes.splat(0.5 * SLACK));
    let near = lanes.sub(lanes.mul(lanes.max(lanes.max(x.0, y.0), z.0), lanes.splat(1.0 - 0.5 * SLACK)), pad);
    let far = lanes.add(lanes.mul(lanes.min(lanes.min(x.1, y.1), z.1), lanes.splat(1.0 + 0.5 * SLACK)), pad);
    // A triangle wholly behind the origin is none of this ray's.
    let inside = lanes.and(inside, lanes.le(zero, far));
    let settled = lanes.and(lanes.and(inside, lanes.le(near, t)), lanes.le(t, far));
    let in_range = lanes.and(lanes.lt(pairs.t_min(lanes), t), lanes.le(t, pairs.t_max(lanes)));
    let doubtful = lanes.bits(inside) & !lanes.bits(settled);
    let hit = lanes.and(settled, in_range);
    Some(Candidates { t, v, w, sum, hit, settled: lanes.bits(hit), doubtful })
}

/// The parameter of a hit that the edge functions accept, moved into the triangle's box: seen almost edge-on, the
/// weights are noise, and `t` may lie anywhere. `None` where the ray misses the box, or only meets it up to `t_min`.
///
/// With this a hit is a property of ray and triangle alone, whatever the hierarchy looks like: the slab test is monotone
/// at every step, so a ray enters each box that holds the triangle before the hit and leaves it after, to within
/// [`super::bounds::BOX_SLACK`].
#[cold]
#[inline(never)]
pub(super) fn settle(frame: &Frame, leaf: Leaf, lane: usize, t: f32) -> Option<f32> {
    let vertex = |i: usize| Vec3::from_array([0, 1, 2].map(|axis| leaf.coordinate(lane, i, axis)));
    let bounds = padded(&[vertex(0), vertex(1), vertex(2)]);
    let (mut near, mut far) = (f32::NEG_INFINITY, f32::INFINITY);
    for axis in 0..3 {
        let low = (bounds.min[axis] - frame.origin_on[axis]) * frame.inverse_on[axis];
        let high = (bounds.max[axis] - frame.origin_on[axis]) * frame.inverse_on[axis];
        near = near.max(low.min(high));
        far = far.min(low.max(high));
    }
    let (near, far) = (near * (1.0 - SLACK), far * (1.0 + SLACK));
    // Exactly edge-on the weights sum to 0 and `t` is not a number.
    let hit = near <= far && !t.is_nan();
    hit.then(|| t.max(near).min(far)).filter(|&t| t > frame.t_min)
}

/// Takes the nearest hit of a leaf; says whether there was a nearer one.
#[inline(always)]
pub(super) fn closest<L: Lanes>(lanes: L, frame: &Frame, leaf: Leaf, nearest: &mut Nearest) -> bool {
    let Some(found) = candidates(lanes, &Alone { frame, leaf, t_max: nearest.t }) else { return false };
    let before = nearest.t;
    let (t, v, w, sum) = (lanes.store(found.t), lanes.store(found.v), lanes.store(found.w), lanes.store(found.sum));
    let mut settled = found.settled;
    while settled != 0 {
        let lane = settled.trailing_zeros() as usize % WIDTH;
        settled &= settled - 1;
        nearest.take(t[lane], leaf.triangle(lane), [v[lane], w[lane]], sum[lane]);
    }
    let mut doubtful = found.doubtful;
    while doubtful != 0 {
        let lane = doubtful.trailing_zeros() as usize % WIDTH;
        doubtful &= doubtful - 1;
        if let Some(t) = settle(frame, leaf, lane, t[lane]) {
            nearest.take(t, leaf.triangle(lane), [v[lane], w[lane]], sum[lane]);
        }
    }
    nearest.t < before
}

/// Whether the ray hits any triangle of a leaf.
#[inline(always)]
pub(super) fn occluded<L: Lanes>(lanes: L, frame: &Frame, leaf: Leaf) -> bool {
    let Some(found) = candidates(lanes, &Alone { frame, leaf, t_max: frame.t_max }) else { return false };
    found.settled != 0 || {
        let t = lanes.store(found.t);
        let mut doubtful = (0..WIDTH).filter(|lane| found.doubtful >> lane & 1 != 0);
        doubtful.any(|lane| settle(frame, leaf, lane, t[lane]).is_some_and(|t| t <= frame.t_max))
    }
}
