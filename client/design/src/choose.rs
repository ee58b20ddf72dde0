//! From first hits to probabilities.

use crate::allocate::allocate;
use crate::strata::{Stratum, strata};
use gonio_scene::design::{Design, Rates};
use gonio_scene::{Capture, Film};
use std::collections::BTreeMap;

/// Cells of a photo's longer side, at most: how finely kinds of places are told apart.
pub const CELLS: u32 = 240;

/// Captures with no more pixels are compared as a whole: eight photos of 320 by 204.
pub const ALL_UP_TO: u64 = 1 << 19;

/// Pixels that are compared of a larger capture, unless another number is asked for: somewhat more than eight photos of 160 by 120
/// have, whose fit this is to cost and to equal. Calibrated with the capture none-202 of the tests: few samples on many pixels tell less
/// than the usual number on these, because samples of one pixel are stratified. From 4 to 16 to 64 of them the standard error of
/// its loss falls by 5.0 and 2.8, where independent ones would make it 2 and 2.
pub const MANY: u64 = 3 << 16;

/// Pixels of all photos of a capture.
#[must_use]
pub fn pixels(capture: &Capture) -> u64 {
    let camera = |photo| capture.camera_of(photo);
    capture.photos.iter().map(camera).map(|c| u64::from(c.width) * u64::from(c.height)).sum()
}

/// Chooses about `wanted` pixels of `capture`. `hits` are the first hits of [`crate::preview()`] of at most [`CELLS`], photo by photo;
/// photos without hits are compared as a whole.
///
/// Strata are photo, object and kind of place; small ones are drawn from more often than large ones. Masks are not looked at: of a
/// photo of which a tenth counts, about a tenth of what is drawn is compared.
#[must_use]
pub fn choose(capture: &Capture, hits: &[Film], seed: u64, wanted: u64) -> Design {
    let mut all: BTreeMap<(usize, Stratum), Vec<usize>> = BTreeMap::new();
    let mut grids = Vec::new();
    for film in hits {
        let Some(photo) = capture.photos.get(film.photo) else { continue };
        let camera = capture.camera_of(photo);
        let cell = camera.width.max(camera.height).div_ceil(CELLS).max(1);
        let grid = Grid { photo: film.photo, cell, width: camera.width, height: camera.height };
        // A film of another size is of another preview: its photo is compared as a whole.
        if (film.width, film.height) == (grid.columns(), camera.height.div_ceil(cell)) {
            all.extend(strata(film).into_iter().map(|(stratum, cells)| ((grids.len(), stratum), cells)));
            grids.push(grid);
        }
    }
    let size = |((grid, _), cells): (&(usize, Stratum), &Vec<usize>)| -> f64 {
        cells.iter().map(|cell| grids[*grid].pixels(*cell)).sum()
    };
    let sizes: Vec<f64> = all.iter().map(size).collect();
    #[allow(clippy::cast_precision_loss)]
    let rates = allocate(&sizes, wanted as f64);
    let mut photos: Vec<(usize, Rates)> = grids.iter().map(|grid| (grid.photo, grid.certain())).collect();
    for (((grid, _), cells), rate) in all.iter().zip(rates) {
        cells.iter().for_each(|cell| photos[*grid].1.codes[*cell] = Rates::code(rate));
    }
    photos.sort_by_key(|(photo, _)| *photo);
    photos.dedup_by_key(|(photo, _)| *photo);
    Design { seed, photos }
}

/// The cells of a photo.
struct Grid {
    photo: usize,
    cell: u32,
    width: u32,
    height: u32,
}

impl Grid {
    fn columns(&self) -> u32 {
        self.width.div_ceil(self.cell)
    }

    /// Pixels of a cell.
    fn pixels(&self, cell: usize) -> f64 {
        let columns = self.columns() as usize;
        let side = |place: usize, length: u32| self.cell.min(length - place as u32 * self.cell);
        f64::from(side(cell % columns, self.width)) * f64::from(side(cell / columns, self.height))
    }

    /// Every pixel is drawn.
    fn certain(&self) -> Rates {
        let cells = self.columns() as usize * self.height.div_ceil(self.cell) as usize;
        Rates { cell: self.cell, columns: self.columns(), codes: vec![0; cells] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strata::tests::film;
    use gonio_scene::capture::{Camera, Photo};

    fn capture() -> Capture {
        let camera = Camera { width: 2400, height: 1000, ..Camera::default() };
        Capture { camera, photos: vec![Photo::default(); 3], ..Capture::default() }
    }

    fn hits(photo: usize) -> Film {
        let place = |i: usize| if i % 240 < 6 && i / 240 < 10 { (0.0, 0.1, 0.2) } else { (0.0, 0.9, 0.2) };
        Film { photo, ..film(240, &(0..240 * 100).map(place).collect::<Vec<_>>()) }
    }

    #[test]
    fn as_many_pixels_are_drawn_as_are_wanted() {
        let capture = capture();
        let design = choose(&capture, &[hits(2), hits(0)], 7, 20_000);
        assert_eq!(design.photos.iter().map(|(photo, _)| *photo).collect::<Vec<_>>(), [0, 2]);
        let mut drawn = [0, 0];
        for (photo, rates) in &design.photos {
            assert!(rates.cover(2400, 1000));
            let draw = rates.draw(design.seed, *photo);
            for (x, y) in (0..1000).flat_map(|y| (0..2400).map(move |x| (x, y))) {
                drawn[usize::from(x < 60 && y < 100)] += usize::from(draw.code(x, y).is_some());
            }
        }
        // Codes round up by at most a twelfth.
        let all = drawn[0] + drawn[1];
        assert!((19_500..22_300).contains(&all), "{all}");
        // A four-hundredth of the pixels, a twentieth of what is drawn.
        assert!(drawn[1] * 30 > all && drawn[1] * 12 < all, "{drawn:?}");
    }

    #[test]
    fn the_design_is_a_function_of_its_arguments() {
        let capture = capture();
        let of = |seed| choose(&capture, &[hits(0), hits(1)], seed, 1000);
        assert_eq!(of(1), of(1));
        assert_ne!(of(1), of(2));
    }

    #[test]
    fn small_captures_and_films_of_another_size_are_compared_as_a_whole() {
        let capture = capture();
        assert_eq!(pixels(&capture), 7_200_000);
        let design = choose(&capture, &[hits(0)], 0, 10_000_000);
        assert!(design.photos[0].1.codes.iter().all(|code| *code == 0));
        assert_eq!(choose(&capture, &[film(24, &vec![(0.0, 0.0, 0.0); 240])], 0, 10), Design::default());
    }
}
