//! How an evaluation is cut into tasks: a pure function of the request and its capture, never of who will render it.

use crate::aggregate::Measured;
use gonio_proto::convert::film::FilmShape;
use gonio_proto::limits;
use gonio_scene::Output;
use gonio_scene::film::{FIRST_HIT_CHANNELS, LARGEST_TILE, PixelSet, TILE, Tile};
use std::ops::Range;

/// Most samples of each half in one task.
pub const CHUNK_SAMPLES: u32 = 64;

/// Most tiles of an evaluation; each costs the coordinator some hundred bytes.
const MOST_TILES: usize = 1 << 22;

/// Most bytes of films that an evaluation returns, all of which the coordinator holds until the end.
const MOST_FILM_BYTES: u64 = 4 << 30;

/// A tile of one of the request's photos, and its pixels that are rendered.
#[derive(Debug, Clone)]
pub struct TileWork {
    /// Index among the request's photos.
    pub photo: usize,
    /// Where it lies.
    pub tile: Tile,
    /// Never empty.
    pub pixels: PixelSet,
    /// Number of pixels in `pixels`, which is asked for more often than it should be counted.
    pub count: usize,
}

/// A photo to be split.
#[derive(Debug, Clone, Copy)]
pub struct PhotoArea<'a> {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Given where pixels that do not count need not be rendered.
    pub counted: Option<&'a Measured>,
}

/// One task of a split.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// Index of the tile in [`Split::tiles`].
    pub tile: usize,
    /// Index of the chunk of samples.
    pub chunk: u32,
    /// Samples of each half; empty for first hits.
    pub samples: Range<u32>,
    /// How many of them, from the first on, finite differences take; 0: all.
    pub difference_samples: u32,
    /// The same of derivatives that are carried along the paths.
    pub forward_samples: u32,
}

/// The tasks of an evaluation: every tile of every photo, and for each tile its chunks of samples, in this order.
#[derive(Debug)]
pub struct Split {
    /// Photo by photo in the request's order, row by row.
    pub tiles: Vec<TileWork>,
    /// Samples of each half; zero for first hits.
    samples: u32,
    /// Of these, those of finite differences; 0: all.
    difference_samples: u32,
    /// The same of derivatives that are carried along the paths.
    forward_samples: u32,
    channels: usize,
}

