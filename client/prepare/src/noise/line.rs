//! A line of variance over mean.

use super::level::Level;

/// Variance = `read`^2 + `shot` * mean.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Line {
    /// Standard deviation without light.
    pub read: f64,
    /// Variance per value.
    pub shot: f64,
    /// Standard errors of `read` and `shot`.
    pub errors: [f64; 2],
}

/// Rounds of weights that follow from the line of the round before; they settle within five.
const ROUNDS: usize = 12;
/// A level further than this many of its standard deviations from the line is left out: flat tiles that are not flat.
const FAR: f64 = 5.0;

impl Line {
    /// The variance at a mean.
    #[must_use]
    pub fn variance(&self, mean: f64) -> f64 {
        self.read * self.read + self.shot * mean.max(0.0)
    }

    /// The line of least squares through levels, each weighted by what its own spread is (a variance of f degrees of freedom
    /// has the relative variance 2 / f). Neither number is below 0. `None` where the levels do not determine a line.
    #[must_use]
    pub fn through(levels: &[Level], variance: impl Fn(&Level) -> f64) -> Option<Self> {
        let total: f64 = levels.iter().map(|level| level.freedom).sum();
        let mean = levels.iter().map(|level| level.freedom * variance(level)).sum::<f64>() / total;
        if !(levels.len() >= 3 && mean.is_finite() && mean > 0.0) {
            return None;
        }
        let mut line = [mean, 0.0];
        let mut found = None;
        for round in 0..ROUNDS {
            let predicted = |level: &Level| (line[0] + line[1] * level.mean).max(0.02 * mean);
            // How much wider the levels scatter than independent pixels would: robust, since some lie far off.
            let mut off: Vec<f64> =
                levels.iter().map(|level| standardised(level, &variance, predicted(level)).abs()).collect();
            off.sort_by(f64::total_cmp);
            let wide = (off[off.len() / 2] / 0.6745).max(1.0);
            let mut sums = [0.0; 5];
            let mut chi = [0.0, 0.0];
            for level in levels {
                let v = predicted(level);
                let distance = standardised(level, &variance, v) / wide;
                if round > 1 && distance.abs() > FAR {
                    continue;
                }
                let w = level.freedom / (2.0 * v * v);
                let (x, y) = (level.mean, variance(level));
                for (sum, term) in sums.iter_mut().zip([w, w * x, w * x * x, w * y, w * x * y]) {
                    *sum += term;
                }
                chi[0] += (distance * wide) * (distance * wide);
                chi[1] += 1.0;
            }
            let [n, x, xx, y, xy] = sums;
            let determinant = n * xx - x * x;
            if determinant.is_nan() || determinant <= 1e-9 * n * xx {
                return None;
            }
            let (mut a, mut b) = ((xx * y - x * xy) / determinant, (n * xy - x * y) / determinant);
            if a < 0.0 {
                (a, b) = (0.0, xy / xx);
            }
            if b < 0.0 {
                (a, b) = (y / n, 0.0);
            }
            line = [a.max(0.0), b.max(0.0)];
            let scatter = (chi[0] / (chi[1] - 2.0).max(1.0)).max(1.0);
            let errors = [(scatter * xx / determinant).sqrt(), (scatter * n / determinant).sqrt()];
            found = Some((line, errors));
        }
        let ([a, b], [error, shot_error]) = found?;
        let read = a.sqrt();
        // d read = d read^2 / (2 read); at 0 that is no error but the largest read noise that the error allows.
        let read_error = if read * read > error { error / (2.0 * read) } else { error.sqrt() };
        Some(Self { read, shot: b, errors: [read_error, shot_error] })
    }
}

fn standardised(level: &Level, variance: &impl Fn(&Level) -> f64, predicted: f64) -> f64 {
    (variance(level) - predicted) * (level.freedom / 2.0).sqrt() / predicted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_exact_line_is_found_beside_an_outlier_and_one_brightness_gives_none() {
        let level = |mean: f64, variance: f64| Level { mean, variance, shared: variance, freedom: 1000.0 };
        let mut levels: Vec<Level> =
            (1..40).map(|k| level(f64::from(k) / 40.0, 1e-5 + 4e-4 * f64::from(k) / 40.0)).collect();
        levels.push(level(0.3, 0.1));
        let line = Line::through(&levels, |level| level.variance).unwrap();
        assert!((line.read * line.read - 1e-5).abs() < 1e-9 && (line.shot - 4e-4).abs() < 1e-9, "{line:?}");
        let same: Vec<Level> = (0..9).map(|_| level(0.5, 1e-4)).collect();
        assert_eq!(Line::through(&same, |level| level.variance), None);
    }
}
