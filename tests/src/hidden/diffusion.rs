//! Light that diffuses through the part: the dipole of Jensen, Marschner, Levoy, Hanrahan 2001, "A practical model for
//! subsurface light transport", summed over points of the mesh that the lamp is seen from.
//!
//! Only the lamp's own light is spread; what the board sends back stays where it falls.

use super::film::{Films, Hit, Hits};
use super::vectors::{V, add, cross, dot, scale, sub, unit};
use super::world::{PART, World};
use gonio_scene::capture::{LightKind, Model};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Each triangle is cut into so many, squared.
const CUTS: usize = 2;
/// Entries of a table of the dipole, and mean free paths that it reaches over.
const TABLE: usize = 4000;
const REACH: f64 = 16.0;

/// A piece of the part's surface.
struct Patch {
    place: V,
    normal: V,
    area: f64,
}

/// What a mean free path below the part's surface adds to the film of the same part without one.
#[must_use]
pub fn spread(world: &World, hits: &Hits, path: f64) -> Films {
    let Model::Plastic { base_color, ior, .. } = world.plastic() else { unreachable!() };
    let LightKind::Point { intensity, .. } = world.capture.lights[0].kind else { unreachable!() };
    let triangles = triangles(world);
    let patches: Vec<Patch> = triangles.iter().flat_map(|(corners, normals)| patches(corners, normals)).collect();
    let tables = base_color.map(|colour| table(albedo(colour)));
    let internal = -1.440 / (ior * ior) + 0.710 / ior + 0.668 + 0.0636 * ior;
    let base = base_color.map(|c| c / (PI * ior * ior * (1.0 - c * internal)));
    let (width, height) = (world.capture.camera.width as usize, world.capture.camera.height as usize);
    let photo = |photo: usize| {
        let lamp = world.lamp_in_room(photo);
        let m = &world.capture.photos[photo].camera_to_world;
        let eye = [m[0][3], m[1][3], m[2][3]];
        // What of the lamp gets below the surface at a place.
        let entering = |place: V, normal: V| {
            let way = sub(lamp, place);
            let cos = dot(unit(way), normal);
            if cos <= 0.0 || shaded(add(place, scale(normal, 2e-5)), lamp, &triangles) {
                return 0.0;
            }
            through(cos, ior) * cos / dot(way, way)
        };
        let lit: Vec<f64> = patches.par_iter().map(|p| entering(p.place, p.normal) * p.area).collect();
        let leaving = |hit: &Hit| -> V {
            let mut sum = [0.0; 3];
            for (patch, light) in patches.iter().zip(&lit).filter(|(_, light)| **light > 0.0) {
                let away = sub(hit.place, patch.place);
                let at = dot(away, away).sqrt() / path / REACH * TABLE as f64;
                if at < TABLE as f64 {
                    sum = [0, 1, 2].map(|c| sum[c] + light * tables[c][at as usize] / (path * path));
                }
            }
            let (here, out) =
                (entering(hit.place, hit.normal), through(dot(unit(sub(eye, hit.place)), hit.normal), ior));
            [0, 1, 2].map(|c| intensity[c] * base[c] * out * (sum[c] - here))
        };
        let exposure = world.capture.photos[photo].factor();
        let pixel = |i: usize| {
            let (hits, share) = hits.part(photo, i);
            // Every other one: light that has spread is smooth.
            let some: Vec<V> = hits.step_by(2).map(leaving).collect();
            let part = share * exposure / some.len().max(1) as f64;
            some.iter().fold([0.0; 3], |sum, light| add(sum, scale(*light, part)))
        };
        (0..width * height).into_par_iter().map(pixel).collect()
    };
    Films((0..world.capture.photos.len()).map(photo).collect())
}

