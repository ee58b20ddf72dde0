//! Files of measured reflectance: a table of direction pairs and BRDF values.
//!
//! Comma-separated text. The first line that is neither empty nor begins with `#` names the columns, in any order:
//! `theta_i`, `phi_i` (where light comes from), `theta_o`, `phi_o` (where it goes), all in radians, theta from the surface
//! normal, phi about it from the object's x axis; then `r`, `g`, `b`, the BRDF in 1/sr, without a cosine. In place of the
//! three, any number of wavelengths in nanometres may stand: the mean of those in 600..=700 is r, in 500..600 g, in
//! 400..500 b.

mod table;

use crate::capture::Reflectance;
use crate::files::Files;
use crate::film::TILE;
use crate::image::Image;
use crate::{MAX_SIDE, Result, SceneError};
use table::Table;

/// A direction of incidence and one of reflection: unit vectors away from the surface, z along its normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// Where light comes from.
    pub incident: [f64; 3],
    /// Where it goes.
    pub outgoing: [f64; 3],
}

impl Pair {
    /// Of angles in radians: theta and phi of incidence, then of reflection.
    #[must_use]
    pub fn of_angles([theta_i, phi_i, theta_o, phi_o]: [f64; 4]) -> Self {
        let unit = |theta: f64, phi: f64| {
            let ((s, c), (sp, cp)) = (libm::sincos(theta), libm::sincos(phi));
            [s * cp, s * sp, c]
        };
        Self { incident: unit(theta_i, phi_i), outgoing: unit(theta_o, phi_o) }
    }

    /// The angle between the normal and the half vector, radians.
    #[must_use]
    pub fn half_angle(&self) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|i| self.incident[i] + self.outgoing[i]);
        libm::atan2(libm::sqrt(x * x + y * y), z)
    }
}

/// The direction pairs of a file, which are all that a renderer knows of it: no value is read.
///
/// As a film, the samples are pixels, row by row, [`TILE`] to the row; what is left of the last row does not count.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Directions {
    /// In the file's order.
    pub pairs: Vec<Pair>,
}

impl Directions {
    /// Reads the direction pairs of the file `path`.
    ///
    /// # Errors
    /// The file cannot be read, lacks a column, has no row or too many, or a direction at or below the horizon.
    pub fn read(files: &dyn Files, path: &str) -> Result<Self> {
        let bytes = files.read(path)?;
        let table = Table::new(path, &bytes)?;
        table.rows().map(|row| row.pair()).collect::<Result<_>>().map(|pairs| Self { pairs })
    }

    /// The pair of the pixel in column `x` and row `y`.
    #[must_use]
    pub fn at(&self, x: u32, y: u32) -> Option<&Pair> {
        self.pairs.get(y as usize * TILE as usize + x as usize)
    }

    /// Width and height of the film.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        size(self.pairs.len())
    }
}

/// The samples of a file as an image, and which of its pixels are samples.
///
/// # Errors
/// As [`Directions::read`]; a value that is no finite number.
pub fn read(files: &dyn Files, reflectance: &Reflectance) -> Result<(Image, Vec<bool>)> {
    let bytes = files.read(&reflectance.file)?;
    let table = Table::new(&reflectance.file, &bytes)?;
    // A file whose directions are broken cannot be rendered: say so here, too.
    let mut pixels = table.rows().map(|row| row.pair().and_then(|_| row.value())).collect::<Result<Vec<_>>>()?;
    let samples = pixels.len();
    let (width, height) = size(samples);
    pixels.resize(width as usize * height as usize, [0.0; 3]);
    let counts = (0..pixels.len()).map(|i| i < samples).collect();
    Ok((Image { width, height, pixels }, counts))
}

#[allow(clippy::cast_possible_truncation)] // A table has no more rows than fit.
fn size(samples: usize) -> (u32, u32) {
    (TILE, samples.div_ceil(TILE as usize) as u32)
}

/// Most samples of a file.
const MOST: usize = TILE as usize * MAX_SIDE as usize;

