//! Objects: meshes placed in the world.

use super::visit::{Numbers, Range, Section, Visitor, XYZ, vector_or};
use crate::Result;
use std::collections::BTreeMap;

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
    /// Materials of parts of the mesh, by the names that the mesh's file gives to its own materials; the other parts have
    /// `material`.
    pub materials: BTreeMap<String, String>,
    /// Maps mesh coordinates to world coordinates; affine, row-major.
    pub object_to_world: [[f64; 4]; 4],
    /// Size along the mesh's own axes, relative to the file's.
    pub scale: [f64; 3],
    /// Correction of the pose: a shift, metres in world coordinates.
    pub translation: [f64; 3],
    /// Correction of the pose: a turn about the object's origin, as a rotation vector in world coordinates, radians.
    pub rotation: [f64; 3],
    /// Share of the exposure during which it was there, 0..=1.
    pub presence: f64,
}

impl Default for Object {
    fn default() -> Self {
        Self {
            name: String::new(),
            mesh: String::new(),
            material: String::new(),
            materials: BTreeMap::new(),
            object_to_world: IDENTITY,
            scale: [1.0; 3],
            translation: [0.0; 3],
            rotation: [0.0; 3],
            presence: 1.0,
        }
    }
}

impl Object {
    /// Maps mesh coordinates to world coordinates, correction included: p = o + translation + R (object_to_world(s q) - o),
    /// with s the scale and o the object's origin in the world.
    #[must_use]
    pub fn placement(&self) -> [[f64; 4]; 4] {
        let mut m = self.object_to_world;
        for row in &mut m {
            row.iter_mut().zip(self.scale).for_each(|(entry, scale)| *entry *= scale);
        }
        if self.rotation != [0.0; 3] {
            let was = m;
            for (row, turned) in m.iter_mut().zip(turn(self.rotation)) {
                for (j, entry) in row.iter_mut().take(3).enumerate() {
                    *entry = (0..3).map(|k| turned[k] * was[k][j]).sum();
                }
            }
        }
        for (row, shift) in m.iter_mut().zip(self.translation) {
            row[3] += shift;
        }
        m
    }
}

/// The rotation matrix of a rotation vector (Rodrigues' formula).
pub(super) fn turn([x, y, z]: [f64; 3]) -> [[f64; 3]; 3] {
    let angle2 = x * x + y * y + z * z;
    let angle = angle2.sqrt();
    // The factors of the cross product and of its square, by their series where the quotients would lose digits.
    let (once, twice) = if angle < 1e-4 {
        (1.0 - angle2 / 6.0, 0.5 - angle2 / 24.0)
    } else {
        (libm::sin(angle) / angle, (1.0 - libm::cos(angle)) / angle2)
    };
    let cross = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
    let v = [x, y, z];
    [0, 1, 2].map(|i| {
        [0, 1, 2].map(|j| {
            let unit = if i == j { 1.0 } else { 0.0 };
            unit + once * cross[i][j] + twice * (v[i] * v[j] - unit * angle2)
        })
    })
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
        let (values, range) = (&mut self.scale[..], Range { min: 1e-9, max: 1e9 });
        v.numbers("scale", Numbers { values, suffixes: &XYZ, range, default: Some(&[1.0; 3]), may_end_early: false })?;
        vector_or(v, "translation", &mut self.translation, &[0.0; 3])?;
        vector_or(v, "rotation", &mut self.rotation, &[0.0; 3])?;
        v.number("presence", &mut self.presence, Range::UNIT, Some(1.0))?;
        v.words("materials", &mut self.materials)
    }
}
