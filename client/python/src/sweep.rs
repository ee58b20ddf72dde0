//! Sweeps, frame by frame.

use crate::array;
use crate::farm::Farm;
use crate::work::{attend, raise};
use gonio::commands::sweep::{Frame, frames};
use gonio::{Console, Failure, Interrupt, SweepOptions};
use numpy::PyArray3;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::sync::{Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// How often signals are looked for.
const TICK: Duration = Duration::from_millis(50);

/// Frames that may wait for Python to take them; the farm waits beyond that.
const WAITING: usize = 4;

enum Event {
    Line(String),
    Frame(Box<Frame>),
}

struct Running {
    events: Receiver<Event>,
    thread: JoinHandle<Result<(), Failure>>,
}

/// A sweep under way: an iterator of its frames.
#[pyclass(frozen, module = "gonio._native")]
pub struct Sweep {
    running: Mutex<Option<Running>>,
    interrupt: Interrupt,
    progress: Option<Py<PyAny>>,
}

/// Index, point, view, numbers, digest, mean photo value per channel, photo values.
type Given<'py> = (usize, usize, String, Vec<(String, f64)>, String, [f64; 3], Option<Bound<'py, PyArray3<f32>>>);

#[pymethods]
impl Sweep {
    /// Begins the sweep of the file `path` with the options of `gonio sweep`; `out` is where results are kept.
    #[new]
    fn new(
        path: PathBuf,
        out: Option<String>,
        farm: &Farm,
        words: Vec<String>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let options: SweepOptions = gonio::parse(&words).map_err(raise)?;
        let (interrupt, farm) = (Interrupt::default(), farm.farm.clone());
        let (sender, events) = sync_channel(WAITING);
        let asked = interrupt.clone();
        let run = move || {
            let lines = sender.clone();
            let mut console = Console::telling(move |line| drop(lines.send(Event::Line(line.to_owned()))));
            let mut give = |frame| {
                if sender.send(Event::Frame(Box::new(frame))).is_err() {
                    asked.ask();
                }
            };
            let farm = || Ok(farm.clone());
            frames(&path, out.as_deref(), &options, &farm, &mut console, &asked, &mut give)
        };
        let thread = std::thread::Builder::new().name("sweep".to_owned()).spawn(run)?;
        Ok(Self { running: Mutex::new(Some(Running { events, thread })), interrupt, progress })
    }

    /// The next frame that is finished.
    fn next<'py>(&self, py: Python<'py>) -> PyResult<Option<Given<'py>>> {
        let frame = py.detach(|| self.wait())?;
        let given = |frame: Frame| {
            let image = frame.image.as_ref().map(|film| array::colours(py, film)).transpose()?;
            Ok((frame.index, frame.point, frame.view, frame.numbers, frame.digest, frame.mean, image))
        };
        frame.map(given).transpose()
    }

    /// Ends the sweep, and returns once nothing of it runs any more. What was finished stays.
    fn close(&self, py: Python<'_>) {
        py.detach(|| drop(self.end()));
    }
}

impl Sweep {
    fn wait(&self) -> PyResult<Option<Frame>> {
        loop {
            let event = {
                let running = self.running.lock().unwrap_or_else(PoisonError::into_inner);
                let Some(running) = &*running else { return Ok(None) };
                running.events.recv_timeout(TICK)
            };
            let line = match event {
                Ok(Event::Frame(frame)) => return Ok(Some(*frame)),
                Ok(Event::Line(line)) => Some(line),
                Err(RecvTimeoutError::Timeout) => None,
                Err(RecvTimeoutError::Disconnected) => return self.end().map(|()| None).map_err(raise),
            };
            if let Err(error) = attend(line.as_deref(), self.progress.as_ref()) {
                // What it ends with is the interruption, or came after it.
                let _ = self.end();
                return Err(error);
            }
        }
    }

    /// Ends the sweep if it has not ended, and gives how it did.
    fn end(&self) -> Result<(), Failure> {
        let running = self.running.lock().unwrap_or_else(PoisonError::into_inner).take();
        let Some(Running { events, thread }) = running else { return Ok(()) };
        self.interrupt.ask();
        drop(events);
        thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }
}

impl Drop for Sweep {
    /// The thread ends by itself, soon; nobody waits for it.
    fn drop(&mut self) {
        self.interrupt.ask();
    }
}
