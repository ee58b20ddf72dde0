//! The reduction of one evaluation: takes task films in any order, gives its statistics and films.

use super::measured::Measured;
use super::merge::{ChunkMerge, MergedFilm};
use super::recipe::Recipe;
use super::statistics::{Observed, compare};
use crate::split::{Part, Split};
use gonio_proto::convert::reduced::Reduced;
use gonio_scene::capture::Sensor;
use gonio_scene::film::TileFilm;
use gonio_scene::{Evaluation, Film, Output, PhotoStatistics};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// One of the request's photos.
#[derive(Debug, Clone)]
pub struct ReducedPhoto {
    /// Index in the capture.
    pub index: usize,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// How films become predictions.
    pub recipe: Recipe,
    /// How sure what was measured is.
    pub sensor: Sensor,
    /// What was measured, where it is compared with.
    pub photograph: Option<Arc<Measured>>,
    /// Largest measured value among the pixels that count.
    pub peak: f64,
}

/// Sums over tiles that are complete, in order of completion: for progress only, never for a result.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Running {
    /// Expectation of the loss under a right model.
    pub noise_floor: f64,
    /// See [`PhotoStatistics::loss`].
    pub loss: f64,
    /// Its variance that is due to the render.
    pub loss_variance: f64,
}

/// One tile: collecting, then reduced.
#[derive(Debug)]
enum TileState {
    Collecting(ChunkMerge),
    Reduced(Reduced),
}

/// What a film has completed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Added {
    /// Nothing: its tile waits for others.
    Film,
    /// Its tile, but not the evaluation.
    Tile,
    /// The evaluation.
    All,
}

/// All of an evaluation's films on their way to its answer.
#[derive(Debug)]
pub struct Reduction {
    output: Output,
    split: Arc<Split>,
    photos: Vec<ReducedPhoto>,
    /// One lock per tile, held by whoever adds a film to it.
    tiles: Vec<Mutex<TileState>>,
    /// Tiles that are still collecting; whoever brings it to zero ends the evaluation.
    collecting: AtomicUsize,
    running: Mutex<Running>,
}

impl Reduction {
    /// A reduction that waits for every task of `split`.
    #[must_use]
    pub fn new(output: Output, split: Arc<Split>, photos: Vec<ReducedPhoto>) -> Self {
        let tiles: Vec<_> =
            split.tiles.iter().map(|_| Mutex::new(TileState::Collecting(ChunkMerge::default()))).collect();
        let collecting = AtomicUsize::new(tiles.len());
        Self { output, split, photos, tiles, collecting, running: Mutex::default() }
    }

    /// Takes the film of one task, which comes once; reduces the tile when it is complete.
    pub fn add(&self, part: &Part, film: TileFilm) -> Added {
        let mut tile = self.tiles[part.tile].lock().unwrap_or_else(PoisonError::into_inner);
        let TileState::Collecting(merge) = &mut *tile else { return Added::Film };
        // First hits have no samples to weigh by.
        merge.add(part.chunk, film, (part.samples.len() as u32).max(1));
        if merge.merged() < self.split.chunks() {
            return Added::Film;
        }
        let film = std::mem::take(merge).finish();
        *tile = TileState::Reduced(self.reduce(part.tile, &film));
        drop(tile);
        if self.collecting.fetch_sub(1, Ordering::AcqRel) == 1 { Added::All } else { Added::Tile }
    }

    /// What a tile was reduced to, until the evaluation is finished.
    #[must_use]
    pub fn reduced(&self, tile: usize) -> Option<Reduced> {
        match &*self.tiles.get(tile)?.lock().unwrap_or_else(PoisonError::into_inner) {
            TileState::Reduced(reduced) => Some(reduced.clone()),
            TileState::Collecting(_) => None,
        }
    }

    /// Takes over a tile that was reduced before, before any film of it is added.
    ///
    /// # Errors
    /// It is not of this evaluation; the text says why.
    pub fn restore(&self, tile: usize, reduced: Reduced) -> Result<(), String> {
        let work = self.split.tiles.get(tile).ok_or_else(|| format!("there is no tile {tile}"))?;
        let photo = &self.photos[work.photo];
        let side = 1 + photo.recipe.columns;
        let statistics_fit = match &reduced.statistics {
            Some(statistics) => {
                photo.photograph.is_some()
                    && [&statistics.gram, &statistics.noise].iter().all(|m| m.len() == side * side)
                    && [0, side * side].contains(&statistics.draw.len())
            }
            None => photo.photograph.is_none(),
        };
        let numbers = work.count * self.image_channels();
        let film_fits = reduced.film.as_ref().map(Vec::len) == self.output.has_films().then_some(numbers);
        if !(statistics_fit && film_fits) {
            return Err(format!("tile {tile} has other sums or another film than this evaluation"));
        }
        if let Some(statistics) = &reduced.statistics {
            self.count(statistics);
        }
        let mut state = self.tiles[tile].lock().unwrap_or_else(PoisonError::into_inner);
        if matches!(&*state, TileState::Collecting(_)) {
            *state = TileState::Reduced(reduced);
            self.collecting.fetch_sub(1, Ordering::AcqRel);
        }
        Ok(())
    }

