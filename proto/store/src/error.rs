//! What goes wrong with a store.

use gonio_proto::Digest;
use tonic::Status;

/// Every error of [`crate::Blobs`].
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
    /// A file that stands for a blob cannot be read.
    #[error("{0}")]
    Lent(String),
    /// A file that stands for a blob has other bytes than when it was listed.
    #[error("a file of the capture, listed with the digest {0}, has changed since; try again when nobody writes to it")]
    Changed(Digest),
    /// The store cannot be listed, so nothing else can be expected of it.
    #[error("--store {url}: cannot be used: {error}; {mend}")]
    Unusable {
        /// As given.
        url: String,
        /// Why.
        error: object_store::Error,
        /// What to look at.
        mend: &'static str,
    },
    /// The store itself fails.
    #[error("the store fails: {0}")]
    Store(#[from] object_store::Error),
}

impl From<StoreError> for Status {
    fn from(error: StoreError) -> Self {
        let text = error.to_string();
        match error {
            StoreError::Missing(_) => Self::not_found(text),
            StoreError::TooLarge { .. } => Self::resource_exhausted(text),
            StoreError::Damaged(_) | StoreError::Changed(_) => Self::data_loss(text),
            StoreError::Lent(_) => Self::not_found(text),
            StoreError::Url { .. } | StoreError::Unusable { .. } | StoreError::Store(_) => Self::unavailable(text),
        }
    }
}
