//! `gonio fit`: from a capture to estimates, a fitted capture and a report.

mod accuracy;
mod large;
mod pictures;
mod residuals;

use super::{check, command, open};
use crate::arguments::{FitArguments, FitOptions, Pixels};
use crate::failure::Failure;
use crate::farm::{Farm, OpenCapture};
use crate::input::Input;
use crate::interrupt::Interrupt;
use crate::output::{Output as Folder, tell, to_json, to_pretty_json};
use crate::progress::{Console, FitConsole};
use crate::report::Report;
use crate::watch::{Live, Watch};
use accuracy::Verdict;
use gonio_fit::{Checkpoint, FitEvent, FitResult, Options};
use gonio_scene::capture::CAPTURE_FILE;
use gonio_scene::{Capture, Values};
pub use pictures::Pictures;
use std::collections::BTreeMap;
use std::path::Path;

const RESULT: &str = "fit.json";
const REPORT: &str = "report.html";
const CHECKPOINT: &str = "checkpoint.json";

/// What stands for the chosen pixels among the files that a checkpoint belongs to.
const CHOSEN: &str = "the pixels chosen by --pixels and --seed";

/// Samples per pixel that a fit begins with, where it may take as many.
const FIRST_SAMPLES: u32 = 4;

/// A fit's outcome.
#[derive(Debug)]
pub struct Fitted {
    /// The estimates.
    pub result: FitResult,
    /// The capture at them, with the files that it was read with.
    pub input: Input,
    /// What its report shows; empty where they could not be rendered.
    pub pictures: Pictures,
    /// Samples per pixel of the pictures.
    picture_samples: u32,
}

impl Fitted {
    /// The report, as a page that says which `command` made it.
    #[must_use]
    pub fn page(&self, command: &str) -> String {
        let (panels, files) = (&self.pictures.photos, &self.pictures.files);
        let (result, samples, version) = (&self.result, self.picture_samples, env!("CARGO_PKG_VERSION"));
        Report { result, panels, files, samples, command, version }.page()
    }

    /// Writes `capture.toml`, `fit.json` and `report.html` to the folder `to`, as the command does.
    ///
    /// # Errors
    /// A folder that cannot be written to.
    pub fn save(&self, to: &Path, command: &str) -> Result<(), Failure> {
        let names = [CAPTURE_FILE, RESULT, REPORT].map(str::to_owned);
        let folder = Folder::create(to, &names, &self.input.root, &self.input.capture)?;
        self.input.write(&folder)?;
        folder.write(RESULT, to_pretty_json(&self.result)?.as_bytes())?;
        folder.write(REPORT, self.page(command).as_bytes())?;
        Ok(())
    }
}

/// Fits `input` on `farm`, and renders what a report shows of it. Writes nothing.
///
/// # Errors
/// A broken capture or photograph, options that make no fit, a farm that fails, an interruption.
pub fn fit(
    input: &Input,
    farm: &Farm,
    options: &FitOptions,
    console: &mut Console,
    interrupt: &Interrupt,
) -> Result<Fitted, Failure> {
    let mut input = input.clone();
    free(&mut input.capture, options)?;
    let chosen = Chosen::look(&input, options)?;
    check::warn_before(&input.capture, &input, console);
    let mut open = farm.open_input(&input)?;
    let watch = Watch::none();
    let how = How { options, interrupt, watch: &watch };
    let result = how.solve(&input, &chosen, &mut open, solver_options(options), console)?;
    if interrupt.is_asked() {
        return Err(Failure::Interrupted("interrupted".to_owned()));
    }
    let fitted = input.with(result.apply(&input.capture)?, &[])?;
    let pictures = pictures::all(&fitted, &mut open, &result, &chosen.photos, console, interrupt)?;
    console.end();
    let picture_samples = chosen.picture_samples(&fitted.capture, &result);
    Ok(Fitted { result, input: fitted, pictures, picture_samples })
}

/// Fits and writes.
///
/// # Errors
/// A broken capture or photograph, options that make no fit, a checkpoint of another fit, a farm that fails, a folder
/// that cannot be written to, Ctrl-C (after everything that was reached has been written).
pub fn run(arguments: &FitArguments) -> Result<(), Failure> {
    let note = "stopping and keeping what is done; again to kill";
    let interrupt = Interrupt::listen(if arguments.farm.json { "" } else { note })?;
    let mut input = Input::open(&arguments.capture)?;
    free(&mut input.capture, &arguments.options)?;
    let chosen = Chosen::look(&input, &arguments.options)?;
    let mut written = [CAPTURE_FILE, RESULT, REPORT, CHECKPOINT].map(str::to_owned).to_vec();
    if arguments.residuals {
        written.extend(input.capture.photos.iter().map(|photo| residuals::name(photo.name())));
    }
    let mut console = Console::new(arguments.farm.json);
    check::warn_before(&input.capture, &input, &console);
    let folder = Folder::create(&arguments.out, &written, &input.root, &input.capture)?;
    let watch = Watch::open(&arguments.watch, ("Fit", &input.capture.name), &interrupt, &console)?;
    let how = How { options: &arguments.options, interrupt: &interrupt, watch: &watch };
    let done = work(arguments, &how, &input, &chosen, &folder, &mut console);
    watch.end(&done);
    done
}

