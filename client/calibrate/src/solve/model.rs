//! Which numbers of a camera a calibration looks for.

use gonio_scene::capture::Camera;
use nalgebra::DMatrix;

/// The numbers of a camera: fx fy cx cy k1 k2 p1 p2 k3.
pub(crate) const SHARED: usize = 9;

/// The distortion that is looked for, as how many of k1 k2 p1 p2 k3: none, k1, k1 k2, and p1 p2, and k3.
const TERMS: [usize; 5] = [0, 1, 2, 4, 5];

const NAMES: [&str; 5] = ["k1", "k2", "p1", "p2", "k3"];

/// Which numbers of a camera were looked for; the others are 0, or as given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Model {
    /// Pixels are square: fx = fy is one number.
    pub square: bool,
    /// How many of k1 k2 p1 p2 k3, in this order.
    pub terms: usize,
    /// The camera was given: poses alone are looked for.
    pub given: bool,
}

impl Model {
    /// Pixels square, no distortion.
    pub(crate) const PLAIN: Self = Self { square: true, terms: 0, given: false };
    /// Enough of the distortion to tell corners that are wrong from those that a lens has moved.
    pub(crate) const ROUGH: Self = Self { square: false, terms: 2, given: false };
    /// Nothing of the camera.
    pub(crate) const POSES: Self = Self { square: true, terms: 0, given: true };

    /// Those to choose from, the simplest first.
    pub(crate) fn choices(distortion: bool) -> Vec<Self> {
        let terms = if distortion { &TERMS[..] } else { &TERMS[..1] };
        let with = |&terms: &usize| [true, false].map(|square| Self { square, terms, given: false });
        let mut choices: Vec<Self> = terms.iter().flat_map(with).collect();
        choices.sort_by_key(|model| (model.columns(), !model.square));
        choices
    }

    /// How many numbers that are.
    pub(crate) fn columns(self) -> usize {
        if self.given { 0 } else { 4 - usize::from(self.square) + self.terms }
    }

    /// The matrix that makes a step of the nine numbers from a step of those looked for.
    pub(crate) fn spread(self) -> DMatrix<f64> {
        let mut spread = DMatrix::zeros(SHARED, self.columns());
        if !self.given {
            let tied = usize::from(self.square);
            for k in 0..4 + self.terms {
                spread[(k, if k == 0 { 0 } else { k - tied })] = 1.0;
            }
        }
        spread
    }

    /// `camera` as far as this model can say it.
    pub(crate) fn cut(self, camera: &Camera) -> Camera {
        let mut camera = camera.clone();
        if !self.given {
            camera.distortion.iter_mut().skip(self.terms).for_each(|term| *term = 0.0);
            if self.square {
                let focal = 0.5 * (camera.fx + camera.fy);
                (camera.fx, camera.fy) = (focal, focal);
            }
        }
        camera
    }

    /// The distortion by its names, such as `k1 k2`, or `none`.
    #[must_use]
    pub fn distortion(self) -> String {
        if self.terms == 0 { "none".to_owned() } else { NAMES[..self.terms].join(" ") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choices_grow_from_the_simplest() {
        let choices = Model::choices(true);
        assert_eq!(choices.len(), 10);
        assert_eq!(choices[0], Model::PLAIN);
        assert!(choices.is_sorted_by_key(|model| model.columns()));
        assert_eq!(choices[9].distortion(), "k1 k2 p1 p2 k3");
        for model in choices {
            let spread = model.spread();
            assert_eq!(spread.sum(), 4.0 + model.terms as f64);
            assert!(spread.column_iter().all(|column| column.sum() >= 1.0));
        }
        assert_eq!(Model::choices(false).len(), 2);
    }
}
