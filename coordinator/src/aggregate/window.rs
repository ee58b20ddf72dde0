//! What lies around a pixel of a tile, without the pixel itself.

use gonio_scene::film::Tile;

/// Half the side of the window over which a number is averaged: 5x5 pixels.
const RADIUS: usize = 2;

/// A window with fewer other pixels than this says too little: its pixel takes the whole tile's instead.
const FEWEST: f64 = 8.0;

/// The mean of a number over the other pixels around every pixel of a tile, in one colour channel.
#[derive(Debug)]
pub struct Window {
    width: usize,
    /// Per tile pixel, with a border of `RADIUS` pixels of zeros, so that no window needs to look where the tile ends.
    own: Grid,
    /// Sums over each pixel's row of the window.
    rows: Grid,
    total: Sum,
}

/// A sum over pixels that count, and their number.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Sum {
    value: f64,
    pixels: f64,
}

impl std::ops::Add for Sum {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { value: self.value + other.value, pixels: self.pixels + other.pixels }
    }
}

#[derive(Debug)]
struct Grid {
    stride: usize,
    sums: Vec<Sum>,
}

impl Window {
    /// A map of `own` numbers (`None` where a pixel does not count), row-major over `tile`.
    #[must_use]
    pub fn new(tile: Tile, own: &[Option<f64>]) -> Self {
        let (width, height) = (tile.width as usize, tile.height as usize);
        let stride = width + 2 * RADIUS;
        let mut grid = Grid { stride, sums: vec![Sum::default(); stride * (height + 2 * RADIUS)] };
        let mut total = Sum::default();
        for (y, row) in own.chunks_exact(width).enumerate() {
            for (x, value) in row.iter().enumerate() {
                if let Some(value) = *value {
                    let sum = Sum { value, pixels: 1.0 };
                    grid.sums[(y + RADIUS) * stride + x + RADIUS] = sum;
                    total = total + sum;
                }
            }
        }
        let mut rows = Grid { stride, sums: vec![Sum::default(); grid.sums.len()] };
        for (i, window) in grid.sums.windows(2 * RADIUS + 1).enumerate() {
            rows.sums[i + RADIUS] = window.iter().fold(Sum::default(), |sum, own| sum + *own);
        }
        Self { width, own: grid, rows, total }
    }

    /// The mean around tile pixel `index`, which counts; its own number where it is the only one.
    #[must_use]
    pub fn at(&self, index: usize) -> f64 {
        let stride = self.own.stride;
        let centre = (index / self.width + RADIUS) * stride + index % self.width + RADIUS;
        let own = self.own.sums[centre].value;
        // Left out by not being added: to add and subtract it would lose the digits of quiet neighbours.
        let mut nearby = Sum::default();
        for distance in 1..=RADIUS {
            nearby = nearby + self.rows.sums[centre - distance * stride] + self.rows.sums[centre + distance * stride];
            nearby = nearby + self.own.sums[centre - distance] + self.own.sums[centre + distance];
        }
        if nearby.pixels < FEWEST && self.total.pixels > nearby.pixels + 1.0 {
            // Here the subtraction may leave a rounding error below zero.
            nearby = Sum { value: (self.total.value - own).max(0.0), pixels: self.total.pixels - 1.0 };
        }
        if nearby.pixels == 0.0 {
            return own;
        }
        nearby.value / nearby.pixels
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TILE: Tile = Tile { x: 0, y: 0, width: 6, height: 7 };

    #[test]
    fn a_window_leaves_its_own_pixel_out() {
        let mut own = vec![Some(1.0); 42];
        own[3 * 6 + 3] = Some(1000.0);
        let map = Window::new(TILE, &own);
        assert_eq!(map.at(3 * 6 + 3), 1.0);
        assert_eq!(map.at(3 * 6 + 2), 1023.0 / 24.0);
        assert_eq!(map.at(0), 1.0);
    }

    #[test]
    fn only_pixels_that_count_speak() {
        let mut own = vec![None; 42];
        own[0] = Some(4.0);
        assert_eq!(Window::new(TILE, &own).at(0), 4.0);
        own[41] = Some(2.0);
        assert_eq!(Window::new(TILE, &own).at(0), 2.0);
        own[40] = Some(4.0);
        assert_eq!(Window::new(TILE, &own).at(0), 3.0);
    }
}
