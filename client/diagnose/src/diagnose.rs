//! A diagnosis from end to end.

use crate::effects::{Effect, Variant};
use crate::judge::{Judgement, judge, with_held_out};
use crate::measured;
use crate::model::Model;
use crate::overlay::AddedFile;
use crate::result::{Considered, Diagnosis, Finding, FoundParameter, HeldOut, Verdict};
use crate::score::tail_probability;
use crate::select::{Addition, Selection, importance, select};
use crate::structure::{Look, STRONG, Seen, Structure, structure};
use crate::trial::Trial;
use crate::workshop::{Observer, Workshop, tell};
use crate::{DiagnoseError, DiagnoseEvent, Options};
use gonio_fit::FitError;
use gonio_scene::Capture;
use gonio_scene::capture::Role;
use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};
use std::time::Instant;

/// A base model that leaves more than this part of its excess over the noise unexplained has not been explained.
const MOSTLY: f64 = 0.5;

/// The same where no covariate carries what is left: photographs may be noisier than their sensor is said to be.
const NEARLY_ALL: f64 = 0.8;

/// Chi-square per observation of a base model that is no noise, whatever it depends on: in captures of another renderer
/// without any effect it is at most 1.05. Both that with the render's variance in the weights, which a firefly in a
/// photograph raises, and that of residuals cut at five standard deviations, which the render's noise raises, must exceed it.
const MISFIT: f64 = 1.2;

/// A diagnosis and what a report shows besides.
#[derive(Debug, Clone)]
pub struct Diagnosed {
    /// The outcome.
    pub diagnosis: Diagnosis,
    /// The extended, fitted capture with all of its photos; the base model's where nothing was found.
    pub capture: Capture,
    /// Files that the extension brought.
    pub files: Vec<AddedFile>,
    /// The base model's capture, without held-out photos.
    pub base_capture: Capture,
    /// The final model's, without held-out photos.
    pub last_capture: Capture,
    /// The fitted photos under the base model.
    pub before: Vec<Seen>,
    /// The fitted photos under the final model.
    pub after: Vec<Seen>,
    /// What each covariate explains before.
    pub structure_before: Vec<Structure>,
    /// And after.
    pub structure_after: Vec<Structure>,
    /// Why the held-out photos could not be judged, if so: the rest stands.
    pub unjudged: Option<String>,
}

/// Diagnoses a capture. Held-out photos are not even opened before the selection has ended.
///
/// The same capture, options and farm results give the same diagnosis to the last bit, `seconds` excepted.
///
/// # Errors
/// See [`DiagnoseError`]. A held-out photo that cannot be read is no error: the selection stands unjudged.
pub fn diagnose(
    whole: &Capture,
    options: &Options,
    workshop: &dyn Workshop,
    observer: &mut Observer<'_>,
) -> Result<Diagnosed, DiagnoseError> {
    let begin = Instant::now();
    options.effects()?;
    let mut fitted = whole.clone();
    fitted.photos.retain(|p| p.role == Role::Fit);
    fitted.reflectance.retain(|r| r.role == Role::Fit);
    if fitted.targets().next().is_none() {
        return Err(FitError::NoFitPhotos.into());
    }
    let pixels =
        fitted.photos.iter().map(|p| fitted.camera_of(p)).map(|c| u64::from(c.width) * u64::from(c.height)).sum();
    let options = &options.shared_among(pixels);
    tell(observer, &DiagnoseEvent::Stage { text: "fitting the base model".to_owned() })?;
    let base = Model::fit(&fitted, Vec::new(), Vec::new(), &options.base_fit(), workshop, observer)?;
    let before = structure(&base, options, workshop, observer)?;
    let selection = select(base, options, workshop, observer)?;
    let after = if selection.additions.is_empty() {
        before.clone()
    } else {
        structure(&selection.model, options, workshop, observer)?
    };
    let (judgement, unjudged) = match judge(&selection.base, &selection.model, whole, options, workshop, observer) {
        Ok(judgement) => (judgement, None),
        Err(DiagnoseError::Cancelled) => return Err(DiagnoseError::Cancelled),
        Err(error) => (None, Some(error.to_string())),
    };
    let mut diagnosis = conclude(whole, &selection, judgement.as_ref(), [&before, &after], options)?;
    diagnosis.seconds = begin.elapsed().as_secs_f64();
    let model = if diagnosis.found.is_empty() { &selection.base } else { &selection.model };
    let capture = with_held_out(model, whole)?;
    let files = model.files.clone();
    let (base_capture, last_capture) = (selection.base.capture, selection.model.capture);
    Ok(Diagnosed {
        diagnosis,
        capture,
        files,
        base_capture,
        last_capture,
        before: before.seen,
        after: after.seen,
        structure_before: before.structures,
        structure_after: after.structures,
        unjudged,
    })
}

