//! `gonio jobs`, `gonio attach`, `gonio cancel`: what runs on a farm.

use crate::arguments::{ClientArguments, JobsArguments};
use crate::failure::Failure;
use crate::farm::{Farm, Job, Jobs};
use crate::interrupt::Interrupt;
use crate::output::{tell, to_json};
use gonio_proto::convert::request::Class;
use serde::Serialize;
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// How long a client may have nothing under way before it is taken to have ended: an optimiser thinks between evaluations.
const PATIENCE: Duration = Duration::from_secs(10);

/// What one client has under way.
#[derive(Debug, Serialize)]
struct ClientSummary {
    client: String,
    /// "interactive" or "batch".
    class: &'static str,
    evaluations: usize,
    tasks_done: u64,
    tasks: u64,
    /// Camera samples traced so far.
    primary_samples: u64,
    /// Of the evaluation that was accepted last, where it compares.
    loss: f64,
    loss_standard_error: f64,
    /// Whether somebody listens to any of them.
    listened_to: bool,
    /// Of the oldest, seconds.
    seconds: f64,
}

#[derive(Debug, Serialize)]
struct Summary {
    workers: u32,
    slots: u64,
    clients: Vec<ClientSummary>,
}

/// `gonio jobs`.
pub fn list(arguments: &JobsArguments) -> Result<(), Failure> {
    let mut found = None;
    Farm::connect_by(&arguments.farm, &arguments.access)?.jobs(&mut |jobs| {
        found = Some(jobs);
        ControlFlow::Break(())
    })?;
    let found = found.ok_or_else(|| Failure::Failed("the farm lists nothing; try again".to_owned()))?;
    let summary = Summary { workers: found.workers, slots: found.slots, clients: by_client(&found) };
    if arguments.json {
        tell(&to_json(&summary)?);
        return Ok(());
    }
    tell(&format!("{} workers, {} threads", summary.workers, summary.slots));
    if !summary.clients.is_empty() {
        tell(&format!(
            "{:<40} {:<12} {:>5}  {:>15}  {:>22}  {:>7}",
            "client", "class", "evals", "tasks", "loss", "seconds"
        ));
    }
    for c in &summary.clients {
        let tasks = format!("{} / {}", c.tasks_done, c.tasks);
        let note = if c.listened_to { "" } else { "  (nobody listens)" };
        tell(&format!(
            "{:<40} {:<12} {:>5}  {tasks:>15}  {:>22}  {:>7.1}{note}",
            c.client,
            c.class,
            c.evaluations,
            loss(c),
            c.seconds
        ));
    }
    Ok(())
}

/// `gonio attach`.
pub fn attach(arguments: &ClientArguments) -> Result<(), Failure> {
    let interrupt = Interrupt::listen("")?;
    let (mut last, mut told, mut heard) = (Instant::now(), String::new(), false);
    Farm::connect_by(&arguments.farm.farm, &arguments.farm.access)?.jobs(&mut |jobs| {
        if interrupt.is_asked() {
            return ControlFlow::Break(());
        }
        let Some(client) = by_client(&jobs).into_iter().find(|c| c.client == arguments.client) else {
            let patience = if heard { PATIENCE } else { Duration::ZERO };
            return if last.elapsed() > patience { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        };
        (last, heard) = (Instant::now(), true);
        let line = if arguments.farm.json {
            serde_json::to_string(&client).unwrap_or_default()
        } else {
            format!(
                "{} / {} tasks, {} samples, loss {}",
                client.tasks_done,
                client.tasks,
                client.primary_samples,
                loss(&client)
            )
        };
        if line != told {
            tell(&line);
            told = line;
        }
        ControlFlow::Continue(())
    })?;
    if heard { Ok(()) } else { Err(nothing_of(&arguments.client)) }
}

/// `gonio cancel`.
pub fn cancel(arguments: &ClientArguments) -> Result<(), Failure> {
    let cancelled = Farm::connect_by(&arguments.farm.farm, &arguments.farm.access)?.cancel(&arguments.client)?;
    if cancelled == 0 {
        return Err(nothing_of(&arguments.client));
    }
    if arguments.farm.json {
        tell(&format!("{{\"cancelled\": {cancelled}}}"));
    } else {
        tell(&format!("{cancelled} evaluations of {} ended", arguments.client));
    }
    Ok(())
}

fn nothing_of(client: &str) -> Failure {
    Failure::Input(format!("{client} has nothing under way on this farm; `gonio jobs` lists the clients that have"))
}

fn by_client(jobs: &Jobs) -> Vec<ClientSummary> {
    let mut clients: BTreeMap<&str, Vec<&Job>> = BTreeMap::new();
    for job in &jobs.jobs {
        clients.entry(&job.requester.client).or_default().push(job);
    }
    let summary = |(client, jobs): (&str, Vec<&Job>)| {
        let last = jobs.last().map(|job| job.progress).unwrap_or_default();
        ClientSummary {
            client: client.to_owned(),
            class: match jobs.first().map(|job| job.requester.class) {
                Some(Class::Batch) => "batch",
                _ => "interactive",
            },
            evaluations: jobs.len(),
            tasks_done: jobs.iter().map(|job| job.progress.tasks_done).sum(),
            tasks: jobs.iter().map(|job| job.progress.tasks).sum(),
            primary_samples: jobs.iter().map(|job| job.progress.primary_samples).sum(),
            loss: last.loss,
            loss_standard_error: last.loss_standard_error,
            listened_to: jobs.iter().any(|job| job.listeners > 0),
            seconds: jobs.iter().map(|job| job.age.as_secs_f64()).fold(0.0, f64::max),
        }
    };
    clients.into_iter().map(summary).collect()
}

fn loss(client: &ClientSummary) -> String {
    if client.loss == 0.0 {
        return "-".to_owned();
    }
    format!("{:.4} +- {:.4}", client.loss, client.loss_standard_error)
}
