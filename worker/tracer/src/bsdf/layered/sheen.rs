//! Light from fibres that stand up: Estevez & Kulla 2017, "Production friendly microfacet sheen BRDF".

use std::f64::consts::PI;

use glam::Vec3;

use super::super::dual::Dual;
use super::super::microfacet::HalfVector;
use super::super::quadrature::Rule;
use super::super::table::AngularTable;

/// Least alpha: below, the lobe is a seam along the horizon that no pixel resolves.
const ALPHA_FLOOR: f64 = 0.01;

/// A sheen lobe of colour 1 and its albedo.
#[derive(Clone, Debug)]
pub struct Sheen {
    inverse_alpha: f32,
    fit: Fit,
    albedo: AngularTable,
}

/// The paper's fit of the masking's logarithm, `a / (1 + b x^c) + d x + e`, at one roughness.
#[derive(Clone, Copy, Debug)]
struct Fit([f32; 5]);

impl Sheen {
    /// The lobe of perceptual `roughness` in `[0, 1]`, alpha its square.
    pub fn new(roughness: f32) -> Self {
        let alpha = f64::from(roughness * roughness).max(ALPHA_FLOOR);
        let mut sheen =
            Self { inverse_alpha: (1.0 / alpha) as f32, fit: Fit::new(alpha), albedo: AngularTable::linear(&[]) };
        let (cosines, azimuths) = (Rule::<40>::gauss_legendre(), Rule::<24>::gauss_legendre());
        sheen.albedo = AngularTable::smooth(|cos| {
            let cos = cos.max(1e-4);
            let wo = Vec3::new((1.0 - cos * cos).sqrt() as f32, 0.0, cos as f32);
            let mut sum = 0.0;
            for &(s, s_weight) in &cosines.nodes {
                // Drawn towards grazing directions, where masking varies.
                let (z, d_z) = (s * s, 2.0 * s);
                let sin = (1.0 - z * z).sqrt();
                for &(t, t_weight) in &azimuths.nodes {
                    let (sin_phi, cos_phi) = libm::sincos(PI * t);
                    let wi = Vec3::new((sin * cos_phi) as f32, (sin * sin_phi) as f32, z as f32);
                    let value = f64::from(sheen.value(wo, wi, &HalfVector::new(wo, wi)));
                    sum += value * s_weight * t_weight * d_z;
                }
            }
            Dual::constant((sum * 2.0 * PI).min(1.0))
        });
        sheen
    }

    /// The lobe times the cosine of `wi`, per steradian.
    #[inline]
    pub fn value(&self, wo: Vec3, wi: Vec3, half: &HalfVector) -> f32 {
        let sine = libm::powf(half.sin2_h, 0.5 * self.inverse_alpha);
        let density = (2.0 + self.inverse_alpha) * sine * (0.5 * std::f32::consts::FRAC_1_PI);
        density / (4.0 * wo.z * (1.0 + self.fit.masking(wo.z) + self.fit.masking(wi.z)))
    }

    /// What the lobe reflects of a uniform sky towards `cos`, at most 1.
    #[inline]
    pub fn albedo(&self, cos: f32) -> f32 {
        self.albedo.value(cos)
    }
}

impl Fit {
    /// Table 1 of the paper: roughness 0 and 1, blended by (1 - alpha)^2.
    fn new(alpha: f64) -> Self {
        const SMOOTH: [f64; 5] = [25.3245, 3.32435, 0.16801, -1.27393, -4.85967];
        const ROUGH: [f64; 5] = [21.5473, 3.82987, 0.19823, -1.97760, -4.32054];
        let share = (1.0 - alpha) * (1.0 - alpha);
        Self(std::array::from_fn(|i| (share * SMOOTH[i] + (1.0 - share) * ROUGH[i]) as f32))
    }

    #[inline]
    fn logarithm(&self, x: f32) -> f32 {
        let [a, b, c, d, e] = self.0;
        a / (1.0 + b * libm::powf(x, c)) + d * x + e
    }

    /// Smith's Lambda.
    #[inline]
    fn masking(&self, cos: f32) -> f32 {
        libm::expf(if cos < 0.5 {
            self.logarithm(cos)
        } else {
            2.0 * self.logarithm(0.5) - self.logarithm((1.0 - cos).max(0.0))
        })
    }
}
