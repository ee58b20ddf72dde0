//! What names an evaluation beyond one stream and one coordinator.

use super::{Result, WireError};
use bytes::Bytes;

/// 16 random bytes: two evaluations have the same with a chance of 2^-128.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Key([u8; 16]);

impl Key {
    /// A key that nobody has had before.
    ///
    /// # Errors
    /// The machine has no source of random numbers.
    pub fn fresh() -> std::io::Result<Self> {
        let mut bytes = [0; 16];
        getrandom::fill(&mut bytes).map_err(|error| std::io::Error::other(error.to_string()))?;
        Ok(Self(bytes))
    }

    /// A key from a message's field; `None` where the field is empty.
    ///
    /// # Errors
    /// Neither no bytes nor 16.
    pub fn from_wire(field: &str, bytes: &[u8]) -> Result<Option<Self>> {
        match bytes.len() {
            0 => Ok(None),
            16 => Ok(bytes.try_into().ok().map(Self)),
            length => Err(WireError::new(field, format!("has {length} bytes, a key has 16"))),
        }
    }

    /// The bytes for a message's field.
    #[must_use]
    pub fn to_wire(self) -> Bytes {
        Bytes::copy_from_slice(&self.0)
    }
}

impl std::fmt::Display for Key {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl std::fmt::Debug for Key {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{self}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_survive_the_wire_and_nothing_else_does() {
        let key = Key::fresh().unwrap();
        assert_ne!(key, Key::fresh().unwrap());
        assert_eq!(Key::from_wire("f", &key.to_wire()), Ok(Some(key)));
        assert_eq!(Key::from_wire("f", b""), Ok(None));
        assert!(Key::from_wire("f", b"short").unwrap_err().to_string().contains("has 5 bytes"));
    }
}
