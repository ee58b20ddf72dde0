//! How rays are traced where renderers differ by convention.

use super::visit::{Range, Section, Visitor};
use crate::Result;

/// Conventions of a ray tracer that a picture can tell apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Tracing {
    /// Rays leave a surface this far off it, along the face's normal and in metres per metre of 1 + the largest coordinate of
    /// the point: a shadow's edge moves by as much. Never more than a hundredth of the object's diagonal, and never
    /// less than rounding asks for.
    pub ray_offset: f64,
}

impl Tracing {
    /// The offset of Mitsuba 3 in single precision: 1500 times half a unit in the last place of 1 (`RayEpsilon`). A tenth of a
    /// millimetre is within what meshes and poses of real parts are known to, but tells two renderers apart.
    pub const DEFAULT_RAY_OFFSET: f64 = 1500.0 * 0.5 * f32::EPSILON as f64;
}

impl Default for Tracing {
    fn default() -> Self {
        Self { ray_offset: Self::DEFAULT_RAY_OFFSET }
    }
}

impl Section for Tracing {
    fn describe(&mut self, v: &mut dyn Visitor) -> Result<()> {
        v.number("ray_offset", &mut self.ray_offset, Range { min: 0.0, max: 0.01 }, Some(Self::DEFAULT_RAY_OFFSET))
    }

    fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}
