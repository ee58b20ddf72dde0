//! Noise of one photo, in tiles that are flat but for a smooth shading.

use super::level::{Level, half_lags};
use rayon::prelude::*;

/// Half the side of the window of neighbours whose noise may be shared.
const REACH: i64 = 2;
/// Sides of a tile in pixels, in photos that have many pixels and in those that have few.
const SIDES: [usize; 2] = [32, 16];
/// A photo has many pixels where this many of its larger tiles count.
const MANY: usize = 400;
/// Side of the blocks whose means tell structure from noise, pixels.
const BLOCK: usize = 4;
/// A tile is flat where its blocks differ, against its noise, by at most this much more than those of the flattest fifth do.
const ROUGHER: f64 = 2.0;

/// Blocks of white noise differ by 16 in these units, those of a demosaiced photo by up to four times that; where the
/// flattest fifth differs more, the photo has no flat tile.
const TEXTURE: f64 = 100.0;

/// One tile's noise, how much its blocks differ in units of it, and its noise by differences of neighbours.
struct Tile {
    level: Level,
    structure: f64,
    fine: f64,
}

/// A channel's levels.
pub(super) struct Levels {
    /// Of each flat tile.
    pub flat: Vec<Level>,
    /// How many tiles there were.
    pub tiles: usize,
    /// Whether no tile is flat, so that differences of neighbours alone were taken.
    pub fine: bool,
}

/// The noise of a channel in each of its flat tiles.
pub(super) fn levels(values: &[f32], width: usize, usable: &[bool]) -> Levels {
    let tiles = |side: usize| tiles_of(values, width, usable, side);
    let [large, small] = SIDES;
    let mut all = tiles(large);
    if all.len() < MANY {
        all = tiles(small);
    }
    let mut structures: Vec<f64> = all.iter().map(|tile| tile.structure).collect();
    structures.sort_by(f64::total_cmp);
    let least = structures.get(structures.len() / 5).copied().unwrap_or(0.0);
    let tiles = all.len();
    if least > TEXTURE {
        let fine = |tile: &Tile| {
            let Level { mean, freedom, .. } = tile.level;
            Level { mean, variance: tile.fine, shared: tile.fine, freedom: freedom / 6.0 }
        };
        return Levels { flat: all.iter().filter(|tile| tile.fine > 0.0).map(fine).collect(), tiles, fine: true };
    }
    let is_flat = |tile: &&Tile| tile.structure <= ROUGHER * least && tile.level.variance > 0.0;
    Levels { flat: all.iter().filter(is_flat).map(|tile| tile.level).collect(), tiles, fine: false }
}

fn tiles_of(values: &[f32], width: usize, usable: &[bool], side: usize) -> Vec<Tile> {
    let height = usable.len() / width.max(1);
    let basis = Basis::new(side);
    let corners: Vec<[usize; 2]> = (0..height / side)
        .flat_map(|row| (0..width / side).map(move |column| [column * side, row * side]))
        .filter(|&[x, y]| (y..y + side).all(|row| usable[row * width + x..][..side].iter().all(|good| *good)))
        .collect();
    let cut = |&[x, y]: &[usize; 2]| -> Vec<f64> {
        (y..y + side).flat_map(|row| &values[row * width + x..][..side]).map(|value| f64::from(*value)).collect()
    };
    corners.par_iter().map(|corner| basis.tile(cut(corner))).collect()
}

/// Smooth shadings of a tile: 1, x, y, x^2, x y, y^2, made orthonormal.
struct Basis {
    side: usize,
    shadings: Vec<Vec<f64>>,
    lags: Vec<[i64; 2]>,
    /// What the sum of covariances of white noise of variance 1 is, once its smooth part is taken out.
    kept: f64,
}

