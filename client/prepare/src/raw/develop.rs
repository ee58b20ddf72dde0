//! From a file's bytes to an image.

#[cfg(not(feature = "raw"))]
use super::refuse;
use super::{Balance, Colour, Notes, Options, Sensor, mosaic};
use crate::stored::upright;
use gonio_scene::SceneError;
use gonio_scene::image::Image;
use nalgebra::{Matrix3, Vector3};

/// A developed image and what became of the file's statements.
#[derive(Debug, Clone, PartialEq)]
pub struct Developed {
    /// Linear light, turned as it is to be shown. 1 is what clips of a gray surface.
    pub image: Image,
    /// Pixels with a clipped value in them.
    pub clipped: Vec<bool>,
    /// The camera's channels of a gray surface in the scene's light, as the camera took it; the largest is 1.
    pub neutral: Option<[f64; 3]>,
    /// What the camera's channels were multiplied by, row by row.
    pub matrix: [[f64; 3]; 3],
    /// The file's own noise in the image's values, for gray: variance per value, and at 0; a mean of the channels.
    pub noise: Option<[f64; 2]>,
    /// What the file says of itself.
    pub notes: Notes,
}

/// Develops the RAW file `bytes`; `file` is for messages.
///
/// # Errors
/// No file that can be read here (the mend says how to go on), or one without the matrices or the white balance that the
/// options ask for.
pub fn develop(file: &str, bytes: &[u8], options: Options) -> Result<Developed, SceneError> {
    let sensor = read(file, bytes)?;
    let matrix = matrix(file, &sensor, options)?;
    let planes = mosaic::planes(file, &sensor, options.demosaic)?;
    let colour = |pixel: &[f32; 3]| -> [f32; 3] {
        let made = matrix * Vector3::from(pixel.map(f64::from));
        [made[0] as f32, made[1] as f32, made[2] as f32]
    };
    let size = [planes.width, planes.height].map(|side| u32::try_from(side).unwrap_or(u32::MAX));
    let stored = Image { width: size[0], height: size[1], pixels: planes.pixels.iter().map(colour).collect() };
    let mark = |bit: &bool| [f32::from(u8::from(*bit)); 3];
    let marks = Image { pixels: planes.clipped.iter().map(mark).collect(), ..stored };
    let clipped = upright(&marks, sensor.orientation).pixels.iter().map(|pixel| pixel[0] > 0.5).collect();
    let stored = Image { pixels: planes.pixels.iter().map(colour).collect(), ..marks };
    Ok(Developed {
        image: upright(&stored, sensor.orientation),
        clipped,
        neutral: sensor.neutral,
        matrix: [0, 1, 2].map(|row| [0, 1, 2].map(|column| matrix[(row, column)])),
        noise: noise(&sensor, &matrix),
        notes: sensor.notes,
    })
}

#[cfg(feature = "raw")]
fn read(file: &str, bytes: &[u8]) -> Result<Sensor, SceneError> {
    super::read::read(file, bytes)
}

#[cfg(not(feature = "raw"))]
fn read(file: &str, _: &[u8]) -> Result<Sensor, SceneError> {
    Err(refuse(file, "is a camera's RAW file, which this build cannot read (it was built without the feature `raw`)"))
}

fn matrix(file: &str, sensor: &Sensor, options: Options) -> Result<Matrix3<f64>, SceneError> {
    let neutral = match options.balance {
        Balance::None => None,
        Balance::AsShot => Some(sensor.neutral.ok_or_else(|| {
            let mend =
                "leave the light its colour (none), or give a gray surface's values R,G,B in the camera's channels";
            SceneError::new(file, "states no white balance as shot", mend).at("--white-balance")
        })?),
        Balance::Neutral(values) => {
            let most = values.iter().fold(0.0, |a: f64, b| a.max(*b));
            Some(values.map(|value| value / most))
        }
    };
    let found = match (options.colour, neutral) {
        (Colour::Camera, None) => Some(Matrix3::identity()),
        (Colour::Camera, Some(neutral)) => {
            Some(Matrix3::from_diagonal(&Vector3::from(neutral.map(|value| 1.0 / value))))
        }
        (Colour::Rec709, None) => sensor.matrices.to_rec709(sensor.neutral),
        (Colour::Rec709, Some(neutral)) => sensor.matrices.balanced(neutral),
    };
    found.ok_or_else(|| {
        let mend = "develop it in the camera's own colours (--colour camera), and find the matrix by `gonio chart`";
        SceneError::new(file, "states no colour matrix, and none of its camera is known", mend).at("--colour")
    })
}

/// The file's noise after the matrix, for gray: the variance of a sum is the sum of squares times variances.
fn noise(sensor: &Sensor, matrix: &Matrix3<f64>) -> Option<[f64; 2]> {
    let own = sensor.noise?;
    let gray = Vector3::from(sensor.neutral.unwrap_or([1.0; 3]));
    let lit = matrix * gray;
    let sum = |of: &dyn Fn(usize, usize) -> f64| {
        (0..3).map(|row| (0..3).map(|c| matrix[(row, c)] * matrix[(row, c)] * of(row, c)).sum::<f64>()).sum::<f64>()
            / 3.0
    };
    let shot = sum(&|row, c| own[c][0] * gray[c] / lit[row].max(1e-6));
    let read = sum(&|_, c| own[c][1]);
    (shot.is_finite() && read.is_finite() && shot >= 0.0 && read >= 0.0).then_some([shot, read])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_raw_file_says_how_to_go_on() {
        for bytes in [&b""[..], b"II*\0", b"no photograph", &[0xff; 64]] {
            let error = develop("a.nef", bytes, Options::default()).unwrap_err().to_string();
            assert!(error.contains("a.nef") && error.contains("linear 16-bit TIFF"), "{error}");
        }
    }
}
