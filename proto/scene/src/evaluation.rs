//! An evaluation: "render these photos at these parameters, and give me loss, normal equations or images".

use crate::parameter::Parameter;
use crate::statistics::PhotoStatistics;

/// What a client asks for, besides the capture.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EvaluationRequest {
    /// Numbers that differ from the capture's file, by dotted name.
    pub numbers: Vec<(String, f64)>,
    /// The derivatives wanted, in the order of the Gram matrix's columns after the residual.
    pub columns: Vec<Parameter>,
    /// Indices of the photos.
    pub photos: Vec<usize>,
    /// Samples per pixel, both halves together; even, at least 2.
    pub samples: u32,
    /// Samples per pixel of the images that are finite differences, both halves together; at most `samples`, and 0
    /// stands for as many. Each task takes its share of them, rounded up, from the front of its samples.
    pub difference_samples: u32,
    /// The same of the images that are carried along the paths: a column's noise is no error of what it says of the residual,
    /// which has all samples.
    pub forward_samples: u32,
    /// Seed of every random number.
    pub seed: u64,
    /// What is computed from the samples.
    pub output: Output,
}

/// What an evaluation returns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Output {
    /// Statistics against the photographs, of masked pixels that are not clipped. Only those pixels are rendered.
    #[default]
    Statistics,
    /// Statistics as above, and the mean film of every pixel (exposed light, see [`Film`]).
    StatisticsAndFilms,
    /// Films of every pixel; the photographs' files are not opened, so they need not exist.
    Films,
    /// First-hit buffers through pixel centres ([`crate::film::FIRST_HIT_CHANNELS`]); no photographs needed.
    FirstHit,
}

impl Output {
    /// Whether photographs are compared with.
    #[must_use]
    pub fn compares(self) -> bool {
        matches!(self, Self::Statistics | Self::StatisticsAndFilms)
    }

    /// Whether images come back.
    #[must_use]
    pub fn has_films(self) -> bool {
        self != Self::Statistics
    }
}

/// A photo-sized image of several channels, planar.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Film {
    /// Index of the photo.
    pub photo: usize,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Channel by channel, each row-major with the top row first. Radiance films: R G B of exposed
    /// light, which [`crate::SensorStage::photo_values`] makes photo values of. First hits:
    /// [`crate::film::FIRST_HIT_CHANNELS`].
    pub channels: Vec<Vec<f32>>,
}

/// The answer to a request.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Evaluation {
    /// One entry per photo of the request, in its order. Empty where nothing was compared.
    pub photos: Vec<PhotoStatistics>,
    /// One entry per photo of the request, in its order, where films were asked for.
    pub films: Vec<Film>,
    /// Camera samples traced, central differences not counted.
    pub primary_samples: u64,
    /// Samples that were NaN or infinite and count as black.
    pub invalid_samples: u64,
}

/// What streams back while an evaluation runs.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Progress {
    /// Tasks committed.
    pub tasks_done: u64,
    /// Tasks in all.
    pub tasks: u64,
    /// Camera samples traced so far.
    pub primary_samples: u64,
    /// Mean weighted squared error per observation of what is committed (debiased), if anything was compared.
    pub loss: f64,
    /// Standard error of `loss` that is due to the render's noise.
    pub loss_standard_error: f64,
    /// Workers connected.
    pub workers: u32,
}
