//! `gonio calibrate`: a camera from photos of a ChArUco board.

use super::draft::{Place, name_of};
use crate::failure::Failure;
use crate::output::{tell, tell_error};
use clap::Args;
use gonio_calibrate::{Board, Calibration, Draft, Pose, View, calibrate, determines_pose};
use gonio_scene::SceneError;
use std::path::PathBuf;

/// `gonio calibrate`.
#[derive(Debug, Args)]
pub struct CalibrateArguments {
    /// Photos of the board, all of one size: at least 3, from different directions
    #[arg(required = true)]
    pub photos: Vec<PathBuf>,
    /// The board, charuco:COLUMNSxROWS:SQUARE:MARKER:DICTIONARY with lengths in metres, such as charuco:5x7:0.04:0.02:6X6_250,
    /// and :legacy behind it for a board of before OpenCV 4.6
    #[arg(long, value_name = "BOARD", value_parser = Board::parse)]
    pub board: Board,
    /// The capture.toml to write: the camera, and each photo's pose above the board; must not exist yet
    #[arg(long, value_name = "DIR/capture.toml")]
    pub out: PathBuf,
    /// Write the result as one JSON object
    #[arg(long)]
    pub json: bool,
}

const NAMES: [&str; 9] = ["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"];

/// Finds the board, calibrates, writes and tells.
///
/// # Errors
/// A photo that is missing, of another size, or does not show the board; photos that do not determine a camera.
pub fn run(arguments: &CalibrateArguments) -> Result<(), Failure> {
    let place = Place::new(&arguments.out)?;
    let mut size = None;
    let (mut files, mut photos) = (Vec::new(), Vec::new());
    let legacy = arguments.board.legacy();
    let mut as_legacy = 0;
    for file in &arguments.photos {
        let at = file.display().to_string();
        let (relative, _) = place.photo(file)?;
        let gray = image::open(file)
            .map_err(|error| SceneError::new(&at, format!("cannot be read: {error}"), "name a PNG, JPEG or TIFF"))?
            .to_luma8();
        let own = gray.dimensions();
        let first = *size.get_or_insert(own);
        if own != first {
            let problem = format!("is {} x {}, the first photo {} x {}", own.0, own.1, first.0, first.1);
            return Err(SceneError::new(at, problem, "calibrate photos of one camera, unscaled and unturned").into());
        }
        let corners = arguments.board.find(own.0, own.1, &gray);
        // A board that one photo does not show is no reason to lose the others.
        if corners.is_empty() {
            tell_error(&format!("warning: {at}: does not show the board; it is left out"));
            as_legacy +=
                usize::from(legacy.as_ref().is_some_and(|board| determines_pose(&board.find(own.0, own.1, &gray))));
            continue;
        }
        if !determines_pose(&corners) {
            let seen = corners.len();
            tell_error(&format!("warning: {at}: {seen} corners do not determine the board's pose; it is left out"));
            continue;
        }
        files.push((relative, at));
        photos.push(corners);
    }
    if as_legacy > photos.len() {
        let mend = "write :legacy behind --board";
        let problem = format!("--board: {as_legacy} photos show the board as OpenCV before 4.6 laid it out; {mend}");
        return Err(Failure::Input(problem));
    }
    let (width, height) = size.unwrap_or_default();
    let result = calibrate(width, height, &photos).map_err(|error| {
        // The library counts photos from 0.
        let named = files.iter().enumerate().find(|(i, _)| error.starts_with(&format!("photo {i}:")));
        let text = named.map_or_else(|| error.clone(), |(i, (_, at))| error.replacen(&format!("photo {i}"), at, 1));
        Failure::Input(format!("--board: {text}"))
    })?;
    refuse_odd_photos(&files, &result)?;
    write(arguments, &place, &files, &photos.iter().map(Vec::len).collect::<Vec<_>>(), &result)
}

/// A photo that is so many times further off than the median one contradicts the others: it was taken by another camera, with
/// another zoom, or shows the board bent. Below a pixel it may be blurred, and does no harm.
const ODD: f64 = 5.0;

fn refuse_odd_photos(files: &[(String, String)], result: &Calibration) -> Result<(), Failure> {
    let mut errors: Vec<f64> = result.photos.iter().map(|photo| photo.error).collect();
    errors.sort_by(f64::total_cmp);
    let median = errors.get(errors.len() / 2).copied().unwrap_or_default();
    let odd = files.iter().zip(&result.photos).find(|(_, photo)| photo.error > (ODD * median).max(1.0));
    let Some(((_, at), photo)) = odd else { return Ok(()) };
    let problem = format!("is off by {:.2} px, the median photo by {median:.2} px", photo.error);
    let mend = "leave it out, or calibrate photos of one camera and zoom, and of a flat board";
    Err(SceneError::new(at, problem, mend).into())
}

fn write(
    arguments: &CalibrateArguments,
    place: &Place,
    files: &[(String, String)],
    corners: &[usize],
    result: &Calibration,
) -> Result<(), Failure> {
    // On the board x goes along the columns, y along the rows and z into it; the world has z up.
    let turn = Pose::new(&[1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0], [0.0; 3]);
    let turn = turn.ok_or_else(|| Failure::Failed("the board's frame is no rotation".to_owned()))?;
    let view = |((file, _), photo): (&(String, String), &gonio_calibrate::PhotoFit)| View {
        file: file.clone(),
        camera: result.camera.clone(),
        camera_to_world: turn.after(&photo.board_to_camera.inverse()).matrix(),
    };
    let views: Vec<View> = files.iter().zip(&result.photos).map(view).collect();
    let dir = arguments.out.parent().filter(|dir| !dir.as_os_str().is_empty()).unwrap_or(std::path::Path::new("."));
    let mut draft = Draft::new(&name_of(dir), &views, &[], Vec::new());
    draft.note("[camera]", "", "", &format!("calibrated on a ChArUco board: {:.4} px over all corners", result.error));
    for ((file, _), photo) in files.iter().zip(&result.photos) {
        draft.note("[[photo]]", file, "camera_to_world", &format!("above the board: {:.4} px", photo.error));
    }
    let each: Vec<_> = files
        .iter()
        .zip(&result.photos)
        .zip(corners)
        .map(|(((_, at), photo), corners)| {
            serde_json::json!({ "file": at, "corners": corners, "error": photo.error, "largest": photo.largest })
        })
        .collect();
    let camera = &result.camera;
    let [k1, k2, p1, p2, k3] = camera.distortion;
    let values = [camera.fx, camera.fy, camera.cx, camera.cy, k1, k2, p1, p2, k3];
    if !arguments.json {
        for ((name, value), error) in NAMES.iter().zip(values).zip(result.errors) {
            tell(&format!("{name}  {value:12.5}  +- {error:.5}"));
        }
        for (((_, at), photo), corners) in files.iter().zip(&result.photos).zip(corners) {
            tell(&format!("{at}: {corners} corners, {:.4} px, at most {:.4} px", photo.error, photo.largest));
        }
        tell(&format!("reprojection error {:.4} px", result.error));
    }
    let numbers = |values: [f64; 9]| -> serde_json::Map<_, _> {
        NAMES.iter().zip(values).map(|(name, value)| ((*name).to_owned(), serde_json::json!(value))).collect()
    };
    let more = serde_json::json!({
        "camera": numbers(values), "errors": numbers(result.errors), "error": result.error, "each": each,
    });
    place.write(&draft, arguments.json, &more)
}
