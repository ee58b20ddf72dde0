//! The photos, their cameras and their masks.

use crate::commands::draft::{Place, name_of};
use crate::failure::Failure;
use crate::input::Input;
use crate::output::tell_error;
use gonio_calibrate::{View, ring};
use gonio_scene::capture::Camera;
use gonio_scene::{Capture, SceneError};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The photos, those whose pose is known apart.
pub(super) struct Views {
    pub posed: Vec<View>,
    /// Photos that the capture leaves out, as it would name them.
    pub unposed: Vec<String>,
}

/// Says which photos are left out.
pub(super) fn warn_of_unposed(views: &Views) {
    for photo in &views.unposed {
        tell_error(&format!("warning: {photo}: has no pose and is left out; estimate it too, as the others were"));
    }
}

/// Cameras of another capture, by the photos' names.
///
/// # Errors
/// A photo that is missing or of another size than its camera; none whose pose is known.
pub(super) fn known(place: &Place, poses: &Path, photos: &[PathBuf]) -> Result<Views, Failure> {
    let source = Input::open(poses)?;
    let own: Vec<PathBuf> = source.capture.photos.iter().map(|photo| source.root.join(&photo.file)).collect();
    let (mut posed, mut unposed) = (Vec::new(), Vec::new());
    for file in if photos.is_empty() { &own } else { photos } {
        let (relative, size) = place.photo(file)?;
        let Some(index) = source.capture.photo_index(&name_of(file)) else {
            unposed.push(relative);
            continue;
        };
        let photo = &source.capture.photos[index];
        let camera = source.capture.camera_of(photo);
        if size != (camera.width, camera.height) {
            let problem = format!("is {} x {}, its camera {} x {}", size.0, size.1, camera.width, camera.height);
            return Err(SceneError::new(relative, problem, "name the photos that were calibrated, unscaled").into());
        }
        posed.push(View { file: relative, camera, camera_to_world: photo.camera_to_world });
    }
    match unposed.first() {
        Some(first) if posed.is_empty() => {
            let problem = format!("has no pose in {}, nor has any other photo", poses.display());
            Err(SceneError::new(first.as_str(), problem, "name the capture whose photos these are by --poses").into())
        }
        _ => Ok(Views { posed, unposed }),
    }
}

/// Names the mask of every photo that `folder` has one for.
///
/// # Errors
/// None of them has one, or a mask is of another size than its photo.
pub(super) fn add_masks(place: &Place, folder: &Path, capture: &mut Capture) -> Result<(), SceneError> {
    let mut found = BTreeMap::new();
    let refuse =
        |problem: String, mend: &str| SceneError::new(folder.display().to_string(), problem, mend).at("--masks");
    let entries = std::fs::read_dir(folder)
        .map_err(|error| refuse(format!("cannot be read: {error}"), "name a folder of masks"))?;
    for path in entries.flatten().map(|entry| entry.path()).filter(|path| path.is_file()) {
        // 0001.mask.png is a mask of 0001, too.
        let name = name_of(&path);
        found.insert(name.strip_suffix(".mask").unwrap_or(&name).to_owned(), path);
    }
    let mut without = Vec::new();
    for index in 0..capture.photos.len() {
        let name = capture.photos[index].name().to_owned();
        let Some(path) = found.get(&name) else {
            without.push(name);
            continue;
        };
        let (relative, size) = place.photo(path)?;
        let camera = capture.camera_of(&capture.photos[index]);
        if size != (camera.width, camera.height) {
            let problem = format!("is {} x {}, its photo {} x {}", size.0, size.1, camera.width, camera.height);
            return Err(SceneError::new(relative, problem, "draw the mask at the photo's size"));
        }
        capture.photos[index].mask = Some(relative);
    }
    if without.len() == capture.photos.len() {
        let mend = "name masks as their photos: IMG_1000.png for IMG_1000.jpg";
        return Err(refuse("has a mask for none of the photos".to_owned(), mend));
    }
    if !without.is_empty() {
        let all = without.join(", ");
        tell_error(&format!("warning: no mask for {all}: the whole picture counts there"));
    }
    Ok(())
}

/// Cameras on a circle.
///
/// # Errors
/// A photo that is missing or is none.
pub(super) fn guessed(place: &Place, photos: &[PathBuf], centre: [f64; 3], distance: f64) -> Result<Views, SceneError> {
    let view = |(file, camera_to_world): (&PathBuf, _)| {
        let (file, (width, height)) = place.photo(file)?;
        let (w, h) = (f64::from(width), f64::from(height));
        let camera = Camera { width, height, fx: 1.2 * w, fy: 1.2 * w, cx: w / 2.0, cy: h / 2.0, ..Camera::default() };
        Ok(View { file, camera, camera_to_world })
    };
    let posed: Result<Vec<View>, SceneError> =
        photos.iter().zip(ring(centre, distance, photos.len())).map(view).collect();
    Ok(Views { posed: posed?, unposed: Vec::new() })
}
