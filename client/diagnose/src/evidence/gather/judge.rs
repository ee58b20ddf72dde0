//! The judgement: both models on the photos that nothing has looked at until now.

use crate::evidence::gather::cross::per_observation;
use crate::evidence::gather::model::Model;
use crate::evidence::gather::quadratic::Quadratic;
use crate::workshop::{Observer, Workshop, evaluate, tell};
use crate::{DiagnoseError, DiagnoseEvent, Options};
use gonio_fit::{Evaluate, Score};
use gonio_scene::capture::{Light, Role};
use gonio_scene::{Capture, EvaluationRequest, Output, PhotoStatistics, Stream};

/// Samples per pixel of the judgement, as a multiple of the fit's: nothing else is rendered of these photos.
const MORE: u32 = 2;

/// Both models' scores on the held-out photos.
#[derive(Debug, Clone, PartialEq)]
pub struct Judgement {
    /// The base model's.
    pub before: Score,
    /// The extended model's.
    pub after: Score,
    /// Mean gain in the logarithm of the predictive density of an observation, in nats.
    pub log_density_gain: f64,
    /// Its standard error by the scatter of the photos; absent with one photo.
    pub standard_error: Option<f64>,
    /// The held-out photos' statistics under both.
    pub photos: [Vec<PhotoStatistics>; 2],
}

/// `model` with the photos of `whole` that it has not seen put back in their places.
///
/// # Errors
/// A capture that the format refuses.
pub fn with_held_out(model: &Model, whole: &Capture) -> Result<Capture, DiagnoseError> {
    let mut capture = model.capture.clone();
    let measured = std::mem::take(&mut capture.reflectance);
    for file in &whole.reflectance {
        capture.reflectance.push(measured.iter().find(|r| r.name() == file.name()).unwrap_or(file).clone());
    }
    let seen = std::mem::take(&mut capture.photos);
    for photo in &whole.photos {
        let mut photo = seen.iter().find(|p| p.name() == photo.name()).unwrap_or(photo).clone();
        if let Some(on) = &mut photo.lights {
            // Lights that the model has added shine in every photo.
            let added = |l: &&Light| !whole.lights.iter().any(|w| w.name == l.name) && !on.contains(&l.name);
            let names: Vec<String> = model.capture.lights.iter().filter(added).map(|l| l.name.clone()).collect();
            on.extend(names);
        }
        capture.photos.push(photo);
    }
    Ok(Capture::parse(&capture.to_toml()?)?)
}

/// Scores both models.
///
/// # Errors
/// A held-out photo that cannot be read, a farm that fails, a cancellation.
pub fn judge(
    base: &Model,
    model: &Model,
    whole: &Capture,
    options: &Options,
    workshop: &dyn Workshop,
    observer: &mut Observer<'_>,
) -> Result<Judgement, DiagnoseError> {
    tell(observer, &DiagnoseEvent::Stage { text: "judging on the held-out photos".to_owned() })?;
    let before = statistics(base, whole, options, workshop, observer)?;
    let after =
        if model.parts.is_empty() { before.clone() } else { statistics(model, whole, options, workshop, observer)? };
    let total = |photos: &[PhotoStatistics]| {
        let mut sum = PhotoStatistics::default();
        photos.iter().for_each(|p| sum.add(p));
        sum
    };
    let (sum_before, sum_after) = (total(&before), total(&after));
    let density = |p: &PhotoStatistics| -0.5 * (p.log_variance + p.loss());
    let gains: Vec<f64> = before.iter().zip(&after).map(|(b, a)| density(a) - density(b)).collect();
    let (log_density_gain, standard_error) = per_observation(&gains, sum_before.observations);
    Ok(Judgement {
        before: Score::new(&sum_before, 0),
        after: Score::new(&sum_after, 0),
        log_density_gain,
        standard_error: (gains.len() > 1).then_some(standard_error),
        photos: [before, after],
    })
}

/// The held-out photos' statistics under a model. Where the model gives every photo a gain of its own, so has each of
/// these: the one number that it cannot predict is fitted to the photo before the photo is scored.
fn statistics(
    model: &Model,
    whole: &Capture,
    options: &Options,
    workshop: &dyn Workshop,
    observer: &mut Observer<'_>,
) -> Result<Vec<PhotoStatistics>, DiagnoseError> {
    let capture = with_held_out(model, whole)?;
    let photos: Vec<usize> =
        capture.targets().enumerate().filter(|(_, t)| t.role() == Role::HeldOut).map(|(i, _)| i).collect();
    let mut farm = workshop.open(&capture, &model.files)?;
    let mut request = EvaluationRequest {
        photos: photos.clone(),
        samples: MORE * options.samples,
        seed: Stream::Fit.seed(options.seed.wrapping_add(2)),
        output: Output::Statistics,
        ..EvaluationRequest::default()
    };
    let keys: Vec<&str> = model.parts.iter().filter_map(|p| p.variant.of_held_out).collect();
    if !keys.is_empty() {
        request.numbers = own_numbers(&capture, &photos, &keys, &request, farm.as_mut(), observer)?;
    }
    Ok(evaluate(farm.as_mut(), &request, observer)?.photos)
}

/// The numbers that each of `photos` has to itself, fitted to it by the quadratic of one evaluation.
fn own_numbers(
    capture: &Capture,
    photos: &[usize],
    keys: &[&str],
    request: &EvaluationRequest,
    farm: &mut dyn Evaluate,
    observer: &mut Observer<'_>,
) -> Result<Vec<(String, f64)>, DiagnoseError> {
    let of = |photo: &usize| keys.iter().map(|key| format!("photo.{}.{key}", capture.photos[*photo].name())).collect();
    let names: Vec<Vec<String>> = photos.iter().map(of).collect();
    let columns = capture.parameters(&names.concat(), &[])?;
    let found = evaluate(farm, &EvaluationRequest { columns: columns.clone(), ..request.clone() }, observer)?;
    let mut numbers = Vec::new();
    for (names, statistics) in names.iter().zip(&found.photos) {
        let below = |name: &str| names.iter().any(|n| name == n || name.starts_with(&format!("{n}.")));
        let own: Vec<usize> = (0..columns.len()).filter(|i| below(&columns[*i].name)).collect();
        let step = Quadratic::new(statistics, &own.iter().map(|i| (*i, 1.0)).collect::<Vec<_>>()).solve();
        for (i, step) in own.iter().zip(&step) {
            let column = &columns[*i];
            numbers.push((column.name.clone(), (column.value + step).clamp(column.range.min, column.range.max)));
        }
    }
    Ok(numbers)
}
