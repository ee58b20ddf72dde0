//! Where blobs lie: an object store, chosen by URL.
//!
//! Keys are made from digests alone, so no request can name an object outside `blob/sha256/`. A blob is written once and
//! never changed; whoever reads it verifies its digest.

use bytes::Bytes;
use gonio_proto::{Digest, limits};
use object_store::local::LocalFileSystem;
use object_store::memory::InMemory;
use object_store::path::Path;
use object_store::{ObjectStore, ObjectStoreExt, PutMode, PutOptions};
use std::sync::Arc;

/// What goes wrong with a store.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The URL is not one of a store that this program knows.
    #[error("--store {url}: {problem}; write a folder, memory:// or s3://BUCKET/PREFIX")]
    Url {
        /// As given.
        url: String,
        /// What is wrong with it.
        problem: String,
    },
    /// There is no such blob.
    #[error("there is no blob {0}; send it first")]
    Missing(Digest),
    /// A blob is larger than it may be.
    #[error("the blob has {size} bytes, the limit is {limit}")]
    TooLarge {
        /// Bytes.
        size: u64,
        /// Bytes.
        limit: u64,
    },
    /// A stored blob's bytes are not those that its key promises.
    #[error("the stored blob {0} is damaged; delete it from the store and send it again")]
    Damaged(Digest),
    /// The store itself fails.
    #[error("the store fails: {0}")]
    Store(#[from] object_store::Error),
}

/// Blobs by digest.
#[derive(Debug, Clone)]
pub struct Blobs {
    store: Arc<dyn ObjectStore>,
}

impl Blobs {
    /// The store at `url`: a folder (made where it is missing), `memory://`, or, in a build with the feature `s3`,
    /// `s3://BUCKET/PREFIX` with credentials from the environment.
    ///
    /// # Errors
    /// A URL of no known store, a folder that cannot be made.
    pub fn open(url: &str) -> Result<Self, StoreError> {
        let problem = |problem: String| StoreError::Url { url: url.to_owned(), problem };
        match url.split_once("://") {
            Some(("memory", _)) => Ok(Self::in_memory()),
            Some(("s3", _)) => open_s3(url).map_err(problem),
            Some(("file", folder)) => open_folder(folder).map_err(problem),
            Some((scheme, _)) => Err(problem(format!("is of an unknown kind, {scheme}"))),
            None => open_folder(url).map_err(problem),
        }
    }

    /// A store that ends with the process.
    #[must_use]
    pub fn in_memory() -> Self {
        Self { store: Arc::new(InMemory::new()) }
    }

    fn key(digest: Digest) -> Path {
        let hex = digest.to_string();
        // 256 folders: none grows too large for a file system to list.
        Path::from_iter(["blob", "sha256", &hex[..2], hex.as_str()])
    }

    /// Whether there is such a blob.
    ///
    /// # Errors
    /// The store fails.
    pub async fn has(&self, digest: Digest) -> Result<bool, StoreError> {
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
        let options = PutOptions::from(PutMode::Create);
        match self.store.put_opts(&Self::key(digest), blob.into(), options).await {
            Ok(_) => Ok(false),
            Err(object_store::Error::AlreadyExists { .. }) => Ok(true),
            Err(error) => Err(error.into()),
        }
    }

    /// A blob, of at most `limit` bytes; its digest is verified.
    ///
    /// # Errors
    /// There is no such blob, it is too large or damaged, or the store fails.
    pub async fn get(&self, digest: Digest, limit: u64) -> Result<Bytes, StoreError> {
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

fn open_folder(folder: &str) -> Result<Blobs, String> {
    if folder.is_empty() {
        return Err("names no folder".to_owned());
    }
    std::fs::create_dir_all(folder).map_err(|error| format!("cannot be made: {error}"))?;
    let store = LocalFileSystem::new_with_prefix(folder).map_err(|error| error.to_string())?;
    Ok(Blobs { store: Arc::new(store) })
}

#[cfg(feature = "s3")]
fn open_s3(url: &str) -> Result<Blobs, String> {
    let parsed = url::Url::parse(url).map_err(|error| error.to_string())?;
    // Fails only where another provider is installed already, which then serves as well.
    let _ = rustls::crypto::ring::default_provider().install_default();
    let bucket = format!("s3://{}", parsed.host_str().unwrap_or_default());
    let store = object_store::aws::AmazonS3Builder::from_env().with_url(bucket).build();
    let store = store.map_err(|error| error.to_string())?;
    let prefix = Path::from_url_path(parsed.path()).map_err(|error| error.to_string())?;
    Ok(Blobs { store: Arc::new(object_store::prefix::PrefixStore::new(store, prefix)) })
}

#[cfg(not(feature = "s3"))]
fn open_s3(_: &str) -> Result<Blobs, String> {
    Err("needs a build with `--features s3`".to_owned())
}
