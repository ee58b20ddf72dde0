//! Checkpoints: the journal of every evaluation that a fit has paid for.
//!
//! Evaluations are pure functions of parameters, samples and seed, and each solver is a pure function of the
//! evaluations. So a resumed fit runs from its start and takes from the journal what it holds: it arrives where it was
//! within milliseconds and goes on with the same bits, for every solver, without any solver's state in the file.
//!
//! The file has one JSON record per line and is only ever appended to; a line that a crash has cut short is dropped.

use crate::event::Iteration;
use crate::{FitError, SolverName};
use gonio_scene::PhotoStatistics;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

/// What identifies a fit: a checkpoint may continue no other.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Identity {
    pub solver: SolverName,
    pub seed: u64,
    pub start: Vec<f64>,
    pub capture: String,
    /// See [`crate::Options::files`].
    pub files: BTreeMap<String, String>,
}

impl Identity {
    /// That a checkpoint of `old` may be continued.
    fn continues(&self, old: &Self) -> Result<(), FitError> {
        let differs = [
            ("solver", old.solver != self.solver),
            ("seed", old.seed != self.seed),
            ("start", old.start != self.start),
            ("capture", old.capture != self.capture),
        ];
        if let Some((what, _)) = differs.iter().find(|d| d.1) {
            return Err(FitError::Resume { what });
        }
        let mut files = self.files.keys().chain(old.files.keys());
        match files.find(|file| self.files.get(*file) != old.files.get(*file)) {
            Some(file) => Err(FitError::ResumeFile { file: file.clone() }),
            None => Ok(()),
        }
    }
}

/// One evaluation of the fitted photos.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Entry {
    /// Physical values of the parameters.
    pub values: Vec<f64>,
    pub samples: u32,
    /// Whether derivatives were asked for.
    pub columns: bool,
    pub primary_samples: u64,
    #[serde(with = "photos")]
    pub photos: Vec<PhotoStatistics>,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Record {
    Fit(Identity),
    Evaluation(Entry),
    /// For people: the solver finds its way without.
    Iteration(Iteration),
}

/// The state of an interrupted fit.
#[derive(Debug, Clone)]
pub struct Checkpoint {
    pub(crate) identity: Identity,
    pub(crate) entries: Vec<Entry>,
}

impl Checkpoint {
    /// Reads a checkpoint file.
    ///
    /// # Errors
    /// [`FitError::Checkpoint`]: no such file, or no checkpoint.
    pub fn read(path: &Path) -> Result<Self, FitError> {
        let refuse = |problem: String| FitError::Checkpoint { path: path.to_owned(), problem };
        let text =
            std::fs::read_to_string(path).map_err(|e| refuse(format!("{e}; name a checkpoint of an earlier fit")))?;
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        let mut records = whole.lines().enumerate().map(|(i, line)| {
            serde_json::from_str::<Record>(line)
                .map_err(|e| refuse(format!("line {} is no checkpoint record ({e}); start anew without it", i + 1)))
        });
        let Some(Record::Fit(identity)) = records.next().transpose()? else {
            return Err(refuse("does not begin as a checkpoint does; start anew without it".to_owned()));
        };
        let mut entries = Vec::new();
        for record in records {
            if let Record::Evaluation(entry) = record? {
                entries.push(entry);
            }
        }
        Ok(Self { identity, entries })
    }

    /// Evaluations that need not be done again.
    #[must_use]
    pub fn evaluations(&self) -> usize {
        self.entries.len()
    }
}

/// All evaluations so far, in memory and, where asked for, in a file.
pub(crate) struct Journal {
    entries: Vec<Entry>,
    file: Option<(PathBuf, File)>,
}

impl Journal {
    /// A journal that begins with what `resume` holds. An existing file at `path` is replaced in one step, by one that
    /// holds the same.
    pub fn new(identity: &Identity, resume: Option<&Checkpoint>, path: Option<&Path>) -> Result<Self, FitError> {
        if let Some(old) = resume {
            identity.continues(&old.identity)?;
        }
        let entries = resume.map(|r| r.entries.clone()).unwrap_or_default();
        let file = path.map(|p| begin(p, identity, &entries)).transpose()?;
        Ok(Self { entries, file })
    }

    /// The evaluation at `values`, if it was done; one with derivatives also serves where none are wanted.
    pub fn find(&self, values: &[f64], samples: u32, columns: bool) -> Option<&Entry> {
        self.entries.iter().rev().find(|e| e.samples == samples && e.columns >= columns && e.values == values)
    }

    /// Adds an evaluation.
    pub fn push(&mut self, entry: Entry) -> Result<(), FitError> {
        self.append(&Record::Evaluation(entry.clone()))?;
        self.entries.push(entry);
        Ok(())
    }

    /// Notes an iteration for the file's reader.
    pub fn note(&mut self, iteration: &Iteration) -> Result<(), FitError> {
        self.append(&Record::Iteration(iteration.clone()))
    }

    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// Camera samples of all evaluations.
    pub fn primary_samples(&self) -> u64 {
        self.entries.iter().map(|e| e.primary_samples).sum()
    }

    fn append(&mut self, record: &Record) -> Result<(), FitError> {
        let Some((path, file)) = &mut self.file else { return Ok(()) };
        line(record).and_then(|text| file.write_all(&text)).map_err(|e| unwritable(path, &e))
    }
}

