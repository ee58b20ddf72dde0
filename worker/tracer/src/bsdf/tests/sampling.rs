//! The mean of value / pdf over draws is the albedo: checked where the lobes are too narrow for bins.

use glam::Vec3;

use super::super::Bsdf;
use super::{Random, direction, furnace, gold, integrate_lobe, plastic};

const DRAWS: usize = 200_000;

/// Mean weight of a draw and its standard error.
fn mean_weight(bsdf: &Bsdf, wo: Vec3, random: &mut Random) -> (f64, f64) {
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..DRAWS {
        let weight = bsdf.sample(wo, random.three()).map_or(0.0, |s| f64::from(s.value.y / s.pdf));
        sum += weight;
        squares += weight * weight;
    }
    let (n, mean) = (DRAWS as f64, sum / DRAWS as f64);
    (mean, ((squares / n - mean * mean) / n).max(0.0).sqrt())
}

fn agree(name: &str, bsdf: &Bsdf, wo: Vec3, albedo: f32, random: &mut Random) {
    let (mean, error) = mean_weight(bsdf, wo, random);
    let difference = (mean - f64::from(albedo)).abs();
    // The quadratures are good to 2e-4.
    assert!(difference < 4.0 * error + 2e-4, "{name} cos {}: {mean} +- {error}, quadrature {albedo}", wo.z);
}

#[test]
fn weights_average_to_the_albedo() {
    let mut random = Random(3);
    for alpha in [1e-3, 0.01, 0.05, 0.25, 1.0] {
        for cos in [0.05, 0.4, 0.9, 1.0] {
            let wo = direction(cos, 2.0);
            let metal = gold(alpha);
            let albedo = integrate_lobe(wo, alpha, |wi| metal.evaluate(wo, wi).value).y;
            agree(&format!("conductor {alpha}"), &metal, wo, albedo, &mut random);
            for compensated in [false, true] {
                let coated = plastic(Vec3::splat(0.7), alpha, 1.5, compensated);
                let black = plastic(Vec3::ZERO, alpha, 1.5, compensated);
                let albedo = furnace(wo, alpha, &black, &coated).y;
                agree(&format!("plastic {alpha} {compensated}"), &coated, wo, albedo, &mut random);
            }
        }
    }
}

/// Fireflies: no draw may weigh much more than the mean.
#[test]
fn weights_are_bounded() {
    let mut random = Random(4);
    for alpha in [1e-3, 0.05, 0.4, 1.0] {
        let models = [gold(alpha), plastic(Vec3::ONE, alpha, 1.5, true), plastic(Vec3::ZERO, alpha, 1.5, false)];
        for model in &models {
            for _ in 0..20_000 {
                if let Some(sample) = model.sample(random.direction(), random.three()) {
                    let weight = sample.value.max_element() / sample.pdf;
                    assert!(weight < 3.0, "alpha {alpha}: weight {weight}");
                }
            }
        }
    }
}
