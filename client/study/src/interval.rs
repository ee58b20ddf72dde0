//! An estimate with its standard error and interval.

use crate::normal::t95;
use serde::Serialize;

/// A number, how far off it may be, and the interval of 95 %.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// The estimate.
    pub value: f64,
    /// Its standard error over observers.
    pub error: f64,
    /// Lower end of the interval of 95 %.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Estimate {
    /// From values of resampled studies of `observers` people each.
    ///
    /// Resampling with replacement spreads by (n - 1) / n too little, and says nothing of how uncertain the spread of few
    /// people itself is: the error is widened by sqrt(n / (n - 1)), the interval taken from Student's t with n - 1 degrees
    /// of freedom. For a mean over observers that is the classical interval.
    pub(crate) fn from_resamples(value: f64, resamples: &[f64], observers: usize) -> Self {
        let (count, n) = (resamples.len() as f64, observers as f64);
        let mean = resamples.iter().sum::<f64>() / count;
        let variance = resamples.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (count - 1.0);
        let error = (variance * n / (n - 1.0)).sqrt();
        let reach = t95(n - 1.0) * error;
        Self { value, error, low: value - reach, high: value + reach }
    }

    /// The same on another scale: `from_resamples` of logarithms, given back as what they are logarithms of.
    pub(crate) fn exponential(self) -> Self {
        let value = libm::exp(self.value);
        Self { value, error: value * self.error, low: libm::exp(self.low), high: libm::exp(self.high) }
    }
}
