//! What a diagnosis says in the end.

use super::accept::error_gain;
use super::{BASE, Course, excess_noise, noise_level};
use crate::evidence::{ChannelNoise, Evidence, Judged, Remains, Structure, UnitKind};
use crate::policy::Policy;
use serde::Serialize;

/// The sentence of a diagnosis in one word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The residuals look like noise.
    None,
    /// A cause is named, and lowers the error on photos that it was not fitted to.
    Named,
    /// Something is left that no effect of the catalogue explains.
    Unexplained,
}

/// What was decided.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Decision {
    /// In one word.
    pub verdict: Verdict,
    /// The last model: the base where nothing was added.
    pub model: usize,
    /// How the selection went.
    pub course: Course,
    /// Why what was added is not named, if so.
    pub refused: Option<String>,
    /// Red, green and blue noise of the photographs, where it is larger than the sensor is said to have.
    pub noise: Option<[ChannelNoise; 3]>,
    /// What is left, where it matters: the covariate that predicts most of it.
    pub unexplained: Option<Structure>,
}

/// Concludes from a finished selection.
pub(super) fn verdict(
    evidence: &Evidence,
    policy: &Policy,
    mut course: Course,
    last: usize,
    judged: Option<&Judged>,
    [before, after]: [&Remains; 2],
) -> Decision {
    let refused = match course.additions.is_empty() {
        true => None,
        false => {
            // No held-out photo shows what is wrong with another.
            let shown = course.additions.iter().any(|a| a.suspect.is_none());
            let judged = judged.filter(|j| shown && !j.units.is_empty());
            why_not(evidence, policy, last, judged, [before, after])
        }
    };
    if let Some(why) = &refused {
        for effect in course.additions.iter().flat_map(|a| &a.effects) {
            course.refused.insert(effect.clone(), why.clone());
        }
    }
    let named = refused.is_none() && !course.additions.is_empty();
    // What was refused leaves the base model, and what is left of that.
    let left = if refused.is_some() { before } else { after };
    let mut unexplained = strong(left, policy).cloned();
    if !named && unexplained.is_none() && misfit(evidence, before) > policy.misfit * noise_level(evidence, policy) {
        // No covariate that we know carries it, but noise it is not.
        unexplained = before.structures.first().cloned();
    }
    let verdict = match (named, &unexplained) {
        (true, _) => Verdict::Named,
        (false, Some(_)) => Verdict::Unexplained,
        (false, None) => Verdict::None,
    };
    let noise = excess_noise(evidence, policy);
    Decision { verdict, model: last, course, refused, noise, unexplained }
}

/// Why what was added is not to be named; none where it is.
fn why_not(
    evidence: &Evidence,
    policy: &Policy,
    last: usize,
    judged: Option<&Judged>,
    [before, after]: [&Remains; 2],
) -> Option<String> {
    if evidence.files_alone() {
        let [first, then] = judged?.chi_squares()?;
        let gain = error_gain(first, then);
        let [percent, least] = [gain, policy.smallest_file_gain].map(|g| 100.0 * g);
        let why = format!("changes the error on held-out files by {:.1} %; {least:.0} % less would matter", -percent);
        return (gain < policy.smallest_file_gain).then_some(why);
    }
    if judged.is_some_and(|j| j.units.iter().map(|u| u.before - u.after).sum::<f64>() <= 0.0) {
        return Some("does not predict the held-out photos better".to_owned());
    }
    if evidence.units.iter().any(|u| u.kind == UnitKind::File) {
        return None;
    }
    let noise = noise_level(evidence, policy);
    let fitted = [BASE, last].map(|model| evidence.models[model].reduced_chi_square);
    let [first, then] = judged.and_then(Judged::chi_squares).unwrap_or(fitted).map(|chi| (chi - noise).max(0.0));
    let structured = strong(after, policy).is_some() && then > policy.mostly * first;
    let nothing = misfit(evidence, before) > policy.misfit * noise && then > policy.nearly_all * first;
    (structured || nothing).then(|| "leaves most of the misfit unexplained".to_owned())
}

/// Chi-square of the base model that is surely no noise: the smaller of two, of which a firefly raises one and the render's noise the other.
fn misfit(evidence: &Evidence, left: &Remains) -> f64 {
    evidence.models[BASE].reduced_chi_square.min(left.cut_chi_square)
}

/// The covariate that predicts most of what is left, if it counts as structure.
fn strong<'a>(left: &'a Remains, policy: &Policy) -> Option<&'a Structure> {
    left.structures.first().filter(|s| s.strength > policy.structure)
}
