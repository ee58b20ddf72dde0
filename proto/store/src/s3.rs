//! Buckets of S3, and of what speaks its protocol.

use object_store::ObjectStore;
#[cfg(feature = "s3")]
use object_store::{RetryConfig, aws::AmazonS3Builder, path::Path, prefix::PrefixStore};
use std::sync::Arc;
#[cfg(feature = "s3")]
use std::time::Duration;

/// How long a call that fails is tried again: shorter than whoever waits for it loses its patience.
#[cfg(feature = "s3")]
const RETRY: Duration = Duration::from_secs(20);

#[cfg(feature = "s3")]
pub(crate) fn open(url: &str) -> Result<Arc<dyn ObjectStore>, String> {
    let parsed = url::Url::parse(url).map_err(|error| error.to_string())?;
    let bucket = parsed.host_str().filter(|bucket| !bucket.is_empty()).ok_or("names no bucket")?;
    // Fails only where another provider is installed already, which then serves as well.
    let _ = rustls::crypto::ring::default_provider().install_default();
    let retry = RetryConfig { max_retries: 4, retry_timeout: RETRY, ..RetryConfig::default() };
    let store = AmazonS3Builder::from_env().with_bucket_name(bucket).with_retry(retry).build();
    let store = store.map_err(|error| error.to_string())?;
    let prefix = Path::from_url_path(parsed.path()).map_err(|error| error.to_string())?;
    Ok(Arc::new(PrefixStore::new(store, prefix)))
}

#[cfg(not(feature = "s3"))]
pub(crate) fn open(_: &str) -> Result<Arc<dyn ObjectStore>, String> {
    Err("needs a build with `--features gonio-coordinator/s3,gonio-worker/s3,gonio/s3`".to_owned())
}
