//! One trace for an evaluation, from the client through the coordinator to every task on two workers, by the real programs
//! and what a real OTLP collector hears of them. `cargo test --test traces --features otel`; without the feature it skips.

#![allow(missing_docs)]
#![cfg(unix)]

#[cfg(not(feature = "otel"))]
#[test]
fn an_evaluation_is_one_trace() {
    println!("skipped: the programs are built without their feature otel");
}

#[cfg(feature = "otel")]
#[path = "traces/collector.rs"]
mod collector;

#[cfg(feature = "otel")]
mod with_otel {
    #![allow(clippy::unwrap_used)]

    use super::collector::Collector;
    use gonio_tests::cluster::{Cluster, command};
    use gonio_tests::operations::{Metrics, free_address};
    use std::collections::BTreeSet;
    use std::time::Duration;

    #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
    async fn an_evaluation_is_one_trace() {
        let collector = Collector::start().await;
        let environment = [("OTEL_EXPORTER_OTLP_ENDPOINT", collector.url.as_str())];
        let arguments = ["--store", "memory://", "--operations", "127.0.0.1:0"];
        let mut cluster = Cluster::start_by(&arguments, 0, &environment);
        let folder = tempfile::tempdir().unwrap();
        let workers = [free_address(), free_address()];
        for operations in &workers {
            let log = folder.path().join("worker");
            cluster.add_logged_worker(&["--operations", operations], &environment, &log);
        }
        let (capture, out) = (gonio_tests::captures().join("none-201"), folder.path().join("out"));
        let arguments = ["render", capture.to_str().unwrap(), "--farm", &cluster.url, "--out", out.to_str().unwrap()];
        let mut render = command("gonio", &[&arguments[..], &["--samples", "8"]].concat());
        assert!(render.envs(environment).status().unwrap().success());
        let begun = |m: &Metrics| m.sum("gonio_worker_tasks_total");
        let tasks: f64 = workers.iter().map(|operations| begun(&Metrics::of(operations))).sum();
        // Each sends its last spans when it ends.
        assert!(cluster.workers.iter_mut().all(|worker| worker.terminate().success()));
        assert!(cluster.coordinator.terminate().success());
        tokio::time::sleep(Duration::from_millis(200)).await;

        let spans = collector.spans();
        let of = |service: &str, name: &str| {
            spans.iter().filter(|s| s.service == service && s.name == name).cloned().collect::<Vec<_>>()
        };
        let (asked, ran) = (of("gonio", "evaluate"), of("gonio-coordinator", "evaluation"));
        let rendered = of("gonio-worker", "task");
        assert!(!asked.is_empty() && tasks > 0.0, "{spans:?}");
        assert_eq!((ran.len(), rendered.len() as f64), (asked.len(), tasks));
        for run in &ran {
            let parent = asked.iter().find(|ask| ask.id == run.parent).unwrap();
            assert_eq!(parent.trace, run.trace);
            // The evaluation lasts for as long as its client listens.
            assert!(parent.begin <= run.begin);
        }
        for task in &rendered {
            let parent = ran.iter().find(|run| run.id == task.parent).unwrap();
            assert_eq!(parent.trace, task.trace);
            assert!(parent.begin <= task.begin && task.begin <= task.end);
        }
        let ids: BTreeSet<_> = spans.iter().map(|span| &span.id).collect();
        assert_eq!(ids.len(), spans.len());
        assert!(asked.iter().all(|ask| ask.parent.is_empty()), "nobody asked the client");
    }
}
