//! Where a part stands: from points of it that were clicked in photos, and from its outlines.

mod clicks;
mod outline;
mod step;

pub use clicks::{Ambiguity, Click, from_clicks};
pub use outline::{Contour, Field, from_outlines};

use crate::Pose;
use gonio_scene::capture::Camera;

/// A photo: its camera and where that stood.
#[derive(Debug, Clone)]
pub struct Station {
    /// Intrinsics.
    pub camera: Camera,
    /// Maps world coordinates to the camera's: x right, y down, z forward, metres.
    pub to_camera: Pose,
}

/// A part's place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placed {
    /// Maps the part's own coordinates (metres) to the world's.
    pub pose: Pose,
    /// Root mean square distance of clicks, or of outlines, pixels.
    pub pixels: f64,
    /// Standard errors of a turn about the world's axes through the part's middle, radians, and of a shift, metres.
    pub errors: [f64; 6],
}

impl Station {
    /// Where a point of the world is seen; absent behind the camera.
    #[must_use]
    pub fn see(&self, point: &nalgebra::Vector3<f64>) -> Option<[f64; 2]> {
        crate::project(&self.camera, &self.to_camera.apply(point))
    }
}
