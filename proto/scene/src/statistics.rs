//! The yardstick: how far a render is from a photograph, in numbers that the render's own noise does not move.
//!
//! An observation is one colour channel of a pixel that counts. With `y` the photo's value, `A` and `B` the values that the
//! two half buffers predict, and `e_A = A - y`, `e_B = B - y`:
//!
//! ```text
//! w      = 1 / v(r)            r: mean of y over the pixels around this one, v: the sensor's variance at a value
//! loss   = sum of w e_A e_B    E[loss] = sum of w (true residual)^2, for any number of samples
//! floor  = sum of w v(y)       E[floor] = sum of w (variance of the photo's noise)
//! chi-square per observation = loss / floor
//! ```
//!
//! Three properties make models comparable, and each follows from one line above:
//!
//! - *No candidate moves a weight.* `w` is a function of the photograph and of the sensor's stated noise. A model cannot lower its
//!   loss by being noisy or by being bright.
//! - *A weight does not know its own pixel's noise*: `r` leaves the pixel out. So E[w n] = 0 for the photo's noise `n`, and the
//!   minimum of the loss is not pulled. `v` is linear (`read_noise^2 + shot_noise y`), hence E[v(y)] is the variance of `n`, whatever
//!   `r` is: for the right model loss / floor is 1 in expectation, at edges as well, where the neighbours say little.
//! - *The render's noise cancels*: the halves are independent, so E[e_A e_B] has no term of their variance, where a plain square
//!   has (Azinovic et al. 2019, "Inverse Path Tracing for Joint Material and Lighting Estimation", section 5).
//!
//! What the render's noise does is make the *estimate* of the loss uncertain. That is [`PhotoStatistics::noise`]. More samples lower
//! it; nothing is divided by it.

/// What one photo's comparison with its render amounts to. Sums run over observations: masked, unclipped pixels, each
/// of three channels.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PhotoStatistics {
    /// Index of the photo.
    pub photo: usize,
    /// Number of observations; where pixels were drawn, the estimate of it, rounded tile by tile.
    pub observations: u64,
    /// Observations that were really compared: fewer where pixels were drawn.
    pub compared: u64,
    /// Gram matrix of [render - photo, d/d column...] under the weights `w`, `(1 + columns)^2` numbers, row-major, symmetric.
    /// Products of the two half buffers, so that Monte Carlo noise adds no bias; hence its diagonal may be negative where
    /// there is nothing but noise.
    pub gram: Vec<f64>,
    /// Covariance of the first column of `gram` (the loss, then J'We by column) that is due to the render's noise; of the same
    /// shape. Its first number is the variance of the loss.
    pub noise: Vec<f64>,
    /// What drawing pixels adds to the covariance of J'We, of the shape of `gram`: the sum of (h^2 - h) w D D' over those that were
    /// drawn, each of which stands for h. Row and column of the residual are zero. Empty where all pixels were compared.
    pub draw: Vec<f64>,
    /// Sum of w v(y): the expectation of the loss under a right model.
    pub noise_floor: f64,
    /// Sum of w times the variance of the render (the mean of the halves): what a plain square would add to the loss.
    pub render_noise: f64,
    /// Sum of e_A e_B, in photo values squared.
    pub squared_error: f64,
    /// Sum of the natural logarithm of 1 / w: what a log density needs beside the loss. The same for every model.
    pub log_variance: f64,
    /// Largest photo value among the observations, the peak of a PSNR.
    pub peak: f64,
    /// Samples that were NaN or infinite and count as black.
    pub invalid_samples: u64,
}

impl PhotoStatistics {
    /// The weighted squared error, free of the render's noise in expectation.
    #[must_use]
    pub fn loss(&self) -> f64 {
        self.gram.first().copied().unwrap_or(0.0)
    }

    /// Variance of [`PhotoStatistics::loss`] that is due to the render's noise.
    #[must_use]
    pub fn loss_variance(&self) -> f64 {
        self.noise.first().copied().unwrap_or(0.0)
    }

    /// Loss over its expectation under a right model: 1 for a right model, larger by what the model does not explain; below 0
    /// only where the render's noise is larger than all else. 0 without observations.
    #[must_use]
    pub fn reduced_chi_square(&self) -> f64 {
        if self.noise_floor > 0.0 { self.loss() / self.noise_floor } else { 0.0 }
    }

    /// Standard error of [`PhotoStatistics::reduced_chi_square`] that is due to the render's noise.
    #[must_use]
    pub fn chi_square_error(&self) -> f64 {
        if self.noise_floor > 0.0 { libm::sqrt(self.loss_variance().max(0.0)) / self.noise_floor } else { 0.0 }
    }

    /// Adds another photo's sums to this one's, for totals. Noise of different photos is independent.
    pub fn add(&mut self, other: &Self) {
        add(&mut self.gram, &other.gram);
        add(&mut self.noise, &other.noise);
        if !other.draw.is_empty() {
            add(&mut self.draw, &other.draw);
        }
        self.observations += other.observations;
        self.compared += other.compared;
        self.noise_floor += other.noise_floor;
        self.render_noise += other.render_noise;
        self.squared_error += other.squared_error;
        self.log_variance += other.log_variance;
        self.peak = self.peak.max(other.peak);
        self.invalid_samples += other.invalid_samples;
    }
}

fn add(sums: &mut Vec<f64>, other: &[f64]) {
    if sums.is_empty() {
        sums.resize(other.len(), 0.0);
    }
    sums.iter_mut().zip(other).for_each(|(a, b)| *a += b);
}
