//! `gonio estimate`: poses of the objects in a BOP dataset's images, by the estimator that is built in or by any program.

mod built_in;
mod external;

use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::output::{tell, to_json};
use crate::progress::{Console, count};
use clap::Args;
use gonio_estimate::Settings;
use gonio_pose::bop::{Dataset, Estimate, ModelsFolder, Target, parse_results, write_results};
use gonio_scene::SceneError;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How often the console is redrawn.
const REDRAW: Duration = Duration::from_millis(100);

/// How often what is done is written down.
const KEEP: Duration = Duration::from_secs(10);

/// `gonio estimate`.
#[derive(Debug, Args)]
pub struct EstimateArguments {
    /// A BOP dataset's folder, or a split inside of it
    #[arg(value_name = "DATASET")]
    pub dataset: PathBuf,
    /// Where to write the estimates: scene_id,im_id,obj_id,score,R,t,time
    #[arg(long, value_name = "RESULTS.csv")]
    pub out: PathBuf,
    /// Which split, where the dataset has several; absent, test
    #[arg(long, value_name = "NAME")]
    pub split: Option<String>,
    /// Images and objects to estimate: targets of BOP19; absent, the dataset's test_targets_bop19.json, or all objects that are
    /// visible by a tenth
    #[arg(long, value_name = "TARGETS.json")]
    pub targets: Option<PathBuf>,
    /// How to estimate
    #[command(flatten)]
    pub method: MethodArguments,
    /// Keep the estimates that RESULTS.csv holds, and estimate the other images
    #[arg(long)]
    pub resume: bool,
    /// Write a summary as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// How poses are estimated.
#[derive(Debug, Args)]
pub struct MethodArguments {
    /// Least and largest distance of the objects from the camera in metres, for the estimator that is built in; absent, an object's
    /// diameter takes between a sixth and nearly all of the image's shorter side
    #[arg(long, value_name = "NEAR,FAR", value_delimiter = ',', num_args = 1)]
    pub distance: Vec<f64>,
    /// Run a program for every image instead: {rgb} is its file, {camera} a JSON file with cam_K, width and height, {models} the
    /// folder of models, {objects} the objects' numbers (1,5), {scene} and {image} its own. It prints lines as in RESULTS.csv, whose scene
    /// and image are not looked at
    #[arg(long, value_name = "COMMAND")]
    pub estimator: Option<String>,
    /// Images at a time; absent, one (built in: it uses all cores for an image) or one for each core (a program)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub jobs: Option<u16>,
    /// Seconds after which a program that has not ended is killed
    #[arg(long, value_name = "SECONDS", default_value_t = 600.0)]
    pub timeout: f64,
}

/// An image in which objects are to be found.
struct Task {
    scene: u32,
    image: u32,
    /// How many of each object.
    objects: BTreeMap<u32, usize>,
}

/// What estimates.
trait Method: Sync {
    /// The estimates of one image, the surest of each object first.
    fn estimate(&self, task: &Task) -> Result<Vec<Estimate>, Failure>;
}

type Done = BTreeMap<(u32, u32), Vec<Estimate>>;

/// Estimates, writes and tells.
///
/// # Errors
/// A dataset, targets or results that are missing or bad; a program that fails; a signal. What was done before is written.
pub fn run(arguments: &EstimateArguments) -> Result<(), Failure> {
    let dataset = Dataset::open(&arguments.dataset, arguments.split.as_deref())?;
    let targets = super::evaluate::targets(&dataset, arguments.targets.as_deref())?;
    let interrupt = Interrupt::listen("stopping; --resume goes on")?;
    let job = Job { dataset: &dataset, targets: &targets, out: &arguments.out, resume: arguments.resume };
    let begin = Instant::now();
    let (images, estimates) = job.run(&arguments.method, &interrupt, &mut Console::new(arguments.json))?;
    let per_image = begin.elapsed().as_secs_f64() / count(images.max(1) as u64);
    let (out, estimates) = (arguments.out.display().to_string(), estimates.len());
    if arguments.json {
        let summary = serde_json::json!({
            "out": out, "images": images, "estimates": estimates, "seconds_per_image": per_image,
        });
        tell(&to_json(&summary)?);
    } else {
        tell(&format!("{estimates} estimates to {out}; {images} images, {per_image:.2} s each"));
    }
    Ok(())
}

/// What is to be estimated, and where it is written to.
pub(super) struct Job<'a> {
    pub dataset: &'a Dataset,
    pub targets: &'a [Target],
    pub out: &'a Path,
    /// Whether estimates that are there are kept.
    pub resume: bool,
}

