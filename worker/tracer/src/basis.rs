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
    /// The frame of a unit normal, without a branch (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
    #[inline(always)]
    pub fn new(z: Vec3) -> Self {
        let sign = 1f32.copysign(z.z);
        let a = -1.0 / (sign + z.z);
        let b = z.x * z.y * a;
        let x = Vec3::new(1.0 + sign * z.x * z.x * a, sign * b, -sign * z.x);
        Self { x, y: Vec3::new(b, sign + z.y * z.y * a, -z.y), z }
    }

    /// The frame turned the shortest way so that its normal is `z`; where that is opposite, some frame of it.
    pub fn turned(&self, z: Vec3) -> Self {
        let (sum, cos) = (self.z + z, self.z.dot(z));
        if cos < -0.999 {
            return Self::new(z);
        }
        let turn = |v: Vec3| v - sum * (v.dot(z) / (1.0 + cos));
        Self { x: turn(self.x), y: turn(self.y), z }
    }

    /// A world direction in the frame.
    #[inline(always)]
    pub fn local(&self, v: Vec3) -> Vec3 {
        Vec3::new(self.x.dot(v), self.y.dot(v), self.z.dot(v))
    }

    /// A direction of the frame in the world.
    #[inline(always)]
    pub fn world(&self, v: Vec3) -> Vec3 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}
