//! Where a sweep's results lie: a folder or a bucket.

use crate::failure::Failure;
use bytes::Bytes;
use futures::{StreamExt, TryStreamExt};
use gonio_scene::files::MemoryFiles;
use gonio_scene::image::{self, Image};
use gonio_scene::{Film, SceneError};
use gonio_store::{Objects, StoreError};
use gonio_sweep::{FrameDigest, Output, Record};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use tokio::runtime::Runtime;

/// What a record's file ends with.
const RECORD: &str = "json";

/// Records read at the same time.
const READS: usize = 32;

/// A folder or prefix, and what drives its calls.
pub(super) struct Place {
    url: String,
    runtime: Runtime,
    /// Absent for a folder that is not there and not to be made.
    objects: Option<Objects>,
}

impl Place {
    /// Opens `url`; a folder is made where it is missing, unless nothing is going to be written.
    ///
    /// # Errors
    /// A URL of no known store, a folder that cannot be made, a bucket that does not answer.
    pub fn open(url: &str, dry_run: bool) -> Result<Self, Failure> {
        let absent = dry_run && folder(url).is_some_and(|folder| !folder.exists());
        let refuse =
            |problem: String| SceneError::new(format!("--out {url}"), problem, "write a folder or s3://BUCKET/PREFIX");
        let objects = if absent { None } else { Some(Objects::open(url).map_err(refuse)?) };
        Ok(Self { url: url.to_owned(), runtime: runtime()?, objects })
    }

    /// Where nothing is and nothing is kept.
    ///
    /// # Errors
    /// The system allows no thread.
    pub fn nowhere() -> Result<Self, Failure> {
        Ok(Self { url: String::new(), runtime: runtime()?, objects: None })
    }

    /// Whether what is written is kept.
    pub fn keeps(&self) -> bool {
        self.objects.is_some()
    }

    /// The folder, where it is one.
    pub fn folder(&self) -> Option<PathBuf> {
        folder(&self.url)
    }

    /// As given.
    pub fn url(&self) -> &str {
        &self.url
    }

    /// Those of `digests` whose record and files are all there. Nothing is opened: a record may turn out to be broken.
    ///
    /// # Errors
    /// The store fails.
    pub fn listed(&self, digests: &[FrameDigest], outputs: &[Output]) -> Result<BTreeSet<FrameDigest>, Failure> {
        let Some(objects) = &self.objects else { return Ok(BTreeSet::new()) };
        let there = self.runtime.block_on(objects.list("frames")).map_err(|error| self.failed(&error))?;
        let has = |path: String| there.get(&path).is_some_and(|size| *size > 0);
        let whole = |digest: &&FrameDigest| {
            has(digest.path(RECORD)) && outputs.iter().all(|output| has(digest.path(output.ending())))
        };
        Ok(digests.iter().filter(whole).copied().collect())
    }

    /// The records of `digests`, without those that are broken.
    ///
    /// # Errors
    /// The store fails.
    pub fn records(
        &self,
        digests: &BTreeSet<FrameDigest>,
        kept: &dyn Fn(FrameDigest, Record) -> Record,
    ) -> Result<BTreeMap<FrameDigest, Record>, Failure> {
        let Some(objects) = &self.objects else { return Ok(BTreeMap::new()) };
        let read = |digest: FrameDigest| async move { Ok((digest, objects.get(&digest.path(RECORD)).await?)) };
        let reads = futures::stream::iter(digests.iter().copied()).map(read).buffer_unordered(READS);
        let collected = reads.try_fold(BTreeMap::new(), |mut records, (digest, bytes)| {
            let record = bytes.and_then(|bytes| Record::from_json(&bytes, &digest.to_string()));
            records.extend(record.map(|record| (digest, kept(digest, record))));
            futures::future::ready(Ok(records))
        });
        self.runtime.block_on(collected).map_err(|error| self.failed(&error))
    }

    /// Writes a frame's files, and then its record, which makes it a finished one.
    ///
    /// # Errors
    /// The store fails.
    pub fn put_frame(
        &self,
        digest: FrameDigest,
        files: Vec<(Output, Vec<u8>)>,
        record: &Record,
    ) -> Result<(), Failure> {
        let json = record.to_json().map_err(|error| Failure::Failed(format!("frame {digest}: is no JSON: {error}")))?;
        let Some(objects) = &self.objects else { return Ok(()) };
        let write = async {
            let put = |(output, bytes): (Output, Vec<u8>)| async move {
                objects.put(&digest.path(output.ending()), Bytes::from(bytes)).await
            };
            futures::future::try_join_all(files.into_iter().map(put)).await?;
            objects.put(&digest.path(RECORD), Bytes::from(json)).await
        };
        self.runtime.block_on(write).map_err(|error| self.failed(&error))
    }

    /// The photo values of a finished frame; `None` where no output keeps them all.
    ///
    /// # Errors
    /// The store fails, or holds a broken file.
    pub fn image(&self, photo: usize, digest: FrameDigest) -> Result<Option<Film>, Failure> {
        let Some(objects) = &self.objects else { return Ok(None) };
        let path = digest.path(Output::Exr.ending());
        let bytes = self.runtime.block_on(objects.get(&path)).map_err(|error| self.failed(&error))?;
        let Some(bytes) = bytes else { return Ok(None) };
        let file = MemoryFiles([(path.clone(), bytes.as_ref().into())].into());
        let Image { width, height, pixels } = image::read(&file, &path)?;
        let channels = (0..3).map(|channel| pixels.iter().map(|pixel| pixel[channel]).collect()).collect();
        Ok(Some(Film { photo, width, height, channels }))
    }

    /// Writes a file of the whole sweep.
    ///
    /// # Errors
    /// The store fails.
    pub fn put(&self, name: &str, bytes: Vec<u8>) -> Result<(), Failure> {
        let Some(objects) = &self.objects else { return Ok(()) };
        self.runtime.block_on(objects.put(name, Bytes::from(bytes))).map_err(|error| self.failed(&error))
    }

    fn failed(&self, error: &StoreError) -> Failure {
        Failure::Failed(format!("--out {}: {error}", self.url))
    }
}

fn runtime() -> Result<Runtime, Failure> {
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(1).thread_name("out").enable_all().build();
    runtime.map_err(|error| Failure::Failed(format!("cannot start: {error}")))
}

fn folder(url: &str) -> Option<PathBuf> {
    match url.split_once("://") {
        None => Some(PathBuf::from(url)),
        Some(("file", path)) => Some(PathBuf::from(path)),
        Some(_) => None,
    }
}
