//! Effects of the part's material, mixed from films of simpler parts.

use super::diffusion;
use super::film::{Films, Hit, Hits};
use super::mesh;
use super::places::Field;
use super::random::Random;
use super::vectors::{V, add, cross, dot, scale, sub, unit};
use super::world::{PART, World};
use gonio_scene::capture::Model;
use std::f64::consts::PI;

const BLACK: Model = Model::Lambert { base_color: [0.0; 3] };

/// Films with an effect; `None` where it is none of these.
#[must_use]
pub fn films(
    effect: &str,
    strength: f64,
    world: &World,
    samples: u32,
    seed: u64,
    random: &mut Random,
) -> Option<Films> {
    let of = |world: &World| Films::of(world, samples, seed);
    let plain = || of(world);
    let (colour, roughness) = world.colour_and_roughness();
    // What light that has been below the surface adds.
    let diffuse = |plain: &Films| plain.with(&of(&world.with_colour([0.0; 3])), |a, b| a - b);
    Some(match effect {
        "albedo-variation" => {
            let (field, hits, plain) = (Field::new(random, 0.3 * strength), Hits::of(world), plain());
            let factor = |photo, i| hits.on_part(photo, i, 0.0, |h| libm::exp(field.value(h.place)) - 1.0);
            plain.with(&diffuse(&plain).at(|photo, i, v| scale(v, factor(photo, i))), |a, b| a + b)
        }
        "roughness-variation" => varied(world, &Field::new(random, 0.4 * strength), roughness, &of),
        "second-lobe" => {
            let other = of(&world.with_roughness(0.5 * roughness));
            plain().with(&other, |a, b| a + 0.4 * strength * (b - a))
        }
        "metallic" => {
            // The real index whose reflectance straight on is the colour.
            let eta = colour.map(|f| (1.0 + f.sqrt()) / (1.0 - f.sqrt()));
            let metal = of(&world.with_model(Model::Conductor { roughness, eta, k: [0.0; 3] }));
            plain().with(&metal, |a, b| a + 0.4 * strength * (b - a))
        }
        "anisotropy" => anisotropic(world, 0.5 * strength.sqrt(), roughness, samples, seed),
        "clear-coat" => {
            let share = 0.8 * strength;
            let coat = Model::Plastic { base_color: [0.0; 3], roughness: 0.1, ior: 1.5, energy_compensation: false };
            let coat = of(&world.with_model(coat)).with(&of(&world.with_model(BLACK)), |a, b| a - b);
            let (hits, black) = (Hits::of(world), of(&world.with_model(BLACK)));
            let under = plain().with(&black, |a, b| a - b).at(|photo, i, v| {
                let through = |h: &Hit| (1.0 - share * fresnel(h, world)).powi(2);
                scale(v, hits.on_part(photo, i, 1.0, through))
            });
            under.with(&black, |a, b| a + b).with(&coat, |a, b| a + share * b)
        }
        "diffuse-roughness" => {
            let (hits, plain) = (Hits::of(world), plain());
            let square = (0.6 * strength.sqrt()).powi(2);
            let more = diffuse(&plain)
                .at(|photo, i, v| scale(v, hits.on_part(photo, i, 1.0, |h| facets(h, world, square)) - 1.0));
            plain.with(&more, |a, b| a + b)
        }
        "sheen" => {
            let hits = Hits::of(world);
            let white = of(&world.with_model(Model::Lambert { base_color: [0.5; 3] }));
            let light = white.with(&of(&world.with_model(BLACK)), |a, b| (a - b) / 0.5);
            let fibres = light.at(|photo, i, v| {
                let lobe = hits.on_part(photo, i, 0.0, |h| PI * fibre(h, world));
                [0, 1, 2].map(|c| strength * [0.30, 0.27, 0.24][c] * lobe * v[c])
            });
            plain().with(&fibres, |a, b| a + b)
        }
        "translucency" => {
            let spread = diffusion::spread(world, &Hits::of(world), 0.004 * strength.sqrt());
            plain().with(&spread, |a, b| a + b)
        }
        _ => return None,
    })
}

