//! Which of the scored candidates are worth a fit.

use super::accept::least;
use crate::evidence::{Evidence, Promise, ScorePass, ScoredCandidate};
use crate::policy::Policy;

/// Decrease of deviance per observation that a fit of a candidate is hoped to bring.
pub(super) fn promise(of: &Promise, candidate: &ScoredCandidate, policy: &Policy) -> f64 {
    // What stands at a place is scored at few of them, and a pattern's many numbers overshoot from their nulls. Where one photo alone knows a
    // direction, the others' prediction of it goes astray. A fit has to decide, then.
    let hopeful = candidate.searched
        || candidate.directions >= policy.pattern
        || of.cross_error > policy.undecided * of.explained;
    of.cross_gain.max(if hopeful { policy.hope * of.explained } else { 0.0 })
}

/// The most promising candidate of each effect in a score pass, most promising first.
#[must_use]
pub fn best_of_each<'a>(pass: &'a ScorePass, policy: &Policy) -> Vec<&'a ScoredCandidate> {
    let mut all: Vec<&ScoredCandidate> = pass.candidates.iter().collect();
    all.sort_by(|a, b| promise(&b.promise, b, policy).total_cmp(&promise(&a.promise, a, policy)));
    let mut best: Vec<&ScoredCandidate> = Vec::new();
    for candidate in all {
        if !best.iter().any(|known| known.effect == candidate.effect) {
            best.push(candidate);
        }
    }
    best
}

/// The candidates to be fitted: the few most promising, one of few numbers among them if there is any. Those whose place has to be
/// searched come last, as a search is dear.
pub(super) fn shortlist<'a>(evidence: &Evidence, policy: &Policy, pass: &'a ScorePass) -> Vec<&'a ScoredCandidate> {
    if evidence.files_alone() {
        // Evaluations are exact and cheap: nothing is taken from a quadratic that can be fitted.
        return pass.candidates.iter().collect();
    }
    let least = least(evidence, policy);
    let chance = policy.false_alarms / evidence.effects.len().max(1) as f64;
    let promising = |c: &&ScoredCandidate| {
        let promise = promise(&c.promise, c, policy);
        let broad = promise > policy.promise_errors * c.promise.cross_error || promise > policy.second_look * least;
        promise > least && broad && c.p_value < chance && stands_out(c, pass, policy)
    };
    let all: Vec<&ScoredCandidate> = best_of_each(pass, policy).into_iter().filter(promising).collect();
    let plain = |c: &&ScoredCandidate| c.directions < policy.pattern;
    let mut short: Vec<&ScoredCandidate> = all.iter().copied().take(policy.shortlist).collect();
    if !short.iter().any(plain) {
        short.extend(all.iter().copied().find(plain));
    }
    short.sort_by_key(|c| c.searched);
    short
}

/// Whether the photo whose numbers are suspected stands out among all photos; true of what belongs to no single photo.
fn stands_out(candidate: &ScoredCandidate, pass: &ScorePass, policy: &Policy) -> bool {
    if candidate.suspect.is_none() {
        return true;
    }
    let others = pass.candidates.iter().filter(|c| c.effect == candidate.effect && c.suspect != candidate.suspect);
    let mut explained: Vec<f64> = others.map(|c| c.promise.explained).collect();
    explained.sort_by(f64::total_cmp);
    explained.get(explained.len() / 2).is_none_or(|median| candidate.promise.explained > policy.stands_out * median)
}

/// The effects that may yet matter beside one that was found, by the derivatives that found it: only these are scored again.
pub(super) fn left_beside(
    evidence: &Evidence,
    policy: &Policy,
    pass: &ScorePass,
    found: &ScoredCandidate,
    then: usize,
) -> Vec<String> {
    let model = &evidence.models[then];
    let worth = policy.worth_scoring * least(evidence, policy);
    let mut left: Vec<String> = Vec::new();
    for beside in &model.beside {
        let Some(candidate) = pass.candidate(beside.candidate) else { continue };
        let promising = promise(beside, candidate, policy) > worth;
        if promising && candidate.effect != found.effect && !left.contains(&candidate.effect) {
            left.push(candidate.effect.clone());
        }
    }
    left
}
