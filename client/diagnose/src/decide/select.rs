//! Forward selection, and back: which effects a model is extended by.

use super::accept::{Comparison, Deviances, error_gain, least};
use super::rival::rivals;
use super::shortlist::{best_of_each, left_beside, promise, shortlist};
use super::{Action, BASE, noise_level};
use crate::evidence::{Evidence, Folds, Outcome, ScorePass, ScoredCandidate};
use crate::policy::Policy;
use serde::Serialize;
use std::collections::BTreeMap;

/// Effects in a set that cannot be told apart, at most: more would name nothing.
const LARGEST_SET: usize = 2;
/// A file's effect that lowers the error on what it is fitted to by less than this part of what matters is not worth being fitted once
/// more without each file: left out, it gains less than that.
const HALF: f64 = 0.5;

/// An effect that the selection has added.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Addition {
    /// The effect and those that explain the same as well, best first.
    pub effects: Vec<String>,
    /// Its score when it was added.
    pub score: f64,
    /// Chance of such a score where no effect is present.
    pub p_value: f64,
    /// Decrease of left-out deviance per observation that it was added for.
    pub gain: f64,
    /// Standard error of that between units.
    pub gain_error: f64,
    /// The photo that all of its numbers belong to, if one alone is suspected.
    pub suspect: Option<usize>,
}

/// What the selection has come to.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Course {
    /// The model at its end.
    pub model: usize,
    /// What was added, in the order of the model's parts.
    pub additions: Vec<Addition>,
    /// Why each of the other effects was not.
    pub refused: BTreeMap<String, String>,
}

/// Selects.
///
/// # Errors
/// What is to be found out before it can go on.
pub(super) fn select(evidence: &Evidence, policy: &Policy) -> Result<Course, Action> {
    let mut course = Course { model: BASE, ..Course::default() };
    let mut effects = evidence.effects.clone();
    let mut dropped: Vec<String> = Vec::new();
    loop {
        while course.additions.len() < policy.most_effects && !effects.is_empty() {
            let model = course.model;
            let pass = evidence.pass(model).ok_or_else(|| Action::Score { model, effects: effects.clone() })?;
            let Some((best, then)) = extend(evidence, policy, pass, &mut course)? else { break };
            effects = remaining(evidence, policy, pass, best, then, &dropped);
            // What an unfinished fit leaves would be taken for another effect.
            course.model = evidence.settled(then).ok_or(Action::Settle { model: then })?;
        }
        let before = course.additions.len();
        let gone = back(evidence, policy, &mut course)?;
        if course.additions.len() == before {
            return Ok(course);
        }
        // What took the place of a wrong name may leave room for another.
        dropped.extend(gone);
        let taken = |name: &String| course.additions.iter().any(|a| a.effects.first() == Some(name));
        effects = evidence.effects.iter().filter(|e| !dropped.contains(e) && !taken(e)).cloned().collect();
    }
}

/// The effects that are scored after `best` was found.
fn remaining(
    evidence: &Evidence,
    policy: &Policy,
    pass: &ScorePass,
    best: &ScoredCandidate,
    then: usize,
    dropped: &[String],
) -> Vec<String> {
    let model = &evidence.models[then];
    let taken = |name: &String| model.parts.iter().any(|p| p.effect == *name) || dropped.contains(name);
    let mut left = if evidence.files_alone() {
        evidence.effects.clone()
    } else if model.reduced_chi_square - policy.quiet * noise_level(evidence, policy) < least(evidence, policy) {
        Vec::new()
    } else {
        left_beside(evidence, policy, pass, best, then)
    };
    left.retain(|name| !taken(name));
    left
}

/// A candidate that was fitted.
struct Contender<'a> {
    scored: &'a ScoredCandidate,
    model: usize,
    comparison: Comparison,
}

impl Contender<'_> {
    fn matters(&self, evidence: &Evidence, policy: &Policy) -> bool {
        self.comparison.matters(evidence, policy, self.scored.suspect)
    }
}

