//! Where a worker fetches captures' files: a coordinator, a store, or a store with a coordinator behind it.

use bytes::Bytes;
use futures::FutureExt;
use futures::future::BoxFuture;
use gonio_proto::{Digest, limits};
use gonio_store::{Blobs, StoreError};

/// Gives blobs by digest.
pub trait BlobSource: Send + Sync {
    /// The blob with this digest, which has been verified; or why there is none, for people.
    fn get(&self, digest: Digest) -> BoxFuture<'_, Result<Bytes, String>>;
}

impl BlobSource for Blobs {
    fn get(&self, digest: Digest) -> BoxFuture<'_, Result<Bytes, String>> {
        async move { Self::get(self, digest, limits::BLOB_BYTES).await.map_err(|error| error.to_string()) }.boxed()
    }
}

/// A store, and whom to ask for what it does not have.
pub struct StoreFirst<S> {
    /// Asked first.
    pub store: Blobs,
    /// Asked where the store has no such blob, a damaged one, or fails.
    pub otherwise: S,
}

impl<S: BlobSource> BlobSource for StoreFirst<S> {
    fn get(&self, digest: Digest) -> BoxFuture<'_, Result<Bytes, String>> {
        async move {
            match self.store.get(digest, limits::BLOB_BYTES).await {
                Ok(blob) => {
                    tracing::debug!(%digest, "fetched from the store");
                    return Ok(blob);
                }
                Err(StoreError::Missing(_)) => tracing::debug!(%digest, "not in the store, asking the coordinator"),
                Err(error) => tracing::warn!(%digest, %error, "asking the coordinator instead"),
            }
            self.otherwise.get(digest).await
        }
        .boxed()
    }
}
