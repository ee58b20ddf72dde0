//! Templates: where a part's edges lie in a picture of it, and how they are turned.

use crate::gradient::{Gradients, bin};
use crate::part::Part;
use glam::{DMat3, DVec3};
use gonio_pose::Intrinsics;
use gonio_pose::render::NOTHING;
use image::{ImageBuffer, Rgb, Rgb32FImage};

/// Pixels that the part's diameter takes in a template.
pub(crate) const SIZE: f64 = 48.0;

/// Features of a template at most: their responses, 4 at most, add up in a byte.
const FEATURES: usize = 63;

/// Distance from which templates are seen, in diameters.
const DISTANCE: f64 = 4.0;

/// Least gradient of a feature: change of a normal a pixel.
const LEAST: f64 = 0.12;

/// Columns and rows of the picture that a template is made from.
const PICTURE: u32 = 72;

/// An edge of a template.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Feature {
    /// Pixels from the part's centre, along columns and rows.
    pub x: f64,
    pub y: f64,
    /// Direction across the edge.
    pub normal: [f64; 2],
}

/// The edges of a part, seen from one direction.
#[derive(Debug)]
pub(crate) struct Template {
    /// From the model to the camera.
    pub rotation: DMat3,
    pub features: Vec<Feature>,
}

impl Template {
    /// Of `part` as a camera sees it that looks at its centre.
    pub fn new(part: &Part, rotation: DMat3) -> Self {
        let middle = f64::from(PICTURE) / 2.0 - 0.5;
        let focal = SIZE * DISTANCE;
        let camera = Intrinsics { fx: focal, fy: focal, cx: middle, cy: middle };
        let gradients = Gradients::of(&normals(part, rotation, &camera));
        let length = |[x, y]: [f32; 2]| f64::from(x).hypot(f64::from(y));
        let mut edges: Vec<(f64, Feature)> = Vec::new();
        for row in 1..PICTURE as usize - 1 {
            for column in 1..PICTURE as usize - 1 {
                let at = |column: usize, row: usize| {
                    gradients.vectors.get(row * gradients.width + column).copied().unwrap_or_default()
                };
                let vector = at(column, row);
                let size = length(vector);
                if size < LEAST {
                    continue;
                }
                // Only where it is largest across the edge: round surfaces have a gradient everywhere.
                let [x, y] = vector.map(|v| f64::from(v) / size);
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)]
                let beside = |sign: f64| {
                    at((column as f64 + sign * x).round() as usize, (row as f64 + sign * y).round() as usize)
                };
                if length(beside(1.0)) > size || length(beside(-1.0)) > size {
                    continue;
                }
                #[allow(clippy::cast_precision_loss)]
                let feature = Feature { x: column as f64 - middle, y: row as f64 - middle, normal: [x, y] };
                edges.push((size, feature));
            }
        }
        Self { rotation, features: scattered(edges) }
    }

    /// The template turned by `angle` radians in the image: offsets in whole pixels, and bins.
    pub fn turned(&self, angle: f64) -> Vec<(i32, i32, usize)> {
        let (sine, cosine) = libm::sincos(angle);
        let turn = |x: f64, y: f64| (cosine * x - sine * y, sine * x + cosine * y);
        let place = |feature: &Feature| {
            let (x, y) = turn(feature.x, feature.y);
            let (nx, ny) = turn(feature.normal[0], feature.normal[1]);
            #[allow(clippy::cast_possible_truncation)] // within a template
            (x.round() as i32, y.round() as i32, bin(nx, ny))
        };
        self.features.iter().map(place).collect()
    }
}

/// The strongest edges, as far apart as their number allows.
fn scattered(mut edges: Vec<(f64, Feature)>) -> Vec<Feature> {
    edges.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut apart = 6.0;
    loop {
        let mut kept: Vec<Feature> = Vec::new();
        for (_, edge) in &edges {
            if kept.len() < FEATURES && kept.iter().all(|other| (edge.x - other.x).hypot(edge.y - other.y) >= apart) {
                kept.push(*edge);
            }
        }
        if kept.len() >= FEATURES || apart < 1.5 {
            return kept;
        }
        apart *= 0.85;
    }
}

/// Normals as colours: an edge of the shape is an edge of the picture, whatever light will fall on it. Nothing is seen as a
/// surface that faces away.
fn normals(part: &Part, rotation: DMat3, camera: &Intrinsics) -> Rgb32FImage {
    let pose = part.pose(rotation, DVec3::new(0.0, 0.0, DISTANCE * part.diameter));
    let seen = part.coarse.see(&pose, camera, PICTURE, PICTURE);
    ImageBuffer::from_fn(PICTURE, PICTURE, |column, row| {
        let triangle = seen.triangles.get((row * PICTURE + column) as usize).copied().unwrap_or(NOTHING);
        let ray = camera.ray(f64::from(column), f64::from(row));
        let normal = if triangle == NOTHING { DVec3::Z } else { part.coarse.normal(triangle, &pose, ray) };
        Rgb(normal.as_vec3().to_array())
    })
}
