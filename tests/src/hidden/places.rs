//! Effects that are other worlds: something stands elsewhere, or shines besides.

use super::mesh;
use super::random::Random;
use super::vectors::{V, dot, unit};
use super::world::{PART, World};
use gonio_scene::capture::{Frame, Light, LightKind};
use gonio_scene::image::Image;
use std::sync::Arc;

/// Changes the world; `false` where the effect is none of these.
#[must_use]
pub fn apply(effect: &str, strength: f64, world: &mut World, random: &mut Random) -> bool {
    let s = strength;
    let part = world.assets.meshes[&format!("{PART}.ply")].clone();
    match effect {
        "pose-error" => {
            let (sin, cos) = libm::sincos(0.05 * s);
            let turn = |[x, y, z]: V| [cos * x - sin * y, sin * x + cos * y, z];
            world.put(PART, mesh::moved(&part, turn, [0.0012 * s, -0.0008 * s, 0.0]));
        }
        "bumps" => {
            let field = Field::new(random, 0.06 * s);
            world.put(
                PART,
                mesh::tilted(&part, |p, n| {
                    let slope = field.slope(p);
                    let along = dot(slope, n);
                    [0, 1, 2].map(|i| along * n[i] - slope[i])
                }),
            );
        }
        "light-position" => {
            let lamp = world.lamp();
            *lamp = [lamp[0] - 0.012 * s, lamp[1] + 0.015 * s, lamp[2] + 0.01 * s];
        }
        "ambient-light" => {
            let pixels = vec![[0.030, 0.034, 0.042].map(|x: f64| (x * s) as f32); 32];
            world.assets.maps.insert("sky.exr".to_owned(), Arc::new(Image { width: 8, height: 4, pixels }));
            add_light(world, "sky", LightKind::Map { map: "sky.exr".to_owned(), scale: 1.0, azimuth: 0.0 });
        }
        "second-light" => {
            let intensity = [0.16, 0.15, 0.12].map(|x| x * s);
            let kind = LightKind::Sphere { position: [0.42, -0.28, 0.5], radius: 0.01, intensity };
            add_light(world, "window", kind);
        }
        "missing-object" => {
            let near = 0.072 + 0.03 * (1.0 - s);
            world.put_box("wall", [near, -0.09, 0.0], [near + 0.01, 0.09, 0.07], [0.75, 0.3, 0.2]);
        }
        _ => return false,
    }
    true
}

fn add_light(world: &mut World, name: &str, kind: LightKind) {
    world.capture.lights.push(Light { name: name.to_owned(), frame: Frame::World, kind, ..Light::default() });
}

/// A smooth random function over the part: three waves, of root mean square 1 before the factor.
pub struct Field {
    waves: Vec<(V, f64)>,
    factor: f64,
}

impl Field {
    /// Waves between 60 and 100 mm long: about one over the part.
    pub fn new(random: &mut Random, factor: f64) -> Self {
        let mut wave = || {
            let direction = unit([random.normal(), random.normal(), random.normal()]);
            let number = std::f64::consts::TAU / random.between(0.06, 0.1);
            (direction.map(|x| x * number), random.between(0.0, std::f64::consts::TAU))
        };
        Self { waves: (0..3).map(|_| wave()).collect(), factor: factor * (2.0f64 / 3.0).sqrt() }
    }

    /// Its value at a place, metres.
    #[must_use]
    pub fn value(&self, p: V) -> f64 {
        self.factor * self.waves.iter().map(|(k, phase)| libm::cos(dot(*k, p) + phase)).sum::<f64>()
    }

    /// The gradient of a height whose slopes have the root mean square of the factor.
    fn slope(&self, p: V) -> V {
        let mut slope = [0.0; 3];
        for (k, phase) in &self.waves {
            let (direction, rate) = (unit(*k), -libm::sin(dot(*k, p) + phase));
            slope = [0, 1, 2].map(|i| slope[i] + self.factor * rate * direction[i]);
        }
        slope
    }
}
