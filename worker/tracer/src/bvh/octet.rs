//! Eight rays side by side, against one triangle at a time: quicker than one ray against eight where most of the rays
//! reach a leaf and the leaf has few triangles. The same arithmetic, so the same bits.

use super::bounds::BOX_SLACK;
use super::bundle::{Bundle, Hits};
use super::lanes::Lanes;
use super::node::{Leaf, Node, WIDTH};
use super::ray::{Frame, SMALLEST_SLOPE};
use super::triangle::{self, Candidates, Nearest, Pairs};

/// Eight rays as the tests want them: what a [`Frame`] is for one. A lane without a ray has a limit that no hit reaches.
pub(super) struct Octet<'a> {
    /// By axis of the world.
    pub origin: [[f32; WIDTH]; 3],
    /// The reciprocal direction.
    pub inverse: [[f32; WIDTH]; 3],
    /// Both again by axis of each ray's sheared space.
    origin_of: [[f32; WIDTH]; 3],
    inverse_of: [[f32; WIDTH]; 3],
    pub shear: [[f32; WIDTH]; 2],
    /// Which axis of the world is z' there.
    depth: [f32; WIDTH],
    pub t_min: [f32; WIDTH],
    /// Where the nearest hit so far is, or the ray ends.
    pub t_max: [f32; WIDTH],
    /// That hit as [`Nearest`] has it; the triangle as the bits of a number.
    nearest: [f32; WIDTH],
    weights: [[f32; WIDTH]; 2],
    sum: [f32; WIDTH],
    /// The rays, and the lane of the first.
    bundle: &'a Bundle,
    base: usize,
    /// By axis of the world, the rays that run backward along it, as bits.
    pub backward: [u32; 3],
    /// The rays whose z' is x, y, z, as bits.
    pub along: [u32; 3],
    /// The rays for which [`Frame::new`] gives a frame, as bits.
    pub valid: u32,
}

/// The bits of all rays of an octet.
pub(super) const EIGHT: u32 = (1 << WIDTH) - 1;

/// Eight rays and one triangle of a leaf. `MIXED` says that the orders of the rays' axes may differ.
struct Beside<'a, const MIXED: bool> {
    rays: &'a Octet<'a>,
    /// Those of the first ray.
    axes: [usize; 3],
    leaf: Leaf<'a>,
    triangle: usize,
}

impl<const MIXED: bool> Beside<'_, MIXED> {
    /// A coordinate of a vertex by an axis of each ray's space.
    #[inline(always)]
    fn coordinate<L: Lanes>(&self, lanes: L, vertex: usize, axis: usize) -> L::F {
        let (leaf, triangle) = (self.leaf, self.triangle);
        if !MIXED {
            return lanes.splat(leaf.coordinate(triangle, vertex, self.axes[axis]));
        }
        // x', y', z' follow each other as x, y, z do.
        let (x, y, z) = ((axis + 1) % 3, (axis + 2) % 3, axis % 3);
        let depth = lanes.load(&self.rays.depth);
        let x = lanes.splat(leaf.coordinate(triangle, vertex, x));
        let y = lanes.splat(leaf.coordinate(triangle, vertex, y));
        let z = lanes.splat(leaf.coordinate(triangle, vertex, z));
        let y_or_z = lanes.select(lanes.lt(depth, lanes.splat(1.5)), y, z);
        lanes.select(lanes.lt(depth, lanes.splat(0.5)), x, y_or_z)
    }
}

impl<L: Lanes, const MIXED: bool> Pairs<L> for Beside<'_, MIXED> {
    #[inline(always)]
    fn relative(&self, lanes: L, axis: usize) -> [L::F; 3] {
        let origin = lanes.load(&self.rays.origin_of[axis]);
        let a = self.coordinate(lanes, 0, axis);
        let b = self.coordinate(lanes, 1, axis);
        let c = self.coordinate(lanes, 2, axis);
        [lanes.sub(a, origin), lanes.sub(b, origin), lanes.sub(c, origin)]
    }
    #[inline(always)]
    fn shear(&self, lanes: L, axis: usize) -> L::F {
        lanes.load(&self.rays.shear[axis])
    }
    #[inline(always)]
    fn inverse(&self, lanes: L, axis: usize) -> L::F {
        lanes.load(&self.rays.inverse_of[axis])
    }
    #[inline(always)]
    fn t_min(&self, lanes: L) -> L::F {
        lanes.load(&self.rays.t_min)
    }
    #[inline(always)]
    fn t_max(&self, lanes: L) -> L::F {
        lanes.load(&self.rays.t_max)
    }
    #[inline(always)]
    fn used(&self, lanes: L) -> L::M {
        lanes.first(WIDTH)
    }
}

