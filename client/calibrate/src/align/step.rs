//! Steps of a pose, and the normal equations that give them.

use crate::Pose;
use nalgebra::{Matrix6, Rotation3, Vector3, Vector6};

/// `pose` turned by the first three numbers (a rotation vector along the world's axes, radians) about `middle`, and shifted by
/// the others, metres.
pub fn moved(pose: &Pose, middle: &Vector3<f64>, step: &Vector6<f64>) -> Pose {
    let turn = Rotation3::new(Vector3::new(step[0], step[1], step[2]));
    let shift = Vector3::new(step[3], step[4], step[5]);
    Pose { rotation: turn.matrix() * pose.rotation, translation: turn * (pose.translation - middle) + middle + shift }
}

/// Sums of a least-squares problem.
#[derive(Debug, Clone)]
pub struct Normal {
    pub matrix: Matrix6<f64>,
    pub vector: Vector6<f64>,
    pub squares: f64,
    pub count: f64,
}

impl Normal {
    pub fn new() -> Self {
        Self { matrix: Matrix6::zeros(), vector: Vector6::zeros(), squares: 0.0, count: 0.0 }
    }

    /// Adds a residual and its derivatives.
    pub fn add(&mut self, residual: f64, slope: &Vector6<f64>) {
        self.matrix += slope * slope.transpose();
        self.vector += slope * residual;
        self.squares += residual * residual;
        self.count += 1.0;
    }

    /// The step to the least, damped by a share of the diagonal; absent where it is not determined.
    pub fn step(&self, damping: f64) -> Option<Vector6<f64>> {
        let mut matrix = self.matrix;
        for k in 0..6 {
            matrix[(k, k)] *= 1.0 + damping;
        }
        let step = -matrix.cholesky()?.solve(&self.vector);
        step.iter().all(|x| x.is_finite()).then_some(step)
    }
}
