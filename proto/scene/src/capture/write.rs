//! Writes a section as TOML. Numbers are written with the digits that read back to the same bits.

use super::visit::{Numbers, Range, Section, Visitor};
use crate::{Result, SceneError};
use std::collections::BTreeMap;
use toml::{Table, Value};

/// Collects one table; keys at their default are left out.
#[derive(Default)]
pub(super) struct Writer {
    table: Table,
}

/// `section` as a table.
pub(super) fn write(section: &mut dyn Section) -> Result<Table> {
    let mut writer = Writer::default();
    section.describe(&mut writer)?;
    Ok(writer.table)
}

impl Writer {
    fn put(&mut self, key: &str, value: Value) {
        self.table.insert(key.to_owned(), value);
    }
}

fn list(values: &[f64]) -> Value {
    Value::Array(values.iter().map(|v| Value::Float(*v)).collect())
}

fn words(values: &[String]) -> Value {
    Value::Array(values.iter().map(|v| Value::String(v.clone())).collect())
}

impl Visitor for Writer {
    fn number(&mut self, key: &str, value: &mut f64, _: Range, default: Option<f64>) -> Result<()> {
        if default != Some(*value) {
            self.put(key, Value::Float(*value));
        }
        Ok(())
    }

    fn optional_number(&mut self, key: &str, value: &mut Option<f64>, _: Range) -> Result<()> {
        if let Some(v) = value {
            self.put(key, Value::Float(*v));
        }
        Ok(())
    }

    fn numbers(&mut self, key: &str, numbers: Numbers<'_>) -> Result<()> {
        if numbers.default != Some(&*numbers.values) {
            let default = numbers.default.filter(|_| numbers.may_end_early);
            let same = default.map_or(0, |d| {
                numbers.values.iter().zip(d).rev().take_while(|(value, default)| value == default).count()
            });
            self.put(key, list(&numbers.values[..numbers.values.len() - same]));
        }
        Ok(())
    }

    fn optional_numbers(&mut self, key: &str, value: &mut Option<Vec<f64>>, _: &[&str], _: Range) -> Result<()> {
        if let Some(v) = value {
            self.put(key, list(v));
        }
        Ok(())
    }

    fn table(&mut self, key: &str, values: &mut Vec<f64>) -> Result<()> {
        self.put(key, list(values));
        Ok(())
    }

    fn matrix(&mut self, key: &str, value: &mut [[f64; 4]; 4]) -> Result<()> {
        self.put(key, Value::Array(value.iter().map(|row| list(row)).collect()));
        Ok(())
    }

    fn size(&mut self, key: &str, value: &mut u32) -> Result<()> {
        self.put(key, Value::Integer(i64::from(*value)));
        Ok(())
    }

    fn optional_size(&mut self, key: &str, value: &mut Option<u32>) -> Result<()> {
        if let Some(v) = value {
            self.put(key, Value::Integer(i64::from(*v)));
        }
        Ok(())
    }

    fn text(&mut self, key: &str, value: &mut String, default: Option<&str>) -> Result<()> {
        if default != Some(value.as_str()) {
            self.put(key, Value::String(value.clone()));
        }
        Ok(())
    }

    fn optional_text(&mut self, key: &str, value: &mut Option<String>) -> Result<()> {
        if let Some(v) = value {
            self.put(key, Value::String(v.clone()));
        }
        Ok(())
    }

    fn flag(&mut self, key: &str, value: &mut bool, default: bool) -> Result<()> {
        if *value != default {
            self.put(key, Value::Boolean(*value));
        }
        Ok(())
    }

    fn texts(&mut self, key: &str, value: &mut Vec<String>) -> Result<()> {
        if !value.is_empty() {
            self.put(key, words(value));
        }
        Ok(())
    }

    fn optional_texts(&mut self, key: &str, value: &mut Option<Vec<String>>) -> Result<()> {
        if let Some(v) = value {
            self.put(key, words(v));
        }
        Ok(())
    }

    fn words(&mut self, key: &str, value: &mut BTreeMap<String, String>) -> Result<()> {
        if !value.is_empty() {
            let table = value.iter().map(|(name, word)| (name.clone(), Value::String(word.clone())));
            self.put(key, Value::Table(table.collect()));
        }
        Ok(())
    }

    fn section(&mut self, key: &str, section: &mut dyn Section) -> Result<()> {
        if !section.is_empty() {
            let table = write(section)?;
            self.put(key, Value::Table(table));
        }
        Ok(())
    }

    fn refuse(&self, key: &str, problem: String, mend: &str) -> SceneError {
        SceneError::new("the capture in memory", problem, mend).at(key)
    }
}
