//! Standard errors and correlations of an estimate.
//!
//! Two answers to "how far off may it be?", from the per-photo normal equations at the estimate. H = J'WJ is of the photos' own
//! noise, N the covariance of J'Wr that the render's noise makes ([`gonio_scene::PhotoStatistics::noise`]):
//!
//! - model: H^-1 (c (H + D) + N) H^-1, right where the model is; c is reduced chi-square where that exceeds 1, as if what the
//!   model does not explain were more noise of the same kind; D is what drawing pixels instead of comparing all adds
//!   ([`gonio_scene::PhotoStatistics::draw`]);
//! - between photos: the sandwich H^-1 (sum over photos of g g') H^-1 with g = J'Wr of one photo (Huber 1967,
//!   White 1980; clustered: Liang and Zeger 1986), times K / (K - 1) for K photos. It also holds where residuals are
//!   alike within a photo, as those of a wrong light or pose are, which no number of pixels averages away. With few
//!   photos it is rough, and of a parameter that one photo alone determines it knows nothing.
//!
//! The reported standard error is the larger of the two: the model knows nothing of what a photo has in common, the scatter of
//! few photos may come out small by chance. The photos *disagree* where theirs is larger by more than the scatter of so few
//! explains: its square over the model's is about chi-square with K - 1 degrees of freedom, over these.

use crate::Normal;
use crate::normal::{Spectrum, count};
use gonio_scene::PhotoStatistics;
use nalgebra::{DMatrix, DVector};

/// Standard normal quantile of the chance, 1e-4, to say that photos disagree when they do not.
const UNLIKELY: f64 = 3.72;

/// What the data say about the estimate's precision, in parameter order and the units of the normal equations.
#[derive(Debug, Clone)]
pub(crate) struct Uncertainty {
    /// The one to report; infinite where the data say nothing.
    pub standard_errors: Vec<f64>,
    /// From the model's own normal equations.
    pub model: Vec<f64>,
    /// From the sandwich; absent with one photo.
    pub between_photos: Option<Vec<f64>>,
    /// Correlation matrix of (J'WJ)^-1; rows of a parameter that the data say nothing about are zero but for the 1.
    pub correlations: Vec<Vec<f64>>,
    /// The scaled normal equations, whose small eigenvalues are combinations that the data cannot tell apart.
    pub spectrum: Spectrum,
    /// The part of each reported variance that is the render's noise, 0 to 1; 0 where the data say nothing.
    pub render_shares: Vec<f64>,
    /// How much larger the error between photos must be than the model's for them to disagree.
    ratio: f64,
}

impl Uncertainty {
    /// From the statistics of the fitted photos, with derivatives by as many columns as there are `slopes`: d value / d unit
    /// of the answer, all ones for physical units.
    pub fn new(photos: &[PhotoStatistics], slopes: &[f64]) -> Self {
        let normal = Normal::new(photos, slopes);
        let spectrum = normal.spectrum();
        let covariance = spectrum.covariance();
        let misfit = reduced_chi_square(&normal.total, slopes.len()).max(1.0);
        let render = &covariance * &normal.noise * &covariance;
        let known: Vec<bool> = spectrum.inverse_scale.iter().map(|s| *s > 0.0).collect();
        let root = |m: &DMatrix<f64>| -> Vec<f64> {
            let errors = m.diagonal().map(|v| v.max(0.0).sqrt());
            errors.iter().zip(&known).map(|(e, k)| if *k { *e } else { f64::INFINITY }).collect()
        };
        let drawn = &covariance * &normal.draw * &covariance;
        let model = root(&((&covariance + drawn) * misfit + &render));
        let between_photos = sandwich(photos, &covariance, slopes).map(|m| root(&m));
        let standard_errors: Vec<f64> = match &between_photos {
            Some(wider) => model.iter().zip(wider).map(|(m, w)| m.max(*w)).collect(),
            None => model.clone(),
        };
        let share =
            |(i, error): (usize, &f64)| if *error > 0.0 { render[(i, i)].max(0.0) / (error * error) } else { 0.0 };
        let render_shares = standard_errors.iter().enumerate().map(share).map(|s: f64| s.min(1.0)).collect();
        let (ratio, correlations) = (disagreement(photos.len()), correlations(&covariance));
        Self { standard_errors, model, between_photos, correlations, spectrum, render_shares, ratio }
    }

    /// The longest of a move's parts, each in its own reported standard error; what the data say nothing about has no part.
    pub fn longest(&self, step: &[f64]) -> f64 {
        step.iter()
            .zip(&self.standard_errors)
            .map(|(s, e)| if *e > 0.0 { s.abs() / e } else { 0.0 })
            .fold(0.0, f64::max)
    }

    /// The render's part in the reported variances, in the mean over the parameters that the data say something about.
    pub fn render_share(&self) -> f64 {
        let known = self.standard_errors.iter().filter(|e| e.is_finite()).count().max(1);
        self.render_shares.iter().sum::<f64>() / count(known as u64)
    }

    /// Whether the photos disagree about parameter `i` by more than noise explains.
    pub fn photos_disagree(&self, i: usize) -> bool {
        matches!((self.standard_errors.get(i), self.model.get(i)), (Some(s), Some(m)) if *s > self.ratio * m)
    }
}

/// The ratio of the two standard errors from which on `photos` photos disagree, by Wilson and Hilferty's (1931)
/// approximation of the chi-square quantile.
fn disagreement(photos: usize) -> f64 {
    let spread = 2.0 / (9.0 * (count(photos as u64) - 1.0).max(1.0));
    let root = 1.0 - spread + UNLIKELY * spread.sqrt();
    (root * root * root).sqrt()
}

