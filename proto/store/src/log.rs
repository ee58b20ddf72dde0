//! Numbered objects, each written by whoever comes first.

use crate::{Blobs, StoreError};
use bytes::Bytes;
use futures::TryStreamExt;
use object_store::path::Path;
use object_store::{ObjectStore, ObjectStoreExt, PutMode, PutOptions};
use std::sync::Arc;

/// A log in a store: objects by number, and one mark that is written over.
#[derive(Debug, Clone)]
pub struct Log {
    store: Arc<dyn ObjectStore>,
    folder: &'static str,
}

impl Blobs {
    /// The log `folder` beside the blobs.
    #[must_use]
    pub fn log(&self, folder: &'static str) -> Log {
        Log { store: Arc::clone(&self.store), folder }
    }
}

impl Log {
    fn key(&self, number: u64) -> Path {
        // As many digits as the largest number has: the order of names is that of numbers.
        Path::from_iter([self.folder, "segments", &format!("{number:020}")])
    }

    fn mark(&self) -> Path {
        Path::from_iter([self.folder, "owner"])
    }

    /// The numbers that are there, ascending.
    ///
    /// # Errors
    /// The store fails.
    pub async fn numbers(&self) -> Result<Vec<u64>, StoreError> {
        let listed = self.store.list(Some(&Path::from_iter([self.folder, "segments"])));
        let names = listed.map_ok(|object| object.location.filename().unwrap_or_default().to_owned());
        let names: Vec<String> = names.try_collect().await?;
        let mut numbers: Vec<u64> = names.iter().filter_map(|name| name.parse().ok()).collect();
        numbers.sort_unstable();
        Ok(numbers)
    }

    /// An object of at most `limit` bytes; `None` where there is none.
    ///
    /// # Errors
    /// It is too large, or the store fails.
    pub async fn get(&self, number: u64, limit: u64) -> Result<Option<Bytes>, StoreError> {
        self.read(&self.key(number), limit).await
    }

    async fn read(&self, path: &Path, limit: u64) -> Result<Option<Bytes>, StoreError> {
        match self.store.get(path).await {
            Ok(found) if found.meta.size > limit => Err(StoreError::TooLarge { size: found.meta.size, limit }),
            Ok(found) => Ok(Some(found.bytes().await?)),
            Err(object_store::Error::NotFound { .. }) => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    /// Writes an object where there is none. `false`: there is one, of other bytes.
    ///
    /// # Errors
    /// The store fails; whether the object was written is then unknown, and the same call may be made again.
    pub async fn put_new(&self, number: u64, bytes: Bytes) -> Result<bool, StoreError> {
        let key = self.key(number);
        match self.store.put_opts(&key, bytes.clone().into(), PutOptions::from(PutMode::Create)).await {
            Ok(_) => Ok(true),
            // An earlier try of ours may have been this one's, though it was told of a failure.
            Err(object_store::Error::AlreadyExists { .. }) => {
                Ok(self.read(&key, bytes.len() as u64).await.is_ok_and(|found| found == Some(bytes)))
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Deletes an object; one that is not there is no error.
    ///
    /// # Errors
    /// The store fails.
    pub async fn delete(&self, number: u64) -> Result<(), StoreError> {
        match self.store.delete(&self.key(number)).await {
            Ok(()) | Err(object_store::Error::NotFound { .. }) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    /// The mark's bytes; `None` where it was never written.
    ///
    /// # Errors
    /// It is longer than a kilobyte, or the store fails.
    pub async fn get_mark(&self) -> Result<Option<Bytes>, StoreError> {
        self.read(&self.mark(), 1024).await
    }

    /// Writes the mark, over what is there.
    ///
    /// # Errors
    /// The store fails.
    pub async fn put_mark(&self, bytes: Bytes) -> Result<(), StoreError> {
        self.store.put(&self.mark(), bytes.into()).await?;
        Ok(())
    }
}
