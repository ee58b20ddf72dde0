//! Cross-validation without another render: every photo is predicted from a fit to the others, by the quadratic that the
//! per-photo normal equations make of chi-square near the estimate.

use crate::evidence::gather::quadratic::Quadratic;
use gonio_scene::PhotoStatistics;
use nalgebra::DVector;

/// Each photo's deviance, twice its negative log predictive density less what is the same for every model, under the model
/// fitted to the other photos: its loss ([`gonio_scene::statistics`]). `parameters` is how many columns the statistics
/// have; `of_photo` tells whether a column belongs to this photo alone, and so is fitted to it all the same.
#[must_use]
pub fn left_out(photos: &[PhotoStatistics], parameters: usize, of_photo: &dyn Fn(usize, usize) -> bool) -> Vec<f64> {
    let columns: Vec<(usize, f64)> = (0..parameters).map(|i| (i, 1.0)).collect();
    let each: Vec<Quadratic> = photos.iter().map(|p| Quadratic::new(p, &columns)).collect();
    let Some(total) = Quadratic::sum(&each) else { return Vec::new() };
    let step = |out: usize| -> DVector<f64> {
        let rest = Quadratic {
            gradient: &total.gradient - &each[out].gradient,
            matrix: &total.matrix - &each[out].matrix,
            noise: &total.noise - &each[out].noise,
        };
        let (own, shared): (Vec<usize>, Vec<usize>) = (0..parameters).partition(|i| of_photo(*i, out));
        let mut step = DVector::zeros(parameters);
        let common = rest.reminded_of(&total).select(&shared).solve();
        shared.iter().zip(&common).for_each(|(i, x)| step[*i] = *x);
        // Only this photo knows its own numbers: they are fitted to it, with the others where the rest puts them.
        let coupled = &each[out].gradient + &each[out].matrix * &step;
        let fitted = Quadratic { gradient: coupled, ..each[out].clone() }.select(&own).solve();
        own.iter().zip(&fitted).for_each(|(i, x)| step[*i] = *x);
        step
    };
    photos.iter().enumerate().map(|(out, p)| p.loss() + each[out].change(&step(out))).collect()
}

/// The sum of per-photo gains per observation, and its standard error from the photos' scatter.
#[must_use]
pub fn per_observation(gains: &[f64], observations: u64) -> (f64, f64) {
    let (n, sum) = (gains.len() as f64, gains.iter().sum::<f64>());
    let variance = gains.iter().map(|g| (g - sum / n).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
    let observations = (observations as f64).max(1.0);
    (sum / observations, (n * variance).sqrt() / observations)
}
