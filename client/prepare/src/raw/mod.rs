//! Cameras' RAW files, developed to linear light: black and white level, demosaicing, and the camera's colours brought to
//! Rec. 709 by the file's own matrices. No curve, no sharpening, no denoising; the white balance is left apart.
//!
//! Files are read by the crate `flashraw`, behind the feature `raw`. A build without it refuses them, saying how to develop them
//! elsewhere.

mod colour;
mod develop;
mod mosaic;
mod options;
#[cfg(feature = "raw")]
mod read;

pub use develop::{Developed, develop};
pub use options::{Balance, Colour, Demosaic, Options};

use gonio_scene::SceneError;

/// How to go on without a reader of a file's kind.
pub const ELSEWHERE: &str = "develop it to a linear 16-bit TIFF by another program: darktable, or rawpy's \
    postprocess(gamma=(1, 1), no_auto_bright=True, output_bps=16)";

/// What a file's reader gives: the sensor's values with black taken off, over white; 1 is where it clips.
#[derive(Debug, Clone, PartialEq)]
struct Sensor {
    width: usize,
    height: usize,
    /// One value a pixel of a mosaic, or three where every pixel has all colours.
    values: Vec<f32>,
    /// The colours (0 red, 1 green, 2 blue) of a mosaic's cell, row by row, and the cell's columns; `None` for three values.
    mosaic: Option<(Vec<u8>, usize)>,
    /// What a surface that is gray in the scene's light has in the camera's channels, the largest 1.
    neutral: Option<[f64; 3]>,
    matrices: colour::Matrices,
    /// Variance over value and variance at 0, of each channel (DNG 1.7, NoiseProfile).
    noise: Option<[[f64; 2]; 3]>,
    orientation: u16,
    notes: Notes,
}

/// What a file says of itself.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Notes {
    /// Maker and model.
    pub camera: String,
    /// The file's format, such as DNG.
    pub format: String,
    /// Black and white level, in the sensor's own steps.
    pub levels: [f64; 2],
    /// Exposure time in seconds.
    pub seconds: Option<f64>,
    /// The lens's f-number.
    pub f_number: Option<f64>,
    /// ISO speed.
    pub iso: Option<f64>,
    /// Width of a pixel over its height.
    pub aspect: f64,
    /// Where the colour matrices come from.
    pub matrices: &'static str,
    /// Corrections that the file asks for and that are not made.
    pub left: Vec<String>,
}

impl Notes {
    /// Seconds at f/1 and ISO 100, as [`crate::hdr::exposure`] has them; `None` where no time is stated.
    #[must_use]
    pub fn exposure(&self) -> Option<f64> {
        let n = self.f_number.unwrap_or(1.0);
        Some(self.seconds? * self.iso.unwrap_or(100.0) / 100.0 / (n * n))
    }
}

fn refuse(file: &str, problem: impl Into<String>) -> SceneError {
    SceneError::new(file, problem, ELSEWHERE)
}
