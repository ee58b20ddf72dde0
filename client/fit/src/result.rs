//! What a fit returns, and writes as `fit.json`.

use crate::event::Iteration;
use crate::normal::count;
use crate::uncertainty::reduced_chi_square;
use crate::{FitError, SolverName};
use gonio_scene::{Capture, PhotoStatistics};
use serde::{Deserialize, Serialize};

/// The outcome of a fit. Serialised, it is `fit.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FitResult {
    /// The capture's name.
    pub capture: String,
    /// Whether the step left at the end was below the tolerance.
    pub converged: bool,
    /// Iterations of the optimiser, refused steps included.
    pub iterations: u32,
    /// Wall-clock time in seconds.
    pub seconds: f64,
    /// Camera samples of all evaluations; central differences not counted.
    pub primary_samples: u64,
    /// Seed of every random number.
    pub seed: u64,
    /// The optimiser.
    pub solver: SolverName,
    /// Samples per pixel at the end.
    pub samples: u32,
    /// The estimates, in the order of the capture's `[fit]`.
    pub parameters: Vec<Estimate>,
    /// Score on the photos fitted to; chi-square per observation less parameters. Where the last step was shorter than a
    /// standard error, from before it: chi-square differs by less than the number of parameters.
    pub fit: Score,
    /// Score on the held-out photos, chi-square per observation; absent without any, or where the fit was cancelled.
    pub held_out: Option<Score>,
    /// Correlation matrix of the estimates, rows in parameter order; empty where no derivatives were evaluated.
    pub correlations: Vec<Vec<f64>>,
    /// What the reader must know, in plain words.
    pub warnings: Vec<String>,
    /// The loss after each iteration.
    pub loss_curve: Vec<LossPoint>,
    /// The fitted photos' statistics that all of this follows from, with the normal equations in physical units.
    #[serde(skip)]
    pub photos: Vec<PhotoStatistics>,
}

/// One parameter's estimate in physical units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Dotted name.
    pub name: String,
    /// Where the fit started.
    pub start: f64,
    /// The estimate.
    pub value: f64,
    /// Its standard error: the larger of the two below; absent where the data
    /// say nothing about the parameter.
    pub standard_error: Option<f64>,
    /// From the curvature of the loss, scaled by the root of reduced chi-square where that exceeds 1.
    pub model_error: Option<f64>,
    /// From the scatter between photos; absent with one photo.
    pub between_photos_error: Option<f64>,
}

/// How well renders match photos.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// Masked, unclipped pixels, three channels each.
    pub observations: u64,
    /// 1 for a right model: the loss, which the render's noise does not move, over what the photos' noise alone would make
    /// of it, per degree of freedom. See [`gonio_scene::statistics`].
    pub reduced_chi_square: f64,
    /// Standard error of `reduced_chi_square` that is due to the render's noise.
    #[serde(default)]
    pub chi_square_error: f64,
    /// Root of the mean squared residual, in photo values, without the render's noise.
    pub rmse: f64,
    /// 10 log10(peak^2 / mean squared residual) in dB, with the largest photo value as peak; absent for a perfect
    /// match.
    pub psnr: Option<f64>,
    /// Mean logarithm of the predictive density of an observation (Gaussian, the sensor's variance), in nats.
    pub log_density: f64,
}

/// One point of the loss curve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LossPoint {
    /// Counts from 1.
    pub iteration: u32,
    /// Samples per pixel.
    pub samples: u32,
    /// See [`Iteration::loss`].
    pub loss: f64,
    /// See [`Iteration::standard_error`].
    pub standard_error: f64,
}

impl Score {
    /// The score of summed photos; `parameters` is how many were fitted to them.
    #[must_use]
    pub fn new(total: &PhotoStatistics, parameters: usize) -> Self {
        let observations = count(total.observations).max(1.0);
        let mean_square = total.squared_error.max(0.0) / observations;
        let two_pi = libm::log(2.0 * std::f64::consts::PI);
        Self {
            observations: total.observations,
            reduced_chi_square: reduced_chi_square(total, parameters),
            chi_square_error: total.chi_square_error(),
            rmse: mean_square.sqrt(),
            psnr: (mean_square > 0.0 && total.peak > 0.0)
                .then(|| 10.0 * libm::log10(total.peak * total.peak / mean_square)),
            log_density: -0.5 * (two_pi + (total.log_variance + total.loss()) / observations),
        }
    }
}

impl From<&Iteration> for LossPoint {
    fn from(i: &Iteration) -> Self {
        Self { iteration: i.iteration, samples: i.samples, loss: i.loss, standard_error: i.standard_error }
    }
}

impl FitResult {
    /// The capture with the estimates in place of its first guesses.
    ///
    /// # Errors
    /// A capture other than the one that was fitted.
    pub fn apply(&self, capture: &Capture) -> Result<Capture, FitError> {
        let mut fitted = capture.clone();
        let mut numbers = Vec::new();
        for parameter in capture.free_parameters()? {
            if let Some(estimate) = self.parameters.iter().find(|e| e.name == parameter.name) {
                numbers.extend(parameter.numbers(estimate.value));
            }
        }
        fitted.set_numbers(&numbers)?;
        Ok(fitted)
    }
}
