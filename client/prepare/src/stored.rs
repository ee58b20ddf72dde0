//! Photographs whose EXIF block says that they are to be shown turned or mirrored.
//!
//! A capture refuses them, since nobody knows which pixels its camera means. What is prepared here has no camera yet: it is
//! made as it is to be shown.

use exif::{In, Reader, Tag};
use gonio_scene::SceneError;
use gonio_scene::files::{Files, MemoryFiles};
use gonio_scene::image::{self, Image};
use std::io::Cursor;
use std::sync::Arc;

/// The name of the block in a JPEG, and one that no reader knows.
const BLOCK: &[u8; 6] = b"Exif\0\0";
const HIDDEN: &[u8; 6] = b"Gone\0\0";

/// Reads the image `path` with its pixels as they are stored, and the orientation 1..=8 that its EXIF block states; 1 where
/// it states none. Only a JPEG's is taken; another file with one is refused.
///
/// # Errors
/// As [`gonio_scene::image::read`].
pub fn read(files: &dyn Files, path: &str) -> Result<(Image, u16), SceneError> {
    let bytes = files.read(path)?;
    let orientation = orientation(&bytes).filter(|_| bytes.starts_with(&[0xff, 0xd8]));
    let at = bytes.windows(BLOCK.len()).position(|window| window == BLOCK);
    let (Some(orientation @ 2..=8), Some(at)) = (orientation, at) else { return Ok((image::read(files, path)?, 1)) };
    let mut bytes = bytes.to_vec();
    if let Some(name) = bytes.get_mut(at..at + BLOCK.len()) {
        name.copy_from_slice(HIDDEN);
    }
    let plain = MemoryFiles([(path.to_owned(), Arc::from(bytes))].into());
    Ok((image::read(&plain, path)?, orientation))
}

fn orientation(bytes: &[u8]) -> Option<u16> {
    let block = Reader::new().read_from_container(&mut Cursor::new(bytes)).ok()?;
    u16::try_from(block.get_field(Tag::Orientation, In::PRIMARY)?.value.get_uint(0)?).ok()
}

/// The image as its orientation says that it is to be shown (Exif 2.32, tag 0x0112); other numbers leave it as it is.
#[must_use]
pub fn upright(image: &Image, orientation: u16) -> Image {
    let (width, height) = (image.width as usize, image.height as usize);
    let (right, bottom) = (width.saturating_sub(1), height.saturating_sub(1));
    let source = |x: usize, y: usize| match orientation {
        2 => (right - x, y),
        3 => (right - x, bottom - y),
        4 => (x, bottom - y),
        5 => (y, x),
        6 => (y, bottom - x),
        7 => (right - y, bottom - x),
        8 => (right - y, x),
        _ => (x, y),
    };
    let turned = matches!(orientation, 5..=8);
    let (wide, high) = if turned { (height, width) } else { (width, height) };
    let pixel = |index: usize| {
        let (x, y) = source(index % wide, index / wide);
        image.pixels[y * width + x]
    };
    let pixels = (0..wide * high).map(pixel).collect();
    let (width, height) = if turned { (image.height, image.width) } else { (image.width, image.height) };
    Image { width, height, pixels }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::image::metadata::Orientation;
    use ::image::{DynamicImage, RgbImage};

    #[test]
    fn every_orientation_is_what_the_image_crate_makes_of_it() {
        let stored = RgbImage::from_fn(3, 2, |x, y| ::image::Rgb([x as u8, y as u8, 9]));
        let floats = |image: &RgbImage| Image {
            width: image.width(),
            height: image.height(),
            pixels: image.pixels().map(|pixel| pixel.0.map(f32::from)).collect(),
        };
        for number in 1..=8 {
            let mut shown = DynamicImage::ImageRgb8(stored.clone());
            shown.apply_orientation(Orientation::from_exif(number).unwrap());
            assert_eq!(upright(&floats(&stored), u16::from(number)), floats(&shown.to_rgb8()), "{number}");
        }
    }

    #[test]
    fn a_turned_jpeg_is_read_as_stored_with_its_orientation() {
        let mut bytes = Cursor::new(Vec::new());
        DynamicImage::ImageRgb8(RgbImage::new(4, 2)).write_to(&mut bytes, ::image::ImageFormat::Jpeg).unwrap();
        let bytes = bytes.into_inner();
        let mut block = b"Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0".to_vec();
        block.extend([0; 4]);
        let length = (block.len() as u16 + 2).to_be_bytes();
        let turned = [&bytes[..2], &[0xff, 0xe1], &length, &block, &bytes[2..]].concat();
        let files = |bytes: Vec<u8>| MemoryFiles([("a.jpg".to_owned(), Arc::from(bytes))].into());
        let (image, orientation) = read(&files(turned), "a.jpg").unwrap();
        assert_eq!((image.width, image.height, orientation), (4, 2, 6));
        assert_eq!(upright(&image, orientation).width, 2);
        assert_eq!(read(&files(bytes), "a.jpg").unwrap().1, 1);
    }
}
