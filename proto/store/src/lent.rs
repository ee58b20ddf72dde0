//! Blobs that lie elsewhere: files of this process's user, which are read when they are asked for and never copied.

use bytes::Bytes;
use gonio_proto::Digest;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Reads a whole blob, or says why not.
type Read = Arc<dyn Fn() -> Result<Bytes, String> + Send + Sync>;

/// Where blobs lie that are not in the store. Clones share it.
#[derive(Clone, Default)]
pub(crate) struct Lent(Arc<Mutex<HashMap<Digest, (u64, Read)>>>);

impl Lent {
    pub fn add(&self, digest: Digest, size: u64, read: Read) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(digest, (size, read));
    }

    /// The size of a blob in bytes, and how to read it.
    pub fn find(&self, digest: Digest) -> Option<(u64, Read)> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get(&digest).cloned()
    }
}

impl std::fmt::Debug for Lent {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let count = self.0.lock().unwrap_or_else(PoisonError::into_inner).len();
        write!(f, "Lent({count})")
    }
}
