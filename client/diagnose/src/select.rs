//! Forward selection with a backward check, on the photos that are not held out.

use crate::backward::backward;
use crate::context::Context;
use crate::effects::Effect;
use crate::measured::{self, Beside};
use crate::model::Model;
use crate::options::{FORWARD, SCORE_DIFFERENCES};
use crate::overlay::Overlay;
use crate::probe::{Candidate, Probe};
use crate::refit::refit;
use crate::score::{Score, scores};
use crate::workshop::{Observer, Workshop, evaluate, tell};
use crate::{DiagnoseError, DiagnoseEvent, Options};
use gonio_scene::{Assets, EvaluationRequest, Output, PhotoStatistics};
use std::collections::BTreeSet;

/// Decrease of deviance per observation below which no gain matters, whatever its significance: on captures of another
/// renderer without any effect the best candidate gains 0.0003.
pub const FLOOR: f64 = 0.002;
/// An effect that promises less than this part of what matters, beside another, is not looked at again.
const WORTH: f64 = 0.25;
/// Chi-square per observation that noise alone has at least: a sensor may be less noisy than the capture says, here by a tenth.
const NOISE: f64 = 0.8;
/// A gain must exceed so many of its standard errors between photos: one photo alone that gains is one of them, two of six
/// alike are 1.58. Chance has no part in it, [`FLOOR`] sees to that; a mishap of one photo has.
pub const ERRORS: f64 = 1.45;
/// Or, as the photos of an effect that is strong in some and weak in others scatter by nature, be so many times what
/// matters, with this part of the photos better predicted.
const LARGE: f64 = 4.0;
/// See [`LARGE`].
const MAJORITY: f64 = 0.66;
/// Where a fitted effect leaves less than this part of the misfit above the noise, no place is searched for another.
const ENOUGH: f64 = 0.1;
/// A rival that reaches this part of the best's gain, or all but this many standard errors of the difference, is not
/// rejected.
const RIVAL: f64 = 0.93;

/// One that comes closer to the fitted photos than the best does is not rejected from this part of its gain on: that a photo
/// left out is predicted worse may be the quadratic's fault.
const CLOSER: f64 = 0.5;

/// An effect that the selection has added.
#[derive(Debug, Clone)]
pub struct Addition {
    /// The effect and those that explain the same as well, best first.
    pub effects: Vec<&'static Effect>,
    /// Its score when it was added.
    pub score: f64,
    /// Chance of such a score where no effect is present.
    pub p_value: f64,
}

/// What was tried with one effect.
#[derive(Debug, Clone)]
pub struct Trial {
    /// The effect.
    pub effect: &'static Effect,
    /// Best of its variants in the first ranking; absent where the capture has nothing it could act on.
    pub first: Option<(Score, Vec<(String, f64)>)>,
    /// Why it was not added; absent where it was.
    pub refused_because: Option<String>,
}

/// What the selection has come to.
#[derive(Debug, Clone)]
pub struct Selection {
    /// The model before.
    pub base: Model,
    /// The model after.
    pub model: Model,
    /// What was added, in order.
    pub additions: Vec<Addition>,
    /// Every effect.
    pub trials: Vec<Trial>,
}

