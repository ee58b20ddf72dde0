//! Whether synthetic images tell how an estimator does on real ones: the same poses in both, image by image.

mod agreement;
mod bootstrap;
mod contrast;
mod series;

pub use agreement::{Agreement, kendall};
pub use contrast::Contrast;
pub use series::{Series, THRESHOLDS};

use bootstrap::{Bootstrap, quantile};
use serde::Serialize;
use series::Row;

/// Level of the intervals.
const LEVEL: f64 = 0.95;

/// How a prediction is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Largest difference of two average recalls that does not matter.
    pub margin: f64,
    /// Resamples of the bootstrap.
    pub resamples: u32,
    /// Seed of its random numbers.
    pub seed: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self { margin: 0.05, resamples: 4000, seed: 0 }
    }
}

/// A value with its bootstrap interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Interval {
    /// Of the images as they are.
    pub value: f64,
    /// Lower end, 95 %.
    pub low: f64,
    /// Upper end, 95 %.
    pub high: f64,
}

/// Recall at one threshold.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Point {
    /// MSSD as a part of the diameter.
    pub threshold: f64,
    /// Recall on the real images, 0 to 1.
    pub real: f64,
    /// Recall on the synthetic ones.
    pub synthetic: f64,
    /// Where a synthetic set that predicts perfectly would lie in 95 % of all samples of images, at this threshold alone.
    pub band: [f64; 2],
}

impl Point {
    /// Whether a recall lies in the band.
    fn holds(&self, recall: f64) -> bool {
        // Recalls are multiples of one over the images: a rounding error is no difference.
        recall >= self.band[0] - 1e-9 && recall <= self.band[1] + 1e-9
    }
}

/// How well one set predicts another.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Prediction {
    /// Images that both sets have.
    pub images: usize,
    /// Images that only one of the sets has; they count for nothing.
    pub unpaired: usize,
    /// Average recall of MSSD (thresholds 0.05 to 0.5 of the diameter) on the real images.
    pub real: Interval,
    /// The same on the synthetic ones.
    pub synthetic: Interval,
    /// Synthetic less real, image by image (paired).
    pub gap: Interval,
    /// Largest gap that does not matter.
    pub margin: f64,
    /// Whether the gap's 90 % interval lies within the margin: two one-sided tests at 5 % (Schuirmann 1987).
    pub equivalent: bool,
    /// The curves.
    pub curve: Vec<Point>,
    /// Half width of the band in which the whole synthetic curve would lie in 95 % of all samples.
    pub simultaneous_half_width: f64,
    /// Whether it does.
    pub inside: bool,
    /// Part of the thresholds at which it lies in the band for that threshold alone.
    pub inside_share: f64,
    /// Image by image.
    pub agreement: Agreement,
    /// Other synthetic sets, the one that changes most first.
    pub contrasts: Vec<Contrast>,
    /// Rank agreement over settings; absent with fewer than two.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub settings: Option<Settings>,
}

/// Average recalls under several settings of an estimator or conditions of light, on both sets.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Settings {
    /// Name, average recall on the real images, on the synthetic ones.
    pub list: Vec<(String, f64, f64)>,
    /// Kendall's tau-b of the two orders: 1 where the synthetic images rank the settings as the real ones do. Absent where one of them
    /// has no order.
    pub kendall: Option<f64>,
}

/// Compares `synthetic` with `real`. Each of `contrasts` is another synthetic set of the same images; each of `settings` the
/// recalls of the two sets under another setting. `None` where no image is in both sets.
#[must_use]
pub fn predict(
    real: &Series,
    synthetic: &Series,
    contrasts: &[(String, Series)],
    settings: &[(String, Series, Series)],
    options: &Options,
) -> Option<Prediction> {
    let (pairs, unpaired) = real.paired(synthetic);
    if pairs.is_empty() {
        return None;
    }
    let (reals, synthetics): (Vec<&Row>, Vec<&Row>) = pairs.into_iter().unzip();
    let bootstrap = Bootstrap::new(reals.len(), options.resamples, options.seed);
    let (real_curve, synthetic_curve) = (series::curve(&reals), series::curve(&synthetics));
    let difference: Vec<f64> = synthetic_curve.iter().zip(&real_curve).map(|(s, r)| s - r).collect();
    let resampled: Vec<Vec<f64>> = bootstrap.map(|weights| {
        let (real, synthetic) = (series::weighted(&reals, weights), series::weighted(&synthetics, weights));
        synthetic.iter().zip(&real).map(|(s, r)| s - r).collect()
    });
    // What the differences would be if the sets were alike: as they scatter about their own.
    let mut largest: Vec<f64> = resampled
        .iter()
        .map(|sample| sample.iter().zip(&difference).map(|(s, d)| (s - d).abs()).fold(0.0, f64::max))
        .collect();
    let half_width = quantile(&mut largest, LEVEL);
    let curve: Vec<Point> = (0..THRESHOLDS.len())
        .map(|i| {
            let mut scatter: Vec<f64> = resampled.iter().map(|sample| sample[i] - difference[i]).collect();
            let low = quantile(&mut scatter, (1.0 - LEVEL) / 2.0);
            let high = quantile(&mut scatter, (1.0 + LEVEL) / 2.0);
            let real = real_curve[i];
            Point {
                threshold: THRESHOLDS[i],
                real,
                synthetic: synthetic_curve[i],
                band: [(real + low).clamp(0.0, 1.0), (real + high).clamp(0.0, 1.0)],
            }
        })
        .collect();
    #[allow(clippy::cast_precision_loss)]
    let inside_share = curve.iter().filter(|point| point.holds(point.synthetic)).count() as f64 / curve.len() as f64;
    let average = |rows: &[&Row], weights: &[u32]| series::average(&series::weighted(rows, weights));
    let gap_of = |weights: &[u32]| average(&synthetics, weights) - average(&reals, weights);
    let mut gaps = bootstrap.map(gap_of);
    let equivalent = quantile(&mut gaps, 0.05) > -options.margin && quantile(&mut gaps, 0.95) < options.margin;
    let mut contrasts: Vec<Contrast> = contrasts
        .iter()
        .filter_map(|(name, series)| Contrast::new(name, real, synthetic, series, &curve, options))
        .collect();
    contrasts.sort_by(|a, b| b.change.value.abs().total_cmp(&a.change.value.abs()));
    Some(Prediction {
        images: reals.len(),
        unpaired,
        real: bootstrap.interval(|weights| average(&reals, weights)),
        synthetic: bootstrap.interval(|weights| average(&synthetics, weights)),
        gap: bootstrap.interval(gap_of),
        margin: options.margin,
        equivalent,
        inside: difference.iter().all(|d| d.abs() <= half_width + 1e-9),
        curve,
        simultaneous_half_width: half_width,
        inside_share,
        agreement: Agreement::new(&reals, &synthetics),
        contrasts,
        settings: Settings::new(settings),
    })
}

