//! Levenberg-Marquardt over a camera and the poses of its photos. Poses are eliminated photo by photo (the Schur
//! complement; Triggs and others 1999, "Bundle adjustment - a modern synthesis", section 6).

use super::model::{Model, SHARED};
use crate::board::Corner;
use crate::geometry::{Pose, project, slopes};
use gonio_scene::capture::Camera;
use nalgebra::{DMatrix, DVector, SMatrix, SVector, Vector3};

/// Numbers of a pose.
pub(crate) const OWN: usize = 6;
/// A corner that falls behind the camera, pixels: no step leads there.
const BEHIND: f64 = 1e6;
/// Steps that are tried at most: from a closed form's start ten suffice.
const MOST_STEPS: usize = 200;
/// A gain of the sum of squares, as a part of it, that is not worth another step.
const SMALLEST_GAIN: f64 = 1e-11;

/// What each corner of each photo counts: 0 leaves it out.
pub(crate) type Weights = Vec<Vec<f64>>;

/// A camera and where the board is, photo by photo.
#[derive(Debug, Clone)]
pub(crate) struct State {
    pub(crate) camera: Camera,
    pub(crate) poses: Vec<Pose>,
}

/// Normal equations of one photo: of the camera (what both share is added up elsewhere), of both, of the pose.
struct Block {
    both: SMatrix<f64, SHARED, OWN>,
    own: SMatrix<f64, OWN, OWN>,
    gradient: SVector<f64, OWN>,
}

struct Equations {
    shared: SMatrix<f64, SHARED, SHARED>,
    gradient: SVector<f64, SHARED>,
    /// None where no corner of the photo counts.
    blocks: Vec<Option<Block>>,
}

impl State {
    /// How far each corner is from where it is predicted, pixels.
    pub(crate) fn distances(&self, photos: &[Vec<Corner>]) -> Vec<Vec<f64>> {
        let each = |(pose, corners): (&Pose, &Vec<Corner>)| {
            corners.iter().map(|corner| self.square(pose, corner).sqrt()).collect()
        };
        self.poses.iter().zip(photos).map(each).collect()
    }

    fn square(&self, pose: &Pose, corner: &Corner) -> f64 {
        let point = pose.apply(&Vector3::new(corner.board[0], corner.board[1], 0.0));
        let [x, y] =
            project(&self.camera, &point).map_or([BEHIND; 2], |pixel| [0, 1].map(|k| corner.pixel[k] - pixel[k]));
        x * x + y * y
    }

    /// The weighted sum of squares of one photo.
    pub(crate) fn photo_cost(&self, index: usize, corners: &[Corner], weights: &[f64]) -> f64 {
        let pose = &self.poses[index];
        let each = corners.iter().zip(weights).filter(|(_, weight)| **weight > 0.0);
        each.map(|(corner, weight)| weight * self.square(pose, corner)).sum()
    }

    fn cost(&self, photos: &[Vec<Corner>], weights: &Weights) -> f64 {
        photos.iter().zip(weights).enumerate().map(|(i, (corners, weights))| self.photo_cost(i, corners, weights)).sum()
    }

    fn equations(&self, photos: &[Vec<Corner>], weights: &Weights) -> Equations {
        let mut all = Equations {
            shared: SMatrix::zeros(),
            gradient: SVector::zeros(),
            blocks: Vec::with_capacity(photos.len()),
        };
        for ((pose, corners), weights) in self.poses.iter().zip(photos).zip(weights) {
            let mut block = Block { both: SMatrix::zeros(), own: SMatrix::zeros(), gradient: SVector::zeros() };
            let mut any = false;
            for (corner, &weight) in corners.iter().zip(weights).filter(|(_, weight)| **weight > 0.0) {
                let Some((pixel, slopes)) = slopes(&self.camera, pose, corner.board) else { continue };
                any = true;
                let residual = SVector::<f64, 2>::new(corner.pixel[0] - pixel[0], corner.pixel[1] - pixel[1]) * weight;
                let (camera, own) = (slopes.fixed_columns::<SHARED>(0), slopes.fixed_columns::<OWN>(SHARED));
                all.shared += camera.transpose() * camera * weight;
                all.gradient += camera.transpose() * residual;
                block.both += camera.transpose() * own * weight;
                block.own += own.transpose() * own * weight;
                block.gradient += own.transpose() * residual;
            }
            all.blocks.push(any.then_some(block));
        }
        all
    }

