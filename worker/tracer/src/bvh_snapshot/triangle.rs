//! The ray-triangle test: watertight, and the same bits on every path.
//!
//! Woop, Benthin & Wald 2013, "Watertight Ray/Triangle Intersection": vertices are moved so that the ray becomes the z
//! axis; the signs of three 2D edge functions decide. Rounding is monotone, so a sign computed from rounded products is
//! never wrong, only possibly 0, and 0 counts as inside for both triangles of an edge: a ray cannot slip between them.
//! The paper's second look in double precision would only take away the double hits.

use super::bounds::{Bounds, SLACK};
use super::lanes::Lanes;
use super::node::{BLOCK, Block};
use super::ray::{Frame, Hit};

use glam::Vec3;

/// The nearest hit so far, with its weights not yet divided by their sum.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearest {
    pub t: f32,
    pub triangle: u32,
    weights: [f32; 2],
    sum: f32,
}

impl Nearest {
    #[inline(always)]
    pub fn none(t_max: f32) -> Self {
        Self { t: t_max, triangle: u32::MAX, weights: [0.0; 2], sum: 1.0 }
    }

    #[inline(always)]
    pub fn hit(&self) -> Option<Hit> {
        let [v, w] = self.weights;
        (self.triangle != u32::MAX).then(|| Hit { t: self.t, u: v / self.sum, v: w / self.sum, triangle: self.triangle })
    }
}

/// Three vertices relative to the ray's origin and, for each, what shearing makes of it.
struct Candidates<L: Lanes<BLOCK>> {
    t: L::F,
    sum: L::F,
    v: L::F,
    w: L::F,
    /// Lanes whose `t` is beyond doubt.
    settled: u32,
    /// Lanes that the edge functions accept but whose `t` may lie outside the triangle's box.
    doubtful: u32,
}

#[inline(always)]
fn candidates<L: Lanes<BLOCK>>(lanes: L, frame: &Frame, block: &Block, t_max: f32) -> Option<Candidates<L>> {
    let [x, y, z] = frame.axes;
    let (sx, sy) = (lanes.splat(frame.shear[0]), lanes.splat(frame.shear[1]));
    let relative = |vertex: usize, axis: usize| {
        lanes.sub(lanes.load(&block.vertices[vertex * 3 + axis]), lanes.splat(frame.origin[axis]))
    };
    let [az, bz, cz] = [relative(0, z), relative(1, z), relative(2, z)];
    let [ax, bx, cx] = [relative(0, x), relative(1, x), relative(2, x)];
    let [ay, by, cy] = [relative(0, y), relative(1, y), relative(2, y)];
    let sheared = |p, s, pz| lanes.sub(p, lanes.mul(s, pz));
    let [apx, bpx, cpx] = [sheared(ax, sx, az), sheared(bx, sx, bz), sheared(cx, sx, cz)];
    let [apy, bpy, cpy] = [sheared(ay, sy, az), sheared(by, sy, bz), sheared(cy, sy, cz)];
    let edge = |px, py, qx, qy| lanes.sub(lanes.mul(px, qy), lanes.mul(py, qx));
    let u = edge(cpx, cpy, bpx, bpy);
    let v = edge(apx, apy, cpx, cpy);
    let w = edge(bpx, bpy, apx, apy);
    let zero = lanes.splat(0.0);
    let (least, most) = (lanes.min(lanes.min(u, v), w), lanes.max(lanes.max(u, v), w));
    let sum = lanes.add(lanes.add(u, v), w);
    // Both faces count; a triangle seen edge-on, whose weights sum to 0, does not.
    let front = lanes.and(lanes.le(zero, least), lanes.lt(zero, sum));
    let back = lanes.and(lanes.le(most, zero), lanes.lt(sum, zero));
    let inside = lanes.or(front, back);
    if lanes.bits(inside) == 0 {
        return None;
    }
    let depth = lanes.add(lanes.add(lanes.mul(u, az), lanes.mul(v, bz)), lanes.mul(w, cz));
    let t = lanes.mul(lanes.div(depth, sum), lanes.splat(frame.inverse[z]));

    let interval = |axis: usize, a, b, c| {
        let inverse = lanes.splat(frame.inverse[axis]);
        let [a, b, c] = [lanes.mul(a, inverse), lanes.mul(b, inverse), lanes.mul(c, inverse)];
        (lanes.min(lanes.min(a, b), c), lanes.max(lanes.max(a, b), c))
    };
    let (x, y, z) = (interval(x, ax, bx, cx), interval(y, ay, by, cy), interval(z, az, bz, cz));
    let near = lanes.mul(lanes.max(lanes.max(x.0, y.0), z.0), lanes.splat(1.0 - SLACK));
    let far = lanes.mul(lanes.min(lanes.min(x.1, y.1), z.1), lanes.splat(1.0 + SLACK));
    let settled = lanes.bits(lanes.and(lanes.and(inside, lanes.le(near, t)), lanes.le(t, far)));
    let in_range = lanes.bits(lanes.and(lanes.lt(lanes.splat(frame.t_min), t), lanes.le(t, lanes.splat(t_max))));
    Some(Candidates { t, sum, v, w, settled: settled & in_range, doubtful: lanes.bits(inside) & !settled })
}

