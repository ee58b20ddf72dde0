//! The same photos with fewer pixels, each of which stands for a square of them.

use gonio_scene::image::Image;
use gonio_scene::{Capture, Values};

/// A capture whose cameras have fewer pixels.
#[derive(Debug, Clone)]
pub struct Preview {
    /// The capture; its photos' files are those of the large one and do not fit it.
    pub capture: Capture,
    /// By photo: one pixel stands for so many by so many; at the right and bottom edge, for what is left.
    pub factors: Vec<u32>,
}

/// `capture` with photos of at most `side` pixels a side, which see what the large ones see.
#[must_use]
pub fn preview(capture: &Capture, side: u32) -> Preview {
    let mut small = capture.clone();
    let mut factors = Vec::with_capacity(capture.photos.len());
    for (photo, of) in small.photos.iter_mut().zip(&capture.photos) {
        let camera = capture.camera_of(of);
        let factor = camera.width.max(camera.height).div_ceil(side.max(1)).max(1);
        let by = f64::from(factor);
        photo.camera.width = Some(camera.width.div_ceil(factor));
        photo.camera.height = Some(camera.height.div_ceil(factor));
        // Pixels are counted from the image's corner, so that every length in pixels is divided alike.
        (photo.camera.fx, photo.camera.fy) = (Some(camera.fx / by), Some(camera.fy / by));
        (photo.camera.cx, photo.camera.cy) = (Some(camera.cx / by), Some(camera.cy / by));
        if camera.glare_fraction > 0.0 {
            photo.camera.glare_width = Some(camera.glare_width / by);
        }
        factors.push(factor);
    }
    Preview { capture: small, factors }
}

/// The mean over squares of `factor` by `factor` pixels: over those that count where at least half do, else over all.
#[must_use]
pub fn shrink(values: &Values, factor: u32) -> Values {
    let (width, height) = (values.image.width, values.image.height);
    let (columns, rows) = (width.div_ceil(factor), height.div_ceil(factor));
    // Of pixels that do not count, and of those that do: sums and number.
    let mut squares = vec![[([0.0_f64; 3], 0_u32); 2]; columns as usize * rows as usize];
    let mut place = 0;
    for y in 0..height {
        let row = (y / factor) as usize * columns as usize;
        for x in 0..width {
            let (sums, count) = &mut squares[row + (x / factor) as usize][usize::from(values.counts[place])];
            sums.iter_mut().zip(values.image.pixels[place]).for_each(|(sum, value)| *sum += f64::from(value));
            *count += 1;
            place += 1;
        }
    }
    let counts: Vec<bool> = squares.iter().map(|[others, counted]| counted.1 >= others.1.max(1)).collect();
    let mean = |([others, counted], counts): (&[([f64; 3], u32); 2], &bool)| {
        let number = f64::from(if *counts { counted.1 } else { counted.1 + others.1 }.max(1));
        #[allow(clippy::cast_possible_truncation)]
        [0, 1, 2].map(|c| (if *counts { counted.0[c] } else { counted.0[c] + others.0[c] } / number) as f32)
    };
    let pixels = squares.iter().zip(&counts).map(mean).collect();
    Values { image: Image { width: columns, height: rows, pixels }, counts, clipped: values.clipped }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gonio_scene::capture::{Camera, Photo};

    #[test]
    fn a_preview_sees_the_same_directions() {
        let camera =
            Camera { width: 4000, height: 3000, fx: 5000.0, fy: 5100.0, cx: 2010.0, cy: 1490.0, ..Camera::default() };
        let capture = Capture { camera: camera.clone(), photos: vec![Photo::default()], ..Capture::default() };
        let Preview { capture: small, factors } = preview(&capture, 320);
        let seen = small.camera_of(&small.photos[0]);
        assert_eq!((factors[0], seen.width, seen.height), (13, 308, 231));
        // The same place, in pixels of either.
        let direction = |c: &Camera, x: f64, y: f64| ((x - c.cx) / c.fx, (y - c.cy) / c.fy);
        let (a, b) = (direction(&camera, 1300.0, 26.0), direction(&seen, 100.0, 2.0));
        assert!((a.0 - b.0).abs() < 1e-12 && (a.1 - b.1).abs() < 1e-12);
        assert_eq!(preview(&capture, 5000).factors, [1]);
    }

    #[test]
    fn squares_are_means_of_what_counts() {
        let pixels = (0..15).map(|i| [i as f32, 0.0, 1.0]).collect();
        let mut counts = vec![true; 15];
        (counts[0], counts[1], counts[14]) = (false, false, false);
        let small = shrink(&Values { image: Image { width: 5, height: 3, pixels }, counts, clipped: 7 }, 2);
        assert_eq!((small.image.width, small.image.height, small.clipped), (3, 2, 7));
        // Of 0 1 5 6, the latter two count; the last square has one pixel, which does not.
        assert_eq!(small.image.pixels[0], [5.5, 0.0, 1.0]);
        assert_eq!(small.image.pixels[5], [14.0, 0.0, 1.0]);
        assert_eq!(small.counts, [true, true, true, true, true, false]);
    }
}