fn line(record: &Record) -> std::io::Result<Vec<u8>> {
    let mut text = serde_json::to_vec(record)?;
    text.push(b'\n');
    Ok(text)
}

fn unwritable(path: &Path, error: &std::io::Error) -> FitError {
    let problem = format!("cannot be written ({error}); name a writable place for the checkpoint");
    FitError::Checkpoint { path: path.to_owned(), problem }
}

/// A new file beside the old one, complete before it takes the old one's name; returned open at its end.
fn begin(path: &Path, identity: &Identity, entries: &[Entry]) -> Result<(PathBuf, File), FitError> {
    let mut part = path.as_os_str().to_owned();
    part.push(".part");
    let write = || {
        let mut file = File::create(&part)?;
        file.write_all(&line(&Record::Fit(identity.clone()))?)?;
        for entry in entries {
            file.write_all(&line(&Record::Evaluation(entry.clone()))?)?;
        }
        file.sync_all()?;
        std::fs::rename(&part, path)?;
        Ok(file)
    };
    write().map(|file| (path.to_owned(), file)).map_err(|e| unwritable(path, &e))
}

/// [`PhotoStatistics`], which know no serde, field by field.
mod photos {
    use gonio_scene::PhotoStatistics;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[derive(Serialize, Deserialize)]
    #[serde(remote = "PhotoStatistics")]
    struct Fields {
        photo: usize,
        observations: u64,
        #[serde(default)]
        compared: u64,
        gram: Vec<f64>,
        noise: Vec<f64>,
        #[serde(default)]
        draw: Vec<f64>,
        noise_floor: f64,
        render_noise: f64,
        squared_error: f64,
        log_variance: f64,
        peak: f64,
        invalid_samples: u64,
    }

    #[derive(Serialize)]
    struct Borrowed<'a>(#[serde(with = "Fields")] &'a PhotoStatistics);

    #[derive(Deserialize)]
    struct Owned(#[serde(with = "Fields")] PhotoStatistics);

    pub fn serialize<S: Serializer>(photos: &[PhotoStatistics], to: S) -> Result<S::Ok, S::Error> {
        to.collect_seq(photos.iter().map(Borrowed))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<PhotoStatistics>, D::Error> {
        Ok(Vec::<Owned>::deserialize(from)?.into_iter().map(|o| o.0).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn identity() -> Identity {
        let files = [("part.ply", "a"), ("00.exr", "b")].map(|(file, digest)| (file.to_owned(), digest.to_owned()));
        let (capture, files) = ("x".to_owned(), files.into());
        Identity { solver: SolverName::LBfgs, seed: u64::MAX, start: vec![0.1 + 0.2], capture, files }
    }

    fn entry(value: f64) -> Entry {
        let photo = PhotoStatistics { photo: 3, gram: vec![value / 3.0, 1e-300, -0.1], ..PhotoStatistics::default() };
        Entry { values: vec![value], samples: 4, columns: true, primary_samples: 7, photos: vec![photo] }
    }

    #[test]
    fn reads_back_to_the_last_bit_and_drops_a_torn_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("fit.checkpoint");
        let mut journal = Journal::new(&identity(), None, Some(&path)).unwrap();
        for i in 1..20 {
            journal.push(entry(std::f64::consts::PI / f64::from(i))).unwrap();
        }
        let mut text = std::fs::read(&path).unwrap();
        text.extend_from_slice(b"{\"evaluation\":{\"val");
        std::fs::write(&path, &text).unwrap();
        let back = Checkpoint::read(&path).unwrap();
        assert_eq!((back.identity.clone(), back.evaluations()), (identity(), 19));
        for (a, b) in back.entries.iter().zip(journal.entries()) {
            assert_eq!((&a.values, &a.photos), (&b.values, &b.photos));
        }
        // Going on replaces the file by a whole one.
        drop(Journal::new(&identity(), Some(&back), Some(&path)).unwrap());
        assert_eq!(Checkpoint::read(&path).unwrap().evaluations(), 19);
    }

    #[test]
    fn refuses_another_fits_checkpoint_and_other_files() {
        let old = Checkpoint { identity: identity(), entries: Vec::new() };
        let other = Identity { seed: 1, ..identity() };
        let error = Journal::new(&other, Some(&old), None).err().unwrap().to_string();
        assert_eq!(error, "the checkpoint is of another fit: its seed differs; resume with the same, or start anew");
        // A file that is another, one that came, one that went.
        for (file, digest) in [("part.ply", Some("c")), ("mask.png", Some("d")), ("00.exr", None)] {
            let mut other = identity();
            other.files.remove(file);
            other.files.extend(digest.map(|digest| (file.to_owned(), digest.to_owned())));
            let error = Journal::new(&other, Some(&old), None).err().unwrap().to_string();
            assert!(error.starts_with(file) && error.contains("start anew without --resume"), "{error}");
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x");
        assert!(Checkpoint::read(&path).unwrap_err().to_string().contains("earlier fit"));
        for text in ["", "\n", "{\"fit\": 3}\n", "not json\n"] {
            std::fs::write(&path, text).unwrap();
            assert!(Checkpoint::read(&path).unwrap_err().to_string().contains("start anew"), "{text:?}");
        }
        let nowhere = folder.path().join("no/such/folder/c");
        assert!(Journal::new(&identity(), None, Some(&nowhere)).err().unwrap().to_string().contains("writable"));
    }
}
