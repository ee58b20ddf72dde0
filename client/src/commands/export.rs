//! `gonio export`: a capture in the words of other programs, and what became of every number.

use crate::failure::Failure;
use crate::input::Input;
use crate::output::{Output, tell, to_json};
use crate::progress::plural;
use clap::Args;
use gonio_export::{Entry, ExportError, Format, RECORD_FILE, Record, export};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// `gonio export`.
#[derive(Debug, Args)]
pub struct ExportArguments {
    /// The capture's folder or its capture.toml; the photographs' files need not exist
    pub capture: PathBuf,
    /// For which program: mitsuba (3), blender (4 and 5), usd, gltf or pbrt (v4)
    #[arg(long, value_name = "FORMAT")]
    pub to: Format,
    /// Folder to write the scene, its meshes and maps, sensor.py and export.json to; created if need be
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Write what export.json holds as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// Converts and writes: the files below the folder `out`; gives what became of every number.
///
/// # Errors
/// A broken capture, one without photos or objects, a folder that cannot be written to.
pub fn write(input: &Input, format: Format, out: &Path) -> Result<Record, Failure> {
    let export = export(&input.capture, input, format)?;
    let names: Vec<String> = export.files.keys().cloned().collect();
    let folder = Output::create(out, &names, &input.root, &input.capture)?;
    for (name, bytes) in &export.files {
        if let Some((inside, _)) = name.rsplit_once('/') {
            let inside = folder.path(inside);
            std::fs::create_dir_all(&inside)
                .map_err(|error| Failure::Failed(format!("{}: cannot be created: {error}", inside.display())))?;
        }
        folder.write(name, bytes)?;
    }
    Ok(export.record)
}

/// Reads, converts, writes and tells.
///
/// # Errors
/// As [`write()`].
pub fn run(arguments: &ExportArguments) -> Result<(), Failure> {
    let record = write(&Input::open(&arguments.capture)?, arguments.to, &arguments.out)?;
    if arguments.json {
        tell(&to_json(&record)?);
    } else {
        tell(table(&record).trim_end());
        // The record names the others.
        let (files, dir) = (plural(record.files.len() + 1, "file"), arguments.out.display());
        tell(&format!("exported {} for {} to {dir}: {files}", record.capture, arguments.to));
    }
    Ok(())
}

impl From<ExportError> for Failure {
    fn from(error: ExportError) -> Self {
        match error {
            ExportError::Capture(error) => error.into(),
            ExportError::Json { .. } => Self::Failed(error.to_string()),
        }
    }
}

/// What was not kept exactly, a line for every key and reason; then how many numbers were.
fn table(record: &Record) -> String {
    let mut text = String::new();
    for word in ["lost", "approximated"] {
        let mut lines: BTreeMap<(&str, String), usize> = BTreeMap::new();
        for entry in record.numbers.iter().filter(|entry| entry.kept.word() == word) {
            *lines.entry((entry.kept.how(), key(entry))).or_default() += 1;
        }
        for ((how, key), count) in lines {
            let many = if count > 1 { format!(" ({count})") } else { String::new() };
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{word:<13}{:<40} {how}", format!("{key}{many}"));
        }
    }
    let exact = record.numbers.iter().filter(|entry| entry.kept.word() == "exact").count();
    let _ = writeln!(
        text,
        "{:<13}{exact} of {}; {RECORD_FILE} lists them all",
        "exact",
        plural(record.numbers.len(), "number")
    );
    for remark in &record.remarks {
        let _ = writeln!(text, "{:<13}{remark}", "note");
    }
    text
}

/// An entry's name, of a photo's number without the photo, of a list's without the place in it.
fn key(entry: &Entry) -> String {
    let parts: Vec<&str> = entry.name.split('.').collect();
    let list = |part: &str| part.len() == 1 || part.chars().all(|c| c.is_ascii_digit());
    let kept = parts.iter().rposition(|part| !list(part)).map_or(parts.len(), |last| last + 1);
    let kept = if parts[kept - 1].len() == 2 && parts.contains(&"distortion") { kept - 1 } else { kept };
    match parts[..kept] {
        ["photo", _, ref rest @ ..] if !rest.is_empty() => format!("photo.*.{}", rest.join(".")),
        ref all => all.join("."),
    }
}
