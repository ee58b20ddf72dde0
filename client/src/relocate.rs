//! Moves a capture's description to another folder: the files stay, their paths are written anew.

use crate::failure::Failure;
use gonio_scene::capture::LightKind;
use gonio_scene::{Capture, SceneError};
use std::path::{Component, Path, PathBuf};

/// Rewrites every path of `capture`, relative to the folder `from`, so that it leads to the same file from the folder
/// `to`: relative where the two share a folder below the file system's root, absolute elsewhere.
///
/// # Errors
/// A folder that does not exist, a path that is not UTF-8.
pub fn relocate(capture: &mut Capture, from: &Path, to: &Path) -> Result<(), Failure> {
    let from = canonical(from)?;
    let to = canonical(to)?;
    let mut paths: Vec<&mut String> = Vec::new();
    paths.extend(capture.objects.iter_mut().map(|object| &mut object.mesh));
    paths.extend(capture.materials.iter_mut().flat_map(|material| material.maps.files_mut()));
    for light in &mut capture.lights {
        if let LightKind::Map { map, .. } = &mut light.kind {
            paths.push(map);
        }
    }
    for photo in &mut capture.photos {
        paths.push(&mut photo.file);
        paths.extend(&mut photo.mask);
    }
    paths.extend(capture.reflectance.iter_mut().map(|reflectance| &mut reflectance.file));
    for path in paths {
        *path = moved(path, &from, &to)?;
    }
    Ok(())
}

/// `path` as seen from `to` instead of from `from`; both folders are canonical.
fn moved(path: &str, from: &Path, to: &Path) -> Result<String, Failure> {
    if Path::new(path).is_absolute() {
        return Ok(path.to_owned());
    }
    let file = from.join(path);
    // The file's own links stay: they may lead to a store whose names say neither format nor photo.
    let file = match (file.parent().map(Path::canonicalize), file.file_name()) {
        (Some(Ok(parent)), Some(name)) => parent.join(name),
        _ => file,
    };
    let seen = relative(&file, to).unwrap_or(file);
    let text = |component: Component<'_>| match component {
        Component::ParentDir => Some("..".to_owned()),
        other => other.as_os_str().to_str().map(str::to_owned),
    };
    let written = if seen.is_absolute() {
        seen.to_str().map(str::to_owned)
    } else {
        // Forward slashes read back on every system.
        seen.components().map(text).collect::<Option<Vec<_>>>().map(|parts| parts.join("/"))
    };
    written.ok_or_else(|| {
        let error = SceneError::new(seen.display().to_string(), "is a path that is not UTF-8", "rename its folder");
        error.into()
    })
}

/// The way from the folder `to` to `file`, if they share more than the root.
fn relative(file: &Path, to: &Path) -> Option<PathBuf> {
    let (file, to): (Vec<_>, Vec<_>) = (file.components().collect(), to.components().collect());
    let shared = file.iter().zip(&to).take_while(|(a, b)| a == b).count();
    let below_root = file.iter().take(shared).any(|component| matches!(component, Component::Normal(_)));
    let up = to.iter().skip(shared).map(|_| Component::ParentDir);
    below_root.then(|| up.chain(file.iter().skip(shared).copied()).collect())
}

fn canonical(folder: &Path) -> Result<PathBuf, Failure> {
    folder.canonicalize().map_err(|error| Failure::Failed(format!("{}: {error}", folder.display())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_lead_to_the_same_files() {
        let top = tempfile::tempdir().unwrap();
        for folder in ["a/capture/photos", "a/out/deep", "a/meshes"] {
            std::fs::create_dir_all(top.path().join(folder)).unwrap();
        }
        let top = top.path().canonicalize().unwrap();
        let (from, to) = (top.join("a/capture"), top.join("a/out/deep"));
        assert_eq!(moved("photos/00.exr", &from, &to).unwrap(), "../../capture/photos/00.exr");
        assert_eq!(moved("../meshes/part.ply", &from, &to).unwrap(), "../../meshes/part.ply");
        assert_eq!(moved("/elsewhere/part.ply", &from, &to).unwrap(), "/elsewhere/part.ply");
        assert_eq!(moved("photos/00.exr", &from, &from).unwrap(), "photos/00.exr");
        assert_eq!(moved("../out/deep/part.ply", &from, &to).unwrap(), "part.ply");
    }

    #[test]
    fn folders_that_share_only_the_root_get_absolute_paths() {
        assert_eq!(moved("part.ply", Path::new("/one"), Path::new("/two")).unwrap(), "/one/part.ply");
    }
}
