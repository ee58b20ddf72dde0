//! Rigid motions and the pinhole with Brown-Conrady distortion.

use gonio_scene::capture::Camera;
use nalgebra::{Matrix3, Rotation3, Vector3};

/// A rigid motion: p -> rotation p + translation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Orthonormal, determinant 1.
    pub rotation: Matrix3<f64>,
    /// Metres.
    pub translation: Vector3<f64>,
}

impl Pose {
    /// From a rotation row by row, which is made orthonormal if digits were lost, and a translation.
    ///
    /// Absent where the nine numbers are no rotation: farther than 1e-2 from one, or a mirror.
    #[must_use]
    pub fn new(rows: &[f64; 9], translation: [f64; 3]) -> Option<Self> {
        let given = Matrix3::from_row_slice(rows);
        let rotation = nearest_rotation(&given)?;
        ((given - rotation).amax() < 1e-2 && translation.iter().all(|x| x.is_finite()))
            .then(|| Self { rotation, translation: Vector3::from(translation) })
    }

    /// The motion back.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Self { rotation, translation: -(rotation * self.translation) }
    }

    /// First `first`, then this.
    #[must_use]
    pub fn after(&self, first: &Self) -> Self {
        let translation = self.rotation * first.translation + self.translation;
        Self { rotation: self.rotation * first.rotation, translation }
    }

    /// Turned by a small rotation vector (radians, camera axes) and shifted.
    pub(crate) fn moved(&self, step: &[f64]) -> Self {
        let turn = Rotation3::new(Vector3::new(step[0], step[1], step[2]));
        let translation = self.translation + Vector3::new(step[3], step[4], step[5]);
        Self { rotation: turn.matrix() * self.rotation, translation }
    }

    /// As a row-major 4x4 matrix.
    #[must_use]
    pub fn matrix(&self) -> [[f64; 4]; 4] {
        let (r, t) = (&self.rotation, &self.translation);
        let row = |i: usize| [r[(i, 0)], r[(i, 1)], r[(i, 2)], t[i]];
        [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
    }

    /// `point` moved.
    #[must_use]
    pub fn apply(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * point + self.translation
    }
}

/// The rotation nearest to `m` in the Frobenius norm; absent where `m` is flat or mirrors.
pub(crate) fn nearest_rotation(m: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    if !m.iter().all(|x| x.is_finite()) || m.determinant() <= 1e-9 {
        return None;
    }
    let svd = m.svd(true, true);
    Some(svd.u? * svd.v_t?)
}

/// Where a point of camera coordinates falls, pixels; absent behind the camera. Brown (1966) with k1 k2 p1 p2 k3, as
/// OpenCV writes it.
#[must_use]
pub fn project(camera: &Camera, point: &Vector3<f64>) -> Option<[f64; 2]> {
    if point.z <= 1e-12 {
        return None;
    }
    let (x, y) = (point.x / point.z, point.y / point.z);
    let [k1, k2, p1, p2, k3] = camera.distortion;
    let r2 = x * x + y * y;
    let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
    let u = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x);
    let v = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y;
    Some([camera.fx * u + camera.cx, camera.fy * v + camera.cy])
}
