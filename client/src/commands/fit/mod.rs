//! `gonio fit`: from a capture to estimates, a fitted capture and a report.

mod accuracy;
mod large;
mod pictures;
mod residuals;

use super::{check, command, open};
use crate::arguments::{FitArguments, Pixels};
use crate::failure::Failure;
use crate::input::Input;
use crate::interrupt::Interrupt;
use crate::output::{Output as Folder, tell, to_json, to_pretty_json};
use crate::progress::{Console, FitConsole};
use crate::relocate::relocate;
use crate::watch::{Live, Watch};
use accuracy::Verdict;
use gonio::farm::OpenCapture;
use gonio::report::Report;
use gonio_fit::{Checkpoint, FitEvent, FitResult, Options};
use gonio_scene::capture::CAPTURE_FILE;
use gonio_scene::{Capture, Values};
use pictures::Pictures;
use std::collections::BTreeMap;
use std::ops::ControlFlow;

const RESULT: &str = "fit.json";
const REPORT: &str = "report.html";
const CHECKPOINT: &str = "checkpoint.json";

/// What stands for the chosen pixels among the files that a checkpoint belongs to.
const CHOSEN: &str = "the pixels chosen by --pixels and --seed";

/// Samples per pixel that a fit begins with, where it may take as many.
const FIRST_SAMPLES: u32 = 4;

