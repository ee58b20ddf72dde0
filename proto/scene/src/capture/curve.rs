//! A response that was measured: `response = "map.response.json"`.

use super::visit::{Section, Visitor};
use crate::files::Files;
use crate::{Result, SceneError};
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

/// Entries of a channel's table: the codes of an 8-bit file.
pub const CODES: usize = 256;

const CHANNELS: [&str; 3] = ["red", "green", "blue"];

/// For every channel g(z) = ln(exposed light) at code z = 255 * value (Debevec and Malik, "Recovering high dynamic range
/// radiance maps from photographs", SIGGRAPH 1997, equation 2). Every table has 256 finite numbers that rise strictly.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResponseCurve {
    log_exposure: [Vec<f64>; 3],
}

/// The neutral curve that a description begins with: a value is the logarithm's share of five e-folds.
impl Default for ResponseCurve {
    fn default() -> Self {
        let table: Vec<f64> = (0..CODES as u32).map(|code| (f64::from(code) - 128.0) / 51.0).collect();
        Self { log_exposure: [table.clone(), table.clone(), table] }
    }
}

impl ResponseCurve {
    /// A curve of ln(exposed light) at codes 0..=255 of red, green, blue.
    ///
    /// # Errors
    /// Which table is not 256 finite numbers that rise, and where; in words.
    pub fn new(log_exposure: [Vec<f64>; 3]) -> std::result::Result<Self, String> {
        let curve = Self { log_exposure };
        curve.check().map_err(|(name, problem)| format!("{name} {problem}"))?;
        Ok(curve)
    }

    /// ln(exposed light) at codes 0..=255 of red, green, blue.
    #[must_use]
    pub fn tables(&self) -> &[Vec<f64>; 3] {
        &self.log_exposure
    }

    /// As [`ResponseCurve::tables`].
    #[must_use]
    pub fn into_tables(self) -> [Vec<f64>; 3] {
        self.log_exposure
    }

    /// The file's value 0..=1 for exposed light `x` in a channel (0..=2), and its slope there: linear in ln(x) between
    /// codes, 0 below and 1 above the curve, where the slope is 0.
    #[must_use]
    pub fn apply(&self, channel: usize, x: f64) -> (f64, f64) {
        let table = &self.log_exposure[channel];
        if x.is_nan() || x <= 0.0 {
            return (0.0, 0.0);
        }
        let log = libm::log(x);
        let above = table.partition_point(|&g| g < log);
        if above == 0 || above >= table.len() {
            return (if above == 0 { 0.0 } else { 1.0 }, 0.0);
        }
        let (low, high) = (table[above - 1], table[above]);
        let codes = (CODES - 1) as f64;
        (((above - 1) as f64 + (log - low) / (high - low)) / codes, 1.0 / (codes * (high - low) * x))
    }

    /// Reads a curve's file: `{"log_exposure": [[256 numbers], [256 numbers], [256 numbers]]}`, as `gonio hdr` writes it;
    /// `file` is for messages.
    ///
    /// # Errors
    /// Another text or key, a table that has not 256 entries or does not rise.
    pub fn from_json(file: &str, text: &str) -> Result<Self> {
        let mend = "name a .response.json that `gonio hdr` wrote";
        let curve: Self = serde_json::from_str(text)
            .map_err(|error| SceneError::new(file, format!("is no response curve: {error}"), mend))?;
        let refuse = |(name, problem): (&str, String)| {
            SceneError::new(file, format!("{name} {problem}"), mend).at("log_exposure")
        };
        curve.check().map_err(refuse)?;
        Ok(curve)
    }

    /// The curve as the text that [`ResponseCurve::from_json`] reads.
    #[must_use]
    pub fn to_json(&self) -> String {
        serde_json::json!(self).to_string()
    }

    fn check(&self) -> std::result::Result<(), (&'static str, String)> {
        for (table, name) in self.log_exposure.iter().zip(CHANNELS) {
            if table.len() != CODES {
                return Err((name, format!("has {} numbers, not {CODES}", table.len())));
            }
            if let Some(code) = table.iter().position(|g| !g.is_finite()) {
                return Err((name, format!("is {} at code {code}", table[code])));
            }
            if let Some(code) = table.windows(2).position(|pair| pair[1] <= pair[0]) {
                let problem =
                    format!("does not rise from code {code} to {}: {} to {}", code + 1, table[code], table[code + 1]);
                return Err((name, problem));
            }
        }
        Ok(())
    }
}

impl Section for ResponseCurve {
    fn describe(&mut self, v: &mut dyn Visitor) -> Result<()> {
        for (table, name) in self.log_exposure.iter_mut().zip(CHANNELS) {
            v.table(name, table)?;
        }
        let mend = "write 256 numbers that rise, ln(exposed light) at codes 0 to 255, or name the file as `response`";
        self.check().map_err(|(name, problem)| v.refuse(name, problem, mend))
    }
}

