//! Effects of lens and lamp that are means or resamplings of films.

use super::film::{Films, Hits, enlarged};
use super::vectors::{V, cross, dot, sub, unit};
use super::world::World;
use std::f64::consts::{PI, TAU};

/// Films with an effect; `None` where it is none of these.
#[must_use]
pub fn films(effect: &str, strength: f64, world: &World, samples: u32, seed: u64) -> Option<Films> {
    Some(match effect {
        "light-size" => {
            let radius = 0.022 * strength.sqrt();
            let places = disk(24).map(|[a, b]| {
                let mut other = world.clone();
                let lamp = other.lamp();
                // Across the way from lamp to part, which in the camera's frame lies straight ahead.
                let ahead = unit(sub([0.0, 0.0, 0.33], *lamp));
                let across = unit(cross(ahead, [0.0, 1.0, 0.0]));
                let up = cross(ahead, across);
                *lamp = [0, 1, 2].map(|i| lamp[i] + radius * (a * across[i] + b * up[i]));
                other
            });
            Films::mean_of(places, 2 * samples, seed)
        }
        "defocus" => {
            let (radius, focus) = (0.014 * strength.sqrt(), 0.40);
            let lens = disk(24).map(|[a, b]| {
                let mut other = world.clone();
                let (x, y) = (radius * a, radius * b);
                for photo in &mut other.capture.photos {
                    let m = &mut photo.camera_to_world;
                    for row in m.iter_mut().take(3) {
                        row[3] += x * row[0] + y * row[1];
                    }
                }
                // What is in focus stays where it is in the picture, and the lamp where it is in the room.
                let camera = &mut other.capture.camera;
                (camera.cx, camera.cy) = (camera.cx + camera.fx * x / focus, camera.cy + camera.fy * y / focus);
                let lamp = other.lamp();
                *lamp = [lamp[0] - x, lamp[1] - y, lamp[2]];
                other
            });
            Films::mean_of(lens, 2 * samples, seed)
        }
        "light-lobe" => {
            let exponent = 12.0 * strength;
            let lamp = *world.clone().lamp();
            let hits = Hits::of(world);
            let toward = |photo: usize, place: V| {
                let m = &world.capture.photos[photo].camera_to_world;
                let from_eye = sub(place, [m[0][3], m[1][3], m[2][3]]);
                let seen = [0, 1, 2].map(|i| (0..3).map(|k| m[k][i] * from_eye[k]).sum::<f64>());
                unit(sub(seen, lamp))[2].max(0.0)
            };
            Films::of(world, samples, seed).at(|photo, i, v| {
                let lobe = hits.on_all(photo, i, 1.0, |h| libm::pow(toward(h.photo, h.place), exponent));
                v.map(|v| v * lobe)
            })
        }
        "veiling-glare" => glare(world, 0.1 * strength, 5.0, samples, seed),
        "lens-distortion" => distorted(world, -0.3 * strength, samples, seed),
        _ => return None,
    })
}

/// Points spread evenly over the unit disk (a sunflower's), with their mean in its middle.
fn disk(count: usize) -> impl ExactSizeIterator<Item = [f64; 2]> {
    let spiral = move |i: usize| {
        let (radius, angle) = (((i / 2) as f64 + 0.5) / (count / 2) as f64, PI * (3.0 - 5f64.sqrt()) * (i / 2) as f64);
        let turned = angle + if i.is_multiple_of(2) { 0.0 } else { TAU / 2.0 };
        [radius.sqrt() * libm::cos(turned), radius.sqrt() * libm::sin(turned)]
    };
    (0..count).map(spiral)
}

/// A share of the light is spread by a Gaussian, out of the picture and into it.
fn glare(world: &World, share: f64, width: f64, samples: u32, seed: u64) -> Films {
    const MARGIN: usize = 16;
    let large = World { capture: enlarged(&world.capture, 1, MARGIN as u32), assets: world.assets.clone() };
    let (w, h) = (large.capture.camera.width as usize, large.capture.camera.height as usize);
    let kernel: Vec<f64> =
        (0..=2 * MARGIN).map(|i| libm::exp(-0.5 * ((i as f64 - MARGIN as f64) / width).powi(2))).collect();
    let total: f64 = kernel.iter().sum();
    let small = |film: &Vec<V>| {
        let mut rows = vec![[0.0; 3]; film.len()];
        for y in 0..h {
            for x in MARGIN..w - MARGIN {
                for (k, weight) in kernel.iter().enumerate() {
                    let from = film[y * w + x + k - MARGIN];
                    rows[y * w + x] = [0, 1, 2].map(|c| rows[y * w + x][c] + weight / total * from[c]);
                }
            }
        }
        let mut out = Vec::new();
        for y in MARGIN..h - MARGIN {
            for x in MARGIN..w - MARGIN {
                let sum = |c: usize| -> f64 {
                    kernel
                        .iter()
                        .enumerate()
                        .map(|(k, weight)| weight / total * rows[(y + k - MARGIN) * w + x][c])
                        .sum()
                };
                out.push([0, 1, 2].map(|c| (1.0 - share) * film[y * w + x][c] + share * sum(c)));
            }
        }
        out
    };
    Films(Films::of(&large, samples, seed).0.iter().map(small).collect())
}

/// A lens that moves what is at a distance r from the axis (in focal lengths) to r (1 + k r^2).
fn distorted(world: &World, k: f64, samples: u32, seed: u64) -> Films {
    const GRID: u32 = 4;
    const MARGIN: u32 = 3;
    let large = World { capture: enlarged(&world.capture, GRID, MARGIN), assets: world.assets.clone() };
    let (camera, fine) = (&world.capture.camera, &large.capture.camera);
    let (w, h) = (fine.width as usize, fine.height as usize);
    let small = |film: &Vec<V>| {
        let read = |x: f64, y: f64| {
            let (x, y) = ((x - 0.5).clamp(0.0, (w - 2) as f64), (y - 0.5).clamp(0.0, (h - 2) as f64));
            let (i, j) = (x as usize, y as usize);
            let (s, t) = (x - i as f64, y - j as f64);
            let at = |i: usize, j: usize| film[j * w + i];
            let line = |j: usize, c: usize| (1.0 - s) * at(i, j)[c] + s * at(i + 1, j)[c];
            [0, 1, 2].map(|c| (1.0 - t) * line(j, c) + t * line(j + 1, c))
        };
        let mut out = Vec::new();
        for i in 0..camera.width * camera.height {
            let mut sum = [0.0; 3];
            for sub in 0..GRID * GRID {
                let part = |n: u32| (f64::from(n) + 0.5) / f64::from(GRID);
                let (px, py) = (i % camera.width, i / camera.width);
                let seen_x = (f64::from(px) + part(sub % GRID) - camera.cx) / camera.fx;
                let seen_y = (f64::from(py) + part(sub / GRID) - camera.cy) / camera.fy;
                let (mut x, mut y) = (seen_x, seen_y);
                for _ in 0..20 {
                    let stretch = 1.0 + k * dot([x, y, 0.0], [x, y, 0.0]);
                    (x, y) = (seen_x / stretch, seen_y / stretch);
                }
                let v = read(x * fine.fx + fine.cx, y * fine.fy + fine.cy);
                sum = [0, 1, 2].map(|c| sum[c] + v[c] / f64::from(GRID * GRID));
            }
            out.push(sum);
        }
        out
    };
    Films(Films::of(&large, (samples / 8).max(16), seed).0.iter().map(small).collect())
}
