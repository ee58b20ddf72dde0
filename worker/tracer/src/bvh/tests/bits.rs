//! Hierarchy, instruction set and packets never change a bit of a hit.

use super::*;
use crate::bvh::{
    Bundle, Hits, closest_portable, occluded_packet_portable, occluded_portable, packet_portable, stream_portable,
};

/// The definition: the nearest of all triangles, each tested by itself, the smaller index where two are equally near.
fn one_by_one(alone: &[Bvh], ray: &Ray) -> Option<Hit> {
    let hits = (0..).zip(alone).filter_map(|(triangle, bvh)| Some(Hit { triangle, ..bvh.closest(ray)? }));
    hits.min_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)))
}

#[test]
fn a_hierarchy_finds_what_testing_every_triangle_finds() {
    let mut random = Random(1);
    for scale in SCALES {
        for offset in [Vec3::ZERO, Vec3::new(20.0, -300.0, 4e3) * scale] {
            let triangles = random.soup(200, scale, offset);
            let bvh = Bvh::build(&triangles);
            let alone: Vec<Bvh> = triangles.iter().map(|triangle| Bvh::build(&[*triangle])).collect();
            let mut found = 0;
            for _ in 0..300 {
                let ray = random.ray(scale, offset);
                let expected = one_by_one(&alone, &ray);
                assert_eq!(bvh.closest(&ray), expected, "scale {scale}, {ray:?}");
                assert_eq!(bvh.occluded(&ray), expected.is_some(), "scale {scale}, {ray:?}");
                found += usize::from(expected.is_some());
            }
            assert!((60..=295).contains(&found), "{found} of 300 rays hit at scale {scale}");
        }
    }
}

/// Vertices on a grid make coincident edges, coplanar and coincident triangles, and rays along all of them.
#[test]
fn a_hierarchy_agrees_where_everything_coincides() {
    let mut random = Random(2);
    let grid = |random: &mut Random| (random.vector() * 2.5).round();
    let triangles: Vec<[Vec3; 3]> = (0..300).map(|_| [0; 3].map(|_| grid(&mut random))).collect();
    let bvh = Bvh::build(&triangles);
    let alone: Vec<Bvh> = triangles.iter().map(|triangle| Bvh::build(&[*triangle])).collect();
    for _ in 0..2000 {
        let origin = grid(&mut random) * if random.number() < 0.5 { 1.0 } else { 0.5 };
        let ray = Ray { origin, direction: grid(&mut random), t_min: 0.0, t_max: f32::INFINITY };
        let expected = one_by_one(&alone, &ray);
        assert_eq!(bvh.closest(&ray), expected, "{ray:?}");
        assert_eq!(closest_portable(&bvh.layout, &ray), expected, "{ray:?}");
        assert_eq!(bvh.occluded(&ray), expected.is_some(), "{ray:?}");
    }
}

#[test]
fn every_instruction_set_gives_the_same_bits() {
    let mut random = Random(3);
    for scale in SCALES {
        let mut triangles = random.soup(2000, scale, Vec3::ZERO);
        // Large enough for the arrays to lie on huge pages.
        triangles.extend(dented_sphere(200, scale, Vec3::ZERO));
        let bvh = Bvh::build(&triangles);
        for _ in 0..5000 {
            let ray = random.ray(scale, Vec3::ZERO);
            let (fast, portable) = (bvh.closest(&ray), closest_portable(&bvh.layout, &ray));
            let bits = |hit: Option<Hit>| hit.map(|h| (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.triangle));
            assert_eq!(bits(fast), bits(portable), "{ray:?}");
            assert_eq!(bvh.occluded(&ray), occluded_portable(&bvh.layout, &ray), "{ray:?}");
        }
    }
}

/// The hits of any number of rays, sixteen at a time.
fn streamed(bvh: &Bvh, rays: &[Ray]) -> Vec<Option<Hit>> {
    let hits = rays.chunks(16).map(|rays| {
        let mut hits = Hits::NONE;
        bvh.closest_stream(&Bundle::new(rays), &mut hits);
        (0..rays.len()).map(move |lane| hits.get(lane))
    });
    hits.flatten().collect()
}

/// Rays of a small camera: `spread` is the difference of neighbouring slopes.
fn camera(random: &mut Random, scale: f32, spread: f32, count: usize) -> Vec<Ray> {
    let origin = scale * 3.0 * random.vector();
    let towards = scale * 0.5 * random.vector() - origin;
    let ray = |random: &mut Random| {
        let direction = towards + scale * spread * random.vector();
        Ray { origin, direction, t_min: 0.0, t_max: if random.number() < 0.8 { f32::INFINITY } else { 0.9 } }
    };
    (0..count).map(|_| ray(random)).collect()
}