/// Chi-square per degree of freedom.
pub(crate) fn reduced_chi_square(total: &PhotoStatistics, parameters: usize) -> f64 {
    let observations = count(total.observations);
    total.reduced_chi_square() * observations / (observations - count(parameters as u64)).max(1.0)
}

/// The covariance that the scatter of the photos' gradients implies.
fn sandwich(photos: &[PhotoStatistics], bread: &DMatrix<f64>, slopes: &[f64]) -> Option<DMatrix<f64>> {
    if photos.len() < 2 {
        return None;
    }
    let photos_count = count(photos.len() as u64);
    let parameters = slopes.len();
    let gradients: Vec<DVector<f64>> =
        photos.iter().map(|p| Normal::new(std::slice::from_ref(p), slopes).gradient).collect();
    // At the estimate they add up to zero but for the step that is left.
    let mean = gradients.iter().fold(DVector::zeros(parameters), |sum, g| sum + g) / photos_count;
    let mut meat = DMatrix::zeros(parameters, parameters);
    for gradient in &gradients {
        let own = gradient - &mean;
        meat += &own * own.transpose();
    }
    Some(bread * meat * bread * (photos_count / (photos_count - 1.0)))
}

fn correlations(covariance: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let n = covariance.nrows();
    let entry = |i: usize, j: usize| {
        let scale = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
        if i == j {
            1.0
        } else if scale > 0.0 {
            (covariance[(i, j)] / scale).clamp(-1.0, 1.0)
        } else {
            0.0
        }
    };
    (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One photo of a constant `level` seen through `n` observations of unit variance, off by `offset` in all of them.
    fn photo(n: u32, offset: f64) -> PhotoStatistics {
        let n = f64::from(n);
        PhotoStatistics {
            observations: 100,
            gram: vec![n * (1.0 + offset * offset), n * offset, n * offset, n],
            noise_floor: 100.0,
            ..PhotoStatistics::default()
        }
    }

    #[test]
    fn the_mean_of_n_unit_observations_has_error_one_over_root_n() {
        let u = Uncertainty::new(&[photo(100, 0.0), photo(100, 0.0)], &[1.0]);
        assert!((u.model[0] - (1.0_f64 / 200.0).sqrt() * (200.0_f64 / 199.0).sqrt()).abs() < 1e-12);
        assert_eq!(u.standard_errors, u.model);
        assert!(!u.photos_disagree(0));
        assert_eq!(u.render_share(), 0.0);
    }

    #[test]
    fn pixels_that_stand_for_many_are_as_many_as_they_are() {
        // A hundred pixels that stand for nine each: H is 900, the gradient's covariance 81 x 100, as for 100 pixels.
        let draw = vec![0.0, 0.0, 0.0, 8100.0 - 900.0];
        let drawn = PhotoStatistics { draw, observations: 900, noise_floor: 900.0, ..photo(900, 0.0) };
        let u = Uncertainty::new(&[drawn], &[1.0]);
        assert!((u.model[0] / 0.1 - (900.0_f64 / 899.0).sqrt()).abs() < 1e-12, "{}", u.model[0]);
    }

    #[test]
    fn the_renders_noise_widens_the_error_and_tells_its_share() {
        let noisy = PhotoStatistics { noise: vec![0.0, 0.0, 0.0, 300.0], ..photo(100, 0.0) };
        let (quiet, noisy) = (Uncertainty::new(&[photo(100, 0.0)], &[1.0]), Uncertainty::new(&[noisy], &[1.0]));
        // 300 of the render beside 100 of the photo's own, times 100/99 for the parameter that was fitted.
        let own: f64 = 100.0 * 100.0 / 99.0;
        assert!((noisy.model[0] / quiet.model[0] - ((own + 300.0) / own).sqrt()).abs() < 1e-12);
        assert!((noisy.render_share() - 300.0 / (300.0 + own)).abs() < 1e-12);
    }

    #[test]
    fn few_photos_must_disagree_more() {
        // Chi-square quantiles at 1 - 1e-4: 15.1 for 1 degree of freedom, 23.5 for 4, 68.6 for 29 (tables).
        for (photos, quantile) in [(2, 15.1), (5, 23.5 / 4.0), (30, 68.6 / 29.0)] {
            let ratio = disagreement(photos);
            assert!((ratio * ratio / quantile - 1.0_f64).abs() < 0.08, "{photos}: {ratio}");
        }
    }

    #[test]
    fn photos_that_disagree_widen_the_error_to_the_scatter_of_their_means() {
        let offsets = [0.8, -0.6, 0.5, -0.7];
        let photos: Vec<_> = offsets.iter().map(|o| photo(100, *o)).collect();
        let u = Uncertainty::new(&photos, &[1.0]);
        let scatter: f64 = offsets.iter().map(|o| o * o).sum::<f64>() / 3.0;
        assert!((u.standard_errors[0] - (scatter / 4.0).sqrt()).abs() < 1e-12);
        assert!(u.photos_disagree(0));
    }

    #[test]
    fn a_parameter_that_nothing_depends_on_has_infinite_error() {
        let gram = vec![1.0, 0.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 0.0];
        let photo = PhotoStatistics { observations: 10, gram, noise_floor: 10.0, ..PhotoStatistics::default() };
        let u = Uncertainty::new(&[photo], &[1.0; 2]);
        assert!(u.standard_errors[0].is_finite() && u.standard_errors[1].is_infinite());
        assert_eq!(u.correlations, [[1.0, 0.0], [0.0, 1.0]]);
        assert!(u.between_photos.is_none());
    }
}
