//! The table of a reflectance file, as text.

use super::{MOST, Pair, refuse};
use crate::Result;
use std::f64::consts::FRAC_PI_2;

const ANGLES: [&str; 4] = ["theta_i", "phi_i", "theta_o", "phi_o"];
const CHANNELS: [&str; 3] = ["r", "g", "b"];
/// Wavelengths of each channel in nanometres; the upper end belongs to the next, but red's.
const BANDS: [(f64, f64); 3] = [(600.0, 700.0), (500.0, 600.0), (400.0, 500.0)];

/// The lines of a file and what their columns mean.
pub(super) struct Table<'a> {
    path: &'a str,
    /// The columns of the four angles.
    angles: [usize; 4],
    /// The columns whose mean is a channel.
    channels: [Vec<usize>; 3],
    columns: usize,
    /// Line number and text.
    lines: Vec<(usize, &'a str)>,
}

/// One sample.
pub(super) struct Row<'a> {
    table: &'a Table<'a>,
    line: usize,
    text: &'a str,
}

impl<'a> Table<'a> {
    /// # Errors
    /// No text, a header that is not as it must be, no rows or too many.
    pub(super) fn new(path: &'a str, bytes: &'a [u8]) -> Result<Self> {
        let text = std::str::from_utf8(bytes)
            .map_err(|error| refuse(path, format!("is not UTF-8 text ({error})"), "save it as UTF-8"))?;
        let filled = |(_, line): &(usize, &str)| !line.trim().is_empty() && !line.trim_start().starts_with('#');
        let mut lines = text.lines().enumerate().map(|(i, line)| (i + 1, line)).filter(filled);
        let header = "write theta_i,phi_i,theta_o,phi_o,r,g,b, or wavelengths in place of r,g,b";
        let (number, first) = lines.next().ok_or_else(|| refuse(path, "is empty", header))?;
        let names: Vec<&str> = first.trim_start_matches('\u{feff}').split(',').map(str::trim).collect();
        let at = |problem: String, mend: &str| refuse(path, problem, mend).at(format!("line {number}"));
        let mut angles = [None; 4];
        let mut rgb = [None; 3];
        let mut bands = [const { Vec::new() }; 3];
        for (column, name) in names.iter().enumerate() {
            let seen = if let Some(i) = ANGLES.iter().position(|n| n == name) {
                angles[i].replace(column)
            } else if let Some(i) = CHANNELS.iter().position(|n| n == name) {
                rgb[i].replace(column)
            } else if let Some(i) = name.parse().ok().and_then(band) {
                bands[i].push(column);
                None
            } else {
                return Err(at(format!("names the column \"{name}\", which is none of this format"), header));
            };
            if seen.is_some() {
                return Err(at(format!("names the column {name} twice"), "keep one"));
            }
        }
        let missing = |name: &str| at(format!("names no column {name}"), header);
        let mut found = [0; 4];
        for ((found, column), name) in found.iter_mut().zip(angles).zip(ANGLES) {
            *found = column.ok_or_else(|| missing(name))?;
        }
        if rgb.iter().any(Option::is_some) {
            if bands.iter().any(|b| !b.is_empty()) {
                return Err(at("names both r, g, b and wavelengths".to_owned(), "keep one of the two"));
            }
            for ((band, column), name) in bands.iter_mut().zip(rgb).zip(CHANNELS) {
                band.push(column.ok_or_else(|| missing(name))?);
            }
        }
        if let Some((_, name)) = bands.iter().zip(CHANNELS).find(|(band, _)| band.is_empty()) {
            return Err(missing(&format!("{name}, nor a wavelength of it")));
        }
        let lines: Vec<_> = lines.collect();
        if lines.is_empty() || lines.len() > MOST {
            return Err(refuse(path, format!("has {} samples", lines.len()), &format!("write 1 to {MOST} of them")));
        }
        Ok(Self { path, angles: found, channels: bands, columns: names.len(), lines })
    }

    pub(super) fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.lines.iter().map(|(line, text)| Row { table: self, line: *line, text })
    }
}

impl Row<'_> {
    /// The directions.
    pub(super) fn pair(&self) -> Result<Pair> {
        let cells = self.cells()?;
        let mut angles = [0.0; 4];
        for (i, angle) in angles.iter_mut().enumerate() {
            *angle = self.number(cells[self.table.angles[i]], ANGLES[i])?;
            if i % 2 == 0 && !(0.0..FRAC_PI_2).contains(angle) {
                let problem = format!("{} is {angle}: the direction is not above the horizon", ANGLES[i]);
                return Err(self.refuse(problem, "write radians from the normal, 0 to below 1.5708, or remove the row"));
            }
        }
        Ok(Pair::of_angles(angles))
    }

    /// The BRDF per channel.
    #[allow(clippy::cast_possible_truncation, clippy::cast_precision_loss)]
    pub(super) fn value(&self) -> Result<[f32; 3]> {
        let cells = self.cells()?;
        let mut value = [0.0; 3];
        for ((value, columns), name) in value.iter_mut().zip(&self.table.channels).zip(CHANNELS) {
            let mut sum = 0.0;
            for column in columns {
                sum += self.number(cells[*column], name)?;
            }
            *value = (sum / columns.len() as f64) as f32;
            if !value.is_finite() {
                return Err(self.refuse(format!("{name} is too large"), "write the BRDF in 1/sr, or remove the row"));
            }
        }
        Ok(value)
    }

    fn cells(&self) -> Result<Vec<&str>> {
        let cells: Vec<&str> = self.text.split(',').map(str::trim).collect();
        if cells.len() != self.table.columns {
            let problem = format!("has {} columns, the header {}", cells.len(), self.table.columns);
            return Err(self.refuse(problem, "write one number for each column"));
        }
        Ok(cells)
    }

    fn number(&self, cell: &str, name: &str) -> Result<f64> {
        let number = cell.parse().ok().filter(|v: &f64| v.is_finite());
        number.ok_or_else(|| {
            self.refuse(format!("{name} is \"{cell}\", which is no finite number"), "mend the row or remove it")
        })
    }

    fn refuse(&self, problem: String, mend: &str) -> crate::SceneError {
        refuse(self.table.path, problem, mend).at(format!("line {}", self.line))
    }
}

/// The channel of a wavelength.
fn band(wavelength: f64) -> Option<usize> {
    BANDS.iter().position(|(from, to)| wavelength >= *from && (wavelength < *to || wavelength == 700.0 && *to == 700.0))
}
