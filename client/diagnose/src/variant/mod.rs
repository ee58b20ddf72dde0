//! One way in which an effect may be present: what it adds, which directions are scored, what a fit frees.

mod direction;
mod structure;

pub use direction::Direction;
pub use structure::Structure;

use crate::overlay::AddedFile;
use gonio_scene::Capture;
use gonio_scene::capture::Range;
use std::collections::{BTreeMap, BTreeSet};

/// One way in which an effect may be present.
#[derive(Debug, Clone)]
pub struct Variant {
    /// What tells it from the effect's others: a subject, a nuisance's value.
    pub label: String,
    /// What it adds to a capture before any of its numbers has a name; must leave what the capture means as it is.
    pub structure: Vec<Structure>,
    /// Numbers that do not matter at the null (a coat's roughness), to be set where the effect is present.
    pub settings: Vec<(String, f64)>,
    /// The directions that are scored, together.
    pub directions: Vec<Direction>,
    /// Names that a refit frees.
    pub free: Vec<String>,
    /// Among them finer coefficients of what the directions begin, 0 at the null, that no score sees: one group for each degree
    /// of fineness, of which a refit frees as many as predict photos left out.
    pub finer: Vec<Vec<String>>,
    /// Colours among them that keep their ratio.
    pub gray: Vec<String>,
    /// Moves of the search before the refit, of numbers that say where something is: there a gradient sees only as far as an
    /// edge is wide. Each moves some numbers together; its first step is so much of each.
    pub search: Vec<Vec<(String, f64)>>,
    /// Numbers that a fit must leave above a value, for what is below is another effect: a halo as narrow as an edge is a blur.
    pub above: Vec<(String, f64)>,
    /// Whether each number belongs to one photo, so that other photos say nothing about it.
    pub of_photos: bool,
    /// The photo (its index) that all of its numbers belong to, if one alone is suspected.
    pub suspect: Option<usize>,
    /// The key of every photo that a photo which is held out needs as well, since no other predicts it.
    pub of_held_out: Option<&'static str>,
}

impl Variant {
    /// A variant of these directions that frees what it moves.
    #[must_use]
    pub fn of(label: impl Into<String>, directions: Vec<Direction>) -> Self {
        let free = directions.iter().map(|d| d.moves().to_owned()).collect();
        Self {
            label: label.into(),
            structure: Vec::new(),
            settings: Vec::new(),
            directions,
            free,
            finer: Vec::new(),
            gray: Vec::new(),
            search: Vec::new(),
            above: Vec::new(),
            of_photos: false,
            suspect: None,
            of_held_out: None,
        }
    }

    /// With a number that does not exist at the null set to `value`, and freed too.
    #[must_use]
    pub fn nuisance(mut self, number: String, value: f64) -> Self {
        self.free.push(number.clone());
        self.settings.push((number, value));
        self
    }

    /// With a number below which it would be another effect.
    #[must_use]
    pub fn only_above(mut self, number: String, least: f64) -> Self {
        self.above.push((number, least));
        self
    }

    /// A number that a fit has left where this would be another effect: its name, its value, and the least.
    #[must_use]
    pub fn strayed(&self, numbers: &BTreeMap<String, (f64, Range)>) -> Option<(&str, f64, f64)> {
        let mut each =
            self.above.iter().filter_map(|(name, least)| Some((name.as_str(), numbers.get(name)?.0, *least)));
        each.find(|(_, value, least)| value < least)
    }

    /// With each of these numbers searched for, in steps of at first `step`.
    #[must_use]
    pub fn searching(mut self, numbers: &[String], step: f64) -> Self {
        self.search.extend(numbers.iter().map(|n| vec![(n.clone(), step)]));
        self
    }

    /// With a move of several numbers searched along, at first by so much of each.
    #[must_use]
    pub fn searching_along(mut self, mut step: Vec<(String, f64)>) -> Self {
        step.retain(|(_, by)| *by != 0.0);
        self.search.push(step);
        self
    }

    /// The numbers that are searched for.
    #[must_use]
    pub fn searched(&self) -> BTreeSet<&str> {
        self.search.iter().flatten().map(|(name, _)| name.as_str()).collect()
    }

    /// Adds its structure to a capture, and the files that come with it, each once, to `files`.
    pub fn add_to(&self, capture: &mut Capture, files: &mut Vec<AddedFile>) {
        for file in self.structure.iter().filter_map(|structure| structure.add(capture)) {
            if !files.iter().any(|known| known.0 == file.0) {
                files.push(file);
            }
        }
    }

    /// With the first `groups` of its finer coefficients only.
    #[must_use]
    pub fn as_fine_as(&self, groups: usize) -> Self {
        let mut coarse = self.clone();
        for name in coarse.finer.split_off(groups.min(self.finer.len())).concat() {
            coarse.free.retain(|free| *free != name);
        }
        coarse
    }

    /// With something added to the capture.
    #[must_use]
    pub fn adding(mut self, structure: Structure) -> Self {
        self.structure.push(structure);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_that_strays_is_another_effect() {
        let halo = Variant::of("halo", Vec::new()).only_above("camera.glare_width".to_owned(), 1.5);
        let numbers = |width| BTreeMap::from([("camera.glare_width".to_owned(), (width, Range::POSITIVE))]);
        assert_eq!(halo.strayed(&numbers(0.5)), Some(("camera.glare_width", 0.5, 1.5)));
        assert_eq!(halo.strayed(&numbers(2.0)), None);
        assert_eq!(halo.strayed(&BTreeMap::new()), None);
    }
}
