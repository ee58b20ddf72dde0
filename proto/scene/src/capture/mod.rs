//! The capture: a folder of measured data, known geometry and first guesses, as `capture.toml` describes it.

pub mod camera;
pub mod curve;
pub mod effects;
pub mod freed;
pub mod light;
pub mod maps;
pub mod material;
mod numbers;
pub mod object;
pub mod photo;
mod read;
pub mod reflectance;
pub mod sensor;
pub mod target;
pub mod tracing;
pub mod visit;
mod write;

pub use camera::{Camera, CameraOverride};
pub use curve::ResponseCurve;
pub use effects::{Effects, LONGEST_SCATTER, NULL_STEP, VARIATIONS};
pub use freed::Freed;
pub use light::{Frame, Light, LightKind, Lobe};
pub use maps::{MapSource, Maps, Role as MapRole};
pub use material::{Material, Model};
pub use object::Object;
pub use photo::{Photo, Role};
pub(crate) use read::{SLIP, edit_distance};
pub use read::{read_section, unknown_key_mend};
pub use reflectance::Reflectance;
pub use sensor::{Response, Sensor, srgb};
pub use target::Target;
pub use tracing::Tracing;
pub use visit::Range;

use crate::files::Files;
use crate::{Result, SceneError};
use numbers::Walker;
use read::Reader;
use std::collections::BTreeSet;
use toml::{Table, Value};
use visit::Section;

/// The name of the file that describes a capture.
pub const CAPTURE_FILE: &str = "capture.toml";

/// A capture, without the contents of the files that it names.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Capture {
    /// Its name, for reports.
    pub name: String,
    /// The camera of every photo that does not override it.
    pub camera: Camera,
    /// Noise, saturation and response.
    pub sensor: Sensor,
    /// Conventions of the ray tracer.
    pub tracing: Tracing,
    /// Named materials.
    pub materials: Vec<Material>,
    /// Named objects.
    pub objects: Vec<Object>,
    /// Named lights.
    pub lights: Vec<Light>,
    /// The photos, in file order.
    pub photos: Vec<Photo>,
    /// Measured reflectance, in file order.
    pub reflectance: Vec<Reflectance>,
    /// What a fit frees.
    pub fit: Freed,
}

const TOP_LEVEL: [&str; 11] =
    ["format", "name", "camera", "sensor", "tracing", "material", "object", "light", "photo", "reflectance", "fit"];

impl Capture {
    /// Reads `capture.toml` from a capture's files.
    ///
    /// # Errors
    /// Anything that is not the format of `FORMAT.md`: unknown keys, wrong types, values out of range, names that do not
    /// resolve. Of the files that it names only a response's is opened; for the others see [`crate::assets`].
    pub fn read(files: &dyn Files) -> Result<Self> {
        Self::read_scene(files)?.measured()
    }

    /// Reads the `capture.toml` of `files`, which may be a scene alone: without anything measured, for those who add views.
    ///
    /// # Errors
    /// As [`Capture::read`], but for what is missing.
    pub fn read_scene(files: &dyn Files) -> Result<Self> {
        let bytes = files.read(CAPTURE_FILE)?;
        let text = std::str::from_utf8(&bytes)
            .map_err(|e| SceneError::new(CAPTURE_FILE, format!("is not UTF-8 text ({e})"), "save it as UTF-8"))?;
        let mut top = to_table(text)?;
        curve::inline(CAPTURE_FILE, &mut top, files)?;
        Self::of_table(&top)
    }

    /// Reads the text of a `capture.toml` that lies beside `files`.
    ///
    /// # Errors
    /// As [`Capture::read`].
    pub fn parse_beside(text: &str, files: &dyn Files) -> Result<Self> {
        let mut top = to_table(text)?;
        curve::inline(CAPTURE_FILE, &mut top, files)?;
        Self::of_table(&top)?.measured()
    }

    /// Reads the text of a `capture.toml` that names no response's file, such as [`Capture::to_toml`] writes.
    ///
    /// # Errors
    /// As [`Capture::read`].
    pub fn parse(text: &str) -> Result<Self> {
        Self::of_table(&to_table(text)?)?.measured()
    }

