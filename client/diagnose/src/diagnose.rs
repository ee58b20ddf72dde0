//! A diagnosis from end to end.

use crate::conclude::conclude;
use crate::decide::{self, Action, BASE};
use crate::evidence::Evidence;
use crate::evidence::gather::Gatherer;
use crate::overlay::AddedFile;
use crate::result::Diagnosis;
use crate::workshop::{Observer, Workshop, tell};
use crate::{DiagnoseError, DiagnoseEvent, Options, Seen, Structure};
use gonio_fit::FitError;
use gonio_scene::Capture;
use gonio_scene::capture::Role;
use std::time::Instant;

/// A diagnosis and what a report shows besides.
#[derive(Debug, Clone)]
pub struct Diagnosed {
    /// The outcome.
    pub diagnosis: Diagnosis,
    /// What it was decided from.
    pub evidence: Evidence,
    /// The extended, fitted capture with all of its photos; the base model's where nothing was found.
    pub capture: Capture,
    /// Files that the extension brought.
    pub files: Vec<AddedFile>,
    /// The base model's capture, without held-out photos.
    pub base_capture: Capture,
    /// The final model's, without held-out photos.
    pub last_capture: Capture,
    /// The fitted photos under the base model.
    pub before: Vec<Seen>,
    /// The fitted photos under the final model.
    pub after: Vec<Seen>,
    /// What each covariate explains before.
    pub structure_before: Vec<Structure>,
    /// And after.
    pub structure_after: Vec<Structure>,
    /// Why the held-out photos could not be judged, if so: the rest stands.
    pub unjudged: Option<String>,
}

/// Diagnoses a capture. Held-out photos are not even opened before the selection has ended.
///
/// The same capture, options and farm results give the same diagnosis to the last bit, `seconds` excepted.
///
/// # Errors
/// See [`DiagnoseError`]. A held-out photo that cannot be read is no error: the selection stands unjudged.
pub fn diagnose(
    whole: &Capture,
    options: &Options,
    workshop: &dyn Workshop,
    observer: &mut Observer<'_>,
) -> Result<Diagnosed, DiagnoseError> {
    let begin = Instant::now();
    if !whole.targets().any(|t| t.role() == Role::Fit) {
        return Err(FitError::NoFitPhotos.into());
    }
    let mut gatherer = Gatherer::new(whole, options.shared_among(pixels(whole)), workshop)?;
    let mut told = 0;
    let decision = loop {
        match decide::next(&gatherer.evidence, &options.policy) {
            Action::Finish(decision) => break decision,
            action => {
                tell_of_extension(&gatherer.evidence, &action, &mut told, observer)?;
                gatherer.perform(&action, observer)?;
            }
        }
    };
    let mut done = conclude(whole, &gatherer, &decision, options)?;
    done.diagnosis.seconds = begin.elapsed().as_secs_f64();
    Ok(done)
}

/// Pixels of the photos that are fitted to.
fn pixels(whole: &Capture) -> u64 {
    let fitted = whole.photos.iter().filter(|p| p.role == Role::Fit).map(|p| whole.camera_of(p));
    fitted.map(|c| u64::from(c.width) * u64::from(c.height)).sum()
}

/// Tells that a model was extended, once it is gone on from.
fn tell_of_extension(
    evidence: &Evidence,
    action: &Action,
    told: &mut usize,
    observer: &mut Observer<'_>,
) -> Result<(), DiagnoseError> {
    let (Action::Score { model, .. } | Action::Remove { model, .. } | Action::Settle { model }) = action else {
        return Ok(());
    };
    if *model == BASE || *model <= *told {
        return Ok(());
    }
    *told = *model;
    match evidence.models[*model].parts.last() {
        Some(part) => tell(observer, &DiagnoseEvent::Extended { effect: part.effect.clone() }),
        None => Ok(()),
    }
}
