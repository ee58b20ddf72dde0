//! What a fit found, as numbers for another capture: its estimates, and points drawn from their uncertainty.

use crate::design_unit;
use crate::points::Points;
use gonio_scene::capture::Range;
use gonio_scene::files::Files;
use gonio_scene::{Capture, Result, SceneError};
use nalgebra::{DMatrix, DVector};
use serde::Deserialize;
use statrs::distribution::{ContinuousCDF, Normal};

/// A `fit.json`, or a `diagnosis.json`, whose last fit counts.
#[derive(Deserialize)]
#[serde(untagged)]
enum Written {
    Diagnosis { r#final: File },
    Fit(File),
}

/// The part of a fit that is needed here.
#[derive(Deserialize)]
struct File {
    parameters: Vec<Parameter>,
    correlations: Vec<Vec<f64>>,
}

#[derive(Deserialize)]
struct Parameter {
    name: String,
    value: f64,
    standard_error: Option<f64>,
}

/// The estimates that a capture has a place for.
pub(crate) struct Fitted {
    path: String,
    names: Vec<String>,
    values: Vec<f64>,
    ranges: Vec<Range>,
    /// `None` where the data said nothing about a number.
    errors: Vec<Option<f64>>,
    correlations: DMatrix<f64>,
}

impl Fitted {
    /// Reads the fit `path`, for `capture`.
    ///
    /// # Errors
    /// No such file, no fit, or one of which the capture has no number.
    pub fn read(path: &str, capture: &Capture, files: &dyn Files) -> Result<Self> {
        let written: Written = serde_json::from_slice(&files.read(path)?).map_err(|error| {
            let mend = "name the fit.json that `gonio fit` wrote, or the diagnosis.json of `gonio diagnose`";
            SceneError::new(path, format!("is no fit: {error}"), mend)
        })?;
        let (Written::Fit(file) | Written::Diagnosis { r#final: file }) = written;
        let known = capture.numbers();
        let kept: Vec<(usize, &Parameter, Range)> = file
            .parameters
            .iter()
            .enumerate()
            .filter_map(|(i, parameter)| known.get(&parameter.name).map(|(_, range)| (i, parameter, *range)))
            .collect();
        if kept.is_empty() {
            let names: Vec<&str> = file.parameters.iter().map(|parameter| parameter.name.as_str()).collect();
            let problem = format!("has estimates of {}, none of which is a number of the capture", names.join(", "));
            return Err(SceneError::new(path, problem, "give materials and lights the names that they had in the fit"));
        }
        let entry = |row: usize, column: usize| {
            let known = file.correlations.get(row).and_then(|list| list.get(column)).copied();
            known.unwrap_or(if row == column { 1.0 } else { 0.0 })
        };
        Ok(Self {
            path: path.to_owned(),
            names: kept.iter().map(|(_, parameter, _)| parameter.name.clone()).collect(),
            values: kept.iter().map(|(_, parameter, _)| parameter.value).collect(),
            ranges: kept.iter().map(|(_, _, range)| *range).collect(),
            errors: kept.iter().map(|(_, parameter, _)| parameter.standard_error).collect(),
            correlations: DMatrix::from_fn(kept.len(), kept.len(), |i, j| entry(kept[i].0, kept[j].0)),
        })
    }

    /// The estimates by name.
    pub fn numbers(&self) -> Vec<(String, f64)> {
        self.names.iter().cloned().zip(self.values.iter().copied()).collect()
    }

    /// `count` points from the normal distribution that the estimates, their standard errors and correlations describe,
    /// spread evenly by a Sobol sequence; what falls out of a number's range is moved to its end.
    ///
    /// # Errors
    /// A number of unknown error, or correlations that are none.
    pub fn draws(&self, count: u64, seed: u32) -> Result<Points> {
        let refuse = |key: &str, problem: &str, mend: &str| SceneError::new(&self.path, problem, mend).at(key);
        let mut scale = DVector::zeros(self.errors.len());
        for (i, error) in self.errors.iter().enumerate() {
            scale[i] = error.filter(|error| error.is_finite() && *error >= 0.0).ok_or_else(|| {
                let mend = "fit with data that determine it, or leave it out of the fit's parameters";
                refuse(&format!("parameters.{}.standard_error", self.names[i]), "is unknown", mend)
            })?;
        }
        // Correlations are rounded, so that near 1 the matrix may just miss being positive definite.
        let shrunk = self.correlations.clone() * (1.0 - 1e-9) + DMatrix::identity(scale.len(), scale.len()) * 1e-9;
        let root = shrunk.cholesky().ok_or_else(|| {
            refuse("correlations", "is no correlation matrix", "name the fit.json that `gonio fit` wrote")
        })?;
        let normal = Normal::standard();
        let row = |index: u64| {
            let units = (0..scale.len() as u32).map(|i| {
                let unit = design_unit(index, i, seed);
                // The sequence may have 0 itself.
                normal.inverse_cdf(unit.clamp(1e-9, 1.0 - 1e-9))
            });
            let moved = root.l() * DVector::from_iterator(scale.len(), units);
            let value = |i: usize| {
                let range = self.ranges[i];
                rounded((self.values[i] + scale[i] * moved[i]).clamp(range.min, range.max))
            };
            (0..scale.len()).map(value).collect()
        };
        Ok(Points { names: self.names.clone(), rows: (0..count).map(row).collect() })
    }
}

/// To twelve digits: a frame's name follows from the number, and the last bits of a logarithm differ between machines.
fn rounded(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use gonio_scene::files::MemoryFiles;
    use std::collections::BTreeMap;

    const FIT: &str = r#"{"parameters": [
        {"name": "light.led.intensity", "value": 2.0, "standard_error": 0.1},
        {"name": "sensor.read_noise", "value": 0.02, "standard_error": 0.001},
        {"name": "sensor.shot_noise", "value": 1e-4, "standard_error": 1e-3}],
        "correlations": [[1.0, 0.1, 0.2], [0.1, 1.0, -0.8], [0.2, -0.8, 1.0]]}"#;

