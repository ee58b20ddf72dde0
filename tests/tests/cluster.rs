//! The real programs on real sockets: a coordinator, workers, a client, and SIGKILL.
//!
//! What must hold is equality to the last bit: of films, statistics and a whole fit, for the embedded farm with one and
//! two threads, one worker process, two, and two of which one is killed half way.

#![allow(clippy::unwrap_used)] // Its helpers may do what its tests may.
#![cfg(unix)]

use gonio::farm::Farm;
use gonio_fit::evaluate::Evaluate;
use gonio_scene::{Capture, Evaluation, EvaluationRequest, Output};
use gonio_tests::cluster::{Cluster, PROGRAMS, Process, files, fitted};
use std::ops::ControlFlow;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

fn request(output: Output) -> EvaluationRequest {
    let capture = Capture::read(&files()).unwrap();
    let columns = capture.free_parameters().unwrap();
    EvaluationRequest {
        numbers: vec![],
        columns,
        photos: vec![0, 3],
        samples: 132,
        difference_samples: 0,
        forward_samples: 0,
        seed: 9,
        output,
    }
}

/// Every bit of an answer.
fn bits(evaluation: &Evaluation) -> Vec<u64> {
    let mut bits = vec![evaluation.primary_samples];
    for s in &evaluation.photos {
        bits.extend([s.photo as u64, s.observations, s.invalid_samples]);
        let sums = [s.noise_floor, s.render_noise, s.squared_error, s.log_variance, s.peak];
        bits.extend(s.gram.iter().chain(&sums).map(|v| v.to_bits()));
    }
    bits.extend(evaluation.films.iter().flat_map(|f| &f.channels).flatten().map(|v| u64::from(v.to_bits())));
    bits
}

/// Films and statistics; half way through, `half_way` is called once.
fn evaluate(farm: &Farm, output: Output, half_way: &mut dyn FnMut()) -> Vec<u64> {
    let mut open = farm.open(&files()).unwrap();
    let mut called = false;
    let answer = open.evaluate(&request(output), &mut |progress| {
        if !called && progress.tasks > 0 && 2 * progress.tasks_done >= progress.tasks {
            called = true;
            half_way();
        }
        ControlFlow::Continue(())
    });
    assert!(called);
    bits(&answer.unwrap())
}

#[test]
fn films_have_the_same_bits_however_they_are_farmed() {
    for output in [Output::StatisticsAndFilms, Output::FirstHit] {
        let expected = evaluate(&Farm::embedded(1).unwrap(), output, &mut || ());
        assert_eq!(evaluate(&Farm::embedded(2).unwrap(), output, &mut || ()), expected, "two threads");
        for workers in [1, 2] {
            let cluster = Cluster::start(workers);
            let farm = Farm::connect(&cluster.url).unwrap();
            assert_eq!(evaluate(&farm, output, &mut || ()), expected, "{workers} worker processes");
        }
        let mut cluster = Cluster::start(2);
        let farm = Farm::connect(&cluster.url).unwrap();
        let kill = &mut || drop(cluster.workers.pop());
        assert_eq!(evaluate(&farm, output, kill), expected, "one of two killed");
        assert_eq!(cluster.workers.len(), 1);
    }
}

#[test]
fn a_fit_has_the_same_bits_however_it_is_farmed() {
    let expected = fitted(&Farm::embedded(1).unwrap(), &mut || ());
    assert_eq!(fitted(&Farm::embedded(2).unwrap(), &mut || ()), expected, "two threads");
    for workers in [1, 2] {
        let cluster = Cluster::start(workers);
        assert_eq!(fitted(&Farm::connect(&cluster.url).unwrap(), &mut || ()), expected, "{workers} worker processes");
    }
    let mut cluster = Cluster::start(2);
    let farm = Farm::connect(&cluster.url).unwrap();
    assert_eq!(fitted(&farm, &mut || drop(cluster.workers.pop())), expected, "one of two killed");
}

#[test]
fn all_workers_may_be_lost_and_others_come() {
    let expected = evaluate(&Farm::embedded(2).unwrap(), Output::Statistics, &mut || ());
    let mut cluster = Cluster::start(2);
    let farm = Farm::connect(&cluster.url).unwrap();
    let replace = &mut || {
        cluster.workers.clear();
        cluster.add_worker();
    };
    assert_eq!(evaluate(&farm, Output::Statistics, replace), expected);
}

#[test]
fn a_worker_that_is_paused_is_done_without_and_taken_back() {
    let expected = evaluate(&Farm::embedded(2).unwrap(), Output::Statistics, &mut || ());
    let cluster = Cluster::start(2);
    let farm = Farm::connect(&cluster.url).unwrap();
    assert_eq!(evaluate(&farm, Output::Statistics, &mut || cluster.workers[0].signal("STOP")), expected);
    cluster.workers[0].signal("CONT");
    // The other is gone for good: the one that was paused does it alone.
    cluster.workers[1].signal("KILL");
    assert_eq!(evaluate(&farm, Output::Statistics, &mut || ()), expected);
}

