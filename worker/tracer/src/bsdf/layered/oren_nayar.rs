//! Oren & Nayar 1994, "Generalization of Lambert's reflectance model": the qualitative model.

use glam::Vec3;

/// The factor that facets of scattered slope put on a diffuse reflectance.
///
/// It is at most 1.015 in the mean over `wi`, near grazing views and slopes about 0.2: the model gains that much.
#[derive(Clone, Copy, Debug)]
pub struct OrenNayar {
    a: f32,
    b: f32,
}

impl OrenNayar {
    /// Facets of slope `sigma`, in radians.
    pub fn new(sigma: f32) -> Self {
        let square = sigma * sigma;
        Self { a: 1.0 - 0.5 * square / (square + 0.33), b: 0.45 * square / (square + 0.09) }
    }

    /// `A + B max(0, cos dphi) sin max(theta) tan min(theta)`; 1 at sigma 0.
    #[inline]
    pub fn factor(&self, wo: Vec3, wi: Vec3) -> f32 {
        // sin_o sin_i cos dphi; the tangent of the lesser angle divides by the greater cosine.
        let together = wo.x * wi.x + wo.y * wi.y;
        self.a + self.b * together.max(0.0) / wo.z.max(wi.z)
    }
}
