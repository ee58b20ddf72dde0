//! Conversions between messages and domain types. Every conversion from a message validates: lengths, ranges, finite
//! numbers, and counts before anything of that count is allocated.

pub mod design;
pub mod digest;
pub mod event;
pub mod film;
pub mod job;
pub mod key;
pub mod manifest;
pub mod reduced;
pub mod request;
pub mod task;

pub use digest::Digest;
pub use key::Key;

use crate::limits;

/// A message that breaks the protocol, or its limits.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{field}: {problem}")]
pub struct WireError {
    /// The message and field, such as `EvaluationRequest.samples`.
    pub field: String,
    /// What is wrong there, with the value found.
    pub problem: String,
}

impl WireError {
    /// An error about one field.
    pub fn new(field: impl Into<String>, problem: impl Into<String>) -> Self {
        Self { field: field.into(), problem: problem.into() }
    }
}

impl From<WireError> for tonic::Status {
    fn from(error: WireError) -> Self {
        Self::invalid_argument(error.to_string())
    }
}

/// What every conversion from a message returns.
pub type Result<T> = std::result::Result<T, WireError>;

/// A message field that protobuf leaves optional and this protocol does not.
pub(crate) fn required<T>(field: &str, value: Option<T>) -> Result<T> {
    value.ok_or_else(|| WireError::new(field, "is absent"))
}

pub(crate) fn finite(field: &str, value: f64) -> Result<f64> {
    if value.is_finite() { Ok(value) } else { Err(WireError::new(field, format!("is {value}, must be finite"))) }
}

pub(crate) fn finite_and_not_negative(field: &str, value: f64) -> Result<f64> {
    if finite(field, value)? < 0.0 {
        return Err(WireError::new(field, format!("is {value}, must not be negative")));
    }
    Ok(value)
}

pub(crate) fn at_most(field: &str, count: usize, limit: usize) -> Result<()> {
    if count > limit {
        return Err(WireError::new(field, format!("has {count} entries, the limit is {limit}")));
    }
    Ok(())
}

/// A name that is neither empty nor longer than `limit` bytes.
pub(crate) fn named(field: &str, value: String, limit: usize) -> Result<String> {
    if value.is_empty() || value.len() > limit {
        return Err(WireError::new(field, format!("has {} bytes, must have 1 to {limit}", value.len())));
    }
    Ok(value)
}

/// A text for people, cut where it is too long, and without control characters: it ends up in logs and terminals.
#[must_use]
pub fn text(value: &str) -> String {
    let mut end = value.len().min(limits::TEXT_BYTES);
    while !value.is_char_boundary(end) {
        end -= 1;
    }
    value[..end].chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_cut_between_characters_and_cleaned() {
        let long = format!("a\x1b[31m{}", "é".repeat(limits::TEXT_BYTES));
        let cut = text(&long);
        assert!(cut.len() <= limits::TEXT_BYTES && cut.starts_with("a [31mé"));
    }
}