/// One round: fits what promises, and adds the best of what matters; returns it and the model with it, or nothing.
fn extend<'a>(
    evidence: &Evidence,
    policy: &Policy,
    pass: &'a ScorePass,
    course: &mut Course,
) -> Result<Option<(&'a ScoredCandidate, usize)>, Action> {
    if pass.model == BASE {
        refuse_unpromising(evidence, policy, pass, course);
    }
    let mut fitted = contenders(evidence, policy, pass, course)?;
    compare(evidence, policy, pass, &mut fitted, course)?;
    fitted.sort_by(|a, b| b.comparison.gain(evidence).total_cmp(&a.comparison.gain(evidence)));
    let best = choose(evidence, policy, &fitted);
    for (i, other) in fitted.iter().enumerate().filter(|(i, _)| Some(*i) != best) {
        let gain = other.comparison.gain(evidence);
        let why = match best {
            Some(best) => format!("gains {gain:.4} when fitted, another {:.4}", fitted[best].comparison.gain(evidence)),
            None => format!(
                "gains {gain:.4} (standard error {:.4}) when fitted; {:.4} would matter",
                fitted[i].comparison.error(evidence),
                least(evidence, policy)
            ),
        };
        course.refused.insert(other.scored.effect.clone(), why);
    }
    let Some(best) = best.map(|i| fitted.remove(i)) else { return Ok(None) };
    let rival = |other: &&Contender<'_>| {
        let close = rivals(&other.comparison, &best.comparison, evidence, policy);
        let another = other.scored.effect != best.scored.effect && !holds(other.scored, best.scored);
        another && close && matters_itself(evidence, policy, other)
    };
    let names = fitted.iter().filter(rival).map(|other| other.scored.effect.clone());
    course.additions.push(Addition {
        effects: std::iter::once(best.scored.effect.clone()).chain(names).take(LARGEST_SET).collect(),
        score: best.scored.score,
        p_value: best.scored.p_value,
        gain: best.comparison.gain(evidence),
        gain_error: best.comparison.error(evidence),
        suspect: best.scored.suspect,
    });
    course.refused.remove(&best.scored.effect);
    Ok(Some((best.scored, best.model)))
}

/// Whether one candidate frees all that another does, and more: it explains as much because it holds the other.
fn holds(large: &ScoredCandidate, small: &ScoredCandidate) -> bool {
    large.frees.len() > small.frees.len() && small.frees.iter().all(|name| large.frees.contains(name))
}

/// A rival of files must matter itself: files are few, and accidents alike.
fn matters_itself(evidence: &Evidence, policy: &Policy, other: &Contender<'_>) -> bool {
    !evidence.files_alone() || other.matters(evidence, policy)
}

/// The best of those that matter, by its place in `fitted`, which is sorted by gain. Of those that gain alike it is the one of fewest
/// numbers; a pattern is chosen only where it is worth its many.
fn choose(evidence: &Evidence, policy: &Policy, fitted: &[Contender<'_>]) -> Option<usize> {
    let gain = |i: usize| fitted[i].comparison.gain(evidence);
    let matter: Vec<usize> = (0..fitted.len()).filter(|i| fitted[*i].matters(evidence, policy)).collect();
    let most = gain(*matter.first()?);
    let alike = matter.iter().copied().filter(|i| gain(*i) > policy.rival * most);
    let first = alike.min_by_key(|i| fitted[*i].scored.directions)?;
    if fitted[first].scored.directions < policy.pattern {
        return Some(first);
    }
    let plain = matter.into_iter().find(|i| fitted[*i].scored.directions < policy.pattern);
    let worth = |plain: &usize| gain(first) <= policy.pattern_price * gain(*plain);
    Some(plain.filter(worth).unwrap_or(first))
}

/// Says of every effect, to begin with, why it is not even fitted.
fn refuse_unpromising(evidence: &Evidence, policy: &Policy, pass: &ScorePass, course: &mut Course) {
    let best = best_of_each(pass, policy);
    for effect in &evidence.effects {
        let why = match best.iter().any(|c| c.effect == *effect) {
            true => "promises too little",
            false => "the capture has nothing that it could act on",
        };
        course.refused.insert(effect.clone(), why.to_owned());
    }
}

/// The shortlisted candidates that came to a model.
fn contenders<'a>(
    evidence: &Evidence,
    policy: &Policy,
    pass: &'a ScorePass,
    course: &mut Course,
) -> Result<Vec<Contender<'a>>, Action> {
    let before = Deviances::by(pass, &evidence.models[pass.model]);
    let mut fitted: Vec<Contender<'a>> = Vec::new();
    for scored in shortlist(evidence, policy, pass) {
        let best = fitted.iter().map(|f| f.comparison.gain(evidence)).fold(0.0, f64::max);
        if !evidence.files_alone() && promise(&scored.promise, scored, policy) < policy.worth_fitting * best {
            continue;
        }
        let candidate = scored.promise.candidate;
        let noise = noise_level(evidence, policy);
        let excess = |model: usize| (evidence.models[model].reduced_chi_square - noise).max(0.0);
        let left = policy.enough * (pass.reduced_chi_square - noise).max(0.0);
        if scored.searched && fitted.iter().any(|f| excess(f.model) < left) {
            let why = "its place was not searched, as another effect that has none explains what there is";
            course.refused.insert(scored.effect.clone(), why.to_owned());
            continue;
        }
        let why = match evidence.attempt(pass.model, candidate) {
            None => return Err(Action::Fit { model: pass.model, candidate }),
            Some(Outcome::Model(model)) => {
                let comparison = Comparison::between(before, Deviances::of(&evidence.models[*model]));
                fitted.push(Contender { scored, model: *model, comparison });
                continue;
            }
            Some(Outcome::Nowhere) => "stands at no place that explains more".to_owned(),
            Some(Outcome::Strayed { name, value, least }) => {
                format!("its fit ends where it would be another effect: {name} at {value:.2}, below {least}")
            }
            Some(Outcome::Failed(why)) => format!("its fit failed: {why}"),
        };
        course.refused.insert(scored.effect.clone(), why);
    }
    Ok(fitted)
}

