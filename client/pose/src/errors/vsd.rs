//! Visible Surface Discrepancy (Hodan et al. 2018, 2020): depth images of the two poses compared where the object is
//! visible.

use crate::bop::Depth;
use crate::{Intrinsics, Pose, render};
use gonio_scene::mesh::Mesh;

/// A surface this far behind the measured one, in metres, still counts as visible.
pub const DELTA: f64 = 0.015;

/// Misalignments that are tolerated, as parts of the diameter.
pub const TAUS: [f64; 10] = [0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5];

/// The error for each of [`TAUS`]: the part of the visible surface, of either pose, that is missing or misaligned.
/// `measured` is the image's depth; a pixel without depth hides nothing. `diameter` is in metres.
#[must_use]
pub fn vsd(
    mesh: &Mesh,
    diameter: f64,
    estimate: &Pose,
    truth: &Pose,
    camera: &Intrinsics,
    measured: &Depth,
) -> [f64; TAUS.len()] {
    let (width, height) = (measured.width, measured.height);
    let rendered = [estimate, truth].map(|pose| render::depth(mesh, pose, camera, width, height).metres);
    let [estimated, true_depth] = &rendered;
    let (mut union, mut apart) = (0u32, 0u32);
    let mut misaligned = [0u32; TAUS.len()];
    for (index, &scene) in measured.metres.iter().enumerate() {
        let (Some(&e), Some(&t)) = (estimated.get(index), true_depth.get(index)) else { continue };
        if e <= 0.0 && t <= 0.0 {
            continue;
        }
        // Distances along the ray, not depths, are compared.
        let (column, row) = (index % width as usize, index / width as usize);
        #[allow(clippy::cast_precision_loss)]
        let length = camera.ray(column as f64, row as f64).length();
        let [scene, e, t] = [scene, e, t].map(|z| f64::from(z) * length);
        let in_view = |distance: f64| distance > 0.0 && (scene <= 0.0 || distance - scene <= DELTA);
        let true_visible = in_view(t);
        // An estimate behind the true surface is not hidden by it.
        let estimate_visible = in_view(e) || (true_visible && e > 0.0);
        union += u32::from(true_visible || estimate_visible);
        if true_visible && estimate_visible {
            let distance = (e - t).abs() / diameter;
            for (count, tau) in misaligned.iter_mut().zip(TAUS) {
                *count += u32::from(distance >= tau);
            }
        } else {
            apart += u32::from(true_visible || estimate_visible);
        }
    }
    misaligned.map(|count| if union == 0 { 1.0 } else { f64::from(count + apart) / f64::from(union) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    const CAMERA: Intrinsics = Intrinsics { fx: 100.0, fy: 100.0, cx: 49.5, cy: 49.5 };
    const SIZE: u32 = 100;

    /// A square of 0.2 m that faces the camera: 40 x 40 pixels at 0.5 m.
    fn square() -> Mesh {
        let positions = vec![[-0.1, -0.1, 0.0], [0.1, -0.1, 0.0], [0.1, 0.1, 0.0], [-0.1, 0.1, 0.0]];
        Mesh { positions, normals: None, triangles: vec![[0, 1, 2], [0, 2, 3]], degenerate: 0 }
    }

    fn at(x: f64, z: f64) -> Pose {
        Pose { translation: DVec3::new(x, 0.0, z), ..Pose::IDENTITY }
    }

    fn everywhere(metres: f32) -> Depth {
        Depth { width: SIZE, height: SIZE, metres: vec![metres; (SIZE * SIZE) as usize] }
    }

    #[test]
    fn the_true_pose_has_no_error_and_one_beside_it_all() {
        let measure = |x: f64, z: f64| vsd(&square(), 0.28, &at(x, z), &at(0.0, 0.5), &CAMERA, &everywhere(0.0));
        assert_eq!(measure(0.0, 0.5), [0.0; 10]);
        assert_eq!(measure(0.22, 0.5), [1.0; 10]);
        // Shifted by 10 of 40 columns: 20 of 50 are seen in one pose alone.
        for error in measure(0.05, 0.5) {
            assert!((error - 0.4).abs() < 1e-12, "{error}");
        }
    }

    #[test]
    fn a_shift_along_the_view_counts_from_its_tolerance_on() {
        // 0.1 of a diameter of 0.2 m behind: at least 0.02 m along every ray, at most 0.0217 m.
        let found = vsd(&square(), 0.2, &at(0.0, 0.52), &at(0.0, 0.5), &CAMERA, &everywhere(0.0));
        // The silhouette shrinks from 40 to 38.46 pixels: from 40 to 38 columns and rows.
        let rim = 1.0 - 38.0 * 38.0 / 1600.0;
        assert_eq!(found[0], 1.0);
        assert!((found[2] - rim).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn what_stands_before_the_object_hides_it() {
        let mut scene = everywhere(0.5);
        // The left half of the square is 0.2 m behind something.
        for row in 0..SIZE as usize {
            scene.metres[row * SIZE as usize..][..50].fill(0.3);
        }
        let found = vsd(&square(), 0.28, &at(0.05, 0.5), &at(0.0, 0.5), &CAMERA, &scene);
        // Of the true one columns 50..70 are seen, of the estimate 50..80: 10 of 30 are apart.
        assert!((found[0] - 1.0 / 3.0).abs() < 1e-12, "{found:?}");
        assert_eq!(vsd(&square(), 0.28, &at(0.0, 0.5), &at(0.0, 0.5), &CAMERA, &everywhere(0.1)), [1.0; 10]);
    }
}