/// Between films at several roughnesses, by the field behind each pixel.
fn varied(world: &World, field: &Field, roughness: f64, of: &dyn Fn(&World) -> Films) -> Films {
    let logs: Vec<f64> = (-4..=4).map(|i| 0.25 * f64::from(i)).collect();
    let films: Vec<Films> =
        logs.iter().map(|l| of(&world.with_roughness((roughness * libm::exp(*l)).min(1.0)))).collect();
    let hits = Hits::of(world);
    films[0].at(|photo, i, _| {
        let at = (hits.on_part(photo, i, 0.0, |h| field.value(h.place)).clamp(-1.0, 1.0) + 1.0) / 0.25;
        let low = (at as usize).min(films.len() - 2);
        let (a, b) = (films[low].0[photo][i], films[low + 1].0[photo][i]);
        [0, 1, 2].map(|c| a[c] + (at - low as f64) * (b[c] - a[c]))
    })
}

/// Facets spread further along the rings than across: a mean over normals tilted along them.
fn anisotropic(world: &World, strength: f64, roughness: f64, samples: u32, seed: u64) -> Films {
    let alpha = roughness * roughness;
    let wide = alpha + (1.0 - alpha) * strength * strength;
    // Slopes of a microfacet distribution of width alpha have about the variance alpha^2 / 2.
    let spread = ((wide * wide - alpha * alpha) / 2.0).sqrt();
    // Middles of sixteen equally likely parts of a normal distribution, to three digits.
    let halves = [0.078, 0.237, 0.402, 0.579, 0.776, 1.010, 1.318, 1.863];
    let part = &world.assets.meshes[&format!("{PART}.ply")];
    let tilts = 0..2 * halves.len();
    let worlds = tilts.map(|i| {
        let tilt = spread * halves[i / 2] * if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        world.with_part(mesh::tilted(part, |_, n| {
            let along = cross([0.0, 0.0, 1.0], n);
            if dot(along, along) < 1e-12 { [tilt, 0.0, 0.0] } else { scale(unit(along), tilt) }
        }))
    });
    Films::mean_of(worlds, 4 * samples, seed)
}

/// The ways to eye and lamp from a place.
fn ways(hit: &Hit, world: &World) -> (V, V) {
    let m = &world.capture.photos[hit.photo].camera_to_world;
    let toward = |p: V| unit(sub(p, hit.place));
    (toward([m[0][3], m[1][3], m[2][3]]), toward(world.lamp_in_room(hit.photo)))
}

/// Reflectance of a smooth surface of index 1.5 seen from the eye.
fn fresnel(hit: &Hit, world: &World) -> f64 {
    let cos = dot(ways(hit, world).0, hit.normal).clamp(0.0, 1.0);
    let inside = (1.0 - (1.0 - cos * cos) / 2.25).sqrt();
    let (s, p) = ((cos - 1.5 * inside) / (cos + 1.5 * inside), (1.5 * cos - inside) / (1.5 * cos + inside));
    0.5 * (s * s + p * p)
}

/// What matt facets of a mean square slope angle make of a lambertian surface's light, in vector form.
fn facets(hit: &Hit, world: &World, square: f64) -> f64 {
    let (eye, lamp) = ways(hit, world);
    let (v, l) = (dot(eye, hit.normal).max(1e-3), dot(lamp, hit.normal).max(1e-3));
    let same_side = dot(eye, lamp) - v * l;
    let across = if same_side > 0.0 { same_side / v.max(l) } else { 0.0 };
    1.0 - 0.5 * square / (square + 0.33) + 0.45 * square / (square + 0.09) * across
}

/// Reflection of fibres that stand up: the distribution of the half vector's sine to the power 1 / 0.25.
fn fibre(hit: &Hit, world: &World) -> f64 {
    let (eye, lamp) = ways(hit, world);
    let (v, l) = (dot(eye, hit.normal).max(0.0), dot(lamp, hit.normal).max(0.0));
    let cos = dot(unit(add(eye, lamp)), hit.normal);
    let sine = (1.0 - cos * cos).max(0.0).sqrt();
    if v + l < 1e-3 { 0.0 } else { 6.0 / (2.0 * PI) * sine.powi(4) / (4.0 * (v + l - v * l)) }
}
