//! What importers give: photos with cameras, and placed meshes.

use gonio_scene::Result;
use gonio_scene::capture::Camera;

/// One photo with its camera, in the conventions of the capture format.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// The image file, as the source names it.
    pub file: String,
    /// Intrinsics; the centre of the upper left pixel is (0.5, 0.5).
    pub camera: Camera,
    /// Rigid, row-major, OpenCV axes.
    pub camera_to_world: [[f64; 4]; 4],
}

/// What a source says of a scene.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Imported {
    /// In the source's order.
    pub views: Vec<View>,
    /// Object number of the source and where its mesh (in millimetres) lies in the world: affine, row-major.
    pub objects: Vec<(u32, [[f64; 4]; 4])>,
    /// What the source does not say of its world.
    pub world: &'static str,
}

/// An image that was found: its path, and its width and height in pixels.
pub type Located = Result<(String, (u32, u32))>;
