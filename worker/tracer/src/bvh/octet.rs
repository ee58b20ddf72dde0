//! Eight rays side by side, against one triangle at a time: quicker than one ray against eight where most of the rays
//! reach a leaf and the leaf has few triangles. The same arithmetic, so the same bits.

use super::bounds::BOX_SLACK;
use super::lanes::Lanes;
use super::node::{Leaf, Node, WIDTH};
use super::ray::{Frame, Ray, SMALLEST_SLOPE};
use super::triangle::{self, Candidates, Nearest, Pairs};

/// Eight rays as the tests want them: what a [`Frame`] is for one. A lane without a ray has a limit that no hit reaches.
pub(super) struct Octet {
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
    /// [`Octet::depth`] in bits 0 and 1, [`Frame::backward`] in bits 2 to 4, [`VALID`] where [`Frame::new`] gives one.
    pub class: [u32; WIDTH],
}

/// See [`Octet::class`].
pub(super) const VALID: u32 = 1 << 5;

/// Eight rays and one triangle of a leaf. `MIXED` says that the orders of the rays' axes may differ.
struct Beside<'a, const MIXED: bool> {
    rays: &'a Octet,
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

/// One of three by an axis.
#[inline(always)]
fn pick(axis: u32, x: f32, y: f32, z: f32) -> f32 {
    let y_or_z = if axis == 1 { y } else { z };
    if axis == 0 { x } else { y_or_z }
}

impl Octet {
    /// The first eight of some rays; `spare` stands in unused lanes.
    #[inline(always)]
    pub fn new(rays: &[Ray], spare: &Ray) -> Self {
        const NONE: [f32; WIDTH] = [0.0; WIDTH];
        let (mut origin, mut direction) = ([NONE; 3], [NONE; 3]);
        let (mut t_min, mut t_max) = (NONE, [f32::NEG_INFINITY; WIDTH]);
        for lane in 0..WIDTH {
            let ray = rays.get(lane).unwrap_or(spare);
            (origin[0][lane], origin[1][lane], origin[2][lane]) = ray.origin.into();
            (direction[0][lane], direction[1][lane], direction[2][lane]) = ray.direction.into();
            t_min[lane] = ray.t_min;
        }
        for (t_max, ray) in t_max.iter_mut().zip(rays) {
            *t_max = ray.t_max;
        }
        let (mut inverse, mut origin_of, mut inverse_of) = ([NONE; 3], [NONE; 3], [NONE; 3]);
        let (mut shear, mut depth, mut class) = ([NONE; 2], NONE, [0; WIDTH]);
        // The steps of `Frame::new`, lane by lane.
        for lane in 0..WIDTH {
            let o = [origin[0][lane], origin[1][lane], origin[2][lane]];
            let d = [direction[0][lane], direction[1][lane], direction[2][lane]];
            let size = [d[0].abs(), d[1].abs(), d[2].abs()];
            let x_or_y = if size[0] > size[1] { size[0] } else { size[1] };
            let largest = if size[2] > x_or_y { size[2] } else { x_or_y };
            let finite = ((o[0] + d[0]) * 0.0 == 0.0) & ((o[1] + d[1]) * 0.0 == 0.0) & ((o[2] + d[2]) * 0.0 == 0.0);
            let valid = finite & (largest >= SMALLEST_SLOPE);
            let y_over_x = u32::from(size[1] > size[0]);
            let z_over_both = u32::from(size[2] > x_or_y);
            let z = (y_over_x & (z_over_both ^ 1)) | (z_over_both << 1);
            let mut i = [0.0; 3];
            for axis in 0..3 {
                let lifted = if size[axis] > SMALLEST_SLOPE { size[axis] } else { SMALLEST_SLOPE };
                i[axis] = 1.0 / lifted.copysign(d[axis]);
                inverse[axis][lane] = i[axis];
            }
            origin_of[0][lane] = pick(z, o[1], o[2], o[0]);
            origin_of[1][lane] = pick(z, o[2], o[0], o[1]);
            origin_of[2][lane] = pick(z, o[0], o[1], o[2]);
            inverse_of[0][lane] = pick(z, i[1], i[2], i[0]);
            inverse_of[1][lane] = pick(z, i[2], i[0], i[1]);
            inverse_of[2][lane] = pick(z, i[0], i[1], i[2]);
            shear[0][lane] = pick(z, d[1], d[2], d[0]) * inverse_of[2][lane];
            shear[1][lane] = pick(z, d[2], d[0], d[1]) * inverse_of[2][lane];
            depth[lane] = z as f32;
            t_min[lane] = if t_min[lane] > 0.0 { t_min[lane] } else { 0.0 };
            let sign = |axis: usize| d[axis].to_bits() >> 31 << (2 + axis);
            class[lane] = z | sign(0) | sign(1) | sign(2) | if valid { VALID } else { 0 };
        }
        Self { origin, inverse, origin_of, inverse_of, shear, depth, t_min, t_max, class }
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

    /// Lets a ray end at a hit.
    #[inline(always)]
    pub fn end(&mut self, lane: usize, t: f32) {
        self.t_max[lane] = t;
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
    /// have found a nearer one. Unless `MIXED`, `axes` is the order of all rays' axes. `rays` and `nearest` are those of the lanes.
    #[inline(always)]
    pub fn closest<L: Lanes, const MIXED: bool>(
        &mut self,
        lanes: L,
        axes: [usize; 3],
        leaf: Leaf,
        active: u32,
        rays: &[Ray],
        nearest: &mut [Nearest],
    ) -> u32 {
        let mut closer = 0;
        for triangle in 0..leaf.count {
            let Some(found) = self.candidates::<L, MIXED>(lanes, axes, leaf, triangle) else { continue };
            let mut hits = (found.settled | found.doubtful) & active;
            if hits == 0 {
                continue;
            }
            let (t, v, w, sum) =
                (lanes.store(found.t), lanes.store(found.v), lanes.store(found.w), lanes.store(found.sum));
            while hits != 0 {
                let lane = hits.trailing_zeros() as usize % WIDTH;
                hits &= hits - 1;
                let settled = found.settled >> lane & 1 != 0;
                let t = if settled { Some(t[lane]) } else { settle(rays, lane, leaf, triangle, t[lane]) };
                if let Some(t) = t {
                    let before = nearest[lane].t;
                    nearest[lane].take(t, leaf.triangle(triangle), [v[lane], w[lane]], sum[lane]);
                    if nearest[lane].t < before {
                        self.t_max[lane] = nearest[lane].t;
                        closer |= 1 << lane;
                    }
                }
            }
        }
        closer
    }

    /// Which of the rays whose bits are set in `active` hit any triangle of a leaf.
    #[inline(always)]
    pub fn occluded<L: Lanes>(&self, lanes: L, axes: [usize; 3], leaf: Leaf, active: u32, rays: &[Ray]) -> u32 {
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
                    let t = settle(rays, lane, leaf, triangle, t[lane]);
                    hit |= u32::from(t.is_some_and(|t| t <= rays[lane].t_max)) << lane;
                }
            }
            if hit & active == active {
                break;
            }
        }
        hit & active
    }
}

/// As [`triangle::settle`], for the ray of a lane.
#[cold]
#[inline(never)]
fn settle(rays: &[Ray], lane: usize, leaf: Leaf, triangle: usize, t: f32) -> Option<f32> {
    triangle::settle(&Frame::new(rays.get(lane)?)?, leaf, triangle, t)
}
