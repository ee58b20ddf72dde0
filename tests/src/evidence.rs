//! Stored diagnoses: what was learnt of captures whose causes are known, in `tests/evidence`, so that decisions are tried without a render.

use gonio_diagnose::evidence::Evidence;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Significant digits that are kept: no decision hangs on the sixth.
const DIGITS: i32 = 6;

/// What was learnt of one capture, and what is true of it.
#[derive(Debug, Serialize, Deserialize)]
pub struct Stored {
    /// Names of the hidden effects or of the suspect; none where nothing is hidden.
    pub expected: Vec<String>,
    /// The evidence.
    pub evidence: Evidence,
}

impl Stored {
    /// Writes it, with few digits.
    ///
    /// # Panics
    /// A disk that is full, a number that JSON cannot hold.
    pub fn write(&self, path: &Path) {
        let short = shortened(serde_json::to_value(self).unwrap());
        std::fs::write(path, serde_json::to_string(&short).unwrap()).unwrap();
    }
}

/// The library: file names without ending, and contents, in the order of names.
///
/// # Panics
/// A file that is none of this program's form.
#[must_use]
pub fn library() -> Vec<(String, Stored)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("evidence");
    let mut paths: Vec<PathBuf> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|e| e == "json"));
    paths.sort();
    let read = |path: PathBuf| {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let stored: Stored = serde_json::from_str(&std::fs::read_to_string(&path).unwrap())
            .unwrap_or_else(|error| panic!("{name}: {error}: make it again by the example `causes` or `confusion`"));
        stored.evidence.check().unwrap_or_else(|problem| panic!("{name}: {problem}"));
        (name, stored)
    };
    paths.into_iter().map(read).collect()
}

fn shortened(value: Value) -> Value {
    match value {
        Value::Number(number) if number.is_f64() => {
            let x = number.as_f64().unwrap_or_default();
            let scale = 10_f64.powi(DIGITS - 1 - if x == 0.0 { 0 } else { x.abs().log10().floor() as i32 });
            if scale.is_finite() && scale > 0.0 { Value::from((x * scale).round() / scale) } else { Value::from(x) }
        }
        Value::Array(all) => all.into_iter().map(shortened).collect(),
        Value::Object(all) => Value::Object(all.into_iter().map(|(key, value)| (key, shortened(value))).collect()),
        other => other,
    }
}
