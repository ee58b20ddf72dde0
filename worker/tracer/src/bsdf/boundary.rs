//! Integrals over a rough dielectric boundary: how much light it lets through and turns back, after one scattering.
//!
//! All are pure functions of (alpha, index of refraction) and carry their derivatives along as [`Dual`] numbers. The
//! boundary is a GGX surface with separable Smith shadowing and the exact unpolarised Fresnel reflectance (Walter et al.
//! 2007, "Microfacet models for refraction through rough surfaces").

use std::f64::consts::FRAC_1_PI;

use super::aliasing;
use super::dual::Dual;
use super::quadrature::{GAUSS, GAUSS_TO_BOTH, GAUSS_TO_ONE, QUARTER_CIRCLE};

/// Number of cosines at which Mitsuba 3 averages the internal reflectance.
const REFERENCE_NODES: f64 = 64.0;

/// A rough boundary between air above and a denser medium below.
#[derive(Clone, Copy, Debug)]
pub struct RoughBoundary {
    alpha: Dual,
    ior: Dual,
}

impl RoughBoundary {
    /// A boundary of GGX roughness `alpha` in `(0, 1]` over a medium of index `ior > 1`.
    pub fn new(alpha: f64, ior: f64) -> Self {
        Self { alpha: Dual::alpha(alpha), ior: Dual::ior(ior) }
    }

    /// The part of a parallel beam from outside, at `cos` from the normal, that leaves again after one reflection.
    ///
    /// Mean over the visible normals of `F G1(reflected)`.
    pub fn reflectance(&self, cos: f64) -> Dual {
        let view = View::new(cos, self.alpha);
        let widest = view.widest();
        let mut sum = Dual::default();
        for &(s, s_weight) in &GAUSS_TO_ONE.nodes {
            let y = widest * s;
            let (low, high) = view.above_horizon(y);
            let span = high - low;
            let mut inner = Dual::default();
            for &(t, t_weight) in &GAUSS_TO_BOTH.nodes {
                let (cos_d, cos_h) = view.facet(y, span * t + low);
                let above = cos_d * cos_h * 2.0 - cos;
                // Below by rounding only.
                if above.value > 0.0 {
                    inner = inner + fresnel(cos_d, self.refract(cos_d), self.ior) * self.smith(above) * t_weight;
                }
            }
            sum = sum + inner * span * (-y.square() + 1.0).sqrt() * (4.0 * FRAC_1_PI * s_weight);
        }
        sum * widest / (view.up.z + 1.0)
    }

    /// Cosine-weighted mean of [`Self::reflectance`] over the hemisphere.
    ///
    /// In half-angle coordinates (Rusinkiewicz 1998; `d omega_i d omega_o = 4 cos_d d omega_h d omega_d`) the double
    /// integral falls apart into the Fresnel reflectance and a purely geometric factor.
    pub fn mean_reflectance_outside(&self) -> Dual {
        let mut sum = Dual::default();
        for &(t, weight) in &GAUSS.nodes {
            // cos_d = t^2: the geometric factor varies over cos_d ~ alpha.
            let cos_d = Dual::constant(t * t);
            let reflected = fresnel(cos_d, self.refract(cos_d), self.ior);
            sum = sum + reflected * self.geometric_factor(cos_d) * (4.0 * t * t * t * weight);
        }
        sum
    }

    /// Cosine-weighted mean of the single-scattering reflectance seen from inside the medium.
    pub fn mean_reflectance_inside(&self) -> Dual {
        let critical = self.refract(Dual::constant(0.0));
        let mut total = Dual::default();
        let mut partial = Dual::default();
        for &(t, weight) in &GAUSS.nodes {
            total = total + self.geometric_factor(critical * (t * t)) * (4.0 * t * t * t * weight);
            // Above the critical angle the cosine outside is the smooth variable: cos dcos = cos_t dcos_t / ior^2.
            let cos_t = Dual::constant(t * t);
            let cos_d = self.refract(cos_t);
            let reflected = fresnel(cos_t, cos_d, self.ior);
            partial = partial + reflected * self.geometric_factor(cos_d) * (4.0 * t * t * t * weight);
        }
        total * critical.square() + partial / self.ior.square()
    }

