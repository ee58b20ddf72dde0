//! One description per section of `capture.toml`, three uses: reading, writing, and naming every number.
//!
//! A section lists its keys once, in [`Section::describe`]; a [`Visitor`] then reads them from TOML, writes them to
//! TOML, or walks their numbers by dotted name. A key that is added there is readable, writable and fittable at once.

use crate::Result;
use std::collections::BTreeMap;

/// What a number may be: bounds (both included) and the value it has where the key is absent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Smallest value allowed.
    pub min: f64,
    /// Largest value allowed.
    pub max: f64,
}

impl Range {
    /// Any finite number.
    pub const ANY: Self = Self { min: f64::MIN, max: f64::MAX };
    /// A fraction: reflectances, perceptual roughness.
    pub const UNIT: Self = Self { min: 0.0, max: 1.0 };
    /// Radiometric quantities and anything else that cannot be negative.
    pub const NON_NEGATIVE: Self = Self { min: 0.0, max: 1e12 };
    /// Lengths, focal lengths, gains: strictly above zero.
    pub const POSITIVE: Self = Self { min: 1e-12, max: 1e12 };
    /// Real index of refraction of a dielectric (against vacuum, as tables give it).
    pub const IOR: Self = Self { min: 1.01, max: 4.0 };

    /// Whether `value` is finite and inside the bounds.
    #[must_use]
    pub fn holds(&self, value: f64) -> bool {
        value.is_finite() && value >= self.min && value <= self.max
    }
}

impl std::fmt::Display for Range {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self.min > f64::MIN, self.max < f64::MAX) {
            (true, true) => write!(f, "{}..={}", self.min, self.max),
            (true, false) => write!(f, "at least {}", self.min),
            (false, true) => write!(f, "at most {}", self.max),
            (false, false) => write!(f, "any finite number"),
        }
    }
}

/// The three suffixes of a colour's numbers.
pub const RGB: [&str; 3] = ["r", "g", "b"];
/// The three suffixes of a point's or a direction's numbers.
pub const XYZ: [&str; 3] = ["x", "y", "z"];
/// The suffixes of the Brown-Conrady distortion, in OpenCV's order.
pub const DISTORTION: [&str; 5] = ["k1", "k2", "p1", "p2", "k3"];
/// The suffixes of the vignetting polynomial.
pub const VIGNETTING: [&str; 2] = ["k1", "k2"];
/// The suffixes of the crosstalk: the channel that light is added to, then the channel that it belongs to.
pub const CROSSTALK: [&str; 6] = ["rg", "rb", "gr", "gb", "br", "bg"];

/// A list of numbers under one key: a colour, a point, the distortion.
pub struct Numbers<'a> {
    /// The numbers.
    pub values: &'a mut [f64],
    /// Each number's dotted suffix, same length as `values`.
    pub suffixes: &'a [&'a str],
    /// The bounds of each number.
    pub range: Range,
    /// Value where the key is absent; `None` where the key is required.
    pub default: Option<&'a [f64]>,
    /// Whether a file may leave out the last numbers, which then have their defaults.
    pub may_end_early: bool,
}

/// What walks a section's keys.
pub trait Visitor {
    /// A number. `default` is the value where the key is absent; `None` makes the key required.
    fn number(&mut self, key: &str, value: &mut f64, range: Range, default: Option<f64>) -> Result<()>;
    /// A number that may be absent for good.
    fn optional_number(&mut self, key: &str, value: &mut Option<f64>, range: Range) -> Result<()>;
    /// A list of numbers of fixed length.
    fn numbers(&mut self, key: &str, numbers: Numbers<'_>) -> Result<()>;
    /// A list of numbers of fixed length that may be absent for good.
    fn optional_numbers(
        &mut self,
        key: &str,
        value: &mut Option<Vec<f64>>,
        suffixes: &[&str],
        range: Range,
    ) -> Result<()>;
    /// A list of numbers that are no parameters; required.
    fn table(&mut self, key: &str, values: &mut Vec<f64>) -> Result<()>;
    /// A 4x4 row-major matrix; its numbers are named `key.row.column`.
    fn matrix(&mut self, key: &str, value: &mut [[f64; 4]; 4]) -> Result<()>;
    /// A whole number of pixels; not a parameter.
    fn size(&mut self, key: &str, value: &mut u32) -> Result<()>;
    /// A whole number of pixels that may be absent; not a parameter.
    fn optional_size(&mut self, key: &str, value: &mut Option<u32>) -> Result<()>;
    /// A word or a file's path; `default` as for [`Visitor::number`].
    fn text(&mut self, key: &str, value: &mut String, default: Option<&str>) -> Result<()>;
    /// A word or path that may be absent for good.
    fn optional_text(&mut self, key: &str, value: &mut Option<String>) -> Result<()>;
    /// A switch.
    fn flag(&mut self, key: &str, value: &mut bool, default: bool) -> Result<()>;
    /// A list of words; empty where absent.
    fn texts(&mut self, key: &str, value: &mut Vec<String>) -> Result<()>;
    /// A list of words that may be absent for good.
    fn optional_texts(&mut self, key: &str, value: &mut Option<Vec<String>>) -> Result<()>;
    /// A table of words by names that are the file's own; empty where absent.
    fn words(&mut self, key: &str, value: &mut BTreeMap<String, String>) -> Result<()>;
    /// A nested table, left out where `present` says that there is nothing in it.
    fn section(&mut self, key: &str, section: &mut dyn Section) -> Result<()>;
    /// Refuses what was read under `key`. Returns the error to give back.
    fn refuse(&self, key: &str, problem: String, mend: &str) -> crate::SceneError;
}

/// A colour in linear RGB.
pub fn colour(
    v: &mut dyn Visitor,
    key: &str,
    value: &mut [f64; 3],
    range: Range,
    default: Option<&[f64; 3]>,
) -> Result<()> {
    v.numbers(
        key,
        Numbers { values: value, suffixes: &RGB, range, default: default.map(|d| &d[..]), may_end_early: false },
    )
}

/// A point or direction.
pub fn vector(v: &mut dyn Visitor, key: &str, value: &mut [f64; 3]) -> Result<()> {
    v.numbers(key, Numbers { values: value, suffixes: &XYZ, range: Range::ANY, default: None, may_end_early: false })
}

/// A point or direction that is `default` where the key is absent.
pub fn vector_or(v: &mut dyn Visitor, key: &str, value: &mut [f64; 3], default: &[f64; 3]) -> Result<()> {
    v.numbers(
        key,
        Numbers { values: value, suffixes: &XYZ, range: Range::ANY, default: Some(default), may_end_early: false },
    )
}

/// A table of `capture.toml`.
pub trait Section {
    /// Shows every key to the visitor, in the order in which they are written.
    ///
    /// # Errors
    /// Whatever the visitor refuses: an absent key, a wrong type, a value out of range.
    fn describe(&mut self, v: &mut dyn Visitor) -> Result<()>;
    /// Whether the section holds nothing and may be left out of a file.
    fn is_empty(&self) -> bool {
        false
    }
}
