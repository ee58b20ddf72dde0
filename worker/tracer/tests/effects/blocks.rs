//! Paths that are traced together give the bits of paths that are traced one by one, as derivatives ask for.

use crate::fixture::{Text, film, lamp, plane};

#[test]
fn a_derivative_leaves_every_bit_of_the_radiance() {
    let point = |name: &str, at: [f64; 3]| lamp(name, "point", at, 0.7, "");
    let sun =
        "[[light]]\nname = \"sun\"\nkind = \"directional\"\ndirection = [1, 2, -3]\nirradiance = [0.5, 0.4, 0.3]\n";
    let sky = "[[light]]\nname = \"sky\"\nkind = \"environment\"\nradiance = [0.1, 0.2, 0.3]\n";
    let first = point("lamp", [0.3, -0.2, 0.8]);
    let lights = [
        first.clone(),
        format!("{first}{}{sun}", point("second", [-0.1, 0.2, 0.3])),
        format!("{first}{sky}"),
        format!("{first}{}", lamp("ball", "sphere", [0.05, 0.1, 0.4], 0.7, "radius = 0.05\n")),
        format!("{first}{}", lamp("torch", "point", [0.0, 0.1, 0.5], 0.7, "lobe_exponent = 3\n")),
        format!(
            "{first}{}",
            (0..4).map(|k| point(&format!("many{k}"), [0.1 * f64::from(k), 0.1, 0.5])).collect::<String>()
        ),
    ];
    let cameras = ["", "aperture_radius = 0.02\nfocus_distance = 0.5\n", "glare_fraction = 0.1\nglare_width = 2\n"];
    let bits = |film: &_| plane(film, 0).iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    for (k, lights) in lights.iter().enumerate() {
        for camera in cameras {
            for block in ["", "presence = 0.5\n"] {
                let (camera, block, lights) = (camera.to_owned(), block.to_owned(), lights.clone());
                let text = Text { camera, block, lights, ..Text::default() };
                let stage = text.stage();
                let columns = text.columns(&["material.glossy.roughness"]);
                // 21: a whole block and a part of one.
                let single = film(&stage.prepare(&[], &columns).unwrap(), 0, 21, 0);
                let together = film(&stage.prepare(&[], &[]).unwrap(), 0, 21, 0);
                assert!(bits(&single) == bits(&together), "lights {k}, {:?}, {:?}", text.camera, text.block);
            }
        }
    }
}
