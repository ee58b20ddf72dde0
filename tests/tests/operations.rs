//! How the farm is operated, by its real programs: what probes, health checks and metrics say while coordinators start,
//! stand by, drain and die, and workers come, wait and go.

#![allow(missing_docs, clippy::unwrap_used)] // Its helpers may do what its tests may.
#![cfg(unix)]

use gonio::farm::Farm;
use gonio_tests::cluster::{Cluster, Process, command, fitted};
use gonio_tests::operations::{Metrics, ask, free_address, probe, wait_for};
use std::collections::BTreeSet;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;
use tonic::transport::Endpoint;
use tonic_health::pb::HealthCheckRequest;
use tonic_health::pb::health_check_response::ServingStatus;
use tonic_health::pb::health_client::HealthClient;

const SOON: Duration = Duration::from_secs(10);
const FARM: &str = "gonio.farm.v1.Farm";

fn statuses(address: &str) -> [u16; 3] {
    ["startup", "ready", "live"].map(|name| probe(address, name).map_or(0, |answer| answer.status))
}

/// What `grpc.health.v1` says of a service; `None` where nobody answers.
async fn health(url: &str, service: &str) -> Option<ServingStatus> {
    let channel = Endpoint::from_shared(url.to_owned()).unwrap().connect().await.ok()?;
    let request = HealthCheckRequest { service: service.to_owned() };
    let answer = HealthClient::new(channel).check(request).await.ok()?;
    Some(answer.into_inner().status())
}

