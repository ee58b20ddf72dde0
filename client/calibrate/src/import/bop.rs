//! A scene of the BOP benchmark: `scene_camera.json` and `scene_gt.json`.

use crate::geometry::Pose;
use crate::json::{numbers, parse};
use crate::view::{Imported, Located, View};
use gonio_scene::capture::Camera;
use gonio_scene::{Result, SceneError};
use serde_json::Value;

const CAMERA: &str = "scene_camera.json";
const TRUTH: &str = "scene_gt.json";
const METRES: f64 = 1e-3;

/// Reads the texts of a scene. BOP has millimetres, OpenCV's axes, and the centre of the upper left pixel at (0, 0): half a
/// pixel is added. Where the scene states no `cam_R_w2c`, the world is the frame of one object, which every image must show
/// once: the one of them that the first image lists first. Objects are placed by the first image's poses.
/// `locate` finds image `number`, and gives its path and size in pixels.
///
/// # Errors
/// No JSON, a key that is missing or of another kind, a rotation that is none, no pose at all, no world and no object that
/// every image shows once, or an image that `locate` does not find.
pub fn bop(camera: &str, truth: Option<&str>, locate: &dyn Fn(u32) -> Located) -> Result<Imported> {
    let cameras = parse(CAMERA, camera)?;
    let truth = truth.map(|text| parse(TRUTH, text)).transpose()?;
    let mut images: Vec<(u32, &str, &Value)> = Vec::new();
    for (key, entry) in cameras.as_object().into_iter().flatten() {
        let number = key.parse().map_err(|_| {
            SceneError::new(CAMERA, "is no number of an image", "write the image's number as the key").at(key)
        })?;
        images.push((number, key, entry));
    }
    images.sort_by_key(|(number, ..)| *number);
    if images.is_empty() {
        return Err(SceneError::new(CAMERA, "lists no image", "name the folder of one scene"));
    }
    let in_world = images.iter().all(|(.., entry)| entry.get("cam_R_w2c").is_some());
    let mut imported =
        Imported { world: "the world of the BOP scene, in metres; z need not point up", ..Imported::default() };
    let anchor = if in_world { None } else { Some(anchor(truth.as_ref(), &images)?) };
    if anchor.is_some() {
        imported.world = "the frame of one object, in metres: the scene states no world; z need not point up";
    }
    for (number, key, entry) in images {
        let objects = objects(truth.as_ref(), key)?;
        let world_to_camera = match anchor {
            None => pose(CAMERA, key, entry, ["cam_R_w2c", "cam_t_w2c"])?,
            // `anchor` has found it in every image.
            Some(id) => {
                objects.iter().find(|(other, _)| *other == id).map(|(_, pose)| *pose).ok_or_else(|| absent(key))?
            }
        };
        let k: [f64; 9] = numbers(CAMERA, &format!("{key}.cam_K"), entry.get("cam_K").unwrap_or(&Value::Null))?;
        if k[0] <= 0.0 || k[4] <= 0.0 || k[1] != 0.0 {
            let mend =
                "write [fx, 0, cx, 0, fy, cy, 0, 0, 1] with positive focal lengths: skew has no place in a capture";
            return Err(SceneError::new(CAMERA, "is no calibration matrix", mend).at(format!("{key}.cam_K")));
        }
        let (file, (width, height)) = locate(number)?;
        let camera = Camera { width, height, fx: k[0], fy: k[4], cx: k[2] + 0.5, cy: k[5] + 0.5, ..Camera::default() };
        let back = world_to_camera.inverse();
        if imported.views.is_empty() {
            for (id, object_to_camera) in &objects {
                // Meshes of the benchmark are in millimetres.
                let mut matrix = back.after(object_to_camera).matrix();
                matrix.iter_mut().flat_map(|row| row.iter_mut().take(3)).for_each(|entry| *entry *= METRES);
                imported.objects.push((*id, matrix));
            }
        }
        imported.views.push(View { file, camera, camera_to_world: back.matrix() });
    }
    Ok(imported)
}

fn absent(key: &str) -> SceneError {
    let mend = "add cam_R_w2c and cam_t_w2c to scene_camera.json, or the object's pose here";
    SceneError::new(TRUTH, "is missing, and no world is stated", mend).at(key)
}

/// The object whose frame is the world: the lists have no order, so it is known by its number.
fn anchor(truth: Option<&Value>, images: &[(u32, &str, &Value)]) -> Result<u32> {
    let mut listed = Vec::new();
    for (_, key, _) in images {
        let ids: Vec<u32> = objects(truth, key)?.into_iter().map(|(id, _)| id).collect();
        if ids.is_empty() {
            return Err(absent(key));
        }
        listed.push((*key, ids));
    }
    let once = |ids: &[u32], id: u32| ids.iter().filter(|other| **other == id).count() == 1;
    let first = listed.first().map(|(_, ids)| ids.as_slice()).unwrap_or_default();
    first.iter().copied().find(|id| listed.iter().all(|(_, ids)| once(ids, *id))).ok_or_else(|| {
        let id = first.first().copied().unwrap_or_default();
        let key = listed.iter().find(|(_, ids)| !once(ids, id)).map_or("", |(key, _)| *key);
        let problem = format!("shows object {id} not once, no other is in every image once, and no world is stated");
        SceneError::new(TRUTH, problem, "add cam_R_w2c and cam_t_w2c to scene_camera.json").at(key)
    })
}

/// Every object of an image with its pose.
fn objects(truth: Option<&Value>, key: &str) -> Result<Vec<(u32, Pose)>> {
    let list = truth.and_then(|truth| truth.get(key)).and_then(Value::as_array);
    let read = |(index, entry): (usize, &Value)| {
        let at = format!("{key}[{index}]");
        let id = entry.get("obj_id").and_then(Value::as_u64).and_then(|id| u32::try_from(id).ok());
        let mend = "write the object's number";
        let id = id.ok_or_else(|| SceneError::new(TRUTH, "is missing", mend).at(format!("{at}.obj_id")))?;
        Ok((id, pose(TRUTH, &at, entry, ["cam_R_m2c", "cam_t_m2c"])?))
    };
    list.into_iter().flatten().enumerate().map(read).collect()
}

fn pose(file: &str, at: &str, entry: &Value, [rotation, translation]: [&str; 2]) -> Result<Pose> {
    let get = |key: &str| (format!("{at}.{key}"), entry.get(key).cloned().unwrap_or(Value::Null));
    let (key, value) = get(rotation);
    let rows: [f64; 9] = numbers(file, &key, &value)?;
    let (shift_key, value) = get(translation);
    let shift: [f64; 3] = numbers(file, &shift_key, &value)?;
    Pose::new(&rows, shift.map(|x| x * METRES))
        .ok_or_else(|| SceneError::new(file, "is no rotation", "write nine numbers row by row").at(key))
}