impl Job<'_> {
    /// Estimates what is not there yet. Gives how many images that were, and all estimates.
    ///
    /// # Errors
    /// Results that are bad, a program that fails, a signal. What was done before is written.
    pub fn run(
        &self,
        method: &MethodArguments,
        interrupt: &Interrupt,
        console: &mut Console,
    ) -> Result<(usize, Vec<Estimate>), Failure> {
        let mut tasks = tasks(self.targets)?;
        let mut done = self.kept()?;
        tasks.retain(|task| !done.contains_key(&(task.scene, task.image)));
        let images = tasks.len();
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let outcome = if let Some(command) = &method.estimator {
            let external = external::External::new(command, self.dataset, method.timeout, interrupt)?;
            self.all(&external, tasks, method.jobs.map_or(cores, usize::from), interrupt, console, &mut done)
        } else {
            let models = self.dataset.models(ModelsFolder::Rendering)?;
            let settings = settings(&method.distance)?;
            let built_in = built_in::BuiltIn::new(self.dataset, &models, &tasks, settings)?;
            self.all(&built_in, tasks, method.jobs.map_or(1, usize::from), interrupt, console, &mut done)
        };
        self.write(&done)?;
        outcome?;
        if interrupt.is_asked() {
            let text = format!("interrupted; {} has what was done, --resume goes on", self.out.display());
            return Err(Failure::Interrupted(text));
        }
        Ok((images, done.into_values().flatten().collect()))
    }

    /// What is there from a run before, if it is to be kept.
    fn kept(&self) -> Result<Done, Failure> {
        let mut done = Done::new();
        if self.resume && self.out.exists() {
            let text = super::prepare::text(self.out)?;
            for estimate in parse_results(&self.out.display().to_string(), &text)? {
                done.entry((estimate.scene, estimate.image)).or_default().push(estimate);
            }
        }
        Ok(done)
    }

    fn write(&self, done: &Done) -> Result<(), Failure> {
        let all: Vec<Estimate> = done.values().flatten().copied().collect();
        super::prepare::write(self.out, write_results(&all).as_bytes())
    }

    /// Estimates `tasks`, `jobs` at a time, into `done`.
    fn all(
        &self,
        method: &dyn Method,
        tasks: Vec<Task>,
        jobs: usize,
        interrupt: &Interrupt,
        console: &mut Console,
        done: &mut Done,
    ) -> Result<(), Failure> {
        let images = tasks.len() as u64;
        let threads = jobs.min(tasks.len());
        console.begin("estimate");
        let queue = Mutex::new(VecDeque::from(tasks));
        let (sender, receiver) = channel();
        let mut result = Ok(());
        let (begin, mut written, mut finished) = (Instant::now(), Instant::now(), 0);
        std::thread::scope(|scope| {
            for _ in 0..threads {
                let (sender, queue) = (sender.clone(), &queue);
                scope.spawn(move || {
                    while !interrupt.is_asked() {
                        let next = queue.lock().unwrap_or_else(PoisonError::into_inner).pop_front();
                        let Some(task) = next else { return };
                        let found = method.estimate(&task);
                        if found.is_err() {
                            queue.lock().unwrap_or_else(PoisonError::into_inner).clear();
                        }
                        // Nobody listens any more only where everything has ended.
                        let _ = sender.send(((task.scene, task.image), found));
                    }
                });
            }
            drop(sender);
            loop {
                match receiver.recv_timeout(REDRAW) {
                    Ok((image, Ok(found))) => {
                        finished += 1;
                        done.insert(image, found);
                    }
                    // An interrupted program's failure is the interruption.
                    Ok((_, Err(failure))) if result.is_ok() && !interrupt.is_asked() => result = Err(failure),
                    Ok(_) | Err(RecvTimeoutError::Timeout) => {}
                    Err(RecvTimeoutError::Disconnected) => break,
                }
                let rate = count(finished) / begin.elapsed().as_secs_f64().max(1e-9);
                console.show(finished, images, &format!("{finished}/{images}  {rate:.2} images/s"), || {
                    serde_json::json!({
                        "event": "progress", "images_done": finished, "images": images, "images_per_second": rate,
                    })
                });
                if written.elapsed() >= KEEP {
                    written = Instant::now();
                    // What cannot be written now is told at the end.
                    let _ = self.write(done);
                }
            }
        });
        console.end();
        result
    }
}

/// The images with what is to be found in them.
fn tasks(targets: &[Target]) -> Result<Vec<Task>, Failure> {
    let mut tasks: BTreeMap<(u32, u32), BTreeMap<u32, usize>> = BTreeMap::new();
    for target in targets {
        let (Some(object), Some(count)) = (target.object, target.count) else {
            let text = "--targets: name objects (BOP19): the targets of BOP24 do not say what to look for";
            return Err(Failure::Input(text.to_owned()));
        };
        tasks.entry((target.scene, target.image)).or_default().insert(object, count);
    }
    Ok(tasks.into_iter().map(|((scene, image), objects)| Task { scene, image, objects }).collect())
}

fn settings(distance: &[f64]) -> Result<Settings, Failure> {
    match *distance {
        [] => Ok(Settings::default()),
        [near, far] if near > 0.0 && far >= near && far.is_finite() => Ok(Settings { distance: Some([near, far]) }),
        _ => Err(Failure::Input("--distance: write two distances in metres, such as 0.3,0.6".to_owned())),
    }
}

/// The file of a task's colours.
fn colours(dataset: &Dataset, task: &Task) -> Result<PathBuf, SceneError> {
    let path = dataset.colour_path(task.scene, task.image).ok_or_else(|| {
        let file = format!("{}/{:06}/rgb/{:06}.png", dataset.split, task.scene, task.image);
        SceneError::new(file, "does not exist", "add the image, or name images that are there by --targets")
    })?;
    Ok(dataset.root.join(path))
}

/// The numbers of the objects that `tasks` ask for.
fn objects(tasks: &[Task]) -> BTreeSet<u32> {
    tasks.iter().flat_map(|task| task.objects.keys().copied()).collect()
}