    fn of_table(top: &Table) -> Result<Self> {
        let file = CAPTURE_FILE;
        for key in top.keys() {
            if !TOP_LEVEL.contains(&key.as_str()) {
                let mend = unknown_key_mend(key, TOP_LEVEL.iter().copied());
                return Err(SceneError::new(file, "is not a key that this version knows", mend).at(key.as_str()));
            }
        }
        match top.get("format") {
            Some(Value::Integer(1)) => {}
            Some(other) => {
                return Err(SceneError::new(
                    file,
                    format!("is {other}; this version reads format 1"),
                    "write format = 1",
                )
                .at("format"));
            }
            None => return Err(SceneError::new(file, "is missing", "write format = 1").at("format")),
        }
        let Some(Value::String(name)) = top.get("name") else {
            return Err(SceneError::new(file, "is missing or no text", "write name = \"...\"").at("name"));
        };
        let mut capture = Self { name: name.clone(), ..Self::default() };
        let empty = Table::new();
        let table = |key: &str| match top.get(key) {
            None => Ok(&empty),
            Some(Value::Table(t)) => Ok(t),
            Some(v) => {
                Err(SceneError::new(file, format!("is a TOML {}", v.type_str()), format!("write [{key}]")).at(key))
            }
        };
        // Without a photo nothing is seen by a camera.
        if top.contains_key("camera") || top.contains_key("photo") || !top.contains_key("reflectance") {
            Reader::new(file, "camera".into(), table("camera")?).read(&mut capture.camera)?;
        }
        Reader::new(file, "sensor".into(), table("sensor")?).read(&mut capture.sensor)?;
        Reader::new(file, "tracing".into(), table("tracing")?).read(&mut capture.tracing)?;
        Reader::new(file, "fit".into(), table("fit")?).read(&mut capture.fit)?;
        capture.materials = read_list(file, top, "material")?;
        capture.objects = read_list(file, top, "object")?;
        capture.lights = read_list(file, top, "light")?;
        capture.photos = read_list(file, top, "photo")?;
        capture.reflectance = read_list(file, top, "reflectance")?;
        capture.check()?;
        Ok(capture)
    }

    /// The text of a `capture.toml` that reads back as this capture, to the last bit. A response's curve stands in it.
    ///
    /// # Errors
    /// A value that [`Capture::parse`] would refuse.
    pub fn to_toml(&self) -> Result<String> {
        let mut copy = self.clone();
        copy.check()?;
        let mut top = Table::new();
        top.insert("format".into(), Value::Integer(1));
        top.insert("name".into(), Value::String(copy.name.clone()));
        if !copy.photos.is_empty() || copy.camera != Camera::default() {
            top.insert("camera".into(), Value::Table(write::write(&mut copy.camera)?));
        }
        if !copy.sensor.is_empty() {
            top.insert("sensor".into(), Value::Table(write::write(&mut copy.sensor)?));
        }
        if !copy.tracing.is_empty() {
            top.insert("tracing".into(), Value::Table(write::write(&mut copy.tracing)?));
        }
        write_list(&mut top, "material", &mut copy.materials)?;
        write_list(&mut top, "object", &mut copy.objects)?;
        write_list(&mut top, "light", &mut copy.lights)?;
        write_list(&mut top, "photo", &mut copy.photos)?;
        write_list(&mut top, "reflectance", &mut copy.reflectance)?;
        if !copy.fit.is_empty() {
            top.insert("fit".into(), Value::Table(write::write(&mut copy.fit)?));
        }
        toml::to_string(&top).map_err(|e| SceneError::new(CAPTURE_FILE, e.to_string(), "report this"))
    }

    /// Calls `each` for every number of the capture: dotted name, value, bounds.
    ///
    /// # Errors
    /// A section whose values contradict each other, as [`Capture::parse`] would refuse it.
    pub fn for_each_number(&mut self, each: &mut dyn FnMut(&str, &mut f64, Range)) -> Result<()> {
        self.for_each_number_in(&|_| true, each)
    }

    /// As [`Capture::for_each_number`], of the sections alone whose dotted name `wanted` accepts: a capture may have
    /// thousands of photos, and naming all of their numbers takes longer than rendering a small one.
    pub(crate) fn for_each_number_in(
        &mut self,
        wanted: &dyn Fn(&str) -> bool,
        each: &mut dyn FnMut(&str, &mut f64, Range),
    ) -> Result<()> {
        let mut walk = |path: String, section: &mut dyn Section| {
            if wanted(&path) { section.describe(&mut Walker { path, each }) } else { Ok(()) }
        };
        walk("camera".into(), &mut self.camera)?;
        walk("sensor".into(), &mut self.sensor)?;
        walk("tracing".into(), &mut self.tracing)?;
        for m in &mut self.materials {
            walk(format!("material.{}", m.name), m)?;
        }
        for o in &mut self.objects {
            walk(format!("object.{}", o.name), o)?;
        }
        for l in &mut self.lights {
            walk(format!("light.{}", l.name), l)?;
        }
        for p in &mut self.photos {
            walk(format!("photo.{}", p.name()), p)?;
        }
        for r in &mut self.reflectance {
            walk(format!("reflectance.{}", r.name()), r)?;
        }
        Ok(())
    }

    /// Index of a photo by its name.
    #[must_use]
    pub fn photo_index(&self, name: &str) -> Option<usize> {
        self.photos.iter().position(|p| p.name() == name)
    }

    /// Index of a material by its name.
    #[must_use]
    pub fn material_index(&self, name: &str) -> Option<usize> {
        self.materials.iter().position(|m| m.name == name)
    }

    /// The camera of photo `index`, overrides applied.
    #[must_use]
    pub fn camera_of(&self, photo: &Photo) -> Camera {
        photo.camera.over(&self.camera)
    }

    /// This capture, if it holds something that was measured.
    fn measured(self) -> Result<Self> {
        if self.targets().next().is_none() {
            let mend = "add at least one photo, or measured [[reflectance]]";
            return Err(SceneError::new(CAPTURE_FILE, "is missing: there is no [[photo]]", mend).at("photo"));
        }
        Ok(self)
    }

