//! The triangles of all objects in world coordinates, and what a ray that hits one finds there.

use crate::affine::affine;
use crate::bvh::{Bundle, Bvh, Hit, Hits, Ray};
use crate::extent::Extent;
use crate::paint::{Factors, Paint, Painter, PartMaps};
use crate::scene::Loaded;
use crate::vectors::{BLOCK, Lanes, Vectors, equal};
use glam::{DVec3, Vec3};
use gonio_scene::capture::{CAPTURE_FILE, Object};
use gonio_scene::{Capture, Result, SceneError};

/// World-space triangles under a BVH.
pub struct Geometry {
    bvh: Bvh,
    triangles: Vec<Triangle>,
    /// By object.
    extents: Vec<Extent>,
    /// All objects' parts, each of one material.
    parts: Vec<Part>,
    /// By object: what varies over it.
    paints: Vec<Option<Paint>>,
    /// [`gonio_scene::capture::Tracing::ray_offset`].
    ray_offset: f32,
}

/// What the triangles of one of an object's materials share.
struct Part {
    /// Index of the object in the capture.
    object: usize,
    maps: PartMaps,
}

/// What shading needs of a triangle, together, because a hit reads all of it.
struct Triangle {
    vertices: [Vec3; 3],
    /// Vertex normals; face normals, three times, where the mesh has none.
    normals: [Vec3; 3],
    /// Unit face normal, on the side that the winding shows counter-clockwise.
    face: Vec3,
    /// Index among the parts of all objects.
    part: u32,
    /// Bounds of [`Surface::margin`]: what rounding asks for, what the object's size allows.
    margins: [f32; 2],
}

/// A point on a surface.
#[derive(Debug, Clone, Copy)]
pub struct Surface {
    /// World position.
    pub position: Vec3,
    /// Unit normal of the triangle's plane.
    pub face: Vec3,
    /// Unit interpolated normal, for shading.
    pub normal: Vec3,
    /// Index among the parts of all objects, each of one material.
    pub part: usize,
    /// Distance off the face at which a ray starts, so that it misses it.
    pub margin: f32,
    /// The triangle that was hit, and the weights of its second and third corner.
    pub triangle: u32,
    pub barycentric: [f32; 2],
    /// How wide the ray is that came here, metres: what is finer is averaged. 0 for all but camera rays.
    pub footprint: f32,
}

/// Where an object is, row-major; `None` where it is not there at all.
pub type Place = Option<[[f64; 4]; 4]>;

/// Where a capture's objects are: equal places, equal geometry. Object `but` is taken to be absent.
#[must_use]
pub fn places(capture: &Capture, but: Option<usize>) -> Vec<Place> {
    let place =
        |(index, object): (usize, &Object)| (object.presence > 0.0 && but != Some(index)).then(|| object.placement());
    capture.objects.iter().enumerate().map(place).collect()
}

impl Geometry {
    /// Puts the meshes of a capture's objects where `places` has them in the world.
    ///
    /// # Errors
    /// A transform that takes vertices out of single precision's range; a mesh that was not loaded.
    pub fn new(capture: &Capture, places: &[Place], loaded: &Loaded) -> Result<Self> {
        let assets = &loaded.assets;
        let mut triangles = Vec::new();
        let mut parts = Vec::new();
        let mut paints = Vec::with_capacity(capture.objects.len());
        let mut extents = vec![Extent::default(); capture.objects.len()];
        for (index, (object, place)) in capture.objects.iter().zip(places).enumerate() {
            let first_part = parts.len() as u32;
            let mut maps = Vec::new();
            for part in assets.parts(capture, object)? {
                maps.push(PartMaps::new(&part, object, &loaded.textures)?);
            }
            let mut painter = Painter::new(capture, object, assets, &maps, triangles.len());
            parts.extend(maps.into_iter().map(|maps| Part { object: index, maps }));
            let Some(place) = place else {
                paints.push(None);
                continue;
            };
            let look = assets.looks.get(&object.mesh).filter(|_| parts.len() as u32 > first_part + 1);
            let refuse = |problem: String, mend: &str| {
                SceneError::new(CAPTURE_FILE, problem, mend).at(format!("object.{}", object.name))
            };
            let mesh = assets
                .meshes
                .get(&object.mesh)
                .ok_or_else(|| refuse(format!("mesh {} was not loaded", object.mesh), "load the capture's assets"))?;
            let pose = affine(place);
            extents[index] = Extent::new(&pose, &mesh.positions);
            let linear = pose.matrix3;
            let cofactor = linear.inverse().transpose();
            let mirror = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
            let to_world = |p: &[f32; 3]| (linear * DVec3::from(p.map(f64::from)) + pose.translation).as_vec3();
            let world: Vec<Vec3> = mesh.positions.iter().map(to_world).collect();
            if let Some(i) = world.iter().position(|p| !p.is_finite() || p.abs().max_element() > 1e9) {
                return Err(refuse(
                    format!("places vertex {i} at {}", world[i]),
                    "mend object_to_world or the mesh's units (metres)",
                ));
            }
            let low = world.iter().copied().reduce(Vec3::min).unwrap_or_default();
            let high = world.iter().copied().reduce(Vec3::max).unwrap_or_default();
            let most = MOST_OFFSET * low.distance(high);
            let turn = |n: &[f32; 3]| (cofactor * DVec3::from(n.map(f64::from))).normalize().as_vec3();
            let turned: Option<Vec<Vec3>> = mesh.normals.as_ref().map(|n| n.iter().map(turn).collect());
            for (number, t) in mesh.triangles.iter().enumerate() {
                let corner = |k: usize| t[k] as usize;
                let v = [world[corner(0)], world[corner(1)], world[corner(2)]];
                let cross = (v[1] - v[0]).as_dvec3().cross((v[2] - v[0]).as_dvec3());
                // Rounding to world coordinates may flatten a sliver: it has no area that light could see.
                let Some(face) = cross.try_normalize().map(|f| (f * mirror).as_vec3()) else { continue };
                let normals = turned.as_ref().map_or([face; 3], |n| [n[corner(0)], n[corner(1)], n[corner(2)]]);
                let extent = v[0].abs().max(v[1].abs()).max(v[2].abs()).max_element();
                let margins = [extent * MARGIN, most.max(extent * MARGIN)];
                let part = first_part + look.map_or(0, |look| look.group_of(number)) as u32;
                triangles.push(Triangle { vertices: v, normals, face, part, margins });
                painter.add(mesh, number, &v);
            }
            paints.push(painter.finish());
        }
        let corners: Vec<[Vec3; 3]> = triangles.iter().map(|t| t.vertices).collect();
        let ray_offset = capture.tracing.ray_offset as f32;
        Ok(Self { bvh: Bvh::build(&corners), triangles, extents, parts, paints, ray_offset })
    }

