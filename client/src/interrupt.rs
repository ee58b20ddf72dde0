//! Ctrl-C: the first asks for a clean stop, the second kills.

use crate::failure::Failure;
use crate::output::tell_error;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether somebody wants the work to stop. [`Interrupt::listen`] makes it that of the whole process: SIGINT, or SIGTERM where there
/// is one. The default one hears no signal, and is asked by [`Interrupt::ask`] alone.
#[derive(Debug, Clone, Default)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens from now on, on a thread of its own. A second signal ends the process at once, with exit code 130.
    ///
    /// # Errors
    /// The system allows no thread or no signal handler.
    pub fn listen(note: &'static str) -> Result<Self, Failure> {
        let failed = |error: std::io::Error| Failure::Failed(format!("cannot listen for signals: {error}"));
        let asked = Arc::new(AtomicBool::new(false));
        let flag = asked.clone();
        let runtime = tokio::runtime::Builder::new_current_thread().enable_io().build().map_err(failed)?;
        // Registered before this returns, so that no early signal takes the default way.
        let mut signals = runtime.block_on(async { Signals::new() }).map_err(failed)?;
        let wait = move || {
            runtime.block_on(async {
                signals.next().await;
                flag.store(true, Ordering::Relaxed);
                if !note.is_empty() {
                    tell_error(&format!("\n{note}"));
                }
                signals.next().await;
            });
            std::process::exit(130);
        };
        std::thread::Builder::new().name("signals".to_owned()).spawn(wait).map_err(failed)?;
        Ok(Self(asked))
    }

    /// Asks as the first signal does.
    pub fn ask(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether a signal has come, or [`Interrupt::ask`] was called.
    #[must_use]
    pub fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// What a watcher of an evaluation returns.
    pub fn flow(&self) -> ControlFlow<()> {
        if self.is_asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

#[cfg(unix)]
struct Signals {
    interrupt: tokio::signal::unix::Signal,
    terminate: tokio::signal::unix::Signal,
}

#[cfg(unix)]
impl Signals {
    fn new() -> std::io::Result<Self> {
        use tokio::signal::unix::{SignalKind, signal};
        Ok(Self { interrupt: signal(SignalKind::interrupt())?, terminate: signal(SignalKind::terminate())? })
    }

    async fn next(&mut self) {
        tokio::select! {
            _ = self.interrupt.recv() => {}
            _ = self.terminate.recv() => {}
        }
    }
}

#[cfg(windows)]
struct Signals(tokio::signal::windows::CtrlC);

#[cfg(windows)]
impl Signals {
    fn new() -> std::io::Result<Self> {
        tokio::signal::windows::ctrl_c().map(Self)
    }

    async fn next(&mut self) {
        self.0.recv().await;
    }
}
