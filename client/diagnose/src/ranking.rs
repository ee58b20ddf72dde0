//! The score pass of a model: every effect of the catalogue, most promising first.

use crate::advance::LARGE;
use crate::context::Context;
use crate::effects::Effect;
use crate::model::Model;
use crate::options::{FORWARD, SCORE_DIFFERENCES};
use crate::overlay::Overlay;
use crate::probe::{Candidate, Probe};
use crate::score::{MANY, Score, scores};
use crate::workshop::{Observer, Workshop, evaluate};
use crate::{DiagnoseError, DiagnoseEvent, Options};
use gonio_scene::{Assets, EvaluationRequest, Output, Stream};
use std::collections::BTreeSet;

/// An effect that promises less than this part of what matters, beside another, is not looked at again.
const WORTH: f64 = 0.25;
/// Chi-square per observation that noise alone has at least: a sensor may be less noisy than the capture says, here by a tenth.
const NOISE: f64 = 0.8;
/// What one score pass has found.
pub struct Ranking {
    probe: Probe,
    /// The most promising variant of each effect, most promising first.
    pub best: Vec<Score>,
    /// The model by the pass' own evaluation, of the same samples as the extensions that are compared with it: its statistics
    /// hold every candidate's columns behind its own.
    pub before: Model,
    /// Gain per observation that matters.
    pub least: f64,
}

impl Ranking {
    /// The candidate of a score.
    pub fn candidate(&self, score: &Score) -> &Candidate {
        &self.probe.candidates[score.candidate]
    }

    /// The effects that may yet matter beside one that explains its part, judged from the same derivatives: only these need
    /// another pass. None does where all that is left is too little.
    pub fn left_beside(&self, score: &Score, there: &Model) -> Vec<&'static Effect> {
        if there.reduced_chi_square() - NOISE < self.least {
            return Vec::new();
        }
        let found = self.candidate(score);
        let beside = scores(&self.probe, &self.before.fit.photos, 1.0, Some(found));
        let promising = beside.iter().filter(|s| s.promise > WORTH * self.least).map(|s| self.candidate(s).effect);
        let mut left: Vec<&'static Effect> = Vec::new();
        for effect in promising {
            if effect.name != found.effect.name && !left.iter().any(|known| known.name == effect.name) {
                left.push(effect);
            }
        }
        left
    }

    /// What an observer is told.
    pub fn event(&self, model: &Model) -> DiagnoseEvent {
        let ranking = self.best.iter().map(|s| (self.candidate(s).effect.name.to_owned(), s.promise)).collect();
        DiagnoseEvent::Ranked { ranking, reduced_chi_square: model.reduced_chi_square() }
    }

    /// At most `most` effects that promise what matters, by more than `chance`; one of few directions is among them if there
    /// is any, as a pattern of many may follow whatever it likes.
    pub fn shortlist(&self, chance: f64, most: usize) -> Vec<&Score> {
        let promises = |s: &&Score| {
            let broad = s.promise > 0.8 * s.cross_error || s.promise > LARGE * self.least;
            s.promise > self.least && broad && s.p_value < chance
        };
        let all: Vec<&Score> = self.best.iter().filter(promises).collect();
        let plain = |s: &&Score| self.candidate(s).variant.directions.len() < MANY;
        let mut short: Vec<&Score> = all.iter().copied().take(most).collect();
        if !short.iter().any(plain) {
            short.extend(all.iter().copied().find(|s| plain(s)));
        }
        short
    }
}

/// One score pass of a model.
///
/// # Errors
/// A patch that the format refuses, an evaluation that fails, a cancellation.
pub fn rank(
    model: &Model,
    effects: &[&'static Effect],
    least: f64,
    options: &Options,
    workshop: &dyn Workshop,
    observer: &mut Observer<'_>,
) -> Result<Ranking, DiagnoseError> {
    let assets = Assets::load(&model.capture, &Overlay { files: workshop.files(), added: &model.files })?;
    let context = Context::new(&model.capture, &assets, model.peak());
    let probe = Probe::new(&context, effects)?;
    let files: Vec<_> = model.files.iter().chain(&probe.files).cloned().collect();
    let mut farm = workshop.open(&probe.capture, &files)?;
    let request = EvaluationRequest {
        columns: probe.columns.clone(),
        photos: (0..probe.capture.targets().count()).collect(),
        samples: options.search_samples(),
        difference_samples: SCORE_DIFFERENCES.min(options.search_samples()),
        forward_samples: FORWARD.min(options.search_samples()),
        // The refits' seed: their deviances are compared with this one's, so that both see the same render noise.
        seed: Stream::Fit.seed(options.seed),
        output: Output::Statistics,
        ..EvaluationRequest::default()
    };
    let found = evaluate(farm.as_mut(), &request, observer)?;
    let mut all = scores(&probe, &found.photos, 1.0, None);
    all.sort_by(|a, b| b.promise.total_cmp(&a.promise));
    let mut seen = BTreeSet::new();
    all.retain(|score| seen.insert(probe.candidates[score.candidate].effect.name));
    Ok(Ranking { probe, best: all, before: model.with_statistics(found.photos), least })
}
