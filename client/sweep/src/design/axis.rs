//! Axes: one dotted name and the values that it takes.

use crate::keys::Keys;
use gonio_scene::capture::{Capture, Range, Sensor, unknown_key_mend};
use gonio_scene::{Result, SceneError};
use toml::Value;

/// The values of an axis.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Levels {
    /// These, in this order: each one value for every number of the name, or one for each.
    Values(Vec<Vec<f64>>),
    /// Everything between two bounds.
    Interval {
        /// Lower bound, included.
        from: f64,
        /// Upper bound, included.
        to: f64,
        /// Equal ratios instead of equal differences.
        log: bool,
    },
}

/// A name of the capture that a design varies.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Axis {
    /// As written: a number's dotted name, or a colour's or point's.
    pub name: String,
    /// Where it stands in the sweep's file.
    pub place: String,
    /// What it takes.
    pub levels: Levels,
    /// How many values of an interval a grid takes.
    pub count: Option<u64>,
    /// The numbers that it sets, in the capture's order; found by [`Axis::resolve`].
    pub numbers: Vec<String>,
}

impl Axis {
    /// Reads one entry of `axes`. In a grid an interval needs a `count`; elsewhere the design has one for all axes.
    pub fn read(mut keys: Keys<'_>, grid: bool, most: u64) -> Result<Self> {
        let name = keys.text("name")?;
        let name = keys.needed("name", name, "a dotted name, such as \"material.shell.roughness\"")?.to_owned();
        let values = keys.value("values");
        let levels = if let Some(values) = values {
            Levels::Values(listed(&keys, values)?)
        } else {
            let (from, to) = (keys.number("from", Range::ANY)?, keys.number("to", Range::ANY)?);
            let what = "values = [...], or from, to and, in a grid, count";
            let (from, to) = (keys.needed("from", from, what)?, keys.needed("to", to, what)?);
            if from > to {
                return Err(keys.refuse("from", format!("is {from}, above `to` = {to}"), "swap the two"));
            }
            let log = keys.word("scale", &[("linear", false), ("log", true)])?.unwrap_or(false);
            if log && from <= 0.0 {
                return Err(keys.refuse("from", format!("is {from}, which has no logarithm"), "write one above 0"));
            }
            Levels::Interval { from, to, log }
        };
        let mut count = None;
        if grid && values.is_none() {
            count = keys.whole("count", 1..=most)?;
            let needed = keys.needed("count", count, "how many values to take between from and to, both included")?;
            if let (1, Levels::Interval { from, to, .. }) = (needed, &levels)
                && from != to
            {
                return Err(keys.refuse("count", "is 1 for an interval", "write at least 2, or values = [...]"));
            }
        }
        let place = keys.path().to_owned();
        keys.finish()?;
        Ok(Self { name, place, levels, count, numbers: Vec::new() })
    }

    /// Finds the numbers that this axis sets, and holds its values against their bounds.
    ///
    /// # Errors
    /// A name that the capture does not have or that changes no render, a value out of bounds, values of the wrong length.
    pub fn resolve(&mut self, capture: &Capture, file: &str) -> Result<()> {
        let bounds = numbers_of(capture, &self.name).map_err(|e| e.of(file, &format!("{}.name", self.place)))?;
        let check = |value: f64, key: &str, (name, range): &(String, Range)| {
            if range.holds(value) {
                return Ok(());
            }
            let problem = format!("sets {name} to {value}");
            Err(SceneError::new(file, problem, format!("it must be {range}")).at(format!("{}.{key}", self.place)))
        };
        match &self.levels {
            Levels::Interval { from, to, .. } => {
                for number in &bounds {
                    check(*from, "from", number)?;
                    check(*to, "to", number)?;
                }
            }
            Levels::Values(values) => {
                for value in values {
                    if value.len() != 1 && value.len() != bounds.len() {
                        let problem = format!("lists {} numbers for {}", value.len(), self.name);
                        let mend = format!("write one number, or {} of them", bounds.len());
                        return Err(SceneError::new(file, problem, mend).at(format!("{}.values", self.place)));
                    }
                    for (i, number) in bounds.iter().enumerate() {
                        check(value.get(i).copied().unwrap_or(value[0]), "values", number)?;
                    }
                }
            }
        }
        self.numbers = bounds.into_iter().map(|(name, _)| name).collect();
        Ok(())
    }