#[test]
fn a_worker_that_is_told_to_stop_loses_nothing() {
    let expected = evaluate(&Farm::embedded(2).unwrap(), Output::Statistics, &mut || ());
    let mut cluster = Cluster::start(2);
    let farm = Farm::connect(&cluster.url).unwrap();
    let mut codes = Vec::new();
    let stop = &mut || codes.push(cluster.workers[0].terminate().code());
    assert_eq!(evaluate(&farm, Output::Statistics, stop), expected);
    assert_eq!(codes, [Some(0)]);
}

#[test]
fn a_coordinator_that_is_told_to_stop_finishes_or_says_so() {
    let expected = evaluate(&Farm::embedded(2).unwrap(), Output::Statistics, &mut || ());
    let cluster = Cluster::start(1);
    let farm = Farm::connect(&cluster.url).unwrap();
    assert_eq!(evaluate(&farm, Output::Statistics, &mut || cluster.coordinator.signal("TERM")), expected);

    let mut cluster = Cluster::start_with_more(&["--grace", "0"], 1);
    let mut open = Farm::connect(&cluster.url).unwrap().open(&files()).unwrap();
    let mut told = false;
    let answer = open.evaluate(&request(Output::Statistics), &mut |progress| {
        if !std::mem::replace(&mut told, progress.tasks_done > 0) && progress.tasks_done > 0 {
            cluster.coordinator.signal("TERM");
        }
        ControlFlow::Continue(())
    });
    let text = answer.unwrap_err().to_string();
    assert!(text.contains("the coordinator stops; ask again"), "{text}");
    assert_eq!(cluster.coordinator.terminate().code(), Some(0));
}

#[test]
fn a_worker_waits_for_a_coordinator_and_both_stop_when_told() {
    let folder = std::env::temp_dir().join(format!("gonio-cluster-{}", std::process::id()));
    let mut cluster = Cluster::start_with(folder.to_str().unwrap(), 0);
    let address = cluster.url.strip_prefix("http://").unwrap().to_owned();
    assert_eq!(cluster.coordinator.terminate().code(), Some(0));
    // The worker comes first this time, and finds nobody.
    cluster.add_worker();
    std::thread::sleep(Duration::from_millis(300));
    let arguments = ["--listen", &address, "--store", folder.to_str().unwrap()];
    cluster.coordinator = Process::start("gonio-coordinator", &arguments);
    let start = Instant::now();
    let farm = loop {
        match Farm::connect(&cluster.url) {
            Ok(farm) => break farm,
            Err(error) => assert!(start.elapsed() < Duration::from_secs(60), "{error}"),
        }
    };
    evaluate(&farm, Output::FirstHit, &mut || ());
    assert_eq!(cluster.workers[0].terminate().code(), Some(0));
    assert_eq!(cluster.coordinator.terminate().code(), Some(0));
    // What was sent once is in the folder.
    assert!(folder.join("blob/sha256").is_dir());
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_worker_reads_the_store_and_asks_the_coordinator_for_what_is_not_there() {
    let top = std::env::temp_dir().join(format!("gonio-stores-{}", std::process::id()));
    let [shared, empty] = ["shared", "empty"].map(|name| top.join(name));
    std::fs::create_dir_all(&empty).unwrap();
    let expected = evaluate(&Farm::embedded(1).unwrap(), Output::Statistics, &mut || ());
    let answer_and_log = |store: &Path| {
        let mut cluster = Cluster::start_with(shared.to_str().unwrap(), 0);
        let log = top.join("log");
        cluster.add_logged_worker(&["--store", store.to_str().unwrap()], &[], &log);
        let answer = evaluate(&Farm::connect(&cluster.url).unwrap(), Output::Statistics, &mut || ());
        (answer, std::fs::read_to_string(&log).unwrap())
    };
    let (fetched, asked) = ("fetched from the store", "asking the coordinator");
    let (answer, log) = answer_and_log(&shared);
    assert_eq!(answer, expected);
    assert!(log.contains(fetched) && !log.contains(asked), "{log}");
    let (answer, log) = answer_and_log(&empty);
    assert_eq!(answer, expected);
    assert!(!log.contains(fetched) && log.contains(asked), "{log}");
    std::fs::remove_dir_all(top).unwrap();
}

#[test]
fn arguments_that_make_no_sense_are_one_clear_line() {
    let fails = |program: &str, arguments: &[&str], expected: &str| {
        let output = Command::new(PROGRAMS.join(program)).args(arguments).output().unwrap();
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && text.contains(expected), "{text}");
    };
    fails("gonio-coordinator", &["--store", "ftp://x"], "is of an unknown kind, ftp; write a folder");
    fails("gonio-coordinator", &["--listen", "nowhere", "--store", "memory://"], "cannot listen on nowhere");
    fails("gonio-worker", &["--coordinator", "not a url"], "write http://HOST:PORT");
    fails("gonio-worker", &[], "--coordinator");
    let worker = |store| ["--coordinator", "http://127.0.0.1:1", "--store", store];
    fails("gonio-worker", &worker("memory://"), "only the coordinator sees its memory");
    fails("gonio-worker", &worker("/no/such/folder"), "/no/such/folder: is no folder here; mount");
    fails("gonio-worker", &worker("ftp://x"), "is of an unknown kind, ftp");
}
