//! The boundary's integrals against a brute-force quadrature over all normals, visible or not.

use super::super::boundary::RoughBoundary;
use super::super::dual::Dual;
use super::super::reference;
use super::super::table::AngularTable;

/// Fresnel reflectance from cosines by Snell and the textbook ratios, total reflection included.
fn fresnel(cos_i: f64, relative_ior: f64) -> (f64, f64) {
    let sin2_t = (1.0 - cos_i * cos_i) / (relative_ior * relative_ior);
    if sin2_t >= 1.0 {
        return (1.0, 0.0);
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    let s = (cos_i - relative_ior * cos_t) / (cos_i + relative_ior * cos_t);
    let p = (relative_ior * cos_i - cos_t) / (relative_ior * cos_i + cos_t);
    (0.5 * (s * s + p * p), cos_t)
}

fn smith(cos: f64, alpha: f64) -> f64 {
    2.0 / (1.0 + (1.0 + alpha * alpha * (1.0 - cos * cos) / (cos * cos)).sqrt())
}

/// (transmittance, reflectance) at `cos`, by the midpoint rule over slopes, with the visible-normal weight
/// `G1 max(0, o.h) / (cos_o cos_h)` of the projected distribution.
fn brute_force(cos: f64, alpha: f64, relative_ior: f64, rings: u32, sectors: u32) -> (f64, f64) {
    let sin = (1.0 - cos * cos).sqrt();
    let azimuth = |j: u32| libm::cos(std::f64::consts::PI * (f64::from(j) + 0.5) / f64::from(sectors));
    let azimuths: Vec<f64> = (0..sectors).map(azimuth).collect();
    let (mut transmitted, mut reflected) = (0.0, 0.0);
    for i in 0..rings {
        let rest = 1.0 - (f64::from(i) + 0.5) / f64::from(rings);
        // Cubed: the weight grows with the slope.
        let (one_minus_u, d_u) = (rest.powi(3), 3.0 * rest * rest);
        let tan = alpha * ((1.0 - one_minus_u) / one_minus_u).sqrt();
        let cos_h = 1.0 / (1.0 + tan * tan).sqrt();
        for &cos_phi in &azimuths {
            let cos_d = cos_h * (sin * tan * cos_phi + cos);
            if cos_d <= 0.0 {
                continue;
            }
            let (reflectance, cos_t) = fresnel(cos_d.min(1.0), relative_ior);
            let weight = d_u * cos_d / cos_h;
            let up = 2.0 * cos_d * cos_h - cos;
            let down = (cos_t - cos_d / relative_ior) * cos_h + cos / relative_ior;
            if up > 0.0 {
                reflected += weight * reflectance * smith(up, alpha);
            }
            if down > 0.0 {
                transmitted += weight * (1.0 - reflectance) * smith(down, alpha);
            }
        }
    }
    let scale = smith(cos, alpha) / (cos * f64::from(rings * sectors));
    (transmitted * scale, reflected * scale)
}

/// The transmittance tables without and with energy compensation.
fn tables(alpha: f64, ior: f64) -> [AngularTable; 2] {
    let boundary = RoughBoundary::new(alpha, ior);
    let compensated = AngularTable::smooth(|cos| -boundary.reflectance(cos) + 1.0);
    [AngularTable::linear(&reference::transmittances(alpha, ior)), compensated]
}

/// The reference renderer's rule has an error of its own, and more where it interpolates linearly near grazing.
#[test]
fn transmittance_and_reflectance() {
    for alpha in [0.01, 0.04, 0.15, 0.4, 1.0] {
        for ior in [1.2, 1.5, 2.5] {
            let [plain, compensated] = tables(alpha, ior);
            for cos in [0.004, 0.03, 0.11, 0.35, 0.72, 0.97] {
                let (transmitted, reflected) = brute_force(cos, alpha, ior, 1000, 500);
                let rule = if cos < 0.1 { 0.02 } else { 8e-4 };
                for (name, exact, table, tolerance) in
                    [("T", transmitted, &plain, rule), ("1 - R", 1.0 - reflected, &compensated, 2e-4)]
                {
                    let table = table.value(cos as f32);
                    let error = (f64::from(table) - exact).abs();
                    assert!(error < tolerance, "{name} alpha {alpha} ior {ior} cos {cos}: {table}, exactly {exact}");
                }
            }
        }
    }
}

/// On the floor of alpha the boundary is a polished one but for the last degrees.
#[test]
fn polished_limit() {
    for ior in [1.2, 1.5, 2.5] {
        for table in tables(1e-3, ior) {
            for cos in [0.1, 0.2, 0.5, 0.8, 1.0] {
                let exact = 1.0 - fresnel(cos, ior).0;
                let error = (f64::from(table.value(cos as f32)) - exact).abs();
                assert!(error < 2e-3, "ior {ior} cos {cos}: {error}");
            }
        }
    }
}

/// Cosine-weighted mean of the brute-force reflectance, by a rule of its own.
fn brute_force_mean(alpha: f64, relative_ior: f64) -> f64 {
    let n = 150;
    (0..n)
        .map(|i| {
            let cos = ((f64::from(i) + 0.5) / f64::from(n)).sqrt();
            brute_force(cos, alpha, relative_ior, 200, 120).1 / f64::from(n)
        })
        .sum()
}

#[test]
fn mean_reflectances() {
    for alpha in [0.01, 0.1, 0.4, 1.0] {
        for ior in [1.2, 1.5, 2.5] {
            let boundary = RoughBoundary::new(alpha, ior);
            let outside = boundary.mean_reflectance_outside().value;
            let inside = boundary.mean_reflectance_inside().value;
            for (name, value, exact) in [
                ("outside", outside, brute_force_mean(alpha, ior)),
                ("inside", inside, brute_force_mean(alpha, 1.0 / ior)),
            ] {
                assert!((value - exact).abs() < 3e-4, "{name} alpha {alpha} ior {ior}: {value}, exactly {exact}");
            }
        }
    }
}

/// A polished boundary's mean internal reflectance at index 1.5 is 0.5963, and outside 0.0918 (Egan & Hilgeman 1973).
#[test]
fn polished_means() {
    let boundary = RoughBoundary::new(1e-3, 1.5);
    assert!((boundary.mean_reflectance_inside().value - 0.5963).abs() < 2e-3);
    assert!((boundary.mean_reflectance_outside().value - 0.0918).abs() < 1e-3);
}

type Quantity = (&'static str, fn(f64, f64) -> Dual);

/// Every dual number's derivatives against central differences of its value.
#[test]
fn derivatives() {
    let quantities: [Quantity; 9] = [
        ("T(0)", |alpha, ior| reference::transmittances(alpha, ior)[0]),
        ("T(25/63)", |alpha, ior| reference::transmittances(alpha, ior)[25]),
        ("T(1)", |alpha, ior| reference::transmittances(alpha, ior)[63]),
        ("R(0.03)", |alpha, ior| RoughBoundary::new(alpha, ior).reflectance(0.03)),
        ("R(0.4)", |alpha, ior| RoughBoundary::new(alpha, ior).reflectance(0.4)),
        ("R(1)", |alpha, ior| RoughBoundary::new(alpha, ior).reflectance(1.0)),
        ("outside", |alpha, ior| RoughBoundary::new(alpha, ior).mean_reflectance_outside()),
        ("inside", |alpha, ior| RoughBoundary::new(alpha, ior).mean_reflectance_inside()),
        ("inside as reference", |alpha, ior| RoughBoundary::new(alpha, ior).mean_reflectance_inside_as_reference()),
    ];
    for (name, quantity) in quantities {
        for alpha in [0.01, 0.1, 0.3, 0.9] {
            for ior in [1.2, 1.5, 2.5] {
                let at = quantity;
                let dual = at(alpha, ior);
                let (h_alpha, h_ior) = (1e-3 * alpha, 1e-3);
                let d_alpha = (at(alpha + h_alpha, ior).value - at(alpha - h_alpha, ior).value) / (2.0 * h_alpha);
                let d_ior = (at(alpha, ior + h_ior).value - at(alpha, ior - h_ior).value) / (2.0 * h_ior);
                for (parameter, exact, difference, scale) in
                    [("alpha", dual.d_alpha, d_alpha, 1.0 / alpha), ("ior", dual.d_ior, d_ior, 1.0)]
                {
                    let error = (exact - difference).abs();
                    assert!(
                        error < 2e-3 * difference.abs() + 2e-4 * scale,
                        "d {name} / d {parameter} at alpha {alpha} ior {ior}: {exact}, by differences {difference}"
                    );
                }
            }
        }
    }
}
