//! How far from where it entered light leaves a translucent surface: normalised diffusion.
//!
//! Christensen & Burley 2015, "Approximate reflectance profiles for efficient subsurface scattering": per channel of albedo A
//! and mean free path l, with d = l / s and s = 1.9 - A + 3.5 (A - 0.8)^2 (their fit for diffuse transmission, which is what
//! a Lambertian base under its boundary is), the light that enters at a point of a plane leaves at distance r with density
//! `(exp(-r / d) + exp(-r / (3 d))) / (8 pi d r)` per area. It integrates to 1: the albedo is a factor elsewhere.

use std::f32::consts::PI;

use glam::Vec3;

/// The share of the first exponential; the second has three quarters.
const NARROW: f32 = 0.25;
/// Distances below this part of a channel's d count as it: the density has a pole at 0.
const LEAST: f32 = 1e-5;
/// Light that would leave beyond `REACH` times the largest d is lost: 3e-5 of it.
const REACH: f32 = 30.0;

/// The profile of three channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    /// 1 / d, per metre.
    rate: Vec3,
}

impl Profile {
    /// That of a base of reflectance `albedo`, each channel in `[0, 1]`, and a mean free path in metres, above 0.
    #[inline]
    pub fn new(albedo: Vec3, distance: f32) -> Self {
        let off = albedo - 0.8;
        Self { rate: (1.9 - albedo + 3.5 * off * off) / distance }
    }

    /// Density per area at a distance, by channel.
    #[inline]
    pub fn value(&self, r: f32) -> Vec3 {
        let channel = |rate: f32| {
            let x = (r * rate).max(LEAST);
            let wide = libm::expf(x * (-1.0 / 3.0));
            rate * rate * wide * (1.0 + wide * wide) / (8.0 * PI * x)
        };
        Vec3::new(channel(self.rate.x), channel(self.rate.y), channel(self.rate.z))
    }

    /// Density per area with which [`Self::radius`], at an even angle, draws a distance: the mean of the channels.
    #[inline]
    pub fn pdf(&self, r: f32) -> f32 {
        self.value(r).element_sum() / 3.0
    }

    /// A distance from a uniform number: first the channel, then the exponential, by what is left of the number.
    #[inline]
    pub fn radius(&self, u: f32) -> f32 {
        let scaled = u * 3.0;
        let (rate, rest) = match scaled as u32 {
            0 => (self.rate.x, scaled),
            1 => (self.rate.y, scaled - 1.0),
            _ => (self.rate.z, scaled - 2.0),
        };
        let (width, rest) = if rest < NARROW { (1.0, rest / NARROW) } else { (3.0, (rest - NARROW) / (1.0 - NARROW)) };
        // A scale that is never 0 inside the logarithm: 2^-24 is a part in 16 million.
        -libm::logf((1.0 - rest).max(6e-8)) * width / rate
    }

    /// The distance that counts as the end of the profile.
    #[inline]
    pub fn reach(&self) -> f32 {
        REACH / self.rate.min_element()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALBEDO: Vec3 = Vec3::new(0.9, 0.5, 0.1);

    /// Every channel integrates to 1 over the plane, in rings whose radii grow by a percent.
    #[test]
    fn profiles_are_normalised() {
        let profile = Profile::new(ALBEDO, 0.002);
        let (mut sum, mut r) = (Vec3::ZERO, 1e-9_f32);
        while r < profile.reach() {
            let middle = r * 1.005;
            sum += profile.value(middle) * (2.0 * PI * middle * 0.01 * r);
            r *= 1.01;
        }
        assert!((sum - 1.0).abs().max_element() < 1e-3, "{sum}");
    }

    /// The share of draws within each of twenty rings is what the density says, within 5 standard errors.
    #[test]
    fn distances_are_drawn_by_their_density() {
        let profile = Profile::new(ALBEDO, 0.002);
        let count = 1 << 20;
        let mut draws: Vec<f32> = (0..count).map(|i| profile.radius((i as f32 + 0.5) / count as f32)).collect();
        draws.sort_by(f32::total_cmp);
        for k in 0..20 {
            let (low, high) = (0.0005 * k as f32, 0.0005 * (k + 1) as f32);
            let found = draws.partition_point(|r| *r < high) - draws.partition_point(|r| *r < low);
            let steps = 1000;
            let expected: f32 = (0..steps)
                .map(|i| {
                    let r = low + (high - low) * (i as f32 + 0.5) / steps as f32;
                    profile.pdf(r) * 2.0 * PI * r * (high - low) / steps as f32
                })
                .sum();
            assert!((found as f32 / count as f32 - expected).abs() < 2e-4, "{k}: {found} {expected}");
        }
    }

    /// A brighter base lets light go further.
    #[test]
    fn bright_channels_spread_more() {
        let far = Profile::new(ALBEDO, 1.0).value(5.0);
        assert!(far.x > far.y && far.y > far.z);
    }
}
