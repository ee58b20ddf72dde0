//! A task's film as bytes: float32, little endian, `[half][pixel][channel]`.

use super::task::AttemptId;
use super::{Result, WireError};
use crate::{limits, wire};
use bytes::Bytes;
use gonio_scene::film::TileFilm;
use std::time::Duration;

/// What a film of a task must look like; whoever handed out the task knows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FilmShape {
    /// Wanted pixels.
    pub pixels: usize,
    /// Channels of each half.
    pub channels: usize,
    /// Halves.
    pub halves: usize,
}

impl FilmShape {
    /// Numbers in the film.
    #[must_use]
    pub fn numbers(&self) -> usize {
        self.pixels * self.channels * self.halves
    }

    /// Bytes of the film.
    #[must_use]
    pub fn bytes(&self) -> usize {
        4 * self.numbers()
    }
}

/// Little-endian bytes of the numbers of all `runs`.
pub fn floats_to_wire<'v>(runs: impl IntoIterator<Item = &'v [f32], IntoIter: Clone>) -> Bytes {
    let runs = runs.into_iter();
    let mut bytes = vec![0; 4 * runs.clone().map(<[f32]>::len).sum::<usize>()];
    let mut rest = bytes.as_chunks_mut::<4>().0;
    for run in runs {
        let (place, after) = rest.split_at_mut(run.len());
        // Where bytes lie as they are sent, this is a plain copy.
        place.iter_mut().zip(run).for_each(|(bytes, value)| *bytes = value.to_le_bytes());
        rest = after;
    }
    bytes.into()
}

/// Copies numbers out of little-endian bytes, which need not be aligned, onto the end of `values`.
///
/// # Errors
/// A part of a number, or one that is not finite.
pub(super) fn append_floats(field: &str, bytes: &[u8], values: &mut Vec<f32>) -> Result<()> {
    let (numbers, rest) = bytes.as_chunks::<4>();
    if !rest.is_empty() {
        return Err(WireError::new(field, format!("has {} bytes, no multiple of 4", bytes.len())));
    }
    let start = values.len();
    values.extend(numbers.iter().map(|number| f32::from_le_bytes(*number)));
    let new = &values[start..];
    // Without a way out of the loop, so that it is a vector loop; which one it was matters to bad films only.
    if new.iter().fold(true, |finite, value| finite & value.is_finite()) {
        return Ok(());
    }
    let bad = new.iter().position(|value| !value.is_finite()).unwrap_or_default();
    Err(WireError::new(field, format!("has {} at number {bad}, must be finite", new[bad])))
}

/// The messages that return `film`: its chunks, then the commit.
pub fn film_to_wire(id: AttemptId, film: &TileFilm, render_time: Duration) -> impl Iterator<Item = wire::FromWorker> {
    use wire::from_worker::Message;
    let bytes = floats_to_wire([&*film.data]);
    let commit = wire::Commit {
        id: Some(id.into()),
        size_bytes: bytes.len() as u64,
        crc32: crc32fast::hash(&bytes),
        pixels: count(film.pixels),
        channels: count(film.channels),
        halves: count(film.halves),
        invalid_samples: film.invalid_samples,
        render_microseconds: u64::try_from(render_time.as_micros()).unwrap_or(u64::MAX),
    };
    let chunks = (0..bytes.len()).step_by(limits::CHUNK_BYTES).map(move |start| {
        let data = bytes.slice(start..bytes.len().min(start + limits::CHUNK_BYTES));
        Message::Chunk(wire::ResultChunk { id: Some(id.into()), offset_bytes: start as u64, data })
    });
    let messages = chunks.chain(std::iter::once(Message::Commit(commit)));
    messages.map(|message| wire::FromWorker { message: Some(message) })
}

fn count(n: usize) -> u32 {
    u32::try_from(n).unwrap_or(u32::MAX)
}

/// Collects an attempt's chunks, without copying them, until its commit.
#[derive(Debug)]
pub struct FilmAssembly {
    shape: FilmShape,
    chunks: Vec<Bytes>,
    bytes: usize,
}

impl FilmAssembly {
    /// An empty film of a known shape.
    #[must_use]
    pub fn new(shape: FilmShape) -> Self {
        Self { shape, chunks: Vec::new(), bytes: 0 }
    }

    /// Adds the next chunk.
    ///
    /// # Errors
    /// A chunk that is empty, too large, not the next, no whole number of floats, or beyond the film's end.
    pub fn add(&mut self, chunk: wire::ResultChunk) -> Result<()> {
        let length = chunk.data.len();
        if length == 0 || length > limits::CHUNK_BYTES || !length.is_multiple_of(4) {
            let problem = format!("has {length} bytes, must have a multiple of 4 up to {}", limits::CHUNK_BYTES);
            return Err(WireError::new("ResultChunk.data", problem));
        }
        if chunk.offset_bytes != self.bytes as u64 {
            let problem = format!("is {}, {} bytes have come", chunk.offset_bytes, self.bytes);
            return Err(WireError::new("ResultChunk.offset_bytes", problem));
        }
        if self.bytes + length > self.shape.bytes() {
            let problem = format!("goes beyond the film's {} bytes", self.shape.bytes());
            return Err(WireError::new("ResultChunk.data", problem));
        }
        self.bytes += length;
        self.chunks.push(chunk.data);
        Ok(())
    }

