//! One capture's diagnosis as a line of JSON, and what such lines say, those of earlier programs among them.

use gonio::farm::Farm;
use gonio_diagnose::Options;
use gonio_tests::evidence::Stored;
use gonio_tests::hidden::{STRENGTHS, diagnosed, hide, named as named_by};
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;

/// Samples per pixel of the hidden captures' films.
const SAMPLES: u32 = 512;
/// The label of a strength that is no row of the matrix.
pub const SWEPT: &str = "swept";

/// What is hidden in one capture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Case {
    /// An effect of the catalogue, or "none".
    pub effect: &'static str,
    /// A label of [`STRENGTHS`], [`SWEPT`], or nothing.
    pub label: &'static str,
    /// The strength as the generator takes it.
    pub at: f64,
    pub seed: u64,
}

impl Case {
    pub fn is_of(&self, outcome: &Value) -> bool {
        outcome["effect"] == self.effect && outcome["strength"] == self.label && outcome["seed"] == self.seed
    }

    /// Makes the capture and diagnoses it; writes what was learnt to `evidence`, and the capture's folder below `keep`.
    pub fn run(&self, farm: &Farm, evidence: &Path, keep: Option<&Path>) -> Value {
        let (Case { effect, label, at, seed }, begin) = (*self, Instant::now());
        let effects: Vec<_> = (effect != "none").then_some((effect, at)).into_iter().collect();
        let hidden = hide(&effects, seed, SAMPLES);
        if let Some(out) = keep {
            hidden.save(&out.join(format!("{effect}-{label}-{seed}")));
        }
        let mut outcome = json!({
            "effect": effect, "strength": label, "at": at, "seed": seed, "program": gonio_operations::COMMIT,
        });
        let said = match diagnosed(farm, &hidden.files, &Options::default()) {
            Ok(done) => {
                let d = &done.diagnosis;
                let expected = effects.iter().map(|(name, _)| (*name).to_owned()).collect();
                let stored = Stored { expected, evidence: done.evidence };
                stored.write(&evidence.join(format!("matrix-{effect}-{label}-{seed}.json")));
                let held_out = d.found.first().and_then(|f| f.held_out);
                let planted = d.candidates.iter().find(|c| c.effect == effect);
                json!({
                    "verdict": d.verdict, "named": named_by(d),
                    "gain": held_out.map(|h| h.log_density_gain),
                    "chi_before": d.base.fit.reduced_chi_square, "chi_after": d.last.fit.reduced_chi_square,
                    "refused": planted.and_then(|c| c.refused_because.clone()),
                    "left": d.unexplained.as_ref().map(|u| u.covariate.clone()), "seconds": d.seconds,
                })
            }
            Err(error) => {
                let seconds = begin.elapsed().as_secs_f64();
                json!({ "verdict": "failed", "named": [], "refused": error.to_string(), "seconds": seconds })
            }
        };
        if let (Some(all), Value::Object(said)) = (outcome.as_object_mut(), said) {
            all.extend(said);
        }
        outcome
    }
}

/// Everything that a diagnosis named: findings with those that could not be told from them.
pub fn named(outcome: &Value) -> Vec<Vec<String>> {
    serde_json::from_value(outcome["named"].clone()).unwrap_or_default()
}

/// Whether the hidden effect is among the first finding's.
pub fn is_right(outcome: &Value) -> bool {
    has(outcome, 1)
}

/// Whether the hidden effect is among the first or the second finding's.
pub fn is_found(outcome: &Value) -> bool {
    has(outcome, 2)
}

fn has(outcome: &Value, findings: usize) -> bool {
    named(outcome).iter().take(findings).flatten().any(|name| outcome["effect"] == **name)
}

/// The strength as a number, which earlier programs wrote as a label alone.
pub fn strength(outcome: &Value) -> Option<f64> {
    let label = || STRENGTHS.iter().find(|(label, _)| outcome["strength"] == *label);
    outcome["at"].as_f64().or_else(|| label().map(|(_, strength)| *strength))
}

/// How many outcomes are of which program.
pub fn programs(outcomes: &[Value]) -> String {
    let of = |o: &Value| o["program"].as_str().map(str::to_owned);
    let mut counts: Vec<(Option<String>, usize)> = Vec::new();
    for program in outcomes.iter().map(of) {
        match counts.iter_mut().find(|(known, _)| *known == program) {
            Some((_, count)) => *count += 1,
            None => counts.push((program, 1)),
        }
    }
    let name = |program: &Option<String>| {
        program.as_ref().map_or("a program that did not write its commit".to_owned(), |p| format!("commit `{p}`"))
    };
    match counts.as_slice() {
        [] => "No captures run.".to_owned(),
        [(program, count)] => format!("All {count} captures by one program: {}.", name(program)),
        _ => {
            let list: Vec<String> =
                counts.iter().map(|(program, count)| format!("{count} by {}", name(program))).collect();
            format!("Captures: {}.", list.join(", "))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_earlier_programs_are_read() {
        let old =
            json!({ "effect": "bumps", "strength": "weak", "seed": 1, "named": [["sheen"], ["bumps", "metallic"]] });
        assert_eq!(strength(&old), Some(0.35));
        assert!(is_found(&old) && !is_right(&old));
        let new = json!({ "effect": "bumps", "strength": SWEPT, "at": 0.1, "program": "abc", "named": [] });
        assert_eq!(strength(&new), Some(0.1));
        assert!(!is_found(&new));
        let none = json!({ "effect": "none", "strength": "", "named": [["none"]] });
        assert_eq!(strength(&none), None);
    }

    #[test]
    fn programs_are_counted() {
        let rows = ["a", "b", "a"].map(|program| json!({ "program": program }));
        assert_eq!(programs(&rows[..1]), "All 1 captures by one program: commit `a`.");
        assert_eq!(programs(&rows), "Captures: 2 by commit `a`, 1 by commit `b`.");
        let mixed = [rows[0].clone(), json!({})];
        assert!(programs(&mixed).ends_with("1 by a program that did not write its commit."));
    }
}
