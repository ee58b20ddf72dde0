//! Outlines of poses over an image.

use crate::bop::Model;
use crate::{Intrinsics, Pose, render};
use gonio_scene::image::Image;

/// Of the true poses.
const TRUTH: [u8; 3] = [40, 220, 60];
/// Of the estimates; drawn last.
const ESTIMATE: [u8; 3] = [255, 60, 200];

/// The image with the outlines of the models at their true (green) and at their estimated poses (magenta): 8-bit colours,
/// `width * height` of them.
#[must_use]
pub fn overlay(
    image: &Image,
    camera: &Intrinsics,
    truths: &[(&Model, Pose)],
    estimates: &[(&Model, Pose)],
) -> Vec<[u8; 3]> {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // `as` saturates
    let mut pixels: Vec<[u8; 3]> = image.pixels.iter().map(|p| p.map(|v| (v * 255.0).round() as u8)).collect();
    for (poses, colour) in [(truths, TRUTH), (estimates, ESTIMATE)] {
        for (model, pose) in poses {
            let depth = render::depth(&model.mesh, pose, camera, image.width, image.height).metres;
            for index in outline(&depth, image.width as usize) {
                if let Some(pixel) = pixels.get_mut(index) {
                    *pixel = colour;
                }
            }
        }
    }
    pixels
}

/// Pixels of the silhouette beside one that is not of it.
fn outline(depth: &[f32], width: usize) -> Vec<usize> {
    let inside = |index: Option<usize>| index.and_then(|index| depth.get(index)).is_some_and(|&z| z > 0.0);
    let rim = |&index: &usize| {
        let column = index % width;
        let left = inside(index.checked_sub(1)) && column > 0;
        let right = inside(Some(index + 1)) && column + 1 < width;
        let around = left && right && inside(index.checked_sub(width)) && inside(Some(index + width));
        inside(Some(index)) && !around
    };
    (0..depth.len()).filter(rim).collect()
}
