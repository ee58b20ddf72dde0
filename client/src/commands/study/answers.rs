//! The table of answers on disk: every answer is there before it is confirmed.

use super::images::Images;
use crate::failure::Failure;
use gonio_study::{HEADER, Rating, Ratings, StudyError, line, whole_lines};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{File, OpenOptions};
use std::io::{Read, Write};
use std::path::Path;

/// The open table, and who has rated what.
#[derive(Debug)]
pub(super) struct Answers {
    file: File,
    /// Bytes that are whole answers.
    length: u64,
    rated: BTreeMap<String, BTreeSet<String>>,
}

impl Answers {
    /// Opens or makes the table; half a line, which a kill left, is cut off.
    ///
    /// # Errors
    /// A table that is none, that another study writes to, or of which an image has another truth now.
    pub(super) fn open(path: &Path, images: &Images) -> Result<Self, Failure> {
        let at = path.display().to_string();
        let failed = |error: std::io::Error| {
            Failure::from(StudyError::new(
                &at,
                format!("cannot be opened: {error}"),
                "name a file that can be written to by --out",
            ))
        };
        let mut file =
            OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path).map_err(failed)?;
        if file.try_lock().is_err() {
            let mend = "end the other study, or name another file by --out";
            return Err(StudyError::new(&at, "is being written to by another study", mend).into());
        }
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(failed)?;
        bytes.truncate(whole_lines(&bytes));
        if bytes.is_empty() {
            bytes = HEADER.as_bytes().to_vec();
            file.set_len(0).map_err(failed)?;
            std::io::Seek::rewind(&mut file).map_err(failed)?;
            file.write_all(&bytes).map_err(failed)?;
        }
        let length = bytes.len() as u64;
        file.set_len(length).and_then(|()| file.sync_all()).map_err(failed)?;
        let text = String::from_utf8(bytes)
            .map_err(|_| StudyError::new(&at, "is no UTF-8 text", "name another file by --out"))?;
        if !text.starts_with(HEADER) {
            let problem = "does not begin as a table of answers";
            return Err(StudyError::new(&at, problem, "name another file by --out").into());
        }
        let mut rated: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for row in Ratings::parse(&at, &text)?.rows {
            let changed = images.0.iter().any(|image| image.name == row.image && image.truth != row.truth);
            if changed {
                let problem = format!("says that \"{}\" is {}, it is not now", row.image, row.truth.word());
                return Err(StudyError::new(&at, problem, "mend the truth, or name another file by --out")
                    .of("truth")
                    .into());
            }
            rated.entry(row.observer).or_default().insert(row.image);
        }
        Ok(Self { file, length, rated })
    }

    /// Answers so far.
    pub(super) fn count(&self) -> usize {
        self.rated.values().map(BTreeSet::len).sum()
    }

    /// Whether `observer` has rated `image`.
    pub(super) fn has(&self, observer: &str, image: &str) -> bool {
        self.rated.get(observer).is_some_and(|images| images.contains(image))
    }

    /// Appends an answer and waits until the disk has it; where that fails, nothing of it stays in the table.
    ///
    /// # Errors
    /// The disk is full or gone.
    pub(super) fn add(&mut self, rating: Rating) -> std::io::Result<()> {
        let text = line(&rating);
        std::io::Seek::seek(&mut self.file, std::io::SeekFrom::Start(self.length))?;
        let written = self.file.write_all(text.as_bytes()).and_then(|()| self.file.sync_data());
        if let Err(error) = written {
            self.file.set_len(self.length)?;
            return Err(error);
        }
        self.length += text.len() as u64;
        self.rated.entry(rating.observer).or_default().insert(rating.image);
        Ok(())
    }
}
