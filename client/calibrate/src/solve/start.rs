//! First cameras and poses, in closed form, from the corners that agree with one homography per photo.

use super::bundle::{State, Weights};
use super::model::Model;
use super::refusal::Refusal;
use super::robust::{FEWEST, noise};
use super::zhang;
use crate::board::Corner;
use crate::geometry::Pose;
use crate::homography::agreed;
use gonio_scene::capture::Camera;
use nalgebra::Matrix3;

/// Corners this near to where a homography has them agree with it, pixels: a lens without distortion leaves less than that.
const CLOSE: f64 = 1.0;

fn homographies(photos: &[Vec<Corner>]) -> Result<(Vec<Matrix3<f64>>, Weights), Refusal> {
    let mut all = (Vec::new(), Weights::new());
    for (index, corners) in photos.iter().enumerate() {
        let found = if corners.len() < FEWEST { None } else { agreed(corners, CLOSE) };
        let (homography, agrees) = found.ok_or_else(|| Refusal::corners(index, corners.len()))?;
        all.0.push(homography);
        all.1.push(agrees.into_iter().map(|agrees| f64::from(u8::from(agrees))).collect());
    }
    Ok(all)
}

/// The poses of a camera that is known, and the corners that they follow from.
pub(crate) fn poses(camera: &Camera, photos: &[Vec<Corner>]) -> Result<(State, Weights), Refusal> {
    let (homographies, weights) = homographies(photos)?;
    let mut poses = Vec::new();
    for (index, (homography, corners)) in homographies.iter().zip(photos).enumerate() {
        poses.push(zhang::pose(camera, homography).ok_or_else(|| Refusal::corners(index, corners.len()))?);
    }
    Ok((State { camera: camera.clone(), poses }, weights))
}

/// A camera with a rough distortion, the poses, and the corners that they follow from.
pub(crate) fn cameras(width: u32, height: u32, photos: &[Vec<Corner>]) -> Result<(State, Weights), Refusal> {
    let (homographies, weights) = homographies(photos)?;
    // Views that are nearly parallel throw the closed form far off, into a valley that does not lead back: a plain
    // camera is tried too, and the better end taken.
    let starts = [zhang::intrinsics(&homographies, width, height), zhang::intrinsics(&[], width, height)];
    let mut best: Option<(f64, State)> = None;
    for camera in starts {
        let poses: Option<Vec<Pose>> = homographies.iter().map(|h| zhang::pose(&camera, h)).collect();
        let Some(poses) = poses else { continue };
        let plain = State { camera: Model::PLAIN.cut(&camera), poses: poses.clone() };
        let ends = [plain.descend(Model::PLAIN, photos, &weights), Some(State { camera, poses })];
        for end in ends.into_iter().flatten() {
            let Some(state) = end.descend(Model::ROUGH, photos, &weights) else { continue };
            let noise = noise(&state, Model::ROUGH, photos, &weights);
            if state.camera.fx > 0.0 && state.camera.fy > 0.0 && best.as_ref().is_none_or(|(least, _)| noise < *least) {
                best = Some((noise, state));
            }
        }
    }
    Ok((best.ok_or_else(Refusal::open)?.1, weights))
}
