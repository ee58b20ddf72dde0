//! Rigid motions and the pinhole with Brown-Conrady distortion.

use gonio_scene::capture::Camera;
use nalgebra::{Matrix2, Matrix2x3, Matrix3, Rotation3, SMatrix, Vector3};

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

/// Derivatives of a pixel with respect to fx fy cx cy k1 k2 p1 p2 k3, and to the six numbers of [`Pose::moved`].
pub(crate) type Slopes = SMatrix<f64, 2, 15>;

/// Where a point of the board's plane (metres) falls, and the derivatives; absent behind the camera.
pub(crate) fn slopes(camera: &Camera, pose: &Pose, board: [f64; 2]) -> Option<([f64; 2], Slopes)> {
    let turned = pose.rotation * Vector3::new(board[0], board[1], 0.0);
    let point = turned + pose.translation;
    let pixel = project(camera, &point)?;
    let (x, y) = (point.x / point.z, point.y / point.z);
    let [k1, k2, p1, p2, k3] = camera.distortion;
    let r2 = x * x + y * y;
    let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
    // Of the radial factor by r^2.
    let growth = k1 + r2 * (2.0 * k2 + 3.0 * r2 * k3);
    let across = 2.0 * (x * y * growth + p1 * x + p2 * y);
    let bent = Matrix2::new(
        radial + 2.0 * x * x * growth + 2.0 * p1 * y + 6.0 * p2 * x,
        across,
        across,
        radial + 2.0 * y * y * growth + 6.0 * p1 * y + 2.0 * p2 * x,
    );
    let seen = Matrix2x3::new(1.0, 0.0, -x, 0.0, 1.0, -y) / point.z;
    let focal = Matrix2::new(camera.fx, 0.0, 0.0, camera.fy);
    let moved = focal * bent * seen;
    let (u, v) = ((pixel[0] - camera.cx) / camera.fx, (pixel[1] - camera.cy) / camera.fy);
    let terms = [
        [x * r2, y * r2],
        [x * r2 * r2, y * r2 * r2],
        [2.0 * x * y, r2 + 2.0 * y * y],
        [r2 + 2.0 * x * x, 2.0 * x * y],
        [x * r2 * r2 * r2, y * r2 * r2 * r2],
    ];
    let mut slopes = Slopes::zeros();
    (slopes[(0, 0)], slopes[(1, 1)], slopes[(0, 2)], slopes[(1, 3)]) = (u, v, 1.0, 1.0);
    for (k, [along_x, along_y]) in terms.into_iter().enumerate() {
        (slopes[(0, 4 + k)], slopes[(1, 4 + k)]) = (camera.fx * along_x, camera.fy * along_y);
    }
    // A small turn w moves the turned point by w x q.
    slopes.fixed_view_mut::<2, 3>(0, 9).copy_from(&(-moved * turned.cross_matrix()));
    slopes.fixed_view_mut::<2, 3>(0, 12).copy_from(&moved);
    Some((pixel, slopes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_those_of_differences() {
        let distortion = [-0.2, 0.1, 0.003, -0.002, 0.05];
        let camera = Camera { fx: 800.0, fy: 790.0, cx: 320.0, cy: 240.0, distortion, ..Camera::default() };
        let rotation = Rotation3::new(Vector3::new(0.3, -0.2, 0.9)).into_inner();
        let pose = Pose { rotation, translation: Vector3::new(0.05, -0.02, 0.5) };
        let board = [0.11, 0.07];
        let (_, slopes) = slopes(&camera, &pose, board).unwrap();
        let at = |k: usize, step: f64| {
            let mut camera = camera.clone();
            let mut own = [0.0; 6];
            match k {
                0 => camera.fx += step,
                1 => camera.fy += step,
                2 => camera.cx += step,
                3 => camera.cy += step,
                4..9 => camera.distortion[k - 4] += step,
                _ => own[k - 9] = step,
            }
            project(&camera, &pose.moved(&own).apply(&Vector3::new(board[0], board[1], 0.0))).unwrap()
        };
        for k in 0..15 {
            let (up, down) = (at(k, 1e-6), at(k, -1e-6));
            for axis in 0..2 {
                let difference = (up[axis] - down[axis]) / 2e-6;
                let own = slopes[(axis, k)];
                assert!((difference - own).abs() < 1e-5 * own.abs().max(1.0), "{k} {axis}: {difference} {own}");
            }
        }
    }
}