/// Compares the contenders with the model that they extend, by fits to parts of the units where the quadratic does not do.
fn compare(
    evidence: &Evidence,
    policy: &Policy,
    pass: &ScorePass,
    fitted: &mut Vec<Contender<'_>>,
    course: &mut Course,
) -> Result<(), Action> {
    if evidence.files_alone() {
        best_variants(evidence, policy, pass, fitted, course);
    }
    let start = &evidence.models[pass.model];
    let second = policy.second_look * least(evidence, policy);
    // What is left out would gain more than what is fitted: it was mispredicted before.
    let beyond = |c: &Contender<'_>| c.comparison.predicted(evidence) > c.comparison.fall(evidence).max(0.0) + second;
    let wanted = evidence.files_alone() || fitted.iter().any(beyond);
    if wanted && start.folds == Folds::Untried {
        return Err(Action::Fold { model: pass.model });
    }
    let before = Deviances::by(pass, start);
    for contender in fitted {
        let model = &evidence.models[contender.model];
        contender.comparison = Comparison::between(before, Deviances::of(model));
        let doubtful = contender.comparison.fall(evidence) >= second && !contender.matters(evidence, policy);
        if (evidence.files_alone() || doubtful) && model.folds == Folds::Untried {
            return Err(Action::Fold { model: contender.model });
        }
    }
    Ok(())
}

/// Of every effect of measured reflectance, the variant that fits best, where that is worth leaving files out.
fn best_variants(
    evidence: &Evidence,
    policy: &Policy,
    pass: &ScorePass,
    fitted: &mut Vec<Contender<'_>>,
    course: &mut Course,
) {
    let squares = |model: usize| evidence.models[model].loss.iter().sum::<f64>();
    fitted.sort_by(|a, b| squares(a.model).total_cmp(&squares(b.model)));
    let mut seen: Vec<&str> = Vec::new();
    let before: f64 = pass.loss.iter().sum();
    fitted.retain(|c| {
        let first = !seen.contains(&c.scored.effect.as_str());
        seen.push(&c.scored.effect);
        let own = error_gain(before, squares(c.model));
        let worth = own >= HALF * policy.smallest_file_gain;
        if first && !worth {
            let why = format!("error on the files fitted to {:+.1} %", -100.0 * own);
            course.refused.insert(c.scored.effect.clone(), why);
        }
        first && worth
    });
}

/// Takes out every part but the last that is not missed, by the rule that brought it in; returns the names of what went.
fn back(evidence: &Evidence, policy: &Policy, course: &mut Course) -> Result<Vec<String>, Action> {
    let mut gone = Vec::new();
    let mut part = 0;
    while part + 1 < evidence.models[course.model].parts.len() && !evidence.files_alone() {
        let model = course.model;
        let smaller = evidence.without(model, part).ok_or(Action::Remove { model, part })?;
        let whole = &evidence.models[model];
        let missed = |wanted: &dyn Fn(&Comparison) -> bool| {
            let before = Deviances::of(&evidence.models[smaller]);
            wanted(&Comparison::between(before, Deviances::of(whole)))
        };
        let second = policy.second_look * least(evidence, policy);
        let suspect = whole.parts[part].suspect;
        let matters = missed(&|c| c.matters(evidence, policy, suspect));
        if !matters && whole.folds == Folds::Untried && missed(&|c| c.fall(evidence) >= second) {
            return Err(Action::Fold { model });
        }
        if matters {
            part += 1;
            continue;
        }
        let name = whole.parts[part].effect.clone();
        course.refused.insert(name.clone(), "is not missed once the rest is there".to_owned());
        course.additions.remove(part);
        course.model = smaller;
        gone.push(name);
    }
    Ok(gone)
}
