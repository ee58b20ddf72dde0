//! The transmittance of a rough boundary by the reference renderer's own rule.
//!
//! Mitsuba 3 integrates it with 32 x 32 Gauss-Legendre nodes on the unit square, mapped to visible normals, for each of 64
//! equally spaced cosines, and interpolates linearly. The rule's error, some 3e-4 of the integral, is larger than what
//! tells two renders apart. So `plastic` without energy compensation, which is checked against those renders, takes the
//! same nodes.

use std::f64::consts::FRAC_PI_4;
use std::sync::LazyLock;

use super::dual::Dual;
use super::quadrature::Rule;

/// Cosines at which the transmittance is tabulated: `0, 1/63, ... 1`.
pub const COSINES: usize = 64;
/// The cosine that stands for 0, where the mapping divides by zero.
const GRAZING: f64 = 1e-6;
/// Gauss-Legendre nodes along each side of the square.
const SIDE: usize = 32;
/// Nodes evaluated side by side, so that the compiler uses vector instructions.
const LANES: usize = 8;

/// The nodes of half of the square, as the other half mirrors it across the plane of incidence.
static NODES: LazyLock<Vec<Block>> = LazyLock::new(blocks);

/// `LANES` points `(x, y)` of the unit disk; x is across the plane of incidence.
#[derive(Clone, Copy, Default)]
struct Block {
    /// `sqrt(1 - x^2)`.
    chord: [f64; LANES],
    /// `y - sqrt(1 - x^2)`.
    drop: [f64; LANES],
    weight: [f64; LANES],
}

fn blocks() -> Vec<Block> {
    let rule = Rule::<SIDE>::gauss_legendre();
    let mut points = Vec::with_capacity(SIDE * SIDE / 2);
    for &(u, u_weight) in rule.nodes.iter().filter(|(u, _)| *u > 0.5) {
        for &(v, v_weight) in &rule.nodes {
            let (x, y) = concentric_disk(2.0 * u - 1.0, 2.0 * v - 1.0);
            let chord = (1.0 - x * x).sqrt();
            points.push((chord, y - chord, 2.0 * u_weight * v_weight));
        }
    }
    let mut blocks = Vec::with_capacity(points.len() / LANES);
    for chunk in points.chunks_exact(LANES) {
        let mut block = Block::default();
        for (lane, &(chord, drop, weight)) in chunk.iter().enumerate() {
            (block.chord[lane], block.drop[lane], block.weight[lane]) = (chord, drop, weight);
        }
        blocks.push(block);
    }
    blocks
}

/// The square `[-1, 1]^2` to the unit disk, keeping neighbours together (Shirley & Chiu 1997).
fn concentric_disk(x: f64, y: f64) -> (f64, f64) {
    if x.abs() < y.abs() {
        let angle = FRAC_PI_4 * (x / y);
        (y * libm::sin(angle), y * libm::cos(angle))
    } else {
        let angle = FRAC_PI_4 * (y / x);
        (x * libm::cos(angle), x * libm::sin(angle))
    }
}

/// The transmittance at cosines `0, 1/63, ... 1` of a boundary of GGX roughness `alpha` over a medium of index `ior > 1`.
pub fn transmittances(alpha: f64, ior: f64) -> [Dual; COSINES] {
    let nodes: &[Block] = &NODES;
    std::array::from_fn(|i| {
        let view = View::new((i as f64 / (COSINES - 1) as f64).max(GRAZING), alpha, ior);
        let mut sums = [[0.0; LANES]; 3];
        for block in nodes {
            // By index: iterators over the six arrays hide from the compiler that all have one length.
            #[allow(clippy::needless_range_loop)]
            for lane in 0..LANES {
                let weight = block.weight[lane];
                let through = view.transmittance(block.chord[lane], block.drop[lane]);
                sums[0][lane] += weight * through.value;
                sums[1][lane] += weight * through.d_alpha;
                sums[2][lane] += weight * through.d_ior;
            }
        }
        let [value, d_alpha, d_ior] = sums.map(|lanes| lanes.iter().sum());
        Dual { value, d_alpha, d_ior }
    })
}

/// What the nodes of one cosine share. A name `d_x` is the derivative of `x` with respect to alpha.
struct View {
    alpha: f64,
    ior: f64,
    cos: f64,
    /// Length of the view after stretching the surface to alpha 1.
    length: f64,
    d_length: f64,
    /// The stretched view, a unit vector in the plane of incidence.
    up: f64,
    d_up: f64,
    along: f64,
    d_along: f64,
}