    /// [`Self::mean_reflectance_inside`] as the reference renderer computes it.
    ///
    /// Mitsuba 3 takes the plain mean of `2 cos R(cos)` over 64 cosines `0, 1/63, ... 1`. That gives both end points full
    /// weight where the trapezoidal rule gives half, so it is `(63 mean + R(1)) / 64`: about 1.5 % less than the integral,
    /// and the base of a white part 1 to 2.5 % darker; and its rule for R has an error (see [`aliasing`]). Its renders are
    /// what `plastic` is checked against.
    pub fn mean_reflectance_inside_as_reference(&self) -> Dual {
        let mean = self.mean_reflectance_inside();
        let exact = (mean * (REFERENCE_NODES - 1.0) + self.normal_reflectance_inside()) * (1.0 / REFERENCE_NODES);
        exact * aliasing::internal_reflectance_factor(self.alpha.value)
    }

    /// Single-scattering reflectance from inside, along the normal.
    fn normal_reflectance_inside(&self) -> Dual {
        // Visible normals are uniform in u = tan^2 / (tan^2 + alpha^2). Reflection is total past the critical angle, where
        // the integrand has a kink, and goes down past 45 degrees.
        let uniform = |tan2: Dual| tan2 / (tan2 + self.alpha.square());
        let end = uniform(Dual::constant(1.0));
        let critical = uniform(Dual::constant(1.0) / (self.ior.square() - 1.0));
        let turn = if critical.value < end.value { critical } else { end };
        let integrand = |u: Dual| {
            let cos_d = (Dual::constant(1.0) / (u * self.alpha.square() / (-u + 1.0) + 1.0)).sqrt();
            let sin2_t = (-cos_d.square() + 1.0) * self.ior.square();
            let reflected = if sin2_t.value < 1.0 {
                let cos_t = (-sin2_t + 1.0).sqrt();
                fresnel(cos_t, cos_d, self.ior)
            } else {
                Dual::constant(1.0)
            };
            reflected * self.smith(cos_d.square() * 2.0 - 1.0)
        };
        let mut sum = Dual::default();
        for &(t, weight) in &GAUSS_TO_ONE.nodes {
            sum = sum + integrand(turn * t) * turn * weight;
            sum = sum + integrand(turn + (end - turn) * t) * (end - turn) * weight;
        }
        sum
    }

    /// Mean over the azimuth of `integral D(h) G1(o) G1(i) d omega_h` for a difference angle of cosine `cos_d`.
    fn geometric_factor(&self, cos_d: Dual) -> Dual {
        let cos2 = cos_d.square();
        let sin2 = -cos2 + 1.0;
        let alpha2 = self.alpha.square();
        let mut sum = Dual::default();
        for &(sin_phi, phi_weight) in &QUARTER_CIRCLE.nodes {
            let across = sin2 * (sin_phi * sin_phi);
            // u as above; the integral ends where either direction sinks below the horizon.
            let scale = Dual::constant(1.0) / (cos2 + alpha2 * across);
            let end = cos2 * scale;
            let rest = alpha2 * across * scale;
            let mut inner = Dual::default();
            for &(t, t_weight) in &GAUSS_TO_ONE.nodes {
                let tan2 = alpha2 * end * t / (rest + end * (1.0 - t));
                let cos_h = (Dual::constant(1.0) / (tan2 + 1.0)).sqrt();
                let lean = (across * tan2).sqrt();
                let up = cos_h * (cos_d + lean);
                let down = cos_h * (cos_d - lean);
                inner = inner + self.smith(up) * self.smith(down) / cos_h * t_weight;
            }
            sum = sum + inner * end * phi_weight;
        }
        sum
    }

