//! Renders the frames that are missing, several batches at a time, so that a farm's workers do not wait for each other's
//! small frames, nor for files to be written.

use super::frame::encode;
use super::input::Rendered;
use super::place::Place;
use crate::failure::Failure;
use crate::farm::{Farm, FarmError, OpenCapture};
use crate::interrupt::Interrupt;
use crate::progress::SweepConsole;
use gonio_fit::{Evaluate, EvaluateError};
use gonio_scene::{Evaluation, EvaluationRequest, Film, Output as Wanted, Stream};
use gonio_sweep::{Batch, FrameDigest, Output, Plan, Record};
use std::collections::VecDeque;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How long a farm that cannot be reached is asked again before the sweep gives up.
const PATIENCE: Duration = Duration::from_secs(120);

/// The first and the longest pause between two such tries.
const PAUSES: (Duration, Duration) = (Duration::from_millis(250), Duration::from_secs(5));

/// How often the console is redrawn.
const REDRAW: Duration = Duration::from_millis(100);

/// What the threads of a sweep share.
pub(super) struct Runner<'a> {
    pub plan: &'a Plan,
    pub digests: &'a [FrameDigest],
    pub files: &'a Rendered,
    pub place: &'a Place,
    pub farm: &'a Farm,
    pub interrupt: &'a Interrupt,
    /// Set once no further batch is to begin.
    pub stop: AtomicBool,
    /// Camera samples of batches that are finished.
    pub traced: AtomicU64,
}

enum Event {
    Finished(usize, Box<Record>, Film),
    Waiting(String),
    Failed(Failure),
}

