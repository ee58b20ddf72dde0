//! `gonio align`: where a part stands, from points that were clicked in photos and from the masks' outlines.

mod clicks;
mod outline;

use crate::failure::Failure;
use crate::input::Input;
use crate::output::{Output, tell, tell_error, to_json};
use clap::Args;
use gonio_calibrate::{Field, Placed, Pose, Station, from_clicks, from_outlines};
use gonio_scene::capture::{CAPTURE_FILE, Role};
use gonio_scene::image::read_mask;
use gonio_scene::mesh::{self, Mesh};
use gonio_scene::{Capture, SceneError};
use nalgebra::Vector3;
use std::path::PathBuf;

/// `gonio align`.
#[derive(Debug, Args)]
pub struct AlignArguments {
    /// The capture's folder or its capture.toml
    pub capture: PathBuf,
    /// Folder to write the capture.toml with the part's place to; created if need be
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// The object that is placed; of a capture with one object it may be left out
    #[arg(long, value_name = "NAME")]
    pub object: Option<String>,
    /// Clicked points, a CSV file with the columns photo, x, y (pixels; the photo's upper left corner is 0, 0) and mesh_x, mesh_y, mesh_z
    /// (in the mesh file's own units). Absent, the part is near its place already
    #[arg(long, value_name = "POINTS.csv")]
    pub points: Option<PathBuf>,
    /// Do not move the part's outlines onto the masks' edges
    #[arg(long, requires = "points")]
    pub no_outlines: bool,
    /// Write the result as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// What is placed.
struct Part {
    /// Index of the object.
    object: usize,
    mesh: Mesh,
    /// Metres of each unit of the mesh file.
    unit: f64,
    /// The part's own coordinates, metres, to the world.
    pose: Pose,
    /// The middle of its box, its own coordinates, metres.
    middle: Vector3<f64>,
}

/// Places and writes.
///
/// # Errors
/// A broken capture, points that give no place, neither points nor masks, a folder that cannot be written to.
pub fn run(arguments: &AlignArguments) -> Result<(), Failure> {
    let input = Input::open(&arguments.capture)?;
    let folder = Output::create(&arguments.out, &[CAPTURE_FILE.to_owned()], &input.root, &input.capture)?;
    let mut part = part(&input, arguments.object.as_deref())?;
    let stations = stations(&input.capture)?;
    let clicked = match &arguments.points {
        None => None,
        Some(file) => {
            let clicks = clicks::read(file, &input.capture, part.unit)?;
            let placed = from_clicks(&stations, &clicks).map_err(|error| {
                SceneError::new(file.display().to_string(), error.to_string(), "add points and run it again")
            })?;
            part.pose = placed.pose;
            Some(placed)
        }
    };
    let fields = if arguments.no_outlines { vec![None; stations.len()] } else { fields(&input)? };
    let masks = fields.iter().flatten().count();
    let outlined = if masks == 0 { None } else { Some(outlined(&part, &stations, &fields)?) };
    let Some(placed) = outlined.map(|(placed, _)| placed).or(clicked) else {
        let mend = "click points of the part (--points), or give the photos masks";
        return Err(SceneError::new(CAPTURE_FILE, "has no masks, and there are no points", mend).into());
    };
    let mut capture = input.capture.clone();
    let object = &mut capture.objects[part.object];
    object.object_to_world = scaled(&placed.pose, part.unit);
    (object.scale, object.translation, object.rotation) = ([1.0; 3], [0.0; 3], [0.0; 3]);
    let name = object.name.clone();
    input.with(capture, &[])?.write(&folder)?;
    told(arguments, &name, clicked.as_ref(), outlined.as_ref(), masks)
}

/// The object with its mesh.
fn part(input: &Input, name: Option<&str>) -> Result<Part, Failure> {
    let capture = &input.capture;
    let all: Vec<&str> = capture.objects.iter().map(|object| object.name.as_str()).collect();
    let mend = format!("the objects are: {}", all.join(", "));
    let object = match name {
        Some(name) => all
            .iter()
            .position(|own| *own == name)
            .ok_or_else(|| SceneError::new("--object", format!("names {name:?}, which is no object"), mend.as_str()))?,
        None if all.len() == 1 => 0,
        None => return Err(SceneError::new("--object", "is needed: the capture has several objects", mend).into()),
    };
    let own = &capture.objects[object];
    let refuse = |problem: &str, mend: &str| {
        SceneError::new(CAPTURE_FILE, problem, mend).at(format!("object.{}.object_to_world", own.name))
    };
    let place = own.placement();
    let column = |j: usize| Vector3::new(place[0][j], place[1][j], place[2][j]);
    let unit = column(0).norm();
    let alike = (1..3).all(|j| (column(j).norm() - unit).abs() < 1e-6 * unit);
    let rows: [f64; 9] = std::array::from_fn(|k| place[k / 3][k % 3] / unit);
    let pose = Pose::new(&rows, [place[0][3], place[1][3], place[2][3]]).filter(|_| alike && unit > 0.0);
    let mend = "write a turn, one scale for all axes and a shift";
    let pose = pose.ok_or_else(|| refuse("is no turn with one scale, so that the part's size is not known", mend))?;
    let mesh = mesh::read(input, &own.mesh)?;
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for position in &mesh.positions {
        for (k, &x) in position.iter().enumerate() {
            low[k] = low[k].min(unit * f64::from(x));
            high[k] = high[k].max(unit * f64::from(x));
        }
    }
    let middle = Vector3::from_fn(|k, _| 0.5 * (low[k] + high[k]));
    Ok(Part { object, mesh, unit, pose, middle })
}

fn stations(capture: &Capture) -> Result<Vec<Station>, Failure> {
    let station = |photo: &gonio_scene::capture::Photo| {
        let place = photo.pose();
        let rows: [f64; 9] = std::array::from_fn(|k| place[k / 3][k % 3]);
        let pose = Pose::new(&rows, [place[0][3], place[1][3], place[2][3]]).ok_or_else(|| {
            SceneError::new(CAPTURE_FILE, "is no rigid motion", "write a turn and a shift")
                .at(format!("photo.{}.camera_to_world", photo.name()))
        })?;
        Ok(Station { camera: capture.camera_of(photo), to_camera: pose.inverse() })
    };
    capture.photos.iter().map(station).collect()
}

/// The masks' distance fields. Photos that judge a fit give none.
fn fields(input: &Input) -> Result<Vec<Option<Field>>, Failure> {
    let field = |photo: &gonio_scene::capture::Photo| match &photo.mask {
        Some(path) if photo.role == Role::Fit => {
            let mask = read_mask(input, path)?;
            Ok(Some(Field::new(mask.width as usize, mask.height as usize, &mask.bits)))
        }
        _ => Ok(None),
    };
    input.capture.photos.iter().map(field).collect()
}

fn outlined(part: &Part, stations: &[Station], fields: &[Option<Field>]) -> Result<(Placed, f64), Failure> {
    let masked: Vec<bool> = fields.iter().map(Option::is_some).collect();
    let contours = |pose: &Pose| outline::contours(part, stations, &masked, pose);
    let placed = from_outlines(stations, fields, &contours, &part.middle, part.pose);
    placed.ok_or_else(|| {
        let problem = "has no outline near its masks' edges";
        let mend = "click points of the part (--points), or put it nearer to its place";
        SceneError::new(CAPTURE_FILE, problem, mend).at("object").into()
    })
}

/// A motion of metres as one of the mesh's units.
fn scaled(pose: &Pose, unit: f64) -> [[f64; 4]; 4] {
    let mut matrix = pose.matrix();
    for row in matrix.iter_mut().take(3) {
        row.iter_mut().take(3).for_each(|entry| *entry *= unit);
    }
    matrix
}

fn told(
    arguments: &AlignArguments,
    name: &str,
    clicked: Option<&Placed>,
    outlined: Option<&(Placed, f64)>,
    masks: usize,
) -> Result<(), Failure> {
    let norm = |errors: &[f64]| errors.iter().map(|error| error * error).sum::<f64>().sqrt();
    let place = |placed: &Placed| {
        serde_json::json!({
            "pixels": placed.pixels, "translation": placed.pose.translation.as_slice(),
            "translation_error": norm(&placed.errors[3..]), "rotation_error": norm(&placed.errors[..3]),
        })
    };
    if arguments.json {
        let object = serde_json::json!({
            "object": name, "points": clicked.map(place), "outlines": outlined.map(|(placed, _)| place(placed)),
            "margin": outlined.map(|(_, margin)| margin), "masks": masks,
            "capture": arguments.out.join(CAPTURE_FILE).display().to_string(),
        });
        tell(&to_json(&object)?);
        return Ok(());
    }
    let line = |what: &str, placed: &Placed| {
        let [x, y, z] = [0, 1, 2].map(|k| placed.pose.translation[k]);
        tell(&format!(
            "{what}: {name} at {x:.5}, {y:.5}, {z:.5} m +- {:.3} mm, +- {:.3} degrees; {:.2} px off",
            1e3 * norm(&placed.errors[3..]),
            norm(&placed.errors[..3]).to_degrees(),
            placed.pixels
        ));
    };
    if let Some(placed) = clicked {
        line("points", placed);
    }
    if let Some((placed, margin)) = outlined {
        line(&format!("outlines of {masks} masks"), placed);
        let than = if *margin < 0.0 { "inside" } else { "outside" };
        tell(&format!("the masks' edges lie {:.2} px {than} of the part's", margin.abs()));
    } else if !arguments.no_outlines {
        tell_error("warning: no photo has a mask: the place is as exact as the clicks");
    }
    tell(&format!("wrote {CAPTURE_FILE} to {}", arguments.out.display()));
    Ok(())
}
