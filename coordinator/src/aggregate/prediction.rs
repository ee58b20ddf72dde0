//! Both halves' predictions of a tile's pixels, and of their derivatives.

use super::merge::MergedFilm;
use super::recipe::{ActiveColumn, Recipe, SensorColumn};
use super::statistics::Observed;
use gonio_scene::{PhotoValue, SensorStage};

/// Both halves' predictions of one pixel that counts, per colour channel.
#[derive(Debug, Clone)]
pub struct Prediction {
    /// Index of the pixel in the film.
    pub pixel: usize,
    /// Index of the pixel in the tile.
    pub index: usize,
    /// y: the photo's values.
    pub measured: [f64; 3],
    /// r: the mean of the photo's values around.
    pub surroundings: [f64; 3],
    /// h: for how many pixels this one stands.
    pub weight: f64,
    /// M: the values predicted by the mean of the halves.
    pub value: [f64; 3],
    /// P_A - P_B.
    pub difference: [f64; 3],
    /// S: d value of row's channel / d exposed light of column's channel.
    slope: [[f64; 3]; 3],
    /// Whether the slope has entries off its diagonal.
    mixes: bool,
    /// Per sensor column: mean and half difference of the halves' derivatives.
    sensor: Vec<[[f64; 3]; 2]>,
}

impl Prediction {
    /// Mean and half difference of the halves' derivatives by one column in one channel. `halves` are the pixel's films.
    #[must_use]
    pub fn column(&self, channel: usize, column: &ActiveColumn, halves: [&[f64]; 2]) -> (f64, f64) {
        if let Some([mean, half]) = column.sensor.and_then(|index| self.sensor.get(index)) {
            return (mean[channel], half[channel]);
        }
        let slope = &self.slope[channel];
        let [a, b] = halves;
        if !self.mixes {
            let (mut column_a, mut column_b) = (0.0, 0.0);
            for (film_channel, factor) in &column.terms {
                column_a += factor * a[*film_channel];
                column_b += factor * b[*film_channel];
            }
            return (slope[channel] * 0.5 * (column_a + column_b), slope[channel] * 0.5 * (column_a - column_b));
        }
        let (mut mean, mut half) = (0.0, 0.0);
        for (film_channel, factor) in &column.terms {
            let rate = slope[film_channel % 3] * 0.5 * factor;
            mean += rate * (a[*film_channel] + b[*film_channel]);
            half += rate * (a[*film_channel] - b[*film_channel]);
        }
        (mean, half)
    }
}

/// Predictions of the rendered pixels that count, in row order.
#[must_use]
pub fn predict(film: &MergedFilm, observed: Observed<'_>, recipe: &Recipe) -> Vec<Prediction> {
    let Observed { tile, pixels, photograph, .. } = observed;
    let mut predictions = Vec::with_capacity(film.pixels);
    for (pixel, index) in pixels.indices().enumerate() {
        let (x, y) = (tile.x as usize + index % tile.width as usize, tile.y as usize + index / tile.width as usize);
        let Some(photo) = photograph.at(x, y) else { continue };
        let half = |half: usize| {
            let film = film.pixel(half, pixel);
            [0, 1, 2].map(|c| recipe.factor * film[c])
        };
        let (a, b) = (half(0), half(1));
        let mean = [0, 1, 2].map(|c| 0.5 * (a[c] + b[c]));
        let apart = [0, 1, 2].map(|c| a[c] - b[c]);
        let predicted = recipe.stage.value(mean, x, y);
        let value = |stage: &SensorStage| if *stage == recipe.stage { predicted } else { stage.value(mean, x, y) };
        let difference = through(&predicted.slope, apart, recipe.stage.mixes());
        predictions.push(Prediction {
            pixel,
            index,
            measured: photo.value.map(f64::from),
            surroundings: photo.surroundings.map(f64::from),
            weight: photo.weight,
            value: predicted.value,
            difference,
            slope: predicted.slope,
            mixes: recipe.stage.mixes(),
            sensor: recipe.sensor.iter().map(|c| derivative(c, &value(&c.from), &value(&c.to), apart)).collect(),
        });
    }
    predictions
}

/// The slope times a small difference of exposed light.
fn through(slope: &[[f64; 3]; 3], light: [f64; 3], mixes: bool) -> [f64; 3] {
    [0, 1, 2].map(|c| {
        let row = &slope[c];
        // Without crosstalk no sum, so that channels cannot touch each other's bits.
        if mixes { row[0] * light[0] + row[1] * light[1] + row[2] * light[2] } else { row[c] * light[c] }
    })
}

/// Mean and half difference of the halves' derivatives by a number of the sensor.
fn derivative(column: &SensorColumn, from: &PhotoValue, to: &PhotoValue, apart: [f64; 3]) -> [[f64; 3]; 2] {
    let rate = 1.0 / column.distance;
    let mut slope = to.slope;
    slope.iter_mut().flatten().zip(from.slope.iter().flatten()).for_each(|(to, from)| *to -= from);
    let half = through(&slope, apart, true);
    [[0, 1, 2].map(|c| (to.value[c] - from.value[c]) * rate), half.map(|h| 0.5 * h * rate)]
}
