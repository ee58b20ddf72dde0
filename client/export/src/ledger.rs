//! What became of every number.

use gonio_scene::Capture;
use gonio_scene::capture::{Light, MapRole, MapSource, Model, Response};
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// Whether the export says what the capture says.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(tag = "kept", content = "how", rename_all = "lowercase")]
pub enum Kept {
    /// As it is; where it stands.
    Exact(String),
    /// Nearly; in which way.
    Approximated(String),
    /// Not; for which reason.
    Lost(String),
}

impl Kept {
    /// `exact`, `approximated` or `lost`.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::Exact(_) => "exact",
            Self::Approximated(_) => "approximated",
            Self::Lost(_) => "lost",
        }
    }

    /// Where, in which way, or for which reason.
    #[must_use]
    pub fn how(&self) -> &str {
        match self {
            Self::Exact(how) | Self::Approximated(how) | Self::Lost(how) => how,
        }
    }

    fn rank(&self) -> u8 {
        match self {
            Self::Exact(_) => 0,
            Self::Approximated(_) => 1,
            Self::Lost(_) => 2,
        }
    }
}

/// One number, word or switch of the capture and what became of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Entry {
    /// Its dotted name.
    pub name: String,
    /// Its value in the capture.
    pub value: Value,
    /// What became of it.
    #[serde(flatten)]
    pub kept: Kept,
}

/// Judgements by dotted name or by its beginning.
#[derive(Debug)]
pub struct Ledger {
    values: BTreeMap<String, Value>,
    judged: BTreeMap<String, Kept>,
}

impl Ledger {
    /// All numbers of `capture`, and the words and switches that change a picture; nothing is judged yet.
    pub fn new(capture: &Capture) -> Self {
        let numbers = capture.numbers().into_iter();
        let mut values: BTreeMap<String, Value> =
            numbers.map(|(name, (value, _))| (name, Value::from(value))).collect();
        let response = match capture.sensor.response {
            Response::Linear => "linear",
            Response::Srgb => "srgb",
            Response::Curve(_) => "curve",
        };
        values.insert("sensor.response".to_owned(), response.into());
        for object in &capture.objects {
            for (part, material) in &object.materials {
                values.insert(format!("object.{}.materials.{part}", object.name), material.as_str().into());
            }
        }
        for material in &capture.materials {
            for role in MapRole::ALL {
                let word = match material.maps.get(role) {
                    None => continue,
                    Some(MapSource::Mesh) => "mesh",
                    Some(MapSource::File(path)) => path,
                };
                values.insert(format!("material.{}.{}", material.name, role.key()), word.into());
            }
            if let Model::Plastic { energy_compensation, .. } = material.model {
                values.insert(format!("material.{}.energy_compensation", material.name), energy_compensation.into());
            }
        }
        Self { values, judged: BTreeMap::new() }
    }

    /// `name`, and every name that begins with it, is kept exactly; `place` says where.
    pub fn exact(&mut self, name: &str, place: &str) {
        self.judge(name, Kept::Exact(place.to_owned()));
    }

    /// As [`Ledger::exact`], for what is approximated: `how`.
    pub fn approximated(&mut self, name: &str, how: &str) {
        self.judge(name, Kept::Approximated(how.to_owned()));
    }

    /// As [`Ledger::exact`], for what is lost: `why`.
    pub fn lost(&mut self, name: &str, why: &str) {
        self.judge(name, Kept::Lost(why.to_owned()));
    }

    /// The lobe of a lamp, if it has one, in a format that has none.
    pub fn lose_lobe(&mut self, light: &Light, why: &str) {
        if light.lobe.exponent > 0.0 {
            for key in ["lobe_exponent", "lobe_axis"] {
                self.lost(&format!("light.{}.{key}", light.name), why);
            }
        }
    }

    /// Of two judgements on one name the worse holds: a number may be kept in one photo and not in another.
    pub fn judge(&mut self, name: &str, kept: Kept) {
        match self.judged.get_mut(name) {
            Some(before) if before.rank() >= kept.rank() => {}
            Some(before) => *before = kept,
            None => {
                self.judged.insert(name.to_owned(), kept);
            }
        }
    }

    /// The judgement with the longest name that `name` begins with.
    fn of(&self, name: &str) -> Option<&Kept> {
        let ends = name.match_indices('.').map(|(at, _)| at).chain([name.len()]);
        ends.filter_map(|end| self.judged.get(&name[..end])).next_back()
    }

    /// All of them, by name.
    pub fn entries(self) -> Vec<Entry> {
        let unknown = || Kept::Lost("this exporter does not know it".to_owned());
        let judge = |(name, value): (&String, &Value)| {
            let kept = self.of(name).cloned().unwrap_or_else(unknown);
            Entry { name: name.clone(), value: value.clone(), kept }
        };
        self.values.iter().map(judge).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_name_and_the_worst_judgement_hold() {
        let mut ledger = Ledger::new(&Capture::default());
        ledger.exact("camera", "there");
        ledger.lost("camera.fy", "pixels are square");
        ledger.exact("camera.fy", "in this photo");
        ledger.approximated("camera.distortion", "nearly");
        let kept = |name: &str| ledger.of(name).map(Kept::word);
        assert_eq!(kept("camera.fx"), Some("exact"));
        assert_eq!(kept("camera.fy"), Some("lost"));
        assert_eq!(kept("camera.distortion.k1"), Some("approximated"));
        // Whole words only.
        assert_eq!(kept("cameras.fx"), None);
        let entries = ledger.entries();
        let gamma = entries.iter().find(|entry| entry.name == "sensor.gamma").unwrap();
        assert_eq!(gamma.kept, Kept::Lost("this exporter does not know it".to_owned()));
    }
}
