//! Any program as the estimator: it is told an image's files and prints its estimates.

use super::{Method, Task, colours};
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use gonio_pose::bop::{Dataset, Estimate, ModelsFolder, parse_results};
use gonio_scene::SceneError;
use gonio_scene::files::DirectoryFiles;
use gonio_scene::image::dimensions;
use std::io::Read;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// Most that a program may print for one image.
const MOST: u64 = 16 << 20;

/// How often a program is asked whether it has ended.
const GLANCE: Duration = Duration::from_millis(5);

/// A program and what it is told.
pub(super) struct External<'a> {
    words: Vec<String>,
    dataset: &'a Dataset,
    timeout: Duration,
    interrupt: &'a Interrupt,
    /// Holds the cameras' files.
    folder: tempfile::TempDir,
}

impl<'a> External<'a> {
    /// Of a command line with placeholders.
    ///
    /// # Errors
    /// Quotes that do not match, no word, an unknown placeholder, a time that is none, no folder for temporary files.
    pub fn new(command: &str, dataset: &'a Dataset, timeout: f64, interrupt: &'a Interrupt) -> Result<Self, Failure> {
        let refuse = |text: &str| Failure::Input(format!("--estimator: {text}"));
        let words = shlex::split(command).ok_or_else(|| refuse("has a quote without its end; close it"))?;
        if words.is_empty() {
            return Err(refuse(
                "is empty; write a program and its arguments, such as \"find-poses {rgb} {camera} {models}\"",
            ));
        }
        if !words.iter().any(|word| word.contains("{rgb}")) {
            return Err(refuse("has no {rgb}: the program would not know the image; write it where the file belongs"));
        }
        let timeout = Duration::try_from_secs_f64(timeout)
            .ok()
            .filter(|timeout| !timeout.is_zero())
            .ok_or_else(|| Failure::Input("--timeout: write seconds above 0".to_owned()))?;
        let folder = tempfile::tempdir()
            .map_err(|error| Failure::Failed(format!("no folder for temporary files: {error}; set TMPDIR")))?;
        Ok(Self { words, dataset, timeout, interrupt, folder })
    }

    fn command(&self, task: &Task) -> Result<Command, Failure> {
        let rgb = absolute(&colours(self.dataset, task)?)?;
        let Some(frame) = self.dataset.frame(task.scene, task.image) else {
            let file = format!("{}/{:06}/scene_camera.json", self.dataset.split, task.scene);
            let error = SceneError::new(file, "has no such image", "add its camera, or leave the image out");
            return Err(error.at(task.image.to_string()).into());
        };
        let (width, height) = dimensions(&DirectoryFiles::new(""), &rgb)?;
        let c = frame.camera;
        let camera = serde_json::json!({
            "cam_K": [c.fx, 0.0, c.cx, 0.0, c.fy, c.cy, 0.0, 0.0, 1.0],
            "width": width,
            "height": height,
        });
        let path = self.folder.path().join(format!("{}-{}.json", task.scene, task.image));
        std::fs::write(&path, camera.to_string())
            .map_err(|error| Failure::Failed(format!("{}: cannot be written: {error}", path.display())))?;
        let models = absolute(&self.dataset.root.join(self.dataset.models_folder(ModelsFolder::Rendering)))?;
        let numbers: Vec<String> = task.objects.keys().map(u32::to_string).collect();
        let (scene, image) = (task.scene.to_string(), task.image.to_string());
        let values = [
            ("{rgb}", rgb),
            ("{camera}", path.display().to_string()),
            ("{models}", models),
            ("{objects}", numbers.join(",")),
            ("{scene}", scene),
            ("{image}", image),
        ];
        let mut words = self.words.iter().map(|word| {
            values.iter().fold(word.clone(), |word, (placeholder, value)| word.replace(placeholder, value))
        });
        let mut command = Command::new(words.next().unwrap_or_default());
        command.args(words).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::inherit());
        Ok(command)
    }

    /// Waits for a program; `None` if it had to be killed.
    fn wait(&self, child: &mut Child, begin: Instant) -> std::io::Result<Option<ExitStatus>> {
        loop {
            if let Some(status) = child.try_wait()? {
                return Ok(Some(status));
            }
            if begin.elapsed() > self.timeout || self.interrupt.is_asked() {
                child.kill()?;
                child.wait()?;
                return Ok(None);
            }
            std::thread::sleep(GLANCE);
        }
    }
}

impl Method for External<'_> {
    fn estimate(&self, task: &Task) -> Result<Vec<Estimate>, Failure> {
        let name = format!("the estimator, scene {} image {}", task.scene, task.image);
        let failed = |problem: String| Failure::Failed(format!("{name}: {problem}"));
        let begin = Instant::now();
        let mut child = self.command(task)?.spawn().map_err(|error| {
            Failure::Input(format!("--estimator: {:?} cannot be started: {error}; correct the path", self.words[0]))
        })?;
        let out = child.stdout.take();
        // Read aside: a full pipe would stop the program.
        let reader = std::thread::spawn(move || {
            let mut bytes = Vec::new();
            out.map_or(Ok(0), |out| out.take(MOST + 1).read_to_end(&mut bytes)).map(|_| bytes)
        });
        let status = self.wait(&mut child, begin).map_err(|error| failed(error.to_string()))?;
        let seconds = begin.elapsed().as_secs_f64();
        match status {
            None => return Err(failed(format!("was killed after {seconds:.1} s; raise --timeout"))),
            Some(status) if !status.success() => {
                return Err(failed(format!("ended with {status}; what it wrote to stderr is above")));
            }
            Some(_) => {}
        }
        let bytes = reader.join().map_err(|_| failed("its output was not read".to_owned()))?;
        let bytes = bytes.map_err(|error| failed(format!("its output cannot be read: {error}")))?;
        if bytes.len() as u64 > MOST {
            return Err(failed(format!("printed more than {} MiB; print estimates only", MOST >> 20)));
        }
        let mut estimates = parse_results(&name, &String::from_utf8_lossy(&bytes))?;
        for estimate in &mut estimates {
            (estimate.scene, estimate.image) = (task.scene, task.image);
            estimate.seconds = Some(estimate.seconds.unwrap_or(seconds));
        }
        Ok(estimates)
    }
}

fn absolute(path: &std::path::Path) -> Result<String, Failure> {
    let whole = path
        .canonicalize()
        .map_err(|error| SceneError::new(path.display().to_string(), error.to_string(), "correct the path"))?;
    Ok(whole.display().to_string())
}
