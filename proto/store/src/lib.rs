//! Where blobs lie: an object store, chosen by URL. The coordinator writes it; workers that can reach it read it too.
//!
//! Keys are made from digests alone, so no request can name an object outside `blob/sha256/`. A blob is written once and
//! never changed; whoever reads it verifies its digest.

mod error;
mod lent;
mod log;
mod objects;
mod s3;

pub use error::StoreError;
pub use log::Log;
pub use objects::Objects;

use bytes::Bytes;
use futures::StreamExt;
use gonio_proto::{Digest, limits};
use lent::Lent;
use object_store::local::LocalFileSystem;
use object_store::memory::InMemory;
use object_store::path::Path;
use object_store::{ObjectStore, ObjectStoreExt, PutMode, PutOptions};
use std::sync::Arc;

/// Blobs by digest.
#[derive(Debug, Clone)]
pub struct Blobs {
    /// As given, for errors.
    url: Arc<str>,
    store: Arc<dyn ObjectStore>,
    /// What is not in the store and can be read all the same.
    lent: Lent,
}

impl Blobs {
    /// The store at `url`: a folder (made where it is missing), `memory://`, or, in a build with the feature `s3`,
    /// `s3://BUCKET/PREFIX` with credentials from the environment.
    ///
    /// # Errors
    /// A URL of no known store, a folder that cannot be made.
    pub fn open(url: &str) -> Result<Self, StoreError> {
        let store = open(url).map_err(|problem| StoreError::Url { url: url.to_owned(), problem })?;
        Ok(Self::over(url, store))
    }

    /// A store that ends with the process.
    #[must_use]
    pub fn in_memory() -> Self {
        Self::over("memory://", Arc::new(InMemory::new()))
    }

    /// A store that somebody else has opened; `url` is what errors call it.
    #[must_use]
    pub fn over(url: &str, store: Arc<dyn ObjectStore>) -> Self {
        Self { url: url.into(), store, lent: Lent::default() }
    }

    /// Asks the store for something, so that a bucket, an address or credentials that are wrong are found out at the start.
    ///
    /// # Errors
    /// The store does not answer, or refuses.
    pub async fn probe(&self) -> Result<(), StoreError> {
        let Some(Err(error)) = self.store.list(None).next().await else { return Ok(()) };
        let mend = match self.url.split_once("://") {
            Some(("s3", _)) => "check that the bucket exists, and AWS_ENDPOINT_URL, AWS_REGION and the credentials",
            _ => "check that it can be read and written",
        };
        Err(StoreError::Unusable { url: self.url.to_string(), error, mend })
    }

    fn key(digest: Digest) -> Path {
        let hex = digest.to_string();
        // 256 folders: none grows too large for a file system to list.
        Path::from_iter(["blob", "sha256", &hex[..2], hex.as_str()])
    }

    /// Makes a blob known that lies elsewhere in reach of this process, such as a photograph's file: it is read whenever it is asked
    /// for, and never stored. `read` may block, and says what is wrong in words that name the file.
    pub fn lend(&self, digest: Digest, size: u64, read: impl Fn() -> Result<Bytes, String> + Send + Sync + 'static) {
        self.lent.add(digest, size, Arc::new(read));
    }

    /// Whether there is such a blob.
    ///
    /// # Errors
    /// The store fails.
    pub async fn has(&self, digest: Digest) -> Result<bool, StoreError> {
        if self.lent.find(digest).is_some() {
            return Ok(true);
        }
        match self.store.head(&Self::key(digest)).await {
            Ok(_) => Ok(true),
            Err(object_store::Error::NotFound { .. }) => Ok(false),
            Err(error) => Err(error.into()),
        }
    }

    /// Stores a blob under the digest of its bytes, which the caller has computed. Returns whether it was there already.
    ///
    /// # Errors
    /// The blob is too large, or the store fails.
    pub async fn put(&self, digest: Digest, blob: Bytes) -> Result<bool, StoreError> {
        let size = blob.len() as u64;
        if size > limits::BLOB_BYTES {
            return Err(StoreError::TooLarge { size, limit: limits::BLOB_BYTES });
        }
        let key = Self::key(digest);
        match self.store.put_opts(&key, blob.clone().into(), PutOptions::from(PutMode::Create)).await {
            Ok(_) => Ok(false),
            Err(object_store::Error::AlreadyExists { .. }) => Ok(true),
            // Without conditional writes, the worst is to write the same bytes twice.
            Err(object_store::Error::NotImplemented { .. }) => {
                let existed = self.has(digest).await?;
                if !existed {
                    self.store.put(&key, blob.into()).await?;
                }
                Ok(existed)
            }
            Err(error) => Err(error.into()),
        }
    }

    /// A blob, of at most `limit` bytes; its digest is verified.
    ///
    /// # Errors
    /// There is no such blob, it is too large or damaged, or the store fails.
    pub async fn get(&self, digest: Digest, limit: u64) -> Result<Bytes, StoreError> {
        if let Some((size, read)) = self.lent.find(digest) {
            if size > limit {
                return Err(StoreError::TooLarge { size, limit });
            }
            let verified = move || {
                let blob = read().map_err(StoreError::Lent)?;
                if Digest::of(&blob) == digest { Ok(blob) } else { Err(StoreError::Changed(digest)) }
            };
            return tokio::task::spawn_blocking(verified).await.map_err(|error| StoreError::Lent(error.to_string()))?;
        }
        let found = match self.store.get(&Self::key(digest)).await {
            Ok(found) => found,
            Err(object_store::Error::NotFound { .. }) => return Err(StoreError::Missing(digest)),
            Err(error) => return Err(error.into()),
        };
        if found.meta.size > limit {
            return Err(StoreError::TooLarge { size: found.meta.size, limit });
        }
        let blob = found.bytes().await?;
        // Hashing a large file takes a while.
        let verified = tokio::task::spawn_blocking(move || (Digest::of(&blob) == digest).then_some(blob)).await;
        verified.ok().flatten().ok_or(StoreError::Damaged(digest))
    }
}

/// The store at a URL, or what is wrong with the URL.
fn open(url: &str) -> Result<Arc<dyn ObjectStore>, String> {
    match url.split_once("://") {
        Some(("memory", _)) => Ok(Arc::new(InMemory::new())),
        Some(("s3", _)) => s3::open(url),
        Some(("file", folder)) => open_folder(folder),
        Some((scheme, _)) => Err(format!("is of an unknown kind, {scheme}")),
        None => open_folder(url),
    }
}

fn open_folder(folder: &str) -> Result<Arc<dyn ObjectStore>, String> {
    if folder.is_empty() {
        return Err("names no folder".to_owned());
    }
    std::fs::create_dir_all(folder).map_err(|error| format!("cannot be made: {error}"))?;
    let store = LocalFileSystem::new_with_prefix(folder).map_err(|error| error.to_string())?;
    Ok(Arc::new(store))
}
