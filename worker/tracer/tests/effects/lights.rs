//! Lobes, small balls, lights that are off and environments that add up.

use crate::fixture::{SIDE, Text, distance, film, lamp, mean, plane, positions, radiance};
use gonio_scene::image::Image;
use gonio_tracer::Stage;
use std::sync::Arc;

const PLACE: [f64; 3] = [0.3, -0.2, 0.8];

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|v| v.to_bits()).collect()
}

fn lit(lights: String) -> Text {
    Text { lights, ..Text::default() }
}

#[test]
fn a_ball_without_radius_is_a_point() {
    let ball = lit(lamp("lamp", "sphere", PLACE, 1.0, "radius = 0")).render(4);
    assert_eq!(bits(&ball), bits(&lit(lamp("lamp", "point", PLACE, 1.0, "")).render(4)));
    let text = lit(lamp("lamp", "sphere", PLACE, 1.0, "radius = 0"));
    let stage = text.stage();
    let mut columns = text.columns(&["light.lamp.radius"]);
    columns[0].step = Some(0.005);
    let found = plane(&film(&stage.prepare(&[], &columns).unwrap(), 0, 4, 0), 1);
    let small = radiance(&stage.prepare(&[("light.lamp.radius".into(), 0.005)], &[]).unwrap(), 4);
    let expected: Vec<f64> = small.iter().zip(&ball).map(|(a, b)| (a - b) / 0.005).collect();
    assert!(distance(&found, &expected) < 1e-3, "{}", distance(&found, &expected));
}

/// A Lambertian ball is its surface's points, each a lamp of lobe 1 along its normal: penumbrae and all.
#[test]
fn a_ball_is_many_small_lamps() {
    let (radius, count) = (0.15, 300);
    let ball = lit(lamp("lamp", "sphere", PLACE, 1.0, &format!("radius = {radius}"))).render(1024);
    let mut sum = vec![0.0; ball.len()];
    for k in 0..count {
        // A Fibonacci spiral covers the ball evenly.
        let z = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(count);
        let (sin, cos) = libm::sincos(2.399_963_229_728_653 * f64::from(k));
        let across = (1.0 - z * z).sqrt();
        let normal = [cos * across, sin * across, z];
        if normal[2] > 0.9 {
            continue; // These face away from the scene.
        }
        let place = [0, 1, 2].map(|i| PLACE[i] + radius * normal[i]);
        let more = format!("lobe_exponent = 1\nlobe_axis = {normal:?}");
        let small = lit(lamp("lamp", "point", place, 4.0 / f64::from(count), &more)).render(32);
        sum.iter_mut().zip(small).for_each(|(a, b)| *a += b);
    }
    let (error, ratio) = (distance(&sum, &ball), mean(&sum) / mean(&ball));
    println!("ball by lamps: distance {error:.4}, mean {ratio:.4}");
    assert!(error < 0.02 && (ratio - 1.0).abs() < 0.002, "{error} {ratio}");
}

/// On an empty board the lobe is a factor that follows from each pixel's position.
#[test]
fn a_lobe_is_its_formula_in_both_frames() {
    let camera = |p: [f64; 3]| [p[0], -p[1], 0.6 - p[2]];
    for (frame, exponent) in [("world", 4.0), ("camera", 30.0), ("world", 0.3)] {
        let axis = [-0.4, 0.1, -0.9];
        let (place, way) = if frame == "world" { (PLACE, axis) } else { (camera(PLACE), [-0.4, -0.1, 0.9]) };
        let empty = |more: &str| Text {
            block: "presence = 0".into(),
            lights: lamp("lamp", "point", place, 1.0, &format!("frame = \"{frame}\"\n{more}")),
            ..Text::default()
        };
        let even = empty("").render(16);
        let text = empty(&format!("lobe_exponent = {exponent}\nlobe_axis = {way:?}"));
        let shaped = text.render(16);
        let length = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        for (pixel, position) in positions(&text).into_iter().enumerate() {
            let leaving = [0, 1, 2].map(|i| position[i] - PLACE[i]);
            let dot: f64 = (0..3).map(|i| leaving[i] * axis[i]).sum();
            let expected = libm::pow((dot / length(leaving) / length(axis)).max(0.0), exponent);
            let found = shaped[3 * pixel] / even[3 * pixel];
            assert!((found - expected).abs() < 4e-3 + 4e-3 * expected, "{frame} {exponent}: {found} {expected}");
        }
    }
}

/// The lobe's difference at its null is that of the renders; a light behind the lamp counts as dark at once.
#[test]
fn a_lobe_has_a_derivative_at_its_null() {
    let text = lit(lamp("lamp", "point", PLACE, 1.0, "lobe_axis = [-0.4, 0.1, -0.9]"));
    let stage = text.stage();
    let columns = text.columns(&["light.lamp.lobe_exponent"]);
    let found = plane(&film(&stage.prepare(&[], &columns).unwrap(), 0, 4, 0), 1);
    let at = |n: f64| radiance(&stage.prepare(&[("light.lamp.lobe_exponent".into(), n)], &[]).unwrap(), 4);
    let expected: Vec<f64> = at(0.1).iter().zip(at(0.0)).map(|(a, b)| (a - b) / 0.1).collect();
    assert!(distance(&found, &expected) < 1e-4);
    assert!(mean(&found) < 0.0);
}

/// A lamp that is off changes no bit, whether or not its derivative is wanted; and that is the light of one that is on.
#[test]
fn a_lamp_that_is_off_shows_in_its_derivative_alone() {
    let main = lamp("lamp", "point", PLACE, 1.0, "");
    let other = [-0.4, 0.3, 0.5];
    for (kind, more) in [("point", ""), ("sphere", "radius = 0.1")] {
        let text = lit(format!("{main}{}", lamp("other", kind, other, 0.0, more)));
        let alone = lit(main.clone()).render(64);
        assert_eq!(bits(&text.render(64)), bits(&alone));
        let columns = text.columns(&["light.other.intensity"]);
        let found = film(&text.stage().prepare(&[], &columns).unwrap(), 0, 64, 0);
        assert_eq!(bits(&plane(&found, 0)), bits(&alone));
        let lone = lit(lamp("lamp", kind, other, 1.0, more)).render(256);
        let error = distance(&plane(&found, 1), &lone);
        assert!(error < 0.03, "{kind}: {error}");
    }
}

#[test]
fn a_constant_and_a_map_add_up() {
    let sky = |more: &str| {
        let text = lit(format!("[[light]]\nname = \"sky\"\nkind = \"environment\"\nmap = \"sky\"\n{more}"));
        let mut assets = crate::fixture::assets();
        let pixels = (0..32).map(|k| [0.2 + 0.1 * (k % 8) as f32; 3]).collect();
        assets.maps.insert("sky".into(), Arc::new(Image { width: 8, height: 4, pixels }));
        radiance(&Stage::new(text.capture(), assets).prepare(&[], &[]).unwrap(), 64)
    };
    let constant =
        |r: f64| format!("[[light]]\nname = \"all\"\nkind = \"environment\"\nradiance = [{r:?}, {r:?}, {r:?}]\n");
    let map = sky("");
    assert_eq!(bits(&map), bits(&sky(&constant(0.0))));
    let both = sky(&constant(0.5));
    let ambient = lit(constant(0.5)).render(64);
    let sum: Vec<f64> = map.iter().zip(ambient).map(|(a, b)| a + b).collect();
    assert!(distance(&both, &sum) < 0.01, "{}", distance(&both, &sum));
    assert_eq!(both.len(), 3 * (SIDE * SIDE) as usize);
}