/// The parameter of a hit that the edge functions accept, moved into the triangle's box: seen almost edge-on, the
/// weights are noise, and `t` may lie anywhere. `None` where the ray misses the box.
///
/// With this a hit is a property of ray and triangle alone: whatever box holds the triangle, the ray enters it before
/// the hit and leaves it after (up to twice [`SLACK`]), because every step of the slab test is monotone.
#[cold]
#[inline(never)]
fn settle(frame: &Frame, block: &Block, lane: usize, t: f32) -> Option<f32> {
    let vertex = |i: usize| Vec3::from_array([0, 1, 2].map(|axis| block.vertices[i * 3 + axis][lane]));
    let bounds = Bounds::padded(&[vertex(0), vertex(1), vertex(2)]);
    let (mut near, mut far) = (f32::NEG_INFINITY, f32::INFINITY);
    for axis in 0..3 {
        let low = (bounds.low[axis] - frame.origin[axis]) * frame.inverse[axis];
        let high = (bounds.high[axis] - frame.origin[axis]) * frame.inverse[axis];
        near = near.max(low.min(high));
        far = far.min(low.max(high));
    }
    let (near, far) = (near * (1.0 - SLACK), far * (1.0 + SLACK));
    (near <= far).then(|| t.max(near).min(far))
}

/// Takes the nearest hit of a block; of equally near ones that with the smallest index.
#[inline(always)]
pub(super) fn closest<L: Lanes<BLOCK>>(lanes: L, frame: &Frame, block: &Block, nearest: &mut Nearest) -> bool {
    let Some(found) = candidates(lanes, frame, block, nearest.t) else { return false };
    let (t, sum, v, w) = (lanes.store(found.t), lanes.store(found.sum), lanes.store(found.v), lanes.store(found.w));
    let mut better = false;
    let mut take = |lane: usize, t: f32| {
        let triangle = block.triangles[lane];
        if t < nearest.t || (t == nearest.t && triangle < nearest.triangle) {
            *nearest = Nearest { t, triangle, weights: [v[lane], w[lane]], sum: sum[lane] };
            better = true;
        }
    };
    for lane in set_bits(found.settled) {
        take(lane, t[lane]);
    }
    for lane in set_bits(found.doubtful) {
        if let Some(t) = settle(frame, block, lane, t[lane])
            && t > frame.t_min
        {
            take(lane, t);
        }
    }
    better
}

/// Whether the ray hits any triangle of a block.
#[inline(always)]
pub(super) fn occluded<L: Lanes<BLOCK>>(lanes: L, frame: &Frame, block: &Block) -> bool {
    let Some(found) = candidates(lanes, frame, block, frame.t_max) else { return false };
    found.settled != 0 || {
        let t = lanes.store(found.t);
        set_bits(found.doubtful)
            .any(|lane| settle(frame, block, lane, t[lane]).is_some_and(|t| t > frame.t_min && t <= frame.t_max))
    }
}

#[inline(always)]
fn set_bits(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        (bits != 0).then(|| {
            let lane = bits.trailing_zeros() as usize;
            bits &= bits - 1;
            lane % BLOCK
        })
    })
}
