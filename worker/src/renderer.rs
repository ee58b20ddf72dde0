//! What a worker renders with. The path tracer in earnest; tests and benchmarks of the farm bring their own.

use gonio_scene::film::TileFilm;
use gonio_scene::{Assets, Capture, Parameter, Result};
use gonio_tracer::{Prepared, Stage};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

pub use gonio_tracer::TileTask;

/// Loads captures.
pub trait Renderer: Send + Sync {
    /// A capture and the contents of its meshes and maps, loaded.
    fn load(&self, capture: Capture, assets: Assets) -> Arc<dyn Loaded>;
}

/// A capture that is loaded.
pub trait Loaded: Send + Sync {
    /// The scene at `numbers` (those that differ from the capture's) with the derivatives that `columns` need.
    ///
    /// # Errors
    /// Numbers or columns that the capture does not have or allow.
    fn prepare(&self, numbers: &[(String, f64)], columns: &[Parameter]) -> Result<Arc<dyn Scene>>;
}

/// A scene that is ready to render. Both functions are pure: equal tasks, equal bits.
pub trait Scene: Send + Sync {
    /// Two halves of a tile; `None` once `cancel` is set.
    fn render(&self, task: &TileTask<'_>, cancel: &AtomicBool) -> Option<TileFilm>;

    /// A tile's first hits, its task's samples unused; `None` once `cancel` is set.
    fn first_hits(&self, task: &TileTask<'_>, cancel: &AtomicBool) -> Option<TileFilm>;
}

/// The path tracer.
#[derive(Debug, Clone, Copy, Default)]
pub struct PathTracer;

impl Renderer for PathTracer {
    fn load(&self, capture: Capture, assets: Assets) -> Arc<dyn Loaded> {
        Arc::new(Stage::new(capture, assets))
    }
}

impl Loaded for Stage {
    fn prepare(&self, numbers: &[(String, f64)], columns: &[Parameter]) -> Result<Arc<dyn Scene>> {
        Ok(Arc::new(self.prepare(numbers, columns)?))
    }
}

impl Scene for Prepared {
    fn render(&self, task: &TileTask<'_>, cancel: &AtomicBool) -> Option<TileFilm> {
        self.render(task, cancel)
    }

    fn first_hits(&self, task: &TileTask<'_>, cancel: &AtomicBool) -> Option<TileFilm> {
        self.first_hits(task.photo, task.tile, task.pixels, cancel)
    }
}
