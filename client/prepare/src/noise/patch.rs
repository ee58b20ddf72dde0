//! A part of a photo.

use gonio_scene::SceneError;
use gonio_scene::image::Image;
use std::str::FromStr;

/// A rectangle of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Patch {
    /// Column of its left edge.
    pub x: u32,
    /// Row of its upper edge.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl FromStr for Patch {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Result<Vec<u32>, _> = text.split(',').map(|number| number.trim().parse()).collect();
        match numbers.as_deref() {
            Ok(&[x, y, width, height]) if width > 0 && height > 0 => Ok(Self { x, y, width, height }),
            _ => Err("write X,Y,WIDTH,HEIGHT in whole pixels, such as 400,300,128,128".to_owned()),
        }
    }
}

/// The part of an image; `file` is for messages.
///
/// # Errors
/// The patch reaches beyond the image.
pub fn crop(file: &str, image: &Image, patch: Patch) -> Result<Image, SceneError> {
    let fits = |start: u32, length: u32, all: u32| start.checked_add(length).is_some_and(|end| end <= all);
    if !fits(patch.x, patch.width, image.width) || !fits(patch.y, patch.height, image.height) {
        let problem = format!("is {} x {} pixels, and the patch reaches beyond", image.width, image.height);
        return Err(SceneError::new(file, problem, "give X,Y,WIDTH,HEIGHT inside of the photo").at("--patch"));
    }
    let row = |y: u32| &image.pixels[(y * image.width + patch.x) as usize..][..patch.width as usize];
    let pixels = (patch.y..patch.y + patch.height).flat_map(row).copied().collect();
    Ok(Image { width: patch.width, height: patch.height, pixels })
}
