//! A dataset on disk: `models/`, `SPLIT/SCENE/` with cameras, poses and images.

use super::{Depth, Frame, Model, Models, ModelsFolder, Scene};
use gonio_scene::files::DirectoryFiles;
use gonio_scene::image::{self, Image};
use gonio_scene::{Result, SceneError};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A split of a dataset, its images unread.
#[derive(Debug, Clone)]
pub struct Dataset {
    /// The folder that holds the split and the models.
    pub root: PathBuf,
    /// The split's folder inside of it, such as `test`.
    pub split: String,
    /// By the scene's number.
    pub scenes: BTreeMap<u32, Scene>,
    files: DirectoryFiles,
}

impl Dataset {
    /// Opens the dataset in the folder `path`, or the split that `path` itself is. Of several splits, `split` names one;
    /// without it, it is `test` where that exists.
    ///
    /// # Errors
    /// No split or several, or a scene that cannot be read.
    pub fn open(path: &Path, split: Option<&str>) -> Result<Self> {
        let refuse = |problem: String, mend: &str| SceneError::new(path.display().to_string(), problem, mend);
        let (root, split) = if scene_folders(path).is_empty() {
            let splits: Vec<String> =
                folders(path).into_iter().filter(|name| !scene_folders(&path.join(name)).is_empty()).collect();
            let wanted = split.map_or_else(
                || if splits.len() == 1 { splits.first() } else { splits.iter().find(|name| *name == "test") },
                |name| splits.iter().find(|split| *split == name),
            );
            let wanted = wanted.ok_or_else(|| {
                let problem = format!("has the splits [{}]", splits.join(", "));
                refuse(
                    problem,
                    "name a BOP dataset: SPLIT/SCENE/scene_camera.json; name one of several splits by --split",
                )
            })?;
            (path.to_owned(), wanted.clone())
        } else {
            let whole = path.canonicalize().map_err(|error| refuse(error.to_string(), "name a folder"))?;
            let name = whole.file_name().unwrap_or_default().to_string_lossy().into_owned();
            (whole.parent().unwrap_or(&whole).to_owned(), name)
        };
        let files = DirectoryFiles::new(&root);
        let mut scenes = BTreeMap::new();
        for (number, name) in scene_folders(&root.join(&split)) {
            let has = |path: &str| root.join(path).is_file();
            scenes.insert(number, Scene::read(&files, &format!("{split}/{name}"), &has)?);
        }
        Ok(Self { root, split, scenes, files })
    }

    /// What is known of an image; `None` where the dataset has no such image.
    #[must_use]
    pub fn frame(&self, scene: u32, image: u32) -> Option<&Frame> {
        self.scenes.get(&scene)?.frames.get(&image)
    }

    /// Every image, as (scene, image, what is known of it), in order.
    pub fn frames(&self) -> impl Iterator<Item = (u32, u32, &Frame)> {
        self.scenes.iter().flat_map(|(&scene, list)| list.frames.iter().map(move |(&image, f)| (scene, image, f)))
    }

    /// The models, in metres.
    ///
    /// # Errors
    /// There is no folder of models, or one cannot be read.
    pub fn models(&self, folder: ModelsFolder) -> Result<Models> {
        Model::read_all(&self.files, self.models_folder(folder))
    }

    /// Which folder of the dataset holds its models.
    #[must_use]
    pub fn models_folder(&self, folder: ModelsFolder) -> &'static str {
        let order = match folder {
            ModelsFolder::Evaluation => ["models_eval", "models"],
            ModelsFolder::Rendering => ["models", "models_eval"],
        };
        if self.root.join(order[0]).join("models_info.json").is_file() { order[0] } else { order[1] }
    }

    /// The path, inside the dataset, of an image's colour file (`rgb/` or `gray/`); `None` where there is none.
    #[must_use]
    pub fn colour_path(&self, scene: u32, image: u32) -> Option<String> {
        let names = [("rgb", "png"), ("rgb", "jpg"), ("gray", "png"), ("gray", "tif"), ("gray", "jpg")];
        names.iter().find_map(|(kind, extension)| self.file(scene, &format!("{kind}/{image:06}.{extension}")))
    }

    /// An image's colours: values from 0 to 1 as stored, mostly with the transfer curve of sRGB.
    ///
    /// # Errors
    /// There is no such image, or it cannot be read.
    pub fn colour(&self, scene: u32, image: u32) -> Result<Image> {
        let path = self.colour_path(scene, image).ok_or_else(|| {
            let file = format!("{}/{scene:06}/rgb/{image:06}.png", self.split);
            SceneError::new(file, "does not exist", "add the image, or remove it from scene_camera.json")
        })?;
        image::read(&self.files, &path)
    }

    /// Width and height of an image in pixels, without decoding it.
    ///
    /// # Errors
    /// As [`Self::colour`].
    pub fn size(&self, scene: u32, image: u32) -> Result<(u32, u32)> {
        match self.colour_path(scene, image) {
            Some(path) => image::dimensions(&self.files, &path),
            None => self.colour(scene, image).map(|image| (image.width, image.height)),
        }
    }

    /// An image's depth; `None` where the dataset has none.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn depth(&self, scene: u32, image: u32) -> Result<Option<Depth>> {
        let Some(frame) = self.frame(scene, image) else { return Ok(None) };
        let Some(path) = self.file(scene, &format!("depth/{image:06}.png")) else { return Ok(None) };
        Depth::read(&self.files, &path, frame.depth_step).map(Some)
    }

    /// Whether an image has a depth file.
    #[must_use]
    pub fn has_depth(&self, scene: u32, image: u32) -> bool {
        self.file(scene, &format!("depth/{image:06}.png")).is_some()
    }

    /// The file `name` of a scene, where it exists, relative to the root.
    fn file(&self, scene: u32, name: &str) -> Option<String> {
        let path = format!("{}/{scene:06}/{name}", self.split);
        self.root.join(&path).is_file().then_some(path)
    }
}

/// Names of the folders in `path`, sorted.
fn folders(path: &Path) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(path) else { return Vec::new() };
    let mut names: Vec<String> = entries
        .flatten()
        .filter(|entry| entry.path().is_dir())
        .filter_map(|entry| entry.file_name().into_string().ok())
        .collect();
    names.sort();
    names
}

/// The scenes in `path`, by number: six digits, with cameras inside.
fn scene_folders(path: &Path) -> Vec<(u32, String)> {
    let scene = |name: String| match name.parse() {
        Ok(number) if name.len() == 6 && path.join(&name).join("scene_camera.json").is_file() => Some((number, name)),
        _ => None,
    };
    folders(path).into_iter().filter_map(scene).collect()
}
