//! How much light crosses a plastic's boundary: for those who say a plastic in the words of other renderers.

use super::error::{ParameterError, check};
use super::microfacet::Ggx;
use super::plastic::{Tables, tables};
use super::quadrature::GAUSS;

/// What one boundary of [`super::Plastic`] does to light, in means over the hemisphere by the cosine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exchange {
    /// Share of the light from outside that the specular lobe reflects, 0..1.
    pub reflected: f64,
    /// Share of the light from outside that reaches the base, 0..1. Without energy compensation it is less than
    /// `1 - reflected`: what would scatter twice between facets is lost.
    pub entered: f64,
    /// Share of the base's light that the boundary turns back to it (F_in), 0..1.
    pub internal: f64,
    /// The index of refraction that the numbers belong to, relative to what is outside.
    pub ior: f64,
}

impl Exchange {
    /// The exchange at a boundary of perceptual `roughness` in `[0, 1]` and relative index `ior` in `[1.001, 10]`.
    ///
    /// # Errors
    /// A number that is not in its range.
    pub fn new(roughness: f32, ior: f32, energy_compensation: bool) -> Result<Self, ParameterError> {
        let alpha = Ggx::new(check("roughness", roughness, 0.0, 1.0)?).alpha();
        let ior = check("ior", ior, 1.001, 10.0)?;
        let Tables { transmittance, internal, mean_transmittance } = tables(alpha, ior, energy_compensation);
        // Nodes t, cos = t^2: the table is smooth in the root of the cosine.
        let mean =
            |&(t, weight): &(f64, f64)| 4.0 * t * t * t * weight * f64::from(transmittance.value((t * t) as f32));
        Ok(Self {
            reflected: 1.0 - mean_transmittance.value,
            entered: GAUSS.nodes.iter().map(mean).sum(),
            internal: internal.value,
            ior: f64::from(ior),
        })
    }

    /// The share of white light from all sides that leaves a plastic by way of its base of reflectance `base`, 0..1:
    /// `base entered^2 / (ior^2 (1 - base internal))`.
    #[must_use]
    pub fn diffuse_albedo(&self, base: f64) -> f64 {
        base * self.entered * self.entered / (self.ior * self.ior * (1.0 - base * self.internal))
    }

    /// The base, 0 or more, whose [`Exchange::diffuse_albedo`] is `albedo`; above 1 where no base shows so much.
    #[must_use]
    pub fn base_of(&self, albedo: f64) -> f64 {
        let once = self.entered * self.entered / (self.ior * self.ior);
        albedo / (once + albedo * self.internal)
    }

    /// The reflectance, 0..1, of a base that shows the same diffuse albedo where its light crosses the boundary once: below
    /// a lobe that leaves `1 - reflected` to it, without reflection from inside.
    ///
    /// With energy compensation, and in the limit of a smooth boundary, `entered = 1 - reflected = ior^2 (1 - internal)`,
    /// and this is `base (1 - internal) / (1 - base internal)`.
    #[must_use]
    pub fn plain_colour(&self, base: f64) -> f64 {
        self.diffuse_albedo(base) / (1.0 - self.reflected)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean reflectance of a smooth boundary from outside (Walsh 1926, as Judd 1942 gives it).
    fn walsh(n: f64) -> f64 {
        let (n2, n4) = (n * n, n * n * n * n);
        0.5 + (n - 1.0) * (3.0 * n + 1.0) / (6.0 * (n + 1.0) * (n + 1.0))
            + n2 * (n2 - 1.0).powi(2) / (n2 + 1.0).powi(3) * libm::log((n - 1.0) / (n + 1.0))
            - 2.0 * n * n2 * (n2 + 2.0 * n - 1.0) / ((n2 + 1.0) * (n4 - 1.0))
            + 8.0 * n4 * (n4 + 1.0) / ((n2 + 1.0) * (n4 - 1.0).powi(2)) * libm::log(n)
    }

    #[test]
    fn a_smooth_boundary_is_walshs() {
        for n in [1.2, 1.5, 1.8, 2.4] {
            let found = Exchange::new(0.05, n as f32, true).unwrap();
            let outside = walsh(f64::from(n as f32));
            let inside = 1.0 - (1.0 - outside) / (n * n);
            assert!((found.reflected - outside).abs() < 1e-3, "{n}: {found:?} {outside}");
            assert!((found.internal - inside).abs() < 1e-3, "{n}: {found:?} {inside}");
            for base in [0.0, 0.2, 0.5, 0.9, 1.0] {
                let expected = base * (1.0 - inside) / (1.0 - base * inside);
                assert!((found.plain_colour(base) - expected).abs() < 2e-3, "{n} {base}: {found:?} {expected}");
                assert!((found.base_of(found.diffuse_albedo(base)) - base).abs() < 1e-12);
            }
        }
        // Saunderson 1942: a pigment of 0.5 below a boundary of index 1.5 looks as one of 0.288 would without.
        let found = Exchange::new(0.0, 1.5, true).unwrap().plain_colour(0.5);
        assert!((found - 0.288).abs() < 1e-3, "{found}");
    }

    /// Diffuse albedo over `b (1 - F_in) / (1 - b F_in) (1 - F_out)` of a smooth boundary, integrated over values of Mitsuba
    /// 3.9's `roughplastic` (ggx, nonlinear) with and without its base: (index, roughness, base, ratio).
    const ROUGH: [(f64, f64, f64, f64); 8] = [
        (1.3, 0.4, 0.5, 0.9594),
        (1.5, 0.2, 0.2, 1.0007),
        (1.5, 0.4, 0.5, 0.9578),
        (1.5, 0.6, 0.5, 0.8434),
        (1.5, 0.8, 0.8, 0.5377),
        (1.5, 0.6, 0.95, 0.6570),
        (1.8, 0.4, 0.8, 0.8793),
        (1.8, 0.8, 0.2, 0.7760),
    ];

    #[test]
    fn a_rough_boundary_is_the_reference_renderers() {
        for (vacuum, roughness, base, ratio) in ROUGH {
            let n = vacuum / 1.000_277;
            let outside = walsh(n);
            let inside = 1.0 - (1.0 - outside) / (n * n);
            let smooth = base * (1.0 - inside) / (1.0 - base * inside) * (1.0 - outside);
            let found = Exchange::new(roughness as f32, n as f32, false).unwrap().diffuse_albedo(base) / smooth;
            assert!((found - ratio).abs() < 2e-3, "{vacuum} {roughness} {base}: {found} {ratio}");
        }
    }
}
