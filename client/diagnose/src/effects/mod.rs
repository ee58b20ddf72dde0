//! The catalogue of effects: what a simple renderer leaves out of real photographs, one file each.
//!
//! An effect is a patch to a capture: keys at their null value, which change nothing, and the names that it frees. To add
//! one, write a file with an `EFFECT` and name it in [`CATALOGUE`]; the keys themselves belong to the capture format.

mod albedo_variation;
mod ambient_light;
mod anisotropy;
mod black_level;
mod bumps;
mod clear_coat;
mod clipping;
mod crosstalk;
mod defocus;
mod diffuse_roughness;
mod lens_distortion;
mod light_flicker;
mod light_lobe;
mod light_position;
mod light_size;
mod metallic;
mod missing_object;
mod pose_error;
mod response_gamma;
mod roughness_variation;
mod second_light;
mod second_lobe;
mod sheen;
mod translucency;
mod veiling_glare;
mod vignetting;

use crate::context::Context;
use crate::overlay::AddedFile;
use gonio_scene::Capture;
use gonio_scene::capture::VARIATIONS;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Every effect that a diagnosis considers, by family.
pub const CATALOGUE: [&Effect; 26] = [
    &diffuse_roughness::EFFECT,
    &second_lobe::EFFECT,
    &clear_coat::EFFECT,
    &metallic::EFFECT,
    &anisotropy::EFFECT,
    &sheen::EFFECT,
    &albedo_variation::EFFECT,
    &roughness_variation::EFFECT,
    &translucency::EFFECT,
    &ambient_light::EFFECT,
    &second_light::EFFECT,
    &light_position::EFFECT,
    &light_size::EFFECT,
    &light_lobe::EFFECT,
    &light_flicker::EFFECT,
    &pose_error::EFFECT,
    &missing_object::EFFECT,
    &bumps::EFFECT,
    &vignetting::EFFECT,
    &response_gamma::EFFECT,
    &black_level::EFFECT,
    &clipping::EFFECT,
    &veiling_glare::EFFECT,
    &defocus::EFFECT,
    &lens_distortion::EFFECT,
    &crosstalk::EFFECT,
];

/// Where an effect belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Family {
    /// What a surface does to light.
    Material,
    /// Where light comes from.
    Light,
    /// What stands where.
    Geometry,
    /// Lens, sensor and file.
    Camera,
}

/// One entry of the catalogue.
#[derive(Debug)]
pub struct Effect {
    /// Its name, as a diagnosis reports it.
    pub name: &'static str,
    /// Where it belongs.
    pub family: Family,
    /// How the residual looks.
    pub looks: &'static str,
    /// Effects that it is easily taken for.
    pub looks_like: &'static [&'static str],
    /// The measurement that tells it from those.
    pub separate_by: &'static str,
    /// The ways in which it may be present in a capture: one per subject (material, light, object) and per value of a
    /// nuisance that does not exist at the null. Empty where the capture has nothing that it could act on.
    pub variants: fn(&Context<'_>) -> Vec<Variant>,
}

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
    /// Whether each number belongs to one photo, so that other photos say nothing about it.
    pub of_photos: bool,
}

/// Something that a variant adds to a capture.
#[derive(Debug, Clone)]
pub enum Structure {
    /// A light, at intensity or radiance zero.
    Light(gonio_scene::capture::Light),
    /// An object that is absent (presence 0), its material, and the contents of its mesh file.
    Object(Box<(gonio_scene::capture::Object, gonio_scene::capture::Material)>, &'static [u8]),
    /// A point light becomes a sphere of radius zero.
    PointToSphere(String),
}

/// A direction in which the model may be wrong: one column of the score.
#[derive(Debug, Clone, PartialEq)]
pub struct Direction {
    /// The number whose value is reported.
    pub name: String,
    /// Further numbers that move along with it: name, and how far while `name` moves by one.
    pub along: Vec<(String, f64)>,
    /// The finite difference's step; where absent, the number's own derivative is used.
    pub step: Option<f64>,
    /// The step that the number's own derivative takes at its null, where it has none of first order there.
    pub step_at_null: Option<f64>,
    /// The derivative is with respect to this power of the number, 1 or 2: a size that enters squared.
    pub power: i32,
    /// Value that changes nothing.
    pub null: f64,
    /// Whether the number can only be above its null.
    pub one_sided: bool,
    /// Largest sensible distance from the null, beyond which an expected change is cut.
    pub most: f64,
    /// The only channel that the direction is seen in.
    pub channel: Option<usize>,
}

impl Direction {
    /// A number that may go either way from `null`.
    #[must_use]
    pub fn of(name: String, null: f64, most: f64) -> Self {
        Self {
            name,
            along: Vec::new(),
            step: None,
            step_at_null: None,
            power: 1,
            null,
            one_sided: false,
            most,
            channel: None,
        }
    }

