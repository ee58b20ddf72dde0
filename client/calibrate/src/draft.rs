//! The draft of a `capture.toml`: whatever was guessed says so in a comment.

use crate::view::View;
use gonio_scene::Result;
use gonio_scene::capture::{
    Camera, CameraOverride, Capture, Frame, Light, LightKind, Lobe, Material, Model, Object, Photo, Response,
};
use std::collections::{BTreeMap, BTreeSet};

/// A mesh and where it lies.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Name of the object.
    pub name: String,
    /// The mesh file, relative to the capture.
    pub mesh: String,
    /// Affine, row-major, to metres.
    pub object_to_world: [[f64; 4]; 4],
    /// Why that is a guess; empty where it is none.
    pub guess: String,
}

/// A comment above a key of a section, or above the section where `key` is empty.
#[derive(Debug, Clone)]
struct Note {
    section: &'static str,
    /// The section's `name` or `file`; empty for any.
    name: String,
    key: &'static str,
    text: String,
}

/// A capture with comments.
#[derive(Debug, Clone)]
pub struct Draft {
    /// The capture.
    pub capture: Capture,
    /// The file of a measured response, relative to the capture.
    response: Option<String>,
    notes: Vec<Note>,
}

const MATERIAL: &str = "surface";

impl Draft {
    /// A capture of `views` (files relative to it) and `parts`. What no source states is guessed: one plastic for all parts,
    /// a lamp at the camera unless `lights` names some, the response of 8-bit files.
    ///
    /// The first view's camera becomes `[camera]`, the others override what they have otherwise.
    #[must_use]
    pub fn new(name: &str, views: &[View], parts: &[Part], lights: Vec<Light>) -> Self {
        let camera = views.first().map_or_else(Camera::default, |view| view.camera.clone());
        let capture = Capture { name: name.to_owned(), ..Capture::default() };
        let mut draft = Self { capture, response: None, notes: Vec::new() };
        draft.capture.photos = (views.iter().zip(labels(views)))
            .map(|(view, label)| Photo {
                file: view.file.clone(),
                label,
                camera_to_world: view.camera_to_world,
                camera: differing(&view.camera, &camera),
                ..Photo::default()
            })
            .collect();
        draft.capture.camera = camera;
        let encoded = |file: &str| [".png", ".jpg", ".jpeg"].iter().any(|end| file.to_lowercase().ends_with(end));
        if views.iter().any(|view| encoded(&view.file)) {
            draft.capture.sensor.response = Response::Srgb;
            draft.capture.sensor.saturation = Some(0.99);
            draft.guess("[sensor]", "", "response", "8-bit files hold sRGB values; linear TIFF or EXR would be better");
            draft.guess("[sensor]", "", "saturation", "values from 0.99 on are clipped");
        }
        if !parts.is_empty() {
            let model = Model::Plastic { base_color: [0.5; 3], roughness: 0.4, ior: 1.5, energy_compensation: true };
            draft.capture.materials = vec![Material { name: MATERIAL.to_owned(), model, ..Material::default() }];
            draft.guess("[[material]]", MATERIAL, "", "a gray plastic for every object; fit it, or write what it is");
        }
        for part in parts {
            let Part { name, mesh, object_to_world, guess } = part.clone();
            let material = MATERIAL.to_owned();
            draft.capture.objects.push(Object { name, mesh, material, object_to_world, ..Object::default() });
            if !guess.is_empty() {
                draft.guess("[[object]]", &part.name, "object_to_world", &guess);
            }
        }
        draft.capture.lights = lights;
        if draft.capture.lights.is_empty() {
            let kind = LightKind::Point { position: [0.0; 3], intensity: [1.0; 3] };
            let lamp = Light { name: "lamp".to_owned(), frame: Frame::Camera, kind, lobe: Lobe::default() };
            draft.capture.lights = vec![lamp];
            draft.guess("[[light]]", "lamp", "", "one lamp at the camera, of a brightness that is free to be fitted");
        }
        draft
    }

    /// Names the file of a measured response, relative to the capture: nothing about it is a guess any more.
    pub fn measured_response(&mut self, file: &str) {
        // What is not the default has a line, which `to_toml` fills in: the curve itself stays in its file.
        self.capture.sensor.response = Response::Srgb;
        self.response = Some(file.to_owned());
        self.notes.retain(|note| (note.section, note.key) != ("[sensor]", "response"));
    }

    /// Marks `key` of a section (such as `[camera]` or `[[object]]`, by its `name` or `file`; empty for all) as guessed.
    pub fn guess(&mut self, section: &'static str, name: &str, key: &'static str, text: &str) {
        self.note(section, name, key, &format!("GUESS: {text}"));
    }

    /// A comment that is no guess.
    pub fn note(&mut self, section: &'static str, name: &str, key: &'static str, text: &str) {
        self.notes.push(Note { section, name: name.to_owned(), key, text: text.to_owned() });
    }

