//! Exact unpolarised Fresnel reflectances, seen from a medium of index 1 (Born & Wolf, "Principles of optics", 1.5 and 14.2).

use glam::Vec3;

/// Reflectance of a dielectric of relative index `ior > 1` at `cos` in `[0, 1]`.
#[inline(always)]
pub fn dielectric(cos: f32, ior: f32) -> f32 {
    // Inlined, the derivative costs nothing; one formula gives one set of bits with and without it.
    dielectric_with_derivative(cos, ior).0
}

/// [`dielectric`] and its derivative with respect to `ior`.
#[inline(always)]
pub fn dielectric_with_derivative(cos: f32, ior: f32) -> (f32, f32) {
    // `inside` is ior cos_t.
    let inside = (ior * ior - 1.0 + cos * cos).sqrt();
    let scaled = ior * ior * cos;
    let (inverse_s, inverse_p) = (1.0 / (cos + inside), 1.0 / (scaled + inside));
    let s = (cos - inside) * inverse_s;
    let p = (scaled - inside) * inverse_p;
    let d_inside = ior / inside;
    let d_s = -2.0 * cos * d_inside * inverse_s * inverse_s;
    let d_p = 2.0 * ior * cos * (2.0 * inside - ior * d_inside) * inverse_p * inverse_p;
    (0.5 * (s * s + p * p), s * d_s + p * d_p)
}

/// A complex index of refraction, one per colour channel.
#[derive(Clone, Copy, Debug)]
pub struct ComplexIndex {
    /// Real part, above 0.
    pub eta: Vec3,
    /// Extinction coefficient, at least 0.
    pub k: Vec3,
}

/// Reflectance of a conductor and its derivatives, each per colour channel.
#[derive(Clone, Copy, Debug)]
pub struct ConductorReflectance {
    /// The reflectance.
    pub value: Vec3,
    /// With respect to `eta`.
    pub d_eta: Vec3,
    /// With respect to `k`.
    pub d_k: Vec3,
}

/// The refracted wave's `eta cos_t`, a complex number `a + ib`, with `a^2 + b^2` and `a^2 - b^2`.
struct Refracted {
    difference: Vec3,
    modulus: Vec3,
    a: Vec3,
}

impl ComplexIndex {
    /// Reflectance at `cos` in `[0, 1]`.
    #[inline]
    pub fn reflectance(&self, cos: f32) -> Vec3 {
        let refracted = self.refract(cos);
        let (s, ratio) = reflect(cos, &refracted);
        0.5 * s * (1.0 + ratio)
    }

    /// Reflectance at `cos` in `[0, 1]` and its derivatives.
    #[inline]
    pub fn reflectance_with_derivatives(&self, cos: f32) -> ConductorReflectance {
        let refracted = self.refract(cos);
        let Refracted { difference, modulus, a } = refracted;
        let (s, ratio) = reflect(cos, &refracted);

        let (cos2, sin2) = (cos * cos, 1.0 - cos * cos);
        let cross = 2.0 * cos * a;
        let (sum_s, sum_p) = (modulus + cos2 + cross, modulus * cos2 + sin2 * sin2 + cross * sin2);
        // s = 1 - 2 cross / sum_s and ratio = 1 - 2 cross sin2 / sum_p, varied along (modulus, a).
        let slope = |d_modulus: Vec3, d_a: Vec3| {
            let d_cross = 2.0 * cos * d_a;
            let d_s = 2.0 * (cross * (d_modulus + d_cross) - d_cross * sum_s) / (sum_s * sum_s);
            let d_ratio =
                2.0 * sin2 * (cross * (d_modulus * cos2 + d_cross * sin2) - d_cross * sum_p) / (sum_p * sum_p);
            0.5 * (d_s * (1.0 + ratio) + s * d_ratio)
        };
        let d_modulus_d_eta = 2.0 * self.eta * (difference + 2.0 * self.k * self.k) / modulus;
        let d_modulus_d_k = 2.0 * self.k * (2.0 * self.eta * self.eta - difference) / modulus;
        ConductorReflectance {
            value: 0.5 * s * (1.0 + ratio),
            d_eta: slope(d_modulus_d_eta, (d_modulus_d_eta + 2.0 * self.eta) / (4.0 * a)),
            d_k: slope(d_modulus_d_k, (d_modulus_d_k - 2.0 * self.k) / (4.0 * a)),
        }
    }

    #[inline]
    fn refract(&self, cos: f32) -> Refracted {
        const TINY: Vec3 = Vec3::splat(1e-10);
        let product = self.eta * self.k;
        let difference = self.eta * self.eta - self.k * self.k - (1.0 - cos * cos);
        let modulus = sqrt(difference * difference + 4.0 * product * product).max(TINY);
        // Of a^2 = (modulus + difference) / 2 and b^2 = (modulus - difference) / 2, with a b = eta k, the larger has no
        // cancellation and gives the other.
        let larger = sqrt(0.5 * (modulus + difference.abs()));
        let a = Vec3::select(difference.cmpge(Vec3::ZERO), larger, product / larger).max(TINY);
        Refracted { difference, modulus, a }
    }
}

/// Reflectance of s-polarised light, and the ratio of p to s.
#[inline]
fn reflect(cos: f32, refracted: &Refracted) -> (Vec3, Vec3) {
    let (cos2, sin2) = (cos * cos, 1.0 - cos * cos);
    let cross = 2.0 * cos * refracted.a;
    let (even_s, even_p) = (refracted.modulus + cos2, refracted.modulus * cos2 + sin2 * sin2);
    ((even_s - cross) / (even_s + cross), (even_p - cross * sin2) / (even_p + cross * sin2))
}

#[inline]
fn sqrt(v: Vec3) -> Vec3 {
    Vec3::new(v.x.sqrt(), v.y.sqrt(), v.z.sqrt())
}
