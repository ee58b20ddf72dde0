//! Where files come from: the store where it has them, the coordinator for everything else.

#![allow(clippy::unwrap_used)] // Its helpers may do what its tests may.

use bytes::Bytes;
use futures::FutureExt;
use futures::future::BoxFuture;
use gonio_proto::Digest;
use gonio_store::Blobs;
use gonio_worker::BlobSource;
use gonio_worker::source::StoreFirst;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A coordinator that has one blob, and counts who asks.
#[derive(Default)]
struct Coordinator {
    asked: AtomicUsize,
}

const ITS_BLOB: &[u8] = b"what the coordinator has";

impl BlobSource for Coordinator {
    fn get(&self, digest: Digest) -> BoxFuture<'_, Result<Bytes, String>> {
        self.asked.fetch_add(1, Ordering::Relaxed);
        let found = (digest == Digest::of(ITS_BLOB)).then(|| Bytes::from_static(ITS_BLOB));
        async move { found.ok_or_else(|| "the coordinator has no such blob".to_owned()) }.boxed()
    }
}

#[tokio::test]
async fn the_coordinator_is_asked_only_for_what_the_store_cannot_give() {
    let folder = tempfile::tempdir().unwrap();
    let store = Blobs::open(folder.path().to_str().unwrap()).unwrap();
    let source = StoreFirst { store: store.clone(), otherwise: Coordinator::default() };
    let asked = || source.otherwise.asked.load(Ordering::Relaxed);
    let (stored, theirs) = (Bytes::from_static(b"stored"), Digest::of(ITS_BLOB));

    store.put(Digest::of(&stored), stored.clone()).await.unwrap();
    assert_eq!((source.get(Digest::of(&stored)).await, asked()), (Ok(stored), 0));
    // Missing, then damaged: the store's bytes are not those of the key.
    assert_eq!((source.get(theirs).await.as_deref(), asked()), (Ok(ITS_BLOB), 1));
    store.put(theirs, Bytes::from_static(b"damaged")).await.unwrap();
    assert_eq!((source.get(theirs).await.as_deref(), asked()), (Ok(ITS_BLOB), 2));
    // A store that fails.
    drop(folder);
    assert_eq!((source.get(theirs).await.as_deref(), asked()), (Ok(ITS_BLOB), 3));
    // Neither has it: the coordinator's reason is told.
    let nobodys = source.get(Digest::of(b"nobody's")).await;
    assert_eq!(nobodys, Err("the coordinator has no such blob".to_owned()));
}
