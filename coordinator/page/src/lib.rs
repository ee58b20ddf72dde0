//! Pages that follow what runs: a fit, a diagnosis or a sweep, served by its own program, and a farm, served by its coordinator.
//!
//! Whoever has something to show implements [`Show`]: its whole state as one JSON object, whenever asked. A page is sent the
//! state once and then, at most twice a second, what has changed, as server-sent events; so a page that comes late, or back
//! after a restart, needs nothing that was sent before. Files are fixed, of this crate, and fetch nothing from elsewhere.

mod files;
mod guard;
mod patch;
mod server;
mod show;
mod stream;
mod viewers;

pub use axum::serve::Listener;
pub use files::{POLICY, Page};
pub use guard::{Hosts, protected};
pub use patch::difference;
pub use server::{HEADER, router, serve};
pub use show::{Refusal, Show, View, Visitor, Window};
pub use stream::INTERVAL;
pub use viewers::{MOST, Viewers};