fn conclude(
    whole: &Capture,
    selection: &Selection,
    judgement: Option<&Judgement>,
    left: [&Look; 2],
    options: &Options,
) -> Result<Diagnosis, DiagnoseError> {
    let (base, model) = (&selection.base, &selection.model);
    let mut candidates: Vec<Considered> = selection.trials.iter().map(|t| considered(t, base, options)).collect();
    let excess = |chi: f64| (chi - 1.0).max(0.0);
    let (before, after) = judgement.map_or((base.fit.fit.reduced_chi_square, model.fit.fit.reduced_chi_square), |j| {
        (j.before.reduced_chi_square, j.after.reduced_chi_square)
    });
    let misfit = |left: &Look| base.fit.fit.reduced_chi_square.min(left.cut_chi_square);
    let strong = |left: &Look| left.structures.first().filter(|s| s.strength > STRONG).cloned();
    let mut strongest = strong(left[1]);
    let mut why_not = None;
    if measured::alone(&base.capture) {
        why_not = measured::why_not(judgement, options).filter(|_| !selection.additions.is_empty());
    } else if !selection.additions.is_empty() {
        if judgement.is_some_and(|j| j.log_density_gain <= 0.0) {
            why_not = Some("does not predict the held-out photos better".to_owned());
        } else if whole.reflectance.is_empty()
            && (strongest.is_some() && excess(after) > MOSTLY * excess(before)
                || misfit(left[0]) > MISFIT && excess(after) > NEARLY_ALL * excess(before))
        {
            why_not = Some("leaves most of the misfit unexplained".to_owned());
        }
    }
    let found = if why_not.is_some() { Vec::new() } else { findings(selection, judgement)? };
    if let Some(why) = &why_not {
        // What was refused leaves the base model, and what is left of that.
        strongest = strong(left[0]);
        for addition in &selection.additions {
            let names = addition.effects.iter().map(|e| e.name);
            for name in names {
                if let Some(c) = candidates.iter_mut().find(|c| c.effect == name) {
                    c.refused_because = Some(why.clone());
                }
            }
        }
    }
    if found.is_empty() && strongest.is_none() && misfit(left[0]) > MISFIT {
        // No covariate that we know carries it, but noise it is not.
        strongest = left[0].structures.first().cloned();
    }
    let verdict = match (&found[..], &strongest) {
        ([_, ..], _) => Verdict::Named,
        ([], Some(_)) => Verdict::Unexplained,
        ([], None) => Verdict::None,
    };
    candidates.sort_by(|a, b| b.gain.unwrap_or(f64::MIN).total_cmp(&a.gain.unwrap_or(f64::MIN)));
    Ok(Diagnosis {
        capture: whole.name.clone(),
        verdict,
        last: if found.is_empty() { base.fit.clone() } else { model.fit.clone() },
        found,
        candidates,
        base: base.fit.clone(),
        unexplained: strongest,
        dispersion: base.dispersion(),
        seconds: 0.0,
    })
}

