//! Reads a section from TOML and refuses everything that it does not know.

use super::visit::{Numbers, Range, Section, Visitor};
use crate::{Result, SceneError};
use std::collections::{BTreeMap, BTreeSet};
use toml::{Table, Value};

/// Reads one table; knows which of its keys were asked for.
pub(super) struct Reader<'a> {
    file: &'a str,
    /// Dotted name of this table, empty for the top level.
    path: String,
    table: &'a Table,
    known: BTreeSet<String>,
}

impl<'a> Reader<'a> {
    pub(super) fn new(file: &'a str, path: String, table: &'a Table) -> Self {
        Self { file, path, table, known: BTreeSet::new() }
    }

    /// Reads `section` from this table and refuses keys that it does not have.
    pub(super) fn read(mut self, section: &mut dyn Section) -> Result<()> {
        section.describe(&mut self)?;
        for key in self.table.keys() {
            if !self.known.contains(key) {
                let mend = unknown_key_mend(key, self.known.iter().map(String::as_str));
                return Err(self.refuse(key, "is not a key that this version knows".to_owned(), &mend));
            }
        }
        Ok(())
    }

    fn get(&mut self, key: &str) -> Option<&'a Value> {
        self.known.insert(key.to_owned());
        self.table.get(key)
    }

    /// A key that is missing may be there with a slip in its name: then that name is the mistake.
    fn missing(&self, key: &str, what: &str) -> SceneError {
        // A key of two letters is a slip of too many others: cx of fx.
        let slips = |other: &&String| !self.known.contains(*other) && edit_distance(other, key) <= SLIP;
        let slip = self.table.keys().find(slips).filter(|_| key.len() > SLIP + 1);
        if let Some(slip) = slip {
            let mend = format!("did you mean `{key}`?");
            return self.refuse(slip, "is not a key that this version knows".to_owned(), &mend);
        }
        self.refuse(key, "is missing".to_owned(), &format!("write {what}"))
    }

    fn wrong_type(&self, key: &str, value: &Value, what: &str) -> SceneError {
        self.refuse(key, format!("is a TOML {}, not {what}", value.type_str()), &format!("write {what}"))
    }

    fn to_number(&self, key: &str, value: &Value, range: Range) -> Result<f64> {
        let number = match value {
            Value::Float(x) => *x,
            // TOML integers above 2^53 lose digits, which no physical quantity has.
            #[allow(clippy::cast_precision_loss)]
            Value::Integer(i) => *i as f64,
            other => return Err(self.wrong_type(key, other, "a number")),
        };
        if !range.holds(number) {
            return Err(self.refuse(key, format!("is {number}"), &format!("the value must be {range}")));
        }
        Ok(number)
    }

    fn to_numbers(&self, key: &str, value: &Value, length: usize, range: Range) -> Result<Vec<f64>> {
        let what = format!("a list of {length} numbers");
        let list = value.as_array().ok_or_else(|| self.wrong_type(key, value, &what))?;
        if list.len() != length {
            return Err(self.refuse(
                key,
                format!("has {} entries, not {length}", list.len()),
                &format!("write {what}"),
            ));
        }
        list.iter().map(|v| self.to_number(key, v, range)).collect()
    }

    fn to_texts(&self, key: &str, value: &Value) -> Result<Vec<String>> {
        let what = "a list of words, such as [\"led\"]";
        let list = value.as_array().ok_or_else(|| self.wrong_type(key, value, what))?;
        list.iter().map(|v| v.as_str().map(str::to_owned).ok_or_else(|| self.wrong_type(key, v, "a word"))).collect()
    }
}

/// Reads `section` from a table of another file, which says `path` of the table in its errors, by the rules of a capture.
///
/// # Errors
/// A key that the section does not have, lacks, or has with another type or outside its bounds.
pub fn read_section(file: &str, path: &str, table: &Table, section: &mut dyn Section) -> Result<()> {
    Reader::new(file, path.to_owned(), table).read(section)
}

/// Letters to change in a name that is still taken for a slip of another.
pub(crate) const SLIP: usize = 2;

/// Proposes the known key that is nearest in spelling, else lists them all.
pub fn unknown_key_mend<'k>(key: &str, known: impl Iterator<Item = &'k str> + Clone) -> String {
    let nearest = known.clone().min_by_key(|k| edit_distance(key, k));
    match nearest {
        Some(k) if edit_distance(key, k) <= SLIP => format!("did you mean `{k}`?"),
        _ => format!("remove it; the keys here are: {}", known.collect::<Vec<_>>().join(", ")),
    }
}

/// Levenshtein distance, for spelling hints.
pub(crate) fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let substitution = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = substitution.min(row[j] + 1).min(row[j + 1] + 1);
        }
    }
    row[b.len()]
}

