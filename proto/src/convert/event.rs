//! What streams back to a client.

use super::film::append_floats;
use super::{Result, WireError, finite, finite_and_not_negative, required, text};
use crate::{limits, wire};
use bytes::Bytes;
use gonio_scene::film::FIRST_HIT_CHANNELS;
use gonio_scene::{Film, MAX_SIDE, PhotoStatistics, Progress};
use wire::evaluation_event::Event as Message;

/// The text of [`Event::Failed`] where somebody has cancelled the evaluation.
pub const CANCELLED: &str = "it was cancelled by somebody";

/// One event of an evaluation, in domain types.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// The coordinator has the request and calls it by this number in its logs.
    Accepted(u64),
    /// How far it is.
    Progress(Progress),
    /// One photo's comparison.
    Statistics(PhotoStatistics),
    /// A part of a photo's film, for [`FilmCollector`].
    Film(wire::FilmChunk),
    /// The end.
    Finished {
        /// Camera samples traced.
        primary_samples: u64,
        /// Samples among them that were NaN or infinite.
        invalid_samples: u64,
    },
    /// The end, without an answer.
    Failed {
        /// Whether another try would fail alike.
        request_at_fault: bool,
        /// What is wrong and how to mend it.
        text: String,
    },
}

impl From<Event> for wire::EvaluationEvent {
    fn from(event: Event) -> Self {
        let event = match event {
            Event::Accepted(evaluation) => Message::Accepted(wire::Accepted { evaluation }),
            Event::Progress(p) => Message::Progress(progress_to_wire(p)),
            Event::Statistics(s) => Message::Statistics(statistics_to_wire(s)),
            Event::Film(chunk) => Message::Film(chunk),
            Event::Finished { primary_samples, invalid_samples } => {
                Message::Finished(wire::Finished { primary_samples, invalid_samples })
            }
            Event::Failed { request_at_fault, text: reason } => {
                let fault = if request_at_fault { wire::failed::Fault::Request } else { wire::failed::Fault::Farm };
                Message::Failed(wire::Failed { fault: fault.into(), text: text(&reason) })
            }
        };
        Self { event: Some(event) }
    }
}

impl TryFrom<wire::EvaluationEvent> for Event {
    type Error = WireError;

    fn try_from(event: wire::EvaluationEvent) -> Result<Self> {
        Ok(match required("EvaluationEvent.event", event.event)? {
            Message::Accepted(accepted) => Self::Accepted(accepted.evaluation),
            Message::Progress(p) => Self::Progress(progress(&p)?),
            Message::Statistics(s) => Self::Statistics(statistics(s)?),
            Message::Film(chunk) => Self::Film(chunk),
            Message::Finished(wire::Finished { primary_samples, invalid_samples }) => {
                Self::Finished { primary_samples, invalid_samples }
            }
            Message::Failed(failed) => Self::Failed {
                request_at_fault: failed.fault() == wire::failed::Fault::Request,
                text: text(&failed.text),
            },
        })
    }
}

pub(super) fn progress_to_wire(p: Progress) -> wire::Progress {
    wire::Progress {
        tasks_done: p.tasks_done,
        tasks: p.tasks,
        primary_samples: p.primary_samples,
        loss: p.loss,
        loss_standard_error: p.loss_standard_error,
        workers: p.workers,
    }
}

pub(super) fn progress(p: &wire::Progress) -> Result<Progress> {
    Ok(Progress {
        tasks_done: p.tasks_done,
        tasks: p.tasks,
        primary_samples: p.primary_samples,
        loss: finite("Progress.loss", p.loss)?,
        loss_standard_error: finite_and_not_negative("Progress.loss_standard_error", p.loss_standard_error)?,
        workers: p.workers,
    })
}

pub(super) fn statistics_to_wire(s: PhotoStatistics) -> wire::PhotoStatistics {
    wire::PhotoStatistics {
        photo: u32::try_from(s.photo).unwrap_or(u32::MAX),
        observations: s.observations,
        compared: s.compared,
        gram: s.gram,
        noise: s.noise,
        draw: s.draw,
        noise_floor: s.noise_floor,
        render_noise: s.render_noise,
        squared_error: s.squared_error,
        log_variance: s.log_variance,
        peak: s.peak,
        invalid_samples: s.invalid_samples,
    }
}