impl Runner<'_> {
    /// Renders `batches`, `in_flight` at a time, and gives each finished frame's record and photo values to
    /// `finished`.
    ///
    /// # Errors
    /// The first failure; what was finished before it stays.
    pub fn run(
        &self,
        open: &OpenCapture,
        batches: Vec<Batch>,
        in_flight: usize,
        console: &mut SweepConsole<'_>,
        finished: &mut dyn FnMut(usize, Record, Film),
    ) -> Result<(), Failure> {
        let threads = in_flight.min(batches.len());
        let queue = Mutex::new(VecDeque::from(batches));
        let under_way: Vec<AtomicU64> = (0..threads).map(|_| AtomicU64::new(0)).collect();
        // Who takes frames slowly slows the farm down, rather than fill the memory with them.
        let (events, receiver) = sync_channel(threads.max(1));
        let mut result = Ok(());
        std::thread::scope(|scope| {
            for under_way in &under_way {
                let (events, queue) = (events.clone(), &queue);
                scope.spawn(move || self.work(open.clone(), queue, under_way, &events));
            }
            drop(events);
            let mut drawn = Instant::now();
            loop {
                match receiver.recv_timeout(REDRAW) {
                    Ok(Event::Finished(frame, record, image)) => {
                        console.rendered(frame, &record.digest);
                        finished(frame, *record, image);
                    }
                    Ok(Event::Waiting(text)) => console.warn(&text),
                    Ok(Event::Failed(failure)) => {
                        self.stop.store(true, Ordering::Relaxed);
                        if result.is_ok() {
                            result = Err(failure);
                        }
                    }
                    Err(RecvTimeoutError::Timeout) => {}
                    Err(RecvTimeoutError::Disconnected) => break,
                }
                if drawn.elapsed() >= REDRAW {
                    drawn = Instant::now();
                    let partly: u64 = under_way.iter().map(|samples| samples.load(Ordering::Relaxed)).sum();
                    console.advance(self.traced.load(Ordering::Relaxed) + partly);
                }
            }
        });
        result
    }

    fn work(
        &self,
        mut open: OpenCapture,
        queue: &Mutex<VecDeque<Batch>>,
        under_way: &AtomicU64,
        events: &SyncSender<Event>,
    ) {
        while !self.halted() {
            let next = queue.lock().unwrap_or_else(PoisonError::into_inner).pop_front();
            let Some(batch) = next else { return };
            if let Err(failure) = self.render(&mut open, &batch, under_way, events) {
                // Nobody listens any more only where the whole sweep has ended.
                let _ = events.send(Event::Failed(failure));
                return;
            }
        }
    }

    fn halted(&self) -> bool {
        self.stop.load(Ordering::Relaxed) || self.interrupt.is_asked()
    }

    fn render(
        &self,
        open: &mut OpenCapture,
        batch: &Batch,
        under_way: &AtomicU64,
        events: &SyncSender<Event>,
    ) -> Result<(), Failure> {
        let begin = Instant::now();
        let frames: Vec<_> = batch.frames.iter().filter_map(|i| self.plan.frames.get(*i)).collect();
        let Some(first) = frames.first() else { return Ok(()) };
        let mut request = EvaluationRequest {
            numbers: self.plan.numbers(first),
            photos: frames.iter().map(|frame| frame.photo).collect(),
            samples: self.plan.samples,
            seed: Stream::Render.seed(first.seed),
            output: Wanted::Films,
            ..EvaluationRequest::default()
        };
        let lit = self.evaluate(open, &request, under_way, events)?;
        if lit.invalid_samples > 0 && batch.frames.len() > 1 {
            // Only a frame alone says whose they are.
            for frame in &batch.frames {
                self.render(open, &Batch { frames: vec![*frame] }, under_way, events)?;
            }
            return Ok(());
        }
        let mut hits = Vec::new();
        if self.plan.outputs.contains(&Output::Buffers) {
            (request.output, request.samples) = (Wanted::FirstHit, 2);
            hits = self.evaluate(open, &request, &AtomicU64::new(0), events)?.films;
        }
        let seconds = begin.elapsed().as_secs_f64();
        let mut capture = self.plan.capture.clone();
        capture.set_numbers(&request.numbers)?;
        let pixels: u64 = frames.iter().map(|frame| self.plan.pixels(frame)).sum();
        for (i, (&frame, film)) in batch.frames.iter().zip(&lit.films).enumerate() {
            let share = crate::progress::count(u64::from(film.width) * u64::from(film.height))
                / crate::progress::count(pixels.max(1));
            let digest = self.digests[frame];
            let measured = (lit.invalid_samples, seconds * share);
            let written = encode(self.plan, &capture, digest, film, hits.get(i), measured)?;
            self.place.put_frame(digest, written.files, &written.record)?;
            let _ = events.send(Event::Finished(frame, Box::new(written.record), written.image));
        }
        self.traced.fetch_add(lit.primary_samples, Ordering::Relaxed);
        under_way.store(0, Ordering::Relaxed);
        Ok(())
    }

    /// Evaluates; a farm that went away is waited for, and gets the capture anew: it may have lost it.
    fn evaluate(
        &self,
        open: &mut OpenCapture,
        request: &EvaluationRequest,
        under_way: &AtomicU64,
        events: &SyncSender<Event>,
    ) -> Result<Evaluation, Failure> {
        let begin = Instant::now();
        let mut pause = PAUSES.0;
        let mut refused = false;
        loop {
            let error = match open.evaluate(request, &mut |progress| {
                under_way.store(progress.primary_samples, Ordering::Relaxed);
                if self.halted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            }) {
                Ok(evaluation) => return Ok(evaluation),
                Err(error) => error,
            };
            let again = match &error {
                EvaluateError::Cancelled => false,
                // A coordinator that was started anew knows no capture; what is wrong with a request stays wrong.
                EvaluateError::Refused(_) => !std::mem::replace(&mut refused, true),
                EvaluateError::Farm(_) => begin.elapsed() < PATIENCE,
            };
            if !self.farm.is_remote() || !again {
                return Err(error.into());
            }
            if pause == PAUSES.0 {
                let _ = events.send(Event::Waiting(format!("{error}; trying again")));
            }
            let until = Instant::now() + pause;
            while Instant::now() < until && !self.halted() {
                std::thread::sleep(Duration::from_millis(50).min(pause));
            }
            pause = (2 * pause).min(PAUSES.1);
            match self.farm.open(self.files) {
                Ok(anew) => *open = anew,
                Err(FarmError::Capture(error)) => return Err(error.into()),
                // Still away: the next evaluation says so, too.
                Err(_) => {}
            }
        }
    }
}
