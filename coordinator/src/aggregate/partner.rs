//! Whose render noise stands for a pixel's: that of a neighbour of like value.
//!
//! A pixel's own difference of halves is no independent witness of its noise where both are multiplied. A neighbour's is, if its
//! noise is of the same size. What makes a render noisy within a pixel, an edge, shows in the photograph: a pixel of mixed value has its
//! like along the edge. So the photograph chooses, and no render has a say in it.

use super::prediction::Prediction;
use gonio_scene::film::Tile;

/// For each of a tile's predictions the index of its partner among them: of the up to eight around the one whose photo values are
/// nearest; where none is around, the nearer of those before and after in row order; one alone is its own.
pub fn partners(tile: Tile, predictions: &[Prediction]) -> Vec<usize> {
    let (width, height) = (tile.width as usize, tile.height as usize);
    let mut rows = vec![None; tile.len()];
    predictions.iter().enumerate().for_each(|(row, p)| rows[p.index] = Some(row));
    let apart = |a: usize, b: usize| -> f64 {
        let (a, b) = (&predictions[a].measured, &predictions[b].measured);
        a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
    };
    let nearest = |row: usize, others: &mut dyn Iterator<Item = usize>| {
        others.map(|other| (apart(row, other), other)).min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, other)| other)
    };
    let partner = |(row, p): (usize, &Prediction)| {
        let (x, y) = (p.index % width, p.index / width);
        let lines = y.saturating_sub(1)..(y + 2).min(height);
        let columns = x.saturating_sub(1)..(x + 2).min(width);
        let around = lines.flat_map(|y| columns.clone().map(move |x| y * width + x));
        let mut around = around.filter_map(|place| rows[place]).filter(|other| *other != row);
        let beside = [row.checked_sub(1), Some(row + 1).filter(|next| *next < predictions.len())];
        nearest(row, &mut around).or_else(|| nearest(row, &mut beside.into_iter().flatten())).unwrap_or(row)
    };
    predictions.iter().enumerate().map(partner).collect()
}
