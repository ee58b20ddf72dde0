//! Photos at a part of their size, for what is sought in them and not measured.

use crate::DiagnoseError;
use crate::overlay::AddedFile;
use crate::overlay::Overlay;
use gonio_scene::capture::{Camera, CameraOverride};
use gonio_scene::files::Files;
use gonio_scene::image::{Image, encode_exr, encode_png8, read, read_mask};
use gonio_scene::{Capture, Result};

/// The capture with photos whose pixels are the means of `factor` x `factor` of its own, and the files that come with it. A
/// pixel counts where all of these do. Rows and columns beyond a multiple of `factor` are left out. The sensor's noise stays
/// as it was, since a mean over an edge errs by more than its noise.
///
/// # Errors
/// A photo that cannot be read, a capture that the format refuses.
pub fn reduced(
    capture: &Capture,
    added: &[AddedFile],
    factor: u32,
    files: &dyn Files,
) -> std::result::Result<(Capture, Vec<AddedFile>), DiagnoseError> {
    let (mut small, mut with) = (capture.clone(), added.to_vec());
    if factor <= 1 {
        return Ok((small, with));
    }
    let files = Overlay { files, added };
    for photo in &mut small.photos {
        photo.camera = over(&capture.camera_of(photo), &photo.camera, factor);
        let name = photo.name().to_owned();
        // A photo is named by its file.
        let (file, mask) = (format!("reduced-{factor}/{name}.exr"), format!("reduced-{factor}/{name}.mask.png"));
        let (image, counts) = means(&files, &photo.file, photo.mask.as_deref(), capture.sensor.saturation, factor)?;
        let shown: Vec<[u8; 3]> = counts.iter().map(|c| [if *c { 255 } else { 0 }; 3]).collect();
        with.push((file.clone(), encode_exr(&file, &image)?.into()));
        with.push((mask.clone(), encode_png8(&mask, image.width, image.height, &shown)?.into()));
        (photo.file, photo.mask) = (file, Some(mask));
    }
    Ok((small, with))
}

/// What a photo at a part of its size has otherwise than the capture's camera; `own` is what it had before.
fn over(camera: &Camera, own: &CameraOverride, factor: u32) -> CameraOverride {
    let scaled = |x: f64| Some(x / f64::from(factor));
    CameraOverride {
        width: Some(camera.width / factor),
        height: Some(camera.height / factor),
        fx: scaled(camera.fx),
        fy: scaled(camera.fy),
        cx: scaled(camera.cx),
        cy: scaled(camera.cy),
        glare_width: scaled(camera.glare_width),
        ..own.clone()
    }
}

/// A photo's means over blocks, and where all pixels of a block count and are not clipped.
fn means(
    files: &dyn Files,
    file: &str,
    mask: Option<&str>,
    saturation: Option<f64>,
    factor: u32,
) -> Result<(Image, Vec<bool>)> {
    let image = read(files, file)?;
    let mask = mask.map(|m| read_mask(files, m)).transpose()?;
    let (width, height) = (image.width / factor, image.height / factor);
    let clipped = saturation.map_or(f32::INFINITY, |s| s as f32);
    let (mut pixels, mut counts) = (Vec::new(), Vec::new());
    for (row, column) in (0..height).flat_map(|row| (0..width).map(move |column| (row, column))) {
        let (mut sum, mut all) = ([0.0; 3], true);
        for (y, x) in (0..factor).flat_map(|y| (0..factor).map(move |x| (row * factor + y, column * factor + x))) {
            let at = y as usize * image.width as usize + x as usize;
            let pixel = image.pixels[at];
            (0..3).for_each(|c| sum[c] += pixel[c]);
            all &= mask.as_ref().is_none_or(|m| m.bits[at]) && pixel.iter().all(|v| *v < clipped);
        }
        pixels.push(sum.map(|s| s / (factor * factor) as f32));
        counts.push(all);
    }
    // A photo without a pixel is no photo: where no block counts as a whole, all do.
    if !counts.contains(&true) {
        counts.fill(true);
    }
    Ok((Image { width, height, pixels }, counts))
}
