//! A Lambertian ball, sampled by the solid angle that it covers (Shirley, Wang and Zimmerman 1996).

use super::{Emission, LightSample};

use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// A ball of radiance intensity / (pi radius^2).
#[derive(Debug, Clone, Copy)]
pub struct SphereLight {
    /// World position, metres.
    pub centre: Vec3,
    radius: f32,
    emission: Emission,
}

impl SphereLight {
    /// `radius` in metres, `intensity` in power per solid angle far away.
    #[must_use]
    pub fn new(centre: Vec3, radius: f64, intensity: Vec3) -> Self {
        let derivative = Vec3::splat((1.0 / (std::f64::consts::PI * radius * radius)) as f32);
        Self { centre, radius: radius as f32, emission: Emission { value: intensity * derivative, derivative } }
    }

    /// Radiance, the same everywhere on the ball.
    #[must_use]
    pub fn emission(&self) -> Emission {
        self.emission
    }

    /// 1 - cos of the half angle that the ball covers from `point`; `None` inside the ball.
    fn versine(&self, point: Vec3) -> Option<f32> {
        let distance2 = (self.centre - point).length_squared();
        let sin2 = self.radius * self.radius / distance2;
        // 1 - sqrt(1 - s) = s / (1 + sqrt(1 - s)): keeps its digits for a ball far away.
        (sin2 < 1.0).then(|| sin2 / (1.0 + (1.0 - sin2).sqrt()))
    }

    /// Density over solid angle of [`SphereLight::sample`] for directions that hit the ball.
    #[must_use]
    pub fn pdf(&self, point: Vec3) -> f32 {
        self.versine(point).map_or(0.25 / PI, |v| 1.0 / (2.0 * PI * v))
    }

    /// A direction uniform over the covered solid angle (over the sphere of directions from inside).
    #[must_use]
    pub fn sample(&self, point: Vec3, u: Vec2) -> Option<LightSample> {
        let axis = (self.centre - point).try_normalize().unwrap_or(Vec3::Z);
        let versine = self.versine(point);
        let covered = versine.unwrap_or(2.0);
        let cos = 1.0 - u.x * covered;
        let sin = (u.x * covered * (2.0 - u.x * covered)).max(0.0).sqrt();
        let (sin_phi, cos_phi) = libm::sincosf(2.0 * PI * u.y);
        let (x, y) = axis.any_orthonormal_pair();
        let direction = (x * (cos_phi * sin) + y * (sin_phi * sin) + axis * cos).normalize();
        // At the rim, rounding may miss the ball by a hair: then the tangent point is meant.
        let tangent = || direction.dot(self.centre - point);
        let distance = self.hit(point, direction).unwrap_or_else(tangent);
        (distance > 0.0).then(|| LightSample {
            direction,
            distance,
            emission: self.emission,
            pdf: 1.0 / (2.0 * PI * covered),
        })
    }

    /// Distance along a ray of unit direction to the ball, if it lies ahead; from inside, to the far wall.
    #[must_use]
    pub fn hit(&self, origin: Vec3, direction: Vec3) -> Option<f32> {
        // Distance of the centre from the line, not the textbook discriminant, which cancels for small far balls
        // (Haines et al. 2019, "Precision Improvements for Ray/Sphere Intersection").
        let to_centre = self.centre - origin;
        let along = to_centre.dot(direction);
        let off2 = (to_centre - direction * along).length_squared();
        let half2 = self.radius * self.radius - off2;
        if half2 < 0.0 {
            return None;
        }
        let half = half2.sqrt();
        let near = along - half;
        let t = if near > 0.0 { near } else { along + half };
        (t > 0.0).then_some(t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The integral of radiance x cosine over the ball, by its sampling, is the irradiance of a Lambertian ball:
    /// intensity / d^2 on a plane that faces it (exact at any distance for a ball wholly above the plane).
    #[test]
    fn irradiance_follows_the_inverse_square_exactly() {
        for (d, radius) in [(1.0f32, 0.01), (1.0, 0.5), (0.3, 0.29), (100.0, 1e-3)] {
            let ball = SphereLight::new(Vec3::new(0.0, 0.0, d), radius, Vec3::ONE);
            let n = 64;
            let mut sum = 0.0f64;
            for i in 0..n * n {
                let u = Vec2::new(((i % n) as f32 + 0.5) / n as f32, ((i / n) as f32 + 0.5) / n as f32);
                let s = ball.sample(Vec3::ZERO, u).unwrap();
                sum += f64::from(s.emission.value.x * s.direction.z.max(0.0) / s.pdf);
            }
            let irradiance = sum / f64::from(n * n) * f64::from(d * d);
            assert!((irradiance - 1.0).abs() < 2e-3, "d {d} radius {radius}: {irradiance}");
        }
    }

    #[test]
    fn samples_hit_the_ball_they_came_from() {
        let ball = SphereLight::new(Vec3::new(1.0, 2.0, 3.0), 0.2, Vec3::ONE);
        for i in 0..1000 {
            let u = Vec2::new((i as f32 * 0.618_034).fract(), (i as f32 * 0.381_97).fract() * 0.999);
            let s = ball.sample(Vec3::new(-1.0, 0.0, 0.5), u).unwrap();
            let there = Vec3::new(-1.0, 0.0, 0.5) + s.direction * s.distance;
            assert!(((there - ball.centre).length() - 0.2).abs() < 1e-3);
            assert!((s.pdf / ball.pdf(Vec3::new(-1.0, 0.0, 0.5)) - 1.0).abs() < 1e-4);
        }
        assert!(ball.sample(ball.centre, Vec2::new(0.3, 0.3)).unwrap().distance > 0.19, "from inside");
    }
}
