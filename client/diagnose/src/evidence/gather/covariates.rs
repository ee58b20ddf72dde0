//! What a residual may depend on: the covariates of every pixel, from the first hits of its centre.

use gonio_scene::capture::{Frame, LightKind, Photo};
use gonio_scene::sensor_stage::SensorStage;
use gonio_scene::{Capture, Film, Photograph};

/// The covariates, in the order of [`Pixel::covariates`]. Angles in radians, lengths in metres, the image in pixels.
pub const COVARIATES: [&str; 17] = [
    "half angle",
    "difference angle",
    "incidence",
    "view angle",
    "image x",
    "image y",
    "image radius",
    "predicted signal",
    "photo",
    "object",
    "object position x",
    "object position y",
    "object position z",
    "distance to silhouette",
    "light distance",
    "light angle",
    "place in the photo",
];

/// Distance to the silhouette beyond which a pixel is inside, in pixels.
const FAR: usize = 8;
/// Side of the blocks that are even or odd in turn, in pixels.
const BLOCK: usize = 6;

/// A pixel that counts.
#[derive(Debug, Clone)]
pub struct Pixel {
    /// Photo less render, per channel, in standard deviations of the sensor.
    pub residual: [f64; 3],
    /// See [`COVARIATES`]; NaN where the pixel has none (no hit, no lamp).
    pub covariates: [f64; COVARIATES.len()],
    /// Which half of the image's blocks it belongs to.
    pub odd: bool,
}

type V = [f64; 3];

fn sub(a: V, b: V) -> V {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(a: V) -> V {
    let length = dot(a, a).sqrt().max(1e-30);
    a.map(|x| x / length)
}

fn angle(a: V, b: V) -> f64 {
    libm::acos(dot(a, b).clamp(-1.0, 1.0))
}

/// The pixels of a photo that count, from its film (exposed light), its first hits and its photograph.
pub fn pixels(capture: &Capture, film: &Film, hits: &Film, photograph: &Photograph) -> Vec<Pixel> {
    let (width, height) = (film.width as usize, film.height as usize);
    let Some(photo) = capture.photos.get(film.photo) else { return Vec::new() };
    let camera = capture.camera_of(photo);
    let pose = photo.pose();
    let eye = [0, 1, 2].map(|i| pose[i][3]);
    let forward = [0, 1, 2].map(|i| pose[i][2]);
    let lamp = lamp(capture, photo);
    let stage = SensorStage::of(capture, film.photo);
    let object = |i: usize| hits.channels[4][i];
    let edge = silhouette(width, height, &object);
    let mut out = Vec::new();
    for index in (0..width * height).filter(|i| photograph.counts.get(*i).copied().unwrap_or(false)) {
        let (x, y) = (index % width, index / width);
        let exposed = [0, 1, 2].map(|c| f64::from(film.channels[c][index]));
        let value = stage.value(exposed, x, y).value;
        let residual = [0, 1, 2].map(|c| {
            let measured = f64::from(photograph.image.pixels[index][c]);
            (measured - value[c]) / capture.sensor.variance(f64::from(photograph.surroundings[index][c])).sqrt()
        });
        let mut covariates = [f64::NAN; COVARIATES.len()];
        let (dx, dy) = (x as f64 + 0.5 - camera.cx, y as f64 + 0.5 - camera.cy);
        covariates[4] = x as f64;
        covariates[5] = y as f64;
        covariates[6] = libm::hypot(dx, dy);
        covariates[7] = (value[0] + value[1] + value[2]) / 3.0;
        covariates[8] = film.photo as f64;
        covariates[9] = f64::from(object(index));
        covariates[13] = edge[index] as f64;
        // Blocks of 20 pixels, each a value of its own.
        covariates[16] = (film.photo * 10_000 + (y / 20) * 100 + x / 20) as f64;
        if object(index) >= 0.0 {
            let position = [5, 6, 7].map(|c| f64::from(hits.channels[c][index]));
            let normal = [1, 2, 3].map(|c| f64::from(hits.channels[c][index]));
            let view = unit(sub(eye, position));
            covariates[3] = angle(normal, view);
            covariates[10..13].copy_from_slice(&position);
            if let Some((place, far)) = lamp {
                let way = if far { place } else { sub(place, position) };
                let light = unit(way);
                let half = unit([light[0] + view[0], light[1] + view[1], light[2] + view[2]]);
                covariates[0] = angle(normal, half);
                covariates[1] = angle(light, half);
                covariates[2] = angle(normal, light);
                if !far {
                    covariates[14] = dot(way, way).sqrt();
                    covariates[15] = angle(forward, light.map(|c| -c));
                }
            }
        }
        let odd = (x / BLOCK + y / BLOCK) % 2 == 1;
        out.push(Pixel { residual, covariates, odd });
    }
    out
}

/// The first lamp that was on: its place, or, where it is infinitely far, the way to it.
fn lamp(capture: &Capture, photo: &Photo) -> Option<(V, bool)> {
    let m = &photo.pose();
    let turn = |v: V| [0, 1, 2].map(|i| m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2]);
    let on = capture.lights.iter().filter(|l| photo.lights.as_ref().is_none_or(|on| on.contains(&l.name)));
    on.filter_map(|light| {
        let moved = |v: V, place: f64| match light.frame {
            Frame::World => v,
            Frame::Camera => {
                let t = turn(v);
                [0, 1, 2].map(|i| t[i] + place * m[i][3])
            }
        };
        match &light.kind {
            LightKind::Point { position, .. } | LightKind::Sphere { position, .. } => {
                Some((moved(*position, 1.0), false))
            }
            LightKind::Directional { direction, .. } => Some((moved(direction.map(|d| -d), 0.0), true)),
            _ => None,
        }
    })
    .next()
}

/// Distance to the nearest pixel of another object, in pixels along rows and columns, up to [`FAR`].
fn silhouette(width: usize, height: usize, object: &dyn Fn(usize) -> f32) -> Vec<usize> {
    let mut distance = vec![FAR; width * height];
    let neighbours = |i: usize| {
        let (x, y) = (i % width, i / width);
        let mut list = Vec::with_capacity(4);
        if x > 0 {
            list.push(i - 1);
        }
        if x + 1 < width {
            list.push(i + 1);
        }
        if y > 0 {
            list.push(i - width);
        }
        if y + 1 < height {
            list.push(i + width);
        }
        list
    };
    let mut front: Vec<usize> =
        (0..width * height).filter(|i| neighbours(*i).iter().any(|n| object(*n) != object(*i))).collect();
    for step in 0..FAR {
        let mut next = Vec::new();
        for i in front {
            if distance[i] == FAR {
                distance[i] = step;
                next.extend(neighbours(i));
            }
        }
        front = next;
    }
    distance
}
