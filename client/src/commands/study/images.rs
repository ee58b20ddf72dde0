//! The images of a study and what they are.

use crate::failure::Failure;
use gonio_study::{StudyError, Truth};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// One image.
#[derive(Debug)]
pub(super) struct Shown {
    pub name: String,
    pub truth: Truth,
    pub kind: &'static str,
    pub bytes: Vec<u8>,
}

/// All images, sorted by name, so that orders do not hang on how a shell lists files.
#[derive(Debug)]
pub(super) struct Images(pub Vec<Shown>);

impl Images {
    /// Reads the files into memory: what is shown cannot change in the midst of a study.
    ///
    /// # Errors
    /// A file that is missing, no PNG or JPEG, named twice, or of unknown truth.
    pub(super) fn read(files: &[PathBuf], truths: Option<&Path>) -> Result<Self, Failure> {
        let truths = truths.map(table).transpose()?;
        let mut images = Vec::new();
        let mut names = BTreeSet::new();
        for file in files {
            let at = file.display().to_string();
            let refuse = |problem: String, mend: &str| Failure::from(StudyError::new(&at, problem, mend));
            let bytes = std::fs::read(file)
                .map_err(|error| refuse(format!("cannot be read: {error}"), "correct the path, or its permissions"))?;
            let kind = match image::guess_format(&bytes) {
                Ok(image::ImageFormat::Png) => "image/png",
                Ok(image::ImageFormat::Jpeg) => "image/jpeg",
                _ => {
                    return Err(refuse(
                        "is no PNG or JPEG".into(),
                        "convert it: browsers show no other that is read here",
                    ));
                }
            };
            image::load_from_memory(&bytes)
                .map_err(|error| refuse(format!("is damaged: {error}"), "write the file again"))?;
            let name = file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
            if name.contains(char::is_control) || !names.insert(name.clone()) {
                return Err(refuse(
                    format!("has the name \"{}\", which is taken or unprintable", name.escape_debug()),
                    "rename it",
                ));
            }
            let folder = file.parent().and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned());
            let truth = match &truths {
                Some(table) => table.get(&name).copied(),
                None => folder.as_deref().and_then(Truth::parse),
            };
            let mend = "put it into a folder real/ or synthetic/, or list image,truth in a table for --truth";
            let truth = truth.ok_or_else(|| refuse("is neither known as real nor as synthetic".into(), mend))?;
            images.push(Shown { name, truth, kind, bytes });
        }
        images.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(Self(images))
    }
}

fn table(path: &Path) -> Result<BTreeMap<String, Truth>, Failure> {
    let file = path.display().to_string();
    let text = std::fs::read_to_string(path)
        .map_err(|error| StudyError::new(&file, format!("cannot be read: {error}"), "name a table image,truth"))?;
    let mut truths = BTreeMap::new();
    for (number, line) in text.lines().enumerate().skip(1).filter(|(_, line)| !line.trim().is_empty()) {
        let (image, truth) = line.rsplit_once(',').unwrap_or((line, ""));
        let truth = Truth::parse(truth.trim()).ok_or_else(|| {
            StudyError::new(
                &file,
                format!("is \"{}\"", truth.trim()),
                "write real or synthetic, after a first line image,truth",
            )
            .at(number as u64 + 1, "truth")
        })?;
        truths.insert(image.trim().trim_matches('"').to_owned(), truth);
    }
    Ok(truths)
}
