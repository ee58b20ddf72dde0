//! Lights: sampled towards (next-event estimation) and hit by chance (multiple importance sampling joins the two).

mod environment;
mod lobe;
mod sphere;

pub use environment::EnvironmentMap;
use lobe::LampLobe;
pub use sphere::SphereLight;

use crate::affine::{affine, rgb};
use crate::bvh::Ray;
use crate::planes::PlaneIndex;
use glam::{DMat3, DVec3, Mat3, Vec2, Vec3};
use gonio_scene::capture::{Frame, Light, LightKind, Photo};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Radiance (or, towards a delta light, radiance times solid angle) and how it depends on the light's own number.
#[derive(Debug, Clone, Copy)]
pub struct Emission {
    /// Linear RGB.
    pub value: Vec3,
    /// Channel c: d value_c / d the light's intensity_c (irradiance, radiance) or scale.
    pub derivative: Vec3,
}

impl Emission {
    fn scaled(&self, factor: f32) -> Self {
        Self { value: self.value * factor, derivative: self.derivative * factor }
    }
}

/// One light sample as a point sees it.
#[derive(Debug, Clone, Copy)]
pub struct LightSample {
    /// Unit direction towards the light.
    pub direction: Vec3,
    /// How far the way must be free.
    pub distance: f32,
    /// What arrives; for a delta light already integrated over its direction.
    pub emission: Emission,
    /// Density over solid angle; 0 for a delta light, which no other strategy can hit.
    pub pdf: f32,
}

/// One light of a photo, in world coordinates.
pub struct PhotoLight {
    source: Source,
    lobe: Option<LampLobe>,
    /// Which derivative plane its intensity, irradiance, radiance or scale belongs to.
    pub plane: PlaneIndex,
}

enum Source {
    Point { position: Vec3, intensity: Vec3 },
    Sphere(SphereLight),
    Directional { towards: Vec3, irradiance: Vec3 },
    Constant { radiance: Vec3 },
    Map { map: Arc<EnvironmentMap>, scale: f32, to_map: Mat3 },
}

/// A light from one place or one direction, the same to all sides.
#[derive(Debug, Clone, Copy)]
pub enum Lamp {
    /// World position, intensity.
    Point {
        /// World.
        position: Vec3,
        /// Power per solid angle.
        intensity: Vec3,
    },
    /// From infinity.
    Directional {
        /// Unit direction towards the light.
        towards: Vec3,
        /// On a plane that faces it.
        irradiance: Vec3,
    },
}

/// The lights that were on in one photo.
#[derive(Default)]
pub struct PhotoLights {
    lights: Vec<PhotoLight>,
    /// Indices of those that can be sampled towards. A constant environment cannot: a surface's own sampling is better.
    sampled: Vec<usize>,
    /// How many of these need no random number.
    fixed: usize,
    spheres: Vec<usize>,
    /// Of intensity 0: there only for their derivatives.
    dark: Vec<usize>,
    environments: Vec<usize>,
}

/// From the frame in which a map is turned by `azimuth` to the map's own. Not turned, it keeps its bits.
fn turn(azimuth: f64) -> DMat3 {
    if azimuth == 0.0 {
        return DMat3::IDENTITY;
    }
    let (sine, cosine) = libm::sincos(azimuth);
    DMat3::from_cols(DVec3::new(cosine, -sine, 0.0), DVec3::new(sine, cosine, 0.0), DVec3::Z)
}

impl PhotoLight {
    fn new(
        light: &Light,
        photo: &Photo,
        maps: &BTreeMap<String, Arc<EnvironmentMap>>,
        plane: PlaneIndex,
    ) -> Option<Self> {
        let pose = affine(&photo.pose());
        let (rotation, origin) = match light.frame {
            Frame::World => (DMat3::IDENTITY, DVec3::ZERO),
            Frame::Camera => (pose.matrix3, pose.translation),
        };
        let place = |p: &[f64; 3]| (rotation * DVec3::from(*p) + origin).as_vec3();
        let source = match &light.kind {
            LightKind::Point { position, intensity } => {
                Source::Point { position: place(position), intensity: rgb(intensity) }
            }
            LightKind::Sphere { position, radius: 0.0, intensity } => {
                Source::Point { position: place(position), intensity: rgb(intensity) }
            }
            LightKind::Sphere { position, radius, intensity } => {
                Source::Sphere(SphereLight::new(place(position), *radius, rgb(intensity)))
            }
            LightKind::Directional { direction, irradiance } => Source::Directional {
                towards: -(rotation * DVec3::from(*direction)).normalize().as_vec3(),
                irradiance: rgb(irradiance),
            },
            LightKind::Constant { radiance } => Source::Constant { radiance: rgb(radiance) },
            LightKind::Map { map, scale, azimuth } => Source::Map {
                map: maps.get(map)?.clone(),
                scale: *scale as f32,
                to_map: (turn(*azimuth) * rotation.transpose()).as_mat3(),
            },
        };
        let lobe = LampLobe::new(&light.lobe, rotation);
        Some(Self { source, lobe, plane })
    }