/// Selects, from a fitted base model.
///
/// # Errors
/// An evaluation or fit that fails, a cancellation.
pub fn select(
    base: Model,
    options: &Options,
    workshop: &dyn Workshop,
    observer: &mut Observer<'_>,
) -> Result<Selection, DiagnoseError> {
    if measured::alone(&base.capture) {
        return measured::select(base, options, workshop, observer);
    }
    let effects = options.effects()?;
    let chance = options.false_alarms / effects.len() as f64;
    // Of the base model's misfit, for every effect: what a wrong model of the first leaves is no second.
    let least = importance(&base, options);
    let mut trials: Vec<Trial> = Vec::new();
    let mut model = base.clone();
    let mut additions: Vec<Addition> = Vec::new();
    let mut left = effects;
    while additions.len() < options.most_effects && !left.is_empty() {
        tell(observer, &DiagnoseEvent::Stage { text: format!("scoring {} effects", left.len()) })?;
        let ranking = rank(&model, &left, least, options, workshop, observer)?;
        tell(observer, &ranking.event(&model))?;
        if trials.is_empty() {
            trials = left.iter().map(|e| trial(e, &ranking)).collect();
        }
        let short = ranking.shortlist(chance, options.shortlist);
        let mut fitted = fit_shortlist(&model, &ranking, &short, options, workshop, &mut trials, observer)?;
        fitted.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        let beside = Beside::of(&model, options);
        let matters = |f: &Fitted<'_>| match &beside {
            Some(beside) => beside.matters(&ranking.here, &f.model.left_out),
            None => f.matters(least, &ranking.here),
        };
        let best = fitted.iter().position(matters).map(|i| fitted.remove(i));
        for Fitted { effect, gain, error, .. } in &fitted {
            let why = match &best {
                Some(best) => format!("gains {gain:.4} when fitted, another {:.4}", best.gain),
                None => format!("gains {gain:.4} (standard error {error:.4}) when fitted; {least:.4} would matter"),
            };
            refuse(&mut trials, effect.name, &why);
        }
        let Some(best) = best else { break };
        left = ranking.left_beside(&best);
        let rivals = fitted.iter().filter(|other| other.rivals(&best)).map(|other| other.effect);
        let names = std::iter::once(best.effect).chain(rivals).take(2).collect();
        tell(observer, &DiagnoseEvent::Extended { effect: best.effect.name.to_owned() })?;
        additions.push(Addition { effects: names, score: best.score.score, p_value: best.score.p_value });
        if let Some(trial) = trials.iter_mut().find(|t| t.effect.name == best.effect.name) {
            trial.refused_because = None;
        }
        model = best.model;
    }
    let (mut model, dropped) = backward(model, &mut additions, least, options, workshop, observer)?;
    for name in dropped {
        refuse(&mut trials, name, "is not missed once the rest is there");
    }
    if !additions.is_empty() {
        tell(observer, &DiagnoseEvent::Stage { text: "fitting the extended model".to_owned() })?;
        let freed: Vec<String> = model.parts.iter().flat_map(|part| part.variant.free.clone()).collect();
        for name in freed {
            if !model.capture.fit.parameters.contains(&name) {
                model.capture.fit.parameters.push(name);
            }
        }
        let last = options.last_fit(model.parts.iter().any(|part| !part.variant.search.is_empty()));
        model = Model::fit(&model.capture, model.files, model.parts, &last, workshop, observer)?;
    }
    Ok(Selection { base, model, additions, trials })
}

/// A model extended by one effect.
struct Fitted<'r> {
    effect: &'static Effect,
    score: &'r Score,
    model: Model,
    /// Decrease of left-out deviance per observation.
    gain: f64,
    /// Its standard error between photos.
    error: f64,
}

impl Fitted<'_> {
    /// Whether the gain is large enough, and no accident of few photos; `here` is the model's before.
    fn matters(&self, least: f64, here: &[f64]) -> bool {
        let broad = self.gain >= LARGE * least && self.model.share_over(here) >= MAJORITY;
        self.gain >= least && (self.gain >= ERRORS * self.error || broad)
    }

    /// Whether it explains about as much as the best.
    fn rivals(&self, best: &Self) -> bool {
        let (behind, error) = best.model.gain_over(&self.model.left_out);
        let closer = self.model.reduced_chi_square() < best.model.reduced_chi_square();
        self.gain > RIVAL * best.gain
            || behind < 2.0 * error && self.gain > 0.7 * best.gain
            || closer && self.gain > CLOSER * best.gain
    }
}

/// Fits the effects of a shortlist, each added to the model alone.
fn fit_shortlist<'r>(
    model: &Model,
    ranking: &'r Ranking,
    short: &[&'r Score],
    options: &Options,
    workshop: &dyn Workshop,
    trials: &mut [Trial],
    observer: &mut Observer<'_>,
) -> Result<Vec<Fitted<'r>>, DiagnoseError> {
    let mut fitted: Vec<Fitted<'r>> = Vec::new();
    let searched = |score: &Score| !ranking.candidate(score).variant.search.is_empty();
    let excess = |model: &Model| (model.reduced_chi_square() - 1.0).max(0.0);
    // A search is dear: who needs none comes first.
    let (later, first): (Vec<&Score>, Vec<&Score>) = short.iter().partition(|s| searched(s));
    for score in first.into_iter().chain(later) {
        // One that promises far less than the best already delivers need not be tried.
        let best = fitted.iter().map(|f| f.gain).fold(0.0, f64::max);
        if score.promise < 0.25 * best {
            continue;
        }
        let candidate = ranking.candidate(score);
        let (effect, variant) = (candidate.effect, &candidate.variant);
        if searched(score) && fitted.iter().any(|f| excess(&f.model) < ENOUGH * excess(model)) {
            refuse(
                trials,
                effect.name,
                "its place was not searched, as another effect that has none explains what there is",
            );
            continue;
        }
        tell(observer, &DiagnoseEvent::Stage { text: format!("fitting {} {}", effect.name, variant.label) })?;
        let there = match refit(model, candidate, score, ranking.least, &options.refit(), workshop, observer) {
            Ok(Some(there)) => there,
            Ok(None) => {
                refuse(trials, effect.name, "stands at no place that explains more");
                continue;
            }
            Err(DiagnoseError::Cancelled) => return Err(DiagnoseError::Cancelled),
            Err(error) => {
                refuse(trials, effect.name, &format!("its fit failed: {error}"));
                continue;
            }
        };
        let (gain, error) = there.gain_over(&ranking.here);
        let refitted = DiagnoseEvent::Refitted {
            effect: effect.name.to_owned(),
            gain,
            standard_error: error,
            reduced_chi_square: there.reduced_chi_square(),
        };
        tell(observer, &refitted)?;
        fitted.push(Fitted { effect, score, model: there, gain, error });
    }
    Ok(fitted)
}

