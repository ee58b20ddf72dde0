//! A tile's film from the films of its sample chunks.

use gonio_scene::film::TileFilm;
use std::collections::BTreeMap;

/// A tile's film in double precision: the mean over all its samples, `[half][pixel][channel]`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MergedFilm {
    /// Wanted pixels.
    pub pixels: usize,
    /// Channels of each half.
    pub channels: usize,
    /// The numbers.
    pub data: Vec<f64>,
    /// Samples that were NaN or infinite.
    pub invalid_samples: u64,
}

impl MergedFilm {
    /// The channels of one pixel in one half.
    #[must_use]
    pub fn pixel(&self, half: usize, pixel: usize) -> &[f64] {
        let start = (half * self.pixels + pixel) * self.channels;
        &self.data[start..start + self.channels]
    }
}

/// Adds chunk films up in ascending order of chunk, whatever the order in which they come: floating-point addition is
/// not associative, and the sum's bits must not depend on who was fast. Only what comes early is kept.
#[derive(Debug, Default)]
pub struct ChunkMerge {
    /// Chunks added so far: the next one to be added.
    next: u32,
    /// Films that came before their turn, with their samples.
    waiting: BTreeMap<u32, (TileFilm, u32)>,
    /// Sum of sample mean times samples.
    sum: MergedFilm,
    samples: u64,
}

impl ChunkMerge {
    /// Takes the film of `chunk`, whose numbers are means of `samples` samples; all films have the same shape and
    /// every chunk comes once.
    pub fn add(&mut self, chunk: u32, film: TileFilm, samples: u32) {
        self.waiting.insert(chunk, (film, samples));
        while let Some((film, samples)) = self.waiting.remove(&self.next) {
            self.next += 1;
            self.samples += u64::from(samples);
            self.sum.invalid_samples += film.invalid_samples;
            let weighted = film.data.iter().map(|mean| f64::from(*mean) * f64::from(samples));
            if self.sum.data.is_empty() {
                (self.sum.pixels, self.sum.channels) = (film.pixels, film.channels);
                self.sum.data = weighted.collect();
            } else {
                self.sum.data.iter_mut().zip(weighted).for_each(|(sum, weighted)| *sum += weighted);
            }
        }
    }

    /// Number of chunks, from the first on, that have been added.
    #[must_use]
    pub fn merged(&self) -> u32 {
        self.next
    }

    /// The mean over the samples of all chunks added.
    #[must_use]
    pub fn finish(mut self) -> MergedFilm {
        #[allow(clippy::cast_precision_loss)]
        let samples = self.samples.max(1) as f64;
        self.sum.data.iter_mut().for_each(|sum| *sum /= samples);
        self.sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chunk(i: u32) -> TileFilm {
        // Magnitudes far apart, so that another order of addition shows in the last bits.
        let scale = [1e-4, 0.37, 11.0, 3.3e3, 9e5][i as usize];
        let data = (0..8_u8).map(|k| (0.1 + f32::from(k)) * scale).collect();
        TileFilm { pixels: 2, channels: 2, halves: 2, data, invalid_samples: u64::from(i) }
    }

    fn merged(order: &[u32]) -> MergedFilm {
        let mut merge = ChunkMerge::default();
        for i in order {
            merge.add(*i, chunk(*i), 10 + *i);
        }
        assert_eq!(merge.merged(), 5);
        merge.finish()
    }

    #[test]
    fn every_order_of_arrival_gives_the_same_bits() {
        let expected = merged(&[0, 1, 2, 3, 4]);
        for order in [[4, 3, 2, 1, 0], [2, 0, 4, 1, 3], [1, 0, 3, 2, 4]] {
            let found = merged(&order);
            let bits = |film: &MergedFilm| film.data.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&found), bits(&expected));
        }
        assert_eq!(expected.invalid_samples, 10);
        let mean = (0..5).map(|i| f64::from(chunk(i).data[3]) * f64::from(10 + i)).sum::<f64>() / 60.0;
        assert!((expected.pixel(0, 1)[1] - mean).abs() < 1e-12 * mean);
    }

    #[test]
    fn one_chunk_comes_back_unchanged() {
        let mut merge = ChunkMerge::default();
        merge.add(0, chunk(1), 37);
        let found: Vec<f32> = merge.finish().data.iter().map(|v| *v as f32).collect();
        assert_eq!(found, chunk(1).data);
    }
}
