//! `gonio check`: everything that is wrong with a capture, and what it consists of.

mod inside;
mod light;
mod object;
mod photo;
mod placed;
mod reflectance;
mod text;
mod vector;
mod winding;

use crate::arguments::CheckArguments;
use crate::failure::Failure;
use crate::input;
use crate::output::{tell, tell_error, to_json};
use crate::progress::{Console, plural};
use gonio_scene::capture::{Range, Role};
use gonio_scene::files::{DirectoryFiles, Files};
use gonio_scene::{Capture, SceneError};
use light::LightSummary;
use object::ObjectSummary;
use photo::PhotoSummary;
use reflectance::ReflectanceSummary;
use serde::Serialize;

/// What is known of a capture after looking at all of its files.
#[derive(Debug, Default, Serialize)]
struct Summary {
    /// The capture's name; empty where its `capture.toml` cannot be read.
    capture: String,
    /// Whether there is no error.
    valid: bool,
    /// What keeps it from being rendered or fitted.
    errors: Vec<String>,
    /// What is likely a mistake.
    warnings: Vec<String>,
    photos: Vec<PhotoSummary>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    reflectance: Vec<ReflectanceSummary>,
    objects: Vec<ObjectSummary>,
    lights: Vec<LightSummary>,
    /// What a fit would free.
    parameters: Vec<Number>,
    /// Every number, where asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    numbers: Option<Vec<Number>>,
}

/// A number of the capture; a bound is absent where there is none.
#[derive(Debug, Serialize)]
struct Number {
    name: String,
    value: f64,
    min: Option<f64>,
    max: Option<f64>,
}

impl Number {
    fn new(name: String, value: f64, range: Range) -> Self {
        let min = (range.min > f64::MIN).then_some(range.min);
        let max = (range.max < f64::MAX).then_some(range.max);
        Self { name, value, min, max }
    }
}

/// Checks and tells.
///
/// # Errors
/// The capture has errors; they have been told.
pub fn run(arguments: &CheckArguments) -> Result<(), Failure> {
    let root = input::folder(&arguments.capture)?;
    let summary = summarise(&DirectoryFiles::new(root), arguments.names);
    if arguments.json {
        tell(&to_json(&summary)?);
    } else {
        // Errors first on their own stream, one line each.
        for error in &summary.errors {
            tell_error(&format!("error: {error}"));
        }
        tell(text::text(&summary).trim_end());
    }
    let path = arguments.capture.display();
    match summary.errors.len() {
        0 => Ok(()),
        n => Err(Failure::Input(format!("{path}: has {}; mend and check again", plural(n, "error")))),
    }
}

/// Warns of what [`run`] would, as far as it can be known without a photo's pixels: a fit must not
/// read those that are held out.
pub(super) fn warn_before(capture: &Capture, files: &dyn Files, console: &Console) {
    let (mut errors, mut warnings) = (Vec::new(), Vec::new());
    photo::look_at_claims(capture, files, &mut warnings);
    object::look(capture, files, &mut errors, &mut warnings);
    light::look(capture, files, &mut errors, &mut warnings);
    // What is an error here stops the fit by itself.
    for warning in warnings {
        console.warn(&warning);
    }
}

fn summarise(files: &dyn Files, names: bool) -> Summary {
    let mut summary = Summary::default();
    match Capture::read(files) {
        Ok(capture) => look(&capture, files, names, &mut summary),
        // What it names is not known without it.
        Err(error) => summary.errors.push(error.to_string()),
    }
    summary.valid = summary.errors.is_empty();
    summary
}

fn look(capture: &Capture, files: &dyn Files, names: bool, summary: &mut Summary) {
    summary.capture.clone_from(&capture.name);
    let mut errors: Vec<SceneError> = Vec::new();
    summary.photos = photo::look(capture, files, &mut errors, &mut summary.warnings);
    photo::look_at_claims(capture, files, &mut summary.warnings);
    summary.reflectance = reflectance::look(capture, files, &mut errors, &mut summary.warnings);
    summary.objects = object::look(capture, files, &mut errors, &mut summary.warnings);
    summary.lights = light::look(capture, files, &mut errors, &mut summary.warnings);
    errors.sort_by(|a, b| (&a.file, &a.key).cmp(&(&b.file, &b.key)));
    errors.dedup();
    summary.errors.extend(errors.iter().map(ToString::to_string));
    // `Capture::read` has refused what would be an error here.
    for parameter in capture.free_parameters().unwrap_or_default() {
        if parameter.value <= parameter.range.min || parameter.value >= parameter.range.max {
            summary.warnings.push(format!(
                "capture.toml: {} starts at its bound {}: a fit starts just inside of it; a value in between starts better",
                parameter.name, parameter.value
            ));
        }
        summary.parameters.push(Number::new(parameter.name, parameter.value, parameter.range));
    }
    if summary.parameters.is_empty() {
        summary.warnings.push("capture.toml: fit.parameters is empty: `gonio fit` has nothing to estimate".to_owned());
    }
    if capture.targets().all(|target| target.role() == Role::HeldOut) {
        summary.warnings.push("capture.toml: every photo is held out: there is none to fit to".to_owned());
    }
    if names {
        let all = capture.numbers().into_iter().map(|(name, (value, range))| Number::new(name, value, range));
        summary.numbers = Some(all.collect());
    }
}
