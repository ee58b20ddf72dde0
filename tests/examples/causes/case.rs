//! One capture with causes that are known, and what its diagnosis says of them.

use gonio::farm::Farm;
use gonio_diagnose::{Diagnosis, Options};
use gonio_scene::Capture;
use gonio_tests::evidence::Stored;
use gonio_tests::hidden::misstate::{MISSTATEMENTS, Misstatement};
use gonio_tests::hidden::random::Random;
use gonio_tests::hidden::{Hidden, diagnosed, hide, named};
use serde_json::{Value, json};
use std::path::Path;

/// Samples per pixel of the hidden captures' films.
const SAMPLES: u32 = 512;
/// First number of the generators of what is hidden: apart from those that make the captures.
const STREAM: u64 = 9;
/// Strengths, from a third of moderate to moderate.
const STRENGTHS: [f64; 2] = [0.35, 1.0];

/// Effects of which the generator can hide several at once, ...
const FREE: [&str; 11] = [
    "vignetting",
    "crosstalk",
    "response-gamma",
    "black-level",
    "light-flicker",
    "pose-error",
    "bumps",
    "light-position",
    "ambient-light",
    "second-light",
    "clipping",
];
/// ... and those of which it can hide one, as a mixture of films.
const MIXED: [&str; 9] = [
    "light-size",
    "light-lobe",
    "veiling-glare",
    "albedo-variation",
    "roughness-variation",
    "second-lobe",
    "metallic",
    "clear-coat",
    "translucency",
];

/// What is wrong with a capture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Effects(usize),
    Suspect,
    Noise,
    Nothing,
}

impl Kind {
    pub fn of(word: &str) -> Self {
        match word {
            "pairs" => Self::Effects(2),
            "triples" => Self::Effects(3),
            "suspects" => Self::Suspect,
            "noise" => Self::Noise,
            "nothing" => Self::Nothing,
            other => panic!("\"{other}\": write pairs, triples, suspects, noise or nothing"),
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Effects(2) => "pairs",
            Self::Effects(_) => "triples",
            Self::Suspect => "suspects",
            Self::Noise => "noise",
            Self::Nothing => "nothing",
        }
    }
}

/// A capture by its kind and seed.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    pub kind: Kind,
    pub seed: u64,
}

impl Case {
    /// The effects to hide, with their strengths: at most one that is a mixture.
    fn effects(self) -> Vec<(&'static str, f64)> {
        let Kind::Effects(count) = self.kind else { return Vec::new() };
        let mut random = Random::new(self.seed, STREAM);
        let mut index = |n: usize| (random.between(0.0, n as f64) as usize).min(n - 1);
        let mut names: Vec<&str> = Vec::new();
        while names.len() < count {
            let i = index(FREE.len() + MIXED.len());
            let name = FREE.get(i).copied().unwrap_or_else(|| MIXED[i - FREE.len()]);
            let mixed = |n: &&str| MIXED.contains(n);
            let taken = names.contains(&name) || mixed(&name) && names.iter().any(mixed);
            if !taken {
                names.push(name);
            }
        }
        names.into_iter().map(|name| (name, random.between(STRENGTHS[0], STRENGTHS[1]))).collect()
    }

    fn wrong(self) -> Option<&'static Misstatement> {
        (self.kind == Kind::Suspect).then(|| &MISSTATEMENTS[(self.seed % MISSTATEMENTS.len() as u64) as usize])
    }

    fn make(self) -> Hidden {
        let hidden = hide(&self.effects(), 3000 + self.seed, SAMPLES);
        match (self.wrong(), self.kind) {
            (Some(wrong), _) => hidden.misstated(wrong),
            (None, Kind::Noise) => hidden.noisier(2.0),
            (None, _) => hidden,
        }
    }

    /// Makes the capture and diagnoses it; writes what was learnt below `evidence`, and the capture's folder below `keep`.
    pub fn run(self, farm: &Farm, evidence: &Path, keep: Option<&Path>) -> Value {
        let hidden = self.make();
        if let Some(out) = keep {
            hidden.save(&out.join(format!("{}-{}", self.kind.name(), self.seed)));
        }
        let effects = self.effects();
        let expected: Vec<&str> =
            effects.iter().map(|(name, _)| *name).chain(self.wrong().map(|wrong| wrong.suspect)).collect();
        let done = match diagnosed(farm, &hidden.files, &Options::default()) {
            Ok(done) => done,
            Err(error) => return json!({ "seed": self.seed, "expected": expected, "failed": error.to_string() }),
        };
        let name = format!("{}-{}.json", self.kind.name(), self.seed);
        let stored = Stored { expected: expected.iter().map(|e| (*e).to_owned()).collect(), evidence: done.evidence };
        stored.write(&evidence.join(name));
        let d = &done.diagnosis;
        let sets = named(d);
        let all = expected.iter().all(|e| sets.iter().any(|set| set.iter().any(|n| n == e)));
        // A set is clean if one of it was hidden.
        let clean = sets.iter().all(|set| set.iter().any(|n| expected.contains(&n.as_str())));
        let mut outcome = json!({
            "seed": self.seed, "expected": expected, "strengths": effects.iter().map(|e| e.1).collect::<Vec<_>>(),
            "verdict": d.verdict, "named": sets, "all": all, "clean": clean, "seconds": d.seconds,
            "chi_before": d.base.fit.reduced_chi_square, "chi_after": d.last.fit.reduced_chi_square,
            "refused": d.candidates.iter().filter(|c| expected.contains(&c.effect.as_str())).map(|c| &c.refused_because).collect::<Vec<_>>(),
        });
        if let Some(wrong) = self.wrong() {
            outcome["value"] = value(d, wrong, &hidden.truth);
        }
        outcome
    }
}

/// The corrected value, its standard error and the truth.
fn value(diagnosis: &Diagnosis, wrong: &Misstatement, truth: &Capture) -> Value {
    let all = diagnosis.found.iter().flat_map(|f| &f.parameters);
    let found = all.clone().find(|p| p.name == wrong.number || wrong.number.starts_with(&p.name));
    json!({
        "number": wrong.number, "found": found.map(|p| p.value), "error": found.and_then(|p| p.standard_error),
        "truth": (wrong.truth)(truth),
    })
}
