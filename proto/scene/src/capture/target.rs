//! Targets: what an evaluation compares with. Photos come first, then files of measured reflectance, both in file order;
//! everywhere behind the capture a photo's index is a target's.

use super::{Capture, Photo, Reflectance, Role, Sensor};

/// A photo, or a file of measured reflectance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target<'a> {
    /// A photo.
    Photo(&'a Photo),
    /// BRDF samples.
    Reflectance(&'a Reflectance),
}

impl<'a> Target<'a> {
    /// Its file's name without folder and extension.
    #[must_use]
    pub fn name(self) -> &'a str {
        match self {
            Self::Photo(photo) => photo.name(),
            Self::Reflectance(reflectance) => reflectance.name(),
        }
    }

    /// What it is used for.
    #[must_use]
    pub fn role(self) -> Role {
        match self {
            Self::Photo(photo) => photo.role,
            Self::Reflectance(reflectance) => reflectance.role,
        }
    }

    /// The paths of the files that hold what was measured.
    pub fn files(self) -> impl Iterator<Item = &'a String> {
        let (file, mask) = match self {
            Self::Photo(photo) => (&photo.file, photo.mask.as_ref()),
            Self::Reflectance(reflectance) => (&reflectance.file, None),
        };
        std::iter::once(file).chain(mask)
    }
}

impl Capture {
    /// Everything that there is to compare with, in the order of the indices.
    pub fn targets(&self) -> impl Iterator<Item = Target<'_>> {
        self.photos.iter().map(Target::Photo).chain(self.reflectance.iter().map(Target::Reflectance))
    }

    /// Target `index`, if there is one.
    #[must_use]
    pub fn target(&self, index: usize) -> Option<Target<'_>> {
        match self.photos.get(index) {
            Some(photo) => Some(Target::Photo(photo)),
            None => self.reflectance.get(index - self.photos.len()).map(Target::Reflectance),
        }
    }

    /// The noise of target `index`: the sensor's own, or for measured reflectance a constant one.
    #[must_use]
    pub fn sensor_of(&self, index: usize) -> Sensor {
        match self.target(index) {
            Some(Target::Reflectance(r)) => Sensor { read_noise: r.noise, ..Sensor::default() },
            _ => self.sensor.clone(),
        }
    }
}
