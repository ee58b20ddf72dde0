//! First intrinsics and poses from homographies (Zhang 2000, "A flexible new technique for camera calibration").

use crate::geometry::{Pose, nearest_rotation};
use gonio_scene::capture::Camera;
use nalgebra::{DMatrix, Matrix3, SVector, Vector3};

/// The row v_ij of Zhang's equation 7.
fn row(h: &Matrix3<f64>, i: usize, j: usize) -> SVector<f64, 6> {
    let (a, b) = (h.column(i), h.column(j));
    SVector::from([
        a[0] * b[0],
        a[0] * b[1] + a[1] * b[0],
        a[1] * b[1],
        a[2] * b[0] + a[0] * b[2],
        a[2] * b[1] + a[1] * b[2],
        a[2] * b[2],
    ])
}

/// Intrinsics without distortion for a photo of `width` x `height` pixels, in closed form (Zhang's appendix B). Where the
/// views do not determine them (too few, or all parallel), a focal length of the longer side about the image's centre.
pub(crate) fn intrinsics(homographies: &[Matrix3<f64>], width: u32, height: u32) -> Camera {
    let (w, h) = (f64::from(width), f64::from(height));
    let base = Camera { width, height, fx: w.max(h), fy: w.max(h), cx: w / 2.0, cy: h / 2.0, ..Camera::default() };
    // Pixels moved to about -1..1, so that the six numbers are of one size.
    let scale = 0.5 * w.max(h);
    let to = Matrix3::new(1.0 / scale, 0.0, -base.cx / scale, 0.0, 1.0 / scale, -base.cy / scale, 0.0, 0.0, 1.0);
    let mut v = DMatrix::zeros(2 * homographies.len() + 1, 6);
    for (k, homography) in homographies.iter().enumerate() {
        let h = to * homography;
        let h = h / h.norm();
        v.row_mut(2 * k).copy_from(&row(&h, 0, 1).transpose());
        v.row_mut(2 * k + 1).copy_from(&(row(&h, 0, 0) - row(&h, 1, 1)).transpose());
    }
    // No skew: the capture format has none.
    v[(2 * homographies.len(), 1)] = 1.0;
    if v.nrows() < 6 {
        return base;
    }
    let Some(v_t) = v.svd(false, true).v_t else { return base };
    let b = v_t.row(5).into_owned();
    let b = if b[0] < 0.0 { -b } else { b };
    let (b11, b12, b22, b13, b23, b33) = (b[0], b[1], b[2], b[3], b[4], b[5]);
    let d = b11 * b22 - b12 * b12;
    let cy = (b12 * b13 - b11 * b23) / d;
    let lambda = b33 - (b13 * b13 + cy * (b12 * b13 - b11 * b23)) / b11;
    let (fx, fy) = ((lambda / b11).sqrt(), (lambda * b11 / d).sqrt());
    let cx = -b13 * fx * fx / lambda;
    let sound = |f: f64| f.is_finite() && (0.1..100.0).contains(&f);
    if sound(fx) && sound(fy) && cx.abs() < 2.0 && cy.abs() < 2.0 {
        Camera { fx: fx * scale, fy: fy * scale, cx: base.cx + cx * scale, cy: base.cy + cy * scale, ..base }
    } else {
        base
    }
}

/// The board's pose from its homography: board coordinates to camera coordinates, in front of the camera.
pub(crate) fn pose(camera: &Camera, h: &Matrix3<f64>) -> Option<Pose> {
    let k = Matrix3::new(camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0);
    let m = k.try_inverse()? * h;
    let (a, b) = (m.column(0), m.column(1));
    let size = (a.norm() * b.norm()).sqrt();
    let sign = if m[(2, 2)] < 0.0 { -1.0 } else { 1.0 };
    let m = m * (sign / size);
    let (a, b): (Vector3<f64>, Vector3<f64>) = (m.column(0).into_owned(), m.column(1).into_owned());
    let rotation = nearest_rotation(&Matrix3::from_columns(&[a, b, a.cross(&b)]))?;
    Some(Pose { rotation, translation: m.column(2).into_owned() })
}
