//! What was measured: a whole photograph, or the pixels of it that a design has drawn.

use gonio_scene::design::{Draw, Rates};
use gonio_scene::film::{PixelSet, Tile};
use gonio_scene::surroundings::Surroundings;
use gonio_scene::{Photograph, Values};

/// What an evaluation compares a photo's render with.
#[derive(Debug, Clone)]
pub enum Measured {
    /// Every pixel.
    All(Photograph),
    /// Those that were drawn.
    Drawn(Drawn),
}

/// A pixel that counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Value {
    /// As in the file.
    pub value: [f32; 3],
    /// The mean of the pixels around it that count, drawn or not.
    pub surroundings: [f32; 3],
    /// For how many pixels it stands; 1 where all are compared.
    pub weight: f64,
}

impl Measured {
    /// Width and height in pixels.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        match self {
            Self::All(photograph) => (photograph.image.width, photograph.image.height),
            Self::Drawn(drawn) => drawn.size,
        }
    }

    /// What was measured in column `x` and row `y`, which lie inside, if it counts.
    #[must_use]
    pub fn at(&self, x: usize, y: usize) -> Option<Value> {
        match self {
            Self::All(photograph) => {
                let place = y * photograph.image.width as usize + x;
                let (value, surroundings) = (photograph.image.pixels[place], photograph.surroundings[place]);
                photograph.counts[place].then_some(Value { value, surroundings, weight: 1.0 })
            }
            Self::Drawn(drawn) => drawn.at(x, y),
        }
    }

    /// The pixels of a tile that count.
    #[must_use]
    pub fn pixels(&self, tile: Tile) -> PixelSet {
        let rows = tile.y as usize..(tile.y + tile.height) as usize;
        let (left, width) = (tile.x as usize, tile.width as usize);
        match self {
            Self::All(photograph) => {
                let row = |y: usize| {
                    let start = y * photograph.image.width as usize + left;
                    photograph.counts[start..start + width].iter().copied()
                };
                PixelSet::from_flags(rows.flat_map(row))
            }
            Self::Drawn(drawn) => {
                let top = rows.start;
                let row = |y: usize| drawn.row(y, left, width).map(move |x| (y - top) * width + x - left);
                PixelSet::from_indices(tile.len(), rows.flat_map(row))
            }
        }
    }

    /// The largest value of all pixels that count, drawn or not.
    #[must_use]
    pub fn peak(&self) -> f64 {
        match self {
            Self::All(photograph) => peak(&photograph.image.pixels, &photograph.counts),
            Self::Drawn(drawn) => drawn.peak,
        }
    }

    /// Bytes in memory, about.
    #[must_use]
    pub fn bytes(&self) -> usize {
        match self {
            Self::All(photograph) => 2 * size_of_val(&*photograph.image.pixels) + photograph.counts.len(),
            Self::Drawn(drawn) => drawn.values.len() * (2 * size_of::<[f32; 3]>() + 3) + size_of_val(&*drawn.starts),
        }
    }
}

/// The pixels of a photograph that were drawn and count.
#[derive(Debug, Clone)]
pub struct Drawn {
    size: (u32, u32),
    /// Where each row begins in what follows; one more than there are rows.
    starts: Vec<u32>,
    /// Ascending within a row; no image has more columns than sixteen bits.
    columns: Vec<u16>,
    values: Vec<[f32; 3]>,
    surroundings: Vec<[f32; 3]>,
    /// Of the probability with which each was drawn.
    codes: Vec<u8>,
    peak: f64,
}

