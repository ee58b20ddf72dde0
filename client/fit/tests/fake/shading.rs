//! A pixel of the fake: GGX over a Lambertian base, or a Lambertian board.

use gonio_scene::Capture;
use gonio_scene::capture::{LightKind, Model};
use std::f64::consts::PI;

/// What a pixel sees, as cosines of its normal: enough for an isotropic material under one lamp.
#[derive(Debug, Clone, Copy)]
pub struct Pixel {
    /// Index of the material.
    pub material: usize,
    /// With the direction to the lamp.
    pub light: f64,
    /// With the direction to the camera.
    pub view: f64,
    /// With the half vector.
    pub half: f64,
    /// Half vector with the lamp.
    pub difference: f64,
    /// Distance of the lamp in metres.
    pub distance: f64,
}

impl Pixel {
    /// The photo value without noise.
    pub fn value(&self, capture: &Capture, photo: usize) -> [f64; 3] {
        let LightKind::Point { intensity, .. } = &capture.lights[0].kind else { panic!("the fake knows point lights") };
        let irradiance = self.light / (self.distance * self.distance) * capture.photos[photo].factor();
        let reflected = match &capture.materials[self.material].model {
            Model::Lambert { base_color } => base_color.map(|c| c / PI),
            Model::Plastic { base_color, roughness, ior, .. } => self.plastic(*base_color, *roughness, *ior),
            Model::Conductor { .. } => panic!("the fake has no metal"),
        };
        std::array::from_fn(|c| intensity[c] * irradiance * reflected[c])
    }

    fn plastic(&self, base_color: [f64; 3], roughness: f64, ior: f64) -> [f64; 3] {
        let alpha2 = roughness * roughness * roughness * roughness;
        let d = self.half * self.half * (alpha2 - 1.0) + 1.0;
        let smith = |cosine: f64| {
            let tan2 = (1.0 - cosine * cosine) / (cosine * cosine);
            2.0 / (1.0 + (1.0 + alpha2 * tan2).sqrt())
        };
        let specular = alpha2 / (PI * d * d) * smith(self.light) * smith(self.view) * fresnel(self.difference, ior)
            / (4.0 * self.light * self.view);
        let through = (1.0 - fresnel(self.light, ior)) * (1.0 - fresnel(self.view, ior));
        // Egan and Hilgeman's fit of the diffuse reflectance from inside.
        let inside = -1.4399 / (ior * ior) + 0.7099 / ior + 0.6681 + 0.0636 * ior;
        base_color.map(|c| specular + through * c / (PI * ior * ior * (1.0 - c * inside)))
    }
}

/// Unpolarised dielectric reflectance from outside.
fn fresnel(cosine: f64, ior: f64) -> f64 {
    let inner = (1.0 - (1.0 - cosine * cosine) / (ior * ior)).sqrt();
    let s = (cosine - ior * inner) / (cosine + ior * inner);
    let p = (inner - ior * cosine) / (inner + ior * cosine);
    0.5 * (s * s + p * p)
}
