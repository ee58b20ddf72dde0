//! Why photos determine no camera.

use gonio_scene::capture::Camera;

/// The largest standard error of a focal length, as a part of it, and of the principal point, as a part of the picture's
/// side, with which a camera is given: a tenth is already far beyond what photos of a tilted board leave open (below a
/// hundredth), and a frontal board leaves several times the value.
const LARGEST_ERROR: f64 = 0.1;

/// What to photograph.
const TILT: &str = "tilt the board by 20 to 50 degrees, another way in each photo, and fill the picture with it";

/// Why photos determine no camera, or one of them no pose.
#[derive(Debug, Clone, PartialEq)]
pub struct Refusal {
    /// The photo that is at fault, counted from 0; absent where all are.
    pub photo: Option<usize>,
    /// What is wrong, and how to mend it.
    pub problem: String,
}

impl std::fmt::Display for Refusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.photo {
            Some(photo) => write!(f, "photo {photo}: {}", self.problem),
            None => f.write_str(&self.problem),
        }
    }
}

impl Refusal {
    pub(crate) fn new(problem: String) -> Self {
        Self { photo: None, problem }
    }

    pub(crate) fn few(photos: usize) -> Self {
        Self::new(format!("{photos} photos with the board do not determine a camera: take at least 3, tilted"))
    }

    pub(crate) fn open() -> Self {
        Self::new(format!("the photos do not determine a camera: {TILT}"))
    }

    pub(crate) fn corners(photo: usize, corners: usize) -> Self {
        let problem = format!("its {corners} corners do not determine the board's pose: leave it out");
        Self { photo: Some(photo), problem }
    }

    pub(crate) fn odd(photo: usize, noise: f64, median: f64) -> Self {
        let problem = format!(
            "its corners are off by {noise:.2} px, those of the median photo by {median:.2} px, and others are off, too: \
             calibrate photos of one camera and zoom, and of a flat board"
        );
        Self { photo: Some(photo), problem }
    }
}

/// Refuses numbers that the photos leave open.
pub(crate) fn check(camera: &Camera, errors: &[f64; 9]) -> Result<(), Refusal> {
    let Camera { fx, fy, cx, cy, width, height, .. } = *camera;
    if !(fx > 0.0 && fy > 0.0) {
        return Err(Refusal::new(format!("the focal length came out negative: {TILT}")));
    }
    let sizes = [fx, fy, f64::from(width), f64::from(height)];
    for (k, (name, value)) in [("fx", fx), ("fy", fy), ("cx", cx), ("cy", cy)].into_iter().enumerate() {
        let error = errors[k];
        if error.is_nan() || error > LARGEST_ERROR * sizes[k] {
            return Err(Refusal::new(format!(
                "the photos do not determine the camera: {name} came out as {value:.1} +- {error:.1} px; {TILT}"
            )));
        }
    }
    Ok(())
}