/// Eight lanes of sixteen.
#[inline(always)]
fn eight<const BASE: usize, L: Lanes>(lanes: L, from: &[f32; 2 * WIDTH]) -> L::F {
    let [a, b] = *bytemuck::cast_ref::<[f32; 2 * WIDTH], [[f32; WIDTH]; 2]>(from);
    if BASE == 0 { lanes.load(&a) } else { lanes.load(&b) }
}

/// The absolute value, as a length that is only compared and inverted.
#[inline(always)]
fn size<L: Lanes>(lanes: L, x: L::F) -> L::F {
    lanes.copysign(x, lanes.splat(0.0))
}

/// The reciprocal of a component, lifted to [`SMALLEST_SLOPE`].
#[inline(always)]
fn inverted<L: Lanes>(lanes: L, size: L::F, x: L::F) -> L::F {
    let smallest = lanes.splat(SMALLEST_SLOPE);
    let lifted = lanes.select(lanes.lt(smallest, size), size, smallest);
    lanes.div(lanes.splat(1.0), lanes.copysign(lifted, x))
}

/// One of three by the axis that is z'.
#[inline(always)]
fn pick<L: Lanes>(lanes: L, z_is_z: L::M, z_is_y: L::M, x: L::F, y: L::F, z: L::F) -> L::F {
    lanes.select(z_is_z, z, lanes.select(z_is_y, y, x))
}

impl<'a> Octet<'a> {
    /// The eight rays of a bundle from lane `BASE` on. All its lanes must be filled: see [`Bundle::filled`].
    ///
    /// The steps of [`Frame::new`], by vector operations: loops over the lanes become masked stores, which take as long
    /// as a walk.
    #[inline(always)]
    pub fn new<const BASE: usize, L: Lanes>(lanes: L, bundle: &'a Bundle) -> Self {
        let zero = lanes.splat(0.0);
        let (o, d) = (&bundle.origin, &bundle.direction);
        let (ox, oy, oz) =
            (eight::<BASE, L>(lanes, &o.x), eight::<BASE, L>(lanes, &o.y), eight::<BASE, L>(lanes, &o.z));
        let (dx, dy, dz) =
            (eight::<BASE, L>(lanes, &d.x), eight::<BASE, L>(lanes, &d.y), eight::<BASE, L>(lanes, &d.z));
        let (sx, sy, sz) = (size(lanes, dx), size(lanes, dy), size(lanes, dz));
        let x_or_y = lanes.max(sx, sy);
        let (y_over_x, z_over_both) = (lanes.lt(sx, sy), lanes.lt(x_or_y, sz));
        let (by_y, by_z) = (lanes.bits(y_over_x), lanes.bits(z_over_both));
        // NaN times anything, and infinity times 0, are NaN.
        let nothing = |o: L::F, d: L::F| lanes.mul(lanes.add(o, d), zero);
        let (nx, ny, nz) = (nothing(ox, dx), nothing(oy, dy), nothing(oz, dz));
        let finite = lanes.bits(lanes.and(lanes.and(lanes.le(nx, zero), lanes.le(ny, zero)), lanes.le(nz, zero)));
        let largest = lanes.max(x_or_y, sz);
        let valid = finite & lanes.bits(lanes.le(lanes.splat(SMALLEST_SLOPE), largest));
        let (ix, iy, iz) = (inverted(lanes, sx, dx), inverted(lanes, sy, dy), inverted(lanes, sz, dz));
        let depth_inverse = pick(lanes, z_over_both, y_over_x, ix, iy, iz);
        let shear_x = lanes.mul(pick(lanes, z_over_both, y_over_x, dy, dz, dx), depth_inverse);
        let shear_y = lanes.mul(pick(lanes, z_over_both, y_over_x, dz, dx, dy), depth_inverse);
        let t_min = eight::<BASE, L>(lanes, &bundle.t_min);
        Self {
            origin: [lanes.store(ox), lanes.store(oy), lanes.store(oz)],
            inverse: [lanes.store(ix), lanes.store(iy), lanes.store(iz)],
            origin_of: [
                lanes.store(pick(lanes, z_over_both, y_over_x, oy, oz, ox)),
                lanes.store(pick(lanes, z_over_both, y_over_x, oz, ox, oy)),
                lanes.store(pick(lanes, z_over_both, y_over_x, ox, oy, oz)),
            ],
            inverse_of: [
                lanes.store(pick(lanes, z_over_both, y_over_x, iy, iz, ix)),
                lanes.store(pick(lanes, z_over_both, y_over_x, iz, ix, iy)),
                lanes.store(depth_inverse),
            ],
            shear: [lanes.store(shear_x), lanes.store(shear_y)],
            depth: lanes.store(pick(lanes, z_over_both, y_over_x, zero, lanes.splat(1.0), lanes.splat(2.0))),
            t_min: lanes.store(lanes.select(lanes.lt(zero, t_min), t_min, zero)),
            t_max: lanes.store(eight::<BASE, L>(lanes, &bundle.t_max)),
            nearest: [f32::from_bits(Nearest::NONE); WIDTH],
            weights: [[0.0; WIDTH]; 2],
            sum: [1.0; WIDTH],
            bundle,
            base: BASE,
            backward: [lanes.signs(dx), lanes.signs(dy), lanes.signs(dz)],
            along: [EIGHT & !(by_y | by_z), by_y & !by_z, by_z],
            valid,
        }
    }

