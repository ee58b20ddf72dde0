//! A part's place from its outlines: the pixels at the edge of its silhouette are moved onto the edge of the photo's mask.

use super::step::{Normal, moved};
use super::{Placed, Station};
use crate::Pose;
use nalgebra::{Vector3, Vector6};

/// Signed distances to the edge of a mask, pixels: below 0 inside.
#[derive(Debug, Clone)]
pub struct Field {
    width: usize,
    height: usize,
    distances: Vec<f32>,
}

/// A pixel at the edge of a part's silhouette in a photo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contour {
    /// Index of the photo.
    pub photo: usize,
    /// What is seen there, world coordinates, metres.
    pub point: [f64; 3],
    /// Its signed distance to the silhouette's own edge, pixels, by [`Field::at`] of the silhouette: what the mask's should be.
    pub own: f64,
}

/// Pixels farther off than this count no more, from step to step: first what is near enough to be the same edge, at last what
/// no mistake of a mask explains.
const REACH: [f64; 8] = [40.0, 30.0, 20.0, 12.0, 8.0, 5.0, 3.0, 3.0];

impl Field {
    /// Of a mask, `white` row by row from the top (Felzenszwalb and Huttenlocher 2012, "Distance transforms of sampled
    /// functions": exact Euclidean distances between pixel centres; the edge lies half a pixel before them).
    #[must_use]
    pub fn new(width: usize, height: usize, white: &[bool]) -> Self {
        let to = |wanted: bool| transformed(width, height, &|k| white[k] == wanted);
        let (outside, inside) = (to(true), to(false));
        let signed = |k: usize| if white[k] { 0.5 - inside[k].sqrt() } else { outside[k].sqrt() - 0.5 };
        Self { width, height, distances: (0..width * height).map(signed).collect() }
    }

