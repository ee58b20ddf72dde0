//! Meshes of the hidden captures: a part with three lobes, and boxes.

use super::vectors::{V, add, cross, sub, unit};
use gonio_scene::mesh::Mesh;
use std::f64::consts::TAU;

const AROUND: usize = 60;
/// Radius and height of the part's rings from the board up, metres: a skirt, a neck, a domed head.
const PROFILE: [[f64; 2]; 13] = [
    [0.034, 0.0],
    [0.034, 0.006],
    [0.033, 0.009],
    [0.029, 0.012],
    [0.025, 0.017],
    [0.0235, 0.024],
    [0.0235, 0.032],
    [0.023, 0.037],
    [0.0215, 0.041],
    [0.018, 0.0445],
    [0.013, 0.0468],
    [0.007, 0.0480],
    [0.0, 0.0484],
];

/// The part: its rings are no circles, so that every turn of it shows. Stands on z = 0, 70 mm wide and 48 mm high.
#[must_use]
pub fn part() -> Mesh {
    let rings = refined(2);
    let mut positions: Vec<V> = Vec::new();
    for [radius, z] in &rings[..rings.len() - 1] {
        for i in 0..AROUND {
            let angle = TAU * i as f64 / AROUND as f64;
            let r = radius * (1.0 + 0.07 * libm::cos(3.0 * angle) + 0.06 * libm::cos(angle));
            positions.push([r * libm::cos(angle), r * libm::sin(angle), *z]);
        }
    }
    positions.push([0.0, 0.0, rings[rings.len() - 1][1]]);
    let top = positions.len() - 1;
    let mut triangles = Vec::new();
    for ring in 0..rings.len() - 1 {
        for i in 0..AROUND {
            let (a, b) = (ring * AROUND + i, ring * AROUND + (i + 1) % AROUND);
            if ring + 2 == rings.len() {
                triangles.push([a, b, top]);
            } else {
                triangles.push([a, b, b + AROUND]);
                triangles.push([a, b + AROUND, a + AROUND]);
            }
        }
    }
    let mut normals = vec![[0.0; 3]; positions.len()];
    for t in &triangles {
        let n = cross(sub(positions[t[1]], positions[t[0]]), sub(positions[t[2]], positions[t[0]]));
        for v in t {
            normals[*v] = add(normals[*v], n);
        }
    }
    Mesh {
        positions: positions.into_iter().map(single).collect(),
        normals: Some(normals.into_iter().map(|n| single(unit(n))).collect()),
        triangles: triangles.into_iter().map(|t| t.map(|i| i as u32)).collect(),
        degenerate: 0,
    }
}

/// The profile with each segment cut into `parts`, on a Catmull-Rom curve.
fn refined(parts: usize) -> Vec<[f64; 2]> {
    let at = |i: isize| PROFILE[i.clamp(0, PROFILE.len() as isize - 1) as usize];
    let mut rings = Vec::new();
    for i in 0..PROFILE.len() as isize - 1 {
        for k in 0..parts {
            let t = k as f64 / parts as f64;
            rings.push([0, 1].map(|axis| {
                let [a, b, c, d] = [-1, 0, 1, 2].map(|o| at(i + o)[axis]);
                b + 0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)))
            }));
        }
    }
    rings.push(PROFILE[PROFILE.len() - 1]);
    rings
}

/// A box between two corners, with flat sides.
#[must_use]
pub fn cuboid(low: V, high: V) -> Mesh {
    let corner = |i: usize| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { high[axis] } else { low[axis] } as f32);
    let sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    Mesh { positions: (0..8).map(corner).collect(), normals: None, triangles, degenerate: 0 }
}

/// The mesh turned, then shifted.
#[must_use]
pub fn moved(mesh: &Mesh, turn: impl Fn(V) -> V, shift: V) -> Mesh {
    let positions = mesh.positions.iter().map(|p| single(add(turn(p.map(f64::from)), shift))).collect();
    let normals = mesh.normals.as_ref().map(|n| n.iter().map(|n| single(turn(n.map(f64::from)))).collect());
    Mesh { positions, normals, ..mesh.clone() }
}

/// The mesh with every normal tilted by a vector, given place and normal.
#[must_use]
pub fn tilted(mesh: &Mesh, by: impl Fn(V, V) -> V) -> Mesh {
    let normals = mesh.normals.as_ref().unwrap();
    let tilt = |(p, n): (&[f32; 3], &[f32; 3])| {
        let (p, n) = (p.map(f64::from), n.map(f64::from));
        single(unit(add(n, by(p, n))))
    };
    Mesh { normals: Some(mesh.positions.iter().zip(normals).map(tilt).collect()), ..mesh.clone() }
}

fn single(v: V) -> [f32; 3] {
    v.map(|x| x as f32)
}
