//! A part's place from clicked points: the pose of least squared distances in the photos, found from many turns.

use super::step::{Normal, moved};
use super::{Placed, Station};
use crate::Pose;
use nalgebra::{Matrix3, Rotation3, SMatrix, Vector3, Vector6};

/// A point of the part that was clicked in a photo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Click {
    /// Index of the photo.
    pub photo: usize,
    /// Where, pixels; the centre of the upper left pixel is (0.5, 0.5).
    pub pixel: [f64; 2],
    /// Which point, in the part's own coordinates, metres.
    pub point: [f64; 3],
}

/// Why clicks give no place.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Ambiguity {
    /// Fewer than three points.
    #[error("{0} clicks do not determine a place: click at least 4 points that are not in one line")]
    Few(usize),
    /// They leave a motion free.
    #[error("the clicked points leave the part's place open: click points that are not in one line")]
    Open,
    /// Two places that explain them alike, root mean square pixels.
    #[error(
        "two places explain the clicks, to {0:.2} and {1:.2} px: click one more point, or the same in another photo"
    )]
    Two(f64, f64),
}

/// Steps of a solution; a good start needs a tenth of them.
const STEPS: usize = 60;
/// Another place counts where it explains the clicks this much worse at most.
const ALIKE: f64 = 2.0;
/// Two poses are one where they differ by less, in radians and in parts of the distance to the camera.
const SAME: f64 = 0.02;

/// Where the part is.
///
/// # Errors
/// Too few points, or points that leave it open.
pub fn from_clicks(stations: &[Station], clicks: &[Click]) -> Result<Placed, Ambiguity> {
    if clicks.len() < 3 {
        return Err(Ambiguity::Few(clicks.len()));
    }
    let middle = clicks.iter().map(|c| Vector3::from(c.point)).sum::<Vector3<f64>>() / clicks.len() as f64;
    let starts = turns().into_iter().filter_map(|rotation| shifted(stations, clicks, rotation));
    let mut solved: Vec<(f64, Pose)> = starts.filter_map(|start| settled(stations, clicks, &middle, start)).collect();
    solved.sort_by(|a, b| a.0.total_cmp(&b.0));
    let &(best, pose) = solved.first().ok_or(Ambiguity::Open)?;
    let apart = |other: &Pose| {
        let turn = Rotation3::from_matrix_unchecked(pose.rotation.transpose() * other.rotation).angle();
        turn > SAME || (pose.apply(&middle) - other.apply(&middle)).norm() > SAME * pose.apply(&middle).norm().max(0.1)
    };
    // Clicks are good to a third of a pixel at best.
    if let Some((other, _)) = solved.iter().find(|(rms, other)| *rms < ALIKE * best.max(0.3) && apart(other)) {
        return Err(Ambiguity::Two(best, *other));
    }
    let normal = normal(stations, clicks, &middle, &pose).ok_or(Ambiguity::Open)?;
    let inverse = normal.matrix.try_inverse().ok_or(Ambiguity::Open)?;
    let noise = normal.squares / (normal.count - 6.0).max(1.0);
    let errors: [f64; 6] = std::array::from_fn(|k| (noise * inverse[(k, k)]).sqrt());
    if errors.iter().any(|error| !error.is_finite()) {
        return Err(Ambiguity::Open);
    }
    Ok(Placed { pose, pixels: best, errors })
}

/// Turns from which every other one is within a descent: the 24 of a cube, and those turned by 45 degrees about (1, 1, 1) and
/// about (1, -1, 0).
fn turns() -> Vec<Matrix3<f64>> {
    let axes: [Vector3<f64>; 6] =
        [Vector3::x(), Vector3::y(), Vector3::z(), -Vector3::x(), -Vector3::y(), -Vector3::z()];
    let mut turns = Vec::new();
    for a in axes {
        for b in axes.into_iter().filter(|b| a.dot(b).abs() < 0.5) {
            turns.push(Matrix3::from_columns(&[a, b, a.cross(&b)]));
        }
    }
    let more = [Vector3::new(1.0, 1.0, 1.0), Vector3::new(1.0, -1.0, 0.0)].map(|axis| {
        Rotation3::from_axis_angle(&nalgebra::Unit::new_normalize(axis), std::f64::consts::FRAC_PI_4).into_inner()
    });
    let turned: Vec<Matrix3<f64>> = more.iter().flat_map(|extra| turns.iter().map(move |turn| extra * turn)).collect();
    turns.extend(turned);
    turns
}

/// The shift of least squares of a part that is turned so: each pixel gives two equations that are linear in it. Distortion,
/// which is small, is left to the steps that follow.
fn shifted(stations: &[Station], clicks: &[Click], rotation: Matrix3<f64>) -> Option<Pose> {
    let (mut matrix, mut vector) = (Matrix3::zeros(), Vector3::zeros());
    for click in clicks {
        let Station { camera, to_camera } = stations.get(click.photo)?;
        let at = [(click.pixel[0] - camera.cx) / camera.fx, (click.pixel[1] - camera.cy) / camera.fy];
        let known = to_camera.rotation * (rotation * Vector3::from(click.point)) + to_camera.translation;
        for (axis, tangent) in at.into_iter().enumerate() {
            let row = (to_camera.rotation.row(axis) - to_camera.rotation.row(2) * tangent).transpose();
            matrix += row * row.transpose();
            vector -= row * (known[axis] - tangent * known.z);
        }
    }
    let translation = matrix.cholesky()?.solve(&vector);
    translation.iter().all(|x| x.is_finite()).then_some(Pose { rotation, translation })
}

/// Root mean square pixels and pose after the descent from `start`; absent where a point ends behind its camera.
fn settled(stations: &[Station], clicks: &[Click], middle: &Vector3<f64>, start: Pose) -> Option<(f64, Pose)> {
    let mut pose = start;
    let mut sums = normal(stations, clicks, middle, &pose)?;
    let mut damping = 1e-3;
    for _ in 0..STEPS {
        let step = sums.step(damping)?;
        let next = moved(&pose, &pose.apply(middle), &step);
        match normal(stations, clicks, middle, &next) {
            Some(better) if better.squares <= sums.squares => {
                let done = sums.squares - better.squares <= 1e-12 * sums.squares;
                (pose, sums, damping) = (next, better, damping * 0.2);
                if done {
                    break;
                }
            }
            _ => damping *= 8.0,
        }
        if damping > 1e12 {
            break;
        }
    }
    Some(((2.0 * sums.squares / sums.count).sqrt(), pose))
}

/// Distances and their derivatives by the pose, differences of 1e-6 each way.
fn normal(stations: &[Station], clicks: &[Click], middle: &Vector3<f64>, pose: &Pose) -> Option<Normal> {
    const H: f64 = 1e-6;
    let mut normal = Normal::new();
    let about = pose.apply(middle);
    for click in clicks {
        let station = stations.get(click.photo)?;
        let seen = |pose: &Pose| station.see(&pose.apply(&Vector3::from(click.point)));
        let here = seen(pose)?;
        let mut slopes = SMatrix::<f64, 6, 2>::zeros();
        for k in 0..6 {
            let mut step = Vector6::zeros();
            step[k] = H;
            let (ahead, behind) = (seen(&moved(pose, &about, &step))?, seen(&moved(pose, &about, &-step))?);
            (0..2).for_each(|axis| slopes[(k, axis)] = (ahead[axis] - behind[axis]) / (2.0 * H));
        }
        for (axis, (seen, clicked)) in here.into_iter().zip(click.pixel).enumerate() {
            normal.add(seen - clicked, &slopes.column(axis).into_owned());
        }
    }
    Some(normal)
}
