//! Photographs that are noisier than their sensor is said to be: told apart from misfit, and taken into account.

use super::BASE;
use crate::evidence::{ChannelNoise, Evidence};
use crate::policy::Policy;

/// The noise of the photographs where it is larger than stated, by the base model's residuals.
#[must_use]
pub fn excess_noise(evidence: &Evidence, policy: &Policy) -> Option<[ChannelNoise; 3]> {
    let channels = evidence.remains(BASE)?.noise?;
    let noisier = |c: &ChannelNoise| {
        let (factor, error) = c.factor();
        factor - policy.noise_errors * error > policy.noisier
    };
    channels.iter().any(noisier).then_some(channels)
}

/// Chi-square per observation that the photographs' own noise comes to: 1 where the file states it rightly, or too high.
#[must_use]
pub fn noise_level(evidence: &Evidence, policy: &Policy) -> f64 {
    excess_noise(evidence, policy)
        .map_or(1.0, |channels| channels.iter().map(|c| c.variance.max(1.0)).sum::<f64>() / 3.0)
}
