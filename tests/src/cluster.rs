//! The real programs as processes: a coordinator, its workers, and what is done with them.

use crate::captures;
use gonio::farm::Farm;
use gonio_fit::{FitEvent, Options, fit};
use gonio_scene::Capture;
use gonio_scene::files::DirectoryFiles;
use std::io::{BufRead, BufReader};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::LazyLock;

/// The folder of the programs, built as this test was: `cargo test` of this crate alone would not have built them.
pub static PROGRAMS: LazyLock<PathBuf> = LazyLock::new(|| {
    let test = std::env::current_exe().unwrap();
    let folder = test.ancestors().nth(2).unwrap().to_owned();
    let release = folder.ends_with("release");
    let built = Command::new(env!("CARGO"))
        .args(["build", "--quiet", "--bin", "gonio", "--bin", "gonio-coordinator", "--bin", "gonio-worker"])
        .args(cfg!(feature = "s3").then_some("--features=gonio/s3,gonio-coordinator/s3,gonio-worker/s3"))
        .args(cfg!(feature = "otel").then_some("--features=gonio/otel,gonio-coordinator/otel,gonio-worker/otel"))
        .args(release.then_some("--release"))
        .arg("--target-dir")
        .arg(folder.parent().unwrap())
        .current_dir(env!("CARGO_MANIFEST_DIR").to_owned() + "/..")
        .status();
    assert!(built.unwrap().success());
    folder
});

/// One of our programs, its standard output to be read.
pub fn command(program: &str, arguments: &[&str]) -> Command {
    let mut command = Command::new(PROGRAMS.join(program));
    command.args(arguments).stdout(Stdio::piped());
    command
}

/// A program that dies with the test.
pub struct Process(Child);

impl Process {
    pub fn start(program: &str, arguments: &[&str]) -> Self {
        Self::spawn(command(program, arguments).env("RUST_LOG", "error"))
    }

    pub fn spawn(command: &mut Command) -> Self {
        Self(command.spawn().unwrap())
    }

    /// Its number for the system.
    pub fn id(&self) -> u32 {
        self.0.id()
    }

    /// SIGTERM; how it ended.
    pub fn terminate(&mut self) -> ExitStatus {
        self.signal("TERM");
        self.0.wait().unwrap()
    }

    /// How it ends by itself; `None` if it does not in this time.
    pub fn wait_for(&mut self, patience: std::time::Duration) -> Option<ExitStatus> {
        let begin = std::time::Instant::now();
        while begin.elapsed() < patience {
            if let Some(status) = self.0.try_wait().unwrap() {
                return Some(status);
            }
            std::thread::sleep(std::time::Duration::from_millis(20));
        }
        None
    }

    /// Sends a signal by its name, such as `STOP`.
    pub fn signal(&self, name: &str) {
        let (name, id) = (format!("-{name}"), self.0.id().to_string());
        assert!(Command::new("kill").args([&name, &id]).status().unwrap().success());
    }
}

