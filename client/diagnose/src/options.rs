//! How a diagnosis is to be done.

use crate::DiagnoseError;
use crate::Policy;
use crate::effects::{Effect, all};

/// Samples of all fitted photos' pixels in one evaluation, more or less at most.
const MOST_SAMPLES: u64 = 16_000_000;
/// Samples per pixel of the score pass' finite differences, at most: a column's noise is no error of its score, which only the
/// residual's is, but with 2 a lobe and a coat were missed in small captures.
pub(crate) const SCORE_DIFFERENCES: u32 = 4;
/// Samples per pixel of derivatives that are carried along the paths, at most, in the score pass and in the fits that are compared
/// with each other: there are a hundred of them, and what was said of the differences' noise holds of theirs.
pub(crate) const FORWARD: u32 = 16;
/// Samples per pixel of the score pass and of the fits that are compared with each other, at most. By 32, clipping that was hidden in five
/// photos of 64x48 pixels was lost in the render's noise (p = 0.13); by 64 it is found (test `clipping_is_found`).
const SEARCH_SAMPLES: u32 = 64;
/// Samples per pixel, however many pixels there are.
const FEWEST_SAMPLES: u32 = 8;

/// Options of [`crate::diagnose`].
#[derive(Debug, Clone)]
pub struct Options {
    /// Seed of every random number.
    pub seed: u64,
    /// Most samples per pixel of a fit's iterations, and of the score pass; even. Captures of more than a quarter of a million
    /// pixels take fewer, at least 8.
    pub samples: u32,
    /// Samples per pixel of finite differences in fits; even. The score pass, which has many more of them, takes at most 4.
    pub difference_samples: u32,
    /// What is accepted, and what it is called.
    pub policy: Policy,
    /// Effects that are left out of the catalogue.
    pub without: Vec<String>,
}

impl Default for Options {
    fn default() -> Self {
        Self { seed: 0, samples: 64, difference_samples: 8, policy: Policy::default(), without: Vec::new() }
    }
}

impl Options {
    /// The effects to consider.
    ///
    /// # Errors
    /// A name to leave out that is no effect's, a number out of range.
    pub(crate) fn effects(&self) -> Result<Vec<&'static Effect>, DiagnoseError> {
        let refuse = |option, value: String, mend| Err(DiagnoseError::Option { option, value, mend });
        if let Some(unknown) = self.without.iter().find(|n| !all().any(|e| e.name == **n)) {
            return refuse("without", unknown.clone(), "name effects of the catalogue");
        }
        if !(self.policy.smallest_gain > 0.0 && self.policy.smallest_gain < 1.0) {
            return refuse("smallest-gain", self.policy.smallest_gain.to_string(), "write a part between 0 and 1");
        }
        if !(self.policy.smallest_file_gain > 0.0 && self.policy.smallest_file_gain < 1.0) {
            return refuse(
                "smallest-file-gain",
                self.policy.smallest_file_gain.to_string(),
                "write a part between 0 and 1",
            );
        }
        if !(self.policy.false_alarms > 0.0 && self.policy.false_alarms < 0.5) {
            return refuse("false-alarms", self.policy.false_alarms.to_string(), "write a chance between 0 and 0.5");
        }
        if self.policy.most_effects == 0 {
            return refuse("most-effects", "0".to_owned(), "write at least 1");
        }
        Ok(all().filter(|e| !self.without.iter().any(|n| n == e.name)).collect())
    }

    /// The same with fewer samples where the photos to be fitted have so many pixels that these take over what more samples would
    /// do: a sum over ten times the pixels has a tenth of the variance. Up to a quarter of a million pixels stay as they are.
    pub(crate) fn shared_among(&self, pixels: u64) -> Self {
        let samples = (MOST_SAMPLES / pixels.max(1) / 2 * 2).max(u64::from(FEWEST_SAMPLES));
        Self { samples: u32::try_from(samples).map_or(self.samples, |s| s.min(self.samples)), ..self.clone() }
    }

    /// Samples per pixel of score passes and of the fits that are compared with each other.
    pub(crate) fn search_samples(&self) -> u32 {
        self.samples.min(SEARCH_SAMPLES)
    }

    /// How the base is fitted: from its first guesses.
    pub(crate) fn base_fit(&self) -> gonio_fit::Options {
        gonio_fit::Options {
            seed: self.seed,
            min_samples: self.samples.min(4),
            max_samples: self.samples,
            difference_samples: self.difference_samples.min(self.samples),
            ..gonio_fit::Options::default()
        }
    }

    /// How an extension is fitted, from near its optimum and only to be compared.
    pub(crate) fn refit(&self) -> gonio_fit::Options {
        let samples = self.search_samples();
        gonio_fit::Options {
            min_samples: samples.min(8),
            max_samples: samples,
            difference_samples: samples.min(4),
            forward_samples: samples.min(FORWARD),
            max_iterations: Some(10),
            ..self.base_fit()
        }
    }

    /// How the extended model is fitted in the end, from its own optimum at fewer samples. Where a place was `searched`, the
    /// search has come near its optimum, and every step is dear.
    pub(crate) fn last_fit(&self, searched: bool) -> gonio_fit::Options {
        gonio_fit::Options {
            min_samples: if searched { self.search_samples() } else { self.samples },
            difference_samples: self.search_samples().min(if searched { 4 } else { 8 }),
            forward_samples: self.search_samples(),
            max_iterations: Some(if searched { 5 } else { 12 }),
            tolerance: 0.1,
            ..self.base_fit()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_pixels_share_the_samples() {
        let of = |pixels| Options::default().shared_among(pixels).samples;
        assert_eq!([of(0), of(8 * 160 * 120), of(250_000)], [64; 3]);
        assert_eq!([of(9 * 512 * 340), of(u64::MAX)], [10, 8]);
        assert_eq!(Options { samples: 4, ..Options::default() }.shared_among(1 << 40).samples, 4);
    }
}
