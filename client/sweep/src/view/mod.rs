//! Virtual cameras: views of a capture that nobody photographed.

mod dataset;
mod pose;

use crate::keys::Keys;
use crate::plan::Label;
use crate::{MOST_PHOTOS, design_unit};
use dataset::{Repeated, Source};
pub(crate) use dataset::{intrinsics, model_to_camera};
use gonio_scene::capture::{CameraOverride, Photo, Range, read_section};
use gonio_scene::files::Files;
use gonio_scene::{Capture, Result};
use pose::{Pose, rotation};
use std::f64::consts::{FRAC_PI_2, TAU};

/// One `[[view]]` of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct View {
    /// What its photos' names begin with.
    name: String,
    kind: Kind,
    /// Factor from radiance to photo value.
    exposure: f64,
    /// The lights that are on; all of them where absent.
    lights: Option<Vec<String>>,
    /// Keys of `[camera]` that it has otherwise.
    camera: CameraOverride,
}

#[derive(Debug, Clone, PartialEq)]
enum Kind {
    Hemisphere(Hemisphere),
    Pose([[f64; 4]; 4]),
    Dataset(Source),
    /// What a dataset has, once it is read.
    Repeated(Vec<Repeated>),
}

/// Cameras around a point, spread evenly over solid angle by an Owen-scrambled Sobol sequence: a larger `count` keeps the
/// views of a smaller one. All intervals are [least, most].
#[derive(Debug, Clone, PartialEq)]
struct Hemisphere {
    /// What all look at, world coordinates, metres.
    target: [f64; 3],
    /// Metres from the target.
    radius: [f64; 2],
    /// Radians above the horizontal plane.
    elevation: [f64; 2],
    /// Radians from the world's x axis towards y.
    azimuth: [f64; 2],
    /// Radians by which the camera is turned clockwise about its view.
    roll: [f64; 2],
    count: u64,
    seed: u32,
}

impl View {
    /// Reads one `[[view]]`.
    pub fn read(mut keys: Keys<'_>) -> Result<Self> {
        let name = keys.text("name")?;
        let name = keys.needed("name", name, "a name for its photos, such as \"dome\"")?.to_owned();
        if !name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_') {
            return Err(keys.refuse("name", format!("is \"{name}\""), "use letters, digits, - and _ only"));
        }
        let kind = keys.word("kind", &[("hemisphere", 0), ("look-at", 1), ("pose", 2), ("bop", 3)])?;
        let kind = match keys.needed("kind", kind, "one of: \"hemisphere\", \"look-at\", \"pose\", \"bop\"")? {
            0 => Kind::Hemisphere(Hemisphere::read(&mut keys)?),
            1 => {
                let (position, target) = (point(&mut keys, "position")?, point(&mut keys, "target")?);
                let position = keys.needed("position", position, "where the camera is: [x, y, z] in metres")?;
                let target = keys.needed("target", target, "what it looks at: [x, y, z] in metres")?;
                let roll = keys.number("roll", Range::ANY)?.unwrap_or(0.0);
                let pose = Pose::between(position, target, roll);
                let mend = "move the camera away from what it looks at";
                Kind::Pose(pose.ok_or_else(|| keys.refuse("position", "is the target", mend))?.camera_to_world())
            }
            2 => Kind::Pose(matrix(&mut keys)?),
            _ => Kind::Dataset(Source::read(&mut keys)?),
        };
        let exposure = keys.number("exposure", Range::POSITIVE)?.unwrap_or(1.0);
        let lights = keys.texts("lights")?.map(|words| words.into_iter().map(str::to_owned).collect());
        let mut camera = CameraOverride::default();
        if let Some(value) = keys.value("camera") {
            let table = value.as_table();
            let table = table.ok_or_else(|| keys.refuse("camera", "is no table", "write [view.camera] below it"))?;
            read_section(keys.file(), &format!("{}.camera", keys.path()), table, &mut camera)?;
        }
        keys.finish()?;
        Ok(Self { name, kind, exposure, lights, camera })
    }

    /// How many photos it stands for.
    pub fn count(&self) -> u64 {
        match &self.kind {
            Kind::Hemisphere(dome) => dome.count,
            Kind::Pose(_) | Kind::Dataset(_) => 1,
            Kind::Repeated(images) => images.len() as u64,
        }
    }

    /// The view with what it takes from other files, which `files` reads.
    ///
    /// # Errors
    /// A dataset that cannot be read or has no such object.
    pub fn resolved(&self, capture: &Capture, files: &dyn Files) -> Result<Self> {
        let kind = match &self.kind {
            Kind::Dataset(source) => Kind::Repeated(source.images(capture, files)?),
            other => other.clone(),
        };
        Ok(Self { kind, ..self.clone() })
    }

    /// Appends its photos to those of `capture`, and what they repeat to `labels`; their files do not exist.
    pub fn extend(&self, capture: &mut Capture, labels: &mut Vec<Option<Label>>) {
        let photo = |name: String, camera_to_world| Photo {
            file: format!("{name}.exr"),
            exposure: self.exposure,
            camera_to_world,
            camera: self.camera.clone(),
            lights: self.lights.clone(),
            ..Photo::default()
        };
        match &self.kind {
            Kind::Pose(matrix) => capture.photos.push(photo(self.name.clone(), *matrix)),
            // What is not resolved stands for nothing yet.
            Kind::Dataset(_) => {}
            Kind::Repeated(images) => {
                for image in images {
                    let Label { scene, image: number } = image.label;
                    let mut photo = photo(format!("{}-{scene:06}-{number:06}", self.name), image.camera_to_world);
                    photo.camera = image.camera(&self.camera);
                    capture.photos.push(photo);
                    labels.push(Some(image.label));
                }
            }
            Kind::Hemisphere(dome) => {
                let digits = (dome.count - 1).to_string().len().max(3);
                let view = |i: u64| photo(format!("{}-{i:0digits$}", self.name), dome.pose(i).camera_to_world());
                capture.photos.extend((0..dome.count).map(view));
            }
        }
        labels.resize(capture.photos.len(), None);
    }
}