    /// The film that `commit` completes.
    ///
    /// # Errors
    /// Another shape than the task's, missing bytes, another checksum, a number that is not finite.
    pub fn finish(self, commit: &wire::Commit) -> Result<TileFilm> {
        let FilmShape { pixels, channels, halves } = self.shape;
        let announced = (commit.pixels as usize, commit.channels as usize, commit.halves as usize);
        if announced != (pixels, channels, halves) {
            let problem = format!("is {announced:?}, the task's is {:?}", (pixels, channels, halves));
            return Err(WireError::new("Commit shape (pixels, channels, halves)", problem));
        }
        if commit.size_bytes != self.bytes as u64 || self.bytes != self.shape.bytes() {
            let problem = format!("is {}, {} of {} bytes have come", commit.size_bytes, self.bytes, self.shape.bytes());
            return Err(WireError::new("Commit.size_bytes", problem));
        }
        let mut crc = crc32fast::Hasher::new();
        let mut data = Vec::with_capacity(self.shape.numbers());
        for chunk in &self.chunks {
            crc.update(chunk);
            append_floats("ResultChunk.data", chunk, &mut data)?;
        }
        let crc = crc.finalize();
        if crc != commit.crc32 {
            return Err(WireError::new("Commit.crc32", format!("is {:08x}, the film's is {crc:08x}", commit.crc32)));
        }
        Ok(TileFilm { pixels, channels, halves, data, invalid_samples: commit.invalid_samples })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wire::from_worker::Message;

    const ID: AttemptId = AttemptId { epoch: 1, evaluation: 2, task: 3, attempt: 0 };

    fn film(pixels: usize, channels: usize) -> TileFilm {
        let numbers = 2 * pixels * channels;
        let data = (0..numbers).map(|i| i as f32 * 0.25 - 1.0).collect();
        TileFilm { pixels, channels, halves: 2, data, invalid_samples: 5 }
    }

    fn messages(film: &TileFilm) -> (Vec<wire::ResultChunk>, wire::Commit) {
        let mut chunks = Vec::new();
        for message in film_to_wire(ID, film, Duration::from_millis(3)) {
            match message.message.unwrap() {
                Message::Chunk(chunk) => chunks.push(chunk),
                Message::Commit(commit) => return (chunks, commit),
                other => panic!("{other:?}"),
            }
        }
        panic!("no commit");
    }

    fn assemble(shape: FilmShape, chunks: Vec<wire::ResultChunk>, commit: &wire::Commit) -> Result<TileFilm> {
        let mut assembly = FilmAssembly::new(shape);
        for chunk in chunks {
            assembly.add(chunk)?;
        }
        assembly.finish(commit)
    }

    #[test]
    fn a_film_survives_its_chunks() {
        for (pixels, channels, expected) in [(1, 3, 1), (1024, 3 * 7, 1), (1024, 3 * 257, 7)] {
            let film = film(pixels, channels);
            let (chunks, commit) = messages(&film);
            assert_eq!(chunks.len(), expected);
            assert_eq!(assemble(FilmShape { pixels, channels, halves: 2 }, chunks, &commit).unwrap(), film);
        }
    }

    #[test]
    fn broken_results_are_refused() {
        let film = film(1000, 200);
        let shape = FilmShape { pixels: 1000, channels: 200, halves: 2 };
        type Change<'a> = &'a dyn Fn(&mut Vec<wire::ResultChunk>, &mut wire::Commit);
        let broken = |change: Change<'_>, expected: &str| {
            let (mut chunks, mut commit) = messages(&film);
            change(&mut chunks, &mut commit);
            let error = assemble(shape, chunks, &commit).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        };
        broken(&|c, _| c[0].data = Bytes::new(), "has 0 bytes");
        broken(&|c, _| c[0].data = Bytes::from_static(b"123"), "multiple of 4");
        broken(&|c, _| c[0].data = vec![0; limits::CHUNK_BYTES + 4].into(), "multiple of 4 up to");
        broken(&|c, _| c[0].offset_bytes = 4, "is 4, 0 bytes have come");
        broken(&|c, _| c[1].offset_bytes = u64::MAX, "bytes have come");
        broken(&|c, _| c.push(wire::ResultChunk { offset_bytes: 1_600_000, ..c[0].clone() }), "beyond the film's");
        broken(&|c, _| c.truncate(1), "of 1600000 bytes have come");
        broken(&|_, m| m.size_bytes = 3, "is 3, 1600000");
        broken(&|_, m| m.pixels = u32::MAX, "the task's is");
        broken(&|_, m| m.halves = 1, "the task's is");
        broken(&|_, m| m.crc32 ^= 1, "the film's is");
        let poisoned = |c: &mut Vec<wire::ResultChunk>, value: f32| {
            let mut bytes = c[0].data.to_vec();
            bytes[8..12].copy_from_slice(&value.to_le_bytes());
            c[0].data = bytes.into();
        };
        broken(&|c, _| poisoned(c, f32::NAN), "NaN at number 2");
        broken(&|c, _| poisoned(c, f32::NEG_INFINITY), "-inf at number 2");
        broken(&|c, _| poisoned(c, 7.0), "Commit.crc32");
    }
}
