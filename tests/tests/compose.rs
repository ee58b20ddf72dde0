//! The compose file in a Docker engine: a fit through it has the bits of an embedded run, and a sweep survives whatever befalls
//! its containers. Skipped, saying so, without an engine or without the images of this version (`k8s/images/build` makes them).

#![allow(clippy::unwrap_used)] // Its helpers may do what its tests may.
#![cfg(unix)]

use gonio_tests::captures;
use gonio_tests::cluster::PROGRAMS;
use gonio_tests::images::{self, docker, text};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Longest that anything may take.
const PATIENCE: Duration = Duration::from_secs(240);

const SWEEP: &str = "format = 1\ncapture = \"none-201\"\nsamples = 32\nresolution = 0.25\n[[design]]\nkind = \"sobol\"\n\
                     count = 300\naxes = [{ name = \"material.shell.roughness\", from = 0.2, to = 0.6 }]\n[[view]]\n\
                     name = \"dome\"\nkind = \"hemisphere\"\ntarget = [0.0, 0.0, 0.02]\nradius = 0.3\ncount = 4\n";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().unwrap()
}

/// Why the test cannot run here.
fn missing() -> Option<String> {
    let compose = text(Command::new("docker-compose").arg("version"));
    images::missing().or_else(|| compose.is_none().then(|| "there is no docker-compose".to_owned()))
}

/// The farm, which goes with the test.
struct Farm {
    top: tempfile::TempDir,
    project: String,
}

impl Farm {
    fn up() -> Self {
        let top = tempfile::tempdir().unwrap();
        let farm = Self { project: format!("gonio-test-{}", std::process::id()), top };
        let secrets = farm.path("secrets");
        assert!(text(Command::new(root().join("k8s/compose/certificates")).arg(&secrets)).is_some());
        for folder in ["out", "captures"] {
            std::fs::create_dir(farm.path(folder)).unwrap();
        }
        let copied = Command::new("cp").arg("-r").arg(captures().join("none-201")).arg(farm.path("captures")).status();
        assert!(copied.unwrap().success());
        std::fs::write(farm.path("captures/sweep.toml"), SWEEP).unwrap();
        farm.compose(&["up", "--detach", "--scale", "worker=1"]);
        farm
    }

    fn path(&self, name: &str) -> PathBuf {
        self.top.path().join(name)
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let id = |flag| text(Command::new("id").arg(flag)).unwrap();
        let mut command = Command::new("docker-compose");
        command.arg("-f").arg(root().join("k8s/compose/compose.yaml")).args(["-p", &self.project]);
        command.arg("--project-directory").arg(self.top.path()).args(arguments);
        command.env("GONIO_CAPTURES", self.path("captures")).env("GONIO_OUT", self.path("out"));
        command.env("GONIO_USER", format!("{}:{}", id("-u"), id("-g")));
        command
    }

    fn compose(&self, arguments: &[&str]) {
        let output = self.command(arguments).stdin(Stdio::null()).output().unwrap();
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    }

    /// Starts a client in a container of its own.
    fn client(&self, arguments: &[&str]) -> Child {
        let run = ["run", "--rm", "-T", "client"];
        let mut command = self.command(&[&run[..], arguments].concat());
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
    }

    fn workers(&self) -> Vec<String> {
        let label = format!("label=com.docker.compose.project={}", self.project);
        let service = "label=com.docker.compose.service=worker";
        docker(&["ps", "--quiet", "--filter", &label, "--filter", service]).lines().map(str::to_owned).collect()
    }

    fn network(&self) -> String {
        format!("{}_default", self.project)
    }

    /// Frames of the sweep that are finished.
    fn frames(&self) -> usize {
        let folders = std::fs::read_dir(self.path("out/swept/frames")).into_iter().flatten().flatten();
        let files = folders.flat_map(|folder| std::fs::read_dir(folder.path()).into_iter().flatten().flatten());
        files.filter(|file| file.path().extension().is_some_and(|ending| ending == "json")).count()
    }

    /// Waits until so many frames are finished, and fails if the client ends before.
    fn reach(&self, frames: usize, client: &mut Child) {
        let begin = Instant::now();
        while self.frames() < frames {
            assert!(begin.elapsed() < PATIENCE, "{} frames after {PATIENCE:?}", self.frames());
            assert!(client.try_wait().unwrap().is_none(), "the sweep ended at {} frames", self.frames());
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

impl Drop for Farm {
    fn drop(&mut self) {
        // What cannot be taken down here is for `docker ps` to show.
        let _ = self.command(&["down", "--volumes", "--timeout", "2"]).output();
    }
}

fn done(client: Child) {
    let output = client.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn embedded(farm: &Farm, arguments: &[&str]) {
    let output = Command::new(PROGRAMS.join("gonio")).current_dir(farm.top.path()).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn json(path: &Path) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

#[test]
fn containers_fit_with_the_same_bits_and_a_sweep_survives_what_befalls_them() {
    if let Some(why) = missing() {
        eprintln!("skipped: {why}");
        return;
    }
    let farm = Farm::up();
    done(farm.client(&["fit", "/captures/none-201", "--out", "/out/fit"]));
    embedded(&farm, &["fit", "captures/none-201", "--out", "fit"]);
    let (through, here) = (json(&farm.path("out/fit/fit.json")), json(&farm.path("fit/fit.json")));
    for key in ["parameters", "correlations", "fit", "held_out", "loss_curve"] {
        assert_eq!(through[key], here[key], "{key}");
    }

    let mut client = farm.client(&["sweep", "/captures/sweep.toml", "--out", "/out/swept"]);
    farm.reach(50, &mut client);
    farm.compose(&["up", "--detach", "--no-recreate", "--scale", "worker=4"]);
    let workers = farm.workers();
    assert_eq!(workers.len(), 4);
    farm.reach(150, &mut client);
    docker(&["kill", &workers[0]]);
    docker(&["pause", &workers[1]]);
    farm.reach(250, &mut client);
    docker(&["network", "disconnect", &farm.network(), &workers[2]]);
    farm.reach(350, &mut client);
    docker(&["unpause", &workers[1]]);
    docker(&["network", "connect", &farm.network(), &workers[2]]);
    docker(&["stop", &workers[3]]);
    farm.reach(450, &mut client);
    farm.compose(&["restart", "coordinator"]);
    farm.reach(600, &mut client);
    farm.compose(&["up", "--detach", "--no-recreate", "--scale", "worker=1"]);
    assert_eq!(farm.workers().len(), 1);
    done(client);
    embedded(&farm, &["sweep", "captures/sweep.toml", "--out", "swept"]);
    for name in ["table.csv", "table.parquet", "sheet.png"] {
        let read = |folder: &str| std::fs::read(farm.path(folder).join(name)).unwrap();
        assert!(read("out/swept") == read("swept"), "{name}");
    }
}
