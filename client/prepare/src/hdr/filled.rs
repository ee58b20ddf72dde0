//! The lower hemisphere that a tripod covers, filled from its horizon.

use super::orient::check;
use gonio_scene::SceneError;
use gonio_scene::image::Image;

/// Replaces an equirectangular map's rows further than `degrees` below the horizon by the ring just above them, ever more
/// smoothed towards the pole, where it is the ring's mean: as far as light is concerned, the ground goes on.
///
/// # Errors
/// The map is not twice as wide as high, or `degrees` is not in -80..=89.
pub fn fill_below(file: &str, map: &mut Image, degrees: f64) -> Result<(), SceneError> {
    check(file, map, "fill-below")?;
    if !(-80.0..=89.0).contains(&degrees) {
        let problem = format!("is to be filled from {degrees} degrees below the horizon");
        return Err(SceneError::new(file, problem, "write a number from -80 to 89").at("fill-below"));
    }
    let (width, height) = (map.width as usize, map.height as usize);
    let first = (((90.0 + degrees) / 180.0 * height as f64).ceil() as usize).clamp(1, height);
    // Two degrees of rows, so that one row's noise does not become a fan of streaks.
    let rows = (height / 90).clamp(1, first);
    let ring: Vec<[f64; 3]> = (0..width)
        .map(|x| {
            let sum = (first - rows..first).fold([0.0; 3], |sum: [f64; 3], y| {
                std::array::from_fn(|c| sum[c] + f64::from(map.pixels[y * width + x][c]))
            });
            sum.map(|sum| sum / rows as f64)
        })
        .collect();
    let mut sums = vec![[0.0_f64; 3]];
    for x in 0..3 * width {
        let last = sums[x];
        sums.push(std::array::from_fn(|c| last[c] + ring[x % width][c]));
    }
    for y in first..height {
        let part = (y - first + 1) as f64 / (height - first) as f64;
        let half = (part * width as f64 / 2.0) as usize;
        for x in 0..width {
            let (from, to) = (width + x - half, width + x + half + 1);
            let pixel = std::array::from_fn(|c| ((sums[to][c] - sums[from][c]) / (to - from) as f64) as f32);
            map.pixels[y * width + x] = pixel;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ground_goes_on_and_the_pole_is_the_mean() -> Result<(), SceneError> {
        let pixels = (0..64 * 32).map(|k| if k / 64 < 20 { [(k % 64) as f32; 3] } else { [-1.0; 3] }).collect();
        let mut map = Image { width: 64, height: 32, pixels };
        fill_below("map", &mut map, 22.5)?;
        assert!(map.pixels.iter().all(|pixel| pixel[0] >= 0.0));
        assert!((map.pixels[31 * 64 + 10][0] - 31.5).abs() < 0.6);
        assert!((map.pixels[20 * 64 + 30][0] - 30.0).abs() < 0.5);
        assert!(fill_below("map", &mut map, 100.0).is_err());
        Ok(())
    }
}
