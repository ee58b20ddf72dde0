//! A design of observations: which pixels of a photo are compared, and for how many each of them stands.
//!
//! A photo of twelve megapixels tells more than a fit needs, and every pixel costs a path. So a pixel is drawn with a
//! probability p, the same in a cell of the photo, and counts 1 / p times: sums over the drawn pixels then have the sums over all
//! pixels as their expectation, whatever is summed and however the probabilities were chosen (Horvitz and Thompson 1952). Pixels
//! are drawn independently of each other, by a hash of (seed, photo, place): who draws them, and in which order, changes nothing.

use std::sync::LazyLock;

/// Steps of a code in which the probability halves.
const STEPS: f64 = 8.0;

/// The probability of every code: 2^(-code / 8), from 1 down to 2.5e-10.
static PROBABILITIES: LazyLock<[f64; 256]> =
    LazyLock::new(|| std::array::from_fn(|code| libm::exp2(-(code as f64) / STEPS)));

/// Which pixels are compared, of the photos that it names; of all others, every one.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Design {
    /// Seed of the draw.
    pub seed: u64,
    /// Index of a photo and its rates; ascending, each photo once.
    pub photos: Vec<(usize, Rates)>,
}

impl Design {
    /// The rates of a photo, where it has any.
    #[must_use]
    pub fn rates(&self, photo: usize) -> Option<&Rates> {
        let found = self.photos.binary_search_by_key(&photo, |(index, _)| *index).ok()?;
        Some(&self.photos[found].1)
    }
}

/// The probabilities of a photo's pixels, cell by cell.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Rates {
    /// Side of a cell in pixels; at the right and bottom edge, cells may be cut.
    pub cell: u32,
    /// Cells side by side.
    pub columns: u32,
    /// Row by row from the top: a pixel is drawn with the probability 2^(-code / 8).
    pub codes: Vec<u8>,
}

impl Rates {
    /// Whether the cells cover an image of this size, and no more.
    #[must_use]
    pub fn cover(&self, width: u32, height: u32) -> bool {
        self.cell > 0
            && self.columns == width.div_ceil(self.cell)
            && self.codes.len() as u64 == u64::from(self.columns) * u64::from(height.div_ceil(self.cell))
    }

    /// The code of the probability that is nearest to `probability` and not below it; of 1 for what is larger.
    #[must_use]
    pub fn code(probability: f64) -> u8 {
        let code = -STEPS * libm::log2(probability);
        // A saturating cast: what is not above zero, or is no number, becomes the smallest probability or 1.
        if probability > 0.0 { code.floor() as u8 } else { u8::MAX }
    }

    /// The probability of a code.
    #[must_use]
    pub fn probability(code: u8) -> f64 {
        PROBABILITIES[usize::from(code)]
    }

    /// For how many pixels one stands that was drawn with the probability of a code.
    #[must_use]
    pub fn weight(code: u8) -> f64 {
        1.0 / Self::probability(code)
    }

    /// The draw of photo `photo` by a seed.
    #[must_use]
    pub fn draw(&self, seed: u64, photo: usize) -> Draw<'_> {
        Draw { rates: self, key: mix(seed ^ mix(photo as u64 + 1)) }
    }
}

/// Draws a photo's pixels.
#[derive(Debug, Clone, Copy)]
pub struct Draw<'a> {
    rates: &'a Rates,
    key: u64,
}

impl Draw<'_> {
    /// The code of the pixel in column `x` and row `y`, inside of the cells, if it is drawn.
    #[must_use]
    pub fn code(&self, x: u32, y: u32) -> Option<u8> {
        let Rates { cell, columns, codes } = self.rates;
        let code = codes[(y / cell) as usize * *columns as usize + (x / cell) as usize];
        let number = mix(self.key ^ mix((u64::from(y) << 32 | u64::from(x)) + 1));
        let uniform = (number >> 11) as f64 / (1_u64 << 53) as f64;
        (uniform < Rates::probability(code)).then_some(code)
    }
}

/// The finaliser of SplitMix64 (Steele, Lea and Flood 2014).
fn mix(number: u64) -> u64 {
    let z = number.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rates(codes: &[u8]) -> Rates {
        Rates { cell: 100, columns: 2, codes: codes.to_vec() }
    }

    #[test]
    fn codes_round_towards_more_pixels() {
        assert_eq!((Rates::code(1.0), Rates::code(2.0), Rates::code(0.5), Rates::code(0.0)), (0, 0, 8, 255));
        for p in [0.9, 0.3, 0.01, 1e-6] {
            let found = Rates::probability(Rates::code(p));
            assert!(found >= p * (1.0 - 1e-12) && found < p * 1.0906, "{p} became {found}");
        }
    }

    #[test]
    fn cells_cover_an_image_and_no_more() {
        assert!(rates(&[0; 4]).cover(200, 101) && rates(&[0; 4]).cover(101, 200));
        assert!(!rates(&[0; 4]).cover(201, 200) && !rates(&[0; 4]).cover(200, 100) && !rates(&[0; 3]).cover(200, 200));
        assert!(!Rates { cell: 0, columns: 0, codes: Vec::new() }.cover(1, 1));
    }

    /// Each rate draws as many as it says, within four standard deviations of a binomial number, and the weighted sum of a function
    /// of the place is that of all pixels, within four of the estimate's own.
    #[test]
    fn drawn_pixels_stand_for_all() {
        let rates = rates(&[0, 8, 24, 40]);
        let mut over_seeds = 0.0;
        for seed in 0..20 {
            let draw = rates.draw(seed, 3);
            let mut counts = [0.0; 4];
            let (mut sum, mut all, mut variance) = (0.0, 0.0, 0.0);
            for (x, y) in (0..200_u32).flat_map(|y| (0..200).map(move |x| (x, y))) {
                let value = f64::from(x * x) + f64::from(y);
                let cell = (y / 100 * 2 + x / 100) as usize;
                let weight = Rates::weight(rates.codes[cell]);
                all += value;
                variance += (weight - 1.0) * value * value;
                if let Some(code) = draw.code(x, y) {
                    assert_eq!(code, rates.codes[cell]);
                    counts[cell] += 1.0;
                    sum += weight * value;
                }
            }
            for (count, code) in counts.iter().zip(&rates.codes) {
                let p = Rates::probability(*code);
                assert!((count - 1e4 * p).abs() <= 4.0 * (1e4 * p * (1.0 - p)).sqrt(), "{count} of rate {p}");
            }
            let z = (sum - all) / variance.sqrt();
            assert!(z.abs() < 4.0, "{z}");
            over_seeds += z * z;
        }
        // Chi-square of 20 degrees of freedom, 0.1 % on either side.
        assert!((5.9..45.3).contains(&over_seeds), "{over_seeds}");
    }

    #[test]
    fn another_photo_or_seed_draws_others() {
        let rates = rates(&[8; 4]);
        let places = || (0..200_u32).flat_map(|y| (0..200).map(move |x| (x, y)));
        let drawn =
            |seed, photo| places().filter(|(x, y)| rates.draw(seed, photo).code(*x, *y).is_some()).collect::<Vec<_>>();
        let first = drawn(0, 0);
        for other in [drawn(1, 0), drawn(0, 1)] {
            let both =
                first.iter().filter(|place| other.binary_search_by_key(&(place.1, place.0), |p| (p.1, p.0)).is_ok());
            // A quarter of 40000, within four standard deviations.
            assert!((both.count() as f64 - 1e4).abs() < 4.0 * 7500.0_f64.sqrt());
        }
        assert_eq!(first, drawn(0, 0));
    }
}
