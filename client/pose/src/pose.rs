//! A rigid motion from a model to a camera, and the camera's projection.

use glam::{DMat3, DVec2, DVec3};

/// Rows of a rotation may miss unit length and right angles by this much: files round to float32 or to few digits.
const ROTATION_TOLERANCE: f64 = 1e-2;

/// A rigid motion `x -> rotation x + translation`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Proper rotation, up to the rounding of the file that it came from.
    pub rotation: DMat3,
    /// In metres.
    pub translation: DVec3,
}

impl Pose {
    /// The motion that moves nothing.
    pub const IDENTITY: Self = Self { rotation: DMat3::IDENTITY, translation: DVec3::ZERO };

    /// The pose with the rotation's nine numbers row by row and the translation in metres; `None` if the rotation is none
    /// or a number is not finite.
    #[must_use]
    pub fn from_rows(rows: &[f64; 9], translation: [f64; 3]) -> Option<Self> {
        let rotation = DMat3::from_cols_array(rows).transpose();
        let translation = DVec3::from_array(translation);
        let gram = rotation * rotation.transpose() - DMat3::IDENTITY;
        let close = gram.to_cols_array().iter().all(|entry| entry.abs() <= ROTATION_TOLERANCE);
        (close && rotation.determinant() > 0.0 && translation.is_finite()).then_some(Self { rotation, translation })
    }

    /// The rotation's nine numbers, row by row.
    #[must_use]
    pub fn rows(&self) -> [f64; 9] {
        self.rotation.transpose().to_cols_array()
    }

    /// Where `point` goes; metres.
    #[must_use]
    pub fn apply(&self, point: DVec3) -> DVec3 {
        self.rotation * point + self.translation
    }

    /// The motion that first does `first`, then this one.
    #[must_use]
    pub fn after(&self, first: &Self) -> Self {
        Self { rotation: self.rotation * first.rotation, translation: self.apply(first.translation) }
    }

    /// The motion back.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Self { rotation, translation: -(rotation * self.translation) }
    }
}

/// A pinhole camera in BOP's pixel coordinates: the centre of the upper left pixel is (0, 0), half a pixel less than in
/// a capture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Intrinsics {
    /// Focal length along columns, in pixels.
    pub fx: f64,
    /// Focal length along rows, in pixels.
    pub fy: f64,
    /// Column of the principal point.
    pub cx: f64,
    /// Row of the principal point.
    pub cy: f64,
}

impl Intrinsics {
    /// The pixel coordinates of a point in front of the camera; infinite or mirrored where it is not in front.
    #[must_use]
    pub fn project(&self, point: DVec3) -> DVec2 {
        DVec2::new(self.fx * point.x / point.z + self.cx, self.fy * point.y / point.z + self.cy)
    }

    /// The direction of the ray through a pixel, scaled to z = 1.
    #[must_use]
    pub fn ray(&self, column: f64, row: f64) -> DVec3 {
        DVec3::new((column - self.cx) / self.fx, (row - self.cy) / self.fy, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn back_and_forth_is_nothing() {
        let pose = Pose {
            rotation: DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7),
            translation: DVec3::new(0.1, -0.2, 0.9),
        };
        let back = pose.inverse().after(&pose);
        assert!((back.rotation - DMat3::IDENTITY).to_cols_array().iter().all(|x| x.abs() < 1e-15));
        assert!(back.translation.length() < 1e-15);
        assert_eq!(Pose::from_rows(&pose.rows(), pose.translation.to_array()), Some(pose));
    }

    #[test]
    fn a_mirror_and_a_stretch_are_no_rotations() {
        assert!(Pose::from_rows(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0], [0.0; 3]).is_none());
        assert!(Pose::from_rows(&[1.1, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], [0.0; 3]).is_none());
        assert!(Pose::from_rows(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], [f64::NAN, 0.0, 0.0]).is_none());
    }

    #[test]
    fn a_ray_meets_what_it_projects() {
        let camera = Intrinsics { fx: 480.0, fy: 470.0, cx: 160.0, cy: 121.5 };
        let point = camera.ray(17.0, 200.0) * 0.8;
        assert!((camera.project(point) - DVec2::new(17.0, 200.0)).length() < 1e-12);
    }
}