    /// Tiles that are still to be completed.
    #[must_use]
    pub fn collecting(&self) -> usize {
        self.collecting.load(Ordering::Acquire)
    }

    /// Adds a tile to the sums for progress.
    fn count(&self, statistics: &PhotoStatistics) {
        let mut running = self.running.lock().unwrap_or_else(PoisonError::into_inner);
        running.noise_floor += statistics.noise_floor;
        running.loss += statistics.loss();
        running.loss_variance += statistics.loss_variance();
    }

    fn reduce(&self, index: usize, film: &MergedFilm) -> Reduced {
        let work = &self.split.tiles[index];
        let photo = &self.photos[work.photo];
        let statistics = photo.photograph.as_deref().map(|photograph| {
            let observed = Observed { tile: work.tile, pixels: &work.pixels, photograph, sensor: &photo.sensor };
            let statistics = compare(film, observed, &photo.recipe, photo.peak);
            self.count(&statistics);
            statistics
        });
        Reduced {
            statistics,
            film: self.output.has_films().then(|| self.values(film, photo)),
            invalid_samples: film.invalid_samples,
        }
    }

    /// What an image of the tile shows, `[pixel][channel]`: exposed light (see [`gonio_scene::SensorStage`]), or first hits.
    fn values(&self, film: &MergedFilm, photo: &ReducedPhoto) -> Vec<f32> {
        #[allow(clippy::cast_possible_truncation)]
        let value = |pixel: usize, channel: usize| {
            if self.output == Output::FirstHit {
                return film.pixel(0, pixel)[channel] as f32;
            }
            let sum = film.pixel(0, pixel)[channel] + film.pixel(1, pixel)[channel];
            (0.5 * photo.recipe.factor * sum) as f32
        };
        (0..film.pixels).flat_map(|p| (0..self.image_channels()).map(move |c| value(p, c))).collect()
    }

    fn image_channels(&self) -> usize {
        if self.output == Output::FirstHit { gonio_scene::film::FIRST_HIT_CHANNELS.len() } else { 3 }
    }

    /// The sums over the tiles that are complete.
    #[must_use]
    pub fn running(&self) -> Running {
        *self.running.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The answer, once [`Reduction::add`] has said that all tiles are complete; `primary_samples` is left at 0.
    ///
    /// # Errors
    /// A statistic that overflowed; the text names photo and statistic.
    pub fn finish(&self) -> Result<Evaluation, String> {
        let mut evaluation = Evaluation::default();
        for photo in &self.photos {
            let side = 1 + photo.recipe.columns;
            if photo.photograph.is_some() {
                let zero = vec![0.0; side * side];
                evaluation.photos.push(PhotoStatistics {
                    photo: photo.index,
                    gram: zero.clone(),
                    noise: zero,
                    ..PhotoStatistics::default()
                });
            }
            if self.output.has_films() {
                let plane = vec![0.0; photo.width as usize * photo.height as usize];
                let channels = vec![plane; self.image_channels()];
                evaluation.films.push(Film { photo: photo.index, width: photo.width, height: photo.height, channels });
            }
        }
        for (work, state) in self.split.tiles.iter().zip(&self.tiles) {
            let mut state = state.lock().unwrap_or_else(PoisonError::into_inner);
            let TileState::Reduced(Reduced { statistics, film, invalid_samples }) = &mut *state else {
                return Err("a tile is missing".to_owned());
            };
            evaluation.invalid_samples += *invalid_samples;
            if let Some(statistics) = statistics {
                evaluation.photos[work.photo].add(statistics);
            }
            if let Some(values) = film.take() {
                let film = &mut evaluation.films[work.photo];
                let channels = film.channels.len();
                for (index, value) in work.pixels.indices().zip(values.chunks_exact(channels)) {
                    let (x, y) = (index % work.tile.width as usize, index / work.tile.width as usize);
                    let place = (work.tile.y as usize + y) * film.width as usize + work.tile.x as usize + x;
                    for (plane, value) in film.channels.iter_mut().zip(value) {
                        plane[place] = *value;
                    }
                }
            }
        }
        evaluation.photos.iter().try_for_each(check_finite)?;
        Ok(evaluation)
    }
}

fn check_finite(s: &PhotoStatistics) -> Result<(), String> {
    let sums = [s.noise_floor, s.render_noise, s.squared_error, s.log_variance, s.peak];
    if s.gram.iter().chain(&s.noise).chain(&s.draw).chain(&sums).all(|v| v.is_finite()) {
        return Ok(());
    }
    Err(format!(
        "the comparison of photo {} with its render overflows; lower the capture's radiances or exposures to the order of one",
        s.photo
    ))
}