pub(super) fn statistics(s: wire::PhotoStatistics) -> Result<PhotoStatistics> {
    let side = s.gram.len().isqrt();
    if side * side != s.gram.len() || side == 0 || side > limits::COLUMNS + 1 {
        let problem = format!("has {} numbers, must have (1 + columns)^2", s.gram.len());
        return Err(WireError::new("PhotoStatistics.gram", problem));
    }
    if s.noise.len() != s.gram.len() {
        let problem = format!("has {} numbers, must have {} as the Gram matrix", s.noise.len(), s.gram.len());
        return Err(WireError::new("PhotoStatistics.noise", problem));
    }
    for value in &s.gram {
        finite("PhotoStatistics.gram", *value)?;
    }
    for value in &s.noise {
        finite("PhotoStatistics.noise", *value)?;
    }
    if !s.draw.is_empty() && s.draw.len() != s.gram.len() {
        let problem = format!("has {} numbers, must have {} as the Gram matrix, or none", s.draw.len(), s.gram.len());
        return Err(WireError::new("PhotoStatistics.draw", problem));
    }
    for value in &s.draw {
        finite("PhotoStatistics.draw", *value)?;
    }
    Ok(PhotoStatistics {
        photo: s.photo as usize,
        observations: s.observations,
        compared: s.compared,
        gram: s.gram,
        noise: s.noise,
        draw: s.draw,
        noise_floor: finite_and_not_negative("PhotoStatistics.noise_floor", s.noise_floor)?,
        render_noise: finite_and_not_negative("PhotoStatistics.render_noise", s.render_noise)?,
        squared_error: finite("PhotoStatistics.squared_error", s.squared_error)?,
        log_variance: finite("PhotoStatistics.log_variance", s.log_variance)?,
        peak: finite("PhotoStatistics.peak", s.peak)?,
        invalid_samples: s.invalid_samples,
    })
}

/// The events that carry `film`.
pub fn film_chunks(film: &Film) -> impl Iterator<Item = Event> + use<> {
    let header = wire::FilmChunk {
        photo: u32::try_from(film.photo).unwrap_or(u32::MAX),
        width_pixels: film.width,
        height_pixels: film.height,
        channels: u32::try_from(film.channels.len()).unwrap_or(u32::MAX),
        offset_bytes: 0,
        data: Bytes::new(),
    };
    let bytes = super::film::floats_to_wire(film.channels.iter().map(Vec::as_slice));
    (0..bytes.len()).step_by(limits::CHUNK_BYTES).map(move |start| {
        let data = bytes.slice(start..bytes.len().min(start + limits::CHUNK_BYTES));
        Event::Film(wire::FilmChunk { offset_bytes: start as u64, data, ..header.clone() })
    })
}

/// Puts films together again from their chunks.
#[derive(Debug, Default)]
pub struct FilmCollector {
    /// The films that are complete, in the order in which they came.
    pub films: Vec<Film>,
    open: Option<(wire::FilmChunk, Vec<f32>)>,
}

impl FilmCollector {
    /// Adds the next chunk.
    ///
    /// # Errors
    /// An impossible size, a chunk that is too large or not the next, a number that is not finite.
    pub fn add(&mut self, mut chunk: wire::FilmChunk) -> Result<()> {
        let data = std::mem::take(&mut chunk.data);
        let offset = std::mem::take(&mut chunk.offset_bytes);
        let (header, mut values) = match self.open.take() {
            Some(open) => open,
            None => {
                let side = |length: u32| (1..=MAX_SIDE).contains(&length);
                let known = [3, FIRST_HIT_CHANNELS.len()].contains(&(chunk.channels as usize));
                if !(side(chunk.width_pixels) && side(chunk.height_pixels) && known) {
                    let size = (chunk.width_pixels, chunk.height_pixels, chunk.channels);
                    return Err(WireError::new("FilmChunk size (width, height, channels)", format!("is {size:?}")));
                }
                (chunk.clone(), Vec::new())
            }
        };
        if chunk != header || offset != 4 * values.len() as u64 {
            return Err(WireError::new("FilmChunk", "does not continue the film before it"));
        }
        if data.is_empty() || data.len() > limits::CHUNK_BYTES {
            return Err(WireError::new("FilmChunk.data", format!("has {} bytes", data.len())));
        }
        append_floats("FilmChunk.data", &data, &mut values)?;
        let plane = header.width_pixels as usize * header.height_pixels as usize;
        let numbers = plane * header.channels as usize;
        if values.len() > numbers {
            return Err(WireError::new("FilmChunk.data", "goes beyond the film's end"));
        }
        if values.len() == numbers {
            self.films.push(Film {
                photo: header.photo as usize,
                width: header.width_pixels,
                height: header.height_pixels,
                channels: values.chunks_exact(plane).map(<[f32]>::to_vec).collect(),
            });
        } else {
            self.open = Some((header, values));
        }
        Ok(())
    }

