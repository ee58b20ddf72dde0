//! `gonio new`: meshes, photos, poses and lights become a capture, every guess marked.

use super::draft::{Place, name_of};
use crate::failure::Failure;
use crate::input::Input;
use clap::Args;
use gonio_calibrate::{Draft, Part, View, ring};
use gonio_scene::capture::{Camera, Frame, Light, LightKind, Lobe, ResponseCurve};
use gonio_scene::files::Files;
use gonio_scene::{SceneError, mesh};
use std::path::{Path, PathBuf};

/// `gonio new`.
#[derive(Debug, Args)]
pub struct NewArguments {
    /// The capture.toml to write, in a folder of its own or beside the photos; must not exist yet
    #[arg(long, value_name = "DIR/capture.toml")]
    pub out: PathBuf,
    /// Photos; absent, those of --poses
    #[arg(long, value_name = "FILE", num_args = 1.., required_unless_present = "poses")]
    pub photos: Vec<PathBuf>,
    /// Meshes of the parts, in the same frame
    #[arg(long, value_name = "FILE", num_args = 1..)]
    pub meshes: Vec<PathBuf>,
    /// Metres per unit of the meshes, such as 0.001 for millimetres; absent, guessed from their size
    #[arg(long, value_name = "METRES", value_parser = positive)]
    pub unit: Option<f64>,
    /// A capture, from `gonio calibrate` or `gonio import`, whose cameras the photos of the same names have
    #[arg(long, value_name = "CAPTURE")]
    pub poses: Option<PathBuf>,
    /// Environment map as the only light; absent, a lamp at the camera is guessed
    #[arg(long, value_name = "FILE")]
    pub environment: Option<PathBuf>,
    /// Response curve of the photos' camera, as `gonio hdr` wrote it; absent, sRGB is guessed for 8-bit photos
    #[arg(long, value_name = "MAP.response.json")]
    pub response: Option<PathBuf>,
    /// Write the summary as one JSON object
    #[arg(long)]
    pub json: bool,
}

fn positive(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x: &f64| x.is_finite() && *x > 0.0).ok_or_else(|| "write a positive number".to_owned())
}

/// Gathers and writes.
///
/// # Errors
/// A file that is missing or not what it should be, or a photo whose pose is not known where others' are.
pub fn run(arguments: &NewArguments) -> Result<(), Failure> {
    let place = Place::new(&arguments.out)?;
    let (parts, centre, radius) = parts(&place, arguments)?;
    let lights = match &arguments.environment {
        None => Vec::new(),
        Some(map) => {
            let kind = LightKind::Map { map: place.relative(map)?, scale: 1.0, azimuth: 0.0 };
            vec![Light { name: "sky".to_owned(), frame: Frame::World, kind, lobe: Lobe::default() }]
        }
    };
    let views = match &arguments.poses {
        Some(poses) => known(&place, poses, &arguments.photos)?,
        None => guessed(&place, &arguments.photos, centre, 3.0 * radius)?,
    };
    let dir = arguments.out.parent().filter(|dir| !dir.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut draft = Draft::new(&name_of(dir), &views, &parts, lights);
    if arguments.poses.is_none() {
        let text = "a focal length of 1.2 times the width, no distortion; `gonio calibrate` measures both";
        draft.guess("[camera]", "", "fx", text);
        let text = "on a circle about the parts; `gonio import` or `gonio calibrate` give poses to --poses";
        draft.guess("[[photo]]", "", "camera_to_world", text);
    }
    if arguments.environment.is_some() {
        // A scale of 1 has no line of its own.
        draft.guess("[[light]]", "sky", "", "the map's own brightness, scale = 1; free light.sky.scale to fit it");
    }
    if let Some(file) = &arguments.response {
        draft.measured_response(&response(&place, file)?);
    }
    place.write(&draft, arguments.json, &serde_json::json!({}))
}

/// The file of a response curve as the capture names it.
fn response(place: &Place, file: &Path) -> Result<String, SceneError> {
    let at = file.display().to_string();
    let relative = place.relative(file)?;
    let refuse = |problem: &str| SceneError::new(&at, problem, "name a .response.json that `gonio hdr` wrote");
    if file.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("json")) {
        return Err(refuse("has a name that does not end with .json").at("--response"));
    }
    let bytes = place.files().read(&relative)?;
    ResponseCurve::from_json(&at, std::str::from_utf8(&bytes).map_err(|_| refuse("is no UTF-8 text"))?)?;
    Ok(relative)
}

