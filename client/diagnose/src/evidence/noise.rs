//! How noisy photographs are, beside what their sensor is said to be.

use serde::{Deserialize, Serialize};

/// One channel's noise in the photographs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChannelNoise {
    /// Variance of what no neighbour shares, in units of the variance that the sensor is said to have: 1 where the file is right. Below 1
    /// where neighbours were averaged, as by demosaicing or JPEG. Slightly negative where the render's noise hides it.
    pub variance: f64,
    /// Its standard error.
    pub error: f64,
}

impl ChannelNoise {
    /// How many times as large as stated the noise' standard deviation is, and the standard error of that.
    #[must_use]
    pub fn factor(&self) -> (f64, f64) {
        let factor = self.variance.max(0.0).sqrt();
        (factor, if factor > 0.0 { 0.5 * self.error / factor } else { self.error.max(0.0).sqrt() })
    }
}
