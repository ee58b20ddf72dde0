//! Work that Python waits for: the interpreter's lock is released, signals are heard, and progress is told on the caller's thread.

use gonio::{Console, Failure, Interrupt};
use pyo3::create_exception;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

create_exception!(
    gonio,
    GonioError,
    PyException,
    "What gonio could not do, in the words of the command line. Another try may succeed, unless it is an InputError."
);
create_exception!(
    gonio,
    InputError,
    GonioError,
    "Bad input: a file, a name or a value. The text says which, and what to write instead."
);

/// How often signals are looked for. A tenth of a second between Ctrl-C and its effect is not noticed.
const TICK: Duration = Duration::from_millis(50);

/// A command's failure as Python's.
pub fn raise(failure: Failure) -> PyErr {
    match failure {
        Failure::Input(text) => InputError::new_err(text),
        Failure::Failed(text) | Failure::Interrupted(text) => GonioError::new_err(text),
    }
}

/// Asks Python for signals, and tells it a line of `progress`, if there is one.
///
/// # Errors
/// `KeyboardInterrupt`, or whatever else a handler or the callable raises.
pub fn attend(line: Option<&str>, progress: Option<&Py<PyAny>>) -> PyResult<()> {
    Python::attach(|py| {
        py.check_signals()?;
        if let (Some(line), Some(progress)) = (line, progress) {
            progress.call1(py, (line,))?;
        }
        Ok(())
    })
}

/// Does `job` without the interpreter's lock. Signals, and what `progress` raises, interrupt it as Ctrl-C interrupts a command; this
/// returns once it has ended.
///
/// # Errors
/// What interrupted it; otherwise the job's failure.
pub fn work<T: Send>(
    py: Python<'_>,
    progress: Option<Py<PyAny>>,
    job: impl FnOnce(Console, &Interrupt) -> Result<T, Failure> + Send,
) -> PyResult<T> {
    let interrupt = &Interrupt::default();
    let (lines, heard) = channel::<String>();
    let (outcome, raised) = py.detach(move || {
        std::thread::scope(|scope| {
            let worker = scope.spawn(move || {
                // Nobody hears the last lines of what was interrupted.
                let console = Console::telling(move |line| drop(lines.send(line.to_owned())));
                job(console, interrupt)
            });
            let raised = wait(&heard, progress.as_ref(), interrupt);
            (worker.join(), raised)
        })
    });
    match (raised, outcome) {
        (Some(raised), _) => Err(raised),
        (None, Ok(result)) => result.map_err(raise),
        (None, Err(panic)) => std::panic::resume_unwind(panic),
    }
}

/// Attends until the job has dropped its console; gives what interrupted it.
fn wait(heard: &Receiver<String>, progress: Option<&Py<PyAny>>, interrupt: &Interrupt) -> Option<PyErr> {
    let mut raised = None;
    loop {
        let line = match heard.recv_timeout(TICK) {
            Ok(line) => Some(line),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => return raised,
        };
        if raised.is_none()
            && let Err(error) = attend(line.as_deref(), progress)
        {
            interrupt.ask();
            raised = Some(error);
        }
    }
}
