//! Errors that follow from the model's vertices: MSSD and MSPD (Hodan et al. 2020), ADD and ADD-S (Hinterstoisser et al.
//! 2012), projection (Brachmann et al. 2016).

use crate::bop::Model;
use crate::{Intrinsics, Pose};
use glam::{DMat3, DVec3};
use rstar::RTree;

/// Largest way of a vertex between neighbouring turns round an axis of symmetry, as a part of the diameter.
const SYMMETRY_STEP: f64 = 0.01;

/// A model prepared for its errors.
#[derive(Debug)]
pub struct Shape {
    vertices: Vec<DVec3>,
    symmetries: Vec<Pose>,
    tree: RTree<[f64; 3]>,
    /// In metres.
    pub diameter: f64,
}

impl Shape {
    /// Of `model`, its axes of symmetry cut into steps of a hundredth of the diameter.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        let vertices: Vec<DVec3> = model.vertices().collect();
        let tree = RTree::bulk_load(vertices.iter().map(DVec3::to_array).collect());
        Self { vertices, symmetries: model.symmetries(SYMMETRY_STEP), tree, diameter: model.diameter }
    }

    /// Largest distance of a vertex from its true place, for the symmetry that makes it least; metres.
    #[must_use]
    pub fn mssd(&self, estimate: &Pose, truth: &Pose) -> f64 {
        // A rigid motion changes no distance: everything is compared in the model's frame.
        let moved = truth.inverse().after(estimate);
        self.least(|symmetry, vertex| (moved.apply(vertex) - symmetry.apply(vertex)).length_squared())
    }

    /// Largest distance of a vertex from its true place in the image, for the symmetry that makes it least; pixels.
    #[must_use]
    pub fn mspd(&self, estimate: &Pose, truth: &Pose, camera: &Intrinsics) -> f64 {
        self.least(|symmetry, vertex| {
            let there = camera.project(truth.apply(symmetry.apply(vertex)));
            (camera.project(estimate.apply(vertex)) - there).length_squared()
        })
    }

    /// Mean distance of the vertices from their true places; metres.
    #[must_use]
    pub fn add(&self, estimate: &Pose, truth: &Pose) -> f64 {
        self.mean(|vertex| (estimate.apply(vertex) - truth.apply(vertex)).length())
    }

    /// Mean distance of the true vertices from the nearest estimated one; metres.
    #[must_use]
    pub fn add_s(&self, estimate: &Pose, truth: &Pose) -> f64 {
        // Seen from the estimate, the tree stands still.
        let moved = estimate.inverse().after(truth);
        self.mean(|vertex| {
            let place = moved.apply(vertex);
            self.tree
                .nearest_neighbor(&place.to_array())
                .map_or(f64::NAN, |nearest| (place - DVec3::from_array(*nearest)).length())
        })
    }

    /// Mean distance of the vertices from their true places in the image; pixels.
    #[must_use]
    pub fn projection(&self, estimate: &Pose, truth: &Pose, camera: &Intrinsics) -> f64 {
        self.mean(|vertex| (camera.project(estimate.apply(vertex)) - camera.project(truth.apply(vertex))).length())
    }

    fn mean(&self, error: impl Fn(DVec3) -> f64) -> f64 {
        let count = u32::try_from(self.vertices.len()).unwrap_or(u32::MAX);
        self.vertices.iter().map(|&vertex| error(vertex)).sum::<f64>() / f64::from(count)
    }

    /// The least, over the symmetries, of the largest error; the error comes squared.
    fn least(&self, squared: impl Fn(&Pose, DVec3) -> f64) -> f64 {
        let mut least = f64::INFINITY;
        for symmetry in &self.symmetries {
            let mut largest = 0.0;
            for &vertex in &self.vertices {
                let error = squared(symmetry, vertex);
                // A vertex in the camera's plane has no place in the image.
                largest = if error.is_nan() { f64::INFINITY } else { error.max(largest) };
                if largest >= least {
                    break;
                }
            }
            least = least.min(largest);
        }
        least.sqrt()
    }
}

/// Angle between the rotations, in degrees.
#[must_use]
pub fn rotation(estimate: &Pose, truth: &Pose) -> f64 {
    let between: DMat3 = estimate.rotation * truth.rotation.transpose();
    let cosine = (between.x_axis.x + between.y_axis.y + between.z_axis.z - 1.0) / 2.0;
    libm::acos(cosine.clamp(-1.0, 1.0)).to_degrees()
}

/// Distance between the translations, in metres.
#[must_use]
pub fn translation(estimate: &Pose, truth: &Pose) -> f64 {
    (estimate.translation - truth.translation).length()
}

#[cfg(test)]
mod tests {
    use super::*;
    use gonio_scene::mesh::Mesh;

    /// The eight corners of a box of half sizes a, b, c: 2 m, 4 m, 6 m.
    fn cuboid() -> Model {
        let sign = |bit: u8, half: f32| if bit == 0 { -half } else { half };
        let positions = (0..8u8).map(|i| [sign(i & 1, 1.0), sign(i & 2, 2.0), sign(i & 4, 3.0)]).collect();
        let mesh = Mesh { positions, normals: None, triangles: vec![[0, 1, 2]], degenerate: 0 };
        Model { mesh, diameter: 56f64.sqrt(), discrete: Vec::new(), continuous: Vec::new() }
    }

