//! Calibration: intrinsics, distortion and poses that minimise the reprojection error, by Levenberg-Marquardt.

use crate::board::Corner;
use crate::geometry::{Pose, project};
use crate::homography::homography;
use crate::zhang;
use gonio_scene::capture::Camera;
use nalgebra::{DMatrix, DVector, Vector3};

/// A photo's part of a calibration.
#[derive(Debug, Clone, PartialEq)]
pub struct PhotoFit {
    /// Board coordinates (metres; z into the board) to camera coordinates.
    pub board_to_camera: Pose,
    /// Root mean square distance of its corners from where they are predicted, pixels.
    pub error: f64,
    /// The largest of these distances, pixels.
    pub largest: f64,
}

/// A calibrated camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// Intrinsics and distortion.
    pub camera: Camera,
    /// Standard errors of fx, fy, cx, cy (pixels) and k1 k2 p1 p2 k3, from the residuals and the curvature.
    pub errors: [f64; 9],
    /// One per photo.
    pub photos: Vec<PhotoFit>,
    /// Root mean square distance over all corners, pixels; OpenCV's figure.
    pub error: f64,
}

/// Intrinsics in the vector of unknowns.
const SHARED: usize = 9;
/// Numbers of a pose.
const OWN: usize = 6;
/// A corner that falls behind the camera, pixels: no step leads there.
const BEHIND: f64 = 1e6;

/// Fewer corners than this leave a pose open.
const FEWEST: usize = 6;

/// The largest standard error of a focal length, as a part of it, and of the principal point, as a part of the picture's
/// side, with which a camera is given: a tenth is already far beyond what photos of a tilted board leave open (below a
/// hundredth), and a frontal board leaves several times the value.
const LARGEST_ERROR: f64 = 0.1;

/// Whether the corners of a photo determine where the board is.
#[must_use]
pub fn determines_pose(corners: &[Corner]) -> bool {
    corners.len() >= FEWEST && homography(corners).is_some()
}

struct State {
    camera: Camera,
    poses: Vec<Pose>,
}

/// Calibrates from the corners of every photo, all of `width` x `height` pixels. Needs three photos of different
/// directions, or more, of six corners each.
///
/// # Errors
/// Says in one line which photo (counted from 0) is no use, or that the photos do not determine a camera: in particular
/// where a standard error is a tenth of its number or more.
pub fn calibrate(width: u32, height: u32, photos: &[Vec<Corner>]) -> Result<Calibration, String> {
    if photos.len() < 3 {
        return Err(format!(
            "{} photos with the board do not determine a camera: take at least 3, tilted",
            photos.len()
        ));
    }
    let mut homographies = Vec::new();
    for (index, corners) in photos.iter().enumerate() {
        let found = if corners.len() < FEWEST { None } else { homography(corners) };
        homographies.push(found.ok_or_else(|| {
            format!("photo {index}: its {} corners do not determine the board's pose: leave it out", corners.len())
        })?);
    }
    // Views that are nearly parallel throw the closed form far off, into a valley that does not lead back: a plain
    // camera is tried too, and the better end taken.
    let starts = [zhang::intrinsics(&homographies, width, height), zhang::intrinsics(&[], width, height)];
    let mut best: Result<(State, f64), String> =
        Err("the board's poses cannot be found: take photos in which it is tilted".into());
    for camera in starts {
        let poses: Option<Vec<Pose>> = homographies.iter().map(|h| zhang::pose(&camera, h)).collect();
        let Some(poses) = poses else { continue };
        let end = descend(State { camera, poses }, photos);
        let better = match (&best, &end) {
            (Ok((_, cost)), Ok((_, value))) => value < cost,
            (Err(_), _) => true,
            (Ok(_), Err(_)) => false,
        };
        if better {
            best = end;
        }
    }
    let (state, cost) = best?;
    state.finish(photos, cost)
}

/// Levenberg-Marquardt from `state`: where it ends, and the sum of squares there.
fn descend(mut state: State, photos: &[Vec<Corner>]) -> Result<(State, f64), String> {
    let mut cost = state.cost(photos);
    let mut damping = 1e-3;
    for _ in 0..200 {
        let (normal, gradient) = state.equations(photos);
        let mut damped = normal.clone();
        for i in 0..damped.nrows() {
            damped[(i, i)] *= 1.0 + damping;
        }
        let Some(factor) = damped.cholesky() else {
            return Err("the photos do not determine a camera: tilt the board, and fill the picture with it".into());
        };
        let next = state.stepped(&factor.solve(&gradient));
        let value = next.cost(photos);
        if value < cost {
            let gain = 1.0 - value / cost;
            (state, cost, damping) = (next, value, (damping * 0.1).max(1e-12));
            if gain < 1e-12 {
                break;
            }
        } else if damping > 1e9 {
            break;
        } else {
            damping *= 10.0;
        }
    }
    Ok((state, cost))
}

impl State {
    fn residual(camera: &Camera, pose: &Pose, corner: &Corner) -> [f64; 2] {
        let point = pose.apply(&Vector3::new(corner.board[0], corner.board[1], 0.0));
        project(camera, &point).map_or([BEHIND; 2], |pixel| [corner.pixel[0] - pixel[0], corner.pixel[1] - pixel[1]])
    }