impl View {
    fn new(cos: f64, alpha: f64, ior: f64) -> Self {
        let sin = (1.0 - cos * cos).sqrt();
        let length = (alpha * alpha * sin * sin + cos * cos).sqrt();
        let d_length = alpha * sin * sin / length;
        let (up, along) = (cos / length, alpha * sin / length);
        let (d_up, d_along) = (-up * d_length / length, (sin - along * d_length) / length);
        Self { alpha, ior, cos, length, d_length, up, d_up, along, d_along }
    }

    /// `(1 - F) G1(refracted)` at the visible normal of a point of the disk (Heitz 2018, "Sampling the GGX distribution of
    /// visible normals").
    ///
    /// Derivatives by hand: as [`Dual`] numbers it takes three times as long.
    #[inline(always)]
    fn transmittance(&self, chord: f64, drop: f64) -> Dual {
        let (alpha, ior) = (self.alpha, self.ior);
        let (alpha2, rest2, inverse_ior) = (alpha * alpha, 1.0 - alpha * alpha, 1.0 / ior);

        // The facet's normal in the stretched frame of the view: x across, y along, z to the viewer.
        let y = chord + 0.5 * (1.0 + self.up) * drop;
        let d_y = 0.5 * self.d_up * drop;
        let z = ((chord - y) * (chord + y)).sqrt();
        let d_z = -y * d_y / z;

        // Its component along the mean normal, and 1 / length^2 once the surface is unstretched.
        let normal = self.along * y + self.up * z;
        let d_normal = self.d_along * y + self.along * d_y + self.d_up * z + self.up * d_z;
        let square = alpha2 + rest2 * normal * normal;
        let d_square = 2.0 * (alpha * (1.0 - normal * normal) + rest2 * normal * d_normal);
        let inverse = 1.0 / square;
        let d_inverse = -inverse * inverse * d_square;

        // Squared cosines to the facet: of the view, and of the refracted ray by Snell.
        let to_view = self.length * z;
        let d_to_view = self.d_length * z + self.length * d_z;
        let cos2_d = to_view * to_view * inverse;
        let d_cos2_d = 2.0 * to_view * d_to_view * inverse + to_view * to_view * d_inverse;
        let cos2_t = 1.0 - (1.0 - cos2_d) * inverse_ior * inverse_ior;
        let d_cos2_t = d_cos2_d * inverse_ior * inverse_ior;
        let d_ior_cos2_t = 2.0 * (1.0 - cos2_d) * inverse_ior * inverse_ior * inverse_ior;

        // Depth of the refracted ray below the surface.
        let root = (cos2_t * inverse).sqrt();
        let half_root = 0.5 / root;
        let product = to_view * normal * inverse;
        let d_product = (d_to_view * normal + to_view * d_normal) * inverse + to_view * normal * d_inverse;
        let below = root * normal + (self.cos - product) * inverse_ior;
        let d_below =
            (d_cos2_t * inverse + cos2_t * d_inverse) * half_root * normal + root * d_normal - d_product * inverse_ior;
        let d_ior_below =
            d_ior_cos2_t * inverse * half_root * normal - (self.cos - product) * inverse_ior * inverse_ior;

        let depth = below.max(0.0);
        let stretched = (alpha2 + rest2 * depth * depth).sqrt();
        let scale = 1.0 / (depth + stretched);
        let smith = 2.0 * depth * scale;
        let smith_slope = 2.0 * alpha * scale * scale / stretched;
        let d_smith = smith_slope * (alpha * d_below - depth * (1.0 - depth * depth));
        let d_ior_smith = smith_slope * alpha * d_ior_below;

        // Fresnel's equations in the ratio of the cosines.
        let ratio = (cos2_t / cos2_d).sqrt();
        let ratio_slope = 0.5 / (ratio * cos2_d);
        let d_ratio = (d_cos2_t - ratio * ratio * d_cos2_d) * ratio_slope;
        let d_ior_ratio = d_ior_cos2_t * ratio_slope;
        let (s_scale, p_scale) = (1.0 / (1.0 + ior * ratio), 1.0 / (ior + ratio));
        let (s, p) = ((1.0 - ior * ratio) * s_scale, (ior - ratio) * p_scale);
        let (s_slope, p_slope) = (2.0 * s * s_scale * s_scale, 2.0 * p * p_scale * p_scale);
        let entering = 1.0 - 0.5 * (s * s + p * p);
        let by_ratio = ior * (s_slope + p_slope);
        let by_ior = ratio * (s_slope - p_slope);

        // No facet sends light through above the horizon; the factor is continuous there.
        let visible = if below > 0.0 { 1.0 } else { 0.0 };
        Dual {
            value: entering * smith,
            d_alpha: visible * (entering * d_smith + smith * by_ratio * d_ratio),
            d_ior: visible * (entering * d_ior_smith + smith * (by_ratio * d_ior_ratio + by_ior)),
        }
    }
}
