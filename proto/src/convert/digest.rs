//! The name of a blob: its SHA-256.

use super::{Result, WireError, at_most};
use crate::{limits, wire};
use bytes::Bytes;
use sha2::{Digest as _, Sha256};

/// SHA-256 of a blob's bytes.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Digest([u8; 32]);

impl Digest {
    /// The digest of `bytes`.
    #[must_use]
    pub fn of(bytes: &[u8]) -> Self {
        Self(Sha256::digest(bytes).into())
    }

    /// A digest from a message's field.
    ///
    /// # Errors
    /// Other than 32 bytes.
    pub fn from_wire(field: &str, bytes: &[u8]) -> Result<Self> {
        let digest = bytes.try_into();
        digest.map(Self).map_err(|_| WireError::new(field, format!("has {} bytes, a digest has 32", bytes.len())))
    }

    /// The bytes for a message's field.
    #[must_use]
    pub fn to_wire(&self) -> Bytes {
        Bytes::copy_from_slice(&self.0)
    }
}

impl std::fmt::Display for Digest {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl std::fmt::Debug for Digest {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{self}")
    }
}

/// The digests of a message.
///
/// # Errors
/// More than [`limits::DIGESTS`], or one that is none.
pub fn digests_from_wire(message: &wire::BlobDigests) -> Result<Vec<Digest>> {
    at_most("BlobDigests.digests", message.digests.len(), limits::DIGESTS)?;
    message.digests.iter().map(|d| Digest::from_wire("BlobDigests.digests", d)).collect()
}

/// The message for `digests`.
#[must_use]
pub fn digests_to_wire(digests: &[Digest]) -> wire::BlobDigests {
    wire::BlobDigests { digests: digests.iter().map(Digest::to_wire).collect() }
}

/// A blob as a stream of messages, the first with digest and size; nothing is copied.
pub fn blob_chunks(digest: Digest, blob: Bytes) -> impl Iterator<Item = wire::BlobChunk> + Send {
    let starts = (0..blob.len().max(1)).step_by(limits::CHUNK_BYTES);
    starts.map(move |start| {
        let data = blob.slice(start..blob.len().min(start + limits::CHUNK_BYTES));
        if start == 0 {
            wire::BlobChunk { digest: digest.to_wire(), size_bytes: blob.len() as u64, data }
        } else {
            wire::BlobChunk { data, ..Default::default() }
        }
    })
}

/// Puts a blob together again from its chunks.
#[derive(Debug, Default)]
pub struct BlobAssembly {
    expected: Option<(Digest, u64)>,
    bytes: Vec<u8>,
}

impl BlobAssembly {
    /// Adds the next chunk.
    ///
    /// # Errors
    /// The first chunk names no digest or too large a size, a chunk is too large or empty, or there are more bytes than
    /// announced.
    pub fn add(&mut self, chunk: &wire::BlobChunk) -> Result<()> {
        let (_, size) = match self.expected {
            Some(expected) => expected,
            None => {
                let digest = Digest::from_wire("BlobChunk.digest", &chunk.digest)?;
                if chunk.size_bytes > limits::BLOB_BYTES {
                    let problem = format!("is {}, the limit is {}", chunk.size_bytes, limits::BLOB_BYTES);
                    return Err(WireError::new("BlobChunk.size_bytes", problem));
                }
                *self.expected.insert((digest, chunk.size_bytes))
            }
        };
        let length = chunk.data.len();
        if length > limits::CHUNK_BYTES || (length == 0 && size > 0) {
            let problem = format!("has {length} bytes, must have 1 to {}", limits::CHUNK_BYTES);
            return Err(WireError::new("BlobChunk.data", problem));
        }
        if (self.bytes.len() + length) as u64 > size {
            return Err(WireError::new("BlobChunk.data", format!("goes beyond the {size} bytes announced")));
        }
        // Memory grows with what arrives, not with what was announced.
        self.bytes.extend_from_slice(&chunk.data);
        Ok(())
    }

    /// The digest announced by the first chunk.
    #[must_use]
    pub fn announced(&self) -> Option<Digest> {
        self.expected.map(|(digest, _)| digest)
    }

    /// The blob.
    ///
    /// # Errors
    /// No chunk came, bytes are missing, or their digest is another.
    pub fn finish(self) -> Result<(Digest, Bytes)> {
        let Some((digest, size)) = self.expected else {
            return Err(WireError::new("BlobChunk", "never came"));
        };
        if self.bytes.len() as u64 != size {
            let problem = format!("ended after {} of {size} bytes", self.bytes.len());
            return Err(WireError::new("BlobChunk.data", problem));
        }
        let found = Digest::of(&self.bytes);
        if found != digest {
            let problem = format!("has the digest {found}, announced was {digest}");
            return Err(WireError::new("BlobChunk.data", problem));
        }
        Ok((digest, self.bytes.into()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assemble(chunks: impl IntoIterator<Item = wire::BlobChunk>) -> Result<(Digest, Bytes)> {
        let mut assembly = BlobAssembly::default();
        for chunk in chunks {
            assembly.add(&chunk)?;
        }
        assembly.finish()
    }

    fn chunked(length: usize) -> (Bytes, Vec<wire::BlobChunk>) {
        let blob: Bytes = (0..length).map(|i| (i % 251) as u8).collect();
        (blob.clone(), blob_chunks(Digest::of(&blob), blob).collect())
    }

    #[test]
    fn a_blob_survives_its_chunks() {
        for length in [0, 1, limits::CHUNK_BYTES, limits::CHUNK_BYTES + 1, 3 * limits::CHUNK_BYTES] {
            let (blob, chunks) = chunked(length);
            assert_eq!(chunks.len(), length.div_ceil(limits::CHUNK_BYTES).max(1));
            assert_eq!(assemble(chunks).unwrap().1, blob);
        }
    }

    #[test]
    fn broken_blobs_are_refused() {
        let (_, good) = chunked(limits::CHUNK_BYTES + 10);
        let broken = |change: &dyn Fn(&mut Vec<wire::BlobChunk>), expected: &str| {
            let mut chunks = good.clone();
            change(&mut chunks);
            let error = assemble(chunks).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        };
        broken(&|c| c.clear(), "never came");
        broken(&|c| c[0].digest = Bytes::new(), "a digest has 32");
        broken(&|c| c[0].digest = Bytes::from_static(&[7; 33]), "a digest has 32");
        broken(&|c| c[0].size_bytes = u64::MAX, "the limit is");
        broken(&|c| c[0].size_bytes = 5, "goes beyond the 5 bytes");
        broken(&|c| c.truncate(1), "ended after");
        broken(&|c| c[1].data = Bytes::new(), "must have 1 to");
        broken(&|c| c[0].data = vec![0; limits::CHUNK_BYTES + 1].into(), "must have 1 to");
        broken(&|c| c[1].data = Bytes::from_static(b"0123456789"), "has the digest");
        broken(&|c| c.swap(0, 1), "a digest has 32");
    }
}
