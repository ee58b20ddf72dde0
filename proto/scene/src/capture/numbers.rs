//! Walks every number of a section by dotted name.

use super::read::join;
use super::visit::{Numbers, Range, Section, Visitor};
use crate::{Result, SceneError};
use std::collections::BTreeMap;

/// What is done with each number: its dotted name, its value, its bounds.
pub(super) type Each<'a> = dyn FnMut(&str, &mut f64, Range) + 'a;

/// Calls a function for every number below `path`.
pub(super) struct Walker<'a, 'b> {
    pub(super) path: String,
    pub(super) each: &'a mut Each<'b>,
}

impl Walker<'_, '_> {
    fn list(&mut self, key: &str, values: &mut [f64], suffixes: &[&str], range: Range) {
        for (value, suffix) in values.iter_mut().zip(suffixes) {
            (self.each)(&join(&join(&self.path, key), suffix), value, range);
        }
    }
}

impl Visitor for Walker<'_, '_> {
    fn number(&mut self, key: &str, value: &mut f64, range: Range, _: Option<f64>) -> Result<()> {
        (self.each)(&join(&self.path, key), value, range);
        Ok(())
    }

    fn optional_number(&mut self, key: &str, value: &mut Option<f64>, range: Range) -> Result<()> {
        if let Some(v) = value {
            (self.each)(&join(&self.path, key), v, range);
        }
        Ok(())
    }

    fn numbers(&mut self, key: &str, numbers: Numbers<'_>) -> Result<()> {
        self.list(key, numbers.values, numbers.suffixes, numbers.range);
        Ok(())
    }

    fn optional_numbers(
        &mut self,
        key: &str,
        value: &mut Option<Vec<f64>>,
        suffixes: &[&str],
        range: Range,
    ) -> Result<()> {
        if let Some(v) = value {
            self.list(key, v, suffixes, range);
        }
        Ok(())
    }

    fn table(&mut self, _: &str, _: &mut Vec<f64>) -> Result<()> {
        Ok(())
    }

    fn matrix(&mut self, key: &str, value: &mut [[f64; 4]; 4]) -> Result<()> {
        // The last row of an affine matrix is no parameter.
        for (i, row) in value.iter_mut().take(3).enumerate() {
            self.list(&format!("{key}.{i}"), row, &["0", "1", "2", "3"], Range::ANY);
        }
        Ok(())
    }

    fn size(&mut self, _: &str, _: &mut u32) -> Result<()> {
        Ok(())
    }

    fn optional_size(&mut self, _: &str, _: &mut Option<u32>) -> Result<()> {
        Ok(())
    }

    fn text(&mut self, _: &str, _: &mut String, _: Option<&str>) -> Result<()> {
        Ok(())
    }

    fn optional_text(&mut self, _: &str, _: &mut Option<String>) -> Result<()> {
        Ok(())
    }

    fn flag(&mut self, _: &str, _: &mut bool, _: bool) -> Result<()> {
        Ok(())
    }

    fn texts(&mut self, _: &str, _: &mut Vec<String>) -> Result<()> {
        Ok(())
    }

    fn optional_texts(&mut self, _: &str, _: &mut Option<Vec<String>>) -> Result<()> {
        Ok(())
    }

    fn words(&mut self, _: &str, _: &mut BTreeMap<String, String>) -> Result<()> {
        Ok(())
    }

    fn section(&mut self, key: &str, section: &mut dyn Section) -> Result<()> {
        let path = join(&self.path, key);
        section.describe(&mut Walker { path, each: self.each })
    }

    fn refuse(&self, key: &str, problem: String, mend: &str) -> SceneError {
        SceneError::new("the capture in memory", problem, mend).at(join(&self.path, key))
    }
}
