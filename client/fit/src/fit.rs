//! The fit itself: from a capture to estimates with errors.

use crate::checkpoint::{Identity, Journal};
use crate::objective::{Objective, Observer, Stopped};
use crate::result::{Estimate, LossPoint};
use crate::solve::{self, Outcome};
use crate::uncertainty::Uncertainty;
use crate::{Evaluate, FitError, FitEvent, FitResult, Normal, Options, Score, Space, warnings};
use gonio_scene::Capture;
use gonio_scene::capture::Role;
use std::time::Instant;

/// Fits the capture's free parameters to its photos and measured reflectance with the role `fit`; what is held out are evaluated once, after the
/// last iteration, for their score alone.
///
/// The observer sees every event and may break at any of them; the fit then ends with what it has, not converged, as
/// it does where `evaluate` reports a cancellation. The same capture, options and evaluations give the same result to
/// the last bit, `seconds` excepted, whether or not the fit was interrupted and resumed.
///
/// # Errors
/// See [`FitError`].
pub fn fit<'a>(
    capture: &'a Capture,
    evaluate: &'a mut dyn Evaluate,
    options: &Options,
    observer: &'a mut Observer<'a>,
) -> Result<FitResult, FitError> {
    let begin = Instant::now();
    options.check()?;
    let options = &options.for_capture(capture);
    let space = Space::new(capture, &options.start)?;
    let of_role = |role| -> Vec<usize> {
        capture.targets().enumerate().filter(|(_, t)| t.role() == role).map(|(i, _)| i).collect()
    };
    let (fitted, held_out) = (of_role(Role::Fit), of_role(Role::HeldOut));
    if fitted.is_empty() {
        return Err(FitError::NoFitPhotos);
    }
    let identity = Identity {
        solver: options.solver,
        seed: options.seed,
        start: space.start().to_vec(),
        capture: capture.to_toml()?,
        files: options.files.clone(),
    };
    let journal = Journal::new(&identity, options.resume.as_ref(), options.checkpoint.as_deref())?;
    let started = FitEvent::Started {
        solver: options.solver,
        parameters: space.names(),
        start: space.start().to_vec(),
        fit_photos: fitted.len(),
        held_out_photos: held_out.len(),
        resumed: options.resume.is_some(),
    };
    let objective = Objective::new(capture, &space, fitted, options, journal, evaluate, observer);
    let end = objective.tell(&started).and_then(|()| estimate(&objective, options));
    let mut result = match end {
        Ok(outcome) => conclude(&objective, capture, options, &outcome, &held_out)?,
        Err(Stopped) => keep(&objective, capture, options)?,
    };
    result.seconds = begin.elapsed().as_secs_f64();
    let finished = FitEvent::Finished {
        converged: result.converged,
        iterations: result.iterations,
        primary_samples: result.primary_samples,
        seconds: result.seconds,
    };
    // Too late to cancel anything.
    let _ = objective.tell(&finished);
    Ok(result)
}

/// Runs the solver; with nothing to solve for, evaluates at the most samples allowed.
fn estimate(objective: &Objective<'_>, options: &Options) -> Result<Outcome, Stopped> {
    if objective.space.is_empty() {
        return Ok(Outcome {
            position: Vec::new(),
            evaluated: Vec::new(),
            samples: options.max_samples,
            converged: true,
        });
    }
    solve::solve(objective, options)
}

/// The result of a solver that has come to its end.
fn conclude(
    objective: &Objective<'_>,
    capture: &Capture,
    options: &Options,
    outcome: &Outcome,
    held_out: &[usize],
) -> Result<FitResult, FitError> {
    let (u, samples) = (&outcome.position, outcome.samples);
    if objective.normal(&outcome.evaluated, samples).is_err() {
        return keep(objective, capture, options);
    }
    let score = match held_out {
        [] => None,
        photos => match objective.score(u, samples, photos.to_vec()) {
            Ok(score) => Some(score),
            Err(Stopped) => return keep(objective, capture, options),
        },
    };
    let mut result = summarise(objective, capture, options, u, &outcome.evaluated)?;
    result.converged = outcome.converged;
    if let Some((total, primary_samples)) = score {
        result.primary_samples += primary_samples;
        result.held_out = Some(Score::new(&total, 0));
        result.warnings.extend(warnings::about_samples("held-out", total.invalid_samples));
    }
    if !outcome.converged {
        let out_of_iterations = result.iterations >= options.iterations();
        let why = if out_of_iterations { "the iterations ran out" } else { "no further step lowers the loss" };
        result.warnings.insert(0, format!("not converged: {why} before the step left was below the tolerance"));
    }
    if let Some(entry) = objective.known(&outcome.evaluated) {
        let uncertainty = Uncertainty::new(&entry.photos, &vec![1.0; objective.space.len()]);
        result.warnings.extend(warnings::about_scores(&uncertainty, &result.fit, result.held_out.as_ref()));
    }
    Ok(result)
}

/// What is left of a fit that was stopped: its last point if it was cancelled, else the error.
fn keep(objective: &Objective<'_>, capture: &Capture, options: &Options) -> Result<FitResult, FitError> {
    match objective.reason() {
        Some(FitError::Cancelled) | None => {}
        Some(error) => return Err(error),
    }
    let (u, _) = objective.position().ok_or(FitError::Cancelled)?;
    let mut result = summarise(objective, capture, options, &u, &u)?;
    result.warnings.insert(0, "cancelled: these are the values reached by then, not the fit's result".to_owned());
    Ok(result)
}

/// Estimates at coordinates `u`, with the errors and the fit's score from what was evaluated there or beside.
fn summarise(
    objective: &Objective<'_>,
    capture: &Capture,
    options: &Options,
    u: &[f64],
    evaluated: &[f64],
) -> Result<FitResult, FitError> {
    let space = objective.space;
    let entry = objective.known(evaluated).ok_or(FitError::Cancelled)?;
    let values = space.values(u);
    let uncertainty = entry.columns.then(|| Uncertainty::new(&entry.photos, &vec![1.0; space.len()]));
    let finite = |list: Option<&Vec<f64>>, i: usize| list.and_then(|l| l.get(i)).copied().filter(|e| e.is_finite());
    let parameters = space
        .names()
        .into_iter()
        .enumerate()
        .map(|(i, name)| Estimate {
            name,
            start: space.start()[i],
            value: values[i],
            standard_error: finite(uncertainty.as_ref().map(|u| &u.standard_errors), i),
            model_error: finite(uncertainty.as_ref().map(|u| &u.model), i),
            between_photos_error: finite(uncertainty.as_ref().and_then(|u| u.between_photos.as_ref()), i),
        })
        .collect();
    let total = Normal::new(&entry.photos, &[]).total;
    let iterations = objective.iterations();
    let mut warnings = uncertainty.as_ref().map(|u| warnings::about(space, &values, u)).unwrap_or_default();
    warnings.extend(warnings::about_samples("fitted", total.invalid_samples));
    Ok(FitResult {
        capture: capture.name.clone(),
        converged: false,
        iterations: objective.iteration_count(),
        seconds: 0.0,
        primary_samples: objective.primary_samples(),
        seed: options.seed,
        solver: options.solver,
        samples: entry.samples,
        parameters,
        fit: Score::new(&total, space.len()),
        held_out: None,
        correlations: uncertainty.as_ref().map(|u| u.correlations.clone()).unwrap_or_default(),
        warnings,
        loss_curve: iterations.iter().map(LossPoint::from).collect(),
        photos: entry.photos.clone(),
    })
}