    /// The rays, as bits, that enter one child box before their ends; they may run anywhere.
    #[inline(always)]
    pub fn enter<L: Lanes>(&self, lanes: L, node: &Node, child: usize) -> u32 {
        let mut near = lanes.load(&self.t_min);
        let mut far = lanes.splat(f32::INFINITY);
        for axis in 0..3 {
            let (origin, inverse) = (lanes.load(&self.origin[axis]), lanes.load(&self.inverse[axis]));
            let low = lanes.mul(lanes.sub(lanes.splat(node.planes[axis * 2][child]), origin), inverse);
            let high = lanes.mul(lanes.sub(lanes.splat(node.planes[axis * 2 + 1][child]), origin), inverse);
            near = lanes.max(lanes.min(low, high), near);
            far = lanes.min(lanes.max(low, high), far);
        }
        let slack = lanes.splat(BOX_SLACK);
        let far = lanes.min(lanes.mul(far, slack), lanes.mul(lanes.load(&self.t_max), slack));
        lanes.bits(lanes.le(near, far))
    }

    /// The nearest hit so far of one ray.
    #[inline(always)]
    pub fn nearest(&self, lane: usize) -> Nearest {
        let weights = [self.weights[0][lane], self.weights[1][lane]];
        Nearest { t: self.t_max[lane], triangle: self.nearest[lane].to_bits(), weights, sum: self.sum[lane] }
    }

    /// Sets the nearest hit so far of one ray.
    #[inline(always)]
    pub fn set_nearest(&mut self, lane: usize, nearest: Nearest) {
        let Nearest { t, triangle, weights: [v, w], sum } = nearest;
        (self.t_max[lane], self.nearest[lane], self.sum[lane]) = (t, f32::from_bits(triangle), sum);
        (self.weights[0][lane], self.weights[1][lane]) = (v, w);
    }

    /// Writes the nearest hits to the lanes that the rays have in their bundle.
    #[inline(always)]
    pub fn write<L: Lanes>(&self, lanes: L, hits: &mut Hits) {
        let sum = lanes.load(&self.sum);
        let (u, v) = (lanes.div(lanes.load(&self.weights[0]), sum), lanes.div(lanes.load(&self.weights[1]), sum));
        let range = self.base..self.base + WIDTH;
        hits.t[range.clone()].copy_from_slice(&self.t_max);
        hits.u[range.clone()].copy_from_slice(&lanes.store(u));
        hits.v[range.clone()].copy_from_slice(&lanes.store(v));
        hits.triangle[range].copy_from_slice(bytemuck::cast_slice(&self.nearest));
    }

    /// One ray as the tests of single rays want it.
    #[inline(always)]
    pub fn frame(&self, lane: usize) -> Option<Frame> {
        Frame::new(&self.bundle.ray(self.base + lane))
    }

