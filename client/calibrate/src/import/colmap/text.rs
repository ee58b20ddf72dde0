//! COLMAP's text model: `cameras.txt` and `images.txt`.

use super::{WORLD, camera, view};
use crate::view::Imported;
use gonio_scene::capture::Camera;
use gonio_scene::{Result, SceneError};
use std::collections::BTreeMap;

/// Reads both texts of a model. COLMAP's axes and pixel centres are those of the capture format; its poses map the world
/// to the camera and are turned round. The world's place, turn and scale are arbitrary.
///
/// # Errors
/// A malformed line, an unknown or fisheye camera model, an image of a camera that is not listed, no image at all.
pub fn colmap(cameras: &str, images: &str) -> Result<Imported> {
    let cameras = read_cameras(cameras)?;
    let file = "images.txt";
    let mut views = Vec::new();
    let mut lines = images.lines().enumerate().filter(|(_, line)| !line.starts_with('#'));
    while let Some((number, line)) = lines.next() {
        if line.trim().is_empty() {
            continue;
        }
        let points = lines.next();
        let at = format!("line {}", number + 1);
        let wrong = |problem: &str| {
            let mend = "write IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, and the points on a line of their own";
            SceneError::new(file, problem, mend).at(&at)
        };
        // The second line of an image lists its points, and may be empty, or absent behind the last.
        let points = points.map_or("", |(_, line)| line);
        let values: Vec<bool> = points.split_whitespace().map(|word| word.parse::<f64>().is_ok()).collect();
        if !values.len().is_multiple_of(3) || values.contains(&false) {
            let mend = "write a line behind each image, empty or with X Y POINT3D_ID for every point";
            let problem = "is no list of an image's points, which must follow the image";
            return Err(SceneError::new(file, problem, mend).at(format!("line {}", number + 2)));
        }
        let words: Vec<&str> = line.trim().splitn(10, char::is_whitespace).collect();
        let [_, pose @ .., camera, name] = words.as_slice() else { return Err(wrong("has too few words")) };
        let pose: Vec<f64> = pose.iter().filter_map(|word| word.parse().ok()).filter(|x: &f64| x.is_finite()).collect();
        let Ok(pose) = <[f64; 7]>::try_from(pose) else { return Err(wrong("is no quaternion and translation")) };
        let camera = cameras
            .get(*camera)
            .ok_or_else(|| wrong(&format!("names camera {camera}, which cameras.txt does not list")))?;
        views.push(view((*name).trim().to_owned(), camera, pose).map_err(wrong)?);
    }
    if views.is_empty() {
        return Err(SceneError::new(file, "lists no image", "name the folder of a reconstruction that holds images"));
    }
    Ok(Imported { views, objects: Vec::new(), world: WORLD })
}

fn read_cameras(text: &str) -> Result<BTreeMap<&str, Camera>> {
    let mut cameras = BTreeMap::new();
    for (number, line) in text.lines().enumerate() {
        if line.starts_with('#') || line.trim().is_empty() {
            continue;
        }
        let wrong = |problem: String, mend: &str| {
            SceneError::new("cameras.txt", problem, mend).at(format!("line {}", number + 1))
        };
        let mend = "write CAMERA_ID MODEL WIDTH HEIGHT and the model's parameters";
        let words: Vec<&str> = line.split_whitespace().collect();
        let [id, model, width, height, parameters @ ..] = words.as_slice() else {
            return Err(wrong("has too few words".to_owned(), mend));
        };
        let size = |word: &str| word.parse::<u32>().ok().filter(|&n| n > 0);
        let (Some(width), Some(height)) = (size(width), size(height)) else {
            return Err(wrong(format!("has the size {width} x {height}"), mend));
        };
        let p: Vec<f64> = parameters.iter().map(|word| word.parse().unwrap_or(f64::NAN)).collect();
        cameras.insert(*id, camera(model, [width, height], &p).map_err(|(problem, mend)| wrong(problem, mend))?);
    }
    Ok(cameras)
}
