//! How much better a part at a pose explains an image than no part does.

use crate::background::Background;
use crate::part::{Part, Solid};
use crate::picture::Picture;
use crate::shading::Shading;
use gonio_pose::Pose;
use gonio_pose::render::{NOTHING, Visible};

/// Part of the part's pixels that may have any colour: highlights, shadows, whatever stands before it.
const OUTLIERS: f64 = 0.05;

/// The surroundings of a candidate, and how likely they are without the part.
pub(crate) struct Likelihood<'a> {
    solid: &'a Solid,
    picture: Picture,
    /// Logarithm of the density of each pixel.
    background: Vec<f32>,
    /// Pixels of the image for each of the picture.
    share: f64,
}

impl<'a> Likelihood<'a> {
    /// Of the surroundings of `pose` in `whole`, at a scale at which the part's diameter takes `size` pixels, or that of the image
    /// where that is smaller. `None` where the part is out of the image.
    pub fn around(
        part: &Part,
        solid: &'a Solid,
        whole: &Picture,
        background: &Background,
        pose: &Pose,
        size: f64,
    ) -> Option<Self> {
        let centre = pose.apply(part.centre);
        let middle = whole.camera.project(centre);
        let focal = (whole.camera.fx * whole.camera.fy).sqrt();
        let diameter = focal * part.diameter / centre.z;
        let reach = 0.85 * diameter + 2.0;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // clamped to the image
        let side = |middle: f64, length: u32| {
            let length = f64::from(length);
            ((middle - reach).floor().clamp(0.0, length) as u32, (middle + reach).ceil().clamp(0.0, length) as u32)
        };
        let ((left, right), (top, bottom)) = (side(middle.x, whole.width()), side(middle.y, whole.height()));
        if right < left + 8 || bottom < top + 8 {
            return None;
        }
        let picture = whole.cropped(left, top, right - left, bottom - top);
        let picture = if diameter > size { picture.scaled(size / diameter) } else { picture };
        let count = picture.width() as usize * picture.height() as usize;
        let background = (0..count).map(|index| background.logarithm(picture.at(index))).collect();
        let area = f64::from((right - left) * (bottom - top));
        #[allow(clippy::cast_precision_loss)]
        Some(Self { solid, picture, background, share: area / count as f64 })
    }

    /// The logarithm of the ratio of the two likelihoods, of as many pixels as the image has.
    pub fn of(&self, pose: &Pose) -> f64 {
        let (width, height) = (self.picture.width(), self.picture.height());
        let seen = self.solid.see(pose, &self.picture.camera, width, height);
        let mut part = Vec::new();
        let mut indices = Vec::new();
        for (index, &triangle) in seen.triangles.iter().enumerate() {
            if triangle == NOTHING {
                continue;
            }
            #[allow(clippy::cast_precision_loss)]
            let (column, row) = ((index % width as usize) as f64, (index / width as usize) as f64);
            let normal = self.solid.normal(triangle, pose, self.picture.camera.ray(column, row));
            part.push((normal, self.picture.at(index)));
            indices.push(index);
        }
        let Some(shading) = Shading::fit(&part) else { return f64::NEG_INFINITY };
        let mut sum = 0.0;
        for ((normal, value), index) in part.iter().zip(indices) {
            let background = f64::from(self.background.get(index).copied().unwrap_or(0.0));
            // exp does not overflow: the spread has a least value.
            let density = libm::exp(shading.logarithm(*normal, value));
            let density = if on_rim(&seen, index) {
                // Which colour a pixel has that both share is open.
                0.5 * density + 0.5 * libm::exp(background).max(1.0)
            } else {
                (1.0 - OUTLIERS) * density + OUTLIERS
            };
            sum += libm::log(density) - background;
        }
        sum * self.share
    }
}

/// Whether a pixel of the part has a neighbour that is none.
fn on_rim(seen: &Visible, index: usize) -> bool {
    let width = seen.width as usize;
    let column = index % width;
    let nothing = |there: bool, other: usize| there && seen.triangles.get(other) == Some(&NOTHING);
    nothing(column > 0, index.wrapping_sub(1))
        || nothing(column + 1 < width, index + 1)
        || nothing(index >= width, index.wrapping_sub(width))
        || nothing(true, index + width)
}