    /// Cosine inside of a ray at `cos` outside: Snell's law. At grazing, `cos` 0, it is that of the critical angle.
    fn refract(&self, cos: Dual) -> Dual {
        (-((-cos.square() + 1.0) / self.ior.square()) + 1.0).sqrt()
    }

    /// Smith's masking function G1 of GGX at a positive cosine.
    fn smith(&self, cos: Dual) -> Dual {
        let cos2 = cos.square();
        cos * 2.0 / (cos + (cos2 + self.alpha.square() * (-cos2 + 1.0)).sqrt())
    }
}

/// A view direction in the xz plane, and the normals that it sees.
///
/// Where the surface is stretched to alpha 1, its normals are uniform on the hemisphere and those visible have the density
/// `max(0, view . h)` (Heitz 2018, "Sampling the GGX distribution of visible normals"). Slices across the plane of
/// incidence make it a product: with `h = (sqrt(1 - y^2) sin psi, y, sqrt(1 - y^2) cos psi)` and `q` the sine of `psi`
/// counted from the view, it is `sqrt(1 - y^2) dy dq`, over `y` in `[-1, 1]` and `q` in `[-1, view.z]`.
struct View {
    alpha: Dual,
    cos: f64,
    sin: f64,
    /// The stretched view.
    up: Stretched,
}

struct Stretched {
    x: Dual,
    z: Dual,
}

impl View {
    fn new(cos: f64, alpha: Dual) -> Self {
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let length = ((alpha * sin).square() + cos * cos).sqrt();
        Self { alpha, cos, sin, up: Stretched { x: alpha * sin / length, z: Dual::constant(cos) / length } }
    }

    /// Cosines of a facet's normal: to the view, and to the mean normal.
    fn facet(&self, y: Dual, q: Dual) -> (Dual, Dual) {
        let radius = (-y.square() + 1.0).sqrt();
        let rest = (-q.square() + 1.0).sqrt();
        let x = self.alpha * radius * (q * self.up.z + rest * self.up.x);
        let z = radius * (rest * self.up.z - q * self.up.x);
        let inverse = Dual::constant(1.0) / (x.square() + (self.alpha * y).square() + z.square()).sqrt();
        ((x * self.sin + z * self.cos) * inverse, z * inverse)
    }

    /// The range of `q` in slice `y` in which the mirrored view is above the horizon.
    ///
    /// In slopes those facets fill the disk `cos (x^2 + y^2) - 2 sin x - cos < 0`; in a slice it is a quadratic in
    /// `tan psi`. Integrals that end there, where G1 is zero, have no kink inside.
    fn above_horizon(&self, y: Dual) -> (Dual, Dual) {
        let alpha2 = self.alpha.square();
        let across = y.square() / (-y.square() + 1.0);
        let a = alpha2 * (across + 1.0) * self.cos;
        let b = self.alpha * self.sin;
        let c = (alpha2 * across - 1.0) * self.cos;
        let sum = b + (b.square() - a * c).sqrt();
        let q = |tan: Dual| (tan * self.up.z - self.up.x) / (tan.square() + 1.0).sqrt();
        (q(c / sum), q(sum / a))
    }

    /// The `y` at which [`Self::above_horizon`] becomes empty.
    fn widest(&self) -> Dual {
        let alpha2 = self.alpha.square();
        let rest = -alpha2 + 1.0;
        let root = (rest.square() + alpha2 * (4.0 / (self.cos * self.cos))).sqrt();
        let across = (rest + root) / (alpha2 * 2.0);
        (across / (across + 1.0)).sqrt()
    }
}

/// Unpolarised Fresnel reflectance between cosine `cos_i` outside and `cos_t` inside; the same in both directions.
fn fresnel(cos_i: Dual, cos_t: Dual, ior: Dual) -> Dual {
    let (across, along) = (ior * cos_t, ior * cos_i);
    let s = (cos_i - across) / (cos_i + across);
    let p = (along - cos_t) / (along + cos_t);
    (s.square() + p.square()) * 0.5
}