    fn turned(axis: DVec3, degrees: f64) -> Pose {
        Pose { rotation: DMat3::from_axis_angle(axis, degrees.to_radians()), translation: DVec3::ZERO }
    }

    const CAMERA: Intrinsics = Intrinsics { fx: 100.0, fy: 100.0, cx: 0.0, cy: 0.0 };

    #[test]
    fn a_shift_moves_every_vertex_alike() {
        let shape = Shape::new(&cuboid());
        let truth = Pose { translation: DVec3::new(0.0, 0.0, 20.0), ..turned(DVec3::X, 20.0) };
        let shift = DVec3::new(0.03, 0.0, 0.04);
        let estimate = Pose { translation: truth.translation + shift, ..truth };
        assert!((shape.mssd(&estimate, &truth) - 0.05).abs() < 1e-12);
        assert!((shape.add(&estimate, &truth) - 0.05).abs() < 1e-12);
        assert!((shape.add_s(&estimate, &truth) - 0.05).abs() < 1e-12);
        assert!((translation(&estimate, &truth) - 0.05).abs() < 1e-12);
        assert_eq!(rotation(&estimate, &truth), 0.0);
    }

    #[test]
    fn a_turn_moves_a_vertex_along_its_chord() {
        let shape = Shape::new(&cuboid());
        let (truth, estimate) = (Pose::IDENTITY, turned(DVec3::Z, 30.0));
        // Every corner is sqrt(1 + 4) m from the axis.
        let chord = 2.0 * 5f64.sqrt() * libm::sin(15f64.to_radians());
        assert!((shape.mssd(&estimate, &truth) - chord).abs() < 1e-12);
        assert!((shape.add(&estimate, &truth) - chord).abs() < 1e-12);
        assert!((rotation(&estimate, &truth) - 30.0).abs() < 1e-9);
    }

    #[test]
    fn a_symmetry_takes_the_error_away_where_it_should() {
        let mut model = cuboid();
        let (truth, estimate) = (turned(DVec3::Y, 10.0), turned(DVec3::Y, 10.0).after(&turned(DVec3::Z, 180.0)));
        let place = |pose: Pose| Pose { translation: DVec3::new(0.0, 0.0, 20.0), ..pose };
        let (truth, estimate) = (place(truth), place(estimate));
        let blind = Shape::new(&model);
        assert!((blind.mssd(&estimate, &truth) - 20f64.sqrt()).abs() < 1e-9);
        assert!(blind.mspd(&estimate, &truth, &CAMERA) > 10.0);
        // The set of corners is the same, so ADD-S knows without being told, and ADD does not though it is.
        assert!(blind.add_s(&estimate, &truth) < 1e-9);
        model.discrete.push(turned(DVec3::Z, 180.0));
        let knowing = Shape::new(&model);
        assert!(knowing.mssd(&estimate, &truth) < 1e-9 && knowing.mspd(&estimate, &truth, &CAMERA) < 1e-9);
        assert!((knowing.add(&estimate, &truth) - 20f64.sqrt()).abs() < 1e-9);
    }

    #[test]
    fn a_turn_round_an_axis_of_symmetry_costs_at_most_half_a_step() {
        let mut model = cuboid();
        model.continuous.push((DVec3::Z, DVec3::ZERO));
        let shape = Shape::new(&model);
        let step = std::f64::consts::TAU / 315.0;
        for degrees in [5.0, 77.7, 181.0, 300.0] {
            let error = shape.mssd(&turned(DVec3::Z, degrees), &Pose::IDENTITY);
            assert!(error <= 5f64.sqrt() * step / 2.0 + 1e-12, "{degrees}: {error}");
        }
        let tilted = shape.mssd(&turned(DVec3::X, 10.0), &Pose::IDENTITY);
        assert!(tilted > 2.0 * 3.0 * libm::sin(5f64.to_radians()), "{tilted}");
    }

    #[test]
    fn a_shift_across_the_view_moves_the_nearest_corner_most_in_the_image() {
        let shape = Shape::new(&cuboid());
        let truth = Pose { translation: DVec3::new(0.0, 0.0, 20.0), ..Pose::IDENTITY };
        let estimate = Pose { translation: DVec3::new(0.1, 0.0, 20.0), ..Pose::IDENTITY };
        // Corners are at z = 17 and z = 23: 100 * 0.1 / z.
        assert!((shape.mspd(&estimate, &truth, &CAMERA) - 10.0 / 17.0).abs() < 1e-12);
        let mean = (10.0 / 17.0 + 10.0 / 23.0) / 2.0;
        assert!((shape.projection(&estimate, &truth, &CAMERA) - mean).abs() < 1e-12);
    }

    #[test]
    fn a_vertex_in_the_cameras_plane_is_no_small_error() {
        let shape = Shape::new(&cuboid());
        let truth = Pose { translation: DVec3::new(0.0, 0.0, 20.0), ..Pose::IDENTITY };
        let through = Pose { translation: DVec3::new(0.0, 0.0, 3.0), ..Pose::IDENTITY };
        assert_eq!(shape.mspd(&through, &truth, &CAMERA), f64::INFINITY);
    }
}