impl Basis {
    fn new(side: usize) -> Self {
        let place = |k: usize| (2.0 * k as f64 + 1.0) / side as f64 - 1.0;
        let functions: [fn(f64, f64) -> f64; 6] =
            [|_, _| 1.0, |x, _| x, |_, y| y, |x, _| x * x, |x, y| x * y, |_, y| y * y];
        let mut shadings: Vec<Vec<f64>> = Vec::new();
        for function in functions {
            let mut shading: Vec<f64> = (0..side * side).map(|k| function(place(k % side), place(k / side))).collect();
            for known in &shadings {
                remove(&mut shading, known);
            }
            let norm = dot(&shading, &shading).sqrt();
            shading.iter_mut().for_each(|value| *value /= norm);
            shadings.push(shading);
        }
        let mut basis = Self { side, shadings, lags: half_lags(REACH), kept: 1.0 };
        // E[sum over lags of r r'] = 1 - sum over shadings of the same sum of b b', for each lag over its pairs.
        basis.kept = 1.0 - basis.shadings.iter().map(|shading| basis.covariances(shading)).sum::<f64>();
        basis
    }

    fn tile(&self, mut values: Vec<f64>) -> Tile {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let fine = self.fine(&values);
        for shading in &self.shadings {
            remove(&mut values, shading);
        }
        let freedom = count - self.shadings.len() as f64;
        let variance = dot(&values, &values) / freedom;
        let shared = self.covariances(&values) / self.kept;
        let blocks = self.side / BLOCK;
        let block = |k: usize| {
            let (x, y) = (k % blocks * BLOCK, k / blocks * BLOCK);
            (y..y + BLOCK).flat_map(|row| &values[row * self.side + x..][..BLOCK]).sum::<f64>()
        };
        let spread = (0..blocks * blocks).map(|k| block(k) * block(k)).sum::<f64>() / (blocks * blocks) as f64;
        let structure = if variance > 0.0 { spread / variance } else { f64::INFINITY };
        Tile { level: Level { mean, variance, shared, freedom }, structure, fine }
    }

    /// The noise by a mask that no plane and no curved surface passes (Immerkaer, "Fast noise variance estimation", CVIU 64,
    /// 1996), by the median of its squares, which edges do not move: of a normal distribution that is 0.4549 of the mean.
    fn fine(&self, values: &[f64]) -> f64 {
        let side = self.side;
        let inner = (1..side - 1).flat_map(|y| (1..side - 1).map(move |x| (x, y)));
        let mut squares: Vec<f64> = inner
            .map(|(x, y)| {
                let at = |dx: usize, dy: usize| values[(y + dy - 1) * side + x + dx - 1];
                let edges = at(1, 0) + at(0, 1) + at(2, 1) + at(1, 2);
                let mask = at(0, 0) + at(2, 0) + at(0, 2) + at(2, 2) - 2.0 * edges + 4.0 * at(1, 1);
                mask * mask / 36.0
            })
            .collect();
        squares.sort_by(f64::total_cmp);
        squares.get(squares.len() / 2).map_or(0.0, |middle| middle / 0.4549)
    }

    /// The sum over the window's lags of the mean product of values that far apart.
    fn covariances(&self, values: &[f64]) -> f64 {
        let side = self.side as i64;
        let product = |&[dx, dy]: &[i64; 2]| {
            let columns = (-dx).max(0)..side - dx.max(0);
            let rows = 0..side - dy;
            let pairs = ((columns.end - columns.start) * (rows.end - rows.start)) as f64;
            let at = |x: i64, y: i64| values[(y * side + x) as usize];
            let each = rows.flat_map(|y| columns.clone().map(move |x| at(x, y) * at(x + dx, y + dy)));
            2.0 * each.sum::<f64>() / pairs
        };
        dot(values, values) / values.len() as f64 + self.lags.iter().map(product).sum::<f64>()
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn remove(values: &mut [f64], shading: &[f64]) {
    let share = dot(values, shading);
    values.iter_mut().zip(shading).for_each(|(value, part)| *value -= share * part);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_smooth_shading_leaves_nothing() {
        let basis = Basis::new(16);
        let shading =
            (0..256).map(|k| 0.2 + 0.01 * f64::from(k % 16) + 3e-4 * f64::from((k / 16) * (k / 16))).collect();
        assert!(basis.tile(shading).level.variance < 1e-20);
        assert!(basis.kept > 0.3 && basis.kept < 1.0, "{}", basis.kept);
    }
}