    fn cost(&self, photos: &[Vec<Corner>]) -> f64 {
        let each = self.poses.iter().zip(photos).flat_map(|(pose, corners)| corners.iter().map(move |c| (pose, c)));
        each.map(|(pose, corner)| Self::residual(&self.camera, pose, corner)).map(|[x, y]| x * x + y * y).sum()
    }

    /// Normal equations of the step; derivatives by central differences, whose error is far below the residuals'.
    fn equations(&self, photos: &[Vec<Corner>]) -> (DMatrix<f64>, DVector<f64>) {
        let size = SHARED + OWN * photos.len();
        let (mut normal, mut gradient) = (DMatrix::zeros(size, size), DVector::zeros(size));
        for (index, corners) in photos.iter().enumerate() {
            let pose = &self.poses[index];
            let place = |k: usize| if k < SHARED { k } else { SHARED + OWN * index + k - SHARED };
            for corner in corners {
                let residual = Self::residual(&self.camera, pose, corner);
                let mut slopes = [[0.0; 2]; SHARED + OWN];
                for (k, slope) in slopes.iter_mut().enumerate() {
                    let step = if k < 4 { 1e-3 } else { 1e-6 };
                    let at = |step: f64| {
                        if k < SHARED {
                            Self::residual(&bumped(&self.camera, k, step), pose, corner)
                        } else {
                            let mut own = [0.0; OWN];
                            own[k - SHARED] = step;
                            Self::residual(&self.camera, &pose.moved(&own), corner)
                        }
                    };
                    let (up, down) = (at(step), at(-step));
                    *slope = [(down[0] - up[0]) / (2.0 * step), (down[1] - up[1]) / (2.0 * step)];
                }
                for (i, a) in slopes.iter().enumerate() {
                    gradient[place(i)] += a[0] * residual[0] + a[1] * residual[1];
                    for (j, b) in slopes.iter().enumerate() {
                        normal[(place(i), place(j))] += a[0] * b[0] + a[1] * b[1];
                    }
                }
            }
        }
        (normal, gradient)
    }

    fn stepped(&self, step: &DVector<f64>) -> Self {
        let camera = (0..SHARED).fold(self.camera.clone(), |camera, k| bumped(&camera, k, step[k]));
        let own = step.as_slice()[SHARED..].chunks(OWN);
        Self { camera, poses: self.poses.iter().zip(own).map(|(pose, own)| pose.moved(own)).collect() }
    }

    fn finish(self, photos: &[Vec<Corner>], cost: f64) -> Result<Calibration, String> {
        let count = photos.iter().map(Vec::len).sum::<usize>();
        let (normal, _) = self.equations(photos);
        let freedom = (2 * count) as f64 - normal.nrows() as f64;
        if freedom <= 0.0 {
            return Err(format!("{count} corners are fewer than the camera has unknowns: add photos"));
        }
        let inverse = normal.cholesky().ok_or("the photos do not determine a camera: tilt the board more")?.inverse();
        let mut errors = [0.0; SHARED];
        errors.iter_mut().enumerate().for_each(|(k, e)| *e = (inverse[(k, k)] * cost / freedom).sqrt());
        let fit = |(pose, corners): (&Pose, &Vec<Corner>)| {
            let distances: Vec<f64> = corners
                .iter()
                .map(|corner| Self::residual(&self.camera, pose, corner))
                .map(|[x, y]| x * x + y * y)
                .collect();
            let error = (distances.iter().sum::<f64>() / distances.len() as f64).sqrt();
            let largest = distances.iter().fold(0.0, |a: f64, &b| a.max(b)).sqrt();
            PhotoFit { board_to_camera: *pose, error, largest }
        };
        let photos = self.poses.iter().zip(photos).map(fit).collect();
        if !(self.camera.fx > 0.0 && self.camera.fy > 0.0) {
            return Err("the focal length came out negative: tilt the board, and fill the picture with it".into());
        }
        let Camera { fx, fy, cx, cy, width, height, .. } = self.camera;
        let sizes = [fx, fy, f64::from(width), f64::from(height)];
        for (k, (name, value)) in [("fx", fx), ("fy", fy), ("cx", cx), ("cy", cy)].into_iter().enumerate() {
            if !(errors[k] <= LARGEST_ERROR * sizes[k]) {
                let error = errors[k];
                return Err(format!(
                    "the photos do not determine the camera: {name} came out as {value:.1} +- {error:.1} px; tilt the \
                     board by 20 to 50 degrees, another way in each photo"
                ));
            }
        }
        Ok(Calibration { camera: self.camera, errors, photos, error: (cost / count as f64).sqrt() })
    }
}

fn bumped(camera: &Camera, k: usize, step: f64) -> Camera {
    let mut camera = camera.clone();
    let [k1, k2, p1, p2, k3] = &mut camera.distortion;
    *[&mut camera.fx, &mut camera.fy, &mut camera.cx, &mut camera.cy, k1, k2, p1, p2, k3][k] += step;
    camera
}
