//! `gonio import`: a capture of poses that others estimated.

use super::draft::{Place, name_of, text};
use crate::failure::Failure;
use clap::{Args, ValueEnum};
use gonio_calibrate::{Draft, Imported, Part, bop, colmap, colmap_binary, transforms};
use gonio_scene::files::{DirectoryFiles, Files};
use gonio_scene::{Result, SceneError};
use std::path::{Path, PathBuf};

/// Who estimated the poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Source {
    /// A folder with COLMAP's cameras.bin and images.bin, or cameras.txt and images.txt
    Colmap,
    /// A transforms.json of NeRF, instant-ngp or nerfstudio
    Transforms,
    /// A scene's folder of the BOP benchmark: scene_camera.json, scene_gt.json, rgb/
    Bop,
}

/// `gonio import`.
#[derive(Debug, Args)]
pub struct ImportArguments {
    /// Who estimated the poses
    #[arg(value_enum)]
    pub source: Source,
    /// COLMAP's model folder, a transforms.json, or a scene's folder of BOP
    pub path: PathBuf,
    /// The capture.toml to write, in a folder of its own or beside the photos; must not exist yet
    #[arg(long, value_name = "DIR/capture.toml")]
    pub out: PathBuf,
    /// Folder of the photos; absent, images/ beside or above COLMAP's model, the folder of transforms.json, or BOP's rgb/ or gray/
    #[arg(long, value_name = "DIR")]
    pub images: Option<PathBuf>,
    /// Folder of BOP's obj_*.ply; absent, the data set's models/ if there is one
    #[arg(long, value_name = "DIR")]
    pub models: Option<PathBuf>,
    /// Write the summary as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// Imports and writes.
///
/// # Errors
/// A file that is missing or not of its format.
pub fn run(arguments: &ImportArguments) -> std::result::Result<(), Failure> {
    let place = Place::new(&arguments.out)?;
    let path = &arguments.path;
    if arguments.models.is_some() && arguments.source != Source::Bop {
        let mend = "leave out --models: only a scene of BOP names meshes; add others by `gonio new --poses`";
        return Err(Failure::Input(format!("--models: is for bop alone; {mend}")));
    }
    let (imported, parts) = match arguments.source {
        Source::Colmap => (read_colmap(&place, path, arguments.images.as_deref())?, Vec::new()),
        Source::Transforms => (read_transforms(&place, path, arguments.images.as_deref())?, Vec::new()),
        Source::Bop => {
            let imported = read_bop(&place, path, arguments.images.as_deref())?;
            let parts = meshes(&place, path, arguments.models.as_deref(), &imported)?;
            (imported, parts)
        }
    };
    let mut draft = Draft::new(&name_of(path), &imported.views, &parts, Vec::new());
    if let Some(first) = imported.views.first() {
        draft.note("[[photo]]", &first.file, "camera_to_world", imported.world);
    }
    place.write(&draft, arguments.json, &serde_json::json!({}))
}

/// The first of `folders` that holds `name`.
fn find(folders: &[PathBuf], name: &str) -> Option<PathBuf> {
    folders.iter().map(|folder| folder.join(name)).find(|file| file.is_file())
}

/// The endings of images that a source may leave away or write otherwise.
const ENDINGS: [&str; 7] = ["png", "jpg", "jpeg", "exr", "tif", "tiff", "hdr"];

/// An image by the name that a source has for it: with slashes of either kind, with its ending, without one, or with one in
/// other letters.
fn find_image(folders: &[PathBuf], name: &str) -> Option<PathBuf> {
    let slashed = name.replace('\\', "/");
    if let Some(found) = find(folders, name).or_else(|| find(folders, &slashed)) {
        return Some(found);
    }
    let (folder, last) = slashed.rsplit_once('/').unwrap_or((".", &slashed));
    let (stem, ending) = last.rsplit_once('.').unwrap_or((last, ""));
    let known = |ending: &str| ENDINGS.iter().position(|known| known.eq_ignore_ascii_case(ending));
    let stem = if known(ending).is_some() { stem } else { last };
    let mut found = Vec::new();
    for entry in folders.iter().filter_map(|above| std::fs::read_dir(above.join(folder)).ok()).flatten().flatten() {
        let file = entry.file_name().to_string_lossy().into_owned();
        let Some((own, own_ending)) = file.rsplit_once('.') else { continue };
        let Some(rank) = known(own_ending) else { continue };
        let same = known(ending).is_none() || ending.eq_ignore_ascii_case(own_ending);
        if own == stem && same && entry.path().is_file() {
            found.push((rank, file.clone(), entry.path()));
        }
    }
    // The order of a folder is no order.
    found.sort();
    found.into_iter().next().map(|(.., path)| path)
}

fn missing(name: &str, folders: &[PathBuf]) -> SceneError {
    let looked = folders.iter().map(|folder| folder.display().to_string()).collect::<Vec<_>>().join(", ");
    SceneError::new(name, format!("is not in {looked}"), "name the folder of the photos by --images")
}

fn read_colmap(place: &Place, path: &Path, images: Option<&Path>) -> Result<Imported> {
    // As COLMAP does: the binary model counts where both are there.
    let binary = ["cameras.bin", "images.bin"].iter().any(|name| path.join(name).is_file());
    let mend = "name a model's folder, with cameras.bin and images.bin or with cameras.txt and images.txt";
    let mut imported = if binary {
        let files = DirectoryFiles::new(path);
        let bytes = |name: &str| files.read(name).map_err(|error| SceneError { mend: mend.to_owned(), ..error });
        colmap_binary(&bytes("cameras.bin")?, &bytes("images.bin")?)?
    } else {
        colmap(&text(path, "cameras.txt", mend)?, &text(path, "images.txt", mend)?)?
    };
    let above = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let folders = match images {
        Some(folder) => vec![folder.to_owned()],
        None => above.ancestors().take(4).map(|folder| folder.join("images")).collect(),
    };
    for view in &mut imported.views {
        let file = find_image(&folders, &view.file).ok_or_else(|| missing(&view.file, &folders))?;
        let (relative, size) = place.photo(&file)?;
        if size != (view.camera.width, view.camera.height) {
            let (width, height) = (view.camera.width, view.camera.height);
            let problem = format!("is {} x {}, its camera in COLMAP's model {width} x {height}", size.0, size.1);
            let mend = "name the photos that COLMAP was given by --images";
            return Err(SceneError::new(relative, problem, mend));
        }
        view.file = relative;
    }
    Ok(imported)
}

fn read_transforms(place: &Place, path: &Path, images: Option<&Path>) -> Result<Imported> {
    let file = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let beside = path.parent().map(Path::to_owned).unwrap_or_default();
    let beside = if beside.as_os_str().is_empty() { PathBuf::from(".") } else { beside };
    let text = text(&beside, &file, "name a transforms.json")?;
    let folders = [images.map_or(beside, Path::to_owned)];
    let locate = |name: &str| place.photo(&find_image(&folders, name).ok_or_else(|| missing(name, &folders))?);
    transforms(&file, &text, &locate)
}

fn read_bop(place: &Place, path: &Path, images: Option<&Path>) -> Result<Imported> {
    let camera = text(path, "scene_camera.json", "name the folder of one scene, such as test/000002")?;
    let truth = if path.join("scene_gt.json").exists() { Some(text(path, "scene_gt.json", "")?) } else { None };
    let folders = match images {
        Some(folder) => vec![folder.to_owned()],
        None => vec![path.join("rgb"), path.join("gray")],
    };
    let locate = |number: u32| {
        let stem = format!("{number:06}");
        place.photo(&find_image(&folders, &stem).ok_or_else(|| missing(&stem, &folders))?)
    };
    bop(&camera, truth.as_deref(), &locate)
}

/// The scene's objects whose meshes are found; several of one number are numbered on.
fn meshes(place: &Place, path: &Path, models: Option<&Path>, imported: &Imported) -> Result<Vec<Part>> {
    let above = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let folders = match models {
        Some(folder) => vec![folder.to_owned()],
        None => above.ancestors().skip(1).take(2).map(|folder| folder.join("models")).collect(),
    };
    let mut parts: Vec<Part> = Vec::new();
    for (id, object_to_world) in &imported.objects {
        let file = format!("obj_{id:06}.ply");
        let Some(mesh) = find(&folders, &file) else {
            if models.is_some() {
                return Err(SceneError {
                    mend: "name the folder of the meshes by --models".into(),
                    ..missing(&file, &folders)
                });
            }
            continue;
        };
        let same = parts.iter().filter(|part| part.name.starts_with(&format!("obj_{id:06}"))).count();
        let name = if same == 0 { format!("obj_{id:06}") } else { format!("obj_{id:06}_{}", same + 1) };
        let guess = "where the first photo's pose puts it; millimetres become metres".to_owned();
        parts.push(Part { name, mesh: place.relative(&mesh)?, object_to_world: *object_to_world, guess });
    }
    Ok(parts)
}