impl Split {
    /// Splits an evaluation of `samples` (both halves together) with `planes` derivative images.
    ///
    /// # Errors
    /// More than a coordinator can hold; the text says what to ask for instead.
    pub fn new(photos: &[PhotoArea<'_>], samples: u32, output: Output, planes: usize) -> Result<Self, String> {
        let first_hits = output == Output::FirstHit;
        let channels = if first_hits { FIRST_HIT_CHANNELS.len() } else { 3 * (1 + planes) };
        if output.has_films() {
            let per_pixel = 4 * if first_hits { channels as u64 } else { 3 };
            let bytes: u64 = photos.iter().map(|p| u64::from(p.width) * u64::from(p.height) * per_pixel).sum();
            if bytes > MOST_FILM_BYTES {
                let text = format!(
                    "the films have {bytes} bytes, the limit is {MOST_FILM_BYTES}; ask for fewer photos at a time"
                );
                return Err(text);
            }
        }
        let cover = |p: &PhotoArea<'_>| p.width.div_ceil(TILE) as usize * p.height.div_ceil(TILE) as usize;
        let most: usize = photos.iter().map(cover).sum();
        if most > MOST_TILES {
            return Err(format!("there are {most} tiles, the limit is {MOST_TILES}; ask for fewer photos at a time"));
        }
        let mut tiles = Vec::new();
        let full = PixelSet::from_flags([true; (TILE * TILE) as usize]);
        for (photo, area) in photos.iter().enumerate() {
            if let Some(drawn @ Measured::Drawn(_)) = area.counted {
                for tile in Tile::cover_by(LARGEST_TILE, area.width, area.height) {
                    part(drawn, photo, tile, &mut tiles);
                }
                continue;
            }
            for tile in Tile::cover(area.width, area.height) {
                let pixels = match area.counted {
                    Some(measured) => measured.pixels(tile),
                    None if tile.len() == (TILE * TILE) as usize => full.clone(),
                    None => PixelSet::from_flags(std::iter::repeat_n(true, tile.len())),
                };
                let count = pixels.count();
                if count > 0 {
                    tiles.push(TileWork { photo, tile, pixels, count });
                }
            }
        }
        let samples = if first_hits { 0 } else { samples / 2 };
        let split = Self { tiles, samples, difference_samples: 0, forward_samples: 0, channels };
        if split.tasks() > limits::TASKS {
            let text = format!(
                "there are {} tasks, the limit is {}; ask for fewer samples or photos",
                split.tasks(),
                limits::TASKS
            );
            return Err(text);
        }
        Ok(split)
    }

    /// The same split with only `differences` samples (both halves together) of finite differences, and `forward` of
    /// derivatives that are carried along the paths; 0: all.
    ///
    /// Chunks are merged by their samples, so each gives derivatives its share, rounded up: none goes without.
    #[must_use]
    pub fn with_derivative_samples(self, differences: u32, forward: u32) -> Self {
        let half = |samples: u32| samples.div_ceil(2).min(self.samples);
        Self { difference_samples: half(differences), forward_samples: half(forward), ..self }
    }

    /// Chunks of samples of every tile.
    #[must_use]
    pub fn chunks(&self) -> u32 {
        self.samples.div_ceil(CHUNK_SAMPLES).max(1)
    }

    /// Number of tasks.
    #[must_use]
    pub fn tasks(&self) -> u64 {
        self.tiles.len() as u64 * u64::from(self.chunks())
    }

    /// The task with index `task`, if there is one.
    #[must_use]
    pub fn part(&self, task: u64) -> Option<Part> {
        let chunks = u64::from(self.chunks());
        let tile = usize::try_from(task / chunks).ok().filter(|tile| *tile < self.tiles.len())?;
        let chunk = (task % chunks) as u32;
        let start = chunk * CHUNK_SAMPLES;
        let samples = start..self.samples.min(start + CHUNK_SAMPLES);
        let (here, all) = (samples.len() as u64, u64::from(self.samples.max(1)));
        let share = |of: u32| (u64::from(of) * here).div_ceil(all) as u32;
        let (difference_samples, forward_samples) = (share(self.difference_samples), share(self.forward_samples));
        Some(Part { tile, chunk, samples, difference_samples, forward_samples })
    }

    /// The tasks of a tile.
    pub fn tasks_of(&self, tile: usize) -> impl Iterator<Item = (u64, Part)> {
        let chunks = u64::from(self.chunks());
        let first = tile as u64 * chunks;
        (first..first + chunks).filter_map(|task| Some((task, self.part(task)?)))
    }

    /// What the film of a task of `tile` looks like.
    #[must_use]
    pub fn shape(&self, tile: usize) -> FilmShape {
        let halves = if self.samples == 0 { 1 } else { 2 };
        FilmShape { pixels: self.tiles[tile].count, channels: self.channels, halves }
    }

    /// Camera samples of one task: both halves of every pixel, or one ray per pixel for first hits.
    #[must_use]
    pub fn camera_samples(&self, part: &Part) -> u64 {
        let per_pixel = if self.samples == 0 { 1 } else { 2 * part.samples.len() as u64 };
        self.tiles[part.tile].count as u64 * per_pixel
    }
}

/// Splits a tile of a photo of which few pixels are drawn, until no part has more of them than a tile of [`TILE`] pixels a side may
/// have: a task for every few pixels would cost more than its paths.
fn part(drawn: &Measured, photo: usize, tile: Tile, tiles: &mut Vec<TileWork>) {
    let pixels = drawn.pixels(tile);
    let count = pixels.count();
    if count == 0 {
        return;
    }
    if count <= (TILE * TILE) as usize {
        tiles.push(TileWork { photo, tile, pixels, count });
        return;
    }
    let side = (tile.width.max(tile.height) / 2).next_multiple_of(TILE);
    for Tile { x, y, width, height } in Tile::cover_by(side, tile.width, tile.height) {
        part(drawn, photo, Tile { x: tile.x + x, y: tile.y + y, width, height }, tiles);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aggregate::measured::Drawn;
    use gonio_scene::design::Rates;
    use gonio_scene::image::Image;
    use gonio_scene::{Photograph, Values};

    fn area(width: u32, height: u32) -> PhotoArea<'static> {
        PhotoArea { width, height, counted: None }
    }

    #[test]
    fn every_sample_of_every_pixel_is_in_one_task() {
        let split = Split::new(&[area(70, 33), area(10, 10)], 260, Output::Films, 2).unwrap();
        assert_eq!((split.tiles.len(), split.chunks(), split.tasks()), (7, 3, 21));
        let mut samples = 0;
        for task in 0..split.tasks() {
            let part = split.part(task).unwrap();
            assert_eq!(part.samples.start, part.chunk * CHUNK_SAMPLES);
            samples += split.camera_samples(&part);
        }
        assert_eq!(samples, 260 * (70 * 33 + 100));
        assert_eq!(split.part(20).unwrap().samples, 128..130);
        assert_eq!(split.part(21), None);
        assert_eq!(split.shape(0), FilmShape { pixels: 1024, channels: 9, halves: 2 });
    }

    #[test]
    fn every_chunk_gives_derivatives_their_share_rounded_up() {
        let split = |of: u32| Split::new(&[area(8, 8)], 260, Output::Films, 1).unwrap().with_derivative_samples(of, of);
        let shares = |of: u32| {
            let parts = (0..3).map(|task| split(of).part(task).unwrap());
            parts
                .map(|part| {
                    assert_eq!(part.forward_samples, part.difference_samples);
                    part.difference_samples
                })
                .collect::<Vec<_>>()
        };
        assert_eq!(shares(0), [0, 0, 0]);
        assert_eq!(shares(260), [64, 64, 2]);
        assert_eq!(shares(65), [17, 17, 1]);
        assert_eq!(shares(2), [1, 1, 1]);
    }

    #[test]
    fn only_pixels_that_count_are_rendered_for_statistics() {
        let mut counts = vec![false; 64 * 40];
        counts[33 * 64 + 40] = true;
        let image = Image { width: 64, height: 40, pixels: vec![[0.0; 3]; 64 * 40] };
        let measured = Measured::All(Photograph::new(image, counts, 0));
        let area = PhotoArea { width: 64, height: 40, counted: Some(&measured) };
        let split = Split::new(&[area], 2, Output::Statistics, 0).unwrap();
        assert_eq!(split.tiles.len(), 1);
        assert_eq!(split.tiles[0].tile, Tile { x: 32, y: 32, width: 32, height: 8 });
        assert_eq!(split.tiles[0].pixels.indices().collect::<Vec<_>>(), [32 + 8]);
    }

    #[test]
    fn few_pixels_make_few_tasks_and_no_task_has_many() {
        let (width, height) = (1500, 1100);
        let pixels = vec![[0.0; 3]; (width * height) as usize];
        let counts = vec![true; pixels.len()];
        let values = Values { image: Image { width, height, pixels }, counts, clipped: 0 };
        // A sixteenth of the left half, a thousandth of the right.
        let rates = Rates { cell: 750, columns: 2, codes: vec![32, 80, 32, 80] };
        let draw = rates.draw(5, 0);
        let measured = Measured::Drawn(Drawn::new(&values, draw));
        let area = PhotoArea { width, height, counted: Some(&measured) };
        let split = Split::new(&[area], 4, Output::Statistics, 0).unwrap();
        let mut wanted = Vec::new();
        for work in &split.tiles {
            assert!(work.count <= 1024 && work.count == work.pixels.count());
            let place = |i: usize| (work.tile.y + i as u32 / work.tile.width, work.tile.x + i as u32 % work.tile.width);
            wanted.extend(work.pixels.indices().map(place));
        }
        wanted.sort_unstable();
        let drawn: Vec<_> = (0..height)
            .flat_map(|y| (0..width).map(move |x| (y, x)))
            .filter(|(y, x)| draw.code(*x, *y).is_some())
            .collect();
        assert_eq!(wanted, drawn);
        assert!(split.tiles.len() < 200, "{}", split.tiles.len());
    }

    #[test]
    fn first_hits_have_one_task_per_tile() {
        let split = Split::new(&[area(64, 32)], 1000, Output::FirstHit, 0).unwrap();
        assert_eq!(split.tasks(), 2);
        let part = split.part(1).unwrap();
        assert_eq!((part.samples.clone(), split.camera_samples(&part)), (0..0, 1024));
        assert_eq!(split.shape(1), FilmShape { pixels: 1024, channels: 10, halves: 1 });
    }

    #[test]
    fn what_no_coordinator_can_hold_is_refused() {
        let many = vec![area(16384, 16384); 100];
        assert!(Split::new(&many, 2, Output::Films, 0).unwrap_err().contains("fewer photos"));
        assert!(Split::new(&many, 2, Output::Statistics, 0).unwrap_err().contains("the limit is 4194304"));
        assert!(Split::new(&[area(1024, 1024)], 10_000_000, Output::Statistics, 0).unwrap_err().contains("tasks"));
    }
}