impl Hemisphere {
    fn read(keys: &mut Keys<'_>) -> Result<Self> {
        let (target, count) = (point(keys, "target")?, keys.whole("count", 1..=MOST_PHOTOS)?);
        let radius = interval(keys, "radius", Range::POSITIVE)?;
        let angle = |most: f64| Range { min: -most, max: most };
        Ok(Self {
            target: keys.needed("target", target, "what the cameras look at: [x, y, z] in metres")?,
            radius: keys.needed("radius", radius, "a distance in metres, or [least, most]")?,
            elevation: interval(keys, "elevation", angle(FRAC_PI_2))?.unwrap_or([0.0, FRAC_PI_2]),
            azimuth: interval(keys, "azimuth", angle(2.0 * TAU))?.unwrap_or([0.0, TAU]),
            roll: interval(keys, "roll", angle(TAU))?.unwrap_or([0.0; 2]),
            count: keys.needed("count", count, "the number of views")?,
            seed: keys.whole("seed", 0..=u64::from(u32::MAX))?.unwrap_or(0) as u32,
        })
    }

    fn pose(&self, i: u64) -> Pose {
        let between =
            |[least, most]: [f64; 2], dimension| least + design_unit(i, dimension, self.seed) * (most - least);
        // Equal parts of a sphere's height have equal area (Archimedes).
        let height = between(self.elevation.map(libm::sin), 1);
        Pose {
            target: self.target,
            azimuth: between(self.azimuth, 0),
            elevation: libm::asin(height.clamp(-1.0, 1.0)).clamp(self.elevation[0], self.elevation[1]),
            distance: between(self.radius, 2),
            roll: between(self.roll, 3),
        }
    }
}

fn point(keys: &mut Keys<'_>, key: &'static str) -> Result<Option<[f64; 3]>> {
    Ok(keys.numbers(key, 3, Range::ANY)?.map(|v| [v[0], v[1], v[2]]))
}

/// One number, or [least, most].
fn interval(keys: &mut Keys<'_>, key: &'static str, range: Range) -> Result<Option<[f64; 2]>> {
    if keys.value(key).is_some_and(|value| value.as_array().is_none()) {
        return Ok(keys.number(key, range)?.map(|value| [value, value]));
    }
    let Some(ends) = keys.numbers(key, 2, range)? else { return Ok(None) };
    if ends[0] > ends[1] {
        return Err(keys.refuse(key, format!("runs from {} down to {}", ends[0], ends[1]), "write [least, most]"));
    }
    Ok(Some([ends[0], ends[1]]))
}

fn matrix(keys: &mut Keys<'_>) -> Result<[[f64; 4]; 4]> {
    let what = "four rows of four numbers, the last [0, 0, 0, 1]";
    let value = keys.value("camera_to_world");
    let rows = keys.needed("camera_to_world", value.and_then(|value| value.as_array()), what)?;
    let mut matrix = [[0.0; 4]; 4];
    let mend = || keys.refuse("camera_to_world", "is no 4x4 matrix", format!("write {what}"));
    if rows.len() != 4 {
        return Err(mend());
    }
    for (row, given) in matrix.iter_mut().zip(rows) {
        let given = given.as_array().filter(|given| given.len() == 4).ok_or_else(mend)?;
        for (entry, value) in row.iter_mut().zip(given) {
            *entry = keys.to_number("camera_to_world", value, Range::ANY)?;
        }
    }
    if matrix[3] != [0.0, 0.0, 0.0, 1.0] {
        return Err(mend());
    }
    rotation(&matrix)
        .map_err(|problem| keys.refuse("camera_to_world", problem, "write a rotation and a translation, row-major"))?;
    Ok(matrix)
}
