//! Hits against geometry in double precision, and against what degenerate input must give.

use super::*;
use glam::DVec3;

/// Möller & Trumbore 1997 in double precision: t, u, v.
fn intersection(ray: &Ray, triangle: &[Vec3; 3]) -> Option<(f64, f64, f64)> {
    let [a, b, c] = triangle.map(Vec3::as_dvec3);
    let (origin, direction): (DVec3, DVec3) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let determinant = ab.dot(p);
    // Closer to edge-on than this, single precision may see either side.
    if determinant.abs() < 1e-3 * ab.length() * ac.length() * direction.length() {
        return None;
    }
    let from = origin - a;
    let u = from.dot(p) / determinant;
    let q = from.cross(ab);
    Some((ac.dot(q) / determinant, u, direction.dot(q) / determinant))
}

#[test]
fn hits_agree_with_double_precision_at_every_scale() {
    let mut random = Random(11);
    for scale in SCALES {
        let triangles = random.soup(60, scale, Vec3::ZERO);
        let bvh = Bvh::build(&triangles);
        let mut compared = 0;
        for _ in 0..2000 {
            let ray = Ray { t_min: 0.0, t_max: f32::INFINITY, ..random.ray(scale, Vec3::ZERO) };
            let length = f64::from(scale / ray.direction.length());
            let exact: Vec<_> = triangles.iter().map(|triangle| intersection(&ray, triangle)).collect();
            // Leave out what is too close to call: an edge, the origin, or edge-on.
            let clear = exact.iter().all(|hit| {
                hit.is_some_and(|(t, u, v)| {
                    let rim = u.min(v).min(1.0 - u - v);
                    rim < -1e-3 || (rim > 1e-3 && (t / length).abs() > 1e-3)
                })
            });
            if !clear {
                continue;
            }
            let hits = exact.iter().enumerate().filter_map(|(i, hit)| Some((i, (*hit)?)));
            let hits = hits.filter(|(_, (t, u, v))| *t > 0.0 && u.min(*v).min(1.0 - u - v) > 0.0);
            let nearest = hits.min_by(|a, b| a.1.0.total_cmp(&b.1.0));
            let found = bvh.closest(&ray);
            match (nearest, found) {
                (None, None) => {}
                (Some((i, (t, u, v))), Some(hit)) => {
                    assert!((f64::from(hit.t) - t).abs() < 1e-4 * (t + length), "{hit:?}, not t {t} at scale {scale}");
                    if hit.triangle as usize == i {
                        let error = (f64::from(hit.u) - u).abs().max((f64::from(hit.v) - v).abs());
                        assert!(error < 1e-3, "{hit:?}, not u {u}, v {v}");
                    }
                }
                _ => panic!("{found:?} instead of {nearest:?} at scale {scale}: {ray:?}"),
            }
            compared += 1;
        }
        assert!(compared > 300, "only {compared} rays were clear at scale {scale}");
    }
}

const UNIT: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];
const DOWN: Ray = Ray { origin: Vec3::new(0.25, 0.5, 2.0), direction: Vec3::NEG_Z, t_min: 0.0, t_max: f32::INFINITY };

#[test]
fn parameters_count_in_lengths_of_the_direction() {
    let bvh = Bvh::build(&[UNIT]);
    let hit = Hit { t: 2.0, u: 0.25, v: 0.5, triangle: 0 };
    assert_eq!(bvh.closest(&DOWN), Some(hit));
    assert_eq!(bvh.closest(&Ray { direction: DOWN.direction * 8.0, ..DOWN }), Some(Hit { t: 0.25, ..hit }));
    assert_eq!(bvh.closest(&Ray { direction: DOWN.direction / 1024.0, ..DOWN }), Some(Hit { t: 2048.0, ..hit }));
}

#[test]
fn the_segment_is_open_at_its_start_and_closed_at_its_end() {
    let bvh = Bvh::build(&[UNIT]);
    let hits = |t_min, t_max| {
        let ray = Ray { t_min, t_max, ..DOWN };
        assert_eq!(bvh.closest(&ray).is_some(), bvh.occluded(&ray));
        bvh.occluded(&ray)
    };
    assert!(hits(0.0, 2.0) && hits(1.999, 2.001) && hits(-5.0, f32::INFINITY));
    assert!(!hits(2.0, 3.0) && !hits(0.0, 1.999) && !hits(3.0, 1.0));
    // From the surface itself, and away from behind it.
    assert!(!bvh.occluded(&Ray { origin: Vec3::new(0.25, 0.5, 0.0), ..DOWN }));
    assert!(!bvh.occluded(&Ray { origin: Vec3::new(0.25, 0.5, -1.0), t_min: -10.0, ..DOWN }));
}

#[test]
fn of_equally_near_triangles_the_first_is_hit() {
    let bvh = Bvh::build(&[[Vec3::ZERO; 3], UNIT, UNIT, [UNIT[1], UNIT[2], UNIT[0]]]);
    assert_eq!(bvh.closest(&DOWN).map(|hit| hit.triangle), Some(1));
}

#[test]
fn an_empty_mesh_is_never_hit() {
    let bvh = Bvh::build(&[]);
    assert_eq!(bvh.closest(&DOWN), None);
    assert!(!bvh.occluded(&DOWN));
    let mut hits = [None; 16];
    bvh.closest_packet(&[DOWN; 16], &mut hits);
    assert_eq!(hits, [None; 16]);
}

#[test]
fn triangles_without_area_are_never_hit_and_harm_no_other() {
    let degenerate = [
        [Vec3::ZERO; 3],
        [Vec3::ZERO, Vec3::ONE, Vec3::ZERO],
        [Vec3::ZERO, Vec3::ONE, Vec3::ONE * 2.0],
        [Vec3::NAN, Vec3::X, Vec3::Y],
        [Vec3::INFINITY, Vec3::X, Vec3::Y],
        [Vec3::X * 1e20, Vec3::X, Vec3::Y],
    ];
    let alone = Bvh::build(&degenerate);
    let mut with_one = degenerate.to_vec();
    with_one.push(UNIT);
    let with_one = Bvh::build(&with_one);
    let mut random = Random(12);
    for _ in 0..1000 {
        let ray = Ray { t_min: 0.0, ..random.ray(1.0, Vec3::ZERO) };
        let onto_line = Ray { direction: Vec3::ONE * random.number() * 2.0 - ray.origin, ..ray };
        assert_eq!(alone.closest(&ray), None);
        assert_eq!(alone.closest(&onto_line), None);
        assert!(with_one.closest(&ray).is_none_or(|hit| hit.triangle == 6));
    }
    assert_eq!(with_one.closest(&DOWN).map(|hit| hit.triangle), Some(6));
}

#[test]
fn rays_that_are_none_hit_nothing() {
    let mut random = Random(13);
    let bvh = Bvh::build(&random.soup(300, 1.0, Vec3::ZERO));
    for bad in [Vec3::NAN, Vec3::new(0.0, f32::NAN, 1.0), Vec3::INFINITY, Vec3::new(f32::NEG_INFINITY, 0.0, 0.0)] {
        for ray in [Ray { direction: bad, ..DOWN }, Ray { origin: bad, ..DOWN }] {
            assert_eq!(bvh.closest(&ray), None, "{ray:?}");
            assert!(!bvh.occluded(&ray), "{ray:?}");
        }
    }
    assert_eq!(bvh.closest(&Ray { direction: Vec3::ZERO, ..DOWN }), None);
    assert_eq!(bvh.closest(&Ray { t_min: f32::NAN, t_max: f32::NAN, ..DOWN }), None);
}
