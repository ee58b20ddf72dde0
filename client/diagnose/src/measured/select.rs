//! Forward selection on files of measured reflectance.

use super::{error_gain, left_out};
use crate::context::Context;
use crate::effects::Effect;
use crate::model::Model;
use crate::overlay::Overlay;
use crate::probe::Probe;
use crate::refit::refit;
use crate::score::{Score, scores};
use crate::select::{Addition, Selection};
use crate::trial::{Trial, refuse};
use crate::workshop::{Observer, Workshop, evaluate, tell};
use crate::{DiagnoseError, DiagnoseEvent, Options};
use gonio_scene::{Assets, EvaluationRequest, Output, Stream};

/// An effect that lowers the error on the files that it is fitted to by less than this part of what matters is not worth
/// being fitted once more without each of them.
const HALF: f64 = 0.5;

/// Selects, from a fitted base model.
///
/// # Errors
/// An evaluation or fit that fails, a cancellation.
pub(crate) fn select(
    base: Model,
    options: &Options,
    workshop: &dyn Workshop,
    observer: &mut Observer<'_>,
) -> Result<Selection, DiagnoseError> {
    let effects = options.effects()?;
    let mut trials: Vec<Trial> = Vec::new();
    let mut model = Model { left_out: left_out(&base, &options.refit(), workshop, observer)?, ..base.clone() };
    let mut additions: Vec<Addition> = Vec::new();
    while additions.len() < options.most_effects {
        let left: Vec<_> =
            effects.iter().filter(|e| !model.parts.iter().any(|p| p.effect.name == e.name)).copied().collect();
        tell(observer, &DiagnoseEvent::Stage { text: format!("scoring {} effects", left.len()) })?;
        let ranking = rank(&model, &left, options, workshop, observer)?;
        let (probe, all) = &ranking;
        let best_of = |effect: &Effect| all.iter().find(|s| probe.candidates[s.candidate].effect.name == effect.name);
        if trials.is_empty() {
            trials = left.iter().map(|e| trial(e, best_of(e), probe)).collect();
        }
        let mut fitted: Vec<Fitted<'_>> = Vec::new();
        for effect in left.iter().filter(|e| best_of(e).is_some()) {
            tell(observer, &DiagnoseEvent::Stage { text: format!("fitting {}", effect.name) })?;
            match Fitted::best(effect, &model, &ranking, options, workshop, observer)? {
                Ok(one) => fitted.push(*one),
                Err(why) => refuse(&mut trials, effect.name, &why),
            }
        }
        fitted.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        if fitted.is_empty() {
            break;
        }
        let best = fitted.remove(0);
        let percent = |gain: f64| format!("{:+.1} %", -100.0 * gain);
        for other in &fitted {
            let why = format!("error on left-out files {}, by another {}", percent(other.gain), percent(best.gain));
            refuse(&mut trials, other.effect.name, &why);
        }
        let least = options.smallest_file_gain;
        if best.gain < least {
            let why = format!("error on left-out files {}; {} would matter", percent(best.gain), percent(least));
            refuse(&mut trials, best.effect.name, &why);
            break;
        }
        tell(observer, &DiagnoseEvent::Extended { effect: best.effect.name.to_owned() })?;
        // Two that both matter, and differ by less than what matters, are not told apart.
        let rival = |other: &&Fitted<'_>| other.gain >= least && error_gain(other.squares(), best.squares()) < least;
        let names = std::iter::once(best.effect).chain(fitted.iter().find(rival).map(|other| other.effect)).collect();
        additions.push(Addition { effects: names, score: best.score.score, p_value: best.score.p_value });
        if let Some(trial) = trials.iter_mut().find(|t| t.effect.name == best.effect.name) {
            trial.refused_because = None;
        }
        model = best.model;
    }
    Ok(Selection { base, model, additions, trials })
}

/// A model extended by one effect.
struct Fitted<'r> {
    effect: &'static Effect,
    score: &'r Score,
    model: Model,
    /// Part by which the error on left-out files is lower.
    gain: f64,
}

/// Or why there is nothing to compare.
type Outcome<'r> = Result<Box<Fitted<'r>>, String>;

