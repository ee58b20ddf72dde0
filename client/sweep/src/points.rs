//! Points: rows of values for the same numbers.

use crate::MOST_FRAMES;
use gonio_scene::{Result, SceneError};
use std::collections::BTreeSet;

/// A table of what numbers are set to.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Points {
    /// Dotted names of numbers, one for each column.
    pub names: Vec<String>,
    /// One value for each name.
    pub rows: Vec<Vec<f64>>,
}

impl Points {
    /// The capture as it is.
    pub fn one() -> Self {
        Self { names: Vec::new(), rows: vec![Vec::new()] }
    }

    /// These points, unless they set a number twice.
    pub fn named_once(self, file: &str, place: &str) -> Result<Self> {
        let mut seen = BTreeSet::new();
        match self.names.iter().find(|name| !seen.insert(*name)) {
            None => Ok(self),
            Some(name) => {
                let problem = format!("sets {name} twice");
                Err(SceneError::new(file, problem, "name it in one place only").at(place))
            }
        }
    }

    /// Every point of this table with every one of `faster`, whose points change first.
    ///
    /// # Errors
    /// A number that both set, or too many points.
    pub fn times(&self, faster: &Self, file: &str) -> Result<Self> {
        let total = (self.rows.len() as u64).saturating_mul(faster.rows.len() as u64);
        if total > MOST_FRAMES {
            let problem = format!("has {total} points in all, the limit is {MOST_FRAMES}");
            return Err(SceneError::new(file, problem, "take fewer points").at("design"));
        }
        let pairs = self.rows.iter().flat_map(|row| faster.rows.iter().map(move |more| (row, more)));
        let rows = pairs.map(|(row, more)| [row.as_slice(), more].concat()).collect();
        let names = [self.names.as_slice(), &faster.names].concat();
        Self { names, rows }.named_once(file, "design")
    }
}
