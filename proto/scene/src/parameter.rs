//! Parameters: what a fit frees and what a derivative is taken with respect to.
//!
//! Every number of a capture has a dotted name (`material.shell.roughness`, `light.led.intensity.r`,
//! `photo.03.gain`). A [`Parameter`] moves one number, or several in a fixed ratio.

use crate::capture::effects::VARIATION;
use crate::capture::visit::CROSSTALK;
use crate::capture::{CAPTURE_FILE, Capture, Range, SLIP, Sensor, edit_distance};
use crate::{Result, SceneError};
use std::collections::{BTreeMap, BTreeSet};

/// A number of the capture and how far it moves when its parameter moves by one.
#[derive(Debug, Clone, PartialEq)]
pub struct Term {
    /// Dotted name of a number.
    pub number: String,
    /// d number / d parameter; the number is `ratio * value`.
    pub ratio: f64,
}

/// One degree of freedom: numbers of the capture that are `ratio * value`.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Dotted name: a number's, or a colour's where its channels keep their ratio.
    pub name: String,
    /// Value in the capture; of a colour that keeps its ratio, the mean of its channels.
    pub value: f64,
    /// Bounds of the value.
    pub range: Range,
    /// The numbers that it moves; at least one.
    pub terms: Vec<Term>,
    /// Takes the derivative by finite differences of this step, in the unit of `value`, whatever is usual for the
    /// numbers; above 0. What acts on the film alone (a photo's gain) needs no difference and ignores it.
    pub step: Option<f64>,
    /// The only channel (0 red, 1 green, 2 blue) that its column holds; the others are 0 there.
    pub channel: Option<usize>,
}

impl Parameter {
    /// The capture's numbers when this parameter has `value`.
    pub fn numbers(&self, value: f64) -> impl Iterator<Item = (String, f64)> + '_ {
        self.terms.iter().map(move |t| (t.number.clone(), t.ratio * value))
    }
}

impl Capture {
    /// All numbers by dotted name, with value and bounds.
    #[must_use]
    pub fn numbers(&self) -> BTreeMap<String, (f64, Range)> {
        let mut all = BTreeMap::new();
        // Only values that contradict each other stop the walk, and those `parse` has refused.
        let _ = self.clone().for_each_number(&mut |name, value, range| {
            all.insert(name.to_owned(), (*value, range));
        });
        all
    }

    /// Sets numbers by dotted name.
    ///
    /// # Errors
    /// A name that the capture does not have, a value outside its bounds.
    pub fn set_numbers(&mut self, values: &[(String, f64)]) -> Result<()> {
        let mut left: BTreeMap<&str, f64> = values.iter().map(|(n, v)| (n.as_str(), *v)).collect();
        let mut outside = None;
        let named: BTreeSet<&str> = left.keys().copied().collect();
        let wanted = |section: &str| {
            let below = |name: &&str| name.strip_prefix(section).is_some_and(|rest| rest.starts_with('.'));
            // Names that begin with the section's may be another's, whose own begins so too.
            named.range(section..).take_while(|name| name.starts_with(section)).any(below)
        };
        self.for_each_number_in(&wanted, &mut |name, number, range| {
            if let Some(value) = left.remove(name) {
                if range.holds(value) {
                    *number = value;
                } else {
                    outside.get_or_insert((name.to_owned(), value, range));
                }
            }
        })?;
        if let Some((name, value, range)) = outside {
            return Err(
                SceneError::new(CAPTURE_FILE, format!("is set to {value}"), format!("it must be {range}")).at(name)
            );
        }
        match left.keys().next() {
            Some(name) => Err(self.unknown_number(name)),
            None => Ok(()),
        }
    }

    /// The parameters that `[fit]` frees.
    ///
    /// # Errors
    /// A name that is no number or colour of the capture, or that no photo can tell anything about.
    pub fn free_parameters(&self) -> Result<Vec<Parameter>> {
        self.parameters(&self.fit.parameters, &self.fit.gray)
    }

    /// The parameters for a list of names: each a number's, or a colour's or point's (one parameter for each of its
    /// numbers, or, where it is among `gray`, one factor for all).
    ///
    /// # Errors
    /// As [`Capture::free_parameters`].
    pub fn parameters(&self, names: &[String], gray: &[String]) -> Result<Vec<Parameter>> {
        let numbers = self.numbers();
        let mut out: Vec<Parameter> = Vec::new();
        for full in names {
            let name = full.strip_suffix(":rgb").unwrap_or(full);
            if Sensor::NOISE.contains(&name) || name.starts_with("reflectance.") {
                return Err(SceneError::new(
                    CAPTURE_FILE,
                    format!("frees {name}, which no residual determines"),
                    "remove it",
                )
                .at("fit.parameters"));
            }
            let parts: Vec<(&String, f64, Range)> = match numbers.get_key_value(name) {
                Some((n, (v, r))) => vec![(n, *v, *r)],
                None => below(&numbers, name),
            };
            if parts.is_empty() {
                return Err(self.unknown_number(name));
            }
            if gray.iter().any(|g| g.strip_suffix(":rgb").unwrap_or(g) == name) {
                out.push(common_factor(name, &parts));
            } else {
                out.extend(parts.into_iter().map(|(number, value, range)| Parameter {
                    name: number.clone(),
                    value,
                    range,
                    terms: vec![Term { number: number.clone(), ratio: 1.0 }],
                    step: None,
                    channel: None,
                }));
            }
        }
        if let Some(g) = gray.iter().find(|g| !names.contains(g)) {
            return Err(SceneError::new(
                CAPTURE_FILE,
                format!("names {g}, which is not freed"),
                "list it in fit.parameters too",
            )
            .at("fit.gray"));
        }
        let mut seen = BTreeSet::new();
        for number in out.iter().flat_map(|p| &p.terms).map(|t| &t.number) {
            if !seen.insert(number) {
                return Err(
                    SceneError::new(CAPTURE_FILE, format!("frees {number} twice"), "list it once").at("fit.parameters")
                );
            }
        }
        Ok(out)
    }

