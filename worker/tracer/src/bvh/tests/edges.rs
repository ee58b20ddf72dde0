//! No ray slips between triangles that share an edge or a corner.

use super::*;

/// From inside a closed surface every ray meets it, also where it is aimed at a corner or at the middle of an edge.
#[test]
fn a_closed_surface_has_no_gaps() {
    let mut random = Random(21);
    for scale in SCALES {
        for offset in [Vec3::ZERO, Vec3::new(-3.0, 100.0, 7.0) * scale] {
            let triangles = dented_sphere(40, scale, offset);
            let bvh = Bvh::build(&triangles);
            for [a, b, c] in &triangles {
                let origin = offset + 0.3 * scale * random.vector();
                for target in [*a, (*a + *b) * 0.5, (*b + *c) * 0.5, a.lerp(*c, random.number())] {
                    let ray = Ray { origin, direction: target - origin, t_min: 0.0, t_max: f32::INFINITY };
                    let hit = bvh.closest(&ray);
                    assert!(hit.is_some_and(|hit| (hit.t - 1.0).abs() < 0.05), "{hit:?} at scale {scale}: {ray:?}");
                    assert!(bvh.occluded(&ray));
                }
            }
        }
    }
}

/// Rays along the axes, with zeros of either sign, onto the corners, edges and faces of a grid that lies in a plane.
#[test]
fn axis_parallel_rays_meet_the_corners_of_a_grid() {
    for scale in SCALES {
        for axis in 0..3 {
            let place = |i: usize, j: usize, height: f32| {
                let mut point = [height; 3];
                (point[(axis + 1) % 3], point[(axis + 2) % 3]) = (i as f32 * scale, j as f32 * scale);
                Vec3::from_array(point)
            };
            let mut triangles = Vec::new();
            for (i, j) in (0..8).flat_map(|i| (0..8).map(move |j| (i, j))) {
                let [a, b, c, d] = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| place(i, j, 0.0));
                triangles.extend([[a, b, c], [a, c, d]]);
            }
            let bvh = Bvh::build(&triangles);
            for (i, j) in (0..=8).flat_map(|i| (0..=8).map(move |j| (i, j))) {
                for (height, zero) in [(3.0, 0.0), (3.0, -0.0), (-3.0, 0.0), (-3.0, -0.0)] {
                    let mut direction = Vec3::splat(zero);
                    direction[axis] = -height;
                    let origin = place(i, j, height * scale);
                    let ray = Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY };
                    let t = bvh.closest(&ray).map(|hit| hit.t);
                    assert!(t.is_some_and(|t| (t / scale - 1.0).abs() < 1e-6), "{t:?} at scale {scale}: {ray:?}");
                }
            }
        }
    }
}

/// Parts measured in metres: from 1 um to 0.1 mm of edge length no ray of a bundle onto a patch is lost.
#[test]
fn small_parts_lose_no_hit() {
    let mut random = Random(22);
    for edge in [1e-6_f32, 1e-5, 1e-4] {
        for offset in [Vec3::ZERO, Vec3::new(0.3, -0.2, 0.1)] {
            let size = 32.0 * edge;
            let triangles = dented_sphere(100, size, offset);
            let bvh = Bvh::build(&triangles);
            for _ in 0..3000 {
                let target = offset + 0.6 * size * random.vector() * Vec3::new(1.0, 1.0, 0.0);
                let origin = offset + Vec3::new(0.02, 0.01, 0.5);
                let ray = Ray { origin, direction: (target - origin).normalize(), t_min: 0.0, t_max: f32::INFINITY };
                assert!(bvh.closest(&ray).is_some(), "edge {edge}: {ray:?}");
            }
        }
    }
}

/// Ever smaller triangles make a binary tree as deep as they are many.
#[test]
fn a_mesh_of_all_scales_is_built_and_hit() {
    let triangles: Vec<[Vec3; 3]> = (0..2000)
        .map(|i| {
            let size = 1e6 * (0.96_f32).powi(i % 1000);
            [Vec3::ZERO, Vec3::X, Vec3::Y].map(|corner| (corner + Vec3::Z) * size)
        })
        .collect();
    let bvh = Bvh::build(&triangles);
    for (i, [a, b, c]) in triangles.iter().enumerate() {
        let centre = (*a + *b + *c) / 3.0;
        let ray = Ray { origin: centre * 1.01, direction: -centre, t_min: 0.0, t_max: 0.015 };
        assert_eq!(bvh.closest(&ray).map(|hit| hit.triangle as usize), Some(i % 1000), "triangle {i}");
    }
}
