//! The strength at which an effect is found half of the time.
//!
//! The share that is found is taken as a logistic function of the strength's logarithm, whose slope is given: a few trials
//! tell where it is, not how steep.

/// Slope of the logistic function per unit of the strength's natural logarithm: from a tenth found to nine tenths in a factor
/// of 3. A gain goes by the square of the strength, and differs by a factor of about 2 between captures.
const SLOPE: f64 = 4.0;
/// Logarithm of the likelihood's ratio at the ends of an interval that holds the truth in 68 of 100 cases: half of the 0.68
/// quantile of chi-square with one degree of freedom.
const FALL: f64 = 0.4945;

/// One diagnosis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial {
    pub strength: f64,
    pub found: bool,
}

/// What the trials say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Threshold {
    /// Always found, at this strength the weakest time.
    Below(f64),
    /// Never found, at this strength the strongest time.
    Above(f64),
    /// By maximum likelihood, with a profile likelihood's interval of 68 %.
    At { half: f64, low: f64, high: f64 },
}

impl Threshold {
    /// The estimate, or the bound.
    pub fn strength(self) -> f64 {
        match self {
            Self::Below(strength) | Self::Above(strength) | Self::At { half: strength, .. } => strength,
        }
    }
}

/// The threshold by all trials of an effect; `None` without any.
pub fn threshold(trials: &[Trial]) -> Option<Threshold> {
    let least = trials.iter().map(|t| t.strength).reduce(f64::min)?;
    let most = trials.iter().map(|t| t.strength).reduce(f64::max)?;
    let found = trials.iter().filter(|t| t.found).count();
    if found == trials.len() {
        return Some(Threshold::Below(least));
    }
    if found == 0 {
        return Some(Threshold::Above(most));
    }
    // The likelihood has one maximum, where as many are expected to be found as were; at both ends it is nothing.
    let reach = 40.0 / SLOPE;
    let (left, right) = (libm::log(least) - reach, libm::log(most) + reach);
    let expected = |half: f64| trials.iter().map(|t| share(t, half)).sum::<f64>();
    let best = falls(left, right, |half| expected(half) - found as f64);
    let floor = likelihood(trials, best) - FALL;
    let low = falls(left, best, |half| floor - likelihood(trials, half));
    let high = falls(best, right, |half| likelihood(trials, half) - floor);
    Some(Threshold::At { half: libm::exp(best), low: libm::exp(low), high: libm::exp(high) })
}

/// The share that is found at a trial's strength, if half is at a strength of this logarithm.
fn share(trial: &Trial, half: f64) -> f64 {
    1.0 / (1.0 + libm::exp(SLOPE * (half - libm::log(trial.strength))))
}

/// Logarithm of the likelihood.
fn likelihood(trials: &[Trial], half: f64) -> f64 {
    let of = |t: &Trial| {
        let sign = if t.found { 1.0 } else { -1.0 };
        -libm::log1p(libm::exp(sign * SLOPE * (half - libm::log(t.strength))))
    };
    trials.iter().map(of).sum()
}

/// Where a function that falls from left to right is zero.
fn falls(mut left: f64, mut right: f64, f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (left + right);
        if f(middle) > 0.0 {
            left = middle;
        } else {
            right = middle;
        }
    }
    0.5 * (left + right)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trials(all: &[(f64, bool)]) -> Vec<Trial> {
        all.iter().map(|&(strength, found)| Trial { strength, found }).collect()
    }

    #[test]
    fn one_sided_trials_give_a_bound() {
        assert_eq!(threshold(&[]), None);
        assert_eq!(threshold(&trials(&[(1.0, true), (0.35, true)])), Some(Threshold::Below(0.35)));
        assert_eq!(threshold(&trials(&[(1.0, false), (4.0, false)])), Some(Threshold::Above(4.0)));
    }

    #[test]
    fn a_find_and_a_miss_meet_in_the_middle() {
        let Some(Threshold::At { half, low, high }) = threshold(&trials(&[(1.0, true), (0.25, false)])) else {
            panic!()
        };
        assert!((half - 0.5).abs() < 1e-9);
        // By symmetry, and where the likelihood has fallen as far as it should.
        assert!((low * high - 0.25).abs() < 1e-9 && low < half);
        let log = |l: f64| -libm::log(1.0 + libm::pow(l, SLOPE)) - libm::log(1.0 + libm::pow(0.25 / l, SLOPE));
        assert!((log(half) - log(low) - FALL).abs() < 1e-9);
        assert!((log(half) - log(high) - FALL).abs() < 1e-9);
    }

    #[test]
    fn shares_give_their_strength_back() {
        // At one strength, three of four: the logistic function's odds are 3 there.
        let all = trials(&[(0.2, true), (0.2, true), (0.2, true), (0.2, false)]);
        let Some(Threshold::At { half, low, high }) = threshold(&all) else { panic!() };
        assert!((half - 0.2 / libm::pow(3.0, 1.0 / SLOPE)).abs() < 1e-9);
        // More of the same: a narrower interval about the same place.
        let more: Vec<Trial> = std::iter::repeat_n(all, 100).flatten().collect();
        let Some(Threshold::At { half: again, low: l, high: h }) = threshold(&more) else { panic!() };
        assert!((again - half).abs() < 1e-9);
        // The normal approximation, which many trials make good.
        let error = 1.0 / (SLOPE * (400.0f64 * 0.75 * 0.25).sqrt());
        assert!((libm::log(h / l) / (2.0 * error) - 1.0).abs() < 0.02);
        assert!(h / l < high / low);
    }
}
