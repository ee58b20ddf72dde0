//! Rays, hits, and what a traversal derives from a ray once.

use glam::Vec3;

/// A ray segment: the points `origin + t * direction` with `t_min < t <= t_max`.
///
/// `direction` need not be normalised: `t` counts in its lengths. Its longest component should lie within 1e-15 and 1e15.
/// A negative `t_min` counts as 0. A ray with a zero or non-finite direction, or a non-finite origin, hits nothing.
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

/// Direction components below this share of the longest one are lifted to it before they are inverted, so that no
/// product of a slab test is 0 * infinity.
const SMALLEST_SLOPE: f32 = 1e-18;

/// A ray as the box and triangle tests want it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub origin: [f32; 3],
    /// The reciprocal direction, finite by [`SMALLEST_SLOPE`].
    pub inverse: [f32; 3],
    /// Per axis 1 where the ray runs towards smaller coordinates, so that it enters a box by its upper plane.
    pub backward: [usize; 3],
    /// The axes in the order x', y', z' of the sheared space: z' is the direction's longest component.
    pub axes: [usize; 3],
    /// x' and y' of the direction over its z'.
    pub shear: [f32; 2],
    pub t_min: f32,
    pub t_max: f32,
}

impl Frame {
    /// A direction of zero or not finite makes the shear NaN, which no edge function accepts.
    #[inline(always)]
    pub fn new(ray: &Ray) -> Self {
        let direction = ray.direction.to_array();
        let size = direction.map(f32::abs);
        let z = if size[0] > size[1] && size[0] > size[2] {
            0
        } else if size[1] > size[2] {
            1
        } else {
            2
        };
        let (x, y) = (if z == 2 { 0 } else { z + 1 }, if z == 0 { 2 } else { z - 1 });
        let least = size[z] * SMALLEST_SLOPE;
        let inverse = direction.map(|d| 1.0 / if d.abs() < least { least.copysign(d) } else { d });
        Self {
            origin: ray.origin.to_array(),
            inverse,
            backward: inverse.map(|i| (i.to_bits() >> 31) as usize),
            axes: [x, y, z],
            shear: [direction[x] * inverse[z], direction[y] * inverse[z]],
            // The order of the operands also turns -0 into +0, whose bits sort as an integer.
            t_min: if ray.t_min > 0.0 { ray.t_min } else { 0.0 },
            t_max: ray.t_max,
        }
    }
}