fn findings(selection: &Selection, judgement: Option<&Judgement>) -> Result<Vec<Finding>, DiagnoseError> {
    let model = &selection.model;
    let held_out = judgement.map(|j| HeldOut {
        log_density_gain: j.log_density_gain,
        standard_error: j.standard_error,
        reduced_chi_square_before: j.before.reduced_chi_square,
        reduced_chi_square_after: j.after.reduced_chi_square,
        rmse_before: j.before.rmse,
        rmse_after: j.after.rmse,
        psnr_before: j.before.psnr,
        psnr_after: j.after.psnr,
    });
    let each = selection.additions.iter().zip(&model.parts);
    Ok(each
        .map(|(addition, part)| {
            let of = |name: &str| part.variant.free.iter().any(|f| name == f || name.starts_with(&format!("{f}.")));
            let parameters = model
                .fit
                .parameters
                .iter()
                .filter(|e| of(&e.name))
                .map(|e| FoundParameter {
                    name: e.name.clone(),
                    value: e.value,
                    standard_error: e.standard_error,
                    null: null(&part.variant, &e.name),
                })
                .collect();
            Finding {
                effects: names_of(addition, model),
                parameters,
                score: addition.score,
                p_value: addition.p_value,
                held_out,
                separate_by: separation(&addition.effects),
            }
        })
        .collect())
}

fn null(variant: &Variant, name: &str) -> Option<f64> {
    let scored = variant.directions.iter().find(|d| d.name == name).map(|d| d.null);
    scored.or_else(|| variant.finer.iter().flatten().any(|n| n == name).then_some(0.0))
}

/// The set's names, without rivals that were found on their own.
fn names_of(addition: &Addition, model: &Model) -> Vec<String> {
    let (first, rivals) = addition.effects.split_at(1.min(addition.effects.len()));
    let apart = rivals.iter().filter(|r| !model.parts.iter().any(|p| p.effect.name == r.name));
    first.iter().chain(apart).map(|e| e.name.to_owned()).collect()
}

fn separation(effects: &[&'static Effect]) -> String {
    effects.iter().map(|e| e.separate_by).collect::<Vec<_>>().join("; ")
}

fn considered(trial: &Trial, base: &Model, options: &Options) -> Considered {
    let score = trial.first.as_ref().map(|f| &f.0);
    let count = options.effects().map_or(1, |e| e.len().max(1));
    // Samples of reflectance err alike: no test of independent ones has a power.
    let power = score.filter(|_| !measured::alone(&base.capture)).map(|s| {
        let size = importance(base, options) * base.observations() as f64 / base.dispersion();
        power(size, s.freedom, options.false_alarms / count as f64)
    });
    Considered {
        effect: trial.effect.name.to_owned(),
        family: trial.effect.family,
        score: score.map(|s| s.score),
        freedom: score.map(|s| s.freedom),
        p_value: score.map(|s| s.p_value),
        gain: score.map(|s| s.cross_gain),
        gain_standard_error: score.map(|s| s.cross_error),
        expected_change: trial.first.as_ref().map(|f| f.1.clone()).unwrap_or_default(),
        power,
        refused_because: trial.refused_because.clone(),
    }
}

/// Chance that a chi-square of `freedom` degrees with noncentrality `size` exceeds the value that one without exceeds with
/// `chance`, by the normal approximation to the noncentral distribution's cube root (Abdel-Aty 1954).
fn power(size: f64, freedom: usize, chance: f64) -> f64 {
    let k = freedom.max(1) as f64;
    let Ok(central) = ChiSquared::new(k) else { return 0.0 };
    let critical = central.inverse_cdf(1.0 - chance);
    debug_assert!(tail_probability(critical, freedom) < 2.0 * chance);
    let mean = k + size;
    let spread = 2.0 * (k + 2.0 * size) / (9.0 * mean * mean);
    let z = (libm::cbrt(critical / mean) - (1.0 - spread)) / spread.sqrt();
    Normal::standard().sf(z)
}

#[cfg(test)]
mod tests {
    use super::power;

    /// Noncentral chi-square tables: 80 % power at 5 % with one degree needs a noncentrality of 7.85; with five, 12.83.
    #[test]
    fn power_is_as_tabulated() {
        assert!((power(7.85, 1, 0.05) - 0.8).abs() < 0.02, "{}", power(7.85, 1, 0.05));
        assert!((power(12.83, 5, 0.05) - 0.8).abs() < 0.02, "{}", power(12.83, 5, 0.05));
        assert!(power(0.0, 3, 0.05) < 0.07);
    }
}