impl Drawn {
    /// Draws from a photograph, whose size the rates cover.
    #[must_use]
    pub fn new(photograph: &Values, draw: Draw<'_>) -> Self {
        let Values { image, counts, .. } = photograph;
        let (width, height) = (image.width, image.height);
        let around = Surroundings::new(image, counts);
        let mut drawn = Self {
            size: (width, height),
            starts: vec![0],
            columns: Vec::new(),
            values: Vec::new(),
            surroundings: Vec::new(),
            codes: Vec::new(),
            peak: peak(&image.pixels, counts),
        };
        let mut place = 0;
        for y in 0..height {
            for x in 0..width {
                if counts[place]
                    && let Some(code) = draw.code(x, y)
                {
                    drawn.columns.push(x as u16);
                    drawn.values.push(image.pixels[place]);
                    drawn.surroundings.push(around.at(x as usize, y as usize));
                    drawn.codes.push(code);
                }
                place += 1;
            }
            drawn.starts.push(drawn.columns.len() as u32);
        }
        drawn.columns.shrink_to_fit();
        drawn.values.shrink_to_fit();
        drawn.surroundings.shrink_to_fit();
        drawn.codes.shrink_to_fit();
        drawn
    }

    /// The drawn columns of row `y`, of the `width` from `left` on.
    fn row(&self, y: usize, left: usize, width: usize) -> impl Iterator<Item = usize> {
        let columns = &self.columns[self.starts[y] as usize..self.starts[y + 1] as usize];
        let from = columns.partition_point(|x| usize::from(*x) < left);
        columns[from..].iter().map(|x| usize::from(*x)).take_while(move |x| *x < left + width)
    }

    fn at(&self, x: usize, y: usize) -> Option<Value> {
        let start = self.starts[y] as usize;
        let columns = &self.columns[start..self.starts[y + 1] as usize];
        let found = start + columns.binary_search_by_key(&x, |x| usize::from(*x)).ok()?;
        let (value, surroundings) = (self.values[found], self.surroundings[found]);
        Some(Value { value, surroundings, weight: Rates::weight(self.codes[found]) })
    }
}

/// The largest value among the pixels that count.
fn peak(pixels: &[[f32; 3]], counts: &[bool]) -> f64 {
    let counted = pixels.iter().zip(counts).filter(|(_, counts)| **counts);
    counted.flat_map(|(pixel, _)| pixel).fold(0.0, |peak, value| f64::from(*value).max(peak))
}

#[cfg(test)]
mod tests {
    use super::*;
    use gonio_scene::image::Image;

    fn photograph() -> Values {
        let (width, height) = (70, 40);
        let pixels = (0..width * height).map(|i| [i as f32, 0.0, -1.0]).collect();
        let counts = (0..width * height).map(|i| i % 3 != 0).collect();
        Values { image: Image { width, height, pixels }, counts, clipped: 0 }
    }

    #[test]
    fn drawing_with_certainty_keeps_everything() {
        let photograph = photograph();
        let rates = Rates { cell: 64, columns: 2, codes: vec![0; 2] };
        let drawn = Measured::Drawn(Drawn::new(&photograph, rates.draw(1, 0)));
        let all = Measured::All(Photograph::new(photograph.image, photograph.counts, 0));
        assert_eq!((drawn.size(), drawn.peak()), (all.size(), all.peak()));
        for (x, y) in (0..40).flat_map(|y| (0..70).map(move |x| (x, y))) {
            assert_eq!(drawn.at(x, y), all.at(x, y));
        }
        for tile in Tile::cover_by(32, 70, 40) {
            assert_eq!(drawn.pixels(tile), all.pixels(tile));
        }
    }

    #[test]
    fn what_was_not_drawn_or_does_not_count_is_not_there() {
        let photograph = photograph();
        let rates = Rates { cell: 35, columns: 2, codes: vec![16, 8, 255, 0] };
        let draw = rates.draw(9, 4);
        let drawn = Drawn::new(&photograph, draw);
        assert!(drawn.values.len() > 300 && drawn.values.len() < 1000);
        for (x, y) in (0..40_u32).flat_map(|y| (0..70_u32).map(move |x| (x, y))) {
            let place = (y * 70 + x) as usize;
            let expected = draw.code(x, y).filter(|_| photograph.counts[place]);
            let expected = expected.map(|code| (photograph.image.pixels[place], Rates::weight(code)));
            assert_eq!(drawn.at(x as usize, y as usize).map(|v| (v.value, v.weight)), expected);
        }
    }
}
