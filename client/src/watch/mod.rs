//! `--watch`: a page that follows this command while it runs.
//!
//! The page is served by this process, on a thread of its own, to this machine alone: it shows the part that is measured, and
//! can stop the command. It ends with the command: once that is over, pages that follow get its last state and have
//! [`PATIENCE`] to fetch the last pictures; where nobody follows, nobody is waited for.

mod board;
mod diagnose;
mod fit;
mod live;
mod sweep;

pub use live::Live;
pub use sweep::SheetWatch;

use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::progress::Console;
use board::Board;
use clap::Args;
use gonio_page::{Hosts, Page, Show, Viewers, router, serve};
use serde_json::json;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

/// How long pages that follow may take to fetch the last pictures. A browser needs far less.
const PATIENCE: Duration = Duration::from_secs(5);

/// Whether to serve a page.
#[derive(Debug, Args)]
pub struct WatchArguments {
    /// Serve a page that follows this command, to this machine alone, and can stop it; its address is printed. Without an
    /// address, at a port that is free
    #[arg(
        long,
        value_name = "ADDRESS:PORT",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "127.0.0.1:0",
        value_parser = loopback
    )]
    pub watch: Option<SocketAddr>,
}

fn loopback(text: &str) -> Result<SocketAddr, String> {
    match text.parse::<SocketAddr>() {
        Ok(address) if address.ip().is_loopback() => Ok(address),
        Ok(_) => {
            Err("anybody who reaches this address could stop the command: write 127.0.0.1:PORT, and reach it from \
                      elsewhere by ssh -L PORT:127.0.0.1:PORT"
                .to_owned())
        }
        Err(_) => Err("write 127.0.0.1:PORT, or [::1]:PORT; port 0 takes a free one".to_owned()),
    }
}

/// The page of a command; of one that was not asked for, nothing at all.
pub struct Watch(Option<Open>);

struct Open {
    board: Arc<Board>,
    viewers: Viewers,
    /// Runs the server; ends with it.
    runtime: tokio::runtime::Runtime,
}

impl Watch {
    /// Of what nobody follows.
    pub fn none() -> Self {
        Self(None)
    }

    /// Serves the page, where the arguments ask for one, and says where. `what` is what runs, such as "Fit", of `capture`;
    /// whoever stops it on the page asks `interrupt`.
    ///
    /// # Errors
    /// The address cannot be served.
    pub fn open(
        arguments: &WatchArguments,
        (what, capture): (&str, &str),
        interrupt: &Interrupt,
        console: &Console,
    ) -> Result<Self, Failure> {
        let Some(address) = arguments.watch else { return Ok(Self::none()) };
        let failed = |error: std::io::Error| Failure::Failed(format!("--watch={address}: {error}"));
        let board = Arc::new(Board::new(what, capture, interrupt.clone()));
        let mut runtime = tokio::runtime::Builder::new_multi_thread();
        let runtime = runtime.worker_threads(1).thread_name("watch").enable_all().build().map_err(failed)?;
        let listener = runtime.block_on(tokio::net::TcpListener::bind(address)).map_err(failed)?;
        let url = format!("http://{}/", listener.local_addr().map_err(failed)?);
        let viewers = Viewers::default();
        let show: Arc<dyn Show> = board.clone();
        runtime.spawn(serve(listener, router(Page::Run, show, Hosts::Addresses, viewers.clone())));
        console.line(&format!("watch at {url}"));
        console.event(&json!({ "event": "watch", "url": url }));
        Ok(Self(Some(Open { board, viewers, runtime })))
    }

    /// Whether there is a page.
    pub fn is_open(&self) -> bool {
        self.0.is_some()
    }

    /// What the page shows; `None` where there is none.
    fn board(&self) -> Option<&Board> {
        self.0.as_ref().map(|open| open.board.as_ref())
    }

    /// Whether anybody follows: only then is anything rendered for the page alone.
    fn is_watched(&self) -> bool {
        self.0.as_ref().is_some_and(|open| open.viewers.count() > 0)
    }

    /// Says what is done now, where no event does.
    pub fn phase(&self, text: &str) {
        if let Some(board) = self.board() {
            board.set("phase", text);
        }
    }

    /// The command is over, with this outcome; returns once those who follow know.
    pub fn end(self, outcome: &Result<(), Failure>) {
        let Some(open) = self.0 else { return };
        let (how, text) = match outcome {
            Ok(()) => ("done", "Done; the program has ended.".to_owned()),
            Err(Failure::Interrupted(text)) => ("interrupted", format!("Stopped: {text}")),
            Err(failure) => ("failed", format!("Failed: {failure}")),
        };
        open.board.end(how, &text);
        open.runtime.block_on(open.viewers.gone(PATIENCE));
        open.runtime.shutdown_background();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_this_machine_may_watch() {
        assert_eq!(loopback("127.0.0.1:0").unwrap().port(), 0);
        assert!(loopback("[::1]:8017").is_ok());
        assert!(loopback("0.0.0.0:8017").unwrap_err().contains("ssh -L"));
        for bad in ["8017", "localhost", "127.0.0.1"] {
            assert!(loopback(bad).unwrap_err().contains("127.0.0.1:PORT"), "{bad}");
        }
    }
}
