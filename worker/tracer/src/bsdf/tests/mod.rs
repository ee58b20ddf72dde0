//! The reflectance models against independent truth: chi-square statistics for the samplers, fine quadratures written in
//! other coordinates for the integrals, central differences for the derivatives, another renderer for the values.

mod aliasing;
mod boundary;
mod chi_square;
mod derivatives;
mod furnace;
mod layered;
mod reference;
mod sampling;

use glam::Vec3;

use super::{Bsdf, Conductor, Lambert, Plastic};

const GOLD_ETA: Vec3 = Vec3::new(0.143, 0.375, 1.442);
const GOLD_K: Vec3 = Vec3::new(3.983, 2.386, 1.603);

fn lambert(color: Vec3) -> Bsdf {
    Bsdf::Lambert(Lambert::new(color).unwrap())
}

fn plastic(color: Vec3, alpha: f32, ior: f32, energy_compensation: bool) -> Bsdf {
    Bsdf::Plastic(Plastic::new(color, alpha.sqrt(), ior, energy_compensation).unwrap())
}

fn gold(alpha: f32) -> Bsdf {
    Bsdf::Conductor(Conductor::new(alpha.sqrt(), GOLD_ETA, GOLD_K).unwrap())
}

/// A direction from its cosine to the normal and its azimuth.
fn direction(cos: f32, azimuth: f32) -> Vec3 {
    let (sin_phi, cos_phi) = libm::sincosf(azimuth);
    let sin = (1.0 - cos * cos).sqrt();
    Vec3::new(sin * cos_phi, sin * sin_phi, cos)
}

/// Independent random numbers (SplitMix64, Steele et al. 2014): the statistics below assume independence, which a
/// low-discrepancy sequence does not have.
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1u32 << 24) as f32
    }

    fn three(&mut self) -> [f32; 3] {
        std::array::from_fn(|_| self.uniform())
    }

    /// Uniform over the hemisphere, not closer to the horizon than a cosine of 0.01.
    fn direction(&mut self) -> Vec3 {
        direction(0.01 + 0.99 * self.uniform(), std::f32::consts::TAU * self.uniform())
    }
}

/// Hemispherical integral of `f(wi)`, smooth on the hemisphere, by the midpoint rule in (cos^2, azimuth).
fn integrate_smooth(f: impl Fn(Vec3) -> Vec3) -> Vec3 {
    let (rings, sectors) = (200, 200);
    let mut sum = Vec3::ZERO.as_dvec3();
    for i in 0..rings {
        let cos = ((i as f32 + 0.5) / rings as f32).sqrt();
        for j in 0..sectors {
            let wi = direction(cos, std::f32::consts::TAU * (j as f32 + 0.5) / sectors as f32);
            sum += (f(wi) / cos).as_dvec3();
        }
    }
    (sum * (std::f64::consts::PI / f64::from(rings * sectors))).as_vec3()
}

/// Hemispherical integral of `f(wi)`, concentrated like a GGX lobe of this `alpha` round the mirror direction of `wo`,
/// by the midpoint rule over half vectors: polar in slope space, where the distribution is flat.
fn integrate_lobe(wo: Vec3, alpha: f32, f: impl Fn(Vec3) -> Vec3) -> Vec3 {
    let (rings, sectors) = (600, 240);
    let mut sum = Vec3::ZERO.as_dvec3();
    for i in 0..rings {
        // Drawn towards u = 1, the tail.
        let rest = 1.0 - (f64::from(i) + 0.5) / f64::from(rings);
        let (u, d_u) = (1.0 - rest * rest, 2.0 * rest);
        let alpha2 = f64::from(alpha).powi(2);
        let tan2 = alpha2 * u / (1.0 - u);
        let cos = (1.0 / (1.0 + tan2)).sqrt();
        // d omega_h = sin d theta d phi; d tan^2 = alpha^2 / (1 - u)^2 du = 2 sin / cos^3 d theta.
        let solid_angle = 0.5 * cos.powi(3) * alpha2 / (1.0 - u).powi(2) * d_u;
        let sin = tan2.sqrt() * cos;
        for j in 0..sectors {
            let (sin_phi, cos_phi) = libm::sincos(std::f64::consts::TAU * (f64::from(j) + 0.5) / f64::from(sectors));
            let half = glam::DVec3::new(sin * cos_phi, sin * sin_phi, cos);
            let cos_d = half.dot(wo.as_dvec3());
            let wi = 2.0 * cos_d * half - wo.as_dvec3();
            if cos_d > 0.0 && wi.z > 0.0 {
                sum += f(wi.as_vec3()).as_dvec3() * (4.0 * cos_d * solid_angle);
            }
        }
    }
    (sum * (std::f64::consts::TAU / f64::from(rings * sectors))).as_vec3()
}

