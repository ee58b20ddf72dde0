//! An object store that fails: slowly, at once, or after it has done what was asked.

use crate::Random;
use async_trait::async_trait;
use futures::stream::BoxStream;
use futures::{StreamExt, TryStreamExt};
use object_store::memory::InMemory;
use object_store::path::Path;
use object_store::{
    CopyOptions, Error, GetOptions, GetResult, ListResult, MultipartUpload, ObjectMeta, ObjectStore,
    PutMultipartOptions, PutOptions, PutPayload, PutResult, Result,
};
use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// What befalls one coordinator's calls.
pub struct Faults {
    random: Mutex<Random>,
    dead: AtomicBool,
}

impl Faults {
    pub fn new(seed: u64, life: u64) -> Self {
        Self { random: Mutex::new(Random::of(seed, 1000 + life)), dead: AtomicBool::new(false) }
    }

    /// From now on nothing reaches the store.
    pub fn die(&self) {
        self.dead.store(true, Ordering::Relaxed);
    }

    /// It was only cut off.
    pub fn revive(&self) {
        self.dead.store(false, Ordering::Relaxed);
    }

    fn chance(&self, thousandths: u64) -> bool {
        self.random.lock().unwrap().chance(thousandths)
    }

    /// The way to the store, and back.
    async fn travel(&self) {
        let milliseconds = {
            let mut random = self.random.lock().unwrap();
            if random.chance(20) { random.below(3000) } else { random.below(30) }
        };
        tokio::time::sleep(Duration::from_millis(milliseconds)).await;
        while self.dead.load(Ordering::Relaxed) {
            tokio::time::sleep(Duration::from_millis(500)).await;
        }
    }

    fn refuse(&self, thousandths: u64, when: &str) -> Result<()> {
        if self.chance(thousandths) {
            return Err(Error::Generic { store: "simulated", source: when.into() });
        }
        Ok(())
    }
}

/// One coordinator's view of a store.
pub struct FaultyStore {
    pub inner: Arc<InMemory>,
    pub faults: Arc<Faults>,
}

impl fmt::Debug for FaultyStore {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("FaultyStore")
    }
}

impl fmt::Display for FaultyStore {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a simulated store")
    }
}

#[async_trait]
impl ObjectStore for FaultyStore {
    async fn put_opts(&self, location: &Path, payload: PutPayload, options: PutOptions) -> Result<PutResult> {
        self.faults.travel().await;
        self.faults.refuse(40, "before it was written")?;
        let done = self.inner.put_opts(location, payload, options).await;
        self.faults.travel().await;
        self.faults.refuse(40, "after it was written")?;
        done
    }

    async fn put_multipart_opts(
        &self,
        location: &Path,
        options: PutMultipartOptions,
    ) -> Result<Box<dyn MultipartUpload>> {
        self.inner.put_multipart_opts(location, options).await
    }

    async fn get_opts(&self, location: &Path, options: GetOptions) -> Result<GetResult> {
        self.faults.travel().await;
        self.faults.refuse(10, "a read")?;
        self.inner.get_opts(location, options).await
    }

    fn delete_stream(&self, locations: BoxStream<'static, Result<Path>>) -> BoxStream<'static, Result<Path>> {
        let faults = self.faults.clone();
        let allowed = locations.and_then(move |path| {
            let faults = faults.clone();
            async move {
                faults.travel().await;
                faults.refuse(40, "a deletion")?;
                Ok(path)
            }
        });
        self.inner.delete_stream(allowed.boxed())
    }

    fn list(&self, prefix: Option<&Path>) -> BoxStream<'static, Result<ObjectMeta>> {
        let (faults, listed) = (self.faults.clone(), self.inner.list(prefix));
        let begin = futures::stream::once(async move {
            faults.travel().await;
            faults.refuse(10, "a list")
        });
        begin
            .flat_map(|begun| match begun {
                Ok(()) => futures::stream::empty().boxed(),
                Err(error) => futures::stream::iter([Err(error)]).boxed(),
            })
            .chain(listed)
            .boxed()
    }

    async fn list_with_delimiter(&self, prefix: Option<&Path>) -> Result<ListResult> {
        self.faults.travel().await;
        self.inner.list_with_delimiter(prefix).await
    }

    async fn copy_opts(&self, from: &Path, to: &Path, options: CopyOptions) -> Result<()> {
        self.inner.copy_opts(from, to, options).await
    }
}
