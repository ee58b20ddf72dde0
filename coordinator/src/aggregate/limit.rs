//! Derivative columns without fireflies.
//!
//! A path that finds a lamp in a highlight's mirror image (board, part, lamp) is rare and bright, and its derivative by what
//! shapes the highlight brighter still: a handful of pixels would carry most of a Gram matrix, by chance. So a half's
//! column value is cut where it exceeds many times what the pixels around it hold. What a column loses by that makes a
//! step or a score a little less than optimal, not biased: with columns c that do not depend on the residual's own
//! noise, E[c'We] is zero at the right model whatever c is. Hence the limit looks at other pixels alone.

use super::window::Window;
use gonio_scene::film::Tile;

/// Multiple of the mean magnitude of the pixels around, in a 5x5 window.
const NEARBY: f64 = 8.0;
/// Multiple of the whole tile's mean magnitude that is allowed besides, for a lone edge in an empty window.
const TILE: f64 = 4.0;
/// Where the tile has more pixels than so many for each that is compared, no window of 25 is looked at: in the mean it would hold
/// less than two of them.
const LONELY: usize = 16;

/// Cuts one column of a tile in place: `(mean, half difference)` of the two halves, and the place in the tile, per pixel.
pub fn limit(tile: Tile, places: impl Iterator<Item = usize> + Clone, column: &mut [(f64, f64)]) {
    // Equal halves are exact, as measured reflectance's are: no peak there is by chance.
    if column.iter().all(|(_, half)| *half == 0.0) {
        return;
    }
    let magnitude = |(mean, half): &(f64, f64)| 0.5 * ((mean + half).abs() + (mean - half).abs());
    let mut total = 0.0;
    column.iter().for_each(|value| total += magnitude(value));
    if total == 0.0 {
        return;
    }
    let count = column.len() as f64;
    let allowed = |own: f64| TILE * if count > 1.0 { (total - own).max(0.0) / (count - 1.0) } else { own };
    let is_suspect = |value: &(f64, f64)| {
        let (a, b) = ((value.0 + value.1).abs(), (value.0 - value.1).abs());
        a.max(b) > allowed(magnitude(value))
    };
    // Most columns of most tiles have none: then what lies around need not be known.
    if !column.iter().any(is_suspect) {
        return;
    }
    // Pixels that were drawn have no neighbours among themselves, and their tile is large: its mean stands for a window.
    let window = (tile.len() < LONELY * column.len()).then(|| {
        let mut magnitudes = vec![None; tile.len()];
        for (place, value) in places.clone().zip(column.iter()) {
            magnitudes[place] = Some(magnitude(value));
        }
        Window::new(tile, &magnitudes)
    });
    for (place, value) in places.zip(column.iter_mut()).filter(|(_, value)| is_suspect(value)) {
        let allowed = allowed(magnitude(value));
        let nearby = window.as_ref().map_or(allowed / TILE, |window| window.at(place));
        let most = NEARBY * nearby + allowed;
        let (mean, half) = *value;
        let (a, b) = ((mean + half).clamp(-most, most), (mean - half).clamp(-most, most));
        // Untouched bits where nothing is cut.
        if a != mean + half || b != mean - half {
            *value = (0.5 * (a + b), 0.5 * (a - b));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: Tile = Tile { x: 0, y: 0, width: 16, height: 16 };

    #[test]
    fn a_smooth_column_and_an_edge_keep_their_bits() {
        let smooth: Vec<(f64, f64)> = (0..256).map(|i| (1.0 + f64::from(i % 16) * 0.3, 0.2)).collect();
        let edge: Vec<(f64, f64)> = (0..256).map(|i| if i % 16 == 7 { (5.0, 1.0) } else { (0.0, 0.0) }).collect();
        for column in [smooth, edge] {
            let mut limited = column.clone();
            limit(SQUARE, 0..256, &mut limited);
            assert_eq!(limited, column);
        }
    }

    #[test]
    fn a_peak_in_both_halves_of_an_exact_column_stays() {
        let mut column = vec![(1.0, 0.0); 256];
        column[100].0 = 1000.0;
        limit(SQUARE, 0..256, &mut column);
        assert_eq!(column[100], (1000.0, 0.0));
    }

    #[test]
    fn a_firefly_in_one_half_is_cut_in_that_half() {
        let mut column = vec![(1.0, 0.0); 256];
        // Half A holds 1000, half B 1.
        column[100] = (500.5, 499.5);
        limit(SQUARE, 0..256, &mut column);
        let (a, b) = (column[100].0 + column[100].1, column[100].0 - column[100].1);
        assert!((a - 12.0).abs() < 1e-12 && (b - 1.0).abs() < 1e-12, "{a} {b}");
        assert!(column.iter().enumerate().all(|(i, c)| i == 100 || *c == (1.0, 0.0)));
    }
}
