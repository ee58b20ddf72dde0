//! Polygons into triangles.

use earcut::Earcut;
use glam::{DVec2, DVec3};

/// Ear clipping takes the square of the corners at worst: more than this many are refused, where a hostile face would
/// take minutes. A cap of a machined part has some hundred.
const MOST_CORNERS: usize = 1 << 14;

/// A polygon whose area is below this fraction of its extent's square has none that its coordinates could hold.
const SLIVER: f64 = 1e-8;

/// A corner turns inwards when its cross product is below this fraction of the polygon's area; what is less is the
/// rounding of coordinates that lie on a line.
const STRAIGHT: f64 = 1e-7;

/// The areas of the triangles may differ from the polygon's by this fraction; more means that its outline crosses itself.
const CROSSED: f64 = 1e-3;

/// Splits polygons; keeps its memory from one to the next.
pub(super) struct Splitter {
    earcut: Earcut<f64>,
    flat: Vec<DVec2>,
    indices: Vec<u32>,
}

impl Splitter {
    pub(super) fn new() -> Self {
        Self { earcut: Earcut::new(), flat: Vec::new(), indices: Vec::new() }
    }

    /// Appends the triangles of the polygon `corners`, wound as it is: a fan around its first corner where it is convex,
    /// clipped ears where it is not. Fewer than three corners give a triangle without an area, and corners that do not
    /// exist a fan: both are for the check behind to judge.
    ///
    /// # Errors
    /// What is wrong with the polygon: its outline crosses itself, or it has too many corners to be clipped.
    pub(super) fn split(
        &mut self,
        positions: &[[f64; 3]],
        corners: &[u32],
        into: &mut Vec<[u32; 3]>,
    ) -> Result<(), String> {
        let [first, rest @ ..] = corners else { return Ok(()) };
        let last = rest.last().copied().unwrap_or(*first);
        if rest.len() < 2 {
            into.push([*first, last, last]);
            return Ok(());
        }
        if rest.len() == 2 || !self.flatten(positions, corners) {
            into.extend(rest.windows(2).filter_map(|edge| Some([*first, *edge.first()?, *edge.last()?])));
            return Ok(());
        }
        if corners.len() > MOST_CORNERS {
            return Err(format!("is a polygon of {} corners that is not convex", corners.len()));
        }
        self.earcut.earcut(self.flat.iter().map(DVec2::to_array), &[] as &[u32], &mut self.indices);
        let corner = |index: u32| self.flat.get(index as usize).copied().unwrap_or(DVec2::NAN);
        let mut covered = 0.0;
        for &[a, b, c] in self.indices.as_chunks::<3>().0 {
            let double = (corner(b) - corner(a)).perp_dot(corner(c) - corner(a));
            covered += double.abs();
            // The library's own winding is not the polygon's.
            let (b, c) = if double < 0.0 { (c, b) } else { (b, c) };
            let named = |index: u32| corners.get(index as usize).copied().unwrap_or(*first);
            into.push([named(a), named(b), named(c)]);
        }
        let area = double_area(&self.flat);
        if (covered - area).abs() <= CROSSED * area {
            return Ok(());
        }
        Err(format!("is a polygon of {} corners whose outline crosses itself", corners.len()))
    }

    /// Puts the polygon into its plane, counter-clockwise; whether it needs to be clipped, having an area and an inward
    /// corner.
    fn flatten(&mut self, positions: &[[f64; 3]], corners: &[u32]) -> bool {
        let point = |index: &u32| positions.get(*index as usize).map(|point| DVec3::from_array(*point));
        let Some(points) = corners.iter().map(point).collect::<Option<Vec<_>>>() else { return false };
        let around = |index: usize| points.get(index % points.len()).copied().unwrap_or(DVec3::NAN) - points[0];
        // Newell's normal: twice the area, whatever the corners' heights over the plane.
        let normal: DVec3 = (0..points.len()).map(|index| around(index).cross(around(index + 1))).sum();
        let extent = points.iter().map(|point| (*point - points[0]).length_squared()).fold(0.0, f64::max);
        if !normal.is_finite() || normal.length() <= SLIVER * extent {
            return false;
        }
        let size = normal.abs();
        let axis = (0..3).max_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or(2);
        let (mut right, mut up) = ((axis + 1) % 3, (axis + 2) % 3);
        if normal[axis] < 0.0 {
            std::mem::swap(&mut right, &mut up);
        }
        self.flat.clear();
        self.flat.extend((0..points.len()).map(around).map(|point| DVec2::new(point[right], point[up])));
        let flat = |index: usize| self.flat.get(index % self.flat.len()).copied().unwrap_or(DVec2::NAN);
        let least = -STRAIGHT * double_area(&self.flat);
        (0..self.flat.len()).any(|at| (flat(at + 1) - flat(at)).perp_dot(flat(at + 2) - flat(at + 1)) < least)
    }
}

