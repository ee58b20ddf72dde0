//! A score pass: every variant of every effect at its null, by one evaluation.

use super::measured;
use super::model::Model;
use super::probe::{Candidate, Probe};
use super::score::{Score, scores};
use crate::context::Context;
use crate::effects::Effect;
use crate::evidence::{Promise, ScorePass, ScoredCandidate};
use crate::options::{FORWARD, SCORE_DIFFERENCES};
use crate::overlay::Overlay;
use crate::workshop::{Observer, Workshop, evaluate};
use crate::{DiagnoseError, DiagnoseEvent, Options};
use gonio_scene::{Assets, EvaluationRequest, Output, PhotoStatistics, Stream};

/// What one score pass has found.
pub struct Pass {
    /// What it asked.
    pub probe: Probe,
    /// What came back, by unit.
    photos: Vec<PhotoStatistics>,
    /// The candidates' scores.
    scores: Vec<Score>,
    /// The model by this pass' samples.
    before: Model,
}

impl Pass {
    /// Scores effects at a model, whose photographs' noise alone leaves a chi-square per observation of `noise`.
    ///
    /// # Errors
    /// A patch that the format refuses, an evaluation that fails, a cancellation.
    pub fn of(
        model: &Model,
        effects: &[&'static Effect],
        noise: f64,
        options: &Options,
        workshop: &dyn Workshop,
        observer: &mut Observer<'_>,
    ) -> Result<Self, DiagnoseError> {
        let assets = Assets::load(&model.capture, &Overlay { files: workshop.files(), added: &model.files })?;
        let context = Context::new(&model.capture, &assets, model.peak());
        let probe = Probe::new(&context, effects)?;
        let files: Vec<_> = model.files.iter().chain(&probe.files).cloned().collect();
        let mut farm = workshop.open(&probe.capture, &files)?;
        // Samples of reflectance are computed, not estimated.
        let exact = measured::alone(&model.capture);
        let samples = if exact { 2 } else { options.search_samples() };
        let request = EvaluationRequest {
            columns: probe.columns.clone(),
            photos: (0..probe.capture.targets().count()).collect(),
            samples,
            difference_samples: SCORE_DIFFERENCES.min(samples),
            forward_samples: FORWARD.min(samples),
            // The refits' seed: their deviances are compared with this one's, so that both see the same render noise.
            seed: Stream::Fit.seed(options.seed),
            output: Output::Statistics,
            ..EvaluationRequest::default()
        };
        let photos = evaluate(farm.as_mut(), &request, observer)?.photos;
        // What is left of files is the noise that a score has to beat, whatever they say of theirs.
        let dispersion = if exact { model.reduced_chi_square().max(1.0) } else { noise };
        let scores = scores(&probe, &photos, dispersion, None);
        let before = model.with_statistics(photos.clone());
        Ok(Self { probe, photos, scores, before })
    }

    /// The score of a candidate.
    #[must_use]
    pub fn score_of(&self, candidate: usize) -> Option<&Score> {
        self.scores.iter().find(|s| s.candidate == candidate)
    }

    /// What every candidate promises where another explains its part.
    #[must_use]
    pub fn beside(&self, found: &Candidate) -> Vec<Promise> {
        scores(&self.probe, &self.photos, 1.0, Some(found)).iter().map(|s| s.promise).collect()
    }

    /// What is written down of it.
    #[must_use]
    pub fn record(&self, model: usize) -> ScorePass {
        ScorePass {
            model,
            loss: self.before.fit.photos.iter().map(PhotoStatistics::loss).collect(),
            left_out: self.before.left_out.clone(),
            reduced_chi_square: self.before.reduced_chi_square(),
            candidates: self.scores.iter().map(|s| scored(s, &self.probe.candidates[s.candidate])).collect(),
        }
    }

    /// What an observer is told: the effects by what they gain on units left out.
    #[must_use]
    pub fn event(&self) -> DiagnoseEvent {
        let mut ranking: Vec<(String, f64)> = Vec::new();
        let mut all: Vec<&Score> = self.scores.iter().collect();
        all.sort_by(|a, b| b.promise.cross_gain.total_cmp(&a.promise.cross_gain));
        for score in all {
            let name = self.probe.candidates[score.candidate].effect.name;
            if !ranking.iter().any(|(known, _)| known == name) {
                ranking.push((name.to_owned(), score.promise.cross_gain));
            }
        }
        DiagnoseEvent::Ranked { ranking, reduced_chi_square: self.before.reduced_chi_square() }
    }
}

fn scored(score: &Score, candidate: &Candidate) -> ScoredCandidate {
    let mut expected_change: Vec<(String, f64)> = Vec::new();
    for (direction, change) in candidate.variant.directions.iter().zip(&score.change) {
        // A number that is scored in each channel by itself changes by the channels' mean.
        let change = if direction.channel.is_some() { change / 3.0 } else { *change };
        match expected_change.iter_mut().find(|(name, _)| name == direction.moves()) {
            Some((_, sum)) => *sum += change,
            None => expected_change.push((direction.moves().to_owned(), change)),
        }
    }
    ScoredCandidate {
        effect: candidate.effect.name.to_owned(),
        label: candidate.variant.label.clone(),
        directions: candidate.variant.directions.len(),
        searched: !candidate.variant.search.is_empty(),
        suspect: candidate.variant.suspect,
        frees: candidate.variant.free.clone(),
        score: score.score,
        freedom: score.freedom,
        p_value: score.p_value,
        promise: score.promise,
        expected_change,
    }
}
