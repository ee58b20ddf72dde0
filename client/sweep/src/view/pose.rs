//! Where a virtual camera stands: OpenCV axes (x right, y down, z forward) in a world whose z is up.

/// A camera that looks at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pose {
    /// World coordinates, metres.
    pub target: [f64; 3],
    /// Radians from the world's x axis towards y, of the camera seen from the target.
    pub azimuth: f64,
    /// Radians above the horizontal plane.
    pub elevation: f64,
    /// Metres from the target.
    pub distance: f64,
    /// Radians by which the camera is turned clockwise about its view; at 0 the image's rows are horizontal.
    pub roll: f64,
}

impl Pose {
    /// A camera at `position` that looks at `target`; `None` where the two are the same.
    pub fn between(position: [f64; 3], target: [f64; 3], roll: f64) -> Option<Self> {
        let [x, y, z] = [0, 1, 2].map(|i| position[i] - target[i]);
        let distance = (x * x + y * y + z * z).sqrt();
        let (azimuth, elevation) = (libm::atan2(y, x), libm::atan2(z, (x * x + y * y).sqrt()));
        (distance > 0.0 && distance.is_finite()).then_some(Self { target, azimuth, elevation, distance, roll })
    }

    /// Maps camera coordinates to world coordinates, row-major.
    pub fn camera_to_world(&self) -> [[f64; 4]; 4] {
        let (sa, ca) = (libm::sin(self.azimuth), libm::cos(self.azimuth));
        let (se, ce) = (libm::sin(self.elevation), libm::cos(self.elevation));
        let (sr, cr) = (libm::sin(self.roll), libm::cos(self.roll));
        // Level axes first; at the zenith they are those of a camera that was carried up along its azimuth.
        let (right, down, forward) = ([-sa, ca, 0.0], [ca * se, sa * se, -ce], [-ca * ce, -sa * ce, -se]);
        let mut matrix = [[0.0; 4]; 4];
        matrix[3][3] = 1.0;
        for i in 0..3 {
            let (x, y) = (cr * right[i] + sr * down[i], cr * down[i] - sr * right[i]);
            matrix[i] = [x, y, forward[i], self.target[i] - self.distance * forward[i]];
        }
        matrix
    }
}

/// That a matrix can be a camera's: a rotation, to the digits that poses are written with.
pub(super) fn rotation(m: &[[f64; 4]; 4]) -> Result<(), String> {
    let column = |j: usize| [m[0][j], m[1][j], m[2][j]];
    let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    for i in 0..3 {
        for j in i..3 {
            let (product, expected) = (dot(column(i), column(j)), if i == j { 1.0 } else { 0.0 });
            if (product - expected).abs() > 2e-3 {
                return Err(format!("is no rotation: columns {i} and {j} have the product {product:.4}"));
            }
        }
    }
    let ([a, b, c], [d, e, f]) = (column(0), column(1));
    let across = [b * f - c * e, c * d - a * f, a * e - b * d];
    if dot(across, column(2)) < 0.0 {
        return Err("mirrors: its determinant is -1".to_owned());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn apply(m: &[[f64; 4]; 4], p: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|i| m[i][0] * p[0] + m[i][1] * p[1] + m[i][2] * p[2] + m[i][3])
    }

    fn near(a: [f64; 3], b: [f64; 3]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12)
    }

    #[test]
    fn a_camera_sees_its_target_ahead_and_up_above() {
        let (position, target) = ([0.3, -0.4, 0.9], [0.1, 0.2, 0.05]);
        let pose = Pose::between(position, target, 0.0).unwrap();
        let m = pose.camera_to_world();
        rotation(&m).unwrap();
        assert!(near(apply(&m, [0.0; 3]), position));
        assert!(near(apply(&m, [0.0, 0.0, pose.distance]), target));
        // Image rows are level, and what is higher in the image (smaller y) is higher in the world.
        assert!(m[2][0].abs() < 1e-15 && m[2][1] < 0.0);
    }

    #[test]
    fn a_quarter_roll_turns_the_camera_clockwise() {
        let level = Pose { target: [0.0; 3], azimuth: 0.7, elevation: 0.4, distance: 2.0, roll: 0.0 };
        let rolled = Pose { roll: std::f64::consts::FRAC_PI_2, ..level };
        // Clockwise as its operator sees it: what was right is where down was.
        let (a, b) = (level.camera_to_world(), rolled.camera_to_world());
        for row in 0..3 {
            assert!((b[row][0] - a[row][1]).abs() < 1e-12);
            assert!((b[row][1] + a[row][0]).abs() < 1e-12);
        }
    }

    #[test]
    fn straight_down_is_a_pose_too() {
        let m = Pose::between([0.0, 0.0, 1.0], [0.0; 3], 0.0).unwrap().camera_to_world();
        rotation(&m).unwrap();
        assert!(near(apply(&m, [0.0, 0.0, 1.0]), [0.0; 3]));
        assert_eq!(Pose::between([1.0; 3], [1.0; 3], 0.0), None);
    }

    #[test]
    fn what_is_no_rotation_is_refused() {
        let identity = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
        rotation(&identity).unwrap();
        let mut mirrored = identity;
        mirrored[0][0] = -1.0;
        assert!(rotation(&mirrored).unwrap_err().contains("mirrors"));
        let mut stretched = identity;
        stretched[1][1] = 1.1;
        assert!(rotation(&stretched).unwrap_err().contains("no rotation"));
    }
}