    fn read(text: &str) -> Result<Fitted> {
        let files = MemoryFiles(BTreeMap::from([("fit.json".to_owned(), text.as_bytes().into())]));
        Fitted::read("fit.json", &Capture::default(), &files)
    }

    #[test]
    fn draws_have_the_moments_of_the_fit_and_stay_in_range() {
        let fitted = read(FIT).unwrap();
        // The capture has no lamp of that name.
        assert_eq!(fitted.numbers(), [("sensor.read_noise".to_owned(), 0.02), ("sensor.shot_noise".to_owned(), 1e-4)]);
        let points = fitted.draws(1024, 3).unwrap();
        let z: Vec<[f64; 2]> = points.rows.iter().map(|r| [(r[0] - 0.02) / 1e-3, (r[1] - 1e-4) / 1e-3]).collect();
        let mean = |of: &dyn Fn(&[f64; 2]) -> f64| z.iter().map(of).sum::<f64>() / 1024.0;
        assert!(mean(&|z| z[0]).abs() < 0.01);
        assert!((mean(&|z| z[0] * z[0]) - 1.0).abs() < 0.03);
        // Half of the other are at its bound 0, which takes part of the correlation away.
        assert!(points.rows.iter().all(|row| row[1] >= 0.0));
        assert!(mean(&|z| z[0] * z[1]) < -0.3);
        let again = read(&format!("{{\"verdict\": \"none\", \"final\": {FIT}}}")).unwrap();
        assert_eq!(points, again.draws(1024, 3).unwrap());
        assert_eq!(points.rows[..8], fitted.draws(8, 3).unwrap().rows[..]);
    }

    #[test]
    fn what_is_no_fit_or_says_nothing_is_refused() {
        let unknown = FIT.replace("0.001}", "null}");
        let error = read(&unknown).unwrap().draws(2, 0).err().unwrap();
        assert_eq!(error.key.as_deref(), Some("parameters.sensor.read_noise.standard_error"));
        assert!(read("{}").err().unwrap().to_string().contains("gonio fit"));
        let error = read(&FIT.replace("sensor.", "detector.")).err().unwrap();
        assert!(error.to_string().contains("detector.read_noise"), "{error}");
    }
}
