//! A camera's response curve.

use gonio_scene::SceneError;
use gonio_scene::capture::{ResponseCurve, curve::CODES};

/// Entries of a curve: the codes of an 8-bit file.
pub const LEVELS: usize = CODES;

/// For every channel g(z) = ln(exposure) at code z = 255 * value (Debevec and Malik 1997, equation 2); 0 about code 128
/// where it was learnt, so that exposures are relative. Rises strictly.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// ln(exposure) at codes 0..=255 of red, green, blue.
    pub log_exposure: [Vec<f64>; 3],
}

impl Response {
    /// A curve of three tables, made to rise: neighbours that fall are replaced by their mean (pool adjacent violators).
    pub fn new(tables: [Vec<f64>; 3]) -> Self {
        Self { log_exposure: tables.map(|table| rising(&table)) }
    }

    /// ln(exposure) at a `value` 0..1 of a channel: linear between codes.
    pub fn log_exposure(&self, channel: usize, value: f32) -> f64 {
        let (k, part) = place(value);
        let table = &self.log_exposure[channel];
        table[k] + part * (table[k + 1] - table[k])
    }

    /// d ln(exposure) / d code at a `value` 0..1 of a channel, over two codes.
    pub fn slope(&self, channel: usize, value: f32) -> f64 {
        let (k, part) = place(value);
        let table = &self.log_exposure[channel];
        let k = (k + usize::from(part > 0.5)).clamp(1, LEVELS - 2);
        (0.5 * (table[k + 1] - table[k - 1])).max(1e-6)
    }

    /// The value 0..1 that an exposure of natural logarithm `log_exposure` gives; clamped to the curve's ends.
    pub fn value(&self, channel: usize, log_exposure: f64) -> f32 {
        let table = &self.log_exposure[channel];
        let k = table.partition_point(|&g| g < log_exposure);
        if k == 0 {
            return 0.0;
        }
        if k >= LEVELS {
            return 1.0;
        }
        let part = (log_exposure - table[k - 1]) / (table[k] - table[k - 1]).max(1e-12);
        ((k as f64 - 1.0 + part) / 255.0) as f32
    }

    /// Reads a curve that [`to_json`](Self::to_json) wrote; `file` is for messages.
    ///
    /// # Errors
    /// The text is no such curve, a table has not 256 entries, is not finite, or does not rise.
    pub fn from_json(file: &str, text: &str) -> Result<Self, SceneError> {
        Ok(Self { log_exposure: ResponseCurve::from_json(file, text)?.into_tables() })
    }

    /// The curve as JSON text, `{"log_exposure": [[256 numbers], ...]}`: what a capture's `response` reads, too.
    pub fn to_json(&self) -> String {
        serde_json::json!({ "log_exposure": self.log_exposure }).to_string()
    }
}

/// The code below `value` and the part of the way to the next.
pub(super) fn place(value: f32) -> (usize, f64) {
    let code = f64::from(value.clamp(0.0, 1.0)) * 255.0;
    let k = (code as usize).min(LEVELS - 2);
    (k, code - k as f64)
}

/// The nearest rising sequence in the least-squares sense, tilted by 1e-7 a step so that it can be inverted.
fn rising(table: &[f64]) -> Vec<f64> {
    let mut blocks: Vec<(f64, usize)> = Vec::new();
    for &value in table {
        let mut block = (value, 1);
        while let Some(&(mean, count)) = blocks.last()
            && mean >= block.0
        {
            blocks.pop();
            let total = count + block.1;
            block = ((mean * count as f64 + block.0 * block.1 as f64) / total as f64, total);
        }
        blocks.push(block);
    }
    let flat = blocks.iter().flat_map(|&(mean, count)| std::iter::repeat_n(mean, count));
    flat.enumerate().map(|(k, value)| value + 1e-7 * k as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_rises_inverts_and_survives_a_file() {
        let mut table: Vec<f64> = (0..LEVELS).map(|k| libm::log((k as f64 + 0.5) / 128.5)).collect();
        table.swap(100, 101);
        let curve = Response::new([table.clone(), table.clone(), table]);
        assert!(curve.log_exposure[0].windows(2).all(|pair| pair[1] > pair[0]));
        for value in [0.01_f32, 0.3, 0.77] {
            let back = curve.value(1, curve.log_exposure(1, value));
            assert!((back - value).abs() < 1e-5, "{back} {value}");
        }
        assert_eq!(Response::from_json("r.json", &curve.to_json()).as_ref(), Ok(&curve));
        let short = Response::from_json("r.json", r#"{"log_exposure":[[1.0],[2.0],[3.0]]}"#).map_err(|e| e.to_string());
        assert!(short.is_err_and(|text| text.contains("r.json") && text.contains("log_exposure")));
    }
}
