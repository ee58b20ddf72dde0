//! The pixels at the edge of a part's silhouettes.

use super::Part;
use glam::DVec3;
use gonio_calibrate::{Contour, Field, Pose, Station};
use gonio_pose::Intrinsics;
use gonio_pose::render::visible;
use nalgebra::Vector3;

/// The edges of the silhouettes of `part` at `pose` in the photos that are `masked`. They are drawn without the lens's distortion,
/// which only says which points of the part lie there.
pub(super) fn contours(part: &Part, stations: &[Station], masked: &[bool], pose: &Pose) -> Vec<Contour> {
    let mut all = Vec::new();
    for (photo, station) in stations.iter().enumerate().filter(|(photo, _)| masked[*photo]) {
        let to_camera = station.to_camera.after(pose);
        let point = |position: &[f32; 3]| {
            let moved = to_camera.apply(&Vector3::from(position.map(|x| part.unit * f64::from(x))));
            DVec3::new(moved.x, moved.y, moved.z)
        };
        let points: Vec<DVec3> = part.mesh.positions.iter().map(point).collect();
        let camera = &station.camera;
        // Pixels count from their centres there.
        let pinhole = Intrinsics { fx: camera.fx, fy: camera.fy, cx: camera.cx - 0.5, cy: camera.cy - 0.5 };
        let seen = visible(&points, &part.mesh.triangles, &pinhole, camera.width, camera.height);
        let (width, height) = (seen.width as usize, seen.height as usize);
        let white: Vec<bool> = seen.metres.iter().map(|metres| *metres > 0.0).collect();
        let field = Field::new(width, height, &white);
        let back = station.to_camera.inverse();
        for y in 1..height.saturating_sub(1) {
            for x in 1..width.saturating_sub(1) {
                let at = y * width + x;
                let edge = white[at] && [at - 1, at + 1, at - width, at + width].iter().any(|next| !white[*next]);
                if !edge {
                    continue;
                }
                #[allow(clippy::cast_precision_loss)] // Far below 2^52.
                let (column, row) = (x as f64, y as f64);
                let ray = pinhole.ray(column, row) * f64::from(seen.metres[at]);
                let world = back.apply(&Vector3::new(ray.x, ray.y, ray.z));
                let Some((own, _)) = field.at([column + 0.5, row + 0.5]) else { continue };
                all.push(Contour { photo, point: world.into(), own });
            }
        }
    }
    all
}
