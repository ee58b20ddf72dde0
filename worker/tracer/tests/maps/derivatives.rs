//! The numbers that maps multiply stay the ones that are fitted.

use crate::fixture::{World, distance, exr, film, plane, square};

const LAMP: &str = "[[light]]\nname = \"led\"\nkind = \"point\"\nposition = [0.3, 0.2, 0.6]\nintensity = [1, 1, 1]\n";

fn plastic() -> World {
    let material = "model = \"plastic\"\nbase_color = [0.7, 0.5, 0.6]\nroughness = 0.5\nior = 1.5\nmetallic = 0.3\n\
                    base_color_map = \"mesh\"\nroughness_map = \"r.exr\"\nmetallic_map = \"r.exr\"\n";
    let colours = [[0.1, 0.9, 0.5], [0.8, 0.4, 0.0], [0.3, 0.3, 1.0], [1.0, 0.7, 0.2]];
    let mut world = World::new(material, square(Some(colours)));
    world.lights.push_str(LAMP);
    world.add("r.exr", exr(4, 4, |x, y| [0.5, 0.4 + 0.15 * x as f32, 0.2 + 0.2 * y as f32]));
    world
}

/// Radiance of a diffuse square is linear in its colour: value = number times derivative, pixel by pixel.
#[test]
fn a_diffuse_colour_s_derivative_is_what_it_multiplies() {
    let material = "model = \"lambert\"\nbase_color = [0.7, 0.5, 0.6]\nbase_color_map = \"mesh\"\n";
    let colours = [[0.1, 0.9, 0.5], [0.8, 0.4, 0.0], [0.3, 0.3, 1.0], [1.0, 0.7, 0.2]];
    let world = World::new(material, square(Some(colours)));
    let prepared = world.stage().prepare(&[], &world.columns(&["material.paint.base_color"])).unwrap();
    let film = film(&prepared, 4);
    let (radiance, derivative) = (plane(&film, 0), plane(&film, 1));
    let product: Vec<[f64; 3]> = derivative.iter().map(|d| [0, 1, 2].map(|c| d[c] * [0.7, 0.5, 0.6][c])).collect();
    assert!(distance(&product, &radiance) < 1e-4, "{}", distance(&product, &radiance));
}

#[test]
fn derivatives_agree_with_differences_of_renders() {
    let world = plastic();
    let names = [
        "material.paint.base_color.g",
        "material.paint.roughness",
        "material.paint.metallic",
        "material.paint.ior",
        "material.paint.albedo_variation.0",
    ];
    let columns = world.columns(&names);
    let forward = film(&world.stage().prepare(&[], &columns).unwrap(), 16);
    let stepped: Vec<_> = columns
        .iter()
        .map(|column| {
            let mut column = column.clone();
            column.step = Some(0.01);
            column
        })
        .collect();
    let difference = film(&world.stage().prepare(&[], &stepped).unwrap(), 16);
    for (index, name) in names.iter().enumerate() {
        let only = |values: Vec<[f64; 3]>| -> Vec<[f64; 3]> {
            // The plane of a colour's channel holds its own derivative there.
            values.into_iter().map(|v| if name.ends_with(".g") { [0.0, v[1], 0.0] } else { v }).collect()
        };
        let (a, b) = (only(plane(&forward, 1 + index)), only(plane(&difference, 1 + index)));
        let error = distance(&a, &b);
        assert!(error < 0.01, "{name}: {error}");
    }
}

/// Paths that are traced together give the bits of single ones, beside plain materials too.
#[test]
fn a_derivative_leaves_every_bit_of_the_radiance() {
    let mut world = plastic();
    world.more = "[[material]]\nname = \"plain\"\nmodel = \"plastic\"\nbase_color = [0.3, 0.3, 0.3]\nroughness = 0.4\n\
                  ior = 1.5\n[[object]]\nname = \"other\"\nmesh = \"square.ply\"\nmaterial = \"plain\"\n\
                  object_to_world = [[0.3, 0, 0, 0.1], [0, 0, -0.3, 0.1], [0, 0.3, 0, 0.2], [0, 0, 0, 1]]\n"
        .to_owned();
    let bits = |film: &_| plane(film, 0).as_flattened().iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    let single = film(&world.stage().prepare(&[], &world.columns(&["material.plain.roughness"])).unwrap(), 21);
    let together = film(&world.stage().prepare(&[], &[]).unwrap(), 21);
    assert!(bits(&single) == bits(&together));
}