    /// The distance at a pixel's coordinates, linear between centres, and its slopes; absent outside of the picture.
    #[must_use]
    pub fn at(&self, [x, y]: [f64; 2]) -> Option<(f64, [f64; 2])> {
        let (x, y) = (x - 0.5, y - 0.5);
        if !(x >= 0.0 && y >= 0.0 && x < self.width as f64 - 1.0 && y < self.height as f64 - 1.0) {
            return None;
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // Inside of the picture.
        let (i, j) = (x as usize, y as usize);
        let (u, v) = (x - i as f64, y - j as f64);
        let value = |i: usize, j: usize| f64::from(self.distances[j * self.width + i]);
        let (a, b, c, d) = (value(i, j), value(i + 1, j), value(i, j + 1), value(i + 1, j + 1));
        let along = |p: f64, q: f64, t: f64| p + (q - p) * t;
        Some((along(along(a, b, u), along(c, d, u), v), [along(b - a, d - c, v), along(c - a, d - b, u)]))
    }
}

/// Squared distances from each pixel to the nearest for which `there` holds.
fn transformed(width: usize, height: usize, there: &dyn Fn(usize) -> bool) -> Vec<f32> {
    // Larger than any distance in a picture.
    const FAR: f32 = 1e12;
    let mut values: Vec<f32> = (0..width * height).map(|k| if there(k) { 0.0 } else { FAR }).collect();
    let mut line = vec![0.0; width.max(height)];
    for x in 0..width {
        (0..height).for_each(|y| line[y] = values[y * width + x]);
        for (y, value) in parabolas(&line[..height]).into_iter().enumerate() {
            values[y * width + x] = value;
        }
    }
    for row in values.chunks_mut(width) {
        let whole = parabolas(row);
        row.copy_from_slice(&whole);
    }
    values
}

/// The lower envelope of parabolas over a line, one above each of its places.
fn parabolas(line: &[f32]) -> Vec<f32> {
    let mut places: Vec<usize> = Vec::with_capacity(line.len());
    let mut begins: Vec<f32> = Vec::with_capacity(line.len());
    let square = |q: usize| (q * q) as f32;
    for q in 0..line.len() {
        let mut begin = f32::NEG_INFINITY;
        while let Some(&p) = places.last() {
            begin = ((line[q] + square(q)) - (line[p] + square(p))) / (2 * (q - p)) as f32;
            if begins.last().is_some_and(|last| begin <= *last) {
                places.pop();
                begins.pop();
                begin = f32::NEG_INFINITY;
            } else {
                break;
            }
        }
        places.push(q);
        begins.push(begin);
    }
    let mut k = 0;
    (0..line.len())
        .map(|q| {
            while begins.get(k + 1).is_some_and(|begin| *begin < q as f32) {
                k += 1;
            }
            let p = places[k];
            square(q.abs_diff(p)) + line[p]
        })
        .collect()
}

/// The place at which outlines and masks agree, from `start` on, and how many pixels the masks' edges lie outside of the outlines:
/// people draw masks a little smaller or larger than the part, and only what differs between sides moves it. `fields` has a
/// photo's mask or nothing; `contours` gives the pixels at the edge of the part's silhouettes at a pose; `middle` is the part's
/// own middle.
///
/// Errors are the scatter between photos where there are three or more (each left out in turn), else those of a least-squares
/// fit in which a seventh of the pixels counts: neighbours on an edge are off together.
#[must_use]
pub fn from_outlines(
    stations: &[Station],
    fields: &[Option<Field>],
    contours: &dyn Fn(&Pose) -> Vec<Contour>,
    middle: &Vector3<f64>,
    start: Pose,
) -> Option<(Placed, f64)> {
    const COUNTS: f64 = 7.0;
    let mut pose = start;
    for reach in REACH {
        let all = residuals(stations, fields, &contours(&pose), &pose.apply(middle), reach);
        pose = moved(&pose, &pose.apply(middle), &centred(&all, None).0.step(1e-6)?);
    }
    let all = residuals(stations, fields, &contours(&pose), &pose.apply(middle), REACH[REACH.len() - 1]);
    let (sums, margin) = centred(&all, None);
    let masked: Vec<usize> = (0..fields.len()).filter(|photo| fields[*photo].is_some()).collect();
    let variances: [f64; 6] = if masked.len() >= 3 {
        // The jackknife (Tukey 1958).
        let steps: Option<Vec<Vector6<f64>>> =
            masked.iter().map(|photo| centred(&all, Some(*photo)).0.step(1e-9)).collect();
        let (steps, count) = (steps?, masked.len() as f64);
        let mean = steps.iter().sum::<Vector6<f64>>() / count;
        std::array::from_fn(|k| {
            steps.iter().map(|step| (step[k] - mean[k]) * (step[k] - mean[k])).sum::<f64>() * (count - 1.0) / count
        })
    } else {
        let inverse = sums.matrix.try_inverse()?;
        let noise = COUNTS * sums.squares / (sums.count - 7.0).max(1.0);
        std::array::from_fn(|k| noise * inverse[(k, k)])
    };
    let placed = Placed { pose, pixels: (sums.squares / sums.count).sqrt(), errors: variances.map(f64::sqrt) };
    (sums.count > 7.0).then_some((placed, -margin))
}

/// How far a pixel of an outline is from the mask's edge, pixels, and what a step of the pose does to that.
struct Residual {
    photo: usize,
    value: f64,
    slope: Vector6<f64>,
}

/// Of the contours within `reach` of most of the others; derivatives by the pose about `middle` in the world.
fn residuals(
    stations: &[Station],
    fields: &[Option<Field>],
    contours: &[Contour],
    middle: &Vector3<f64>,
    reach: f64,
) -> Vec<Residual> {
    let mut all: Vec<Residual> =
        contours.iter().filter_map(|contour| residual(stations, fields, contour, middle)).collect();
    let mut values: Vec<f64> = all.iter().map(|residual| residual.value).collect();
    let half = values.len() / 2;
    if half > 0 {
        let median = *values.select_nth_unstable_by(half, f64::total_cmp).1;
        all.retain(|residual| (residual.value - median).abs() <= reach);
    }
    all
}

fn residual(
    stations: &[Station],
    fields: &[Option<Field>],
    contour: &Contour,
    middle: &Vector3<f64>,
) -> Option<Residual> {
    const H: f64 = 1e-5;
    let (field, station) = (fields.get(contour.photo)?.as_ref()?, stations.get(contour.photo)?);
    let point = Vector3::from(contour.point);
    let (distance, slope) = field.at(station.see(&point)?)?;
    // What a shift of the point along each axis does to the distance.
    let shift = |k: usize| {
        let (mut ahead, mut behind) = (point, point);
        ahead[k] += H;
        behind[k] -= H;
        let (a, b) = (station.see(&ahead)?, station.see(&behind)?);
        Some((0..2).map(|axis| slope[axis] * (a[axis] - b[axis]) / (2.0 * H)).sum::<f64>())
    };
    let along = Vector3::new(shift(0)?, shift(1)?, shift(2)?);
    let turn = (point - middle).cross(&along);
    let slope = Vector6::new(turn.x, turn.y, turn.z, along.x, along.y, along.z);
    Some(Residual { photo: contour.photo, value: distance - contour.own, slope })
}

/// The sums of residuals about their mean, with derivatives about theirs: a constant is fitted besides. And that mean.
fn centred(all: &[Residual], without: Option<usize>) -> (Normal, f64) {
    let own = || all.iter().filter(|residual| without != Some(residual.photo));
    let count = (own().count() as f64).max(1.0);
    let mean = own().map(|residual| residual.value).sum::<f64>() / count;
    let slope = own().map(|residual| residual.slope).sum::<Vector6<f64>>() / count;
    let mut normal = Normal::new();
    own().for_each(|residual| normal.add(residual.value - mean, &(residual.slope - slope)));
    (normal, mean)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_euclidean_and_signed() {
        let (width, height) = (23, 17);
        let white: Vec<bool> = (0..width * height).map(|k| (k * 7919 % 101) < 8).collect();
        let field = Field::new(width, height, &white);
        for k in 0..width * height {
            let nearest = (0..width * height)
                .filter(|other| white[*other] != white[k])
                .map(|other| {
                    let (dx, dy) = ((k % width).abs_diff(other % width), (k / width).abs_diff(other / width));
                    ((dx * dx + dy * dy) as f64).sqrt()
                })
                .fold(f64::INFINITY, f64::min);
            let expected = if white[k] { 0.5 - nearest } else { nearest - 0.5 };
            assert!((f64::from(field.distances[k]) - expected).abs() < 1e-4, "{k}");
        }
        let (value, slopes) = field.at([3.5, 4.5]).unwrap();
        assert!((value - f64::from(field.distances[4 * width + 3])).abs() < 1e-6);
        assert!(slopes.iter().all(|slope| slope.abs() <= 1.5));
        assert_eq!(field.at([0.2, 5.0]), None);
    }
}
