//! Numbers out of JSON files, with errors that name the key.

use gonio_scene::{Result, SceneError};
use serde_json::Value;

/// The text of `file` as JSON. Python's `NaN` and `Infinity`, which JSON lacks, are null: only who needs such a number
/// refuses it.
pub(crate) fn parse(file: &str, text: &str) -> Result<Value> {
    let text = text.trim_start_matches('\u{feff}');
    serde_json::from_str(text)
        .or_else(|_| serde_json::from_str(&without_nan(text)))
        .map_err(|error| SceneError::new(file, format!("is no JSON: {error}"), "mend the syntax, or export it again"))
}

fn without_nan(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let (mut quoted, mut escaped) = (false, false);
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let word = ["-Infinity", "Infinity", "-NaN", "NaN"].into_iter().find(|word| !quoted && rest.starts_with(word));
        let length = word.map_or(first.len_utf8(), str::len);
        match word {
            Some(_) => out.push_str("null"),
            None => out.push(first),
        }
        quoted ^= first == '"' && !escaped;
        escaped = first == '\\' && quoted && !escaped;
        rest = rest.get(length..).unwrap_or_default();
    }
    out
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pythons_numbers_are_null_outside_of_texts() {
        let text = r#"{"a": NaN, "b\"NaN": [-Infinity, 1], "c": "NaN \\", "d": Infinity}"#;
        let expected = serde_json::json!({"a": null, "b\"NaN": [null, 1], "c": "NaN \\", "d": null});
        assert_eq!(parse("t.json", text).unwrap(), expected);
        assert!(parse("t.json", "{\"a\": Nan}").unwrap_err().to_string().contains("line 1 column"));
    }
}
