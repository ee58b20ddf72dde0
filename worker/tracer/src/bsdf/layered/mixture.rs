//! Which lobe is sampled how often.

/// Index of the GGX lobe of `roughness`.
pub const FIRST: usize = 0;
/// Index of the second plastic's GGX lobe.
pub const SECOND: usize = 1;
/// Index of the diffuse part.
pub const DIFFUSE: usize = 2;
/// Index of the sheen.
pub const SHEEN: usize = 3;
/// Index of the coat's GGX lobe.
pub const COAT: usize = 4;
/// How many lobes there may be.
pub const LOBES: usize = 5;

/// Least chance of a lobe that is there: its share is an estimate, and its derivative may be more than its value.
const LEAST: f32 = 0.1;

/// Chances of the lobes, adding up to 1.
#[derive(Clone, Copy, Debug)]
pub struct Mixture([f32; LOBES]);

impl Mixture {
    /// Chances about in proportion to shares of the reflected light; `None` for a lobe that is not there.
    #[inline]
    pub fn new(shares: [Option<f32>; LOBES]) -> Self {
        let sum: f32 = shares.iter().flatten().sum();
        let count = shares.iter().flatten().count() as f32;
        // Without any light every lobe has the same chance.
        let (scale, least) = if sum > 0.0 { ((1.0 - count * LEAST) / sum, LEAST) } else { (0.0, 1.0 / count) };
        Self(shares.map(|share| share.map_or(0.0, |s| least + scale * s)))
    }

    /// The lobe that a uniform number chooses.
    #[inline]
    pub fn pick(&self, choice: f32) -> usize {
        let mut left = choice;
        let mut last = DIFFUSE;
        for (lobe, chance) in self.0.iter().enumerate().filter(|(_, chance)| **chance > 0.0) {
            if left < *chance {
                return lobe;
            }
            left -= chance;
            last = lobe;
        }
        // Past the end by rounding only.
        last
    }

    /// A lobe's chance.
    #[inline]
    pub fn chance(&self, lobe: usize) -> f32 {
        self.0[lobe]
    }

    /// The mixture of the lobes' densities.
    #[inline]
    pub fn density(&self, densities: &[f32; LOBES]) -> f32 {
        self.0.iter().zip(densities).map(|(chance, density)| chance * density).sum()
    }
}