/// The parts, with the centre and radius of all, metres.
fn parts(place: &Place, arguments: &NewArguments) -> Result<(Vec<Part>, [f64; 3], f64), SceneError> {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    let mut meshes = Vec::new();
    for file in &arguments.meshes {
        let relative = place.relative(file)?;
        for position in &mesh::read(&place.files(), &relative)?.positions {
            for (k, &x) in position.iter().enumerate() {
                low[k] = low[k].min(f64::from(x));
                high[k] = high[k].max(f64::from(x));
            }
        }
        meshes.push((name_of(file), relative));
    }
    if meshes.is_empty() {
        return Ok((Vec::new(), [0.0; 3], 0.1));
    }
    let size = (0..3).map(|k| (high[k] - low[k]) * (high[k] - low[k])).sum::<f64>().sqrt();
    // No part that is photographed on a table is five metres long; one in millimetres is hardly smaller than that.
    let unit = arguments.unit.unwrap_or(if size > 5.0 { 0.001 } else { 1.0 });
    let guess = match arguments.unit {
        Some(_) => "the mesh's own frame is the world's".to_owned(),
        None => format!(
            "the mesh's own frame is the world's, and its unit {unit} m (all meshes are {size:.4} units across)"
        ),
    };
    let object_to_world = [[unit, 0.0, 0.0, 0.0], [0.0, unit, 0.0, 0.0], [0.0, 0.0, unit, 0.0], [0.0, 0.0, 0.0, 1.0]];
    let part = |(name, mesh)| Part { name, mesh, object_to_world, guess: guess.clone() };
    let centre = [0, 1, 2].map(|k| 0.5 * unit * (low[k] + high[k]));
    Ok((meshes.into_iter().map(part).collect(), centre, (0.5 * unit * size).max(1e-3)))
}

/// Cameras of another capture, by the photos' names.
fn known(place: &Place, poses: &Path, photos: &[PathBuf]) -> Result<Vec<View>, Failure> {
    let source = Input::open(poses)?;
    let own: Vec<PathBuf> = source.capture.photos.iter().map(|photo| source.root.join(&photo.file)).collect();
    let mut views = Vec::new();
    for file in if photos.is_empty() { &own } else { photos } {
        let (relative, size) = place.photo(file)?;
        let index = source.capture.photo_index(&name_of(file)).ok_or_else(|| {
            let problem = format!("has no pose in {}", poses.display());
            SceneError::new(relative.clone(), problem, "leave the photo out, or estimate its pose too")
        })?;
        let photo = &source.capture.photos[index];
        let camera = source.capture.camera_of(photo);
        if size != (camera.width, camera.height) {
            let problem = format!("is {} x {}, its camera {} x {}", size.0, size.1, camera.width, camera.height);
            return Err(SceneError::new(relative, problem, "name the photos that were calibrated, unscaled").into());
        }
        views.push(View { file: relative, camera, camera_to_world: photo.camera_to_world });
    }
    Ok(views)
}

fn guessed(place: &Place, photos: &[PathBuf], centre: [f64; 3], distance: f64) -> Result<Vec<View>, SceneError> {
    let view = |(file, camera_to_world): (&PathBuf, _)| {
        let (file, (width, height)) = place.photo(file)?;
        let (w, h) = (f64::from(width), f64::from(height));
        let camera = Camera { width, height, fx: 1.2 * w, fy: 1.2 * w, cx: w / 2.0, cy: h / 2.0, ..Camera::default() };
        Ok(View { file, camera, camera_to_world })
    };
    photos.iter().zip(ring(centre, distance, photos.len())).map(view).collect()
}
