//! `gonio diagnose`: what the simulation of a capture gets wrong.

mod decide;
mod workshop;

use super::{check, command, farm};
use crate::arguments::{DiagnoseArguments, DiagnoseOptions};
use crate::failure::Failure;
use crate::farm::Farm;
use crate::input::Input;
use crate::interrupt::Interrupt;
use crate::output::{Output as Folder, tell, to_json, to_pretty_json};
use crate::progress::{Console, DiagnoseConsole};
use crate::report::{DiagnosisReport, Panel, ReflectancePanel};
use crate::watch::Watch;
use gonio_diagnose::{Diagnosed, Diagnosis, Options, Seen, Verdict};
use gonio_scene::Capture;
use gonio_scene::capture::CAPTURE_FILE;
use std::path::Path;
use workshop::FarmWorkshop;

const RESULT: &str = "diagnosis.json";
const EVIDENCE: &str = "evidence.json";
const REPORT: &str = "report.html";

/// What is known after a diagnosis.
pub struct Outcome {
    /// Its result, and what was seen on the way.
    pub diagnosed: Diagnosed,
    /// The capture extended by what was found, at the values that were fitted; its added meshes come with it.
    pub input: Input,
}

impl Outcome {
    /// The report, as a page that says which `command` made it.
    #[must_use]
    pub fn page(&self, command: &str) -> String {
        let d = &self.diagnosed;
        DiagnosisReport {
            diagnosis: &d.diagnosis,
            before: &panels(&d.base_capture, &d.before),
            after: &panels(&d.last_capture, &d.after),
            files_before: &files(&d.base_capture, &d.before),
            files_after: &files(&d.last_capture, &d.after),
            structure_before: &d.structure_before,
            structure_after: &d.structure_after,
            command,
            version: env!("CARGO_PKG_VERSION"),
        }
        .page()
    }

    /// Writes `capture.toml`, added meshes, `diagnosis.json`, `evidence.json` and `report.html` to the folder `to`, as the command does.
    ///
    /// # Errors
    /// A folder that cannot be written to.
    pub fn save(&self, to: &Path, command: &str) -> Result<(), Failure> {
        let folder = folder(to, &self.input)?;
        self.write(&folder, command)
    }

    fn write(&self, folder: &Folder, command: &str) -> Result<(), Failure> {
        self.input.write(folder)?;
        folder.write(RESULT, to_pretty_json(&self.diagnosed.diagnosis)?.as_bytes())?;
        folder.write(EVIDENCE, to_json(&self.diagnosed.evidence)?.as_bytes())?;
        folder.write(REPORT, self.page(command).as_bytes())?;
        Ok(())
    }

    /// What was found could not be held against the photos that are held out.
    ///
    /// # Errors
    /// That.
    pub fn judged(&self) -> Result<(), Failure> {
        match &self.diagnosed.unjudged {
            Some(why) => Err(Failure::Input(format!("the held-out photos could not be judged: {why}"))),
            None => Ok(()),
        }
    }
}

/// Diagnoses `input` on `farm`. Writes nothing.
///
/// # Errors
/// A broken capture or photograph, options that make no diagnosis, a farm that fails, an interruption.
pub fn diagnose(
    input: &Input,
    farm: Farm,
    options: &DiagnoseOptions,
    console: &mut Console,
    interrupt: &Interrupt,
) -> Result<Outcome, Failure> {
    check::warn_before(&input.capture, input, console);
    follow(input, farm, options, console, interrupt, &Watch::none())
}

fn follow(
    input: &Input,
    farm: Farm,
    options: &DiagnoseOptions,
    console: &mut Console,
    interrupt: &Interrupt,
    watch: &Watch,
) -> Result<Outcome, Failure> {
    let options = Options {
        seed: options.seed,
        samples: options.samples,
        policy: decide::policy(options)?,
        without: options.without.clone(),
        ..Options::default()
    };
    let workshop = FarmWorkshop { farm, files: input };
    let diagnosed = {
        let mut view = DiagnoseConsole::new(console);
        let mut observer = |event: &gonio_diagnose::DiagnoseEvent| {
            view.show(event);
            watch.diagnose(event);
            interrupt.flow()
        };
        gonio_diagnose::diagnose(&input.capture, &options, &workshop, &mut observer)?
    };
    console.end();
    let extended = input.with(diagnosed.capture.clone(), &diagnosed.files)?;
    Ok(Outcome { diagnosed, input: extended })
}

