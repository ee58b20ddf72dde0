//! Fewer triangles for small pictures: vertices of one cell become one (Rossignac & Borrel 1993).

use glam::DVec3;
use std::collections::BTreeMap;

/// Positions and triangles of a mesh.
pub(crate) type Soup = (Vec<DVec3>, Vec<[u32; 3]>);

/// The mesh with the vertices of every cubic cell of `side` metres at their mean; triangles that vanish are left out.
pub(crate) fn cluster(points: &[DVec3], triangles: &[[u32; 3]], side: f64) -> Soup {
    let mut cells: BTreeMap<[i64; 3], u32> = BTreeMap::new();
    let mut sums: Vec<(DVec3, f64)> = Vec::new();
    let mut cell_of = Vec::with_capacity(points.len());
    for &point in points {
        #[allow(clippy::cast_possible_truncation)]
        // a part has no more cells than its extent over a part of its diameter
        let key = (point / side).floor().to_array().map(|x| x as i64);
        let next = u32::try_from(sums.len()).unwrap_or(u32::MAX);
        let cell = *cells.entry(key).or_insert(next);
        if cell == next {
            sums.push((DVec3::ZERO, 0.0));
        }
        if let Some((sum, count)) = sums.get_mut(cell as usize) {
            *sum += point;
            *count += 1.0;
        }
        cell_of.push(cell);
    }
    let means = sums.into_iter().map(|(sum, count)| sum / count).collect();
    let kept = triangles.iter().filter_map(|triangle| {
        let mut corners = [0; 3];
        for (corner, index) in corners.iter_mut().zip(triangle) {
            *corner = *cell_of.get(*index as usize)?;
        }
        let [a, b, c] = corners;
        (a != b && b != c && c != a).then_some(corners)
    });
    (means, kept.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fine_sheet_becomes_a_coarse_one() {
        let (mut points, mut triangles) = (Vec::new(), Vec::new());
        for row in 0..41u32 {
            for column in 0..41u32 {
                points.push(DVec3::new(f64::from(column) + 0.5, f64::from(row) + 0.5, 0.0) / 40.0);
            }
        }
        for row in 0..40u32 {
            for column in 0..40u32 {
                let a = row * 41 + column;
                triangles.extend([[a, a + 1, a + 41], [a + 1, a + 42, a + 41]]);
            }
        }
        let (means, kept) = cluster(&points, &triangles, 0.1);
        assert!(kept.len() < triangles.len() / 8 && kept.len() > 100, "{}", kept.len());
        let area: f64 = kept
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| means[i as usize]);
                (b - a).cross(c - a).length() / 2.0
            })
            .sum();
        assert!((area - 1.0).abs() < 0.15, "{area}");
    }
}
