//! The plane-to-photo homography, by the normalised direct linear transform (Hartley and Zisserman 2004, algorithm 4.2),
//! and from points some of which are wrong (least median of squares; Rousseeuw 1984).

use crate::board::Corner;
use nalgebra::{DMatrix, Matrix3, Vector3};

/// Quadruples of points that are tried: with a third of them wrong, a fifth of all quadruples is right.
const TRIES: usize = 200;
/// Distance up to which a point agrees, in median distances of all. 1.177 of those are a standard deviation.
const AGREES: f64 = 3.5;

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

/// Where a point of the plane falls.
pub(crate) fn map(h: &Matrix3<f64>, [x, y]: [f64; 2]) -> [f64; 2] {
    let q = h * Vector3::new(x, y, 1.0);
    [q.x / q.z, q.y / q.z]
}

fn distance(h: &Matrix3<f64>, corner: &Corner) -> f64 {
    let [x, y] = map(h, corner.board);
    let far = (corner.pixel[0] - x).hypot(corner.pixel[1] - y);
    if far.is_finite() { far } else { f64::INFINITY }
}

/// A homography that most corners agree with, and which do: up to `close` pixels, or a few times their median distance.
///
/// Draws the same quadruples each time. Absent where no four corners determine one, or fewer than four agree.
pub(crate) fn agreed(corners: &[Corner], close: f64) -> Option<(Matrix3<f64>, Vec<bool>)> {
    let fit = |h: &Matrix3<f64>| {
        let mut distances: Vec<f64> = corners.iter().map(|corner| distance(h, corner)).collect();
        let limit = (AGREES * *distances.select_nth_unstable_by(corners.len() / 2, f64::total_cmp).1).max(close);
        let agrees: Vec<bool> = corners.iter().map(|corner| distance(h, corner) <= limit).collect();
        (limit, agrees)
    };
    let whole = homography(corners);
    if let Some(h) = whole
        && corners.iter().all(|corner| distance(&h, corner) <= close)
    {
        return Some((h, vec![true; corners.len()]));
    }
    let mut state = 1_u64;
    let mut draw = || {
        // Knuth's MMIX generator; its upper bits.
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        corners.get((state >> 33) as usize % corners.len()).copied()
    };
    if corners.is_empty() {
        return None;
    }
    let mut best = whole.map(|h| (fit(&h), h));
    for _ in 0..if corners.len() > 4 { TRIES } else { 0 } {
        let four: Vec<Corner> = (0..4).filter_map(|_| draw()).collect();
        let Some(h) = homography(&four) else { continue };
        let found = fit(&h);
        if best.as_ref().is_none_or(|((limit, agrees), _)| {
            let count = |agrees: &[bool]| agrees.iter().filter(|agrees| **agrees).count();
            found.0 < *limit || found.0 == *limit && count(&found.1) > count(agrees)
        }) {
            best = Some((found, h));
        }
    }
    // From all that agree, which then may be more.
    let (_, mut agrees) = best?.0;
    let mut end = None;
    for _ in 0..3 {
        let those: Vec<Corner> =
            corners.iter().zip(&agrees).filter(|(_, agrees)| **agrees).map(|(corner, _)| *corner).collect();
        let h = homography(&those)?;
        agrees = fit(&h).1;
        end = Some(h);
    }
    Some((end?, agrees))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_third_of_wrong_corners_does_not_count() {
        let truth = Matrix3::new(300.0, 20.0, 100.0, -30.0, 280.0, 80.0, 0.2, -0.1, 1.0);
        let corner = |id: u32| {
            let board = [f64::from(id % 6) * 0.1, f64::from(id / 6) * 0.1];
            let [x, y] = map(&truth, board);
            let wrong = if id.is_multiple_of(3) { 10.0 + 3.0 * f64::from(id) } else { 0.0 };
            Corner { id, board, pixel: [x + wrong, y - 0.5 * wrong] }
        };
        let corners: Vec<Corner> = (0..30).map(corner).collect();
        let (h, agrees) = agreed(&corners, 0.5).unwrap();
        assert!((h - truth).amax() < 1e-6, "{h}");
        assert!(agrees.iter().enumerate().all(|(i, agrees)| *agrees == (i % 3 != 0)), "{agrees:?}");
        // On a line, nothing is determined.
        assert!(agreed(&corners[..6], 0.5).is_none() && agreed(&[], 0.5).is_none());
    }
}