/// Puts the curve in place of the file that `[sensor]` names: what follows sees one form, and it travels with the text.
pub(super) fn inline(file: &str, top: &mut Table, files: &dyn Files) -> Result<()> {
    let Some(sensor) = top.get_mut("sensor").and_then(Value::as_table_mut) else { return Ok(()) };
    let named = sensor.get("response").and_then(Value::as_str).filter(|word| word.to_lowercase().ends_with(".json"));
    let Some(path) = named.map(str::to_owned) else { return Ok(()) };
    if sensor.contains_key("curve") {
        let problem = format!("is there beside response = \"{path}\"");
        return Err(SceneError::new(file, problem, "keep one of the two").at("sensor.curve"));
    }
    let bytes = files.read(&path).map_err(|error| error.at("sensor.response"))?;
    let text = std::str::from_utf8(&bytes).map_err(|error| {
        SceneError::new(&path, format!("is not UTF-8 text ({error})"), "name a .response.json that `gonio hdr` wrote")
            .at("sensor.response")
    })?;
    let mut curve = ResponseCurve::from_json(&path, text)?;
    sensor.insert("response".into(), Value::String("curve".into()));
    sensor.insert("curve".into(), Value::Table(super::write::write(&mut curve)?));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Capture;
    use crate::capture::{CAPTURE_FILE, Response};
    use crate::files::MemoryFiles;
    use std::sync::Arc;

    const TOML: &str = "format = 1\nname = \"x\"\n\
        [camera]\nwidth = 4\nheight = 4\nfx = 4.0\nfy = 4.0\ncx = 2.0\ncy = 2.0\n\
        [sensor]\nresponse = \"maps/a.response.json\"\n\
        [[photo]]\nfile = \"a.png\"\ncamera_to_world = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n";

    /// ln of a power law, of another exponent in every channel.
    fn curve() -> ResponseCurve {
        let table = |power: f64| (0..CODES).map(|z| power * libm::log((z as f64 + 0.5) / 128.5)).collect();
        ResponseCurve::new([table(2.2), table(1.8), table(2.0)]).unwrap()
    }

    fn read(json: Option<&str>) -> Result<Capture> {
        let mut files = MemoryFiles::default();
        files.0.insert(CAPTURE_FILE.into(), Arc::from(TOML.as_bytes()));
        if let Some(json) = json {
            files.0.insert("maps/a.response.json".into(), Arc::from(json.as_bytes()));
        }
        Capture::read(&files)
    }

    #[test]
    fn a_value_at_a_code_is_the_code_and_the_slope_is_its_derivative() {
        let curve = curve();
        for (channel, power) in [2.2, 1.8, 2.0].into_iter().enumerate() {
            for z in [0, 1, 20, 128, 254, 255] {
                let (value, _) = curve.apply(channel, libm::exp(curve.tables()[channel][z]));
                assert!((value * 255.0 - z as f64).abs() < 1e-9, "{channel} {z}: {value}");
            }
            let x = libm::pow(0.3, power);
            let (low, high) = (curve.apply(channel, x * (1.0 - 1e-6)).0, curve.apply(channel, x * (1.0 + 1e-6)).0);
            let slope = curve.apply(channel, x).1;
            assert!(((high - low) / (2e-6 * x) / slope - 1.0).abs() < 1e-6, "{channel}: {slope}");
        }
        // Black, less than black, and more than the file holds.
        for (x, value) in [(0.0, 0.0), (-1.0, 0.0), (1e-9, 0.0), (1e9, 1.0), (f64::INFINITY, 1.0), (f64::NAN, 0.0)] {
            assert_eq!(curve.apply(0, x), (value, 0.0), "{x}");
        }
    }

    #[test]
    fn a_file_becomes_part_of_the_capture_and_of_its_text() {
        let capture = read(Some(&curve().to_json())).unwrap();
        assert_eq!(capture.sensor.response, Response::Curve(Arc::new(curve())));
        let text = capture.to_toml().unwrap();
        assert_eq!(Capture::parse(&text).unwrap(), capture);
        // Its numbers are no parameters.
        let mut names = Vec::new();
        capture.clone().for_each_number(&mut |name, _, _| names.push(name.to_owned())).unwrap();
        assert!(names.iter().any(|name| name == "sensor.gamma") && names.iter().all(|name| !name.contains("curve")));
        // Without its files a text says nothing of a curve.
        let error = Capture::parse(TOML).unwrap_err().to_string();
        assert!(error.contains("sensor.response") && error.contains("maps/a.response.json"), "{error}");
    }

    #[test]
    fn broken_curves_are_refused_by_file_key_and_mend() {
        let good = curve().to_json();
        let falling =
            serde_json::json!({ "log_exposure": [vec![0.5; 256], vec![0.5; 256], vec![0.5; 256]] }).to_string();
        let cut: Vec<f64> = curve().tables()[0][..255].to_vec();
        let cut = serde_json::json!({ "log_exposure": [cut, curve().tables()[1], curve().tables()[2]] }).to_string();
        for (json, says) in [
            (None, "maps/a.response.json: sensor.response: "),
            (Some("{"), "maps/a.response.json: is no response curve"),
            (Some(r#"{"log_exposure": [[1.0], [2.0]]}"#), "is no response curve: invalid length 2"),
            (Some(falling.as_str()), "log_exposure: red does not rise from code 0 to 1"),
            (Some(cut.as_str()), "log_exposure: red has 255 numbers, not 256"),
            (Some(good.replacen('{', "{\"gamma\": 2, ", 1).as_str()), "unknown field `gamma`"),
            (Some(good.replacen("[[", "[[NaN,", 1).as_str()), "is no response curve"),
            (Some(good.replacen("[[", "[[null,", 1).as_str()), "is no response curve"),
            (Some(good.replacen("[[", "[[1e999,", 1).as_str()), "is no response curve"),
        ] {
            let error = read(json).unwrap_err().to_string();
            assert!(error.contains(says) && error.contains("maps/a.response.json"), "{says}: {error}");
            assert!(json.is_none() || error.contains("gonio hdr"), "{error}");
        }
        let mut tables = curve().into_tables();
        tables[2][7] = f64::NAN;
        assert_eq!(ResponseCurve::new(tables).unwrap_err(), "blue is NaN at code 7");
    }
}