    /// The text of the `capture.toml`.
    ///
    /// # Errors
    /// Values that the format refuses, such as two photos of one name.
    pub fn to_toml(&self) -> Result<String> {
        let text = self.capture.to_toml()?;
        let mut out = String::new();
        let mut block: Vec<&str> = Vec::new();
        for line in text.lines() {
            // A section begins; overrides such as [photo.camera] belong to the section before.
            if line.starts_with('[') && !line.contains('.') {
                self.flush(&mut out, &block);
                block.clear();
            }
            block.push(line);
        }
        self.flush(&mut out, &block);
        Ok(out)
    }

    fn flush(&self, out: &mut String, block: &[&str]) {
        let header = block.first().copied().unwrap_or_default();
        let notes: Vec<&Note> = self
            .notes
            .iter()
            .filter(|note| note.section == header)
            .filter(|note| {
                let named = |key: &str| format!("{key} = {}", toml_text(&note.name));
                note.name.is_empty() || block.contains(&&*named("name")) || block.contains(&&*named("file"))
            })
            .collect();
        for line in block {
            let key = line.split_once(" = ").map(|(key, _)| key);
            let here = |note: &&&Note| if note.key.is_empty() { *line == header } else { key == Some(note.key) };
            for note in notes.iter().filter(here) {
                out.push_str(&format!("# {}\n", note.text.replace('\n', " ")));
            }
            match &self.response {
                Some(file) if header == "[sensor]" && key == Some("response") => {
                    out.push_str(&format!("response = {}", toml_text(file)));
                }
                _ => out.push_str(line),
            }
            out.push('\n');
        }
    }
}

/// A text as the writer quotes it.
fn toml_text(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// A path of more parts is not looked at in full to tell two photos apart.
const DEEPEST: usize = 16;

/// The names of photos whose files have a name in common: as much of the path as tells them apart, joined by `-`, with the
/// ending where the rest does not do. Of one file that is there twice, nothing does.
fn labels(views: &[View]) -> Vec<Option<String>> {
    let short: Vec<String> =
        views.iter().map(|view| Photo { file: view.file.clone(), ..Photo::default() }.name().to_owned()).collect();
    let mut counts: BTreeMap<&String, usize> = BTreeMap::new();
    short.iter().for_each(|name| *counts.entry(name).or_default() += 1);
    let twice: Vec<bool> = short.iter().map(|name| counts.get(name).is_some_and(|count| *count > 1)).collect();
    let long = |view: &View, depth: usize, ending: bool| {
        let mut parts: Vec<&str> =
            view.file.split(['/', '\\']).filter(|part| ![".", "..", ""].contains(part)).collect();
        let file = parts.pop().unwrap_or_default();
        let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
        let folders = parts.get(parts.len().saturating_sub(depth)..).unwrap_or_default();
        let last = if ending { file.replace('.', "-") } else { stem.to_owned() };
        folders.iter().copied().chain([last.as_str()]).collect::<Vec<_>>().join("-")
    };
    let tries = [false, true].into_iter().flat_map(|ending| (0..DEEPEST).map(move |depth| (depth, ending)));
    for (depth, ending) in tries {
        let labels: Vec<Option<String>> =
            views.iter().zip(&twice).map(|(view, twice)| twice.then(|| long(view, depth, ending))).collect();
        let names: BTreeSet<&String> =
            labels.iter().zip(&short).map(|(label, short)| label.as_ref().unwrap_or(short)).collect();
        if names.len() == views.len() {
            return labels;
        }
    }
    vec![None; views.len()]
}

/// What `own` has otherwise than `base`.
fn differing(own: &Camera, base: &Camera) -> CameraOverride {
    let number = |own: f64, base: f64| (own != base).then_some(own);
    CameraOverride {
        width: (own.width != base.width).then_some(own.width),
        height: (own.height != base.height).then_some(own.height),
        fx: number(own.fx, base.fx),
        fy: number(own.fy, base.fy),
        cx: number(own.cx, base.cx),
        cy: number(own.cy, base.cy),
        distortion: (own.distortion != base.distortion).then(|| own.distortion.to_vec()),
        ..CameraOverride::default()
    }
}

/// Guessed poses: `count` cameras on a circle above `centre` (metres), all looking at it, upright, `distance` metres away
/// and 35 degrees above the horizon. The first is on the side of +x.
#[must_use]
pub fn ring(centre: [f64; 3], distance: f64, count: usize) -> Vec<[[f64; 4]; 4]> {
    let (se, ce) = libm::sincos(35.0_f64.to_radians());
    let pose = |i: usize| {
        let (sa, ca) = libm::sincos(std::f64::consts::TAU * i as f64 / count as f64);
        let (right, down, forward) = ([-sa, ca, 0.0], [ca * se, sa * se, -ce], [-ca * ce, -sa * ce, -se]);
        let row = |k: usize| [right[k], down[k], forward[k], centre[k] - forward[k] * distance];
        [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
    };
    (0..count).map(pose).collect()
}