impl<'r> Fitted<'r> {
    /// Fits every variant of the effect, and leaves files out of the best.
    fn best(
        effect: &'static Effect,
        model: &Model,
        (probe, all): &'r (Probe, Vec<Score>),
        options: &Options,
        workshop: &dyn Workshop,
        observer: &mut Observer<'_>,
    ) -> Result<Outcome<'r>, DiagnoseError> {
        let mut best: Option<(&Score, Model)> = None;
        let mut failed = String::new();
        for score in all.iter().filter(|s| probe.candidates[s.candidate].effect.name == effect.name) {
            let candidate = &probe.candidates[score.candidate];
            // No material's effect has a place to search.
            match refit(model, candidate, score, 0.0, &options.refit(), workshop, observer) {
                Err(DiagnoseError::Cancelled) => return Err(DiagnoseError::Cancelled),
                Err(error) => failed = format!("its fit failed: {error}"),
                Ok(None) => "stands at no place that explains more".clone_into(&mut failed),
                Ok(Some(there)) => {
                    let better = best.as_ref().is_none_or(|(_, b)| there.reduced_chi_square() < b.reduced_chi_square());
                    if better {
                        best = Some((score, there));
                    }
                }
            }
        }
        let Some((score, mut there)) = best else { return Ok(Err(failed)) };
        let own = error_gain(model.reduced_chi_square(), there.reduced_chi_square());
        if own < HALF * options.smallest_file_gain {
            let why = format!("error on the files fitted to {:+.1} %", -100.0 * own);
            return Ok(Err(why));
        }
        there.left_out = left_out(&there, &options.refit(), workshop, observer)?;
        let (gain, standard_error) = there.gain_over(&model.left_out);
        let reduced_chi_square = there.reduced_chi_square();
        let name = effect.name.to_owned();
        tell(observer, &DiagnoseEvent::Refitted { effect: name, gain, standard_error, reduced_chi_square })?;
        let gain = error_gain(squares(model), squares(&there));
        Ok(Ok(Box::new(Self { effect, score, model: there, gain })))
    }

    fn squares(&self) -> f64 {
        squares(&self.model)
    }
}

/// Sum of squares of the files' residuals, in standard deviations, each file's when it is left out.
fn squares(model: &Model) -> f64 {
    model.left_out.iter().sum()
}

/// One score pass of a model: every variant, best first.
fn rank(
    model: &Model,
    effects: &[&'static Effect],
    options: &Options,
    workshop: &dyn Workshop,
    observer: &mut Observer<'_>,
) -> Result<(Probe, Vec<Score>), DiagnoseError> {
    let assets = Assets::load(&model.capture, &Overlay { files: workshop.files(), added: &model.files })?;
    let probe = Probe::new(&Context::new(&model.capture, &assets, model.peak()), effects)?;
    let mut farm = workshop.open(&probe.capture, &model.files)?;
    let request = EvaluationRequest {
        columns: probe.columns.clone(),
        photos: (0..probe.capture.reflectance.len()).collect(),
        samples: 2,
        seed: Stream::Fit.seed(options.seed),
        output: Output::Statistics,
        ..EvaluationRequest::default()
    };
    let found = evaluate(farm.as_mut(), &request, observer)?;
    // What is left is the noise that a score has to beat, whatever the files say of theirs.
    let mut all = scores(&probe, &found.photos, model.reduced_chi_square().max(1.0), None);
    all.sort_by(|a, b| b.cross_gain.total_cmp(&a.cross_gain));
    let mut named: Vec<(String, f64)> = Vec::new();
    for score in &all {
        let name = probe.candidates[score.candidate].effect.name;
        if !named.iter().any(|(n, _)| n == name) {
            named.push((name.to_owned(), score.cross_gain));
        }
    }
    tell(observer, &DiagnoseEvent::Ranked { ranking: named, reduced_chi_square: model.reduced_chi_square() })?;
    Ok((probe, all))
}

fn trial(effect: &'static Effect, score: Option<&Score>, probe: &Probe) -> Trial {
    let first = score.map(|s| {
        let directions = &probe.candidates[s.candidate].variant.directions;
        (s.clone(), directions.iter().zip(&s.change).map(|(d, c)| (d.name.clone(), *c)).collect())
    });
    let why = if first.is_none() { "measured reflectance does not show it" } else { "was not fitted" };
    Trial { effect, first, refused_because: Some(why.to_owned()) }
}
