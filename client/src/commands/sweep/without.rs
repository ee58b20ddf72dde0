//! What an effect that a diagnosis found would be if it were not there.

use crate::failure::Failure;
use gonio_scene::{Capture, SceneError};
use serde::Deserialize;
use std::path::Path;

/// The part of a `diagnosis.json` that is needed here.
#[derive(Deserialize)]
struct Diagnosis {
    found: Vec<Finding>,
}

#[derive(Deserialize)]
struct Finding {
    effects: Vec<String>,
    parameters: Vec<Parameter>,
}

#[derive(Deserialize)]
struct Parameter {
    name: String,
    null: f64,
}

/// The numbers of the effects `without` at their nulls, those that `capture` has.
///
/// # Errors
/// No such file, no diagnosis, an effect that it did not find, or one of which the capture has no number.
pub(super) fn nulls(path: &Path, without: &[String], capture: &Capture) -> Result<Vec<(String, f64)>, Failure> {
    let shown = path.display().to_string();
    let refuse = |problem: String, mend: String| Failure::from(SceneError::new(&shown, problem, mend));
    let text = super::super::prepare::text(path)?;
    let diagnosis: Diagnosis = serde_json::from_str(&text).map_err(|error| {
        refuse(format!("is no diagnosis: {error}"), "name the diagnosis.json of `gonio diagnose`".to_owned())
    })?;
    let known = capture.numbers();
    let mut nulls = Vec::new();
    for effect in without {
        let Some(finding) = diagnosis.found.iter().find(|finding| finding.effects.contains(effect)) else {
            let found: Vec<&str> = diagnosis.found.iter().flat_map(|f| &f.effects).map(String::as_str).collect();
            let mend = format!("name one of those that it found: {}", found.join(", "));
            return Err(refuse(format!("did not find {effect}"), mend));
        };
        let here = finding.parameters.iter().filter(|parameter| known.contains_key(&parameter.name));
        let numbers: Vec<(String, f64)> = here.map(|parameter| (parameter.name.clone(), parameter.null)).collect();
        if numbers.is_empty() {
            let problem = format!("has {effect} in numbers that the sweep's capture does not have");
            return Err(refuse(problem, "sweep the capture.toml that the diagnosis wrote".to_owned()));
        }
        nulls.extend(numbers);
    }
    Ok(nulls)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FOUND: &str = r#"{"found": [
        {"effects": ["black-level"], "parameters": [{"name": "sensor.black_level", "value": 0.01, "null": 0.0}]},
        {"effects": ["ghost"], "parameters": [{"name": "light.ghost.intensity.r", "value": 0.01, "null": 0.0}]}]}"#;

    #[test]
    fn an_effect_is_taken_back_to_its_null() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("diagnosis.json");
        std::fs::write(&path, FOUND).unwrap();
        let of = |effect: &str| nulls(&path, &[effect.to_owned()], &Capture::default());
        assert_eq!(of("black-level").unwrap(), [("sensor.black_level".to_owned(), 0.0)]);
        assert!(of("vignetting").unwrap_err().to_string().contains("black-level, ghost"));
        assert!(of("ghost").unwrap_err().to_string().contains("does not have"));
        std::fs::write(&path, "{}").unwrap();
        assert!(of("ghost").unwrap_err().to_string().contains("no diagnosis"));
    }
}