impl Settings {
    fn new(settings: &[(String, Series, Series)]) -> Option<Self> {
        if settings.len() < 2 {
            return None;
        }
        let list: Vec<(String, f64, f64)> = settings
            .iter()
            .map(|(name, real, synthetic)| (name.clone(), real.average(), synthetic.average()))
            .collect();
        let (reals, synthetics): (Vec<f64>, Vec<f64>) =
            list.iter().map(|(_, real, synthetic)| (*real, *synthetic)).unzip();
        let kendall = kendall(&reals, &synthetics);
        Some(Self { list, kendall })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::{RngCore, SeedableRng};

    /// `count` images whose error is uniform in 0 to `spread`, by a common part of weight `common` and one of its own.
    fn two(count: u32, spreads: [f64; 2], common: f64, seed: u64) -> [Series; 2] {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut unit = || (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        let mut errors = [Vec::new(), Vec::new()];
        for image in 0..count {
            let shared = unit();
            for (list, spread) in errors.iter_mut().zip(spreads) {
                let own = unit();
                list.push(((1, image), spread * if unit() < common { shared } else { own }));
            }
        }
        errors.map(|list| Series::of_errors(&list))
    }

    #[test]
    fn sets_that_are_alike_are_told_apart_as_rarely_as_stated() {
        // Both bands at 95 %: of 200 pairs of sets 10 lie outside on average; more than 20 has a probability of 0.1 %.
        let options = Options { resamples: 400, ..Options::default() };
        let (mut outside, mut gaps) = (0, 0);
        for seed in 0..200 {
            let [real, synthetic] = two(60, [0.4, 0.4], 0.5, seed);
            let found = predict(&real, &synthetic, &[], &[], &options).unwrap();
            outside += u32::from(!found.inside);
            gaps += u32::from(found.gap.low > 0.0 || found.gap.high < 0.0);
        }
        assert!(outside <= 20 && gaps <= 20, "{outside} {gaps}");
    }

    #[test]
    fn a_set_on_which_the_estimator_does_better_is_found_out() {
        let [real, synthetic] = two(60, [0.5, 0.25], 0.5, 1);
        let found = predict(&real, &synthetic, &[], &[], &Options::default()).unwrap();
        assert!(!found.inside && !found.equivalent && found.gap.low > 0.05, "{:?}", found.gap);
        // Twice the error at every threshold: the mean recall rises by an eighth and more.
        assert!(found.synthetic.value > found.real.value + 0.1);
    }

    #[test]
    fn a_set_is_equivalent_to_itself() {
        let [real, _] = two(40, [0.4, 0.4], 0.5, 3);
        let found = predict(&real, &real, &[("same".to_owned(), real.clone())], &[], &Options::default()).unwrap();
        assert!(found.inside && found.equivalent && found.inside_share == 1.0);
        assert_eq!((found.gap.value, found.gap.low, found.gap.high), (0.0, 0.0, 0.0));
        assert_eq!(found.agreement.spearman, Some(1.0));
        assert_eq!(found.contrasts[0].change.value, 0.0);
    }

    #[test]
    fn sets_without_a_common_image_say_nothing() {
        let [a, _] = two(4, [0.4, 0.4], 0.5, 3);
        let b = Series::of_errors(&[((2, 0), 0.1)]);
        assert!(predict(&a, &b, &[], &[], &Options::default()).is_none());
    }

    #[test]
    fn contrasts_come_by_how_much_they_change() {
        let [real, synthetic] = two(50, [0.4, 0.4], 0.9, 5);
        let [bad, _] = two(50, [2.0, 2.0], 0.9, 5);
        let [mild, _] = two(50, [0.5, 0.5], 0.9, 5);
        let list = [("mild".to_owned(), mild), ("bad".to_owned(), bad)];
        let found = predict(&real, &synthetic, &list, &[], &Options::default()).unwrap();
        let names: Vec<&str> = found.contrasts.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["bad", "mild"]);
        assert!(found.contrasts[0].change.high < -0.2);
        assert!(found.contrasts[0].inside_share < 0.2);
    }
}
