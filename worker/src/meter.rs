//! What a worker has done, how it is, and what it holds.

use crate::Worker;
use gonio_operations::{Distribution, Families, Probe, Pulse, Verdict};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::time::Duration;

/// The loop that speaks with the coordinator has hung if it does not come round for so long: it does once a second, however
/// long a render takes.
const HUNG: Duration = Duration::from_secs(30);

/// Counts of a worker; all only grow.
#[derive(Debug, Default)]
pub struct Meter {
    /// Render time of tasks that were rendered, of one thread.
    pub render_times: Distribution,
    /// Tasks that were rendered.
    pub rendered: AtomicU64,
    /// Tasks that cannot be rendered, by anybody.
    pub failed: AtomicU64,
    /// Tasks ended while they were rendered: another worker was faster, the evaluation is over, or the grace.
    pub cancelled: AtomicU64,
    /// Camera samples of the tasks that were rendered.
    pub camera_samples: AtomicU64,
    /// Bytes of captures' files that were fetched.
    pub fetched_bytes: AtomicU64,
    /// Streams to a coordinator that were begun, successful or not.
    pub connections: AtomicU64,
    /// Whether a coordinator has accepted this worker, on the stream that is open.
    pub accepted: AtomicBool,
    /// Whether it has been told to stop.
    pub stopping: AtomicBool,
    /// Beats while the loop that speaks with the coordinator comes round.
    pub pulse: Pulse,
}

impl Meter {
    /// Counts a task that was rendered.
    pub(crate) fn rendered(&self, camera_samples: u64, time: Duration) {
        self.rendered.fetch_add(1, Relaxed);
        self.camera_samples.fetch_add(camera_samples, Relaxed);
        self.render_times.add(time);
    }
}

impl Probe for Worker {
    fn startup(&self) -> Verdict {
        // It is asked from when it can render on.
        Ok(())
    }

    fn ready(&self) -> Verdict {
        if self.meter.stopping.load(Relaxed) {
            return Err("it stops: what it renders is finished, the rest handed back".to_owned());
        }
        if !self.meter.accepted.load(Relaxed) {
            return Err("no coordinator has accepted it yet, or not again".to_owned());
        }
        self.live()
    }

    fn live(&self) -> Verdict {
        self.meter.pulse.within(HUNG, "the loop that speaks with the coordinator")?;
        if self.queue.is_stuck(HUNG) {
            return Err(format!("tasks have waited for {} s while render threads are free", HUNG.as_secs()));
        }
        Ok(())
    }

    fn metrics(&self) -> Families {
        let (meter, mut families) = (&*self.meter, Families::new());
        let (rendering, waiting) = self.queue.load();
        let held = self.scenes.held();
        let mut gauge = |name, help, value| families.gauge(name, help, value);
        gauge(
            "gonio_worker_accepted",
            "1 while a coordinator has accepted this worker, else 0.",
            u64::from(meter.accepted.load(Relaxed)),
        );
        gauge("gonio_worker_slots", "Tasks that it renders at the same time.", self.slots().into());
        gauge("gonio_worker_jobs_running", "Render threads that render or prepare.", rendering);
        gauge("gonio_worker_jobs_waiting", "Tasks and preparations that wait for a render thread.", waiting);
        gauge("gonio_worker_cache_bytes", "Bytes of the files of captures that are kept loaded.", held.bytes);
        gauge("gonio_worker_cached_captures", "Captures that are kept loaded.", held.captures);
        gauge("gonio_worker_cached_scenes", "Scenes that are kept prepared.", held.scenes);
        let ended = [("rendered", &meter.rendered), ("failed", &meter.failed), ("cancelled", &meter.cancelled)];
        #[allow(clippy::cast_precision_loss)]
        families.counters(
            "gonio_worker_tasks_total",
            "Tasks that a render thread began and that ended: rendered, failed (nobody can render them), or cancelled.",
            "outcome",
            ended.map(|(outcome, count)| (outcome, count.load(Relaxed) as f64)),
        );
        let mut counter = |name, help, value| families.counter(name, help, value);
        counter(
            "gonio_worker_camera_samples_total",
            "Camera samples of the tasks that were rendered.",
            meter.camera_samples.load(Relaxed),
        );
        counter(
            "gonio_worker_fetched_bytes_total",
            "Bytes of captures' files fetched, from a store or the coordinator.",
            meter.fetched_bytes.load(Relaxed),
        );
        counter(
            "gonio_worker_reconnects_total",
            "Times that it tried again to reach a coordinator.",
            meter.connections.load(Relaxed).saturating_sub(1),
        );
        families.histogram(
            "gonio_worker_task_render_seconds",
            "Render time of the tasks that were rendered, on one thread.",
            &meter.render_times,
        );
        families
    }
}