    /// The nearest triangle along a ray.
    #[inline]
    #[must_use]
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        self.bvh.closest(ray)
    }

    /// Whether anything lies on a ray.
    #[inline]
    #[must_use]
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.bvh.occluded(ray)
    }

    /// [`Geometry::closest`] for rays that start and run close together.
    pub fn closest_bundle(&self, rays: &Bundle, hits: &mut Hits) {
        self.bvh.closest_bundle(rays, hits);
    }

    /// [`Geometry::closest`] for rays that start close together and mostly hit nothing.
    pub fn closest_stream(&self, rays: &Bundle, hits: &mut Hits) {
        self.bvh.closest_stream(rays, hits);
    }

    /// [`Geometry::occluded`] for rays that start and run close together, as bits.
    #[must_use]
    pub fn occluded_bundle(&self, rays: &Bundle) -> u32 {
        self.bvh.occluded_bundle(rays)
    }

    /// The object of a triangle that was hit.
    #[inline]
    #[must_use]
    pub fn object_of(&self, triangle: u32) -> usize {
        self.parts[self.part_of(triangle)].object
    }

    /// The part of a triangle that was hit, among the parts of all objects.
    #[inline]
    #[must_use]
    pub fn part_of(&self, triangle: u32) -> usize {
        self.triangles[triangle as usize].part as usize
    }

    /// Where the bounding box of the object lies that a surface belongs to.
    #[inline]
    #[must_use]
    pub fn extent_at(&self, surface: &Surface) -> &Extent {
        &self.extents[self.parts[surface.part].object]
    }

    /// What maps make of a material's numbers at a point.
    #[must_use]
    pub fn factors(&self, surface: &Surface) -> Factors {
        let part = &self.parts[surface.part];
        self.paints[part.object].as_ref().map_or(Factors::ONE, |paint| paint.at(&part.maps, surface))
    }

    /// What lies at a hit.
    #[inline(always)]
    #[must_use]
    pub fn surface(&self, hit: &Hit) -> Surface {
        let triangle = &self.triangles[hit.triangle as usize];
        let (position, normal) = triangle.at(hit.u, hit.v);
        let margin = triangle.margin(position, self.ray_offset);
        let (part, barycentric) = (triangle.part as usize, [hit.u, hit.v]);
        let (face, triangle) = (triangle.face, hit.triangle);
        Surface { position, face, normal, part, margin, triangle, barycentric, footprint: 0.0 }
    }

    /// What lies at the hits of the lanes in `mask`.
    #[inline(always)]
    pub fn surfaces(&self, hits: &Hits, mask: u32, into: &mut Surfaces) {
        let mut todo = mask;
        while todo != 0 {
            let lane = todo.trailing_zeros() as usize % BLOCK;
            let index = hits.triangle[lane];
            let triangle = &self.triangles[index as usize];
            let same = equal(&hits.triangle, index);
            todo &= !same;
            if same & (same - 1) == 0 {
                let (position, normal) = triangle.at(hits.u[lane], hits.v[lane]);
                into.set(lane, position, triangle.face, normal, triangle.margin(position, self.ray_offset));
                continue;
            }
            // Samples of a pixel mostly share a few triangles.
            for lane in 0..BLOCK {
                let (position, normal) = triangle.at(hits.u[lane], hits.v[lane]);
                let old = (into.position.get(lane), into.face.get(lane), into.normal.get(lane), into.margin[lane]);
                let hit = same >> lane & 1 != 0;
                into.set(
                    lane,
                    pick(hit, position, old.0),
                    pick(hit, triangle.face, old.1),
                    pick(hit, normal, old.2),
                    one(hit, triangle.margin(position, self.ray_offset), old.3),
                );
            }
        }
    }
}

