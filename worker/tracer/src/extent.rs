//! Where an object lies: what its material's variation needs of a world position.

use glam::{DAffine3, DVec3, Mat3, Vec3};

/// An object's bounding box and axes in the world.
#[derive(Debug, Clone, Copy, Default)]
pub struct Extent {
    /// World position to position in the box, each coordinate 0 to 1.
    linear: Mat3,
    offset: Vec3,
    /// Length of the box's diagonal in the world, metres.
    pub diagonal: f32,
    /// The object's z axis in the world, a unit vector.
    pub z: Vec3,
    /// The object's x axis in the world, a unit vector.
    pub x: Vec3,
}

impl Extent {
    /// That of an object in this pose whose mesh has these vertices.
    #[must_use]
    pub fn new(pose: &DAffine3, positions: &[[f32; 3]]) -> Self {
        let points = || positions.iter().map(|p| DVec3::from(p.map(f64::from)));
        let low = points().fold(DVec3::INFINITY, DVec3::min);
        let high = points().fold(DVec3::NEG_INFINITY, DVec3::max);
        let extent = high - low;
        // Along a flat side the position is 0.
        let scale = DVec3::from(extent.to_array().map(|e| if e > 0.0 && e.is_finite() { 1.0 / e } else { 0.0 }));
        let low = if low.is_finite() { low } else { DVec3::ZERO };
        let to_box = DAffine3::from_scale(scale) * DAffine3::from_translation(-low) * pose.inverse();
        Self {
            linear: to_box.matrix3.as_mat3(),
            offset: to_box.translation.as_vec3(),
            diagonal: (pose.matrix3 * extent).length() as f32,
            z: pose.matrix3.z_axis.normalize().as_vec3(),
            x: pose.matrix3.x_axis.normalize().as_vec3(),
        }
    }

    /// Position in the box of a world position.
    #[must_use]
    pub fn position(&self, world: Vec3) -> Vec3 {
        (self.linear * world + self.offset).clamp(Vec3::ZERO, Vec3::ONE)
    }

    /// World gradient of a function whose gradient by the position in the box is given.
    #[must_use]
    pub fn gradient(&self, gradient: Vec3) -> Vec3 {
        self.linear.transpose() * gradient
    }

    /// How far the position in the box goes for a world displacement.
    #[must_use]
    pub fn along(&self, displacement: Vec3) -> Vec3 {
        self.linear * displacement
    }

    /// The direction whose cross product with the unit normal `n` is the tangent: the z axis, or where these are parallel
    /// one that makes it the x axis.
    #[must_use]
    pub fn axis(&self, n: Vec3) -> Vec3 {
        if self.z.cross(n).length_squared() > 1e-8 { self.z } else { n.cross(self.x) }
    }
}