    /// How many values a grid takes.
    pub fn grid_count(&self) -> u64 {
        match &self.levels {
            Levels::Values(values) => values.len() as u64,
            Levels::Interval { .. } => self.count.unwrap_or(1),
        }
    }

    /// Appends the value of each of its numbers at `i` of a grid.
    #[allow(clippy::cast_precision_loss)]
    pub fn at_index(&self, i: u64, row: &mut Vec<f64>) {
        match &self.levels {
            Levels::Values(values) => self.push(values.get(i as usize).map_or(&[], Vec::as_slice), row),
            Levels::Interval { to, .. } if i + 1 == self.grid_count() => self.push(&[*to], row),
            Levels::Interval { .. } => self.at(i as f64 / (self.grid_count() - 1) as f64, row),
        }
    }

    /// Appends the value of each of its numbers at the part `u` of the way, 0 <= u < 1.
    #[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    pub fn at(&self, u: f64, row: &mut Vec<f64>) {
        match &self.levels {
            Levels::Values(values) => {
                let i = ((u * values.len() as f64) as usize).min(values.len().saturating_sub(1));
                self.push(values.get(i).map_or(&[], Vec::as_slice), row);
            }
            Levels::Interval { from, to, log: false } => self.push(&[(from + u * (to - from)).clamp(*from, *to)], row),
            Levels::Interval { from, to, log: true } => {
                let value = libm::exp(libm::log(*from) + u * (libm::log(*to) - libm::log(*from)));
                self.push(&[value.clamp(*from, *to)], row);
            }
        }
    }

    fn push(&self, values: &[f64], row: &mut Vec<f64>) {
        let one = values.first().copied().unwrap_or(0.0);
        row.extend((0..self.numbers.len()).map(|i| values.get(i).copied().unwrap_or(one)));
    }
}

/// Why a name cannot be varied; where it stood is added by who knows.
pub(crate) struct NoName {
    problem: String,
    mend: String,
}

impl NoName {
    /// The error about `key` of `file`.
    pub fn of(self, file: &str, key: &str) -> SceneError {
        SceneError::new(file, self.problem, self.mend).at(key)
    }
}

/// The numbers behind a name, with their bounds.
pub(crate) fn numbers_of(capture: &Capture, name: &str) -> std::result::Result<Vec<(String, Range)>, NoName> {
    if Sensor::NOISE.contains(&name) || name.starts_with("reflectance.") {
        let problem = format!("is {name}, which changes no render");
        return Err(NoName { problem, mend: "vary what is rendered".to_owned() });
    }
    let parameters = capture.parameters(&[name.to_owned()], &[]).map_err(|error| {
        let known = capture.numbers();
        // Without a likely one, the capture's own words: all of its names would be hundreds.
        let mend = Some(unknown_key_mend(name, known.keys().map(String::as_str)));
        let mend = mend.filter(|mend| mend.starts_with("did you mean")).unwrap_or(error.mend);
        NoName { problem: format!("is {name}, no number of the capture"), mend }
    })?;
    Ok(parameters.into_iter().map(|p| (p.name, p.range)).collect())
}

/// The entries of `values`: numbers, or lists of them.
fn listed(keys: &Keys<'_>, values: &Value) -> Result<Vec<Vec<f64>>> {
    let list = values.as_array().filter(|list| !list.is_empty());
    let list = list.ok_or_else(|| keys.refuse("values", "is no list, or empty", "list at least one value"))?;
    let number = |v: &Value| keys.to_number("values", v, Range::ANY);
    let entry = |v: &Value| match v.as_array().map(Vec::as_slice) {
        Some([]) => Err(keys.refuse("values", "has an empty list in it", "write a number, or one for each channel")),
        Some(parts) => parts.iter().map(number).collect(),
        None => Ok(vec![number(v)?]),
    };
    list.iter().map(entry).collect()
}
