//! `gonio new`: meshes, photos, poses and lights become a capture that fits at once, every guess marked.

mod board;
mod fit;
mod light;
mod parts;
mod photos;

use super::draft::{Place, name_of};
use crate::failure::Failure;
use clap::Args;
use gonio_calibrate::{Board, Draft};
use gonio_scene::SceneError;
use gonio_scene::capture::ResponseCurve;
use gonio_scene::files::Files;
use light::Lamp;
use parts::Stand;
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
    /// Where the meshes' origin stands in the world, metres, and by how many degrees they are turned about the world's z axis;
    /// absent, the meshes' own frame is taken for the world's
    #[arg(long, value_name = "X,Y,Z[,DEGREES]", value_parser = Stand::parse, allow_hyphen_values = true)]
    pub at: Option<Stand>,
    /// A capture, from `gonio calibrate` or `gonio import`, whose cameras the photos of the same names have
    #[arg(long, value_name = "CAPTURE")]
    pub poses: Option<PathBuf>,
    /// Folder of masks: images with the photos' names, white where the part is
    #[arg(long, value_name = "DIR")]
    pub masks: Option<PathBuf>,
    /// The board that the parts stand on, as `gonio calibrate` takes it: it becomes two objects in the plane z = 0, its white and
    /// its black parts
    #[arg(long, value_name = "BOARD", value_parser = Board::parse)]
    pub board: Option<Board>,
    /// Environment map as the only light; absent, a lamp at the camera is guessed
    #[arg(long, value_name = "FILE")]
    pub environment: Option<PathBuf>,
    /// A lamp that stands still: its place in the world as it was measured, metres, and the radius of a ball as large as it. The
    /// fit looks for its place from there
    #[arg(long, value_name = "X,Y,Z[,RADIUS]", value_parser = Lamp::parse, allow_hyphen_values = true,
          conflicts_with = "environment")]
    pub lamp: Option<Lamp>,
    /// Light from all sides besides, the same from each, for the fit to find
    #[arg(long, conflicts_with = "environment")]
    pub room: bool,
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
/// A file that is missing or not what it should be, or no photo whose pose is known.
pub fn run(arguments: &NewArguments) -> Result<(), Failure> {
    let place = Place::new(&arguments.out)?;
    let found = parts::read(&place, arguments)?;
    let views = match &arguments.poses {
        Some(poses) => photos::known(&place, poses, &arguments.photos)?,
        None => photos::guessed(&place, &arguments.photos, found.centre, 3.0 * found.radius)?,
    };
    photos::warn_of_unposed(&views);
    let dir = arguments.out.parent().filter(|dir| !dir.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let lights = light::lights(&place, arguments)?;
    let mut draft = Draft::new(&name_of(dir), &views.posed, &found.parts, lights);
    if arguments.poses.is_none() {
        let text = "a focal length of 1.2 times the width, no distortion; `gonio calibrate` measures both";
        draft.guess("[camera]", "", "fx", text);
        let text = "on a circle about the parts; `gonio import` or `gonio calibrate` give poses to --poses";
        draft.guess("[[photo]]", "", "camera_to_world", text);
    }
    light::note(&mut draft, arguments);
    if let Some(folder) = &arguments.masks {
        photos::add_masks(&place, folder, &mut draft.capture)?;
    }
    if let Some(board) = &arguments.board {
        board::add(&place, board, &mut draft)?;
    }
    if let Some(file) = &arguments.response {
        draft.measured_response(&response(&place, file)?);
    }
    fit::complete(&mut draft);
    place.write(&draft, arguments.json, &serde_json::json!({ "unposed": views.unposed }))
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