/// Twice the signed area of an outline: positive where it runs counter-clockwise.
fn double_area(outline: &[DVec2]) -> f64 {
    let closing = outline.last().into_iter().zip(outline.first());
    outline
        .windows(2)
        .filter_map(|edge| edge.first().zip(edge.last()))
        .chain(closing)
        .map(|(a, b)| a.perp_dot(*b))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An L of area 3 in a plane that is turned against every axis, and its normal.
    fn ell() -> (Vec<[f64; 3]>, DVec3) {
        let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -1.1, 2.0);
        let outline = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let points = outline.map(|[x, y]| (turn * DVec3::new(x, y, 0.5)).to_array());
        (points.to_vec(), turn * DVec3::Z)
    }

    fn areas(points: &[[f64; 3]], triangles: &[[u32; 3]], normal: DVec3) -> Vec<f64> {
        let area = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|index| DVec3::from_array(points[index as usize]));
            (b - a).cross(c - a).dot(normal) / 2.0
        };
        triangles.iter().map(area).collect()
    }

    #[test]
    fn a_concave_polygon_keeps_its_area_and_winding_from_any_first_corner() {
        let (points, normal) = ell();
        for first in 0..6 {
            for reversed in [false, true] {
                let mut corners: Vec<u32> = (0..6).map(|corner| (corner + first) % 6).collect();
                let mut facing = normal;
                if reversed {
                    corners.reverse();
                    facing = -normal;
                }
                let mut triangles = Vec::new();
                Splitter::new().split(&points, &corners, &mut triangles).unwrap();
                let areas = areas(&points, &triangles, facing);
                assert!(areas.iter().all(|area| *area > 0.0), "{areas:?}");
                assert!((areas.iter().sum::<f64>() - 3.0).abs() < 1e-12, "{areas:?}");
            }
        }
    }

    #[test]
    fn a_convex_polygon_stays_a_fan_around_its_first_corner() {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.1], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]];
        let mut triangles = Vec::new();
        Splitter::new().split(&points, &[1, 2, 3, 4, 0], &mut triangles).unwrap();
        assert_eq!(triangles, [[1, 2, 3], [1, 3, 4], [1, 4, 0]]);
    }

    #[test]
    fn a_keyhole_keeps_its_hole() {
        // A square of 4 x 4 with a hole of 2 x 2, joined by a seam that is walked twice.
        let square = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0], [1.0, 1.0], [1.0, 3.0], [3.0, 3.0], [3.0, 1.0]];
        let points = square.map(|[x, y]| [x, y, 0.0]);
        let mut triangles = Vec::new();
        Splitter::new().split(&points, &[0, 1, 2, 3, 0, 4, 5, 6, 7, 4], &mut triangles).unwrap();
        let areas = areas(&points, &triangles, DVec3::Z);
        assert!((areas.iter().sum::<f64>() - 12.0).abs() < 1e-12 && areas.iter().all(|area| *area >= 0.0), "{areas:?}");
    }

    #[test]
    fn an_outline_that_crosses_itself_is_refused() {
        let points = [[0.0, 0.0, 0.0], [4.0, 4.0, 0.0], [4.0, 0.0, 0.0], [0.0, 3.0, 0.0]];
        let problem = Splitter::new().split(&points, &[0, 1, 2, 3], &mut Vec::new()).unwrap_err();
        assert!(problem.contains("crosses itself"), "{problem}");
    }
}
