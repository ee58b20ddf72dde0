//! Forward selection with a backward check, on the photos that are not held out.

use crate::backward::backward;
use crate::effects::Effect;
use crate::measured::{self, Beside};
use crate::model::Model;
use crate::ranking::rank;
use crate::shortlist::{Fitted, fit_shortlist};
use crate::trial::{Trial, refuse};
use crate::workshop::{Observer, Workshop, tell};
use crate::{DiagnoseError, DiagnoseEvent, Options};

/// Decrease of deviance per observation below which no gain matters, whatever its significance: on captures of another
/// renderer without any effect the best candidate gains 0.0003.
pub const FLOOR: f64 = 0.002;
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
            trials = left.iter().map(|e| Trial::of(e, &ranking)).collect();
        }
        let short = ranking.shortlist(chance, options.shortlist);
        let mut fitted = fit_shortlist(&model, &ranking, &short, options, workshop, &mut trials, observer)?;
        fitted.sort_by(|a, b| b.advance.gain().0.total_cmp(&a.advance.gain().0));
        let beside = Beside::of(&model, options);
        let matters = |f: &Fitted<'_>| match &beside {
            Some(beside) => beside.matters(&ranking.before.left_out, &f.model.left_out),
            None => f.advance.matters(least),
        };
        let best = fitted.iter().position(matters).map(|i| fitted.remove(i));
        for Fitted { effect, advance, .. } in &fitted {
            let (gain, error) = advance.gain();
            let why = match &best {
                Some(best) => format!("gains {gain:.4} when fitted, another {:.4}", best.advance.gain().0),
                None => format!("gains {gain:.4} (standard error {error:.4}) when fitted; {least:.4} would matter"),
            };
            refuse(&mut trials, effect.name, &why);
        }
        let Some(best) = best else { break };
        left = ranking.left_beside(best.score, &best.model);
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

/// The least gain per observation that matters to `model`.
#[must_use]
pub fn importance(model: &Model, options: &Options) -> f64 {
    if let Some(both) = Beside::of(model, options) {
        return both.least();
    }
    let above = model.fit.fit.reduced_chi_square - 1.0;
    (options.smallest_gain * above).max(FLOOR)
}
