//! A sweep over real processes: the same tables embedded, with one worker, with two, and with a coordinator that is killed,
//! whether the next one knows of it (its store is a folder) or not (memory). `GONIO_FRAMES=2000` makes it a longer one.

#![allow(clippy::unwrap_used)] // Its helpers may do what its tests may.
#![cfg(unix)]

use gonio_tests::captures;
use gonio_tests::cluster::{Cluster, PROGRAMS};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// How many frames, unless the environment says.
const FRAMES: usize = 400;

/// A folder that goes with the test.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Self {
        let path = std::env::temp_dir().join(format!("gonio-sweep-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // What is left of it harms nobody.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn sweep(top: &Path, out: &str, farm: Option<&str>) -> Command {
    let mut command = Command::new(PROGRAMS.join("gonio"));
    command.current_dir(top).args(["sweep", "sweep.toml", "--out", out]).stderr(Stdio::piped());
    command.args(farm.into_iter().flat_map(|url| ["--farm", url]));
    command
}

fn tables(top: &Path, out: &str) -> Vec<Vec<u8>> {
    let read = |name| std::fs::read(top.join(out).join(name)).unwrap();
    ["table.csv", "table.parquet", "sheet.png", "sheet.html"].map(read).into()
}

/// Finished frames.
fn records(out: &Path) -> usize {
    let folders = std::fs::read_dir(out.join("frames")).into_iter().flatten().flatten();
    let files = folders.flat_map(|folder| std::fs::read_dir(folder.path()).into_iter().flatten().flatten());
    files.filter(|file| file.path().extension().is_some_and(|ending| ending == "json")).count()
}

#[test]
fn a_sweep_has_the_same_tables_however_it_is_farmed() {
    let folder = Folder::new();
    let top = folder.0.as_path();
    let frames =
        std::env::var("GONIO_FRAMES").map_or(FRAMES, |text| text.parse().expect("GONIO_FRAMES: a whole number"));
    let text = format!(
        "format = 1\ncapture = {:?}\nsamples = 32\nresolution = 0.2\nphotos = [\"00\", \"03\"]\n[[design]]\nkind = \"sobol\"\n\
         count = {}\naxes = [{{ name = \"material.shell.roughness\", from = 0.1, to = 0.6 }}]\n",
        captures().join("none-201"),
        frames / 2
    );
    std::fs::write(top.join("sweep.toml"), text).unwrap();
    assert!(sweep(top, "embedded", None).output().unwrap().status.success());
    let expected = tables(top, "embedded");

    for workers in [1, 2] {
        let cluster = Cluster::start(workers);
        let out = format!("farm{workers}");
        let output = sweep(top, &out, Some(&cluster.url)).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(tables(top, &out) == expected, "{workers} workers");
    }

    for store in ["memory://", "objects"] {
        let store = if store == "objects" { top.join(store).to_str().unwrap().to_owned() } else { store.to_owned() };
        let mut cluster = Cluster::start_with(&store, 2);
        let out = format!("killed-{}", store.starts_with("memory"));
        let child = sweep(top, &out, Some(&cluster.url)).spawn().unwrap();
        for kill in 1..=3 {
            let patience = Instant::now();
            while records(&top.join(&out)) < kill * frames / 5 {
                assert!(patience.elapsed() < Duration::from_secs(120), "no frames before kill {kill}");
                std::thread::sleep(Duration::from_millis(2));
            }
            cluster.replace_coordinator(Path::new(&store));
        }
        let output = child.wait_with_output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{stderr}");
        // Only one that knows nothing must be told again.
        assert!(stderr.contains("trying again") || !store.starts_with("memory"), "{stderr}");
        assert_eq!(records(&top.join(&out)), frames);
        assert!(tables(top, &out) == expected, "killed three times over {store}");
    }
}
