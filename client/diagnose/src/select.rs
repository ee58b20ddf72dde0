//! Forward selection with a backward check, on the photos that are not held out.

use crate::context::Context;
use crate::effects::Effect;
use crate::model::Model;
use crate::probe::Probe;
use crate::refit::refit;
use crate::score::{Score, scores};
use crate::workshop::{Observer, Workshop, evaluate, tell};
use crate::{DiagnoseError, DiagnoseEvent, Options};
use gonio_scene::{Assets, EvaluationRequest, Output};

/// Decrease of deviance per observation below which no gain matters, whatever its significance. Two renderers that agree to a
/// part in a thousand still differ along shadow edges: on captures of another renderer without any effect, a shift of the
/// lamp by a fifth of a millimetre gains 0.002 to 0.007.
pub const FLOOR: f64 = 0.008;
/// A gain must exceed so many of its standard errors between photos.
const ERRORS: f64 = 1.8;
/// Or, as the photos of an effect that is strong in some and weak in others scatter by nature, be so many times what
/// matters, with this part of the photos better predicted.
const LARGE: f64 = 4.0;
/// See [`LARGE`].
const MAJORITY: f64 = 0.66;
/// A rival that reaches this part of the best's gain, or all but this many standard errors of the difference, is not
/// rejected.
const RIVAL: f64 = 0.93;

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
    let effects = options.effects()?;
    let mut trials: Vec<Trial> = Vec::new();
    let mut model = base.clone();
    let mut additions: Vec<Addition> = Vec::new();
    for round in 0..=options.most_effects {
        let left: Vec<_> =
            effects.iter().filter(|e| !model.parts.iter().any(|p| p.effect.name == e.name)).copied().collect();
        tell(observer, &DiagnoseEvent::Stage { text: format!("scoring {} effects", left.len()) })?;
        let (probe, ranked, here) = rank(&model, &left, options, workshop, observer)?;
        let names =
            ranked.iter().map(|s| (probe.candidates[s.candidate].effect.name.to_owned(), s.cross_gain)).collect();
        let reduced_chi_square = model.reduced_chi_square();
        tell(observer, &DiagnoseEvent::Ranked { ranking: names, reduced_chi_square })?;
        if round == 0 {
            trials = left.iter().map(|e| trial(e, &probe, &ranked)).collect();
        }
        if round == options.most_effects {
            break;
        }
        let least = importance(&model, options);
        let chance = options.false_alarms / effects.len() as f64;
        let short: Vec<&Score> = ranked
            .iter()
            .filter(|s| {
                s.cross_gain > least
                    && (s.cross_gain > 0.8 * s.cross_error || s.cross_gain > LARGE * least)
                    && s.p_value < chance
            })
            .take(options.shortlist)
            .collect();
        let mut fitted: Vec<(&Score, Model, f64, f64)> = Vec::new();
        for score in short {
            // One that promises far less than the best already delivers need not be tried.
            let best = fitted.iter().map(|f| f.2).fold(0.0, f64::max);
            if score.cross_gain < 0.25 * best {
                continue;
            }
            let candidate = &probe.candidates[score.candidate];
            let name = candidate.effect.name.to_owned();
            tell(observer, &DiagnoseEvent::Stage { text: format!("fitting {name} {}", candidate.variant.label) })?;
            let there = match refit(&model, candidate, score, &options.refit(), workshop, observer) {
                Ok(there) => there,
                Err(DiagnoseError::Cancelled) => return Err(DiagnoseError::Cancelled),
                Err(error) => {
                    refuse(&mut trials, &name, &format!("its fit failed: {error}"));
                    continue;
                }
            };
            let (gain, standard_error) = there.gain_over(&here);
            tell(
                observer,
                &DiagnoseEvent::Refitted {
                    effect: name,
                    gain,
                    standard_error,
                    reduced_chi_square: there.reduced_chi_square(),
                },
            )?;
            let (moved, least_move) = (there.last_move(), candidate.variant.least_move);
            if moved < least_move {
                let why = format!("gains {gain:.4} by a move of {moved:.2e}; {least_move:.2e} would matter");
                refuse(&mut trials, candidate.effect.name, &why);
                continue;
            }
            fitted.push((score, there, gain, standard_error));
        }
        fitted.sort_by(|a, b| b.2.total_cmp(&a.2));
        let Some((score, best, gain, error)) = fitted.first().cloned() else { break };
        for (other, _, other_gain, _) in &fitted[1..] {
            let name = probe.candidates[other.candidate].effect.name;
            refuse(&mut trials, name, &format!("gains {other_gain:.4} when fitted, another {gain:.4}"));
        }
        let effect = probe.candidates[score.candidate].effect;
        let supported = gain >= ERRORS * error || (gain >= LARGE * least && best.share_over(&here) >= MAJORITY);
        if gain < least || !supported {
            refuse(
                &mut trials,
                effect.name,
                &format!("gains {gain:.4} (standard error {error:.4}) when fitted; {least:.4} would matter"),
            );
            break;
        }
        let rivals = fitted[1..].iter().filter(|(_, there, other, _)| {
            let (behind, error) = best.gain_over(&there.left_out);
            *other > RIVAL * gain || behind < 2.0 * error && *other > 0.7 * gain
        });
        let names: Vec<&'static Effect> =
            std::iter::once(effect).chain(rivals.map(|r| probe.candidates[r.0.candidate].effect)).take(2).collect();
        tell(observer, &DiagnoseEvent::Extended { effect: effect.name.to_owned() })?;
        additions.push(Addition { effects: names, score: score.score, p_value: score.p_value });
        if let Some(trial) = trials.iter_mut().find(|t| t.effect.name == effect.name) {
            trial.refused_because = None;
        }
        model = best;
    }
    if !additions.is_empty() {
        tell(observer, &DiagnoseEvent::Stage { text: "fitting the extended model".to_owned() })?;
        model = Model::fit(&model.capture, model.files, model.parts, &options.last_fit(), workshop, observer)?;
    }
    Ok(Selection { base, model, additions, trials })
}

