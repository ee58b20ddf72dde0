//! The farm as real processes: `gonio`, `gonio-coordinator` and `gonio-worker`, as a user starts them.
//!
//! A render and a fit must have the same bits embedded with one thread and with two, on one worker process, on two, and on
//! two of which one is killed (SIGKILL) half way.

use gonio_tests::captures;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// A program of this workspace, next to the tests' own folder; built where `cargo test -p` left it out.
fn program(name: &str) -> PathBuf {
    let exe = std::env::current_exe().unwrap();
    let folder = exe.parent().unwrap().parent().unwrap();
    let path = folder.join(name);
    if !path.exists() {
        let release = folder.ends_with("release");
        let mut cargo = Command::new(env!("CARGO"));
        cargo.args(["build", "--offline", "--workspace", "--bins"]).args(release.then_some("--release"));
        assert!(cargo.status().unwrap().success());
    }
    path
}

/// A child process that does not outlive the test.
struct Process(Child);

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

struct Cluster {
    _coordinator: Process,
    workers: Vec<Process>,
    url: String,
    _store: tempfile::TempDir,
}

impl Cluster {
    fn start(workers: usize) -> Self {
        let store = tempfile::tempdir().unwrap();
        let mut coordinator = Command::new(program("gonio-coordinator"))
            .args(["--listen", "127.0.0.1:0", "--store"])
            .arg(store.path().join("objects"))
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(coordinator.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let address = line.split_whitespace().find(|word| word.contains("127.0.0.1:")).expect("no address printed");
        let url = format!("http://{}", address.trim_start_matches("http://"));
        let workers = (0..workers)
            .map(|_| {
                let mut worker = Command::new(program("gonio-worker"));
                Process(worker.args(["--coordinator", &url, "--threads", "1"]).spawn().unwrap())
            })
            .collect();
        Self { _coordinator: Process(coordinator), workers, url, _store: store }
    }
}

fn gonio(arguments: &[&str], out: &Path) -> Command {
    let mut command = Command::new(program("gonio"));
    command.args(arguments).arg("--out").arg(out).stdout(Stdio::null()).stderr(Stdio::piped());
    command
}

fn succeed(mut command: Command) {
    let out = command.output().unwrap();
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
}

/// What must not depend on who rendered: every file of a render, and the numbers of a fit.
#[derive(PartialEq)]
struct Answer {
    films: Vec<(String, Vec<u8>)>,
    parameters: serde_json::Value,
    loss: serde_json::Value,
}

fn fit_arguments(capture: &str) -> Vec<&str> {
    vec!["fit", capture, "--samples", "16", "--seed", "5"]
}

/// Renders and fits with `extra` arguments; `during` runs while the fit does.
fn answer(extra: &[&str], during: &mut dyn FnMut()) -> Answer {
    let folder = captures().join("none-202");
    let capture = folder.to_str().unwrap();
    let out = tempfile::tempdir().unwrap();
    let (rendered, fitted) = (out.path().join("render"), out.path().join("fit"));
    let mut arguments = vec!["render", capture, "--samples", "8", "--seed", "5", "--buffers", "--photos", "00,03"];
    arguments.extend(extra);
    succeed(gonio(&arguments, &rendered));
    let mut arguments = fit_arguments(capture);
    arguments.extend(extra);
    let child = gonio(&arguments, &fitted).spawn().unwrap();
    during();
    let done = child.wait_with_output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let mut films: Vec<_> = std::fs::read_dir(&rendered)
        .unwrap()
        .map(|e| e.unwrap().path())
        .map(|p| (p.file_name().unwrap().to_string_lossy().into_owned(), std::fs::read(&p).unwrap()))
        .collect();
    films.sort();
    assert_eq!(films.len(), 4, "two photos and their first-hit buffers");
    let text = std::fs::read_to_string(fitted.join("fit.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    Answer { films, parameters: json["parameters"].clone(), loss: json["loss_curve"].clone() }
}

#[test]
fn the_same_bits_whoever_renders() {
    let one = answer(&["--threads", "1"], &mut || ());
    assert!(one.parameters[0]["value"].is_f64());
    let mut same = |what: &str, other: &Answer| {
        assert!(one.films == other.films, "{what}: the films differ");
        assert_eq!(one.parameters, other.parameters, "{what}");
        assert_eq!(one.loss, other.loss, "{what}");
    };
    same("two threads", &answer(&["--threads", "2"], &mut || ()));
    for workers in [1, 2] {
        let cluster = Cluster::start(workers);
        same(&format!("{workers} worker processes"), &answer(&["--farm", &cluster.url], &mut || ()));
    }
    let mut cluster = Cluster::start(2);
    let mut victim = cluster.workers.pop().unwrap();
    let url = cluster.url.clone();
    let killed = answer(&["--farm", &url], &mut || {
        std::thread::sleep(Duration::from_millis(1200));
        assert!(victim.0.try_wait().unwrap().is_none(), "the worker ended before it was killed");
        victim.0.kill().unwrap();
        victim.0.wait().unwrap();
    });
    same("two worker processes, one killed", &killed);
}