    /// The films.
    ///
    /// # Errors
    /// The last one is not complete.
    pub fn finish(self) -> Result<Vec<Film>> {
        match self.open {
            Some((header, _)) => Err(WireError::new("FilmChunk", format!("the film of photo {} is cut", header.photo))),
            None => Ok(self.films),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn film(photo: usize, width: u32, height: u32) -> Film {
        let plane = |c: u32| (0..width * height).map(|i| (i + c) as f32).collect();
        Film { photo, width, height, channels: (0..3).map(plane).collect() }
    }

    fn chunks(film: &Film) -> Vec<wire::FilmChunk> {
        let chunk = |event| match event {
            Event::Film(chunk) => chunk,
            other => panic!("{other:?}"),
        };
        film_chunks(film).map(chunk).collect()
    }

    #[test]
    fn films_survive_their_chunks() {
        let films = [film(4, 500, 300), film(2, 3, 1)];
        let mut collector = FilmCollector::default();
        for chunk in films.iter().flat_map(chunks) {
            collector.add(chunk).unwrap();
        }
        assert_eq!(collector.finish().unwrap(), films);
    }

    #[test]
    fn broken_films_are_refused() {
        let broken = |change: &dyn Fn(&mut Vec<wire::FilmChunk>), expected: &str| {
            let mut all = chunks(&film(0, 500, 300));
            change(&mut all);
            let mut collector = FilmCollector::default();
            let error =
                all.into_iter().try_for_each(|c| collector.add(c)).and_then(|()| collector.finish().map(|_| ()));
            let error = error.unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        };
        broken(&|c| c[0].width_pixels = u32::MAX, "FilmChunk size");
        broken(&|c| c[0].height_pixels = 0, "FilmChunk size");
        broken(&|c| c[0].channels = 4, "FilmChunk size");
        broken(&|c| c[1].photo = 1, "does not continue");
        broken(&|c| c[1].offset_bytes = 0, "does not continue");
        broken(&|c| c[1].data = Bytes::from_static(b"12345"), "multiple of 4");
        broken(&|c| c.truncate(1), "is cut");
        broken(&|c| c.iter_mut().for_each(|c| c.height_pixels = 200), "beyond the film's end");
    }

    #[test]
    fn broken_events_are_refused() {
        let good = wire::PhotoStatistics { gram: vec![1.0; 9], noise: vec![1.0; 9], ..Default::default() };
        let broken = |change: &dyn Fn(&mut wire::PhotoStatistics), expected: &str| {
            let mut s = good.clone();
            change(&mut s);
            let event = wire::EvaluationEvent { event: Some(Message::Statistics(s)) };
            let error = Event::try_from(event).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        };
        broken(&|s| s.gram.truncate(8), "has 8 numbers");
        broken(&|s| s.gram.clear(), "has 0 numbers");
        broken(&|s| s.gram = vec![0.0; 300 * 300], "has 90000 numbers");
        broken(&|s| s.gram[3] = f64::NAN, "gram: is NaN");
        broken(&|s| s.noise.truncate(4), "has 4 numbers");
        broken(&|s| s.noise[1] = f64::NAN, "noise: is NaN");
        broken(&|s| s.noise_floor = -1.0, "must not be negative");
        broken(&|s| s.render_noise = f64::INFINITY, "must be finite");
        assert!(Event::try_from(wire::EvaluationEvent { event: None }).is_err());
    }

    #[test]
    fn events_survive_the_wire() {
        let progress =
            Progress { tasks_done: 1, tasks: 2, primary_samples: 3, loss: -0.5, loss_standard_error: 0.25, workers: 4 };
        let statistics = PhotoStatistics {
            photo: 7,
            gram: vec![2.0],
            noise: vec![0.5],
            observations: 9,
            peak: 3.0,
            ..Default::default()
        };
        for event in [
            Event::Accepted(3),
            Event::Progress(progress),
            Event::Statistics(statistics),
            Event::Finished { primary_samples: 8, invalid_samples: 2 },
            Event::Failed { request_at_fault: true, text: "photos/00.exr: is missing".into() },
        ] {
            assert_eq!(Event::try_from(wire::EvaluationEvent::from(event.clone())).unwrap(), event);
        }
    }
}