/// What a fit compares of a capture of more pixels than it needs.
struct Chosen {
    /// How many pixels; absent, all of them.
    wanted: Option<u64>,
    /// The photos as they are shown, where not all pixels are compared.
    photos: BTreeMap<usize, Values>,
}

impl Chosen {
    /// Reads every photo, the held-out too: an hour's fit should not end at one that cannot be read.
    fn look(input: &Input, options: &FitOptions) -> Result<Self, Failure> {
        let wanted = wanted(&input.capture, options);
        let mut photos = BTreeMap::new();
        if wanted.is_some() {
            photos = large::look(&input.capture, input)?;
        } else {
            for target in input.capture.targets() {
                Values::of(&input.capture, target, input)?;
            }
        }
        Ok(Self { wanted, photos })
    }

    /// Samples per pixel of the report's pictures.
    fn picture_samples(&self, fitted: &Capture, result: &FitResult) -> u32 {
        if self.photos.is_empty() { pictures::samples(fitted, result) } else { large::SAMPLES }
    }
}

/// How many pixels are compared: what is asked for, or all of a small capture and many of a large one. Absent: all.
fn wanted(capture: &Capture, options: &FitOptions) -> Option<u64> {
    let pixels = gonio_design::pixels(capture);
    match options.pixels {
        Pixels::All => None,
        Pixels::Some(wanted) => Some(wanted).filter(|wanted| *wanted < pixels),
        Pixels::AsNeeded if options.accuracy.is_some() => Some(accuracy::PILOT).filter(|pilot| *pilot < pixels),
        Pixels::AsNeeded => (pixels > gonio_design::ALL_UP_TO).then_some(gonio_design::MANY),
    }
}

/// How a fit goes on, and who follows it.
struct How<'a> {
    options: &'a FitOptions,
    interrupt: &'a Interrupt,
    watch: &'a Watch,
}

impl How<'_> {
    /// Fits to as many pixels as the options ask for, or as an accuracy turns out to need.
    fn solve(
        &self,
        input: &Input,
        chosen: &Chosen,
        farm: &mut OpenCapture,
        mut options: Options,
        console: &mut Console,
    ) -> Result<FitResult, Failure> {
        let mut result = None;
        let mut pixels = chosen.wanted;
        let all = gonio_design::pixels(&input.capture);
        for round in 1..=accuracy::ROUNDS {
            if let Some(wanted) = pixels {
                let design = large::design(&input.capture, input, farm, self.options.seed, wanted)?;
                *farm = farm.clone().with_design(&design)?;
            }
            options.files = farm.files().map(|(path, digest)| (path.to_owned(), digest.to_string())).collect();
            // Other pixels make another fit, as other photos do.
            options.files.extend(farm.design().map(|digest| (CHOSEN.to_owned(), digest.to_string())));
            let live = Live::start(self.watch, input, farm);
            let fitted = {
                let mut view = FitConsole::new(console);
                let mut observer = |event: &FitEvent| {
                    view.show(event);
                    self.watch.fit(event);
                    live.note(event);
                    self.interrupt.flow()
                };
                gonio_fit::fit(&input.capture, farm, &options, &mut observer)?
            };
            let judged = self
                .options
                .accuracy
                .zip(pixels)
                .map(|(wanted, pixels)| (accuracy::judge(&fitted, wanted, pixels), wanted));
            options.start = fitted.parameters.iter().map(|p| (p.name.clone(), p.value)).collect();
            result = Some(fitted);
            match judged {
                Some((Verdict::Needs(more), wanted))
                    if round < accuracy::ROUNDS && pixels < Some(all) && !self.interrupt.is_asked() =>
                {
                    console.line(&format!("an accuracy of {wanted} needs about {more} pixels"));
                    pixels = Some(more.min(all));
                }
                Some((Verdict::Needs(_), wanted)) => {
                    console.line(&format!("an accuracy of {wanted} was not reached"));
                    break;
                }
                Some((Verdict::Disagree(error), _)) => {
                    console.line(&format!(
                        "the scatter between photos allows a relative error of {error:.1e}, whatever the pixels"
                    ));
                    break;
                }
                Some((Verdict::Reached, _)) | None => break,
            }
        }
        result.ok_or_else(|| Failure::Failed("there was no fit".to_owned()))
    }
}