/// The least gain per observation that matters to `model`.
#[must_use]
pub fn importance(model: &Model, options: &Options) -> f64 {
    if let Some(both) = Beside::of(model, options) {
        return both.least();
    }
    let above = model.fit.fit.reduced_chi_square - 1.0;
    (options.smallest_gain * above).max(FLOOR)
}

/// What one score pass has found.
struct Ranking {
    probe: Probe,
    /// The most promising variant of each effect, most promising first.
    best: Vec<Score>,
    /// The model's own deviances of photos left out, of the same samples as the extensions that are compared with it.
    here: Vec<f64>,
    photos: Vec<PhotoStatistics>,
    /// Gain per observation that matters.
    least: f64,
}

impl Ranking {
    fn candidate(&self, score: &Score) -> &Candidate {
        &self.probe.candidates[score.candidate]
    }

    /// The effects that may yet matter beside one that explains its part, judged from the same derivatives: only these need
    /// another pass. None does where all that is left is too little.
    fn left_beside(&self, found: &Fitted<'_>) -> Vec<&'static Effect> {
        if found.model.reduced_chi_square() - NOISE < self.least {
            return Vec::new();
        }
        let (found, dispersion) = (self.candidate(found.score), found.model.dispersion());
        let beside = scores(&self.probe, &self.photos, dispersion, Some(found));
        let promising = beside.iter().filter(|s| s.promise > WORTH * self.least).map(|s| self.candidate(s).effect);
        let mut left: Vec<&'static Effect> = Vec::new();
        for effect in promising {
            if effect.name != found.effect.name && !left.iter().any(|known| known.name == effect.name) {
                left.push(effect);
            }
        }
        left
    }

    fn event(&self, model: &Model) -> DiagnoseEvent {
        let ranking = self.best.iter().map(|s| (self.candidate(s).effect.name.to_owned(), s.promise)).collect();
        DiagnoseEvent::Ranked { ranking, reduced_chi_square: model.reduced_chi_square() }
    }

    /// At most `most` effects that promise what matters, by more than `chance`.
    fn shortlist(&self, chance: f64, most: usize) -> Vec<&Score> {
        let promises = |s: &&Score| {
            let broad = s.promise > 0.8 * s.cross_error || s.promise > LARGE * self.least;
            s.promise > self.least && broad && s.p_value < chance
        };
        self.best.iter().filter(promises).take(most).collect()
    }
}

/// One score pass of a model.
fn rank(
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
        seed: options.seed,
        output: Output::Statistics,
        ..EvaluationRequest::default()
    };
    let found = evaluate(farm.as_mut(), &request, observer)?;
    let mut all = scores(&probe, &found.photos, model.dispersion(), None);
    all.sort_by(|a, b| b.promise.total_cmp(&a.promise));
    let mut seen = BTreeSet::new();
    all.retain(|score| seen.insert(probe.candidates[score.candidate].effect.name));
    let here = model.left_out_of(&found.photos);
    Ok(Ranking { probe, best: all, here, photos: found.photos, least })
}

fn trial(effect: &'static Effect, ranking: &Ranking) -> Trial {
    let score = ranking.best.iter().find(|s| ranking.candidate(s).effect.name == effect.name);
    let first = score.map(|s| {
        let mut changes: Vec<(String, f64)> = Vec::new();
        for (direction, change) in ranking.candidate(s).variant.directions.iter().zip(&s.change) {
            // A number that is scored in each channel by itself changes by the channels' mean.
            let change = if direction.channel.is_some() { change / 3.0 } else { *change };
            match changes.iter_mut().find(|(name, _)| *name == direction.name) {
                Some((_, sum)) => *sum += change,
                None => changes.push((direction.name.clone(), change)),
            }
        }
        (s.clone(), changes)
    });
    let why = if first.is_none() { "the capture has nothing that it could act on" } else { "promises too little" };
    Trial { effect, first, refused_because: Some(why.to_owned()) }
}

pub(crate) fn refuse(trials: &mut [Trial], name: &str, why: &str) {
    if let Some(trial) = trials.iter_mut().find(|t| t.effect.name == name) {
        trial.refused_because = Some(why.to_owned());
    }
}
