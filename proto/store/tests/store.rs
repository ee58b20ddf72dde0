//! One suite that every store passes: a folder, memory, and S3 by way of the same `object_store` trait.

#![allow(clippy::unwrap_used)] // Its helpers may do what its tests may.

use bytes::Bytes;
use gonio_proto::Digest;
use gonio_store::{Blobs, Objects, StoreError};

async fn conforms(blobs: &Blobs) {
    for content in [Bytes::new(), Bytes::from_static(b"a blob"), Bytes::from(vec![7; 3 << 20])] {
        let digest = Digest::of(&content);
        assert!(!blobs.has(digest).await.unwrap());
        assert!(matches!(blobs.get(digest, u64::MAX).await, Err(StoreError::Missing(d)) if d == digest));
        assert!(!blobs.put(digest, content.clone()).await.unwrap(), "it was not there");
        assert!(blobs.put(digest, content.clone()).await.unwrap(), "it was there");
        assert!(blobs.has(digest).await.unwrap());
        assert_eq!(blobs.get(digest, content.len() as u64).await.unwrap(), content);
        if let Some(less) = (content.len() as u64).checked_sub(1) {
            assert!(matches!(blobs.get(digest, less).await, Err(StoreError::TooLarge { .. })));
        }
    }
    // A blob under a digest that is not its own is found out when it is read.
    let wrong = Digest::of(b"something else");
    blobs.put(wrong, Bytes::from_static(b"not that")).await.unwrap();
    assert!(matches!(blobs.get(wrong, 100).await, Err(StoreError::Damaged(d)) if d == wrong));
}

#[tokio::test]
async fn memory_conforms() {
    conforms(&Blobs::open("memory://").unwrap()).await;
}

#[tokio::test]
async fn a_folder_conforms_and_keeps_its_blobs() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path().join("made/where/missing");
    let url = root.to_str().unwrap();
    conforms(&Blobs::open(url).unwrap()).await;
    let digest = Digest::of(b"a blob");
    let reopened = Blobs::open(&format!("file://{url}")).unwrap();
    assert_eq!(&reopened.get(digest, 100).await.unwrap()[..], b"a blob");
    let hex = digest.to_string();
    reopened.probe().await.unwrap();
    assert!(root.join("blob/sha256").join(&hex[..2]).join(&hex).is_file());
}

#[tokio::test]
async fn many_writers_of_one_blob_agree() {
    let folder = tempfile::tempdir().unwrap();
    let blobs = Blobs::open(folder.path().to_str().unwrap()).unwrap();
    let content = Bytes::from(vec![3; 1 << 20]);
    let digest = Digest::of(&content);
    let writers = (0..16).map(|_| {
        let (blobs, content) = (blobs.clone(), content.clone());
        tokio::spawn(async move { blobs.put(digest, content).await.unwrap() })
    });
    let mut existed = 0;
    for writer in writers.collect::<Vec<_>>() {
        existed += usize::from(writer.await.unwrap());
    }
    assert_eq!(existed, 15);
    assert_eq!(blobs.get(digest, u64::MAX).await.unwrap(), content);
}

#[test]
fn urls_of_no_store_are_refused() {
    for (url, expected) in
        [("ftp://host/x", "unknown kind, ftp"), ("", "names no folder"), ("/dev/null/x", "cannot be made")]
    {
        let error = Blobs::open(url).unwrap_err().to_string();
        assert!(error.contains(expected) && error.contains("s3://BUCKET/PREFIX"), "{error}");
    }
    #[cfg(not(feature = "s3"))]
    assert!(Blobs::open("s3://bucket/prefix").unwrap_err().to_string().contains("--features gonio-coordinator/s3"));
}

#[tokio::test]
async fn objects_have_names_and_are_replaced_whole() {
    let folder = tempfile::tempdir().unwrap();
    let objects = Objects::open(folder.path().join("out").to_str().unwrap()).unwrap();
    assert!(objects.list("frames").await.unwrap().is_empty());
    for (path, content) in [("frames/ab/1.exr", "one"), ("frames/cd/2.exr", "three"), ("table.csv", "t")] {
        objects.put(path, Bytes::from_static(content.as_bytes())).await.unwrap();
    }
    objects.put("table.csv", Bytes::from_static(b"another")).await.unwrap();
    assert_eq!(objects.get("table.csv").await.unwrap().unwrap(), "another");
    assert_eq!(objects.get("absent").await.unwrap(), None);
    let listed = objects.list("frames").await.unwrap();
    assert_eq!(
        listed.into_iter().collect::<Vec<_>>(),
        [("frames/ab/1.exr".to_owned(), 3), ("frames/cd/2.exr".to_owned(), 5)]
    );
    // What a program that was killed leaves is no object.
    assert_eq!(std::fs::read_dir(folder.path().join("out")).unwrap().count(), 2);
    assert!(Objects::open("memory://").unwrap_err().contains("end with this process"));
}