    #[inline(always)]
    fn candidates<L: Lanes, const MIXED: bool>(
        &self,
        lanes: L,
        axes: [usize; 3],
        leaf: Leaf,
        triangle: usize,
    ) -> Option<Candidates<L>> {
        triangle::candidates(lanes, &Beside::<MIXED> { rays: self, axes, leaf, triangle })
    }

    /// Takes the nearest hits with a leaf of those rays whose bits are set in `active`; returns the bits of those that
    /// have hit anything. Unless `MIXED`, `axes` is the order of all rays' axes.
    #[inline(always)]
    pub fn closest<L: Lanes, const MIXED: bool>(&mut self, lanes: L, axes: [usize; 3], leaf: Leaf, active: u32) -> u32 {
        let mut any = 0;
        for triangle in 0..leaf.count {
            let Some(found) = self.candidates::<L, MIXED>(lanes, axes, leaf, triangle) else { continue };
            // A hit of a ray that is not active is one all the same.
            let (settled, mut doubtful) = (found.settled, found.doubtful & active);
            if settled | doubtful == 0 {
                continue;
            }
            any |= settled | doubtful;
            let index = leaf.triangle(triangle);
            let before = lanes.load(&self.t_max);
            let closer = lanes.and(found.hit, lanes.lt(found.t, before));
            let ties = settled & !lanes.bits(closer) & lanes.bits(lanes.le(found.t, before));
            let (t, v, w, sum) =
                (lanes.store(found.t), lanes.store(found.v), lanes.store(found.w), lanes.store(found.sum));
            // As `Nearest::take`, without a branch.
            self.t_max = lanes.store(lanes.select(closer, found.t, before));
            self.nearest =
                lanes.store(lanes.select(closer, lanes.splat(f32::from_bits(index)), lanes.load(&self.nearest)));
            self.weights[0] = lanes.store(lanes.select(closer, found.v, lanes.load(&self.weights[0])));
            self.weights[1] = lanes.store(lanes.select(closer, found.w, lanes.load(&self.weights[1])));
            self.sum = lanes.store(lanes.select(closer, found.sum, lanes.load(&self.sum)));
            let mut rest = ties;
            while rest != 0 {
                let lane = rest.trailing_zeros() as usize % WIDTH;
                rest &= rest - 1;
                let mut nearest = self.nearest(lane);
                nearest.take(t[lane], index, [v[lane], w[lane]], sum[lane]);
                self.set_nearest(lane, nearest);
            }
            while doubtful != 0 {
                let lane = doubtful.trailing_zeros() as usize % WIDTH;
                doubtful &= doubtful - 1;
                if let Some(t) = self.settle(lane, leaf, triangle, t[lane]) {
                    let mut nearest = self.nearest(lane);
                    nearest.take(t, index, [v[lane], w[lane]], sum[lane]);
                    self.set_nearest(lane, nearest);
                }
            }
        }
        any
    }

    /// Which of the rays whose bits are set in `active` hit any triangle of a leaf.
    #[inline(always)]
    pub fn occluded<L: Lanes>(&self, lanes: L, axes: [usize; 3], leaf: Leaf, active: u32) -> u32 {
        let mut hit = 0;
        for triangle in 0..leaf.count {
            let Some(found) = self.candidates::<L, false>(lanes, axes, leaf, triangle) else { continue };
            hit |= found.settled;
            let mut doubtful = found.doubtful & active & !hit;
            if doubtful != 0 {
                let t = lanes.store(found.t);
                while doubtful != 0 {
                    let lane = doubtful.trailing_zeros() as usize % WIDTH;
                    doubtful &= doubtful - 1;
                    let t = self.settle(lane, leaf, triangle, t[lane]);
                    hit |= u32::from(t.is_some_and(|t| t <= self.t_max[lane])) << lane;
                }
            }
            if hit & active == active {
                break;
            }
        }
        hit & active
    }

    /// As [`triangle::settle`], for the ray of a lane.
    #[cold]
    #[inline(never)]
    fn settle(&self, lane: usize, leaf: Leaf, triangle: usize, t: f32) -> Option<f32> {
        triangle::settle(&self.frame(lane)?, leaf, triangle, t)
    }
}
