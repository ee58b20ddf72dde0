//! Named objects: what a command writes for people and other programs, where blobs are for the farm.

use crate::StoreError;
use bytes::Bytes;
use futures::TryStreamExt;
use object_store::path::Path;
use object_store::{ObjectStore, ObjectStoreExt};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Objects by path below one folder or prefix.
#[derive(Debug, Clone)]
pub struct Objects {
    store: Arc<dyn ObjectStore>,
}

impl Objects {
    /// The objects below `url`: a folder (made where it is missing) or, in a build with the feature `s3`,
    /// `s3://BUCKET/PREFIX` with credentials from the environment.
    ///
    /// # Errors
    /// A text that says what is wrong with the URL.
    pub fn open(url: &str) -> Result<Self, String> {
        match url.split_once("://") {
            Some(("memory", _)) => Err("would end with this process; write a folder or s3://BUCKET/PREFIX".to_owned()),
            _ => Ok(Self { store: crate::open(url)? }),
        }
    }

    /// Writes an object, over one that is there; nobody reads half of it.
    ///
    /// # Errors
    /// The store fails.
    pub async fn put(&self, path: &str, bytes: Bytes) -> Result<(), StoreError> {
        self.store.put(&Path::from(path), bytes.into()).await?;
        Ok(())
    }

    /// An object; `None` where there is none.
    ///
    /// # Errors
    /// The store fails.
    pub async fn get(&self, path: &str) -> Result<Option<Bytes>, StoreError> {
        match self.store.get(&Path::from(path)).await {
            Ok(found) => Ok(Some(found.bytes().await?)),
            Err(object_store::Error::NotFound { .. }) => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    /// Path and size in bytes of every object below the folder `path`.
    ///
    /// # Errors
    /// The store fails.
    pub async fn list(&self, path: &str) -> Result<BTreeMap<String, u64>, StoreError> {
        let listed = self.store.list(Some(&Path::from(path)));
        Ok(listed.map_ok(|object| (object.location.to_string(), object.size)).try_collect().await?)
    }
}
