//! One point of the plot: the noise at one brightness.

/// The noise of pixels of about one brightness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Level {
    /// Their mean value.
    pub mean: f64,
    /// Variance of a pixel's value.
    pub variance: f64,
    /// The sum of the noise's covariances with all near pixels, its own variance among them: what the variance of a mean
    /// over many pixels is, times their number.
    pub shared: f64,
    /// Degrees of freedom of `variance`.
    pub freedom: f64,
}

/// Which lags of a window of half side `reach` are counted twice: one of every pair of opposite lags, without lag 0.
pub(super) fn half_lags(reach: i64) -> Vec<[i64; 2]> {
    let all = (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| [x, y]));
    all.filter(|&[x, y]| y > 0 || (y == 0 && x > 0)).collect()
}

#[cfg(test)]
mod tests {
    use super::half_lags;

    #[test]
    fn half_of_a_window_and_its_mirror_are_the_window() {
        let half = half_lags(2);
        assert_eq!(half.len(), 12);
        assert!(half.iter().all(|&[x, y]| !half.contains(&[-x, -y])));
    }
}
