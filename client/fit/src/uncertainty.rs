//! Standard errors and correlations of an estimate.
//!
//! Two answers to "how far off may it be?", from the per-photo normal equations at the estimate, in physical units:
//!
//! - model: (J'WJ)^-1, right where the model is; scaled by reduced chi-square where that exceeds 1, as if what the
//!   model does not explain were more noise of the same kind, and widened for the render's noise, which a pixel's three
//!   channels share because they come from the same paths: its share s of the variance counts three times, 1 + 2 s;
//! - between photos: the sandwich (J'WJ)^-1 (sum over photos of g g') (J'WJ)^-1 with g = J'Wr of one photo (Huber 1967,
//!   White 1980; clustered: Liang and Zeger 1986), times K / (K - 1) for K photos. It also holds where residuals are
//!   alike within a photo, as those of a wrong light or pose are, which no number of pixels averages away. With few
//!   photos it is rough, and of a parameter that one photo alone determines it knows nothing.
//!
//! The reported standard error is the larger of the two: the model knows nothing of the heavy tails of caustics and of what
//! a photo has in common, the scatter of few photos may come out small by chance. The photos *disagree* where theirs is larger
//! by more than the scatter of so few explains: its square over the model's is about chi-square with K - 1 degrees of
//! freedom, over these.

use crate::Normal;
use crate::normal::{Spectrum, count};
use gonio_scene::PhotoStatistics;
use nalgebra::{DMatrix, DVector};

/// Standard normal quantile of the chance, 1e-4, to say that photos disagree when they do not.
const UNLIKELY: f64 = 3.72;

/// What the data say about the estimate's precision, in parameter order and physical units.
#[derive(Debug, Clone)]
pub(crate) struct Uncertainty {
    /// The one to report; infinite where the data say nothing.
    pub standard_errors: Vec<f64>,
    /// From (J'WJ)^-1, scaled.
    pub model: Vec<f64>,
    /// From the sandwich; absent with one photo.
    pub between_photos: Option<Vec<f64>>,
    /// Correlation matrix of (J'WJ)^-1; rows of a parameter that the data say nothing about are zero but for the 1.
    pub correlations: Vec<Vec<f64>>,
    /// The scaled normal equations, whose small eigenvalues are combinations that the data cannot tell apart.
    pub spectrum: Spectrum,
    /// How much larger the error between photos must be than the model's for them to disagree.
    ratio: f64,
}

impl Uncertainty {
    /// From the statistics of the fitted photos, with derivatives for `parameters` columns.
    pub fn new(photos: &[PhotoStatistics], parameters: usize) -> Self {
        let ones = vec![1.0; parameters];
        let normal = Normal::new(photos, &ones);
        let spectrum = normal.spectrum();
        let covariance = spectrum.covariance();
        let reduced_chi_square = reduced_chi_square(&normal.total, parameters);
        let known: Vec<bool> = spectrum.inverse_scale.iter().map(|s| *s > 0.0).collect();
        let root = |m: &DMatrix<f64>, factor: f64| -> Vec<f64> {
            let errors = m.diagonal().map(|v| (factor * v.max(0.0)).sqrt());
            errors.iter().zip(&known).map(|(e, k)| if *k { *e } else { f64::INFINITY }).collect()
        };
        let shared = 1.0 + 2.0 * normal.render_share();
        let model = root(&covariance, shared * reduced_chi_square.max(1.0));
        let between_photos = sandwich(photos, &covariance, parameters).map(|m| root(&m, 1.0));
        let standard_errors = match &between_photos {
            Some(wider) => model.iter().zip(wider).map(|(m, w)| m.max(*w)).collect(),
            None => model.clone(),
        };
        let ratio = disagreement(photos.len());
        Self { standard_errors, correlations: correlations(&covariance), model, between_photos, spectrum, ratio }
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
    total.chi_square / (count(total.observations) - count(parameters as u64)).max(1.0)
}

/// The covariance that the scatter of the photos' gradients implies.
fn sandwich(photos: &[PhotoStatistics], bread: &DMatrix<f64>, parameters: usize) -> Option<DMatrix<f64>> {
    if photos.len() < 2 {
        return None;
    }
    let photos_count = count(photos.len() as u64);
    let ones = vec![1.0; parameters];
    let gradients: Vec<DVector<f64>> =
        photos.iter().map(|p| Normal::new(std::slice::from_ref(p), &ones).gradient).collect();
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
            chi_square: 100.0,
            ..PhotoStatistics::default()
        }
    }

    #[test]
    fn the_mean_of_n_unit_observations_has_error_one_over_root_n() {
        let u = Uncertainty::new(&[photo(100, 0.0), photo(100, 0.0)], 1);
        assert!((u.model[0] - (1.0_f64 / 200.0).sqrt() * (200.0_f64 / 199.0).sqrt()).abs() < 1e-12);
        assert_eq!(u.standard_errors, u.model);
        assert!(!u.photos_disagree(0));
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
        let u = Uncertainty::new(&photos, 1);
        let scatter: f64 = offsets.iter().map(|o| o * o).sum::<f64>() / 3.0;
        assert!((u.standard_errors[0] - (scatter / 4.0).sqrt()).abs() < 1e-12);
        assert!(u.photos_disagree(0));
    }

    #[test]
    fn a_parameter_that_nothing_depends_on_has_infinite_error() {
        let gram = vec![1.0, 0.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 0.0];
        let photo = PhotoStatistics { observations: 10, gram, chi_square: 10.0, ..PhotoStatistics::default() };
        let u = Uncertainty::new(&[photo], 2);
        assert!(u.standard_errors[0].is_finite() && u.standard_errors[1].is_infinite());
        assert_eq!(u.correlations, [[1.0, 0.0], [0.0, 1.0]]);
        assert!(u.between_photos.is_none());
    }
}
