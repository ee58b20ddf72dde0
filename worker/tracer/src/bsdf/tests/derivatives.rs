//! Derivatives of the value against central differences of freshly built models, for every slot of every model.

use glam::Vec3;

use super::super::{Bsdf, Conductor, Lambert, Plastic, SlotKind};
use super::{GOLD_ETA, GOLD_K, Random};

/// Parameters in the order of the slots.
type Build = fn(&[Vec3]) -> Bsdf;

/// Compares at random pairs of directions, half of them near the mirror direction, where the lobe lives.
///
/// A step of 0.1 % leaves 1e-4 of rounding. A longer one smooths the saw tooth that the reference renderer's rule has over
/// alpha (see `aliasing`), which the derivatives follow.
fn check(name: &str, build: Build, parameters: &[Vec3]) {
    let mut random = Random(9);
    let bsdf = build(parameters);
    for (index, slot) in bsdf.slots().iter().enumerate() {
        let (mut upper, mut lower) = (parameters.to_vec(), parameters.to_vec());
        let step = 0.001 * parameters[index];
        upper[index] += step;
        lower[index] -= step;
        let (above, below) = (build(&upper), build(&lower));
        for round in 0..400 {
            let wo = random.direction();
            let mut wi = random.direction();
            if round % 2 == 0 {
                let mirror = Vec3::new(-wo.x, -wo.y, wo.z);
                wi = (mirror + 0.2 * wi).normalize();
            }
            let mut derivatives = [Vec3::NAN; 3];
            let evaluation = bsdf.evaluate_with_derivatives(wo, wi, &mut derivatives);
            assert_eq!(evaluation, bsdf.evaluate(wo, wi));
            let exact = derivatives[index];
            let difference =
                (above.evaluate(wo, wi).value - below.evaluate(wo, wi).value) / (upper[index] - lower[index]);
            // Where a derivative changes sign, its error is measured against the value over the parameter.
            let tolerance = 0.01 * difference.abs() + 1e-3 * evaluation.value / parameters[index];
            assert!(
                (exact - difference).abs().cmple(tolerance).all(),
                "{name} d/d {}: {exact}, by differences {difference} at wo {wo} wi {wi}",
                slot.name
            );
            if slot.kind == SlotKind::Scalar {
                assert_eq!(parameters[index], Vec3::splat(parameters[index].x), "a scalar is given three times");
            }
        }
    }
}

#[test]
fn lambert() {
    check("lambert", |p| Bsdf::Lambert(Lambert::new(p[0]).unwrap()), &[Vec3::new(0.9, 0.5, 0.1)]);
}

#[test]
fn plastic() {
    let plain: Build = |p| Bsdf::Plastic(Plastic::new(p[0], p[1].x, p[2].x, false).unwrap());
    let compensated: Build = |p| Bsdf::Plastic(Plastic::new(p[0], p[1].x, p[2].x, true).unwrap());
    for (name, build) in [("plastic", plain), ("compensated plastic", compensated)] {
        for roughness in [0.1, 0.2, 0.4, 0.7, 0.99] {
            for ior in [1.2, 1.5, 2.4] {
                let parameters = [Vec3::new(0.95, 0.5, 0.05), Vec3::splat(roughness), Vec3::splat(ior)];
                check(&format!("{name} roughness {roughness} ior {ior}"), build, &parameters);
            }
        }
    }
}

#[test]
fn conductor() {
    let build: Build = |p| Bsdf::Conductor(Conductor::new(p[2].x, p[0], p[1]).unwrap());
    for roughness in [0.1, 0.2, 0.4, 0.7, 0.99] {
        for (eta, k) in [(GOLD_ETA, GOLD_K), (Vec3::new(0.05, 1.5, 3.0), Vec3::new(4.0, 0.1, 3.0))] {
            check(&format!("conductor roughness {roughness}"), build, &[eta, k, Vec3::splat(roughness)]);
        }
    }
}

/// Below the floor of alpha the roughness has no effect, and says so.
#[test]
fn no_derivative_on_the_floor() {
    let mut derivatives = [Vec3::NAN; 3];
    let bsdf = Bsdf::Plastic(Plastic::new(Vec3::splat(0.5), 0.01, 1.5, false).unwrap());
    bsdf.evaluate_with_derivatives(Vec3::Z, Vec3::Z, &mut derivatives);
    assert_eq!(derivatives[1], Vec3::ZERO);
}