    /// A sample as seen from `point`; `None` where the light cannot reach it.
    #[inline]
    fn sample(&self, point: Vec3, u: Vec2) -> Option<LightSample> {
        let sample = self.even_sample(point, u)?;
        match &self.lobe {
            None => Some(sample),
            Some(lobe) => {
                let factor = lobe.factor(-sample.direction);
                (factor > 0.0).then(|| LightSample { emission: sample.emission.scaled(factor), ..sample })
            }
        }
    }

    /// As [`PhotoLight::sample`] for a light without a lobe.
    #[inline]
    fn even_sample(&self, point: Vec3, u: Vec2) -> Option<LightSample> {
        match &self.source {
            Source::Point { position, intensity } => {
                let way = *position - point;
                let distance2 = way.length_squared();
                if distance2 <= f32::MIN_POSITIVE {
                    return None;
                }
                let distance = distance2.sqrt();
                let derivative = Vec3::splat(1.0 / distance2);
                let emission = Emission { value: *intensity * derivative, derivative };
                Some(LightSample { direction: way / distance, distance, emission, pdf: 0.0 })
            }
            Source::Sphere(sphere) => sphere.sample(point, u),
            Source::Directional { towards, irradiance } => Some(LightSample {
                direction: *towards,
                distance: f32::INFINITY,
                emission: Emission { value: *irradiance, derivative: Vec3::ONE },
                pdf: 0.0,
            }),
            Source::Constant { .. } => None,
            Source::Map { map, scale, to_map } => {
                let (local, derivative, pdf) = map.sample(u)?;
                let emission = Emission { value: derivative * *scale, derivative };
                Some(LightSample { direction: to_map.transpose() * local, distance: f32::INFINITY, emission, pdf })
            }
        }
    }
}

impl PhotoLight {
    /// An environment's light along `-direction`, its sampling density and plane.
    fn light_from_afar(&self, direction: Vec3) -> Option<(Emission, f32, PlaneIndex)> {
        match &self.source {
            Source::Constant { radiance } => {
                Some((Emission { value: *radiance, derivative: Vec3::ONE }, 0.0, self.plane))
            }
            Source::Map { map, scale, to_map } => {
                let local = *to_map * direction;
                let (derivative, pdf) = map.seen(local);
                Some((Emission { value: derivative * *scale, derivative }, pdf, self.plane))
            }
            _ => None,
        }
    }
}

impl PhotoLights {
    /// The lights that were on in `photo`; `plane_of` gives the derivative plane of a light's number.
    #[must_use]
    pub fn new(
        lights: &[Light],
        photo: &Photo,
        maps: &BTreeMap<String, Arc<EnvironmentMap>>,
        plane_of: &dyn Fn(&Light) -> PlaneIndex,
    ) -> Self {
        let mut this = Self::default();
        for light in lights {
            if photo.lights.as_ref().is_some_and(|on| !on.contains(&light.name)) {
                continue;
            }
            let plane = plane_of(light);
            if light.is_dark() && plane.is_none() {
                continue;
            }
            let Some(ready) = PhotoLight::new(light, photo, maps, plane) else { continue };
            let index = this.lights.len();
            if light.is_dark() {
                this.dark.push(index);
                this.lights.push(ready);
                continue;
            }
            match &ready.source {
                Source::Point { .. } | Source::Directional { .. } => {
                    this.sampled.push(index);
                    this.fixed += 1;
                }
                Source::Sphere(_) => {
                    this.sampled.push(index);
                    this.spheres.push(index);
                }
                Source::Map { map, .. } => {
                    this.environments.push(index);
                    if map.can_be_sampled() {
                        this.sampled.push(index);
                    }
                }
                Source::Constant { .. } => this.environments.push(index),
            }
            this.lights.push(ready);
        }
        this
    }

    /// Number of lights that can be sampled towards.
    #[inline]
    #[must_use]
    pub fn sampled(&self) -> usize {
        self.sampled.len()
    }

    /// A sample towards sampled light number `index`, and that light's plane.
    #[inline]
    #[must_use]
    pub fn sample(&self, index: usize, point: Vec3, u: Vec2) -> Option<(LightSample, PlaneIndex)> {
        let light = &self.lights[self.sampled[index]];
        light.sample(point, u).map(|s| (s, light.plane))
    }

    /// Sampled light number `index`, where it needs no random number.
    #[inline]
    #[must_use]
    pub fn lamp(&self, index: usize) -> Option<Lamp> {
        let light = &self.lights[self.sampled[index]];
        match light.source {
            _ if light.lobe.is_some() => None,
            Source::Point { position, intensity } => Some(Lamp::Point { position, intensity }),
            Source::Directional { towards, irradiance } => Some(Lamp::Directional { towards, irradiance }),
            _ => None,
        }
    }