    /// A number that can only grow from 0.
    #[must_use]
    pub fn growing(name: String, most: f64) -> Self {
        Self { one_sided: true, ..Self::of(name, 0.0, most) }
    }

    /// By a finite difference with this step.
    #[must_use]
    pub fn by_step(self, step: f64) -> Self {
        Self { step: Some(step), ..self }
    }

    /// Seen in one channel alone.
    #[must_use]
    pub fn in_channel(self, channel: usize) -> Self {
        Self { channel: Some(channel), ..self }
    }

    /// Scored by its square.
    #[must_use]
    pub fn squared(self) -> Self {
        Self { power: 2, ..self }
    }

    /// While another number is set to `value`, from `now`: at the null it makes no difference.
    #[must_use]
    pub fn with(mut self, number: String, now: f64, value: f64) -> Self {
        if let Some(step) = self.step {
            self.along.push((number, (value - now) / step));
        }
        self
    }
}

impl Variant {
    /// A variant of these directions that frees what it moves.
    #[must_use]
    pub fn of(label: impl Into<String>, directions: Vec<Direction>) -> Self {
        let free = directions.iter().map(|d| d.name.clone()).collect();
        Self {
            label: label.into(),
            structure: Vec::new(),
            settings: Vec::new(),
            directions,
            free,
            finer: Vec::new(),
            gray: Vec::new(),
            search: Vec::new(),
            of_photos: false,
        }
    }

    /// With a number that does not exist at the null set to `value`, and freed too.
    #[must_use]
    pub fn nuisance(mut self, number: String, value: f64) -> Self {
        self.free.push(number.clone());
        self.settings.push((number, value));
        self
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

impl Structure {
    /// Adds it to a capture, once; returns the file that came with it.
    pub fn add(&self, capture: &mut Capture) -> Option<AddedFile> {
        use gonio_scene::capture::LightKind;
        match self {
            Self::Light(light) => {
                if capture.lights.iter().any(|l| l.name == light.name) {
                    return None;
                }
                capture.lights.push(light.clone());
                // A photo that lists its lights had this one on as well.
                for photo in &mut capture.photos {
                    if let Some(on) = &mut photo.lights {
                        on.push(light.name.clone());
                    }
                }
                None
            }
            Self::Object(added, mesh) => {
                let (object, material) = &**added;
                if !capture.objects.iter().any(|o| o.name == object.name) {
                    capture.objects.push(object.clone());
                    capture.materials.push(material.clone());
                }
                Some((object.mesh.clone(), Arc::from(*mesh)))
            }
            Self::PointToSphere(name) => {
                for light in capture.lights.iter_mut().filter(|l| l.name == *name) {
                    if let LightKind::Point { position, intensity } = light.kind {
                        light.kind = LightKind::Sphere { position, radius: 0.0, intensity };
                    }
                }
                None
            }
        }
    }
}

/// The three names of a colour's channels.
fn rgb(name: &str) -> [String; 3] {
    ["r", "g", "b"].map(|c| format!("{name}.{c}"))
}

/// The three names of a point's coordinates.
fn xyz(name: &str) -> [String; 3] {
    ["x", "y", "z"].map(|c| format!("{name}.{c}"))
}

/// Coefficients over an object's box of degree at most 3, which are scored, and at most 4, 5 and 6.
const DEGREES: [usize; 4] = [19, 34, 55, VARIATIONS];

/// A material that varies over its object: scored in the coarsest patterns, fitted with as many as the photos support.
fn over_the_surface(material: &str, key: &str, most: f64) -> Variant {
    let names: Vec<String> = (0..VARIATIONS).map(|k| format!("material.{material}.{key}.{k}")).collect();
    let directions = names[..DEGREES[0]].iter().map(|n| Direction::of(n.clone(), 0.0, most)).collect();
    let finer = DEGREES.windows(2).map(|d| names[d[0]..d[1]].to_vec()).collect();
    Variant { finer, free: names, ..Variant::of(material, directions) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_known_to_each_other() {
        let names: BTreeSet<_> = CATALOGUE.iter().map(|e| e.name).collect();
        assert_eq!(names.len(), CATALOGUE.len());
        for effect in CATALOGUE {
            let known = |n: &&str| names.contains(n) || ["ior", "roughness", "light colour", "exposure"].contains(n);
            assert!(effect.looks_like.iter().all(known), "{}", effect.name);
        }
    }
}
