//! `gonio diagnose`: what the simulation of a capture gets wrong.

mod decide;
mod workshop;

use super::{check, command, farm};
use crate::arguments::DiagnoseArguments;
use crate::failure::Failure;
use crate::input::Input;
use crate::interrupt::Interrupt;
use crate::output::{Output as Folder, tell, to_json, to_pretty_json};
use crate::progress::{Console, DiagnoseConsole};
use crate::relocate::relocate;
use crate::watch::Watch;
use gonio::report::{DiagnosisReport, Panel, ReflectancePanel};
use gonio_diagnose::{Diagnosed, Diagnosis, Options, Seen, Verdict};
use gonio_scene::Capture;
use gonio_scene::capture::CAPTURE_FILE;
use workshop::FarmWorkshop;

const RESULT: &str = "diagnosis.json";
const EVIDENCE: &str = "evidence.json";
const REPORT: &str = "report.html";

/// Diagnoses and writes.
///
/// # Errors
/// A broken capture or photograph, options that make no diagnosis, a farm that fails, a folder that cannot be written to,
/// Ctrl-C.
pub fn run(arguments: &DiagnoseArguments) -> Result<(), Failure> {
    let policy = decide::policy(arguments)?;
    if let Some(file) = &arguments.evidence {
        return decide::again(file, &policy);
    }
    let note = "stopping; again to kill";
    let interrupt = Interrupt::listen(if arguments.farm.json { "" } else { note })?;
    let (Some(capture), Some(out)) = (&arguments.capture, &arguments.out) else {
        return Err(Failure::Input("name a capture and --out, or --evidence".to_owned()));
    };
    let input = Input::open(capture)?;
    check::warn_before(&input.capture, &input.files);
    let written = [CAPTURE_FILE, RESULT, EVIDENCE, REPORT].map(str::to_owned);
    let folder = Folder::create(out, &written, &input.root, &input.capture)?;
    let options = Options {
        seed: arguments.seed,
        samples: arguments.samples,
        policy,
        without: arguments.without.clone(),
        ..Options::default()
    };
    let mut console = Console::new(arguments.farm.json);
    let watch = Watch::open(&arguments.watch, ("Diagnosis", &input.capture.name), &interrupt, &console)?;
    let done = work(arguments, &input, &folder, &options, &mut console, &interrupt, &watch);
    watch.end(&done);
    done
}

fn work(
    arguments: &DiagnoseArguments,
    input: &Input,
    folder: &Folder,
    options: &Options,
    console: &mut Console,
    interrupt: &Interrupt,
    watch: &Watch,
) -> Result<(), Failure> {
    let workshop = FarmWorkshop { farm: farm(&arguments.farm)?, files: &input.files };
    let diagnosed = {
        let mut view = DiagnoseConsole::new(console);
        let mut observer = |event: &gonio_diagnose::DiagnoseEvent| {
            view.show(event);
            watch.diagnose(event);
            interrupt.flow()
        };
        gonio_diagnose::diagnose(&input.capture, options, &workshop, &mut observer)?
    };
    console.end();
    watch.diagnosis(&diagnosed.diagnosis);
    let panels = write(&diagnosed, input, folder)?;
    watch.panels(&diagnosed.last_capture, &panels);
    if arguments.farm.json {
        tell(&to_json(&diagnosed.diagnosis)?);
    } else {
        conclude(&diagnosed.diagnosis, folder);
    }
    match &diagnosed.unjudged {
        Some(why) => Err(Failure::Input(format!("the held-out photos could not be judged: {why}"))),
        None => Ok(()),
    }
}

/// Writes the files; returns the panels of the last model.
fn write(diagnosed: &Diagnosed, input: &Input, folder: &Folder) -> Result<Vec<Panel>, Failure> {
    let mut here = diagnosed.capture.clone();
    relocate(&mut here, &input.root, folder.dir())?;
    for (path, bytes) in &diagnosed.files {
        folder.write(path, bytes)?;
        // These lie beside the extended capture, not beside the one that was diagnosed.
        for (object, moved) in diagnosed.capture.objects.iter().zip(&mut here.objects) {
            if object.mesh == *path {
                moved.mesh.clone_from(path);
            }
        }
    }
    folder.write(CAPTURE_FILE, here.to_toml()?.as_bytes())?;
    folder.write(RESULT, to_pretty_json(&diagnosed.diagnosis)?.as_bytes())?;
    folder.write(EVIDENCE, to_json(&diagnosed.evidence)?.as_bytes())?;
    let panels = |capture: &Capture, seen: &[Seen]| -> Vec<Panel> {
        seen.iter().filter_map(|s| Panel::new(capture, &s.photograph, &s.film, &s.statistics)).collect()
    };
    let files = |capture: &Capture, seen: &[Seen]| -> Vec<ReflectancePanel> {
        let panel = |s: &Seen| ReflectancePanel::new(capture, &s.photograph, &s.pairs, &s.film, &s.statistics);
        seen.iter().filter_map(panel).collect()
    };
    let after = panels(&diagnosed.last_capture, &diagnosed.after);
    let report = DiagnosisReport {
        diagnosis: &diagnosed.diagnosis,
        before: &panels(&diagnosed.base_capture, &diagnosed.before),
        after: &after,
        files_before: &files(&diagnosed.base_capture, &diagnosed.before),
        files_after: &files(&diagnosed.last_capture, &diagnosed.after),
        structure_before: &diagnosed.structure_before,
        structure_after: &diagnosed.structure_after,
        command: &command(),
        version: env!("CARGO_PKG_VERSION"),
    };
    folder.write(REPORT, report.page().as_bytes())?;
    Ok(after)
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