/// An evaluation that nobody renders: it keeps a coordinator that drains from ending.
fn submit(url: &str) -> Process {
    let capture = gonio_tests::captures().join("none-201");
    let out = std::env::temp_dir().join(format!("gonio-operations-{}", std::process::id()));
    let arguments = ["render", capture.to_str().unwrap(), "--farm", url, "--out", out.to_str().unwrap()];
    Process::spawn(command("gonio", &arguments).stderr(Stdio::null()))
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn probes_and_health_follow_owner_and_standby_from_start_to_end() {
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().to_str().unwrap();
    let own = ["--store", store, "--operations", "127.0.0.1:0", "--grace", "4"];
    let cluster = Cluster::start_by(&own, 0, &[]);
    let owner = cluster.port("operations").to_owned();
    assert_eq!(statuses(&owner), [200, 200, 200]);
    assert_eq!(health(&cluster.url, "").await, Some(ServingStatus::Serving));
    assert_eq!(health(&cluster.url, FARM).await, Some(ServingStatus::Serving));
    assert_eq!(health(&cluster.url, "somebody.else").await, None);
    assert_eq!(Metrics::of(&owner).value("gonio_coordinator_phase{phase=\"serving\"}"), 1.0);

    let (standby, listen) = (free_address(), free_address());
    let arguments = ["--store", store, "--standby", "--listen", &listen, "--operations", &standby, "--grace", "4"];
    let mut second = Process::start("gonio-coordinator", &arguments);
    wait_for(&standby, "startup", 200, SOON);
    assert_eq!(statuses(&standby), [200, 503, 200]);
    assert!(probe(&standby, "ready").unwrap().body.contains("stands by"));
    assert_eq!(Metrics::of(&standby).value("gonio_coordinator_phase{phase=\"standby\"}"), 1.0);
    let second_url = format!("http://{listen}");
    assert_eq!(health(&second_url, "").await, None, "one that stands by does not listen");

    // The owner drains: what runs keeps it for its grace, and meanwhile nobody is sent to it.
    let _client = submit(&cluster.url);
    let queued = || Metrics::of(&owner).value("gonio_coordinator_tasks_queued");
    let begin = std::time::Instant::now();
    while queued() == 0.0 {
        assert!(begin.elapsed() < SOON, "nothing was submitted");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    cluster.coordinator.signal("TERM");
    assert!(wait_for(&owner, "ready", 503, Duration::from_secs(2)).contains("drains"));
    assert_eq!(probe(&owner, "live").unwrap().status, 200);
    assert_eq!(health(&cluster.url, "").await, Some(ServingStatus::NotServing));
    assert_eq!(health(&cluster.url, FARM).await, Some(ServingStatus::NotServing));
    assert_eq!(Metrics::of(&owner).value("gonio_coordinator_phase{phase=\"draining\"}"), 1.0);

    wait_for(&standby, "ready", 200, Duration::from_secs(20));
    assert_eq!(health(&second_url, FARM).await, Some(ServingStatus::Serving));
    // The evaluation was written down, and is its own now.
    assert!(Metrics::of(&standby).value("gonio_coordinator_evaluations_open") >= 1.0);

    // A process that stands still answers nothing, which is what kills it.
    second.signal("STOP");
    assert_eq!(ask(&standby, "/healthz/live", Duration::from_secs(1)), None);
    second.signal("CONT");
    wait_for(&standby, "live", 200, SOON);
    assert!(second.terminate().success());
}

#[tokio::test]
async fn health_asks_for_no_token_where_everything_else_does() {
    let folder = tempfile::tempdir().unwrap();
    let tokens = folder.path().join("tokens");
    let tokens = tokens.to_str().unwrap();
    let made = command("gonio-coordinator", &["token", "a", "--roles", "watch", "--tokens", tokens]).status();
    assert!(made.unwrap().success());
    let cluster = Cluster::start_with_more(&["--tokens", tokens], 0);
    assert_eq!(health(&cluster.url, FARM).await, Some(ServingStatus::Serving));
    let url = cluster.url.clone();
    let refused = tokio::task::spawn_blocking(move || Farm::connect(&url).err().unwrap().to_string());
    assert!(refused.await.unwrap().contains("--token"));
}

#[test]
fn a_worker_is_ready_while_a_coordinator_has_it_and_alive_without() {
    let (listen, operations) = (free_address(), free_address());
    let url = format!("http://{listen}");
    let worker = ["--coordinator", &url, "--threads", "1", "--operations", &operations, "--name", "w\"1"];
    let mut worker = Process::start("gonio-worker", &worker);
    wait_for(&operations, "startup", 200, SOON);
    assert_eq!(statuses(&operations), [200, 503, 200]);
    assert_eq!(Metrics::of(&operations).value("gonio_worker_accepted"), 0.0);

    let coordinator = ["--listen", &listen, "--store", "memory://"];
    let first = Process::start("gonio-coordinator", &coordinator);
    wait_for(&operations, "ready", 200, Duration::from_secs(20));
    let metrics = Metrics::of(&operations);
    assert!(metrics.value("gonio_worker_reconnects_total") >= 1.0);
    assert_eq!(metrics.value("gonio_worker_accepted"), 1.0);
    drop(first);
    wait_for(&operations, "ready", 503, Duration::from_secs(20));
    assert_eq!(probe(&operations, "live").unwrap().status, 200);
    let _second = Process::start("gonio-coordinator", &coordinator);
    wait_for(&operations, "ready", 200, Duration::from_secs(30));
    assert!(worker.terminate().success());
}

/// Runs `promtool check metrics` where there is one.
fn check_by_promtool(text: &str) {
    let promtool = Command::new("promtool").args(["check", "metrics"]).stdin(Stdio::piped()).spawn();
    let Ok(mut promtool) = promtool else {
        println!("skipped: there is no promtool here");
        return;
    };
    promtool.stdin.take().unwrap().write_all(text.as_bytes()).unwrap();
    assert!(promtool.wait().unwrap().success(), "promtool finds fault with {text}");
}

/// The names of metrics in the dashboard's queries.
fn names_of_dashboard() -> BTreeSet<String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../k8s/grafana/dashboard.json");
    let dashboard: serde_json::Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    let panels = dashboard["panels"].as_array().unwrap().iter();
    let targets = panels.flat_map(|panel| panel["targets"].as_array().into_iter().flatten());
    let queries: Vec<&str> = targets.map(|target| target["expr"].as_str().unwrap()).collect();
    assert!(queries.len() > 20);
    let words = queries.iter().flat_map(|query| query.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')));
    words.filter(|word| word.starts_with("gonio_")).map(str::to_owned).collect()
}

#[test]
fn metrics_add_up_pass_promtool_and_are_those_of_the_dashboard() {
    let mut cluster = Cluster::start_with_more(&["--operations", "127.0.0.1:0"], 0);
    let coordinator = cluster.port("operations").to_owned();
    let workers = [free_address(), free_address()];
    for (name, operations) in ["left", "right"].into_iter().zip(&workers) {
        cluster.add_worker_with(&["--operations", operations, "--name", name]);
        wait_for(operations, "ready", 200, SOON);
    }
    fitted(&Farm::connect(&cluster.url).unwrap(), &mut || ());
    // What was rendered twice is cancelled, or comes late: nothing moves any more once all is over.
    let mut metrics = Metrics::of(&coordinator);
    let begin = std::time::Instant::now();
    while metrics.value("gonio_coordinator_evaluations_open") > 0.0 {
        assert!(begin.elapsed() < SOON, "evaluations stay open: {}", metrics.text);
        std::thread::sleep(Duration::from_millis(50));
        metrics = Metrics::of(&coordinator);
    }
    let value = |name: &str| metrics.value(&format!("gonio_coordinator_{name}"));
    let done = value("tasks_done_total");
    assert!(done > 100.0, "{done}");
    assert_eq!((value("tasks_queued"), value("tasks_leased")), (0.0, 0.0));
    assert_eq!((value("workers_connected"), value("worker_slots")), (2.0, 2.0));
    assert_eq!(value("task_render_seconds_count"), done);
    assert_eq!(value("task_render_seconds_bucket{le=\"+Inf\"}"), done);
    let by_worker = metrics.sum("gonio_coordinator_worker_camera_samples_total");
    assert!(by_worker > 1e5 && by_worker == value("camera_samples_total"), "{by_worker}");
    let time = metrics.sum("gonio_coordinator_worker_render_seconds_total");
    assert!((time - value("task_render_seconds_sum")).abs() < 1e-3 * time, "{time}");
    assert!(metrics.value("gonio_coordinator_worker_camera_samples_total{worker=\"left\"}") > 0.0);
    for series in ["received_bytes_total{what=\"films\"}", "sent_bytes_total{what=\"answers\"}"] {
        assert!(value(series) > 1e4, "{series}: {}", value(series));
    }
    let uploaded = value("received_bytes_total{what=\"files\"}");
    assert!(uploaded > 1e3 && value("sent_bytes_total{what=\"files\"}") > 1e3);

    let of_workers = workers.each_ref().map(|operations| Metrics::of(operations));
    let sum = |name: &str| of_workers.iter().map(|m| m.sum(name)).sum::<f64>();
    let rendered: f64 = of_workers.iter().map(|m| m.value("gonio_worker_tasks_total{outcome=\"rendered\"}")).sum();
    let refused = metrics.sum("gonio_coordinator_results_refused_total");
    // What was rendered was accepted, or refused, or its evaluation was over before it was sent.
    assert!(rendered >= done && rendered <= done + refused + value("second_attempts_total"), "{rendered} of {done}");
    assert!(sum("gonio_worker_camera_samples_total") >= by_worker);
    assert_eq!(sum("gonio_worker_fetched_bytes_total"), value("sent_bytes_total{what=\"files\"}"));
    assert_eq!(sum("gonio_worker_cache_bytes"), sum("gonio_worker_fetched_bytes_total"), "all is kept");

    check_by_promtool(&metrics.text);
    check_by_promtool(&of_workers[0].text);
    let mut served = metrics.names();
    of_workers.iter().for_each(|m| served.extend(m.names()));
    for name in names_of_dashboard() {
        assert!(served.contains(name.as_str()), "the dashboard asks for {name}, which nobody serves");
    }
}

#[test]
fn every_program_says_which_build_it_is_and_logs_json_if_told_to() {
    let mut versions = BTreeSet::new();
    for program in ["gonio-coordinator", "gonio-worker", "gonio"] {
        let output = command(program, &["--version"]).output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        let version = text.trim().strip_prefix(program).unwrap().trim().to_owned();
        let (number, commit) = version.split_once(' ').unwrap();
        assert_eq!(number, gonio_proto::VERSION);
        let commit = commit.strip_prefix('(').unwrap().strip_suffix(')').unwrap();
        let digits = commit.len() >= 7 && commit.bytes().all(|digit| digit.is_ascii_hexdigit());
        assert!(digits || commit == "unknown" || std::env::var("GONIO_COMMIT").is_ok(), "{text}");
        versions.insert(version);
    }
    assert_eq!(versions.len(), 1, "{versions:?}");

    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("log");
    let mut cluster = Cluster::start_logged(&["--log", "json"], &log);
    let worker_log = folder.path().join("worker");
    cluster.add_logged_worker(&["--log", "json"], &[("RUST_LOG", "info")], &worker_log);
    fitted(&Farm::connect(&cluster.url).unwrap(), &mut || ());
    assert!(cluster.workers[0].terminate().success());
    assert!(cluster.coordinator.terminate().success());
    for (log, expected) in [(log, "worker joined"), (worker_log, "connected")] {
        let text = std::fs::read_to_string(&log).unwrap();
        let lines: Vec<serde_json::Value> = text.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
        let event = lines.iter().find(|line| line["message"] == expected).unwrap();
        assert!(event["timestamp"].is_string() && event["level"] == "INFO" && event["target"].is_string());
    }
}