impl From<Child> for Process {
    fn from(child: Child) -> Self {
        Self(child)
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // Already gone is as good.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A coordinator and its workers.
pub struct Cluster {
    pub workers: Vec<Process>,
    pub coordinator: Process,
    pub url: String,
    /// What the coordinator printed before it began.
    said: String,
}

impl Cluster {
    pub fn start(workers: usize) -> Self {
        Self::start_with("memory://", workers)
    }

    pub fn start_with(store: &str, workers: usize) -> Self {
        Self::start_in(store, workers, &[])
    }

    /// A coordinator with further environment variables.
    pub fn start_in(store: &str, workers: usize, environment: &[(&str, &str)]) -> Self {
        Self::start_by(&["--store", store], workers, environment)
    }

    /// A coordinator with further arguments.
    pub fn start_with_more(more: &[&str], workers: usize) -> Self {
        Self::start_by(&[&["--store", "memory://"], more].concat(), workers, &[])
    }

    pub fn start_by(arguments: &[&str], workers: usize, environment: &[(&str, &str)]) -> Self {
        let mut command = command("gonio-coordinator", &["--listen", "127.0.0.1:0"]);
        command.args(arguments).env("RUST_LOG", "error").envs(environment.iter().copied());
        Self::start_command(&mut command, workers)
    }

    /// A coordinator over memory with further arguments, without workers, which writes all that it can to a log.
    pub fn start_logged(arguments: &[&str], log: &Path) -> Self {
        let mut command = command("gonio-coordinator", &["--listen", "127.0.0.1:0", "--store", "memory://"]);
        command.args(arguments).env("RUST_LOG", "trace").stderr(std::fs::File::create(log).unwrap());
        Self::start_command(&mut command, 0)
    }

    fn start_command(command: &mut Command, workers: usize) -> Self {
        let mut coordinator = Process::spawn(command);
        let mut said = String::new();
        let mut lines = BufReader::new(coordinator.0.stdout.take().unwrap());
        // Further ports are named before the one that everybody comes to.
        let url = loop {
            let start = said.len();
            assert_ne!(lines.read_line(&mut said).unwrap(), 0, "the coordinator ended: {said}");
            if let Some(url) = said[start..].trim().strip_prefix("listening on ") {
                break url.to_owned();
            }
        };
        let mut cluster = Self { workers: Vec::new(), coordinator, url, said };
        for _ in 0..workers {
            cluster.add_worker();
        }
        cluster
    }

    /// Where the coordinator serves something else, by what it printed: `operations`, `scaler`.
    pub fn port(&self, what: &str) -> &str {
        let prefix = format!("{what} on ");
        self.said.lines().find_map(|line| line.strip_prefix(&prefix)).unwrap()
    }

    /// A coordinator over a folder, and its workers.
    pub fn durable(store: &Path, workers: usize) -> Self {
        Self::start_with(store.to_str().unwrap(), workers)
    }

    /// Kills the coordinator without a warning, and starts another at its address over the same store.
    pub fn replace_coordinator(&mut self, store: &Path) {
        self.coordinator.signal("KILL");
        self.coordinator = Process::spawn(&mut Command::new("true"));
        self.coordinator = self.another_coordinator(store, &[]);
    }

    /// One more coordinator at the same address, such as a standby.
    pub fn another_coordinator(&self, store: &Path, more: &[&str]) -> Process {
        let address = self.url.strip_prefix("http://").unwrap();
        let arguments = ["--listen", address, "--store", store.to_str().unwrap()];
        Process::start("gonio-coordinator", &[&arguments, more].concat())
    }

    pub fn add_worker(&mut self) {
        self.add_worker_with(&[]);
    }

    /// A worker with further arguments.
    pub fn add_worker_with(&mut self, more: &[&str]) {
        let arguments = ["--coordinator", &self.url, "--threads", "1"];
        self.workers.push(Process::start("gonio-worker", &[&arguments, more].concat()));
    }

    /// A worker with further arguments and environment variables, which writes its log to a file.
    pub fn add_logged_worker(&mut self, more: &[&str], environment: &[(&str, &str)], log: &Path) {
        let mut command = command("gonio-worker", &["--coordinator", &self.url, "--threads", "1"]);
        command.args(more).env("RUST_LOG", "gonio_worker=debug").envs(environment.iter().copied());
        command.stderr(std::fs::File::create(log).unwrap());
        self.workers.push(Process::spawn(&mut command));
    }
}

/// The capture that the cluster works on.
pub fn files() -> DirectoryFiles {
    DirectoryFiles::new(captures().join("none-201"))
}

/// A short fit; after its second iteration, `in_between` is called once. The bits of all parameters and errors.
pub fn fitted(farm: &Farm, in_between: &mut dyn FnMut()) -> Vec<u64> {
    let capture = Capture::read(&files()).unwrap();
    let mut open = farm.open(&files()).unwrap();
    let options = Options { seed: 4, max_samples: 16, max_iterations: Some(4), ..Options::default() };
    let mut iterations = 0;
    let mut observer = |event: &FitEvent| {
        if matches!(event, FitEvent::IterationDone(_)) {
            iterations += 1;
            if iterations == 2 {
                in_between();
            }
        }
        ControlFlow::Continue(())
    };
    let result = fit(&capture, &mut open, &options, &mut observer).unwrap();
    assert!(iterations >= 2);
    let numbers = result.parameters.iter().flat_map(|p| [Some(p.value), p.standard_error]);
    numbers.flatten().chain([result.fit.reduced_chi_square]).map(f64::to_bits).collect()
}
