//! The capture's numbers as glam's types.

use glam::{DAffine3, DMat3, DVec3, Vec3};

/// A row-major 4x4 matrix of a capture as an affine map; its last row is 0 0 0 1.
pub fn affine(m: &[[f64; 4]; 4]) -> DAffine3 {
    let column = |j: usize| DVec3::new(m[0][j], m[1][j], m[2][j]);
    DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) }
}

/// A capture's colour in single precision.
pub fn rgb(c: &[f64; 3]) -> Vec3 {
    DVec3::from(*c).as_vec3()
}
