//! Photos: what was measured, from where, and what for.

use super::camera::CameraOverride;
use super::object::{IDENTITY, determinant, turn};
use super::visit::{Numbers, RGB, Range, Section, Visitor, vector_or};
use crate::Result;

/// What a photo is used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Role {
    /// Fitted to.
    #[default]
    Fit,
    /// Never used for fitting or selecting, only for scoring.
    HeldOut,
}

/// One photograph.
#[derive(Debug, Clone, PartialEq)]
pub struct Photo {
    /// The image file's path, relative to the capture.
    pub file: String,
    /// The name, where files of several folders have the same one.
    pub label: Option<String>,
    /// The mask file's path; every pixel counts where there is none.
    pub mask: Option<String>,
    /// Factor from radiance to photo value.
    pub exposure: f64,
    /// Further factor of this photo alone, for a lamp or shutter that is not steady.
    pub gain: f64,
    /// Factors of this photo's red, green and blue light: a white balance that is not the other photos'.
    pub balance: [f64; 3],
    /// Maps camera coordinates (OpenCV) to world coordinates; rigid, row-major. See [`Photo::pose`].
    pub camera_to_world: [[f64; 4]; 4],
    /// How far the camera was moved from there, along its own axes, in metres.
    pub translation: [f64; 3],
    /// How far it was turned, a rotation vector about its own axes, in radians.
    pub rotation: [f64; 3],
    /// Keys of `[camera]` that this photo has otherwise.
    pub camera: CameraOverride,
    /// The names of the lights that were on; all of them where absent.
    pub lights: Option<Vec<String>>,
    /// What it is used for.
    pub role: Role,
}

impl Default for Photo {
    fn default() -> Self {
        Self {
            file: String::new(),
            label: None,
            mask: None,
            exposure: 1.0,
            gain: 1.0,
            balance: [1.0; 3],
            camera_to_world: IDENTITY,
            translation: [0.0; 3],
            rotation: [0.0; 3],
            camera: CameraOverride::default(),
            lights: None,
            role: Role::Fit,
        }
    }
}

impl Photo {
    /// The name in dotted parameter names and of output files: the label, or else the file's name without folder and
    /// extension.
    #[must_use]
    pub fn name(&self) -> &str {
        self.label.as_deref().unwrap_or_else(|| stem(&self.file))
    }

    /// Maps camera coordinates to world coordinates: `camera_to_world` times the camera's own move and turn. Rigid, row-major.
    #[must_use]
    pub fn pose(&self) -> [[f64; 4]; 4] {
        if self.translation == [0.0; 3] && self.rotation == [0.0; 3] {
            return self.camera_to_world;
        }
        let turn = turn(self.rotation);
        self.camera_to_world.map(|row| {
            let along = |values: [f64; 3]| row[0] * values[0] + row[1] * values[1] + row[2] * values[2];
            let column = |j: usize| along([turn[0][j], turn[1][j], turn[2][j]]);
            [column(0), column(1), column(2), along(self.translation) + row[3]]
        })
    }

    /// Factor from radiance to exposed light: exposure times gain.
    #[must_use]
    pub fn factor(&self) -> f64 {
        self.exposure * self.gain
    }
}

impl Section for Photo {
    fn describe(&mut self, v: &mut dyn Visitor) -> Result<()> {
        v.text("file", &mut self.file, None)?;
        v.optional_text("name", &mut self.label)?;
        if self.label.as_ref().is_some_and(|label| label.is_empty() || label.contains(['/', '\\'])) {
            let mend = "write letters, digits, - and _: files are named after it";
            return Err(v.refuse("name", "is empty or has a slash".to_owned(), mend));
        }
        v.optional_text("mask", &mut self.mask)?;
        v.number("exposure", &mut self.exposure, Range::POSITIVE, Some(1.0))?;
        v.number("gain", &mut self.gain, Range::POSITIVE, Some(1.0))?;
        let balance = Numbers {
            values: &mut self.balance,
            suffixes: &RGB,
            range: Range::POSITIVE,
            default: Some(&[1.0; 3]),
            may_end_early: false,
        };
        v.numbers("balance", balance)?;
        v.matrix("camera_to_world", &mut self.camera_to_world)?;
        if let Some(problem) = not_rigid(&self.camera_to_world) {
            return Err(v.refuse("camera_to_world", problem, "write a rotation and a translation, row-major"));
        }
        vector_or(v, "translation", &mut self.translation, &[0.0; 3])?;
        vector_or(v, "rotation", &mut self.rotation, &[0.0; 3])?;
        v.optional_texts("lights", &mut self.lights)?;
        role(v, &mut self.role)?;
        v.section("camera", &mut self.camera)
    }
}

/// A file's name without folder and extension.
pub(super) fn stem(path: &str) -> &str {
    let file = path.rsplit(['/', '\\']).next().unwrap_or(path);
    file.rsplit_once('.').map_or(file, |(stem, _)| if stem.is_empty() { file } else { stem })
}

/// The key `role`.
pub(super) fn role(v: &mut dyn Visitor, role: &mut Role) -> Result<()> {
    let mut word = if *role == Role::HeldOut { "held-out" } else { "fit" }.to_owned();
    v.text("role", &mut word, Some("fit"))?;
    *role = match word.as_str() {
        "fit" => Role::Fit,
        "held-out" => Role::HeldOut,
        _ => return Err(v.refuse("role", format!("is \"{word}\""), "write \"fit\" or \"held-out\"")),
    };
    Ok(())
}

/// Why a matrix is no rigid motion, with a tolerance for poses written with few digits.
fn not_rigid(m: &[[f64; 4]; 4]) -> Option<String> {
    for i in 0..3 {
        for j in i..3 {
            let dot: f64 = (0..3).map(|k| m[k][i] * m[k][j]).sum();
            let expected = if i == j { 1.0 } else { 0.0 };
            if (dot - expected).abs() > 2e-3 {
                return Some(format!("is no rotation: columns {i} and {j} have the product {dot:.4}, not {expected}"));
            }
        }
    }
    (determinant(m) < 0.0).then(|| "mirrors: its determinant is -1".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A camera at (1, 2, 3) that looks along x: its own axes are world's -y, -z, x.
    #[test]
    fn a_camera_moves_and_turns_along_its_own_axes() {
        let m = [[0.0, 0.0, 1.0, 1.0], [-1.0, 0.0, 0.0, 2.0], [0.0, -1.0, 0.0, 3.0], [0.0, 0.0, 0.0, 1.0]];
        let quarter = std::f64::consts::FRAC_PI_2;
        let photo = Photo {
            camera_to_world: m,
            translation: [0.1, 0.2, 0.3],
            rotation: [0.0, 0.0, quarter],
            ..Photo::default()
        };
        let pose = photo.pose();
        // A quarter about the own axis: its x points where its y did.
        let expected = [[0.0, 0.0, 1.0, 1.3], [0.0, 1.0, 0.0, 1.9], [-1.0, 0.0, 0.0, 2.8], [0.0, 0.0, 0.0, 1.0]];
        for (row, wanted) in pose.iter().zip(expected) {
            row.iter().zip(wanted).for_each(|(a, b)| assert!((a - b).abs() < 1e-12, "{pose:?}"));
        }
        assert_eq!(Photo { camera_to_world: m, ..Photo::default() }.pose(), m);
    }
}