#[inline(always)]
fn one(first: bool, a: f32, b: f32) -> f32 {
    if first { a } else { b }
}

#[inline(always)]
fn pick(first: bool, a: Vec3, b: Vec3) -> Vec3 {
    Vec3::new(one(first, a.x, b.x), one(first, a.y, b.y), one(first, a.z, b.z))
}

impl Triangle {
    /// Position and shading normal.
    #[inline(always)]
    fn at(&self, u: f32, v: f32) -> (Vec3, Vec3) {
        let [a, b, c] = self.vertices;
        let [na, nb, nc] = self.normals;
        let w = 1.0 - u - v;
        (a * w + b * u + c * v, unit_or(na * w + nb * u + nc * v, self.face))
    }

    /// See [`Surface::margin`].
    #[inline(always)]
    fn margin(&self, position: Vec3, ray_offset: f32) -> f32 {
        let [least, most] = self.margins;
        ((1.0 + position.abs().max_element()) * ray_offset).clamp(least, most)
    }
}

/// [`Vec3::normalize_or`] without a branch.
#[inline(always)]
fn unit_or(v: Vec3, fallback: Vec3) -> Vec3 {
    let inverse = v.length_recip();
    pick((inverse > 0.0) & (inverse < f32::INFINITY), v * inverse, fallback)
}

/// Surfaces side by side.
#[derive(Debug, Clone, Copy)]
pub struct Surfaces {
    pub position: Vectors,
    pub face: Vectors,
    pub normal: Vectors,
    pub margin: Lanes,
}

impl Surfaces {
    /// All zero.
    pub const ZERO: Self =
        Self { position: Vectors::ZERO, face: Vectors::ZERO, normal: Vectors::ZERO, margin: [0.0; BLOCK] };

    #[inline(always)]
    fn set(&mut self, lane: usize, position: Vec3, face: Vec3, normal: Vec3, margin: f32) {
        self.position.set(lane, position);
        self.face.set(lane, face);
        self.normal.set(lane, normal);
        self.margin[lane] = margin;
    }

    /// [`Surface::ray`] without an end, in every lane; which lanes hold a ray stays as it is.
    #[inline(always)]
    pub fn rays(&self, direction: &Vectors, into: &mut Bundle) {
        for lane in 0..BLOCK {
            into.origin.set(lane, self.off(lane, direction.get(lane)));
        }
        into.direction = *direction;
        into.t_max = [f32::INFINITY; BLOCK];
    }

    /// As [`Surface::ray_to`], in every lane; which lanes hold a ray stays as it is.
    #[inline(always)]
    pub fn rays_to(&self, direction: &Vectors, distance: &Lanes, into: &mut Bundle) {
        for lane in 0..BLOCK {
            let (towards, distance) = (direction.get(lane), distance[lane]);
            let origin = self.off(lane, towards);
            let way = self.position.get(lane) + towards * distance - origin;
            let length = way.length();
            let endless = distance == f32::INFINITY;
            into.origin.set(lane, origin);
            into.direction.set(lane, pick(endless, towards, way / length));
            into.t_max[lane] = one(endless, distance, length * (1.0 - 1e-4));
        }
    }

    #[inline(always)]
    fn off(&self, lane: usize, direction: Vec3) -> Vec3 {
        let (face, margin) = (self.face.get(lane), self.margin[lane]);
        self.position.get(lane) + face * one(face.dot(direction) < 0.0, -margin, margin)
    }
}

/// Rounding error of an interpolated position relative to its triangle's largest coordinate, with room for the
/// intersection test's own: pbrt's bound for three products and two sums is about 7 units in the last place.
const MARGIN: f32 = 24.0 * f32::EPSILON;

/// Largest offset of a ray relative to the diagonal of the object that it leaves: small parts keep their shadows.
const MOST_OFFSET: f32 = 0.01;

impl Surface {
    /// A ray from just off the surface towards `direction`.
    #[inline]
    #[must_use]
    pub fn ray(&self, direction: Vec3, t_max: f32) -> Ray {
        Ray { origin: self.off(direction), direction, t_min: 0.0, t_max }
    }

    /// A ray from just off the surface to just before the point that lies `distance` from the surface along `direction`.
    #[inline]
    #[must_use]
    pub fn ray_to(&self, direction: Vec3, distance: f32) -> Ray {
        let origin = self.off(direction);
        if distance == f32::INFINITY {
            return Ray { origin, direction, t_min: 0.0, t_max: distance };
        }
        let way = self.position + direction * distance - origin;
        let length = way.length();
        Ray { origin, direction: way / length, t_min: 0.0, t_max: length * (1.0 - 1e-4) }
    }

    #[inline]
    fn off(&self, direction: Vec3) -> Vec3 {
        self.position + self.face * if self.face.dot(direction) < 0.0 { -self.margin } else { self.margin }
    }
}
