//! Another synthetic set: without an effect, or with the first guess in place of the fit.

use super::bootstrap::Bootstrap;
use super::series::{self, Row};
use super::{Interval, Options, Point, Series};
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
    /// Part of the thresholds at which it lies in the band about the real curve.
    pub inside_share: f64,
}

impl Contrast {
    /// Over the images that all three sets have; `None` where there is none.
    pub(super) fn new(
        name: &str,
        real: &Series,
        synthetic: &Series,
        other: &Series,
        band: &[Point],
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
        let curve = series::curve(&others);
        let inside = band.iter().zip(&curve).filter(|(point, recall)| point.holds(**recall)).count();
        Some(Self {
            name: name.to_owned(),
            recall: bootstrap.interval(|weights| average(&others, weights)),
            change: bootstrap.interval(|weights| average(&others, weights) - average(&synthetics, weights)),
            gap: bootstrap.interval(|weights| average(&others, weights) - average(&reals, weights)),
            curve,
            #[allow(clippy::cast_precision_loss)] // tens
            inside_share: inside as f64 / band.len().max(1) as f64,
        })
    }
}