fn refuse(file: &str, problem: impl Into<String>, mend: &str) -> SceneError {
    SceneError::new(file, problem, mend)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::MemoryFiles;

    const GOOD: &str =
        "# measured today\nphi_i, theta_i,theta_o,phi_o,g,r,b\n\n0,0.5,0.25,3.5,0.2,0.1,-0.3\n0,0,0,0,2,1,3\n";

    fn files(text: &str) -> MemoryFiles {
        MemoryFiles([("s.csv".to_owned(), text.as_bytes().into())].into())
    }

    fn values(text: &str) -> Result<(Image, Vec<bool>)> {
        read(&files(text), &Reflectance { file: "s.csv".into(), ..Reflectance::default() })
    }

    #[test]
    fn samples_are_pixels_and_columns_go_by_their_names() {
        let (image, counts) = values(GOOD).unwrap();
        assert_eq!((image.width, image.height, counts.iter().filter(|c| **c).count()), (TILE, 1, 2));
        assert_eq!(image.pixels[..3], [[0.1, 0.2, -0.3], [1.0, 2.0, 3.0], [0.0; 3]]);
        let directions = Directions::read(&files(GOOD), "s.csv").unwrap();
        assert_eq!((directions.size(), directions.pairs.len()), ((TILE, 1), 2));
        let Pair { incident, outgoing } = directions.at(0, 0).unwrap();
        let close = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).for_each(|(a, b)| assert!((a - b).abs() < 1e-15));
        close(*incident, [libm::sin(0.5), 0.0, libm::cos(0.5)]);
        close(*outgoing, [libm::sin(0.25) * libm::cos(3.5), libm::sin(0.25) * libm::sin(3.5), libm::cos(0.25)]);
        assert_eq!((directions.at(2, 0), directions.at(0, 1)), (None, None));
        let mirror = Pair::of_angles([0.6, 0.0, 0.6, std::f64::consts::PI]);
        assert!(mirror.half_angle() < 1e-15);
        assert!((Pair::of_angles([0.6, 1.0, 0.2, 1.0]).half_angle() - 0.4).abs() < 1e-15);
    }

    #[test]
    fn spectra_become_band_means() {
        let text = "theta_i,phi_i,theta_o,phi_o,400,490,500,550,599,600,700\n0,0,0,0,1,3,2,3,7,5,6\n";
        assert_eq!(values(text).unwrap().0.pixels[0], [5.5, 4.0, 2.0]);
    }

    #[test]
    fn a_renderer_reads_no_value() {
        let text = "theta_i,phi_i,theta_o,phi_o,r,g,b\n0,0,0,0,secret,NaN,\n";
        assert_eq!(Directions::read(&files(text), "s.csv").unwrap().pairs.len(), 1);
        assert!(values(text).unwrap_err().to_string().starts_with("s.csv: line 2: r is \"secret\""));
    }

    #[test]
    fn broken_files_are_refused_by_line() {
        let refused = |from: &str, to: &str, expected: &str| {
            assert!(GOOD.contains(from));
            let error = values(&GOOD.replacen(from, to, 1)).unwrap_err().to_string();
            assert!(error.starts_with("s.csv: ") && error.contains(expected), "{error}");
        };
        refused("0.25", "1.5708", "line 4: theta_o is 1.5708: the direction is not above the horizon");
        refused("0,0.5", "0,-0.5", "line 4: theta_i is -0.5");
        refused("3.5", "NaN", "line 4: phi_o is \"NaN\"");
        refused("2,1,3", "2,inf,3", "line 5: r is \"inf\"");
        refused("2,1,3", "2,1e39,3", "line 5: r is too large");
        refused("2,1,3", "2,1", "line 5: has 6 columns, the header 7");
        refused("phi_o", "phi", "line 2: names the column \"phi\"");
        refused(",g,r", ",r,r", "names the column r twice");
        refused(",g,r", ",450,r", "both r, g, b and wavelengths");
        refused("g,r,b", "420,450,650", "names no column g");
        refused(",phi_o", ",600", "names no column phi_o");
        for (text, expected) in [("# nothing\n", "is empty"), ("theta_i,phi_i,theta_o,phi_o,r,g,b\n", "has 0 samples")]
        {
            assert!(values(text).unwrap_err().to_string().contains(expected));
        }
        let error = read(
            &MemoryFiles([("s.csv".to_owned(), [0xff, 0xfe][..].into())].into()),
            &Reflectance { file: "s.csv".into(), ..Reflectance::default() },
        );
        assert!(error.unwrap_err().to_string().contains("UTF-8"));
    }
}