    fn unknown_number(&self, name: &str) -> SceneError {
        let numbers = self.numbers();
        let prefix = name.rsplit_once('.').map_or(name, |(p, _)| p);
        let near: Vec<&str> = numbers.keys().filter(|n| n.starts_with(prefix)).map(String::as_str).take(8).collect();
        // A colour's or a point's name stands for its numbers, so that it may be meant, too.
        let groups = numbers.keys().filter_map(|number| number.rsplit_once('.').map(|(group, _)| group));
        let all: BTreeSet<&str> = numbers.keys().map(String::as_str).chain(groups).collect();
        let nearest = all.into_iter().map(|other| (edit_distance(name, other), other)).min();
        let mend = if let Some((_, nearest)) = nearest.filter(|(distance, _)| *distance <= SLIP) {
            format!("did you mean `{nearest}`?")
        } else if near.is_empty() {
            "`gonio check` lists every number's name".to_owned()
        } else {
            format!("the names there are: {}", near.join(", "))
        };
        SceneError::new(CAPTURE_FILE, "is no number of this capture", mend).at(name)
    }
}

/// The numbers one level below `name`: a colour's channels, a point's coordinates, a variation's coefficients.
fn below<'n>(numbers: &'n BTreeMap<String, (f64, Range)>, name: &str) -> Vec<(&'n String, f64, Range)> {
    let order = |suffix: &str| match suffix {
        "r" | "x" | "k1" => 0,
        "g" | "y" | "k2" => 1,
        "b" | "z" | "p1" => 2,
        "p2" => 3,
        // Last, in their own order.
        _ => 4 + CROSSTALK.iter().position(|s| *s == suffix).unwrap_or(0),
    };
    let suffixes = ["r", "g", "b", "x", "y", "z", "k1", "k2", "p1", "p2", "k3"];
    let suffixes = [&suffixes[..], &CROSSTALK[..]].concat();
    let mut found: Vec<_> = numbers
        .iter()
        .filter_map(|(n, (v, r))| {
            let suffix = n.strip_prefix(name)?.strip_prefix('.')?;
            // A material's only lists by index are its variations; elsewhere an index is a matrix's.
            if name.starts_with("material.") && VARIATION.contains(&suffix) {
                return Some((suffix.parse().ok()?, n, *v, *r));
            }
            suffixes.contains(&suffix).then_some((order(suffix), n, *v, *r))
        })
        .collect();
    found.sort_by_key(|f| f.0);
    found.into_iter().map(|(_, n, v, r)| (n, v, r)).collect()
}

fn common_factor(name: &str, parts: &[(&String, f64, Range)]) -> Parameter {
    #[allow(clippy::cast_precision_loss)]
    let mean = parts.iter().map(|p| p.1).sum::<f64>() / parts.len() as f64;
    let terms: Vec<Term> = parts
        .iter()
        .map(|(n, v, _)| Term { number: (*n).clone(), ratio: if mean > 0.0 { v / mean } else { 1.0 } })
        .collect();
    // The channel with the largest ratio reaches its bound first.
    let largest = terms.iter().map(|t| t.ratio).fold(1.0, f64::max);
    let range = Range {
        min: parts.iter().map(|p| p.2.min).fold(f64::MIN, f64::max),
        max: parts.iter().map(|p| p.2.max).fold(f64::MAX, f64::min) / largest,
    };
    Parameter { name: name.to_owned(), value: mean, range, terms, step: None, channel: None }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Photo;

    #[test]
    fn numbers_of_sections_whose_names_begin_alike_are_told_apart() {
        let photo = |file: &str| Photo { file: file.to_owned(), ..Photo::default() };
        let mut capture =
            Capture { photos: vec![photo("a.exr"), photo("a.b.exr"), photo("ab.exr")], ..Capture::default() };
        let gains = [("photo.a.gain", 2.0), ("photo.a.b.gain", 3.0), ("photo.ab.gain", 4.0), ("camera.fx", 5.0)];
        capture.set_numbers(&gains.map(|(name, value)| (name.to_owned(), value))).unwrap();
        assert_eq!(capture.photos.iter().map(|photo| photo.gain).collect::<Vec<_>>(), [2.0, 3.0, 4.0]);
        assert_eq!(capture.camera.fx, 5.0);
        for unknown in ["photo.a.gian", "photo.c.gain", "photo", "photo.a", ""] {
            assert!(capture.set_numbers(&[(unknown.to_owned(), 1.0)]).is_err(), "{unknown}");
        }
    }
}