    /// A step in the numbers of `model` and in the poses, damped by `damping`; absent where the corners leave it open.
    fn step(
        equations: &Equations,
        model: Model,
        damping: f64,
    ) -> Option<(SVector<f64, SHARED>, Vec<SVector<f64, OWN>>)> {
        let spread = model.spread();
        let mut inverses = Vec::with_capacity(equations.blocks.len());
        for block in &equations.blocks {
            inverses.push(match block {
                Some(block) => Some((block, damped(block.own, damping).cholesky()?)),
                None => None,
            });
        }
        let mut shared = SVector::<f64, SHARED>::zeros();
        if model.columns() > 0 {
            let mut gradient = equations.gradient;
            let mut eliminated = SMatrix::<f64, SHARED, SHARED>::zeros();
            for (block, factor) in inverses.iter().flatten() {
                eliminated += block.both * factor.solve(&block.both.transpose());
                gradient -= block.both * factor.solve(&block.gradient);
            }
            let mut normal = spread.transpose() * equations.shared * &spread;
            for k in 0..normal.nrows() {
                normal[(k, k)] *= 1.0 + damping;
            }
            normal -= spread.transpose() * eliminated * &spread;
            let own: DVector<f64> = normal.cholesky()?.solve(&(spread.transpose() * gradient));
            shared.copy_from(&(&spread * own));
        }
        let own = |inverse: &Option<(&Block, _)>| match inverse {
            Some((block, factor)) => {
                let factor: &nalgebra::Cholesky<f64, nalgebra::Const<OWN>> = factor;
                factor.solve(&(block.gradient - block.both.transpose() * shared))
            }
            None => SVector::zeros(),
        };
        Some((shared, inverses.iter().map(own).collect()))
    }

    fn stepped(&self, (shared, own): &(SVector<f64, SHARED>, Vec<SVector<f64, OWN>>)) -> Self {
        let mut camera = self.camera.clone();
        camera.fx += shared[0];
        camera.fy += shared[1];
        camera.cx += shared[2];
        camera.cy += shared[3];
        camera.distortion.iter_mut().zip(&shared.as_slice()[4..]).for_each(|(term, step)| *term += step);
        Self { camera, poses: self.poses.iter().zip(own).map(|(pose, own)| pose.moved(own.as_slice())).collect() }
    }

    /// Where the weighted sum of squares is least, from here; absent where the corners do not determine `model`.
    pub(crate) fn descend(mut self, model: Model, photos: &[Vec<Corner>], weights: &Weights) -> Option<Self> {
        let mut cost = self.cost(photos, weights);
        let mut damping = 1e-3;
        let mut equations = self.equations(photos, weights);
        for _ in 0..MOST_STEPS {
            let next = self.stepped(&Self::step(&equations, model, damping)?);
            let value = next.cost(photos, weights);
            if value < cost {
                let gain = 1.0 - value / cost;
                (self, cost, damping) = (next, value, (damping * 0.1).max(1e-12));
                if gain < SMALLEST_GAIN {
                    break;
                }
                equations = self.equations(photos, weights);
            } else if damping > 1e9 {
                break;
            } else {
                damping *= 10.0;
            }
        }
        Some(self)
    }

    /// The inverse of the normal equations of `model`'s numbers, poses marginalised, for residuals of one pixel; absent
    /// where the corners do not determine them.
    pub(crate) fn covariance(&self, model: Model, photos: &[Vec<Corner>], weights: &Weights) -> Option<DMatrix<f64>> {
        let equations = self.equations(photos, weights);
        let mut normal = equations.shared;
        for block in equations.blocks.iter().flatten() {
            normal -= block.both * block.own.cholesky()?.solve(&block.both.transpose());
        }
        let spread = model.spread();
        let inverse = (spread.transpose() * normal * &spread).cholesky()?.inverse();
        Some(&spread * inverse * spread.transpose())
    }
}

fn damped(mut matrix: SMatrix<f64, OWN, OWN>, damping: f64) -> SMatrix<f64, OWN, OWN> {
    for k in 0..OWN {
        matrix[(k, k)] *= 1.0 + damping;
    }
    matrix
}
