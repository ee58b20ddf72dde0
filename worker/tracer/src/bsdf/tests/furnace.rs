//! Energy: what a surface returns under a uniform sky of radiance 1.

use glam::Vec3;

use super::super::quadrature::GAUSS;
use super::{direction, furnace, gold, integrate_lobe, integrate_smooth, lambert, plastic};

#[test]
fn lambert_returns_its_colour() {
    let color = Vec3::new(1.0, 0.5, 0.1);
    let returned = integrate_smooth(|wi| lambert(color).evaluate(Vec3::Z, wi).value);
    assert!((returned - color).abs().max_element() < 1e-4, "{returned}");
}

#[test]
fn compensated_white_plastic_returns_everything() {
    for alpha in [0.01, 0.03, 0.1, 0.25, 0.5, 1.0] {
        for ior in [1.2, 1.5, 2.0, 2.5] {
            let (white, black) = (plastic(Vec3::ONE, alpha, ior, true), plastic(Vec3::ZERO, alpha, ior, true));
            for cos in [0.005, 0.02, 0.1, 0.3, 0.6, 1.0] {
                let returned = furnace(direction(cos, 0.3), alpha, &black, &white).x;
                assert!((returned - 1.0).abs() < 5e-4, "alpha {alpha} ior {ior} cos {cos}: {returned}");
                assert!(returned < 1.0001, "alpha {alpha} ior {ior} cos {cos}: {returned}");
            }
        }
    }
}

#[test]
fn uncompensated_plastic_and_metal_never_gain() {
    for alpha in [0.01, 0.1, 0.5, 1.0] {
        for ior in [1.2, 1.5, 2.5] {
            let (white, black) = (plastic(Vec3::ONE, alpha, ior, false), plastic(Vec3::ZERO, alpha, ior, false));
            for cos in [0.02, 0.3, 1.0] {
                let wo = direction(cos, 0.3);
                let returned = furnace(wo, alpha, &black, &white).x;
                assert!(returned < 1.0001, "alpha {alpha} ior {ior} cos {cos}: {returned}");
                let metal = gold(alpha);
                let returned = integrate_lobe(wo, alpha, |wi| metal.evaluate(wo, wi).value).max_element();
                assert!(returned < 1.0001, "gold alpha {alpha} cos {cos}: {returned}");
            }
        }
    }
}

/// The loss of a white base at alpha 0.25 and index 1.5: the capture format's 0.74, and Mitsuba 3.9.1's values (midpoint
/// rule of 120 x 120 directions over `bsdf.eval`).
#[test]
fn uncompensated_white_plastic_loses_as_the_reference() {
    let (white, black) = (plastic(Vec3::ONE, 0.25, 1.5, false), plastic(Vec3::ZERO, 0.25, 1.5, false));
    for (cos, reference) in [(1.0, 0.7407), (0.6, 0.7298), (0.3, 0.7089)] {
        let returned = furnace(direction(cos, 0.0), 0.25, &black, &white).x;
        assert!((returned - reference).abs() < 5e-4, "cos {cos}: {returned}, Mitsuba {reference}");
    }
}

/// The same as a ball seen from far away, whose rim is darker than its middle.
#[test]
fn uncompensated_white_ball() {
    let (white, black) = (plastic(Vec3::ONE, 0.25, 1.5, false), plastic(Vec3::ZERO, 0.25, 1.5, false));
    let mean: f64 = GAUSS
        .nodes
        .iter()
        .map(|&(cos, weight)| {
            2.0 * cos * weight * f64::from(furnace(direction(cos as f32, 0.0), 0.25, &black, &white).x)
        })
        .sum();
    assert!((mean - 0.729).abs() < 1e-3, "{mean}");
}
