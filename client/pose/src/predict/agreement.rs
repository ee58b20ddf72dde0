//! Whether the two sets agree image by image.

use super::series::Row;
use serde::Serialize;

/// The threshold at which images are found or missed, as a part of the diameter: that of ADD's usual recall.
const FOUND: f64 = 0.1;

/// Its place among the thresholds.
const PLACE: usize = 9;

/// Agreement over the images of both sets.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Agreement {
    /// Spearman's rank correlation of the images' errors; absent where one set has no order.
    pub spearman: Option<f64>,
    /// The threshold of the next ones, as a part of the diameter.
    pub threshold: f64,
    /// Images whose targets are all found in both.
    pub both: u32,
    /// In the real image alone.
    pub real_alone: u32,
    /// In the synthetic image alone.
    pub synthetic_alone: u32,
    /// In neither.
    pub neither: u32,
    /// Cohen's kappa of that table; absent where chance alone would agree always.
    pub kappa: Option<f64>,
}

impl Agreement {
    pub(super) fn new(reals: &[&Row], synthetics: &[&Row]) -> Self {
        let errors = |rows: &[&Row]| rows.iter().map(|row| row.error).collect::<Vec<f64>>();
        let found = |row: &Row| row.found.get(PLACE) == Some(&row.targets);
        let mut table = [0u32; 4];
        for (real, synthetic) in reals.iter().zip(synthetics) {
            table[usize::from(!found(real)) * 2 + usize::from(!found(synthetic))] += 1;
        }
        let [both, real_alone, synthetic_alone, neither] = table;
        let all = f64::from(table.iter().sum::<u32>().max(1));
        let share = |counts: [u32; 2]| f64::from(counts[0] + counts[1]) / all;
        let (real, synthetic) = (share([both, real_alone]), share([both, synthetic_alone]));
        let chance = real * synthetic + (1.0 - real) * (1.0 - synthetic);
        let observed = share([both, neither]);
        let kappa = (chance < 1.0 - 1e-12).then(|| (observed - chance) / (1.0 - chance));
        let spearman = correlation(&ranks(&errors(reals)), &ranks(&errors(synthetics)));
        Self { spearman, threshold: FOUND, both, real_alone, synthetic_alone, neither, kappa }
    }
}

/// Ranks from 1, the mean of equals.
fn ranks(values: &[f64]) -> Vec<f64> {
    let count = |wanted: &dyn Fn(&f64) -> bool| {
        f64::from(u32::try_from(values.iter().filter(|v| wanted(v)).count()).unwrap_or(u32::MAX))
    };
    values.iter().map(|value| count(&|v| v < value) + (count(&|v| v == value) + 1.0) / 2.0).collect()
}

/// Pearson's correlation; `None` where one of the lists is constant.
fn correlation(a: &[f64], b: &[f64]) -> Option<f64> {
    let count = f64::from(u32::try_from(a.len()).ok()?);
    let mean = |list: &[f64]| list.iter().sum::<f64>() / count;
    let (ma, mb) = (mean(a), mean(b));
    let sum = |of: &dyn Fn(f64, f64) -> f64| a.iter().zip(b).map(|(x, y)| of(x - ma, y - mb)).sum::<f64>();
    let (xy, xx, yy) = (sum(&|x, y| x * y), sum(&|x, _| x * x), sum(&|_, y| y * y));
    (xx > 0.0 && yy > 0.0).then(|| xy / (xx * yy).sqrt())
}

/// Kendall's tau-b: pairs in the same order less pairs in opposite order, over the root of the pairs that each list tells apart;
/// `None` where one tells none apart.
#[must_use]
pub fn kendall(a: &[f64], b: &[f64]) -> Option<f64> {
    let (mut together, mut in_a, mut in_b) = (0.0, 0.0f64, 0.0f64);
    for (i, (x, y)) in a.iter().zip(b).enumerate() {
        for (u, v) in a.iter().zip(b).skip(i + 1) {
            let sign = |d: f64| {
                if d > 0.0 {
                    1.0
                } else if d < 0.0 {
                    -1.0
                } else {
                    0.0
                }
            };
            let (s, t) = (sign(x - u), sign(y - v));
            together += s * t;
            in_a += s * s;
            in_b += t * t;
        }
    }
    (in_a > 0.0 && in_b > 0.0).then(|| together / (in_a * in_b).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_forms() {
        assert_eq!(ranks(&[0.3, 0.1, 0.3, f64::INFINITY]), [2.5, 1.0, 2.5, 4.0]);
        // 1 - 6 sum d^2 / (n (n^2 - 1)) with d = 1, 1, 0, 0.
        let spearman = correlation(&ranks(&[1.0, 2.0, 3.0, 4.0]), &ranks(&[2.0, 1.0, 3.0, 4.0])).unwrap();
        assert!((spearman - 0.8).abs() < 1e-12);
        assert_eq!(kendall(&[1.0, 2.0, 3.0], &[1.0, 3.0, 2.0]), Some(1.0 / 3.0));
        assert_eq!(kendall(&[1.0, 1.0], &[1.0, 2.0]), None);
        assert_eq!(correlation(&[1.0, 1.0], &[1.0, 2.0]), None);
    }

    #[test]
    fn kappa_is_1_for_the_same_and_0_for_chance() {
        let row = |hit: bool| Row { targets: 1, found: vec![u32::from(hit); 50], error: if hit { 0.01 } else { 1.0 } };
        let (hit, miss) = (row(true), row(false));
        let same = Agreement::new(&[&hit, &miss, &hit], &[&hit, &miss, &hit]);
        assert_eq!((same.both, same.neither, same.kappa), (2, 1, Some(1.0)));
        let chance = Agreement::new(&[&hit, &hit, &miss, &miss], &[&hit, &miss, &hit, &miss]);
        assert_eq!((chance.real_alone, chance.synthetic_alone, chance.kappa), (1, 1, Some(0.0)));
    }
}
