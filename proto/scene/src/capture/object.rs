//! Objects: meshes placed in the world.

use super::visit::{Section, Visitor};
use crate::Result;

/// The 4x4 identity.
pub const IDENTITY: [[f64; 4]; 4] =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// A named mesh with a material and a pose.
#[derive(Debug, Clone, PartialEq)]
pub struct Object {
    /// The name that dotted parameter names use.
    pub name: String,
    /// The mesh file's path, relative to the capture.
    pub mesh: String,
    /// The material's name.
    pub material: String,
    /// Maps mesh coordinates to world coordinates; affine, row-major.
    pub object_to_world: [[f64; 4]; 4],
}

impl Default for Object {
    fn default() -> Self {
        Self { name: String::new(), mesh: String::new(), material: String::new(), object_to_world: IDENTITY }
    }
}

/// The determinant of the upper left 3x3 part.
pub(super) fn determinant(m: &[[f64; 4]; 4]) -> f64 {
    m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
        + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
}

impl Section for Object {
    fn describe(&mut self, v: &mut dyn Visitor) -> Result<()> {
        v.text("name", &mut self.name, None)?;
        v.text("mesh", &mut self.mesh, None)?;
        v.text("material", &mut self.material, None)?;
        v.matrix("object_to_world", &mut self.object_to_world)?;
        let det = determinant(&self.object_to_world);
        if !(det.is_finite() && det.abs() > 1e-30) {
            return Err(v.refuse(
                "object_to_world",
                format!("flattens the object (determinant {det:e})"),
                "write an invertible affine matrix, row-major",
            ));
        }
        Ok(())
    }
}