/// The reduced albedo of a medium, without a boundary, that returns so much of the light on a plane.
fn albedo(colour: f64) -> f64 {
    let returned = |a: f64| {
        let root = (3.0 * (1.0 - a)).sqrt();
        0.5 * a * (1.0 + libm::exp(-4.0 / 3.0 * root)) * libm::exp(-root)
    };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if returned(middle) < colour {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// The dipole by distance in mean free paths, of integral 1 over a plane.
fn table(albedo: f64) -> Vec<f64> {
    let (decay, above) = ((3.0 * (1.0 - albedo)).sqrt(), 1.0 + 4.0 / 3.0);
    let source = |z: f64, r: f64| {
        let d = (r * r + z * z).sqrt();
        z * (1.0 + decay * d) * libm::exp(-decay * d) / (d * d * d)
    };
    let radius = |i: usize| (i as f64 + 0.5) * REACH / TABLE as f64;
    let values: Vec<f64> = (0..TABLE).map(|i| source(1.0, radius(i)) + source(above, radius(i))).collect();
    let sum: f64 = values.iter().enumerate().map(|(i, v)| v * 2.0 * PI * radius(i) * REACH / TABLE as f64).sum();
    values.iter().map(|v| v / sum).collect()
}

/// What a smooth surface lets through.
fn through(cos: f64, index: f64) -> f64 {
    let cos = cos.clamp(0.0, 1.0);
    let inside = (1.0 - (1.0 - cos * cos) / (index * index)).sqrt();
    let s = (cos - index * inside) / (cos + index * inside);
    let p = (index * cos - inside) / (index * cos + inside);
    1.0 - 0.5 * (s * s + p * p)
}

/// Corners and normals of the part's triangles.
fn triangles(world: &World) -> Vec<([V; 3], [V; 3])> {
    let mesh = &world.assets.meshes[&format!("{PART}.ply")];
    let of = |all: &[[f32; 3]], t: &[u32; 3]| t.map(|i| all[i as usize].map(f64::from));
    let normals = mesh.normals.as_ref().unwrap();
    mesh.triangles.iter().map(|t| (of(&mesh.positions, t), of(normals, t))).collect()
}

/// A triangle in equal pieces.
fn patches([a, b, c]: &[V; 3], normals: &[V; 3]) -> Vec<Patch> {
    let whole = cross(sub(*b, *a), sub(*c, *a));
    let area = 0.5 * dot(whole, whole).sqrt() / (CUTS * CUTS) as f64;
    let at = |corners: [V; 3], u: f64, v: f64| {
        [0, 1, 2].map(|i| corners[0][i] * (1.0 - u - v) + corners[1][i] * u + corners[2][i] * v)
    };
    let mut all = Vec::new();
    for i in 0..CUTS {
        for j in 0..CUTS - i {
            // The piece at (i, j), and the one that stands on its head beside it.
            for part in [1.0 / 3.0, 2.0 / 3.0].iter().take(if i + j + 1 < CUTS { 2 } else { 1 }) {
                let (u, v) = ((i as f64 + part) / CUTS as f64, (j as f64 + part) / CUTS as f64);
                all.push(Patch { place: at([*a, *b, *c], u, v), normal: unit(at(*normals, u, v)), area });
            }
        }
    }
    all
}

/// Whether any triangle stands between a place and the lamp (Moller and Trumbore 1997).
fn shaded(from: V, to: V, triangles: &[([V; 3], [V; 3])]) -> bool {
    let way = sub(to, from);
    triangles.iter().any(|([a, b, c], _)| {
        let (e, f) = (sub(*b, *a), sub(*c, *a));
        let p = cross(way, f);
        let volume = dot(e, p);
        if volume.abs() < 1e-18 {
            return false;
        }
        let s = sub(from, *a);
        let u = dot(s, p) / volume;
        if !(0.0..=1.0).contains(&u) {
            return false;
        }
        let q = cross(s, e);
        let (v, t) = (dot(way, q) / volume, dot(f, q) / volume);
        v >= 0.0 && u + v <= 1.0 && t > 1e-9 && t < 1.0
    })
}