/// The least gain per observation that matters to `model`.
#[must_use]
pub fn importance(model: &Model, options: &Options) -> f64 {
    let above = model.fit.fit.reduced_chi_square - 1.0;
    (options.smallest_gain * above).max(FLOOR)
}

/// One score pass: the probe, the best variant of each effect by what survives cross-validation, and the model's own
/// chi-squares of photos left out.
fn rank(
    model: &Model,
    effects: &[&'static Effect],
    options: &Options,
    workshop: &dyn Workshop,
    observer: &mut Observer<'_>,
) -> Result<(Probe, Vec<Score>, Vec<f64>), DiagnoseError> {
    let assets = Assets::load(&model.capture, &Overlay { files: workshop.files(), added: &model.files })?;
    let context = Context::new(&model.capture, &assets, model.peak());
    let probe = Probe::new(&context, effects)?;
    let files: Vec<_> = model.files.iter().chain(&probe.files).cloned().collect();
    let mut farm = workshop.open(&probe.capture, &files)?;
    let request = EvaluationRequest {
        columns: probe.columns.clone(),
        photos: (0..probe.capture.photos.len()).collect(),
        samples: options.search_samples(),
        difference_samples: options.difference_samples,
        // The refits' seed: their chi-squares are compared with this one's, so that both see the same render noise.
        seed: options.seed,
        output: Output::Statistics,
        ..EvaluationRequest::default()
    };
    let found = evaluate(farm.as_mut(), &request, observer)?;
    let mut all = scores(&probe, &found.photos, model.dispersion());
    all.sort_by(|a, b| b.cross_gain.total_cmp(&a.cross_gain));
    let mut best: Vec<Score> = Vec::new();
    for score in all {
        let name = probe.candidates[score.candidate].effect.name;
        if !best.iter().any(|b| probe.candidates[b.candidate].effect.name == name) {
            best.push(score);
        }
    }
    // Of the same samples as the extensions that are compared with it.
    let here = model.left_out_of(&found.photos);
    Ok((probe, best, here))
}

fn trial(effect: &'static Effect, probe: &Probe, ranked: &[Score]) -> Trial {
    let score = ranked.iter().find(|s| probe.candidates[s.candidate].effect.name == effect.name);
    let first = score.map(|s| {
        let directions = &probe.candidates[s.candidate].variant.directions;
        (s.clone(), directions.iter().zip(&s.change).map(|(d, c)| (d.name.clone(), *c)).collect())
    });
    let why = if first.is_none() { "the capture has nothing that it could act on" } else { "promises too little" };
    Trial { effect, first, refused_because: Some(why.to_owned()) }
}

fn refuse(trials: &mut [Trial], name: &str, why: &str) {
    if let Some(trial) = trials.iter_mut().find(|t| t.effect.name == name) {
        trial.refused_because = Some(why.to_owned());
    }
}

/// A capture's files with some added.
pub struct Overlay<'a> {
    /// The capture's own.
    pub files: &'a dyn gonio_scene::files::Files,
    /// Path and contents of those added.
    pub added: &'a [(String, &'static [u8])],
}

impl gonio_scene::files::Files for Overlay<'_> {
    fn read(&self, path: &str) -> gonio_scene::Result<std::sync::Arc<[u8]>> {
        match self.added.iter().find(|(p, _)| p == path) {
            Some((_, bytes)) => Ok((*bytes).into()),
            None => self.files.read(path),
        }
    }
}
