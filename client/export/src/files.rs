//! What an export consists of.

use crate::ledger::{Entry, Ledger};
use crate::scene::Scene;
use crate::{ExportError, Format, RECORD_FILE, Result};
use serde::Serialize;
use std::collections::BTreeMap;

/// Files by their path below the folder of the export, with forward slashes.
pub(crate) type FileMap = BTreeMap<String, Vec<u8>>;

/// A capture in another format.
#[derive(Debug, Clone)]
pub struct Export {
    /// What to write: bytes by path below one folder, with forward slashes; `export.json` among them.
    pub files: BTreeMap<String, Vec<u8>>,
    /// What `export.json` says.
    pub record: Record,
}

/// What `export.json` says.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Record {
    /// The format's word.
    pub format: &'static str,
    /// The capture's name.
    pub capture: String,
    /// The other files, sorted.
    pub files: Vec<String>,
    /// The photos' names and what each is called in the export, in the capture's order.
    pub photos: Vec<PhotoName>,
    /// What holds for the whole of it.
    pub remarks: Vec<String>,
    /// What became of every number, sorted by name.
    pub numbers: Vec<Entry>,
}

/// A photo's two names.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct PhotoName {
    /// In the capture.
    pub name: String,
    /// In the export: of its file, its camera or its scene.
    pub exported: String,
}

impl Export {
    pub(crate) fn new(scene: &Scene<'_>, format: Format, ledger: Ledger, mut files: FileMap) -> Result<Self> {
        let photo = |view: &crate::view::View| PhotoName { name: view.name.clone(), exported: view.stem.clone() };
        let record = Record {
            format: format.word(),
            capture: scene.capture.name.clone(),
            files: files.keys().cloned().collect(),
            photos: scene.views.iter().map(photo).collect(),
            remarks: scene.remarks(format),
            numbers: ledger.entries(),
        };
        let mut text = pretty(RECORD_FILE, &record)?;
        text.push('\n');
        files.insert(RECORD_FILE.to_owned(), text.into_bytes());
        Ok(Self { files, record })
    }
}

/// `value` as JSON text with line breaks.
pub(crate) fn pretty(file: &str, value: &impl Serialize) -> Result<String> {
    serde_json::to_string_pretty(value)
        .map_err(|error| ExportError::Json { file: file.to_owned(), problem: error.to_string() })
}
