//! The file of clicked points.

use gonio_calibrate::Click;
use gonio_scene::capture::Photo;
use gonio_scene::{Capture, SceneError};
use serde::Deserialize;
use std::path::Path;

#[derive(Deserialize)]
struct Row {
    photo: String,
    x: f64,
    y: f64,
    mesh_x: f64,
    mesh_y: f64,
    mesh_z: f64,
}

/// Reads the points; `unit` is the metres of each of the mesh's units.
///
/// # Errors
/// A file that cannot be read, a row that is none, a photo that is not there, a point outside of its photo.
pub(super) fn read(file: &Path, capture: &Capture, unit: f64) -> Result<Vec<Click>, SceneError> {
    let at = file.display().to_string();
    let mend = "write the columns photo,x,y,mesh_x,mesh_y,mesh_z, with a line for each point";
    let refuse = |problem: String, mend: &str| SceneError::new(&at, problem, mend);
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .from_path(file)
        .map_err(|error| refuse(format!("cannot be read: {error}"), mend))?;
    let mut clicks = Vec::new();
    for (index, row) in reader.deserialize::<Row>().enumerate() {
        let line = format!("point {}", index + 1);
        let row = row.map_err(|error| refuse(format!("is no list of points: {error}"), mend).at(&*line))?;
        let photo = capture.photo_index(&row.photo).ok_or_else(|| {
            let known: Vec<&str> = capture.photos.iter().map(Photo::name).take(20).collect();
            refuse(format!("names the photo {:?}", row.photo), &format!("the photos are: {}", known.join(", ")))
                .at(&*line)
        })?;
        let camera = capture.camera_of(&capture.photos[photo]);
        let inside =
            (0.0..=f64::from(camera.width)).contains(&row.x) && (0.0..=f64::from(camera.height)).contains(&row.y);
        if !inside {
            let problem = format!("lies at {}, {}, outside of its photo", row.x, row.y);
            let size = format!("give pixels from 0, 0 to {}, {}", camera.width, camera.height);
            return Err(refuse(problem, &size).at(&*line));
        }
        let point = [row.mesh_x, row.mesh_y, row.mesh_z].map(|x| x * unit);
        if !point.iter().all(|x| x.is_finite()) {
            return Err(refuse("has a coordinate that is no number".to_owned(), mend).at(&*line));
        }
        clicks.push(Click { photo, pixel: [row.x, row.y], point });
    }
    Ok(clicks)
}
