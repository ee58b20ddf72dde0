//! The last line of defence around other people's decoders.

use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::error::{Result, SceneError};

/// Runs a third-party decoder over the bytes of `file`; should it panic on bytes that nobody foresaw, that is an error
/// of the file and not the end of a worker that holds other people's tasks.
///
/// # Errors
/// What `decode` returns, or that it panicked.
pub fn shielded<T>(file: &str, decode: impl FnOnce() -> Result<T>) -> Result<T> {
    // Unwind safe: a decoder owns all that it changes, and what it had built is dropped.
    catch_unwind(AssertUnwindSafe(decode)).unwrap_or_else(|_| {
        Err(SceneError::new(file, "is damaged in a way its decoder cannot name", "export or save the file again"))
    })
}

/// Decoders quote what they could not read, which may be the whole file: at most this many characters of it.
const LONGEST: usize = 200;

/// The message of a decoder's error on one line, without the final stop.
pub(crate) fn one_line(error: &dyn std::fmt::Display) -> String {
    let text = error.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
    let text = text.trim_end_matches('.');
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => text.get(..end).unwrap_or_default().to_owned() + "...",
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_an_error_of_the_file() {
        let empty: [u8; 0] = [];
        let error = shielded("part.ply", || Ok(empty.iter().max().copied().unwrap())).unwrap_err();
        assert_eq!(error.file, "part.ply");
    }

    #[test]
    fn messages_stay_on_one_line() {
        assert_eq!(one_line(&"a\n\tb."), "a b");
        assert_eq!(one_line(&"x".repeat(999)).len(), 203);
    }
}
