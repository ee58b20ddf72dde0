//! Corners of a dark quadrilateral to a fraction of a pixel: a line through the steepest places of each side, and where
//! two of them meet (as AprilTag 2 refines its edges; Wang and Olson 2016).

use super::quad::Quad;
use super::refine::Gray;
use nalgebra::{Matrix2, Vector2};

/// The part of a side, from either end, that is left to the corner: blur rounds it.
const END: f64 = 0.12;
/// The least change across an edge that counts, gray levels.
const FAINTEST: f64 = 12.0;
/// Points farther from their line than this, pixels, or than so many median distances, are something else.
const ASIDE: (f64, f64) = (0.25, 3.5);
/// Profiles along a side.
const PROFILES: (f64, f64) = (8.0, 80.0);

/// A line: a point and a unit direction.
struct Line {
    point: Vector2<f64>,
    along: Vector2<f64>,
}

/// The corners of `quad`, sought up to `reach` pixels from its sides; absent where a side has no edge.
pub(super) fn sharpen(gray: &Gray<'_>, quad: &Quad, reach: f64) -> Option<Quad> {
    let mut lines = Vec::with_capacity(4);
    for k in 0..4 {
        lines.push(side(gray, Vector2::from(quad[k]), Vector2::from(quad[(k + 1) % 4]), reach)?);
    }
    let mut corners = *quad;
    for k in 0..4 {
        let (a, b) = (&lines[(k + 3) % 4], &lines[k]);
        let solved = Matrix2::from_columns(&[a.along, -b.along]).try_inverse()? * (b.point - a.point);
        let corner = a.point + a.along * solved.x;
        let moved = (corner - Vector2::from(quad[k])).norm();
        if moved.is_nan() || moved > 2.0 * reach + 1.0 {
            return None;
        }
        corners[k] = corner.into();
    }
    Some(corners)
}

fn side(gray: &Gray<'_>, from: Vector2<f64>, to: Vector2<f64>, reach: f64) -> Option<Line> {
    let (length, along) = ((to - from).norm(), (to - from).normalize());
    // Corners go clockwise on the screen, so outwards is to the left of the way.
    let outwards = Vector2::new(along.y, -along.x);
    let count = length.clamp(PROFILES.0, PROFILES.1) as usize;
    let steps = (4.0 * reach) as i32;
    let mut points = Vec::with_capacity(count);
    for i in 0..count {
        let t = END + (1.0 - 2.0 * END) * (i as f64 + 0.5) / count as f64;
        let middle = from + (to - from) * t;
        let at = |s: f64| gray.at(middle.x + outwards.x * s, middle.y + outwards.y * s);
        let (mut sum, mut moment) = (0.0, 0.0);
        for step in -steps..=steps {
            let s = 0.25 * f64::from(step);
            let rise = (at(s + 0.5) - at(s - 0.5)).max(0.0);
            // Squares, so that the edge counts and the noise beside it hardly does.
            sum += rise * rise;
            moment += rise * rise * s;
        }
        if at(moment / sum + 1.0) - at(moment / sum - 1.0) >= FAINTEST {
            points.push(middle + outwards * (moment / sum));
        }
    }
    if 2 * points.len() < count {
        return None;
    }
    let mut line = fit(&points)?;
    for _ in 0..2 {
        let across = Vector2::new(-line.along.y, line.along.x);
        let aside = |point: &Vector2<f64>| (point - line.point).dot(&across).abs();
        let mut distances: Vec<f64> = points.iter().map(aside).collect();
        let middle = distances.len() / 2;
        let limit = (ASIDE.1 * *distances.select_nth_unstable_by(middle, f64::total_cmp).1).max(ASIDE.0);
        let near: Vec<Vector2<f64>> = points.iter().filter(|point| aside(point) <= limit).copied().collect();
        line = fit(&near)?;
    }
    Some(line)
}

/// The line of least squares of distances.
fn fit(points: &[Vector2<f64>]) -> Option<Line> {
    let point = points.iter().sum::<Vector2<f64>>() / points.len() as f64;
    let spread: Matrix2<f64> = points.iter().map(|p| (p - point) * (p - point).transpose()).sum();
    let eigen = spread.symmetric_eigen();
    let along = eigen.eigenvectors.column(eigen.eigenvalues.imax()).into_owned();
    (points.len() >= 2 && along.iter().all(|x| x.is_finite())).then_some(Line { point, along })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_of_a_blurred_square_are_found() {
        let truth = [[20.3, 15.6], [58.2, 19.4], [55.1, 60.7], [16.8, 54.9]];
        // Dark where inside of all four sides; an edge is 1.6 pixels wide.
        let value = |k: usize| {
            let (x, y) = ((k % 80) as f64, (k / 80) as f64);
            let inside = (0..4).map(|k| {
                let (a, b): ([f64; 2], [f64; 2]) = (truth[k], truth[(k + 1) % 4]);
                let (u, v) = (b[0] - a[0], b[1] - a[1]);
                ((x - a[0]) * -v + (y - a[1]) * u) / u.hypot(v)
            });
            let depth = inside.fold(f64::INFINITY, f64::min);
            (125.0 - 95.0 * libm::tanh(depth / 0.8)) as u8
        };
        let data: Vec<u8> = (0..80 * 80).map(value).collect();
        let gray = Gray { width: 80, height: 80, data: &data };
        let rough = truth.map(|[x, y]: [f64; 2]| [x.round() + 0.5, y.round() - 0.5]);
        let found = sharpen(&gray, &rough, 2.5).unwrap();
        for (found, truth) in found.iter().zip(truth) {
            assert!((found[0] - truth[0]).hypot(found[1] - truth[1]) < 0.05, "{found:?} {truth:?}");
        }
        assert!(sharpen(&Gray { width: 80, height: 80, data: &[90; 6400] }, &rough, 2.5).is_none());
    }
}