/// Diagnoses and writes.
///
/// # Errors
/// A broken capture or photograph, options that make no diagnosis, a farm that fails, a folder that cannot be written to,
/// Ctrl-C.
pub fn run(arguments: &DiagnoseArguments) -> Result<(), Failure> {
    if let Some(file) = &arguments.evidence {
        return decide::again(file, &decide::policy(&arguments.options)?);
    }
    let note = "stopping; again to kill";
    let interrupt = Interrupt::listen(if arguments.farm.json { "" } else { note })?;
    let (Some(capture), Some(out)) = (&arguments.capture, &arguments.out) else {
        return Err(Failure::Input("name a capture and --out, or --evidence".to_owned()));
    };
    let input = Input::open(capture)?;
    let mut console = Console::new(arguments.farm.json);
    check::warn_before(&input.capture, &input, &console);
    let folder = folder(out, &input)?;
    let watch = Watch::open(&arguments.watch, ("Diagnosis", &input.capture.name), &interrupt, &console)?;
    let done = work(arguments, &input, &folder, &mut console, &interrupt, &watch);
    watch.end(&done);
    done
}

fn work(
    arguments: &DiagnoseArguments,
    input: &Input,
    folder: &Folder,
    console: &mut Console,
    interrupt: &Interrupt,
    watch: &Watch,
) -> Result<(), Failure> {
    let outcome = follow(input, farm(&arguments.farm)?, &arguments.options, console, interrupt, watch)?;
    let diagnosed = &outcome.diagnosed;
    watch.diagnosis(&diagnosed.diagnosis);
    outcome.write(folder, &command())?;
    if watch.is_open() {
        watch.panels(&diagnosed.last_capture, &panels(&diagnosed.last_capture, &diagnosed.after));
    }
    if arguments.farm.json {
        tell(&to_json(&diagnosed.diagnosis)?);
    } else {
        conclude(&diagnosed.diagnosis, folder);
    }
    outcome.judged()
}

/// The folder that is written to.
fn folder(to: &Path, input: &Input) -> Result<Folder, Failure> {
    let written = [CAPTURE_FILE, RESULT, EVIDENCE, REPORT].map(str::to_owned);
    Folder::create(to, &written, &input.root, &input.capture)
}

fn panels(capture: &Capture, seen: &[Seen]) -> Vec<Panel> {
    seen.iter().filter_map(|s| Panel::new(capture, &s.photograph, &s.film, &s.statistics)).collect()
}

fn files(capture: &Capture, seen: &[Seen]) -> Vec<ReflectancePanel> {
    let panel = |s: &Seen| ReflectancePanel::new(capture, &s.photograph, &s.pairs, &s.film, &s.statistics);
    seen.iter().filter_map(panel).collect()
}

/// The diagnosis in a few lines, for people.
fn conclude(diagnosis: &Diagnosis, folder: &Folder) {
    match diagnosis.verdict {
        Verdict::None => tell("none: what is left looks like noise"),
        Verdict::Unexplained => tell("unexplained: something is left that no effect of the catalogue explains"),
        Verdict::Named => {
            for found in &diagnosis.found {
                let subject = if found.subject.is_empty() { String::new() } else { format!(" ({})", found.subject) };
                tell(&format!("found: {}{subject}", found.effects.join(" or ")));
                for p in &found.parameters {
                    let error = p.standard_error.map_or_else(|| "undetermined".to_owned(), |e| format!("± {e:.2e}"));
                    tell(&format!("  {}  {:.6}  {error}", p.name, p.value));
                }
                tell(&format!("  to be sure: {}", found.separate_by));
            }
        }
    }
    if let Some(held) = diagnosis.found.first().and_then(|f| f.held_out) {
        tell(&format!(
            "held out: reduced chi-square {:.4} before, {:.4} after; RMSE {:+.1} %; log density {:+.4} per observation",
            held.reduced_chi_square_before,
            held.reduced_chi_square_after,
            100.0 * (held.rmse_after / held.rmse_before - 1.0),
            held.log_density_gain
        ));
    }
    if let Some(noise) = &diagnosis.noise {
        let each = noise.map(|c| format!("{:.2} ± {:.2}", c.factor().0, c.factor().1));
        tell(&format!(
            "noise: the photographs are {} times as noisy as [sensor] says (red, green, blue)",
            each.join(", ")
        ));
    }
    if let Some(left) = &diagnosis.unexplained {
        tell(&format!("left: {} predicts {:.1} % of the residuals' variance", left.covariate, 100.0 * left.strength));
    }
    tell(&format!("wrote {RESULT}, {EVIDENCE}, {CAPTURE_FILE}, {REPORT} to {}", folder.dir().display()));
}
