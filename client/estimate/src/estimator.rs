//! The estimator.

use crate::background::Background;
use crate::candidate::{Candidate, distinct};
use crate::likelihood::Likelihood;
use crate::part::{Part, Solid};
use crate::picture::Picture;
use crate::refine::{Effort, Steps, refine};
use crate::search::Templates;
use gonio_pose::bop::Model;
use gonio_pose::{Intrinsics, Pose};
use gonio_scene::image::Image;
use rayon::prelude::*;

/// Sizes of a part that are looked for where no distance is known, as parts of the image's shorter side.
const SIZES: [f64; 2] = [1.0 / 6.0, 0.95];

/// Candidates of the templates, and those that every round of refinement but the last leaves.
const KEPT: [usize; 4] = [48, 8, 3, 2];

/// How long each round looks.
const EFFORTS: [Effort; 4] = [
    Effort { simplexes: 1, iterations: 40 },
    Effort { simplexes: 2, iterations: 50 },
    Effort { simplexes: 3, iterations: 40 },
    Effort { simplexes: 2, iterations: 40 },
];

/// Pixels of the diameter in the rounds at most.
const PIXELS: [f64; 4] = [32.0, 48.0, 64.0, 110.0];

/// What is known before an image is looked at.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Settings {
    /// Least and largest distance of the part from the camera in metres; absent, its diameter takes between a sixth and nearly all of
    /// the image's shorter side.
    pub distance: Option<[f64; 2]>,
}

/// A pose that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// From the model to the camera.
    pub pose: Pose,
    /// Logarithm of how much better the part explains the image than no part does; of all its pixels.
    pub score: f64,
}

/// A part that is looked for.
pub struct Estimator {
    part: Part,
    templates: Templates,
}

impl Estimator {
    /// Makes the templates of a model.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        let part = Part::new(&model.mesh, model.diameter);
        let templates = Templates::new(&part);
        Self { part, templates }
    }

    /// Poses of the part in an image, the best first; none where nothing is like it.
    #[must_use]
    pub fn find(&self, image: &Image, camera: &Intrinsics, settings: &Settings) -> Vec<Found> {
        let whole = Picture::new(image, camera);
        let focal = (camera.fx * camera.fy).sqrt();
        let side = f64::from(image.width.min(image.height));
        let sizes = match settings.distance {
            Some([near, far]) => [focal * self.part.diameter / far, focal * self.part.diameter / near],
            None => SIZES.map(|size| size * side),
        };
        let background = Background::of(&whole);
        let mut candidates = self.templates.search(&self.part, &whole, sizes, KEPT[0]);
        let (coarse, fine) = (&self.part.coarse, &self.part.fine);
        let rounds: [(&Solid, Steps); 4] =
            [(coarse, Steps::COARSE), (coarse, Steps::COARSE), (fine, Steps::MIDDLE), (fine, Steps::FINE)];
        for (round, (solid, steps)) in rounds.into_iter().enumerate() {
            let better = candidates.par_iter().filter_map(|candidate| {
                let likelihood =
                    Likelihood::around(&self.part, solid, &whole, &background, &candidate.pose, PIXELS[round])?;
                let (centre, diameter) = (self.part.centre, self.part.diameter);
                let refined = refine(&likelihood, &candidate.pose, centre, diameter, steps, EFFORTS[round]);
                refined.score.is_finite().then_some(refined)
            });
            let better: Vec<Candidate> = better.collect();
            let most = KEPT.get(round + 1).copied().unwrap_or(usize::MAX);
            candidates = distinct(better, most, self.part.centre, self.part.diameter);
        }
        candidates.into_iter().map(|Candidate { pose, score }| Found { pose, score }).collect()
    }
}
