//! The plane-to-photo homography, by the normalised direct linear transform (Hartley and Zisserman 2004, algorithm 4.2).

use crate::board::Corner;
use nalgebra::{DMatrix, Matrix3, Vector3};

/// Moves the centroid to 0 and the mean distance to sqrt 2.
fn normaliser(points: impl Iterator<Item = [f64; 2]> + Clone) -> Option<Matrix3<f64>> {
    let n = points.clone().count() as f64;
    let (sx, sy) = points.clone().fold((0.0, 0.0), |(sx, sy), [x, y]| (sx + x, sy + y));
    let (mx, my) = (sx / n, sy / n);
    let spread = points.map(|[x, y]| (x - mx).hypot(y - my)).sum::<f64>() / n;
    let s = std::f64::consts::SQRT_2 / spread;
    s.is_finite().then(|| Matrix3::new(s, 0.0, -s * mx, 0.0, s, -s * my, 0.0, 0.0, 1.0))
}

/// H with pixel ~ H (x, y, 1) for board points (x, y); absent for fewer than four corners, or corners on one line.
pub(crate) fn homography(corners: &[Corner]) -> Option<Matrix3<f64>> {
    if corners.len() < 4 {
        return None;
    }
    let from = normaliser(corners.iter().map(|corner| corner.board))?;
    let to = normaliser(corners.iter().map(|corner| corner.pixel))?;
    let mut a = DMatrix::zeros((2 * corners.len()).max(9), 9);
    for (i, corner) in corners.iter().enumerate() {
        let p = from * Vector3::new(corner.board[0], corner.board[1], 1.0);
        let q = to * Vector3::new(corner.pixel[0], corner.pixel[1], 1.0);
        for k in 0..3 {
            a[(2 * i, k)] = p[k];
            a[(2 * i, 6 + k)] = -q.x * p[k];
            a[(2 * i + 1, 3 + k)] = p[k];
            a[(2 * i + 1, 6 + k)] = -q.y * p[k];
        }
    }
    let svd = a.svd(false, true);
    let values = &svd.singular_values;
    // A second null direction: the corners do not determine the map.
    if values[7] < 1e-6 * values[0] {
        return None;
    }
    let last = svd.v_t?.row(8).into_owned();
    let h = Matrix3::from_row_slice(last.as_slice());
    let h = to.try_inverse()? * h * from;
    (h[(2, 2)].abs() > 1e-12).then(|| h / h[(2, 2)])
}