fn work(
    arguments: &FitArguments,
    how: &How<'_>,
    input: &Input,
    chosen: &Chosen,
    folder: &Folder,
    console: &mut Console,
) -> Result<(), Failure> {
    let (watch, interrupt) = (how.watch, how.interrupt);
    let mut farm = open(&arguments.farm, input)?;
    let options = kept_options(arguments, folder)?;
    let result = how.solve(input, chosen, &mut farm, options, console)?;
    watch.result(&result);
    let fitted = input.with(result.apply(&input.capture)?, &[])?;
    // Before the pictures, so that whatever becomes of those, the estimates are there.
    fitted.write(folder)?;
    folder.write(RESULT, to_pretty_json(&result)?.as_bytes())?;
    let rendered = if interrupt.is_asked() {
        Ok(Pictures::default())
    } else {
        watch.phase("Rendering the report's pictures");
        pictures::all(&fitted, &mut farm, &result, &chosen.photos, console, interrupt)
    };
    let (pictures, missing) = match rendered {
        Ok(pictures) => (pictures, None),
        Err(failure) => (Pictures::default(), Some(failure)),
    };
    let picture_samples = chosen.picture_samples(&fitted.capture, &result);
    let fitted = Fitted { result, input: fitted, pictures, picture_samples };
    folder.write(REPORT, fitted.page(&command()).as_bytes())?;
    watch.panels(&fitted.input.capture, &fitted.pictures.photos);
    if arguments.residuals && !interrupt.is_asked() {
        watch.phase("Rendering the residuals");
        let flow = || interrupt.flow();
        residuals::write(&fitted.input, &mut farm, &fitted.result, folder, console, &flow)?;
    }
    console.end();
    if arguments.farm.json {
        tell(&to_json(&fitted.result)?);
    } else {
        conclude(&fitted.result, folder);
    }
    if let Some(failure) = missing {
        return Err(failure);
    }
    if interrupt.is_asked() {
        let text = format!("interrupted; continue with --resume --out {}", folder.dir().display());
        return Err(Failure::Interrupted(text));
    }
    Ok(())
}

/// Frees what the options name instead of what the capture does.
fn free(capture: &mut Capture, options: &FitOptions) -> Result<(), Failure> {
    if let Some(names) = &options.free {
        capture.fit.parameters.clone_from(names);
        capture.fit.gray.retain(|gray| names.contains(gray));
    }
    if let Some(gray) = &options.gray {
        capture.fit.gray.clone_from(gray);
    }
    capture.free_parameters()?;
    Ok(())
}

/// What the solver is told.
fn solver_options(options: &FitOptions) -> Options {
    Options {
        solver: options.solver,
        seed: options.seed,
        min_samples: FIRST_SAMPLES.min(options.samples),
        max_samples: options.samples,
        max_iterations: options.max_iterations,
        start: options.start.clone(),
        ..Options::default()
    }
}

/// The same of a fit that keeps where it is in `folder`, and may go on from there.
fn kept_options(arguments: &FitArguments, folder: &Folder) -> Result<Options, Failure> {
    let checkpoint = folder.path(CHECKPOINT);
    let resume = if arguments.resume { Some(Checkpoint::read(&checkpoint)?) } else { None };
    Ok(Options { checkpoint: Some(checkpoint), resume, ..solver_options(&arguments.options) })
}

/// The result in a few lines, for people.
fn conclude(result: &FitResult, folder: &Folder) {
    let width = result.parameters.iter().map(|p| p.name.len()).max().unwrap_or(0);
    for p in &result.parameters {
        let error = p.standard_error.map_or_else(|| "undetermined".to_owned(), |e| format!("± {e:.2e}"));
        tell(&format!("{:width$}  {:>12.6}  {error}", p.name, p.value));
    }
    let held = result.held_out.as_ref().map(|h| format!(", held out {:.4}", h.reduced_chi_square)).unwrap_or_default();
    let ended = if result.converged { "converged" } else { "not converged" };
    tell(&format!(
        "{ended} after {} iterations in {:.1} s; reduced chi-square {:.4}{held}",
        result.iterations, result.seconds, result.fit.reduced_chi_square
    ));
    for warning in &result.warnings {
        tell(&format!("warning: {warning}"));
    }
    tell(&format!("wrote {CAPTURE_FILE}, {RESULT}, {REPORT} to {}", folder.dir().display()));
}
