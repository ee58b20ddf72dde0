//! Photos beside their renders at the values that a fit has reached, while it goes on.
//!
//! They are rendered one at a time, of the newest values, and only while somebody looks, with pauses of [`REST`] times as long
//! as it takes: so the fit, whose numbers do not depend on it, loses little time by it. Held-out photos stay closed.

use super::Watch;
use super::board::Board;
use crate::farm::OpenCapture;
use crate::input::Input;
use crate::report::Panel;
use gonio_fit::{Evaluate, FitEvent};
use gonio_page::Viewers;
use gonio_scene::capture::Role;
use gonio_scene::{EvaluationRequest, Output, Photograph};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Samples per pixel: enough to see what differs.
const SAMPLES: u32 = 16;

/// How much longer than rendering a picture takes is waited before the next.
const REST: u32 = 3;

/// How often the thread looks whether there is something to do.
const PAUSE: Duration = Duration::from_millis(100);

/// Where a fit stands.
#[derive(Debug, Clone, PartialEq)]
struct Position {
    iteration: u32,
    /// Values of the free parameters, in their order.
    values: Vec<f64>,
}

#[derive(Default)]
struct Shared {
    position: Mutex<Option<Position>>,
    stop: AtomicBool,
}

/// The thread that renders for the page; ended and waited for when this is dropped.
pub struct Live {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

struct Painter {
    shared: Arc<Shared>,
    board: Arc<Board>,
    viewers: Viewers,
    input: Input,
    farm: OpenCapture,
}

impl Live {
    /// Begins to render for `watch`, where there is a page, photos of `input` that are fitted to.
    pub fn start(watch: &Watch, input: &Input, farm: &OpenCapture) -> Self {
        let shared = Arc::new(Shared::default());
        let thread = watch.0.as_ref().and_then(|open| {
            let painter = Painter {
                shared: Arc::clone(&shared),
                board: Arc::clone(&open.board),
                viewers: open.viewers.clone(),
                input: input.clone(),
                farm: farm.clone(),
            };
            // Without a thread there are no pictures before the end, and all else.
            std::thread::Builder::new().name("pictures".to_owned()).spawn(move || painter.run()).ok()
        });
        Self { shared, thread }
    }

    /// Notes where the fit stands.
    pub fn note(&self, event: &FitEvent) {
        let position = match event {
            FitEvent::Started { start, .. } => Position { iteration: 0, values: start.clone() },
            FitEvent::IterationDone(i) if i.accepted => {
                Position { iteration: i.iteration, values: i.parameters.clone() }
            }
            _ => return,
        };
        *self.shared.position.lock().unwrap_or_else(PoisonError::into_inner) = Some(position);
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // A panic there was told on standard error; the fit is as good without its pictures.
            let _ = thread.join();
        }
    }
}

impl Painter {
    fn run(mut self) {
        let photos: Vec<usize> = (0..self.input.capture.photos.len())
            .filter(|photo| self.input.capture.photos[*photo].role == Role::Fit)
            .collect();
        // Of each photo, at which position it was rendered last.
        let mut shown: Vec<Option<Position>> = vec![None; photos.len()];
        while !self.is_stopped() {
            let position = self.shared.position.lock().unwrap_or_else(PoisonError::into_inner).clone();
            let old = |at: &Option<Position>| position.is_some() && *at != position;
            // The one whose picture is oldest.
            let next = (0..photos.len())
                .filter(|i| old(&shown[*i]))
                .min_by_key(|i| shown[*i].as_ref().map(|position| position.iteration));
            match (next, position) {
                (Some(i), Some(position)) if self.viewers.count() > 0 => {
                    let begin = Instant::now();
                    // Where it fails the farm is away, or the photo has changed: the fit itself will say so.
                    let _ = self.paint(photos[i], &position);
                    shown[i] = Some(position);
                    self.rest(REST * begin.elapsed());
                }
                _ => std::thread::sleep(PAUSE),
            }
        }
    }

    fn rest(&self, time: Duration) {
        let until = Instant::now() + time;
        while Instant::now() < until && !self.is_stopped() {
            std::thread::sleep(PAUSE);
        }
    }

    fn is_stopped(&self) -> bool {
        self.shared.stop.load(Ordering::Relaxed)
    }

    /// Renders one photo and shows it; `None` where that fails or was stopped.
    fn paint(&mut self, photo: usize, position: &Position) -> Option<()> {
        let mut capture = self.input.capture.clone();
        let parameters = capture.free_parameters().ok()?;
        let numbers: Vec<(String, f64)> = parameters
            .iter()
            .zip(&position.values)
            .flat_map(|(parameter, value)| parameter.numbers(*value).collect::<Vec<_>>())
            .collect();
        capture.set_numbers(&numbers).ok()?;
        let request = EvaluationRequest {
            numbers,
            photos: vec![photo],
            samples: SAMPLES,
            output: Output::StatisticsAndFilms,
            ..EvaluationRequest::default()
        };
        let shared = Arc::clone(&self.shared);
        let stopped = move || shared.stop.load(Ordering::Relaxed);
        let evaluation = self
            .farm
            .evaluate(&request, &mut |_| if stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
            .ok()?;
        let target = capture.target(photo)?;
        let photograph = Photograph::of(&capture, target, &self.input).ok()?;
        let panel = Panel::new(&capture, &photograph, evaluation.films.first()?, evaluation.photos.first()?)?;
        self.board.panel(photo, &panel, Some(position.iteration));
        Some(())
    }
}
