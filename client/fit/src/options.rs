//! How a fit is to be done.

use crate::{Checkpoint, FitError};
use gonio_scene::{Capture, SensorStage};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::str::FromStr;

/// The optimisers, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SolverName {
    /// Trust-region Gauss-Newton on the debiased normal equations.
    #[default]
    GaussNewton,
    /// Nelder and Mead's simplex; uses no derivative but for the first scale.
    NelderMead,
    /// Limited-memory BFGS on the gradient of the normal equations.
    LBfgs,
    /// Particle swarm, then a simplex from its best particle.
    ParticleSwarm,
}

impl SolverName {
    /// All of them, the default first.
    pub const ALL: [Self; 4] = [Self::GaussNewton, Self::NelderMead, Self::LBfgs, Self::ParticleSwarm];

    /// The name that [`SolverName::from_str`] reads.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::GaussNewton => "gauss-newton",
            Self::NelderMead => "nelder-mead",
            Self::LBfgs => "l-bfgs",
            Self::ParticleSwarm => "particle-swarm",
        }
    }

    /// Iterations that are enough for a fit that can succeed at all.
    #[must_use]
    pub fn usual_iterations(self) -> u32 {
        match self {
            Self::GaussNewton => 60,
            Self::NelderMead => 2000,
            Self::LBfgs => 300,
            Self::ParticleSwarm => 2000,
        }
    }
}

impl std::fmt::Display for SolverName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for SolverName {
    type Err = FitError;

    fn from_str(text: &str) -> Result<Self, FitError> {
        Self::ALL.into_iter().find(|s| s.name() == text).ok_or_else(|| FitError::Option {
            option: "solver",
            value: format!("\"{text}\""),
            mend: format!("write one of: {}", Self::ALL.map(Self::name).join(", ")),
        })
    }
}

/// Options of [`crate::fit`]; the default suits photographs of a few hundred pixels a side.
#[derive(Debug, Clone)]
pub struct Options {
    /// The optimiser.
    pub solver: SolverName,
    /// Seed of every random number, the same in all iterations.
    pub seed: u64,
    /// Samples per pixel of the first iterations; even, 2 to `max_samples`.
    pub min_samples: u32,
    /// Samples per pixel that no iteration exceeds; even.
    pub max_samples: u32,
    /// Samples per pixel of derivatives by finite differences (geometry), each of which costs one or two renders: a step's
    /// direction needs fewer than the residual that it is judged by. Even; at most as many as an iteration takes.
    pub difference_samples: u32,
    /// Samples per pixel of all other derivatives, which are carried along the paths: what a pattern of a hundred coefficients
    /// costs. Even; at most as many as an iteration takes, and 0 stands for as many.
    pub forward_samples: u32,
    /// Iterations in all, restarts included; [`SolverName::usual_iterations`] where absent. At least 1.
    pub max_iterations: Option<u32>,
    /// The fit has converged when what its last step leaves is below this many standard errors; above 0, at most 1.
    pub tolerance: f64,
    /// Starting values instead of the capture's: a freed parameter's name, or a colour's for all its channels.
    pub start: Vec<(String, f64)>,
    /// Digest of each of the capture's files by the path that names it, in whatever notation: a checkpoint continues a fit of
    /// the same files only, for they may be replaced under their names.
    pub files: BTreeMap<String, String>,
    /// Where the state is written after each iteration.
    pub checkpoint: Option<PathBuf>,
    /// The state to go on from.
    pub resume: Option<Checkpoint>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            solver: SolverName::default(),
            seed: 0,
            min_samples: 4,
            max_samples: 64,
            difference_samples: 16,
            forward_samples: 0,
            max_iterations: None,
            tolerance: 0.2,
            start: Vec::new(),
            files: BTreeMap::new(),
            checkpoint: None,
            resume: None,
        }
    }
}

/// Least samples per pixel where the response is curved. Nine sRGB photographs of a black and white board, whose edges are what is
/// noisiest, have a reduced chi-square of 4.98 by 4 samples, 2.18 by 16 and 2.04 by 64 at one model.
const CURVED_SAMPLES: u32 = 16;

impl Options {
    /// Iterations in all.
    #[must_use]
    pub fn iterations(&self) -> u32 {
        self.max_iterations.unwrap_or_else(|| self.solver.usual_iterations())
    }

    /// These options, with enough samples from the first iteration on for what a capture's photos are compared by: the loss is
    /// free of the render's noise where values are linear in light, and to second order in the noise where they are not
    /// ([`CURVED_SAMPLES`]).
    #[must_use]
    pub(crate) fn for_capture(&self, capture: &Capture) -> Self {
        let curved = (0..capture.photos.len()).any(|photo| SensorStage::of(capture, photo).is_curved());
        let least = if curved { CURVED_SAMPLES.min(self.max_samples) } else { 2 };
        Self { min_samples: self.min_samples.max(least), ..self.clone() }
    }

    /// Refuses what no fit can be done with.
    pub(crate) fn check(&self) -> Result<(), FitError> {
        let refuse = |option, value: String, mend: &str| Err(FitError::Option { option, value, mend: mend.to_owned() });
        for (option, samples) in [
            ("min_samples", self.min_samples),
            ("max_samples", self.max_samples),
            ("difference_samples", self.difference_samples),
        ] {
            if samples < 2 || samples % 2 != 0 {
                return refuse(
                    option,
                    samples.to_string(),
                    "write an even number of at least 2: a sample for each half",
                );
            }
        }
        if !self.forward_samples.is_multiple_of(2) {
            return refuse(
                "forward_samples",
                self.forward_samples.to_string(),
                "write an even number: as many for each half",
            );
        }
        if self.min_samples > self.max_samples {
            return refuse("min_samples", self.min_samples.to_string(), "write at most max_samples");
        }
        if !(self.tolerance > 0.0 && self.tolerance <= 1.0) {
            return refuse("tolerance", self.tolerance.to_string(), "write a number of standard errors in (0, 1]");
        }
        if self.iterations() == 0 {
            return refuse("max_iterations", "0".to_owned(), "write at least 1");
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_reads_back() {
        for solver in SolverName::ALL {
            assert_eq!(solver.name().parse::<SolverName>().unwrap(), solver);
        }
    }

    #[test]
    fn a_wrong_name_lists_the_right_ones() {
        let text = "adam".parse::<SolverName>().unwrap_err().to_string();
        assert_eq!(text, "solver is \"adam\"; write one of: gauss-newton, nelder-mead, l-bfgs, particle-swarm");
    }

    #[test]
    fn refuses_what_makes_no_fit() {
        let bad = [
            Options { min_samples: 3, ..Options::default() },
            Options { max_samples: 0, ..Options::default() },
            Options { min_samples: 128, ..Options::default() },
            Options { forward_samples: 3, ..Options::default() },
            Options { tolerance: 0.0, ..Options::default() },
            Options { tolerance: f64::NAN, ..Options::default() },
            Options { max_iterations: Some(0), ..Options::default() },
        ];
        for options in bad {
            assert!(options.check().is_err(), "{options:?}");
        }
        Options::default().check().unwrap();
    }
}
