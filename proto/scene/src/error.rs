//! The one error of this crate: which file, which key, what is wrong, how to mend it.

/// Bad data in a capture or in a file that it names, displayed as one line:
/// `capture.toml: material.shell.roughness: is 1.7, must lie in 0..=1; write a perceptual roughness (glTF) there`.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{file}: {}{problem}; {mend}", .key.as_ref().map(|key| format!("{key}: ")).unwrap_or_default())]
pub struct SceneError {
    /// The file at fault, as the capture names it.
    pub file: String,
    /// The place inside the file: a dotted key of `capture.toml`, an element of a mesh, a pixel of an image.
    pub key: Option<String>,
    /// What is wrong there, with the value found.
    pub problem: String,
    /// What to do about it, as an imperative.
    pub mend: String,
}

impl SceneError {
    /// An error about a whole file; add the place inside it with [`SceneError::at`].
    pub fn new(file: impl Into<String>, problem: impl Into<String>, mend: impl Into<String>) -> Self {
        Self { file: file.into(), key: None, problem: problem.into(), mend: mend.into() }
    }

    /// The same error, naming the key or element of the file that is at fault.
    #[must_use]
    pub fn at(mut self, key: impl Into<String>) -> Self {
        self.key = Some(key.into());
        self
    }
}

/// What everything in this crate that can fail returns.
pub type Result<T> = std::result::Result<T, SceneError>;

#[cfg(test)]
mod tests {
    use super::SceneError;

    #[test]
    fn is_displayed_as_one_line() {
        let error = SceneError::new("capture.toml", "is 1.7, must lie in 0..=1", "write a perceptual roughness there");
        assert_eq!(error.to_string(), "capture.toml: is 1.7, must lie in 0..=1; write a perceptual roughness there");
        assert_eq!(
            error.at("material.shell.roughness").to_string(),
            "capture.toml: material.shell.roughness: is 1.7, must lie in 0..=1; write a perceptual roughness there"
        );
    }
}
