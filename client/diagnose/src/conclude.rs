//! From a decision to what a diagnosis returns.

use crate::decide::{self, Addition, BASE, Decision, Verdict, accept};
use crate::diagnose::Diagnosed;
use crate::effects::{Effect, Variant, all};
use crate::evidence::gather::judge::{Judgement, with_held_out};
use crate::evidence::gather::model::Model;
use crate::evidence::gather::score::tail_probability;
use crate::evidence::gather::{Gatherer, structure::Look};
use crate::evidence::{Evidence, ScoredCandidate};
use crate::result::{Considered, Diagnosis, Finding, FoundParameter, HeldOut};
use crate::{DiagnoseError, Options};
use gonio_scene::Capture;
use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};

/// What a diagnosis returns, `seconds` excepted.
///
/// # Errors
/// A capture that the format refuses.
pub(crate) fn conclude(
    whole: &Capture,
    gatherer: &Gatherer<'_>,
    decision: &Decision,
    options: &Options,
) -> Result<Diagnosed, DiagnoseError> {
    let (base, last) = (&gatherer.models[BASE], &gatherer.models[decision.model]);
    let named = decision.verdict == Verdict::Named;
    let shown = if named { last } else { base };
    let found = if named { findings(gatherer, decision, last) } else { Vec::new() };
    let diagnosis = Diagnosis {
        capture: whole.name.clone(),
        verdict: decision.verdict,
        found,
        candidates: candidates(&gatherer.evidence, decision, options),
        base: base.fit.clone(),
        last: shown.fit.clone(),
        noise: decision.noise,
        unexplained: decision.unexplained.clone(),
        dispersion: base.dispersion(),
        seconds: 0.0,
    };
    let look = |model: usize| gatherer.looks.iter().find(|(m, _)| *m == model).map(|(_, look)| look);
    let seen = |look: Option<&Look>| look.map(|l| (l.seen.clone(), l.structures.clone())).unwrap_or_default();
    let (before, structure_before) = seen(look(BASE));
    let (after, structure_after) = seen(look(decision.model));
    Ok(Diagnosed {
        diagnosis,
        evidence: gatherer.evidence.clone(),
        capture: with_held_out(shown, whole)?,
        files: shown.files.clone(),
        base_capture: base.capture.clone(),
        last_capture: last.capture.clone(),
        before,
        after,
        structure_before,
        structure_after,
        unjudged: gatherer.unjudged.clone(),
    })
}

fn findings(gatherer: &Gatherer<'_>, decision: &Decision, model: &Model) -> Vec<Finding> {
    let held_out = gatherer.judgement.as_ref().map(held_out);
    let each = decision.course.additions.iter().zip(&model.parts);
    let found = each.map(|(addition, part)| {
        let of = |name: &str| part.variant.free.iter().any(|f| name == f || name.starts_with(&format!("{f}.")));
        let parameters = model.fit.parameters.iter().filter(|e| of(&e.name)).map(|e| FoundParameter {
            name: e.name.clone(),
            value: e.value,
            standard_error: e.standard_error,
            null: null(&part.variant, &e.name),
        });
        Finding {
            effects: names_of(addition, model),
            subject: part.variant.label.clone(),
            gain: addition.gain,
            parameters: parameters.collect(),
            score: addition.score,
            p_value: addition.p_value,
            held_out,
            separate_by: separation(&addition.effects),
        }
    });
    found.collect()
}

fn held_out(judgement: &Judgement) -> HeldOut {
    HeldOut {
        log_density_gain: judgement.log_density_gain,
        standard_error: judgement.standard_error,
        reduced_chi_square_before: judgement.before.reduced_chi_square,
        reduced_chi_square_after: judgement.after.reduced_chi_square,
        rmse_before: judgement.before.rmse,
        rmse_after: judgement.after.rmse,
        psnr_before: judgement.before.psnr,
        psnr_after: judgement.after.psnr,
    }
}

fn null(variant: &Variant, name: &str) -> Option<f64> {
    let scored = variant.directions.iter().find(|d| d.moves() == name).map(|d| d.null);
    scored.or_else(|| variant.finer.iter().flatten().any(|n| n == name).then_some(0.0))
}

/// The set's names, without rivals that were found on their own.
fn names_of(addition: &Addition, model: &Model) -> Vec<String> {
    let (first, rivals) = addition.effects.split_at(1.min(addition.effects.len()));
    let apart = rivals.iter().filter(|r| !model.parts.iter().any(|p| p.effect.name == r.as_str()));
    first.iter().chain(apart).cloned().collect()
}

fn entry(name: &str) -> Option<&'static Effect> {
    all().find(|e| e.name == name)
}

fn separation(effects: &[String]) -> String {
    effects.iter().filter_map(|name| entry(name)).map(|e| e.separate_by).collect::<Vec<_>>().join("; ")
}

/// Every effect by its best candidate in the first score pass, the most gaining first.
fn candidates(evidence: &Evidence, decision: &Decision, options: &Options) -> Vec<Considered> {
    let best = evidence.pass(BASE).map(|pass| decide::best_of_each(pass, &options.policy)).unwrap_or_default();
    let considered = |name: &String| {
        let scored: Option<&ScoredCandidate> = best.iter().find(|c| c.effect == *name).copied();
        // Samples of reflectance err alike: no test of independent ones has a power.
        let power = scored.filter(|_| !evidence.files_alone()).map(|s| {
            let dispersion = evidence.models[BASE].dispersion;
            let size = accept::least(evidence, &options.policy) * evidence.observations() / dispersion;
            power(size, s.freedom, options.policy.false_alarms / evidence.effects.len().max(1) as f64)
        });
        Some(Considered {
            effect: name.clone(),
            family: entry(name)?.family,
            score: scored.map(|s| s.score),
            freedom: scored.map(|s| s.freedom),
            p_value: scored.map(|s| s.p_value),
            gain: scored.map(|s| s.promise.cross_gain),
            gain_standard_error: scored.map(|s| s.promise.cross_error),
            expected_change: scored.map(|s| s.expected_change.clone()).unwrap_or_default(),
            power,
            refused_because: decision.course.refused.get(name).cloned(),
        })
    };
    let mut all: Vec<Considered> = evidence.effects.iter().filter_map(considered).collect();
    all.sort_by(|a, b| b.gain.unwrap_or(f64::MIN).total_cmp(&a.gain.unwrap_or(f64::MIN)));
    all
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
