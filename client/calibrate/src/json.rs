//! Numbers out of JSON files, with errors that name the key.

use gonio_scene::{Result, SceneError};
use serde_json::Value;

/// The text of `file` as JSON.
pub(crate) fn parse(file: &str, text: &str) -> Result<Value> {
    serde_json::from_str(text)
        .map_err(|error| SceneError::new(file, format!("is no JSON: {error}"), "mend the syntax, or export it again"))
}

/// `count` finite numbers: a list, or lists in a list.
pub(crate) fn numbers<const N: usize>(file: &str, key: &str, value: &Value) -> Result<[f64; N]> {
    fn flat(value: &Value, out: &mut Vec<f64>) {
        match value {
            Value::Array(list) => list.iter().for_each(|entry| flat(entry, out)),
            other => out.push(other.as_f64().unwrap_or(f64::NAN)),
        }
    }
    let mut out = Vec::new();
    flat(value, &mut out);
    let whole = out.iter().all(|x| x.is_finite());
    <[f64; N]>::try_from(out).ok().filter(|_| whole).ok_or_else(|| {
        let problem = if value.is_null() { "is missing".to_owned() } else { format!("is no list of {N} numbers") };
        SceneError::new(file, problem, format!("write {N} finite numbers")).at(key)
    })
}
