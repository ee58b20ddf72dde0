//! The shading frame at a surface.

use glam::Vec3;

/// Right-handed orthonormal axes, z along the shading normal.
#[derive(Debug, Clone, Copy)]
pub struct Basis {
    /// Some tangent.
    pub x: Vec3,
    /// The other tangent.
    pub y: Vec3,
    /// The shading normal.
    pub z: Vec3,
}

impl Basis {
    /// The frame of a unit normal.
    #[inline]
    pub fn new(z: Vec3) -> Self {
        let (x, y) = z.any_orthonormal_pair();
        Self { x, y, z }
    }

    /// A world direction in the frame.
    #[inline]
    pub fn local(&self, v: Vec3) -> Vec3 {
        Vec3::new(self.x.dot(v), self.y.dot(v), self.z.dot(v))
    }

    /// A direction of the frame in the world.
    #[inline]
    pub fn world(&self, v: Vec3) -> Vec3 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}
