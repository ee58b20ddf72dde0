//! How many pixels each stratum gets.

/// The exponent of a stratum's size in its share of the pixels: at 1 all pixels are alike, at 0 all strata. Halfway between, a stratum
/// with a hundredth of the pixels gets a tenth of what is compared (power allocation: Bankier 1988, The American Statistician 42).
const POWER: f64 = 0.5;

/// Smallest probability relative to the mean one: so that no pixel stands for more than four of its even share, and none of the
/// estimates hangs on a few.
const LEAST: f64 = 0.25;

/// The probability of a pixel in each stratum, from the strata's sizes in pixels, so that `wanted` pixels are drawn in the mean; 1 for
/// all where there are no more.
pub fn allocate(sizes: &[f64], wanted: f64) -> Vec<f64> {
    let total: f64 = sizes.iter().sum();
    if wanted >= total {
        return vec![1.0; sizes.len()];
    }
    let floor = LEAST * wanted / total;
    let rate = |size: f64, scale: f64| (scale * libm::pow(size, POWER - 1.0)).clamp(floor, 1.0);
    let drawn = |scale: f64| sizes.iter().map(|size| size * rate(*size, scale)).sum::<f64>();
    // What is drawn rises with the scale, from below what is wanted to all: bisection, to the last bits of a double.
    let (mut low, mut high) = (0.0, sizes.iter().fold(1.0, |most: f64, size| most.max(libm::pow(*size, 1.0 - POWER))));
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        (low, high) = if drawn(middle) < wanted { (middle, high) } else { (low, middle) };
    }
    sizes.iter().map(|size| rate(*size, high)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_are_drawn_as_are_wanted_and_small_strata_more_often() {
        let sizes = [1e6, 1e4, 100.0, 1.0];
        for wanted in [100.0, 5000.0, 2e5, 1e6] {
            let rates = allocate(&sizes, wanted);
            let drawn: f64 = sizes.iter().zip(&rates).map(|(size, rate)| size * rate).sum();
            assert!((drawn / wanted - 1.0).abs() < 1e-9, "{drawn} of {wanted}");
            assert!(rates.windows(2).all(|pair| pair[0] <= pair[1]));
            assert!(rates.iter().all(|rate| *rate >= LEAST * wanted / 1_010_101.0 && *rate <= 1.0));
        }
        // A hundredth of the pixels, a tenth of the share, while none is drawn with certainty.
        let rates = allocate(&[1e6, 1e4], 1100.0);
        assert!((rates[1] / rates[0] - 10.0).abs() < 1e-6);
    }

    #[test]
    fn all_are_drawn_where_there_are_no_more() {
        assert_eq!(allocate(&[3.0, 4.0], 7.0), [1.0; 2]);
        assert!(allocate(&[], 5.0).is_empty());
    }
}