    /// What no single section can know: names are unique and resolve.
    fn check(&self) -> Result<()> {
        let refuse =
            |key: String, problem: String, mend: &str| Err(SceneError::new(CAPTURE_FILE, problem, mend).at(key));
        unique("material", self.materials.iter().map(|m| m.name.as_str()))?;
        unique("object", self.objects.iter().map(|o| o.name.as_str()))?;
        unique("light", self.lights.iter().map(|l| l.name.as_str()))?;
        unique("photo", self.photos.iter().map(Photo::name))?;
        // Reports and output files know both by name alone.
        unique("reflectance", self.targets().map(Target::name))?;
        for r in &self.reflectance {
            if !self.materials.iter().any(|m| m.name == r.material) {
                return refuse(
                    format!("reflectance.{}.material", r.name()),
                    format!("names \"{}\", which is no material here", r.material),
                    "name a [[material]] of this capture",
                );
            }
        }
        for o in &self.objects {
            let own = std::iter::once((format!("object.{}.material", o.name), &o.material));
            let of_parts = o.materials.iter().map(|(part, name)| (format!("object.{}.materials.{part}", o.name), name));
            if let Some((key, name)) = own.chain(of_parts).find(|(_, name)| self.material_index(name).is_none()) {
                let problem = format!("names \"{name}\", which is no material here");
                return refuse(key, problem, "name a [[material]] of this capture");
            }
        }
        for p in &self.photos {
            for light in p.lights.iter().flatten() {
                if !self.lights.iter().any(|l| l.name == *light) {
                    return refuse(
                        format!("photo.{}.lights", p.name()),
                        format!("names \"{light}\", which is no light here"),
                        "name a [[light]] of this capture",
                    );
                }
            }
            let on = self.lights.iter().filter(|l| p.lights.as_ref().is_none_or(|on| on.contains(&l.name)));
            if on.filter(|l| matches!(l.kind, LightKind::Map { .. })).count() > 1 {
                return refuse(
                    format!("photo.{}.lights", p.name()),
                    "has two environment maps on".into(),
                    "keep one map per photo; light of constant radiance may be beside it",
                );
            }
        }
        self.partly_present()?;
        self.free_parameters().map(|_| ())
    }

    /// Index of the object that was there for a part of the exposure only, if one was.
    ///
    /// # Errors
    /// Two of them: their shares do not say for how long both were there.
    pub fn partly_present(&self) -> Result<Option<usize>> {
        let mut partly = self.objects.iter().enumerate().filter(|(_, o)| o.presence > 0.0 && o.presence < 1.0);
        let first = partly.next();
        if let (Some((_, a)), Some((_, b))) = (first, partly.next()) {
            return Err(SceneError::new(
                CAPTURE_FILE,
                format!("is between 0 and 1, as is object.{}.presence", a.name),
                "keep one object at most whose presence is neither 0 nor 1",
            )
            .at(format!("object.{}.presence", b.name)));
        }
        Ok(first.map(|(index, _)| index))
    }
}

fn to_table(text: &str) -> Result<Table> {
    text.parse().map_err(|e: toml::de::Error| {
        let problem = format!("is not TOML: {}", e.to_string().trim().replace('\n', " "));
        SceneError::new(CAPTURE_FILE, problem, "mend the syntax there")
    })
}

fn unique<'a>(what: &str, names: impl Iterator<Item = &'a str>) -> Result<()> {
    let mut seen = BTreeSet::new();
    for name in names {
        if !seen.insert(name) {
            let mend = match what {
                "photo" => "give one of them a `name`: a photo's name is its file's otherwise",
                "reflectance" => "rename one file: its name counts, among the photos' too",
                _ => "rename one",
            };
            return Err(SceneError::new(CAPTURE_FILE, "is a name given twice", mend).at(format!("{what}.{name}")));
        }
    }
    Ok(())
}

fn read_list<T: Section + Default>(file: &str, top: &Table, key: &str) -> Result<Vec<T>> {
    let Some(value) = top.get(key) else { return Ok(Vec::new()) };
    let wrong = || SceneError::new(file, "is no list of tables", format!("write [[{key}]]")).at(key);
    let list = value.as_array().ok_or_else(wrong)?;
    let mut out = Vec::with_capacity(list.len());
    for (i, entry) in list.iter().enumerate() {
        let table = entry.as_table().ok_or_else(wrong)?;
        let name = table.get("name").or_else(|| table.get("file")).and_then(Value::as_str);
        let path = name.map_or_else(|| format!("{key}[{i}]"), |n| format!("{key}.{n}"));
        let mut section = T::default();
        Reader::new(file, path, table).read(&mut section)?;
        out.push(section);
    }
    Ok(out)
}

fn write_list<T: Section>(top: &mut Table, key: &str, sections: &mut [T]) -> Result<()> {
    if sections.is_empty() {
        return Ok(());
    }
    let tables = sections.iter_mut().map(|s| write::write(s).map(Value::Table)).collect::<Result<_>>()?;
    top.insert(key.into(), Value::Array(tables));
    Ok(())
}
