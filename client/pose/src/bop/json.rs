//! JSON files whose errors name the file.

use gonio_scene::files::Files;
use gonio_scene::{Result, SceneError};
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;

/// Reads the JSON file `path`.
pub(super) fn read<T: DeserializeOwned>(files: &dyn Files, path: &str) -> Result<T> {
    parse(path, &files.read(path)?)
}

/// Reads `bytes`, the content of `path`.
pub(super) fn parse<T: DeserializeOwned>(path: &str, bytes: &[u8]) -> Result<T> {
    serde_json::from_slice(bytes).map_err(|error| {
        let problem = format!("is not what BOP's format says: {error}");
        SceneError::new(path, problem, "correct the entry there, or export the dataset again")
    })
}

/// The entries of a file whose keys are numbers: of images or objects.
pub(super) fn numbered<T>(path: &str, entries: BTreeMap<String, T>) -> Result<BTreeMap<u32, T>> {
    let number = |(key, entry): (String, T)| match key.parse() {
        Ok(number) => Ok((number, entry)),
        Err(_) => Err(SceneError::new(path, "is no number of an image or object", "write a whole number").at(key)),
    };
    entries.into_iter().map(number).collect()
}