impl Visitor for Reader<'_> {
    fn number(&mut self, key: &str, value: &mut f64, range: Range, default: Option<f64>) -> Result<()> {
        *value = match (self.get(key), default) {
            (Some(v), _) => self.to_number(key, v, range)?,
            (None, Some(d)) => d,
            (None, None) => return Err(self.missing(key, "a number")),
        };
        Ok(())
    }

    fn optional_number(&mut self, key: &str, value: &mut Option<f64>, range: Range) -> Result<()> {
        *value = self.get(key).map(|v| self.to_number(key, v, range)).transpose()?;
        Ok(())
    }

    fn numbers(&mut self, key: &str, numbers: Numbers<'_>) -> Result<()> {
        let length = numbers.values.len();
        match (self.get(key), numbers.default) {
            (Some(v), Some(d)) if numbers.may_end_early => {
                let given = v.as_array().map_or(length, |list| list.len().min(length));
                numbers.values.copy_from_slice(d);
                numbers.values[..given].copy_from_slice(&self.to_numbers(key, v, given, numbers.range)?);
            }
            (Some(v), _) => numbers.values.copy_from_slice(&self.to_numbers(key, v, length, numbers.range)?),
            (None, Some(d)) => numbers.values.copy_from_slice(d),
            (None, None) => return Err(self.missing(key, &format!("a list of {length} numbers"))),
        }
        Ok(())
    }

    fn optional_numbers(
        &mut self,
        key: &str,
        value: &mut Option<Vec<f64>>,
        suffixes: &[&str],
        range: Range,
    ) -> Result<()> {
        *value = self.get(key).map(|v| self.to_numbers(key, v, suffixes.len(), range)).transpose()?;
        Ok(())
    }

    fn table(&mut self, key: &str, values: &mut Vec<f64>) -> Result<()> {
        let what = "a list of numbers";
        let given = self.get(key).ok_or_else(|| self.missing(key, what))?;
        let list = given.as_array().ok_or_else(|| self.wrong_type(key, given, what))?;
        *values = list.iter().map(|v| self.to_number(key, v, Range::ANY)).collect::<Result<_>>()?;
        Ok(())
    }

    fn matrix(&mut self, key: &str, value: &mut [[f64; 4]; 4]) -> Result<()> {
        let what = "four rows of four numbers";
        let given = self.get(key).ok_or_else(|| self.missing(key, what))?;
        let rows = given.as_array().ok_or_else(|| self.wrong_type(key, given, what))?;
        if rows.len() != 4 {
            return Err(self.refuse(key, format!("has {} rows, not 4", rows.len()), &format!("write {what}")));
        }
        for (row, given) in value.iter_mut().zip(rows) {
            row.copy_from_slice(&self.to_numbers(key, given, 4, Range::ANY)?);
        }
        if value[3] != [0.0, 0.0, 0.0, 1.0] {
            return Err(self.refuse(
                key,
                format!("has the last row {:?}", value[3]),
                "write the matrix row-major with the last row [0, 0, 0, 1]",
            ));
        }
        Ok(())
    }

    fn size(&mut self, key: &str, value: &mut u32) -> Result<()> {
        let mut size = None;
        self.optional_size(key, &mut size)?;
        *value = size.ok_or_else(|| self.missing(key, "a number of pixels"))?;
        Ok(())
    }

    fn optional_size(&mut self, key: &str, value: &mut Option<u32>) -> Result<()> {
        let Some(given) = self.get(key) else {
            *value = None;
            return Ok(());
        };
        let size = given.as_integer().ok_or_else(|| self.wrong_type(key, given, "a whole number of pixels"))?;
        *value = u32::try_from(size).ok().filter(|s| (1..=crate::MAX_SIDE).contains(s));
        if value.is_none() {
            return Err(self.refuse(
                key,
                format!("is {size}"),
                &format!("the value must be 1..={} pixels", crate::MAX_SIDE),
            ));
        }
        Ok(())
    }

    fn text(&mut self, key: &str, value: &mut String, default: Option<&str>) -> Result<()> {
        let mut text = None;
        self.optional_text(key, &mut text)?;
        *value = match (text, default) {
            (Some(t), _) => t,
            (None, Some(d)) => d.to_owned(),
            (None, None) => return Err(self.missing(key, "a word in quotes")),
        };
        Ok(())
    }

    fn optional_text(&mut self, key: &str, value: &mut Option<String>) -> Result<()> {
        *value = match self.get(key) {
            None => None,
            Some(Value::String(s)) if !s.is_empty() => Some(s.clone()),
            Some(Value::String(_)) => {
                return Err(self.refuse(key, "is empty".to_owned(), "write a word, or remove the key"));
            }
            Some(other) => return Err(self.wrong_type(key, other, "a word in quotes")),
        };
        Ok(())
    }

    fn flag(&mut self, key: &str, value: &mut bool, default: bool) -> Result<()> {
        *value = match self.get(key) {
            None => default,
            Some(Value::Boolean(b)) => *b,
            Some(other) => return Err(self.wrong_type(key, other, "true or false")),
        };
        Ok(())
    }

    fn texts(&mut self, key: &str, value: &mut Vec<String>) -> Result<()> {
        *value = self.get(key).map(|v| self.to_texts(key, v)).transpose()?.unwrap_or_default();
        Ok(())
    }

    fn optional_texts(&mut self, key: &str, value: &mut Option<Vec<String>>) -> Result<()> {
        *value = self.get(key).map(|v| self.to_texts(key, v)).transpose()?;
        Ok(())
    }

    fn words(&mut self, key: &str, value: &mut BTreeMap<String, String>) -> Result<()> {
        value.clear();
        let Some(given) = self.get(key) else { return Ok(()) };
        let table = given.as_table().ok_or_else(|| self.wrong_type(key, given, "a table of words"))?;
        for (name, word) in table {
            let key = join(key, name);
            let word = word.as_str().ok_or_else(|| self.wrong_type(&key, word, "a word in quotes"))?;
            value.insert(name.clone(), word.to_owned());
        }
        Ok(())
    }

    fn section(&mut self, key: &str, section: &mut dyn Section) -> Result<()> {
        let empty = Table::new();
        let table = match self.get(key) {
            None => &empty,
            Some(Value::Table(table)) => table,
            Some(other) => return Err(self.wrong_type(key, other, "a table")),
        };
        Reader::new(self.file, join(&self.path, key), table).read(section)
    }

    fn refuse(&self, key: &str, problem: String, mend: &str) -> SceneError {
        SceneError::new(self.file, problem, mend).at(join(&self.path, key))
    }
}

/// A dotted name.
pub(super) fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}
