//! The most promising effects, each fitted beside the model.

use crate::advance::Advance;
use crate::effects::Effect;
use crate::model::Model;
use crate::ranking::Ranking;
use crate::refit::refit;
use crate::score::Score;
use crate::trial::{Trial, refuse};
use crate::workshop::{Observer, Workshop, tell};
use crate::{DiagnoseError, DiagnoseEvent, Options};

/// Where a fitted effect leaves less than this part of the misfit above the noise, no place is searched for another.
const ENOUGH: f64 = 0.1;
/// A rival that reaches this part of the best's gain, or all but this many standard errors of the difference, is not
/// rejected.
const RIVAL: f64 = 0.93;

/// Nor is one that brings the fitted photos' deviance down by this part of what the best does ...
const CLOSE: f64 = 0.9;
/// ... from this part of the best's gain on: that photos left out are predicted worse may be the fault of how it is estimated.
const NEARLY: f64 = 0.4;

/// A model extended by one effect.
pub struct Fitted<'r> {
    /// The effect.
    pub effect: &'static Effect,
    /// What promised it.
    pub score: &'r Score,
    /// The model.
    pub model: Model,
    /// How much better it predicts than the model before.
    pub advance: Advance,
}

impl Fitted<'_> {
    /// Whether it explains about as much as the best.
    pub fn rivals(&self, best: &Self) -> bool {
        let (own, most) = (self.advance.gain().0, best.advance.gain().0);
        let (behind, error) = best.advance.gain_over(&self.advance);
        let close = self.advance.fall > CLOSE * best.advance.fall;
        own > RIVAL * most || behind < 2.0 * error && own > 0.7 * most || close && own > NEARLY * most
    }
}

/// Fits the effects of a shortlist, each added to the model alone; says of the others why not.
///
/// # Errors
/// A cancellation.
pub fn fit_shortlist<'r>(
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
        let best = fitted.iter().map(|f| f.advance.gain().0).fold(0.0, f64::max);
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
        if let Some((name, value, least)) = variant.strayed(&there.capture.numbers()) {
            let why = format!("its fit ends where it would be another effect: {name} at {value:.2}, below {least}");
            refuse(trials, effect.name, &why);
            continue;
        }
        let advance = Advance::between(&ranking.before, &there);
        fitted.push(Fitted { effect, score, model: there, advance });
    }
    let models: Vec<&Model> = fitted.iter().map(|f| &f.model).collect();
    let advances = Advance::of(&ranking.before, &models, ranking.least, options, workshop, observer)?;
    for (fitted, advance) in fitted.iter_mut().zip(advances) {
        let (gain, standard_error) = advance.gain();
        let reduced_chi_square = fitted.model.reduced_chi_square();
        let effect = fitted.effect.name.to_owned();
        tell(observer, &DiagnoseEvent::Refitted { effect, gain, standard_error, reduced_chi_square })?;
        fitted.advance = advance;
    }
    Ok(fitted)
}