#[test]
fn packets_find_what_single_rays_find() {
    let mut random = Random(4);
    let mut shared = 0;
    for scale in SCALES {
        let mut triangles = random.soup(500, scale, Vec3::ZERO);
        triangles.extend(dented_sphere(60, scale, Vec3::ZERO));
        let bvh = Bvh::build(&triangles);
        for (spread, count) in [(0.0, 16), (1e-3, 16), (0.02, 16), (0.2, 16), (1.0, 16), (0.02, 7), (0.02, 41)] {
            for _ in 0..20 {
                let rays = camera(&mut random, scale, spread, count);
                let mut hits = vec![None; count];
                bvh.closest_packet(&rays, &mut hits);
                let expected: Vec<Option<Hit>> = rays.iter().map(|ray| bvh.closest(ray)).collect();
                assert_eq!(hits, expected, "spread {spread}, scale {scale}");
                assert_eq!(streamed(&bvh, &rays), expected, "spread {spread}, scale {scale}");
                let mut blocked = vec![false; count];
                bvh.occluded_packet(&rays, &mut blocked);
                let any: Vec<bool> = expected.iter().map(Option::is_some).collect();
                assert_eq!(blocked, any, "spread {spread}, scale {scale}");

                let (bundle, lanes) = (Bundle::new(&rays), 0..count.min(16));
                if let Some(blocked) = occluded_packet_portable(&bvh.layout, &bundle) {
                    let blocked: Vec<bool> = lanes.clone().map(|lane| blocked >> lane & 1 != 0).collect();
                    assert_eq!(blocked, any[lanes.clone()], "spread {spread}, scale {scale}");
                }
                let mut hits = Hits::NONE;
                if packet_portable(&bvh.layout, &bundle, &mut hits) {
                    shared += 1;
                    let hits: Vec<Option<Hit>> = lanes.clone().map(|lane| hits.get(lane)).collect();
                    assert_eq!(hits, expected[lanes], "spread {spread}, scale {scale}");
                }
            }
        }
    }
    assert!(shared > 200, "only {shared} packets were coherent");
}

#[test]
fn a_packet_of_unlike_rays_is_traced_ray_by_ray() {
    let mut random = Random(5);
    let bvh = Bvh::build(&random.soup(500, 1.0, Vec3::ZERO));
    let rays: Vec<Ray> = (0..333).map(|_| random.ray(1.0, Vec3::ZERO)).collect();
    let mut hits = vec![None; rays.len()];
    bvh.closest_packet(&rays, &mut hits);
    for (ray, hit) in rays.iter().zip(hits) {
        assert_eq!(hit, bvh.closest(ray));
    }
}

/// A few large triangles beside a small part of many, as a part on a board: the root has leaves of its own.
#[test]
fn rays_that_leave_together_find_what_single_rays_find() {
    let mut random = Random(6);
    for scale in SCALES {
        let mut triangles = dented_sphere(40, 0.2 * scale, Vec3::ZERO);
        let corner = |x: f32, y: f32| scale * Vec3::new(x, y, -0.25);
        triangles.push([corner(-4.0, -4.0), corner(4.0, -4.0), corner(4.0, 4.0)]);
        triangles.push([corner(-4.0, -4.0), corner(4.0, 4.0), corner(-4.0, 4.0)]);
        let bvh = Bvh::build(&triangles);
        let mut found = 0;
        for round in 0..200 {
            let mut rays: Vec<Ray> = (0..21).map(|_| random.ray(scale, Vec3::ZERO)).collect();
            if round % 2 == 0 {
                let origin = rays[0].origin;
                rays.iter_mut().for_each(|ray| ray.origin = origin);
            }
            if round % 5 == 0 {
                rays[3] = if round % 2 == 0 { Ray::NONE } else { Ray { direction: Vec3::ZERO, ..rays[3] } };
            }
            let expected: Vec<Option<Hit>> = rays.iter().map(|ray| bvh.closest(ray)).collect();
            found += expected.iter().flatten().count();
            assert_eq!(streamed(&bvh, &rays), expected, "scale {scale}");
            let mut hits = Hits::NONE;
            stream_portable(&bvh.layout, &Bundle::new(&rays), &mut hits);
            let hits: Vec<Option<Hit>> = (0..16).map(|lane| hits.get(lane)).collect();
            assert_eq!(hits, expected[..16], "scale {scale}");
        }
        assert!((200..4000).contains(&found), "{found} of 4200 rays hit at scale {scale}");
    }
}
