//! Rays, hits, and what a traversal derives from a ray once.

use glam::{Vec3, Vec4};

/// A ray segment: the points `origin + t * direction` with `t_min < t <= t_max`.
///
/// `direction` need not be normalised: `t` counts in its lengths, which should lie within 1e-12 and 1e12. A negative
/// `t_min` counts as 0. A ray of zero or non-finite direction, or of non-finite origin, hits nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where `t` is 0, in the units of the mesh.
    pub origin: Vec3,
    /// The way the ray runs; one unit of `t` is its length.
    pub direction: Vec3,
    /// Hits at or before this parameter do not count.
    pub t_min: f32,
    /// Hits beyond this parameter do not count; may be infinite.
    pub t_max: f32,
}

impl Ray {
    /// A ray that hits nothing.
    pub const NONE: Self = Self { origin: Vec3::ZERO, direction: Vec3::ZERO, t_min: 0.0, t_max: 0.0 };
}

/// Where a ray meets a triangle `[a, b, c]`: at `origin + t * direction`, which is `(1 - u - v) a + u b + v c`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The ray parameter.
    pub t: f32,
    /// The barycentric weight of the second vertex, in 0..=1.
    pub u: f32,
    /// The barycentric weight of the third vertex, in 0..=1.
    pub v: f32,
    /// The triangle's index in the slice that the hierarchy was built from.
    pub triangle: u32,
}

/// Direction components smaller than this are lifted to it before they are inverted, so that no product of a slab test
/// is 0 * infinity.
pub(super) const SMALLEST_SLOPE: f32 = 1e-20;

/// A ray as the box and triangle tests want it.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    pub origin: Vec4,
    /// The reciprocal direction, finite by [`SMALLEST_SLOPE`].
    pub inverse: Vec4,
    /// Bit `i` is set where the ray runs towards smaller coordinates on axis `i`: it enters a box by the upper plane.
    pub backward: u32,
    /// The axes in the order x', y', z' of the sheared space: z' is the direction's longest component.
    pub axes: [usize; 3],
    /// x' and y' of the direction over its z'.
    pub shear: [f32; 2],
    /// The origin again, to be indexed by an axis.
    pub origin_on: [f32; 4],
    /// The reciprocal direction again, to be indexed by an axis.
    pub inverse_on: [f32; 4],
    pub t_min: f32,
    pub t_max: f32,
}

impl Frame {
    /// `None` for a ray without a direction or with a number that is not finite: it would enter unused slots.
    #[inline(always)]
    pub fn new(ray: &Ray) -> Option<Self> {
        let origin = ray.origin.extend(0.0);
        let direction = ray.direction.extend(1.0);
        let size = direction.abs();
        // NaN times anything, and infinity times 0, are NaN.
        let finite = ((origin + direction) * 0.0).cmpeq(Vec4::ZERO).all();
        if !finite || size.x.max(size.y).max(size.z) < SMALLEST_SLOPE {
            return None;
        }
        let inverse = Vec4::ONE / size.max(Vec4::splat(SMALLEST_SLOPE)).copysign(direction);
        // Without a branch, which rays in random directions would mispredict.
        let y_over_x = usize::from(size.y > size.x);
        let z_over_both = usize::from(size.z > size.x.max(size.y));
        let z = (y_over_x & (z_over_both ^ 1)) | (z_over_both << 1);
        let (x, y) = (0b00_10_01 >> (2 * z) & 3, 0b01_00_10 >> (2 * z) & 3);
        let (direction_on, inverse_on) = (direction.to_array(), inverse.to_array());
        Some(Self {
            origin,
            inverse,
            backward: direction.is_negative_bitmask(),
            axes: [x, y, z],
            shear: [direction_on[x] * inverse_on[z], direction_on[y] * inverse_on[z]],
            origin_on: origin.to_array(),
            inverse_on,
            // The order of the operands also turns -0 into +0, whose bits sort as an integer.
            t_min: if ray.t_min > 0.0 { ray.t_min } else { 0.0 },
            t_max: ray.t_max,
        })
    }
}