    /// Whether sampled light number `index` is the same for whatever random numbers.
    #[inline]
    #[must_use]
    pub fn is_fixed(&self, index: usize) -> bool {
        matches!(self.lights[self.sampled[index]].source, Source::Point { .. } | Source::Directional { .. })
    }

    /// Whether a path can come upon a light: one that has an extent, or surrounds everything.
    #[inline]
    #[must_use]
    pub fn can_be_met(&self) -> bool {
        !self.spheres.is_empty() || !self.environments.is_empty()
    }

    /// Whether a sample towards one of the lights needs random numbers.
    #[inline]
    #[must_use]
    pub fn need_numbers(&self) -> bool {
        self.sampled.len() > self.fixed
    }

    /// Whether a lamp that has an extent blocks a shadow ray.
    #[inline]
    #[must_use]
    pub fn in_the_way(&self, shadow: &Ray) -> bool {
        self.sphere(shadow.origin, shadow.direction, shadow.t_max).is_some()
    }

    /// Number of lights of intensity 0 whose derivative is wanted.
    #[inline]
    #[must_use]
    pub fn dark(&self) -> usize {
        self.dark.len()
    }

    /// As [`PhotoLights::sample`], of the lights of intensity 0.
    #[must_use]
    pub fn sample_dark(&self, index: usize, point: Vec3, u: Vec2) -> Option<(LightSample, PlaneIndex)> {
        let light = &self.lights[self.dark[index]];
        light.sample(point, u).map(|s| (s, light.plane))
    }

    /// The nearest sphere light on a ray closer than `limit`: distance and index.
    #[inline]
    #[must_use]
    pub fn sphere(&self, origin: Vec3, direction: Vec3, limit: f32) -> Option<(f32, usize)> {
        let mut nearest = None;
        let mut limit = limit;
        for &i in &self.spheres {
            if let Source::Sphere(sphere) = &self.lights[i].source
                && let Some(t) = sphere.hit(origin, direction)
                && t < limit
            {
                limit = t;
                nearest = Some((t, i));
            }
        }
        nearest
    }

    /// What sphere light `index` sends back along a ray of `direction` that hit it, the density with which sampling from `origin` would
    /// have chosen that direction, and its plane.
    #[must_use]
    pub fn sphere_emission(&self, index: usize, origin: Vec3, direction: Vec3) -> Option<(Emission, f32, PlaneIndex)> {
        let light = &self.lights[index];
        let Source::Sphere(sphere) = &light.source else { return None };
        let even = sphere.emission();
        let emission = light.lobe.as_ref().map_or(even, |lobe| even.scaled(lobe.factor(-direction)));
        Some((emission, sphere.pdf(origin), light.plane))
    }

    /// What arrives from infinity along `-direction`: of each environment its light, the density with which sampling
    /// would have chosen it, its plane.
    pub fn environments(&self, direction: Vec3) -> impl Iterator<Item = (Emission, f32, PlaneIndex)> + '_ {
        self.environments.iter().filter_map(move |index| self.lights[*index].light_from_afar(direction))
    }

    /// Direction towards the first light that comes from one place, for half angles.
    #[must_use]
    pub fn principal_direction(&self, point: Vec3) -> Option<Vec3> {
        self.lights.iter().find_map(|l| match &l.source {
            Source::Point { position, .. } => (*position - point).try_normalize(),
            Source::Sphere(sphere) => (sphere.centre - point).try_normalize(),
            Source::Directional { towards, .. } => Some(*towards),
            Source::Constant { .. } | Source::Map { .. } => None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gonio_scene::image::Image;

    #[test]
    fn a_map_that_is_turned_from_x_towards_y_shows_along_y_what_was_along_x() {
        // As in the map's own test: 1 along +x.
        let mut pixels = vec![[0.0f32; 3]; 8 * 5];
        pixels[2 * 8 + 3..2 * 8 + 5].fill([1.0; 3]);
        let map = Arc::new(EnvironmentMap::new(&Image { width: 8, height: 5, pixels }));
        let maps = BTreeMap::from([("room.exr".to_owned(), map)]);
        let radiance = |azimuth: f64, direction: Vec3| {
            let kind = LightKind::Map { map: "room.exr".to_owned(), scale: 2.0, azimuth };
            let light = Light { name: "room".to_owned(), kind, ..Light::default() };
            let light = PhotoLight::new(&light, &Photo::default(), &maps, PlaneIndex::default()).unwrap();
            light.light_from_afar(direction).unwrap().0.value.x
        };
        let quarter = std::f64::consts::FRAC_PI_2;
        assert!((radiance(0.0, Vec3::X) - 2.0).abs() < 1e-5);
        assert!((radiance(quarter, Vec3::Y) - 2.0).abs() < 1e-5);
        assert!(radiance(quarter, Vec3::X).abs() < 1e-5);
        assert!((radiance(-quarter, Vec3::NEG_Y) - 2.0).abs() < 1e-5);
    }
}
