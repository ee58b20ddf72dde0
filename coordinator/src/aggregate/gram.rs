//! The Gram matrix of one tile and channel, by far the largest sum of a reduction: one row per observation.
//!
//! Rows are collected in blocks and multiplied four columns by four, so that sums stay in registers while a block passes.
//! Every entry still adds its observations up one after the other, in the order in which they came: blocks change no bit.

/// Columns that are multiplied together: two registers of two doubles each.
const LANES: usize = 4;

/// Observations of a block: its panels of a hundred columns stay in the second-level cache.
const BLOCK: usize = 64;

type Lanes = [f64; LANES];

/// Sums `w (mean_i mean_j - half_i half_j)` over observations, for all pairs of columns.
///
/// With mean and half difference of two halves A and B this is w (A_i B_j + B_i A_j) / 2.
#[derive(Debug)]
pub struct Gram {
    side: usize,
    /// Column groups, the last one padded with zeros.
    groups: usize,
    /// Upper triangle of groups: `[group of i][group of j][i][j]`.
    sums: Vec<[Lanes; LANES]>,
    /// `[group][observation of the block]`: means and half differences.
    rows: Vec<[Lanes; 2]>,
    weights: Vec<f64>,
}

impl Gram {
    /// An empty sum over `side` columns.
    #[must_use]
    pub fn new(side: usize) -> Self {
        let groups = side.div_ceil(LANES);
        Self {
            side,
            groups,
            sums: vec![[[0.0; LANES]; LANES]; groups * groups],
            rows: vec![[[0.0; LANES]; 2]; groups * BLOCK],
            weights: Vec::with_capacity(BLOCK),
        }
    }

    /// Adds an observation of weight `weight`, whose column `i` has mean and half difference `value(i)`.
    pub fn add(&mut self, weight: f64, mut value: impl FnMut(usize) -> (f64, f64)) {
        if self.weights.len() == BLOCK {
            self.flush();
        }
        for i in 0..self.side {
            let row = &mut self.rows[i / LANES * BLOCK + self.weights.len()];
            (row[0][i % LANES], row[1][i % LANES]) = value(i);
        }
        self.weights.push(weight);
    }

    fn flush(&mut self) {
        let mut weighted = [[[0.0; LANES]; 2]; BLOCK];
        for i in 0..self.groups {
            let of = |group: usize| &self.rows[group * BLOCK..group * BLOCK + self.weights.len()];
            for (to, (from, w)) in weighted.iter_mut().zip(of(i).iter().zip(&self.weights)) {
                *to = from.map(|lanes| lanes.map(|v| w * v));
            }
            for j in i..self.groups {
                let sums = &mut self.sums[i * self.groups + j];
                *sums = multiply(*sums, &weighted, of(j));
            }
        }
        self.weights.clear();
    }

    /// The entries of the upper triangle, with row and column.
    pub fn finish(mut self) -> impl Iterator<Item = (usize, usize, f64)> {
        self.flush();
        (0..self.side).flat_map(move |i| (i..self.side).map(move |j| (i, j))).map(move |(i, j)| {
            let sums = &self.sums[i / LANES * self.groups + j / LANES];
            (i, j, sums[i % LANES][j % LANES])
        })
    }
}

/// Adds the products of a block's rows to the sums.
fn multiply(mut sums: [Lanes; LANES], left: &[[Lanes; 2]], right: &[[Lanes; 2]]) -> [Lanes; LANES] {
    for ([mean_i, half_i], [mean_j, half_j]) in left.iter().zip(right) {
        for i in 0..LANES {
            for j in 0..LANES {
                sums[i][j] += mean_i[i] * mean_j[j] - half_i[i] * half_j[j];
            }
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn has_the_bits_of_a_plain_loop() {
        for side in [1, 4, 7, 13] {
            let value = |row: usize, i: usize| (libm::sin((3 * row + i) as f64), libm::cos((row * i) as f64));
            let weight = |row: usize| 1.0 + (row % 5) as f64 / 7.0;
            let mut plain = vec![0.0_f64; side * side];
            let mut gram = Gram::new(side);
            for row in 0..3 * BLOCK + 5 {
                gram.add(weight(row), |i| value(row, i));
                for i in 0..side {
                    for j in 0..side {
                        let ((mi, hi), (mj, hj)) = (value(row, i), value(row, j));
                        plain[i * side + j] += weight(row) * mi * mj - weight(row) * hi * hj;
                    }
                }
            }
            let mut entries = 0;
            for (i, j, sum) in gram.finish() {
                assert_eq!(sum.to_bits(), plain[i * side + j].to_bits(), "{i} {j}");
                entries += 1;
            }
            assert_eq!(entries, side * (side + 1) / 2);
        }
    }
}
