//! A pose that may be the part's.

use gonio_pose::Pose;

/// A pose and what speaks for it; what exactly depends on who found it, and more is better.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Candidate {
    pub pose: Pose,
    pub score: f64,
}

impl Candidate {
    /// Whether the two mean nearly the same pose: refinement of one would find the other. `centre` is the part's.
    fn is_near(&self, other: &Self, centre: glam::DVec3, diameter: f64) -> bool {
        let (a, b) = (self.pose.apply(centre), other.pose.apply(centre));
        // What is across the view counts more than what is along it.
        let across = (a / a.z - b / b.z).length() * a.z;
        across < 0.12 * diameter
            && (a.z / b.z).max(b.z / a.z) < 1.15
            && gonio_pose::errors::rotation(&self.pose, &other.pose) < 20.0
    }
}

/// The best of `candidates`, at most `most`, no two of which are near each other.
pub(crate) fn distinct(
    mut candidates: Vec<Candidate>,
    most: usize,
    centre: glam::DVec3,
    diameter: f64,
) -> Vec<Candidate> {
    candidates.sort_by(|a, b| b.score.total_cmp(&a.score));
    let mut kept: Vec<Candidate> = Vec::new();
    for candidate in candidates {
        if kept.len() == most {
            break;
        }
        if !kept.iter().any(|other| candidate.is_near(other, centre, diameter)) {
            kept.push(candidate);
        }
    }
    kept
}
