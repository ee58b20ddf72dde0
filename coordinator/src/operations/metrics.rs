//! The coordinator's metrics.
//!
//! Names are part of the interface: the dashboard and people's alerts are written in them.

use super::Phase;
use crate::Coordinator;
use crate::broker::Survey;
use gonio_operations::Families;

/// Most workers that have series of their own, two each; those that connected first. All together are in the other metrics.
const NAMED_WORKERS: usize = 500;

pub(super) fn families(phase: Phase, coordinator: Option<&Coordinator>) -> Families {
    let mut families = Families::new();
    families.gauges(
        "gonio_coordinator_phase",
        "1 for the phase that the coordinator is in: it owns the farm in serving and draining.",
        "phase",
        Phase::ALL.map(|known| (known.name(), u64::from(known == phase))),
    );
    if let Some(coordinator) = coordinator {
        let survey = coordinator.broker.survey(NAMED_WORKERS);
        now(&mut families, &survey, coordinator.jobs.count() as u64);
        so_far(&mut families, &survey);
        workers(&mut families, &survey);
        let broker = &coordinator.broker;
        families.histogram(
            "gonio_coordinator_task_render_seconds",
            "Render time of the tasks committed, on one thread of a worker.",
            &broker.render_times,
        );
        let traffic = &broker.traffic;
        #[allow(clippy::cast_precision_loss)]
        let bytes = |counts: [(&'static str, u64); 2]| counts.map(|(what, count)| (what, count as f64));
        families.counters(
            "gonio_coordinator_received_bytes_total",
            "Bytes received: films of results from workers, files of captures from clients.",
            "what",
            bytes([("films", traffic.films.count()), ("files", traffic.uploads.count())]),
        );
        families.counters(
            "gonio_coordinator_sent_bytes_total",
            "Bytes sent: progress and results to clients, files of captures to workers and clients.",
            "what",
            bytes([("answers", traffic.answers.count()), ("files", traffic.downloads.count())]),
        );
    }
    families
}

/// What is so at this moment.
fn now(families: &mut Families, survey: &Survey, open: u64) {
    let mut gauge = |name, help, value| families.gauge(name, help, value);
    gauge("gonio_coordinator_tasks_queued", "Tasks that wait for a worker.", survey.load.queued);
    gauge("gonio_coordinator_tasks_leased", "Attempts at tasks that workers hold.", survey.load.leased);
    gauge("gonio_coordinator_evaluations_open", "Evaluations accepted that are not over.", open);
    gauge("gonio_coordinator_workers_connected", "Workers connected.", survey.connected);
    gauge("gonio_coordinator_workers_silent", "Workers connected that do not beat.", survey.silent);
    gauge("gonio_coordinator_worker_slots", "Tasks that all workers render at the same time.", survey.slots);
}

/// What has happened since the start.
fn so_far(families: &mut Families, survey: &Survey) {
    let counters = &survey.counters;
    let mut counter = |name, help, value| families.counter(name, help, value);
    counter("gonio_coordinator_leases_granted_total", "Attempts at tasks handed to workers.", counters.granted);
    counter("gonio_coordinator_tasks_done_total", "Tasks whose result was accepted.", counters.committed);
    counter(
        "gonio_coordinator_tasks_retried_total",
        "Attempts that ended without a result: their tasks are handed out again, or set aside.",
        counters.returned,
    );
    counter(
        "gonio_coordinator_second_attempts_total",
        "Attempts at tasks that another worker was taking long for.",
        counters.second,
    );
    counter(
        "gonio_coordinator_tasks_set_aside_total",
        "Tasks lost too often, each of which ended its evaluation.",
        counters.set_aside,
    );
    counter(
        "gonio_coordinator_camera_samples_total",
        "Camera samples of the tasks whose result was accepted.",
        counters.camera_samples,
    );
    counter(
        "gonio_coordinator_worker_silences_total",
        "Times that a worker fell silent and lost its leases.",
        counters.silences,
    );
    counter("gonio_coordinator_workers_gone_total", "Workers whose stream ended.", counters.workers_gone);
    let late = counters.refused.saturating_sub(counters.foreign + counters.repeated);
    #[allow(clippy::cast_precision_loss)]
    families.counters(
        "gonio_coordinator_results_refused_total",
        "Results refused: late (the lease had ended), foreign (it was never that worker's), repeated (sent before).",
        "reason",
        [("late", late), ("foreign", counters.foreign), ("repeated", counters.repeated)].map(|(r, n)| (r, n as f64)),
    );
}

/// How fast each worker is: camera samples over render time.
fn workers(families: &mut Families, survey: &Survey) {
    #[allow(clippy::cast_precision_loss)]
    families.counters(
        "gonio_coordinator_worker_camera_samples_total",
        "Camera samples committed by a connected worker; at most 500 workers are named.",
        "worker",
        survey.workers.iter().map(|(name, worker)| (name, worker.camera_samples as f64)),
    );
    families.counters(
        "gonio_coordinator_worker_render_seconds_total",
        "Render time of the tasks committed by a connected worker, of one thread; at most 500 workers are named.",
        "worker",
        survey.workers.iter().map(|(name, worker)| (name, worker.render_time.as_secs_f64())),
    );
}
