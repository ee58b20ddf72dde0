//! A rough plastic from first principles, in double precision.

#![allow(clippy::disallowed_methods)] // An independent truth, whose last bits do not matter.

/// Index of refraction of the air that light comes from.
const AIR: f64 = 1.000_277;
/// Points of a quadrature along each of two axes.
const POINTS: u32 = 64;

type Vector = [f64; 3];

/// The numbers of a capture's `plastic`.
pub struct Plastic {
    pub base_color: [f64; 3],
    pub roughness: f64,
    pub ior: f64,
}

/// A plastic whose inner reflectance is known.
pub struct Prepared {
    base_color: [f64; 3],
    alpha: f64,
    /// Inside over outside.
    index: f64,
    /// What the base sees of its own light, reflected from inside.
    inner: f64,
}

impl Plastic {
    pub fn prepare(&self) -> Prepared {
        let (alpha, index) = (self.roughness * self.roughness, self.ior / AIR);
        let cosine = |i: u32| (f64::from(i) + 0.5) / f64::from(POINTS);
        let reflected = |mu: f64| mean(mu, alpha, |f, _, reflected| f * reflected, 1.0 / index);
        let inner = (0..POINTS).map(|i| 2.0 * cosine(i) * reflected(cosine(i))).sum::<f64>() / f64::from(POINTS);
        Prepared { base_color: self.base_color, alpha, index, inner }
    }
}

impl Prepared {
    /// The BRDF for theta and phi of incidence and of reflection, 1/sr.
    pub fn brdf(&self, [ti, pi, to, po]: [f64; 4]) -> [f64; 3] {
        let unit = |t: f64, p: f64| [t.sin() * p.cos(), t.sin() * p.sin(), t.cos()];
        let (i, o) = (unit(ti, pi), unit(to, po));
        let h = normal([i[0] + o[0], i[1] + o[1], i[2] + o[2]]);
        let a2 = self.alpha * self.alpha;
        let slope = h[2] * h[2] * (a2 - 1.0) + 1.0;
        let ggx = a2 / (std::f64::consts::PI * slope * slope);
        let shadowing = smith(i[2], self.alpha) * smith(o[2], self.alpha);
        let facets = fresnel(dot(i, h), self.index).0 * ggx * shadowing / (4.0 * i[2] * o[2]);
        let through = |mu: f64| mean(mu, self.alpha, |f, transmitted, _| (1.0 - f) * transmitted, self.index);
        let both = through(i[2]) * through(o[2]) / (std::f64::consts::PI * self.index * self.index);
        self.base_color.map(|c| facets + both * c / (1.0 - c * self.inner))
    }
}

/// The mean over the facets that a direction of cosine `mu` sees of `value`(Fresnel reflectance, shadowing of the refracted
/// direction, shadowing of the reflected one); facets after Heitz, "Sampling the GGX Distribution of Visible Normals" (2018).
fn mean(mu: f64, alpha: f64, value: impl Fn(f64, f64, f64) -> f64, index: f64) -> f64 {
    let view = [(1.0 - mu * mu).sqrt(), 0.0, mu];
    let stretched = normal([alpha * view[0], 0.0, view[2]]);
    let side = [-stretched[2], 0.0, stretched[0]];
    let mut sum = 0.0;
    for i in 0..POINTS {
        for j in 0..POINTS {
            let (u, v) = ((f64::from(i) + 0.5) / f64::from(POINTS), (f64::from(j) + 0.5) / f64::from(POINTS));
            let (r, phi) = (u.sqrt(), std::f64::consts::TAU * v);
            let (along, mut across) = (r * phi.cos(), r * phi.sin());
            let share = 0.5 * (1.0 + stretched[2]);
            across = (1.0 - share) * (1.0 - along * along).sqrt() + share * across;
            let up = (1.0 - along * along - across * across).max(0.0).sqrt();
            let point = [across * side[0] + up * stretched[0], along, across * side[2] + up * stretched[2]];
            let facet = normal([alpha * point[0], alpha * point[1], point[2].max(1e-9)]);
            let c = dot(view, facet);
            let (f, inside) = fresnel(c, index);
            let reflected = 2.0 * c * facet[2] - view[2];
            // Refraction: the part along the facet's normal turns over.
            let refracted = (c / index - inside) * facet[2] - view[2] / index;
            let lit = |cosine: f64| if cosine > 0.0 { smith(cosine, alpha) } else { 0.0 };
            sum += value(f, lit(-refracted), lit(reflected));
        }
    }
    sum / f64::from(POINTS * POINTS)
}

/// Reflectance of a dielectric whose far side has `index` times the near side's, and the cosine there.
fn fresnel(cosine: f64, index: f64) -> (f64, f64) {
    let square = 1.0 - (1.0 - cosine * cosine) / (index * index);
    if square <= 0.0 {
        return (1.0, 0.0);
    }
    let inside = square.sqrt();
    let s = (cosine - index * inside) / (cosine + index * inside);
    let p = (index * cosine - inside) / (index * cosine + inside);
    (0.5 * (s * s + p * p), inside)
}

/// Smith's shadowing of one direction.
fn smith(cosine: f64, alpha: f64) -> f64 {
    let tangent = (1.0 - cosine * cosine).max(0.0) / (cosine * cosine);
    2.0 / (1.0 + (1.0 + alpha * alpha * tangent).sqrt())
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn normal(v: Vector) -> Vector {
    let length = dot(v, v).sqrt();
    v.map(|c| c / length)
}
