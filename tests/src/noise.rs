//! Noise of a counter, for data that a test makes.

/// About Gaussian, of variance one: the sum of twelve uniform numbers by SplitMix64 (Steele, Lea, Flood 2014).
#[must_use]
pub fn gaussian(counter: u64) -> f64 {
    let uniform = |k: u64| {
        let mut z = (12 * counter + k + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..12).map(uniform).sum::<f64>() - 6.0
}
