//! d' of one criterion, and its sampling distribution by Miller (1996).

use crate::normal::z;
use serde::Serialize;

/// Outcomes of a yes-no decision: how many of the synthetic and of the real images were called synthetic.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Detection {
    /// Synthetic images called synthetic.
    pub hits: u32,
    /// Synthetic images shown.
    pub synthetic: u32,
    /// Real images called synthetic.
    pub false_alarms: u32,
    /// Real images shown.
    pub real: u32,
}

impl Detection {
    /// d' = z(H) - z(F) (Green and Swets 1966), with the log-linear correction H = (hits + 1/2) / (synthetic + 1) of
    /// Hautus (1995), which keeps it finite where every answer is right.
    #[must_use]
    pub fn d_prime(&self) -> f64 {
        z(corrected(self.hits, self.synthetic)) - z(corrected(self.false_alarms, self.real))
    }

    /// The criterion c = -(z(H) + z(F)) / 2; above 0 the observer is slow to say "synthetic".
    #[must_use]
    pub fn criterion(&self) -> f64 {
        -0.5 * (z(corrected(self.hits, self.synthetic)) + z(corrected(self.false_alarms, self.real)))
    }

    /// Variance of [`Detection::d_prime`] for one observer: [`miller_variance`] at the corrected rates.
    #[must_use]
    pub fn variance(&self) -> f64 {
        let hit = corrected(self.hits, self.synthetic);
        let false_alarm = corrected(self.false_alarms, self.real);
        miller_variance(hit, self.synthetic) + miller_variance(false_alarm, self.real)
    }
}

/// The rate `count` of `trials`, never 0 or 1.
pub(crate) fn corrected(count: u32, trials: u32) -> f64 {
    (f64::from(count) + 0.5) / (f64::from(trials) + 1.0)
}

/// Variance of z of a corrected rate over the exact binomial distribution of its count, `trials` shown at the true rate
/// `p` in 0..1 (Miller 1996, "The sampling distribution of d'", Perception & Psychophysics 58, 65-72; there with rates of
/// 0 and 1 moved by half a count, here with the log-linear correction that [`Detection::d_prime`] uses).
///
/// For many trials it becomes p (1 - p) / (n phi(z(p))^2) (Gourevitch and Galanter 1967), which for few of them and
/// rates near 0 or 1 is far too large.
#[must_use]
pub fn miller_variance(p: f64, trials: u32) -> f64 {
    let (log_p, log_q) = (libm::log(p), libm::log1p(-p));
    let log_factorial = |n: u32| statrs::function::gamma::ln_gamma(f64::from(n) + 1.0);
    let (mut mean, mut square) = (0.0, 0.0);
    for k in 0..=trials {
        let log_choose = log_factorial(trials) - log_factorial(k) - log_factorial(trials - k);
        let weight = libm::exp(log_choose + f64::from(k) * log_p + f64::from(trials - k) * log_q);
        let value = z(corrected(k, trials));
        mean += weight * value;
        square += weight * value * value;
    }
    (square - mean * mean).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::normal::density;

    #[test]
    fn d_prime_is_the_closed_form() {
        // H = 0.84134, F = 0.15866 are one deviation above and below: d' = 2, c = 0.
        let d = Detection { hits: 84_134, synthetic: 100_000, false_alarms: 15_866, real: 100_000 };
        assert!((d.d_prime() - 2.0).abs() < 1e-4 && d.criterion().abs() < 1e-12);
        // All right out of 10: z(10.5 / 11) = 1.690622.
        let d = Detection { hits: 10, synthetic: 10, false_alarms: 0, real: 10 };
        assert!((d.d_prime() - 2.0 * 1.690_622).abs() < 1e-5, "{}", d.d_prime());
    }

    #[test]
    fn the_variance_of_many_trials_is_gourevitch_and_galanters() {
        for p in [0.2, 0.5, 0.84] {
            let closed = p * (1.0 - p) / (4000.0 * density(z(p)).powi(2));
            let exact = miller_variance(p, 4000);
            assert!((exact / closed - 1.0).abs() < 0.005, "{p}: {exact} {closed}");
        }
    }

    #[test]
    fn the_variance_of_two_trials_is_its_enumeration() {
        // Counts 0, 1, 2 have z of -z(5/6), 0, z(5/6); at p = 1/2 half the weight is at the ends.
        let end = z(2.5 / 3.0);
        assert!((miller_variance(0.5, 2) - 0.5 * end * end).abs() < 1e-12);
    }
}