/// Fits and writes.
///
/// # Errors
/// A broken capture or photograph, options that make no fit, a checkpoint of another fit, a farm that fails, a folder
/// that cannot be written to, Ctrl-C (after everything that was reached has been written).
pub fn run(arguments: &FitArguments) -> Result<(), Failure> {
    let note = "stopping and keeping what is done; again to kill";
    let interrupt = Interrupt::listen(if arguments.farm.json { "" } else { note })?;
    let mut input = Input::open(&arguments.capture)?;
    free(&mut input.capture, arguments)?;
    // All of them, the held-out too: an hour's fit should not end at a photo that cannot be read.
    let wanted = wanted(&input.capture, arguments);
    let mut photos = BTreeMap::new();
    if wanted.is_some() {
        photos = large::look(&input.capture, &input.files)?;
    } else {
        for target in input.capture.targets() {
            Values::of(&input.capture, target, &input.files)?;
        }
    }
    let chosen = Chosen { wanted, photos };
    let mut written = [CAPTURE_FILE, RESULT, REPORT, CHECKPOINT].map(str::to_owned).to_vec();
    if arguments.residuals {
        written.extend(input.capture.photos.iter().map(|photo| residuals::name(photo.name())));
    }
    check::warn_before(&input.capture, &input.files);
    let folder = Folder::create(&arguments.out, &written, &input.root, &input.capture)?;
    let mut console = Console::new(arguments.farm.json);
    let watch = Watch::open(&arguments.watch, ("Fit", &input.capture.name), &interrupt, &console)?;
    let done = work(arguments, &input, &chosen, &folder, &mut console, &interrupt, &watch);
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

/// How many pixels are compared: what is asked for, or all of a small capture and many of a large one. Absent: all.
fn wanted(capture: &Capture, arguments: &FitArguments) -> Option<u64> {
    let pixels = gonio_design::pixels(capture);
    match arguments.pixels {
        Pixels::All => None,
        Pixels::Some(wanted) => Some(wanted).filter(|wanted| *wanted < pixels),
        Pixels::AsNeeded if arguments.accuracy.is_some() => Some(accuracy::PILOT).filter(|pilot| *pilot < pixels),
        Pixels::AsNeeded => (pixels > gonio_design::ALL_UP_TO).then_some(gonio_design::MANY),
    }
}

fn work(
    arguments: &FitArguments,
    input: &Input,
    chosen: &Chosen,
    folder: &Folder,
    console: &mut Console,
    interrupt: &Interrupt,
    watch: &Watch,
) -> Result<(), Failure> {
    let mut farm = open(&arguments.farm, input)?;
    let mut options = options(arguments, folder)?;
    let mut result = None;
    let mut pixels = chosen.wanted;
    let all = gonio_design::pixels(&input.capture);
    for round in 1..=accuracy::ROUNDS {
        if let Some(wanted) = pixels {
            let design = large::design(&input.capture, &input.files, &farm, arguments.seed, wanted)?;
            farm = farm.with_design(&design)?;
        }
        options.files = farm.files().map(|(path, digest)| (path.to_owned(), digest.to_string())).collect();
        // Other pixels make another fit, as other photos do.
        options.files.extend(farm.design().map(|digest| (CHOSEN.to_owned(), digest.to_string())));
        let live = Live::start(watch, &input.capture, &input.files, &farm);
        let fitted = fit(
            &input.capture,
            &mut farm,
            &options,
            &mut |event| {
                watch.fit(event);
                live.note(event);
                interrupt.flow()
            },
            console,
        )?;
        let judged =
            arguments.accuracy.zip(pixels).map(|(wanted, pixels)| (accuracy::judge(&fitted, wanted, pixels), wanted));
        options.start = fitted.parameters.iter().map(|p| (p.name.clone(), p.value)).collect();
        result = Some(fitted);
        match judged {
            Some((Verdict::Needs(more), wanted))
                if round < accuracy::ROUNDS && pixels < Some(all) && !interrupt.is_asked() =>
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
    let result = result.ok_or_else(|| Failure::Failed("there was no fit".to_owned()))?;
    watch.result(&result);
    let fitted = result.apply(&input.capture)?;
    write_capture(&fitted, input, folder)?;
    folder.write(RESULT, to_pretty_json(&result)?.as_bytes())?;
    let panels = if interrupt.is_asked() {
        Ok(Pictures::default())
    } else {
        watch.phase("Rendering the report's pictures");
        pictures::all(&fitted, &input.files, &mut farm, &result, &chosen.photos, console, interrupt)
    };
    let whole = chosen.photos.is_empty();
    let samples = if whole { pictures::samples(&fitted, &result) } else { large::SAMPLES };
    let none = Pictures::default();
    write_report(folder, &result, panels.as_ref().unwrap_or(&none), samples)?;
    watch.panels(&fitted, &panels.as_ref().unwrap_or(&none).photos);
    if arguments.residuals && !interrupt.is_asked() {
        watch.phase("Rendering the residuals");
        let flow = || interrupt.flow();
        residuals::write(&fitted, &input.files, &mut farm, &result, folder, console, &flow)?;
    }
    console.end();
    if arguments.farm.json {
        tell(&to_json(&result)?);
    } else {
        conclude(&result, folder);
    }
    panels?;
    if interrupt.is_asked() {
        let text = format!("interrupted; continue with --resume --out {}", folder.dir().display());
        return Err(Failure::Interrupted(text));
    }
    Ok(())
}

fn fit(
    capture: &Capture,
    farm: &mut OpenCapture,
    options: &Options,
    seen: &mut dyn FnMut(&FitEvent) -> ControlFlow<()>,
    console: &mut Console,
) -> Result<FitResult, Failure> {
    let mut view = FitConsole::new(console);
    let mut observer = |event: &FitEvent| {
        view.show(event);
        seen(event)
    };
    Ok(gonio_fit::fit(capture, farm, options, &mut observer)?)
}

/// Frees what the arguments name instead of what the capture does.
fn free(capture: &mut Capture, arguments: &FitArguments) -> Result<(), Failure> {
    if let Some(names) = &arguments.free {
        capture.fit.parameters.clone_from(names);
        capture.fit.gray.retain(|gray| names.contains(gray));
    }
    if let Some(gray) = &arguments.gray {
        capture.fit.gray.clone_from(gray);
    }
    capture.free_parameters()?;
    Ok(())
}

fn options(arguments: &FitArguments, folder: &Folder) -> Result<Options, Failure> {
    let checkpoint = folder.path(CHECKPOINT);
    let resume = if arguments.resume { Some(Checkpoint::read(&checkpoint)?) } else { None };
    Ok(Options {
        solver: arguments.solver,
        seed: arguments.seed,
        min_samples: FIRST_SAMPLES.min(arguments.samples),
        max_samples: arguments.samples,
        max_iterations: arguments.max_iterations,
        start: arguments.start.clone(),
        checkpoint: Some(checkpoint),
        resume,
        ..Options::default()
    })
}

/// Writes the fitted capture so that it can be used from where it lies.
fn write_capture(fitted: &Capture, input: &Input, folder: &Folder) -> Result<(), Failure> {
    let mut here = fitted.clone();
    relocate(&mut here, &input.root, folder.dir())?;
    folder.write(CAPTURE_FILE, here.to_toml()?.as_bytes())?;
    Ok(())
}

fn write_report(folder: &Folder, result: &FitResult, pictures: &Pictures, samples: u32) -> Result<(), Failure> {
    let command = command();
    let version = env!("CARGO_PKG_VERSION");
    let (panels, files) = (&pictures.photos, &pictures.files);
    let report = Report { result, panels, files, samples, command: &command, version };
    folder.write(REPORT, report.page().as_bytes())?;
    Ok(())
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
