//! Reads tables of a sweep's TOML: each key by name, and at the end refuses those that nobody asked for.

use gonio_scene::capture::{Range, unknown_key_mend};
use gonio_scene::{Result, SceneError};
use std::collections::BTreeSet;
use std::ops::RangeInclusive;
use toml::{Table, Value};

/// One table and which of its keys were asked for.
pub(crate) struct Keys<'a> {
    file: &'a str,
    /// Dotted name of this table, empty for the top level.
    path: String,
    table: &'a Table,
    known: BTreeSet<&'static str>,
}

impl<'a> Keys<'a> {
    /// The keys of `table`, which `file` has at `path`.
    pub fn new(file: &'a str, path: String, table: &'a Table) -> Self {
        Self { file, path, table, known: BTreeSet::new() }
    }

    /// The dotted name of this table.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// The file.
    pub fn file(&self) -> &'a str {
        self.file
    }

    /// An error about `key` of this table.
    pub fn refuse(&self, key: &str, problem: impl Into<String>, mend: impl Into<String>) -> SceneError {
        let path = if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) };
        SceneError::new(self.file, problem, mend).at(path)
    }

    /// Whatever is at `key`.
    pub fn value(&mut self, key: &'static str) -> Option<&'a Value> {
        self.known.insert(key);
        self.table.get(key)
    }

    /// `found`, without which there is no going on.
    pub fn needed<T>(&self, key: &str, found: Option<T>, what: &str) -> Result<T> {
        found.ok_or_else(|| self.refuse(key, "is missing", format!("write {what}")))
    }

    fn wrong_type(&self, key: &str, value: &Value, what: &str) -> SceneError {
        self.refuse(key, format!("is a TOML {}, not {what}", value.type_str()), format!("write {what}"))
    }

    /// A text that is not empty.
    pub fn text(&mut self, key: &'static str) -> Result<Option<&'a str>> {
        match self.value(key) {
            None => Ok(None),
            Some(Value::String(text)) if !text.is_empty() => Ok(Some(text)),
            Some(Value::String(_)) => Err(self.refuse(key, "is empty", "write a text, or remove the key")),
            Some(other) => Err(self.wrong_type(key, other, "a text in quotes")),
        }
    }

    /// One of the words of `choices`.
    pub fn word<T: Copy>(&mut self, key: &'static str, choices: &[(&str, T)]) -> Result<Option<T>> {
        let Some(text) = self.text(key)? else { return Ok(None) };
        match choices.iter().find(|(word, _)| *word == text) {
            Some((_, choice)) => Ok(Some(*choice)),
            None => {
                let words: Vec<_> = choices.iter().map(|(word, _)| format!("\"{word}\"")).collect();
                Err(self.refuse(key, format!("is \"{text}\""), format!("write one of: {}", words.join(", "))))
            }
        }
    }

    /// A list of texts, at least one.
    pub fn texts(&mut self, key: &'static str) -> Result<Option<Vec<&'a str>>> {
        let what = "a list of texts in quotes";
        let Some(value) = self.value(key) else { return Ok(None) };
        let list = value.as_array().ok_or_else(|| self.wrong_type(key, value, what))?;
        if list.is_empty() {
            return Err(self.refuse(key, "is empty", "list something, or remove the key"));
        }
        list.iter().map(|v| v.as_str().ok_or_else(|| self.wrong_type(key, v, what))).collect::<Result<_>>().map(Some)
    }

    /// A whole number in `range`.
    pub fn whole(&mut self, key: &'static str, range: RangeInclusive<u64>) -> Result<Option<u64>> {
        let Some(value) = self.value(key) else { return Ok(None) };
        let given = value.as_integer().ok_or_else(|| self.wrong_type(key, value, "a whole number"))?;
        let whole = u64::try_from(given).ok().filter(|n| range.contains(n));
        let refuse =
            || self.refuse(key, format!("is {given}"), format!("it must be {}..={}", range.start(), range.end()));
        whole.ok_or_else(refuse).map(Some)
    }

    /// A number in `range`.
    pub fn number(&mut self, key: &'static str, range: Range) -> Result<Option<f64>> {
        let Some(value) = self.value(key) else { return Ok(None) };
        self.to_number(key, value, range).map(Some)
    }

    /// A list of `length` numbers in `range`.
    pub fn numbers(&mut self, key: &'static str, length: usize, range: Range) -> Result<Option<Vec<f64>>> {
        let Some(value) = self.value(key) else { return Ok(None) };
        let what = format!("a list of {length} numbers");
        let list = value.as_array().ok_or_else(|| self.wrong_type(key, value, &what))?;
        if list.len() != length {
            return Err(self.refuse(key, format!("has {} entries", list.len()), format!("write {what}")));
        }
        list.iter().map(|v| self.to_number(key, v, range)).collect::<Result<_>>().map(Some)
    }

    /// A number as TOML writes it, finite and in `range`.
    pub fn to_number(&self, key: &str, value: &Value, range: Range) -> Result<f64> {
        let number = match value {
            Value::Float(x) => *x,
            // TOML integers above 2^53 lose digits, which no physical quantity has.
            #[allow(clippy::cast_precision_loss)]
            Value::Integer(i) => *i as f64,
            other => return Err(self.wrong_type(key, other, "a number")),
        };
        if range.holds(number) {
            return Ok(number);
        }
        Err(self.refuse(key, format!("is {number}"), format!("it must be {range}")))
    }

    /// The tables of a list of tables; empty where the key is absent.
    pub fn tables(&mut self, key: &'static str) -> Result<Vec<Keys<'a>>> {
        let Some(value) = self.value(key) else { return Ok(Vec::new()) };
        let what = "a list of tables";
        let list = value.as_array().ok_or_else(|| self.wrong_type(key, value, what))?;
        let table = |(i, entry): (usize, &'a Value)| {
            let table = entry.as_table().ok_or_else(|| self.wrong_type(key, entry, what))?;
            let above = if self.path.is_empty() { String::new() } else { format!("{}.", self.path) };
            Ok(Keys::new(self.file, format!("{above}{key}[{i}]"), table))
        };
        list.iter().enumerate().map(table).collect()
    }

    /// Refuses keys that nobody asked for.
    pub fn finish(self) -> Result<()> {
        match self.table.keys().find(|key| !self.known.contains(key.as_str())) {
            None => Ok(()),
            Some(key) => {
                let mend = unknown_key_mend(key, self.known.iter().copied());
                Err(self.refuse(key, "is not a key that this version knows", mend))
            }
        }
    }
}
