//! A model on its way: the capture with what was added to it, fitted to the photos that are not held out.

use crate::effects::{Effect, Variant};
use crate::evidence::gather::cross;
use crate::evidence::gather::measured;
use crate::evidence::gather::quadratic::Quadratic;
use crate::overlay::AddedFile;
use crate::workshop::{Observer, Workshop, evaluate};
use crate::{DiagnoseError, DiagnoseEvent};
use gonio_fit::{Evaluate, FitError, FitResult, Options, Space};
use gonio_scene::{Capture, EvaluationRequest, Output, PhotoStatistics, Stream};
use std::ops::ControlFlow;

/// An effect that is part of a model.
#[derive(Debug, Clone)]
pub struct Part {
    /// The effect.
    pub effect: &'static Effect,
    /// How it is present.
    pub variant: Variant,
}

/// A fitted model.
#[derive(Debug, Clone)]
pub struct Model {
    /// The capture at the fitted values, without held-out photos.
    pub capture: Capture,
    /// Files that its effects brought.
    pub files: Vec<AddedFile>,
    /// Its effects, in the order in which they were added.
    pub parts: Vec<Part>,
    /// The fit.
    pub fit: FitResult,
    /// Each photo's deviance when fitted to the others.
    pub left_out: Vec<f64>,
}

impl Model {
    /// Fits a capture.
    ///
    /// # Errors
    /// A fit that fails or is cancelled.
    pub fn fit(
        capture: &Capture,
        files: Vec<AddedFile>,
        parts: Vec<Part>,
        options: &Options,
        workshop: &dyn Workshop,
        observer: &mut Observer<'_>,
    ) -> Result<Self, DiagnoseError> {
        let mut farm = workshop.open(capture, &files)?;
        let mut fit = fitted(capture, options, farm.as_mut(), observer)?;
        let capture = fit.apply(capture)?;
        if fit.samples < options.max_samples {
            // Chi-squares compare only between equal samples, and a fit may end with fewer.
            fit.photos = statistics(&capture, &all(&capture), true, options, farm.as_mut(), observer)?;
        }
        let left_out = left_out(&capture, &fit, &fit.photos, 0);
        Ok(Self { capture, files, parts, fit, left_out })
    }

    /// Pixels times channels of the fitted photos.
    #[must_use]
    pub fn observations(&self) -> u64 {
        self.fit.fit.observations
    }

    /// Largest value among the fitted photos.
    #[must_use]
    pub fn peak(&self) -> f64 {
        self.fit.photos.iter().map(|p| p.peak).fold(0.0, f64::max)
    }

    /// What a score that is due to noise alone comes to per degree of freedom: 1 for the photos' noise, more by what the render's
    /// adds to the gradient.
    #[must_use]
    pub fn dispersion(&self) -> f64 {
        let columns: Vec<(usize, f64)> = (0..self.fit.parameters.len()).map(|i| (i, 1.0)).collect();
        Quadratic::sum(&self.fit.photos.iter().map(|p| Quadratic::new(p, &columns)).collect::<Vec<_>>())
            .map_or(1.0, |total| total.dispersion())
    }

    /// Reduced chi-square of the fitted photos, at the samples that models are compared with.
    #[must_use]
    pub fn reduced_chi_square(&self) -> f64 {
        gonio_fit::Normal::new(&self.fit.photos, &[]).total.reduced_chi_square()
    }

    /// The same model by other statistics at its values, whose first columns are its own.
    #[must_use]
    pub fn with_statistics(&self, photos: Vec<PhotoStatistics>) -> Self {
        let mut model = self.clone();
        model.left_out = left_out(&model.capture, &model.fit, &photos, 0);
        model.fit.photos = photos;
        model
    }

    /// Each photo's deviance when fitted to the others, from other statistics at this model's values, whose first columns are
    /// its own; the `further` columns after these are fitted as well.
    #[must_use]
    pub fn left_out_with(&self, photos: &[PhotoStatistics], further: usize) -> Vec<f64> {
        left_out(&self.capture, &self.fit, photos, further)
    }
}

/// Indices of all of a capture's targets.
pub(crate) fn all(capture: &Capture) -> Vec<usize> {
    (0..capture.targets().count()).collect()
}

/// Statistics of some of a capture's photos at its own values, by the samples that models are compared with; with the
/// derivatives of its free parameters if these are `wanted`.
pub(crate) fn statistics(
    capture: &Capture,
    photos: &[usize],
    wanted: bool,
    options: &Options,
    farm: &mut dyn Evaluate,
    observer: &mut Observer<'_>,
) -> Result<Vec<PhotoStatistics>, DiagnoseError> {
    let space = Space::new(capture, &[])?;
    let request = EvaluationRequest {
        numbers: space.numbers(space.start()),
        columns: if wanted { space.columns(space.start()) } else { Vec::new() },
        photos: photos.to_vec(),
        samples: options.max_samples,
        difference_samples: options.difference_samples,
        forward_samples: options.forward_samples,
        seed: Stream::Fit.seed(options.seed),
        output: Output::Statistics,
    };
    Ok(evaluate(farm, &request, observer)?.photos)
}

/// Fits a capture under the observer's eyes.
pub(crate) fn fitted(
    capture: &Capture,
    options: &Options,
    farm: &mut dyn Evaluate,
    observer: &mut Observer<'_>,
) -> Result<FitResult, DiagnoseError> {
    let exact = measured::exact(options);
    let options = if measured::alone(capture) { &exact } else { options };
    let mut stopped = false;
    let fit = gonio_fit::fit(capture, farm, options, &mut |event| {
        let flow = observer(&DiagnoseEvent::Fit { fit: event.clone() });
        stopped |= flow == ControlFlow::Break(());
        flow
    });
    if stopped || matches!(fit, Err(FitError::Cancelled)) {
        return Err(DiagnoseError::Cancelled);
    }
    Ok(fit?)
}

fn left_out(capture: &Capture, fit: &FitResult, photos: &[PhotoStatistics], further: usize) -> Vec<f64> {
    let own = |column: usize, photo: usize| {
        let name =
            fit.photos.get(photo).and_then(|p| capture.photos.get(p.photo)).map(gonio_scene::capture::Photo::name);
        let prefix = name.map(|n| format!("photo.{n}."));
        prefix.is_some_and(|p| fit.parameters.get(column).is_some_and(|e| e.name.starts_with(&p)))
    };
    let mut deviances = cross::left_out(photos, fit.parameters.len() + further, &own);
    if further == 0 {
        // At a fit's optimum none is predicted better by the others than where it was fitted along; what says so is noise in
        // the derivatives of few samples, whose products are no squares.
        for (deviance, p) in deviances.iter_mut().zip(photos) {
            *deviance = deviance.max(p.loss());
        }
    }
    deviances
}