/// Light reflected towards `wo` under a uniform sky of radiance 1: the lobe and the rest each by a fitting rule.
fn furnace(wo: Vec3, alpha: f32, lobe: &Bsdf, whole: &Bsdf) -> Vec3 {
    integrate_lobe(wo, alpha, |wi| lobe.evaluate(wo, wi).value)
        + integrate_smooth(|wi| whole.evaluate(wo, wi).value - lobe.evaluate(wo, wi).value)
}

#[test]
fn reciprocal_and_one_sided() {
    let mut random = Random(1);
    let color = Vec3::new(0.9, 0.5, 0.1);
    let models =
        [lambert(color), plastic(color, 0.2, 1.5, false), plastic(color, 0.2, 1.5, true), gold(0.1), gold(1.0)];
    for model in &models {
        for _ in 0..1000 {
            let (wo, wi) = (random.direction(), random.direction());
            let forward = model.evaluate(wo, wi).value / wi.z;
            let backward = model.evaluate(wi, wo).value / wo.z;
            assert!((forward - backward).abs().max_element() <= 1e-5 * forward.max_element(), "{forward} {backward}");
            let below = Vec3::new(wi.x, wi.y, -wi.z);
            for (wo, wi) in [(wo, below), (below, wo), (below, below)] {
                let mut derivatives = [Vec3::ONE; 3];
                assert_eq!(model.evaluate(wo, wi), super::Evaluation::default());
                assert_eq!(model.evaluate_with_derivatives(wo, wi, &mut derivatives), super::Evaluation::default());
                assert!(derivatives.iter().take(model.slots().len()).all(|&d| d == Vec3::ZERO));
            }
            assert!(model.sample(below, random.three()).is_none());
        }
    }
}

/// Grazing, normal, mirror, retro-reflecting and opposite directions: finite, and never negative.
#[test]
fn finite_at_every_corner() {
    let cosines = [1e-20, 1e-7, 1e-3, 0.5, 1.0 - 6e-8, 1.0];
    let azimuths = [0.0, 1.0, std::f32::consts::PI];
    for alpha in [0.0, 1e-3, 0.04, 1.0] {
        let models = [
            plastic(Vec3::ONE, alpha, 1.001, false),
            plastic(Vec3::ONE, alpha, 10.0, true),
            plastic(Vec3::ZERO, alpha, 1.5, false),
            gold(alpha),
            Bsdf::Conductor(Conductor::new(alpha.sqrt(), Vec3::splat(1e-3), Vec3::ZERO).unwrap()),
            Bsdf::Conductor(Conductor::new(alpha.sqrt(), Vec3::ONE, Vec3::ZERO).unwrap()),
        ];
        for (index, model) in models.iter().enumerate() {
            for &cos_o in &cosines {
                for &cos_i in &cosines {
                    for &azimuth in &azimuths {
                        let (wo, wi) = (direction(cos_o, 0.0), direction(cos_i, azimuth));
                        let mut derivatives = [Vec3::NAN; 3];
                        let evaluation = model.evaluate_with_derivatives(wo, wi, &mut derivatives);
                        let place =
                            format!("model {index} alpha {alpha} wo {wo} wi {wi}: {evaluation:?} {derivatives:?}");
                        assert!(evaluation.value.is_finite() && evaluation.pdf.is_finite(), "{place}");
                        assert!(evaluation.value.min_element() >= 0.0 && evaluation.pdf >= 0.0, "{place}");
                        assert!(derivatives.iter().all(|d| d.is_finite()), "{place}");
                    }
                }
                for u in [0.0, 0.5, 1.0 - 6e-8] {
                    for v in [0.0, 0.5, 1.0 - 6e-8] {
                        for choice in [0.0, 1.0 - 6e-8] {
                            let sample = model.sample(direction(cos_o, 0.0), [choice, u, v]);
                            assert!(sample.is_none_or(|s| {
                                s.pdf > 0.0 && s.pdf.is_finite() && (s.wi.length() - 1.0).abs() < 1e-4
                            }));
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn parameters_out_of_range_are_refused() {
    let error = Plastic::new(Vec3::ONE, 1.5, 1.5, false).unwrap_err();
    assert_eq!(error.to_string(), "`roughness` is 1.5, must be from 0 to 1");
    assert!(Plastic::new(Vec3::new(0.5, f32::NAN, 0.5), 0.5, 1.5, false).is_err());
    assert!(Plastic::new(Vec3::ONE, 0.5, 1.0, false).is_err());
    assert!(Lambert::new(Vec3::splat(-0.1)).is_err());
    assert!(Conductor::new(0.5, Vec3::ZERO, Vec3::ONE).is_err());
}
