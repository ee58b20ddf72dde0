//! A coordinator that is killed, in the middle of an evaluation, a fit and a sweep: the next one over the same store goes on,
//! the client notices nothing but the time, and every bit is that of an undisturbed run.

#![allow(clippy::unwrap_used)] // Its helpers may do what its tests may.
#![cfg(unix)]

use gonio::farm::Farm;
use gonio_fit::evaluate::Evaluate;
use gonio_scene::{Capture, Evaluation, EvaluationRequest, Output};
use gonio_tests::cluster::{Cluster, PROGRAMS, files, fitted};
use std::ops::ControlFlow;
use std::process::Command;
use std::time::{Duration, Instant};

fn request() -> EvaluationRequest {
    let capture = Capture::read(&files()).unwrap();
    let columns = capture.free_parameters().unwrap();
    let output = Output::StatisticsAndFilms;
    EvaluationRequest { columns, photos: vec![0, 3], samples: 260, seed: 9, output, ..EvaluationRequest::default() }
}

/// The answer; `seen` is told how far it is.
fn evaluate(farm: &Farm, seen: &mut dyn FnMut(f64)) -> Evaluation {
    let mut open = farm.open(&files()).unwrap();
    let answer = open.evaluate(&request(), &mut |progress| {
        seen(progress.tasks_done as f64 / progress.tasks.max(1) as f64);
        ControlFlow::Continue(())
    });
    answer.unwrap()
}

#[test]
fn an_evaluation_survives_three_coordinators() {
    let expected = evaluate(&Farm::embedded(2).unwrap(), &mut |_| ());
    let store = tempfile::tempdir().unwrap();
    let mut cluster = Cluster::durable(store.path(), 2);
    let farm = Farm::connect(&cluster.url).unwrap();
    let (mut kills, mut restored) = (0, 0.0);
    let answer = evaluate(&farm, &mut |done| {
        if kills > 0 && restored == 0.0 && done > 0.0 {
            restored = done;
        }
        if kills < 3 && done > 0.25 * f64::from(kills + 1) {
            kills += 1;
            cluster.replace_coordinator(store.path());
        }
    });
    assert_eq!((kills, &answer), (3, &expected));
    // What was reduced before the first kill did not begin again.
    assert!(restored > 0.1, "{restored}");
    // It is over: nothing is left for a fourth.
    let journal = store.path().join("journal/segments");
    let begin = Instant::now();
    while std::fs::read_dir(&journal).unwrap().count() > 1 {
        assert!(begin.elapsed() < Duration::from_secs(20));
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn a_fit_survives_a_coordinator() {
    let expected = fitted(&Farm::embedded(2).unwrap(), &mut || ());
    let store = tempfile::tempdir().unwrap();
    let mut cluster = Cluster::durable(store.path(), 2);
    let farm = Farm::connect(&cluster.url).unwrap();
    assert_eq!(fitted(&farm, &mut || cluster.replace_coordinator(store.path())), expected);
}

#[test]
fn a_standby_takes_over_within_30_s() {
    let expected = evaluate(&Farm::embedded(2).unwrap(), &mut |_| ());
    let store = tempfile::tempdir().unwrap();
    let cluster = Cluster::durable(store.path(), 2);
    let _standby = cluster.another_coordinator(store.path(), &["--standby"]);
    let farm = Farm::connect(&cluster.url).unwrap();
    let mut killed: Option<Instant> = None;
    let answer = evaluate(&farm, &mut |done| {
        if killed.is_none() && done > 0.3 {
            cluster.coordinator.signal("KILL");
            killed = Some(Instant::now());
        }
    });
    assert_eq!(answer, expected);
    // From the kill to the end of the evaluation.
    assert!(killed.unwrap().elapsed() < Duration::from_secs(30));
}

#[test]
fn whoever_is_replaced_stops_and_says_why() {
    let store = tempfile::tempdir().unwrap();
    let mut cluster = Cluster::durable(store.path(), 1);
    let arguments = ["--listen", "127.0.0.1:0", "--store", store.path().to_str().unwrap()];
    let _next = gonio_tests::cluster::Process::start("gonio-coordinator", &arguments);
    let status = cluster.coordinator.wait_for(Duration::from_secs(30));
    assert_eq!(status.and_then(|status| status.code()), Some(1));
}

#[test]
fn jobs_are_listed_followed_and_cancelled() {
    let cluster = Cluster::start(1);
    let gonio = |arguments: &[&str]| {
        let output =
            Command::new(PROGRAMS.join("gonio")).args(arguments).args(["--farm", &cluster.url]).output().unwrap();
        let texts = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
        (output.status.code(), texts)
    };
    let out = tempfile::tempdir().unwrap();
    let capture = gonio_tests::captures().join("none-201");
    let mut fit = Command::new(PROGRAMS.join("gonio"));
    fit.args(["fit", capture.to_str().unwrap(), "--samples", "65536", "--farm", &cluster.url, "--out"]).arg(out.path());
    let fit = fit.stderr(std::process::Stdio::piped()).spawn().unwrap();
    let client = loop {
        let (code, [stdout, stderr]) = gonio(&["jobs", "--json"]);
        assert_eq!(code, Some(0), "{stderr}");
        let jobs: serde_json::Value = serde_json::from_str(&stdout).unwrap();
        if let Some(client) = jobs["clients"][0]["client"].as_str() {
            assert_eq!(jobs["workers"], 1);
            break client.to_owned();
        }
        std::thread::sleep(Duration::from_millis(50));
    };
    assert!(client.starts_with("fit-"), "{client}");
    let mut cancelled = Some(1);
    // Between two evaluations it has none.
    while cancelled != Some(0) {
        cancelled = gonio(&["cancel", &client]).0;
    }
    let output = fit.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", String::from_utf8_lossy(&output.stderr));
    let (code, [_, stderr]) = gonio(&["cancel", "nobody"]);
    assert!(code == Some(2) && stderr.contains("has nothing under way"), "{stderr}");
    let (code, [_, stderr]) = gonio(&["attach", "nobody"]);
    assert!(code == Some(2) && stderr.contains("has nothing under way"), "{stderr}");
}
