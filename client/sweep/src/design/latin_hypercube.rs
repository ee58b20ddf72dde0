//! Latin hypercubes (McKay, Beckman and Conover 1979): n points, one in each of n equal parts of every axis.

/// For each axis the coordinates, in 0..1, of `count` points.
#[allow(clippy::cast_precision_loss)]
pub(super) fn columns(axes: usize, count: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut random = SplitMix64(seed);
    let mut column = || {
        let mut parts: Vec<usize> = (0..count).collect();
        // Fisher and Yates; the modulo's bias is below 2^-40 for any count that a sweep allows.
        for i in (1..count).rev() {
            parts.swap(i, (random.next() % (i as u64 + 1)) as usize);
        }
        parts.iter().map(|part| (*part as f64 + random.unit()) / count as f64).collect()
    };
    (0..axes).map(|_| column()).collect()
}

/// Steele, Lea and Flood 2014: a small generator whose sequence is fixed by its paper, so that no update of a crate moves
/// the points of a sweep.
struct SplitMix64(u64);

impl SplitMix64 {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// 53 bits, in 0..1.
    #[allow(clippy::cast_precision_loss)]
    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_generator_is_that_of_the_paper() {
        // The first numbers for seed 1234567, as published with the reference implementation.
        let mut random = SplitMix64(1_234_567);
        let expected = [6_457_827_717_110_365_317_u64, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423];
        assert_eq!([random.next(), random.next(), random.next()], expected);
    }

    #[test]
    fn every_part_of_every_axis_holds_one_point() {
        for (axes, count, seed) in [(3, 100, 0), (1, 1, 7), (5, 17, 42)] {
            for column in columns(axes, count, seed) {
                let mut parts: Vec<usize> = column.iter().map(|x| (x * count as f64) as usize).collect();
                parts.sort_unstable();
                assert_eq!(parts, (0..count).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn axes_are_permuted_apart_and_seeds_differ() {
        let of = |seed| columns(2, 50, seed);
        assert_eq!(of(3), of(3));
        assert_ne!(of(3), of(4));
        // Kendall's tau of independent permutations of 50 has a standard deviation of 0.097.
        let columns = of(3);
        let mut tau = 0.0;
        for i in 0..50 {
            for j in 0..i {
                tau += ((columns[0][i] - columns[0][j]) * (columns[1][i] - columns[1][j])).signum();
            }
        }
        assert!((tau / 1225.0_f64).abs() < 0.4, "{tau}");
    }
}
