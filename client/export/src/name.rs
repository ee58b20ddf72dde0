//! Names that every file system and every format takes.

use std::collections::BTreeSet;

/// Names that were given, so that no two are the same.
#[derive(Debug, Default)]
pub struct Names(BTreeSet<String>);

impl Names {
    /// `name` with everything but ASCII letters, digits, `-` and `_` replaced by `_`; numbered where it was given before,
    /// letters in either case counting as one, as some file systems have it.
    pub fn file(&mut self, name: &str) -> String {
        self.give(name, |c| c.is_ascii_alphanumeric() || "-_".contains(c), "")
    }

    /// As [`Names::file`] without `-`, and not beginning with a digit: an identifier of USD.
    pub fn identifier(&mut self, name: &str) -> String {
        let before = if name.starts_with(|c: char| c.is_ascii_alphabetic()) { "" } else { "_" };
        self.give(name, |c| c.is_ascii_alphanumeric() || c == '_', before)
    }

    fn give(&mut self, name: &str, keeps: impl Fn(char) -> bool, before: &str) -> String {
        let mut safe: String = name.chars().map(|c| if keeps(c) { c } else { '_' }).collect();
        safe.insert_str(0, before);
        if safe.is_empty() {
            safe.push('_');
        }
        let mut given = safe.clone();
        let mut number = 1;
        while !self.0.insert(given.to_lowercase()) {
            number += 1;
            given = format!("{safe}_{number}");
        }
        given
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_safe_and_differ() {
        let mut names = Names::default();
        let given = ["led", "led", "LED", "../x y", "", "ä"].map(|name| names.file(name));
        assert_eq!(given, ["led", "led_2", "LED_3", "___x_y", "_", "__2"]);
        let mut names = Names::default();
        assert_eq!(["00", "a-b", "_x"].map(|name| names.identifier(name)), ["_00", "a_b", "__x"]);
    }
}
