//! A farm's state, as its page shows it.

use crate::Coordinator;
use crate::broker::{Activity, WorkerLook};
use crate::evaluation;
use crate::jobs::Job;
use crate::security::{Guard, Roles};
use gonio_page::{Refusal, Show, View, Visitor};
use gonio_proto::convert::event::CANCELLED;
use gonio_proto::convert::request::Class;
use serde::Deserialize;
use serde_json::{Map, Value, json};
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};
use tokio::time::Instant;

/// What a page shows of a coordinator.
pub struct FarmPage {
    coordinator: Coordinator,
    guard: Guard,
    /// One moment by both clocks, so that a time that is told twice is the same twice.
    began: (Instant, u64),
}

/// Which evaluation an action is about. Numbers begin anew with every coordinator.
#[derive(Deserialize)]
struct Which {
    epoch: u64,
    evaluation: u64,
}

impl FarmPage {
    /// The page of a coordinator, for those whom `guard` lets in.
    #[must_use]
    pub fn new(coordinator: Coordinator, guard: Guard) -> Self {
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Self { coordinator, guard, began: (Instant::now(), since.as_secs()) }
    }

    /// Seconds since 1970 at an instant.
    fn unix(&self, at: Instant) -> u64 {
        let (began, unix) = self.began;
        match at.checked_duration_since(began) {
            Some(since) => unix + since.as_secs(),
            None => unix.saturating_sub(began.saturating_duration_since(at).as_secs()),
        }
    }

    fn jobs(&self, view: &View) -> Value {
        let (find, window) = (view.text("find_jobs"), view.window("jobs"));
        let all = self.coordinator.jobs.all();
        let found: Vec<&Arc<Job>> = all.iter().filter(|job| job.requester.client.contains(find)).collect();
        let rows: Map<String, Value> = found
            .iter()
            .skip(window.from)
            .take(window.count)
            .map(|job| (job.evaluation.to_string(), self.job(job)))
            .collect();
        json!({ "total": all.len(), "found": found.len(), "from": window.from, "rows": rows })
    }

    fn job(&self, job: &Job) -> Value {
        let progress = evaluation::progress(&self.coordinator, job);
        let loss = (progress.loss != 0.0).then_some((progress.loss, progress.loss_standard_error));
        json!({
            "client": job.requester.client,
            "class": match job.requester.class { Class::Interactive => "interactive", Class::Batch => "batch" },
            "done": progress.tasks_done,
            "tasks": progress.tasks,
            "speed": self.coordinator.broker.samples_per_second(job.evaluation).round(),
            "loss": loss.map(|(loss, _)| loss),
            "error": loss.map(|(_, error)| error),
            "since": self.unix(job.since),
            "listeners": job.listeners(),
        })
    }

    fn workers(&self, view: &View, total: usize) -> Value {
        let window = view.window("workers");
        let broker = &self.coordinator.broker;
        let (found, workers) = broker.look_at_workers(view.text("find_workers"), window.from, window.count);
        let rows: Map<String, Value> = workers.iter().map(|w| (w.id.to_string(), self.worker(w))).collect();
        json!({ "total": total, "found": found, "from": window.from, "rows": rows })
    }

    fn worker(&self, worker: &WorkerLook) -> Value {
        let state = match worker.activity {
            Activity::Rendering => "rendering",
            Activity::Idle => "idle",
            Activity::Leaving => "leaving",
            Activity::Silent => "silent",
        };
        json!({
            "name": worker.name,
            "state": state,
            "slots": worker.slots,
            "held": worker.held,
            "samples": worker.samples,
            "speed": worker.samples_per_second.round(),
            "since": self.unix(worker.since),
        })
    }
}

impl Show for FarmPage {
    fn admit(&self, authorization: Option<&str>) -> Result<Visitor, Refusal> {
        let allowed = |call| {
            let path = format!("/{}/{call}", gonio_proto::wire::farm_server::SERVICE_NAME);
            let roles = Roles::for_call(&path).unwrap_or_default();
            self.guard.allows(authorization, roles).map_err(|status| Refusal::Unknown(status.message().to_owned()))
        };
        if !allowed("Jobs")? {
            return Err(Refusal::Forbidden("this token has neither the role watch nor submit".to_owned()));
        }
        Ok(Visitor { may_act: allowed("Cancel")? })
    }

    fn state(&self, view: &View) -> Map<String, Value> {
        let all = self.coordinator.broker.look();
        let state = [
            ("epoch", self.coordinator.broker.epoch().into()),
            ("started", self.began.1.into()),
            ("time", self.unix(Instant::now()).into()),
            ("strength", json!({ "workers": all.workers, "silent": all.silent, "slots": all.slots, "busy": all.busy })),
            ("queue", json!({ "waiting": all.waiting, "leased": all.leased })),
            ("speed", json!(all.samples_per_second.round())),
            ("jobs", self.jobs(view)),
            ("workers", self.workers(view, all.workers)),
        ];
        state.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
    }

    fn act(&self, action: &str, of: &Value) -> Result<String, Refusal> {
        let which = Which::deserialize(of);
        let Which { epoch, evaluation } =
            which.map_err(|error| Refusal::Bad(format!("names no evaluation: {error}")))?;
        let gone = || Refusal::Absent(format!("evaluation {evaluation} is over"));
        let broker = &self.coordinator.broker;
        let job = self.coordinator.jobs.get(evaluation).filter(|_| epoch == broker.epoch()).ok_or_else(gone)?;
        match action {
            "cancel" => {
                tracing::info!(evaluation, client = job.requester.client, "cancelled on the page");
                job.cancel(CANCELLED);
                Ok(format!("Evaluation {evaluation} is cancelled."))
            }
            "retry" => {
                Ok(format!("{} tasks of evaluation {evaluation} are handed out anew.", broker.reissue(evaluation)))
            }
            _ => Err(Refusal::Absent(format!("{action:?} is nothing that this page does"))),
        }
    }
}
