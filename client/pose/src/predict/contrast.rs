//! Another synthetic set: without an effect, or with the first guess in place of the fit.

use super::bootstrap::{Bootstrap, quantile};
use super::series::{self, Row};
use super::{Interval, LEVEL, Options, Series};
use serde::Serialize;

/// How another synthetic set predicts, and what it changes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Contrast {
    /// Its name.
    pub name: String,
    /// Average recall on it.
    pub recall: Interval,
    /// Its recall less that of the synthetic set, image by image.
    pub change: Interval,
    /// Its recall less that of the real set.
    pub gap: Interval,
    /// Recall at each threshold.
    pub curve: Vec<f64>,
    /// Whether its curve lies in the simultaneous band about the real one.
    pub inside: bool,
}

impl Contrast {
    /// Over the images that all three sets have; `None` where there is none.
    pub(super) fn new(
        name: &str,
        real: &Series,
        synthetic: &Series,
        other: &Series,
        options: &Options,
    ) -> Option<Self> {
        let rows: Vec<[&Row; 3]> = real
            .rows()
            .iter()
            .filter_map(|(image, row)| Some([row, synthetic.rows().get(image)?, other.rows().get(image)?]))
            .collect();
        if rows.is_empty() {
            return None;
        }
        let column = |i: usize| rows.iter().map(|row| row[i]).collect::<Vec<&Row>>();
        let [reals, synthetics, others] = [column(0), column(1), column(2)];
        let bootstrap = Bootstrap::new(rows.len(), options.resamples, options.seed);
        let average = |rows: &[&Row], weights: &[u32]| series::average(&series::weighted(rows, weights));
        let differences = |weights: &[u32]| -> Vec<f64> {
            let (a, b) = (series::weighted(&others, weights), series::weighted(&reals, weights));
            a.iter().zip(&b).map(|(a, b)| a - b).collect()
        };
        let difference = differences(&vec![1; rows.len()]);
        let mut largest = bootstrap.map(|weights| {
            differences(weights).iter().zip(&difference).map(|(s, d)| (s - d).abs()).fold(0.0, f64::max)
        });
        let half_width = quantile(&mut largest, LEVEL);
        Some(Self {
            name: name.to_owned(),
            recall: bootstrap.interval(|weights| average(&others, weights)),
            change: bootstrap.interval(|weights| average(&others, weights) - average(&synthetics, weights)),
            gap: bootstrap.interval(|weights| average(&others, weights) - average(&reals, weights)),
            curve: series::curve(&others),
            inside: difference.iter().all(|d| d.abs() <= half_width + 1e-9),
        })
    }
}
