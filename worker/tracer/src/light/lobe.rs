//! Lamps that send more light one way than another.

use glam::{DMat3, DVec3, Vec3};
use gonio_scene::capture::Lobe;

/// The factor max(0, cos)^exponent on a lamp's intensity.
#[derive(Debug, Clone, Copy)]
pub struct LampLobe {
    /// Unit length, world.
    axis: Vec3,
    exponent: f32,
}

impl LampLobe {
    /// `None` where the factor is 1 to all sides. `to_world` turns the light's frame.
    #[must_use]
    pub fn new(lobe: &Lobe, to_world: DMat3) -> Option<Self> {
        let axis = (to_world * DVec3::from(lobe.axis)).normalize().as_vec3();
        (lobe.exponent > 0.0).then_some(Self { axis, exponent: lobe.exponent as f32 })
    }

    /// The factor for light that leaves along `way`, a unit vector.
    #[must_use]
    pub fn factor(&self, way: Vec3) -> f32 {
        libm::powf(self.axis.dot(way).clamp(0.0, 1.0), self.exponent)
    }
}
