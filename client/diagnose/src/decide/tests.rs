//! Courses of diagnoses over a made-up world: an oracle answers every action, so that each branch is seen without a render.

use super::*;
use crate::evidence::*;
use std::collections::BTreeMap;

const PHOTOS: usize = 6;
const OBSERVATIONS: f64 = 1000.0;

/// What an effect would do in this world.
#[derive(Clone)]
struct Truth {
    /// Decrease of each photo's deviance when it is added alone.
    gains: Vec<f64>,
    directions: usize,
    searched: bool,
    /// What its fit comes to, if not a model.
    outcome: Option<Outcome>,
    /// Effects whose part it explains as well.
    covers: Vec<&'static str>,
    /// Whose photo's numbers alone it moves.
    suspect: Option<usize>,
    frees: Vec<String>,
}

impl Truth {
    fn of(gains: &[f64]) -> Self {
        Self {
            gains: gains.to_vec(),
            directions: 1,
            searched: false,
            outcome: None,
            covers: Vec::new(),
            suspect: None,
            frees: Vec::new(),
        }
    }

    fn even(gain: f64) -> Self {
        Self::of(&[gain; PHOTOS])
    }
}

/// A world: what the base leaves, and what effects explain of it.
struct World {
    base: f64,
    effects: BTreeMap<&'static str, Truth>,
    structure: f64,
    held_out: Option<[f64; 2]>,
    /// Whether fits to parts of the photos can be made: they spread what an extension gains evenly.
    folds: bool,
    kind: UnitKind,
    noise: Option<[ChannelNoise; 3]>,
}

impl World {
    fn new(base: f64, effects: &[(&'static str, Truth)]) -> Self {
        let effects = effects.iter().cloned().collect();
        Self { base, effects, structure: 0.0, held_out: None, folds: false, kind: UnitKind::Photo, noise: None }
    }

    fn evidence(&self) -> Evidence {
        let unit =
            |i: usize| Unit { name: i.to_string(), kind: self.kind, observations: OBSERVATIONS, floor: OBSERVATIONS };
        Evidence {
            format: EVIDENCE_FORMAT,
            effects: self.effects.keys().map(|name| (*name).to_owned()).collect(),
            units: (0..PHOTOS).map(unit).collect(),
            holds_out: self.held_out.is_some(),
            ..Evidence::default()
        }
    }

    /// A model's losses: what the effects of its parts leave of the base's, none explained twice.
    fn model(&self, parts: &[String]) -> FittedModel {
        let covered = |name: &str| {
            let by = |other: &String| self.effects[other.as_str()].covers.contains(&name);
            parts.iter().any(by)
        };
        let explained: Vec<&Truth> = parts.iter().filter(|p| !covered(p)).map(|p| &self.effects[p.as_str()]).collect();
        let loss: Vec<f64> = (0..PHOTOS)
            .map(|i| OBSERVATIONS * self.base - explained.iter().map(|t| t.gains[i]).sum::<f64>())
            // No effect explains the noise.
            .map(|loss| loss.max(OBSERVATIONS.min(OBSERVATIONS * self.base)))
            .collect();
        FittedModel {
            parts: parts
                .iter()
                .map(|p| PartName {
                    effect: p.clone(),
                    label: String::new(),
                    suspect: self.effects[p.as_str()].suspect,
                })
                .collect(),
            reduced_chi_square: loss.iter().sum::<f64>() / (OBSERVATIONS * PHOTOS as f64),
            left_out: loss.clone(),
            loss,
            dispersion: 1.0,
            ..FittedModel::default()
        }
    }

    fn answer(&self, evidence: &mut Evidence, action: &Action) {
        let parts = |evidence: &Evidence, model: usize| -> Vec<String> {
            evidence.models[model].parts.iter().map(|p| p.effect.clone()).collect()
        };
        match action {
            Action::FitBase => evidence.models.push(self.model(&[])),
            Action::Look { model } => {
                let structure =
                    Structure { covariate: "image x".to_owned(), strength: self.structure, curve: Vec::new() };
                let cut_chi_square = evidence.models[*model].reduced_chi_square;
                evidence.remains.push(Remains {
                    model: *model,
                    cut_chi_square,
                    structures: vec![structure],
                    noise: self.noise,
                });
            }
            Action::Score { model, effects } => {
                let here = self.model(&parts(evidence, *model));
                let candidates = effects.iter().enumerate().map(|(candidate, name)| {
                    let mut with = parts(evidence, *model);
                    with.push(name.clone());
                    let there = self.model(&with);
                    let gain =
                        (here.loss.iter().sum::<f64>() - there.loss.iter().sum::<f64>()) / evidence.observations();
                    let truth = &self.effects[name.as_str()];
                    ScoredCandidate {
                        effect: name.clone(),
                        label: String::new(),
                        directions: truth.directions,
                        searched: truth.searched,
                        suspect: truth.suspect,
                        frees: truth.frees.clone(),
                        score: 100.0,
                        freedom: 1,
                        p_value: if gain > 0.0 { 1e-9 } else { 0.5 },
                        promise: Promise { candidate, explained: gain, cross_gain: gain, cross_error: 0.0 },
                        expected_change: Vec::new(),
                    }
                });
                evidence.passes.push(ScorePass {
                    model: *model,
                    loss: here.loss.clone(),
                    left_out: here.loss.clone(),
                    reduced_chi_square: here.reduced_chi_square,
                    candidates: candidates.collect(),
                });
            }
            Action::Fit { model, candidate } => {
                let pass = evidence.pass(*model).unwrap();
                let name = pass.candidates[*candidate].effect.clone();
                let beside = pass.candidates.iter().map(|c| c.promise).collect();
                let outcome = self.effects[name.as_str()].outcome.clone().unwrap_or_else(|| {
                    let mut with = parts(evidence, *model);
                    with.push(name);
                    evidence.models.push(FittedModel { beside, ..self.model(&with) });
                    Outcome::Model(evidence.models.len() - 1)
                });
                evidence.attempts.push(Attempt { model: *model, candidate: *candidate, outcome });
            }
            Action::Fold { model } => {
                let mean = evidence.models[*model].loss.iter().sum::<f64>() / PHOTOS as f64;
                evidence.models[*model].folds =
                    if self.folds { Folds::Known(vec![mean; PHOTOS]) } else { Folds::Impossible };
            }
            Action::Remove { model, part } => {
                let mut with = parts(evidence, *model);
                with.remove(*part);
                evidence.models.push(self.model(&with));
                let then = evidence.models.len() - 1;
                evidence.removals.push(Removal { model: *model, part: *part, then });
            }
            Action::Settle { model } => {
                evidence.models.push(self.model(&parts(evidence, *model)));
                evidence.settled.push((*model, evidence.models.len() - 1));
            }
            Action::Judge { model } => {
                let unit = |[before, after]: [f64; 2]| HeldOutUnit { observations: 1e3, floor: 1e3, before, after };
                evidence.judged.push(Judged { model: *model, units: self.held_out.map(unit).into_iter().collect() });
            }
            Action::Finish(_) => {}
        }
    }

    fn run(&self) -> (Decision, Vec<Action>) {
        let (mut evidence, mut actions) = (self.evidence(), Vec::new());
        for _ in 0..200 {
            match next(&evidence, &Policy::default()) {
                Action::Finish(decision) => return (*decision, actions),
                action => {
                    self.answer(&mut evidence, &action);
                    actions.push(action);
                }
            }
        }
        panic!("no end: {actions:?}");
    }

    fn names(&self) -> Vec<Vec<String>> {
        self.run().0.course.additions.into_iter().map(|a| a.effects).collect()
    }
}

fn fits(actions: &[Action]) -> usize {
    actions.iter().filter(|a| matches!(a, Action::Fit { .. })).count()
}

#[test]
fn a_base_without_misfit_ends_with_none_and_without_a_fit() {
    let (decision, actions) = World::new(1.0, &[("gamma", Truth::even(0.5))]).run();
    assert_eq!(decision.verdict, Verdict::None);
    assert_eq!(fits(&actions), 0);
    assert!(decision.course.refused["gamma"].contains("too little"));
}

#[test]
fn one_cause_is_named_alone() {
    let world = World::new(1.5, &[("coat", Truth::even(50.0)), ("gamma", Truth::even(499.0))]);
    let (decision, actions) = world.run();
    assert_eq!(decision.verdict, Verdict::Named);
    assert_eq!(world.names(), [["gamma"]]);
    assert!(actions.contains(&Action::Settle { model: 1 }));
}

#[test]
fn as_many_causes_are_named_as_there_are() {
    let effects =
        [("a", Truth::even(600.0)), ("b", Truth::even(300.0)), ("c", Truth::even(100.0)), ("d", Truth::even(0.1))];
    let names = World::new(2.0, &effects).names();
    assert_eq!(names, [["a"], ["b"], ["c"]]);
}

#[test]
fn what_another_explains_as_well_goes() {
    // "wrong" stands for a part of what "right" explains, and is found first.
    let right = Truth { covers: vec!["wrong"], directions: 19, ..Truth::even(880.0) };
    let world = World::new(1.9, &[("right", right), ("wrong", Truth::even(650.0))]);
    let (decision, actions) = world.run();
    assert_eq!(world.names(), [["right"]]);
    assert!(decision.course.refused["wrong"].contains("not missed"), "{:?}", decision.course.refused);
    assert!(actions.iter().any(|a| matches!(a, Action::Remove { part: 0, .. })));
}

#[test]
fn rivals_make_a_set_of_two() {
    let world = World::new(1.5, &[("a", Truth::even(498.0)), ("b", Truth::even(485.0)), ("c", Truth::even(475.0))]);
    assert_eq!(world.names(), [["a", "b"]]);
}

#[test]
fn a_gain_of_one_photo_alone_is_an_accident() {
    let one = Truth::of(&[900.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let mut world = World::new(1.5, &[("a", one)]);
    world.structure = 0.1;
    let (decision, actions) = world.run();
    assert_eq!(decision.verdict, Verdict::Unexplained);
    assert!(decision.course.refused["a"].contains("would matter"), "{:?}", decision.course.refused);
    // Large enough for a second look, by fits.
    assert!(actions.contains(&Action::Fold { model: 1 }));
}

#[test]
fn a_pattern_must_be_worth_its_numbers() {
    let pattern = |gain| Truth { directions: 19, ..Truth::even(gain) };
    assert_eq!(
        World::new(1.5, &[("pattern", pattern(450.0)), ("plain", Truth::even(350.0))]).names()[0],
        ["plain", "pattern"]
    );
    assert_eq!(World::new(1.5, &[("pattern", pattern(499.0)), ("plain", Truth::even(100.0))]).names(), [["pattern"]]);
    assert_eq!(World::new(1.5, &[("pattern", pattern(499.0)), ("plain", Truth::even(0.0))]).names(), [["pattern"]]);
}

#[test]
fn what_comes_to_no_model_is_refused_with_its_reason() {
    let with = |outcome| Truth { outcome: Some(outcome), ..Truth::even(300.0) };
    let strayed = Outcome::Strayed { name: "camera.glare_width".to_owned(), value: 0.5, least: 1.5 };
    let effects = [
        ("failed", with(Outcome::Failed("no".to_owned()))),
        ("nowhere", with(Outcome::Nowhere)),
        ("strayed", with(strayed)),
    ];
    let mut world = World::new(1.5, &effects);
    world.structure = 0.1;
    let (decision, _) = world.run();
    assert_eq!(decision.verdict, Verdict::Unexplained);
    assert!(decision.course.refused["failed"].contains("its fit failed: no"));
    assert!(decision.course.refused["nowhere"].contains("no place"));
    assert!(decision.course.refused["strayed"].contains("camera.glare_width"));
}

#[test]
fn no_place_is_searched_where_enough_is_explained() {
    let searched = Truth { searched: true, ..Truth::even(499.0) };
    let world = World::new(1.5, &[("gamma", Truth::even(496.0)), ("wall", searched)]);
    let (decision, actions) = world.run();
    assert_eq!(fits(&actions), 1);
    assert!(decision.course.refused["wall"].contains("not searched"));
}

#[test]
fn what_promises_far_less_than_another_gains_is_not_fitted() {
    let world = World::new(2.0, &[("a", Truth::even(900.0)), ("b", Truth::even(150.0))]);
    let (_, actions) = world.run();
    assert_eq!(actions.iter().position(|a| matches!(a, Action::Fit { candidate: 1, model: 0 })), None);
}

#[test]
fn folds_overrule_the_quadratic() {
    // Mispredicted by the quadratic: gains nothing when left out, but by fits to parts of the photos it does.
    let mut world = World::new(1.5, &[("a", Truth::of(&[500.0, 500.0, 0.0, 0.0, 0.0, 0.0]))]);
    assert_eq!(world.run().0.verdict, Verdict::Unexplained);
    world.folds = true;
    assert_eq!(world.run().0.verdict, Verdict::Named);
}

#[test]
fn held_out_photos_have_the_last_word() {
    let mut world = World::new(1.5, &[("gamma", Truth::even(480.0))]);
    world.held_out = Some([1500.0, 1020.0]);
    assert_eq!(world.run().0.verdict, Verdict::Named);
    world.held_out = Some([1500.0, 1510.0]);
    let (decision, _) = world.run();
    assert_eq!(decision.verdict, Verdict::Unexplained);
    assert!(decision.refused.unwrap().contains("held-out"));
}

#[test]
fn what_leaves_most_of_the_misfit_is_not_named() {
    let mut world = World::new(2.0, &[("gamma", Truth::even(200.0))]);
    world.structure = 0.1;
    let (decision, _) = world.run();
    assert_eq!(decision.verdict, Verdict::Unexplained);
    assert!(decision.refused.unwrap().contains("most of the misfit"));
    // Without structure in what is left, a fifth has to be explained, and is.
    world.structure = 0.0;
    world.effects.insert("gamma", Truth::even(250.0));
    assert_eq!(world.run().0.verdict, Verdict::Named);
}

#[test]
fn a_misfit_without_structure_is_still_one() {
    let world = World::new(1.5, &[("gamma", Truth::even(0.0))]);
    assert_eq!(world.run().0.verdict, Verdict::Unexplained);
    assert_eq!(World::new(1.1, &[("gamma", Truth::even(0.0))]).run().0.verdict, Verdict::None);
}

#[test]
fn files_are_judged_by_their_error_and_folded() {
    let mut world = World::new(4.0, &[("coat", Truth::even(2000.0)), ("sheen", Truth::even(100.0))]);
    (world.kind, world.folds) = (UnitKind::File, true);
    let (decision, actions) = world.run();
    assert_eq!(decision.course.additions[0].effects, ["coat"]);
    assert!(decision.course.refused["sheen"].contains("fitted to"), "{:?}", decision.course.refused);
    assert!(actions.contains(&Action::Fold { model: BASE }));
    world.held_out = Some([4000.0, 3900.0]);
    assert!(world.run().0.refused.unwrap().contains("held-out files"));
}

#[test]
fn an_effect_without_a_candidate_could_act_on_nothing() {
    let world = World::new(1.5, &[("gamma", Truth::even(480.0))]);
    let mut evidence = world.evidence();
    evidence.effects.push("absent".to_owned());
    loop {
        match next(&evidence, &Policy::default()) {
            Action::Finish(decision) => {
                assert!(decision.course.refused["absent"].contains("act on"));
                break;
            }
            Action::Score { model, effects } => {
                let effects = effects.into_iter().filter(|e| e != "absent").collect();
                world.answer(&mut evidence, &Action::Score { model, effects });
            }
            action => world.answer(&mut evidence, &action),
        }
    }
}

#[test]
fn accidents_have_the_chance_of_fishers_test() {
    use super::accept::{accident, believed};
    assert_eq!(accident(&[1.0; 5]), 1.0 / 32.0);
    assert_eq!(accident(&[1.0, 0.0, 0.0, 0.0, 0.0]), 0.5);
    assert_eq!(accident(&[1.0, 1.0, 0.0, 0.0, 0.0, 0.0]), 0.25);
    assert_eq!(accident(&[-1.0; 3]), 1.0);
    // Many units, by random signs: the sum of a hundred signs exceeds 20 with a chance of 0.028 (two standard deviations, continuity corrected).
    let gains: Vec<f64> = (0..100).map(|i| if i < 60 { 1.0 } else { -1.0 }).collect();
    assert!((accident(&gains) - 0.0284).abs() < 0.008, "{}", accident(&gains));
    // Two photos cannot do better than both.
    assert!(believed(&[1.0, 1.0], 0.05) && !believed(&[1.0, -0.1], 0.05));
}

#[test]
fn a_photo_that_stands_out_is_a_suspect() {
    let suspect = |gain: f64| {
        let mut gains = [0.0; PHOTOS];
        gains[2] = gain;
        Truth { suspect: Some(2), frees: vec!["photo.2.gain".to_owned()], ..Truth::of(&gains) }
    };
    let mut world = World::new(1.08, &[("exposure", suspect(80.0))]);
    // All of what the median photo leaves is noise.
    world.structure = 0.1;
    let (decision, _) = world.run();
    assert_eq!(decision.course.additions[0].effects, ["exposure"]);
    assert_eq!(decision.course.additions[0].suspect, Some(2));
}

#[test]
fn of_effects_that_gain_alike_the_one_of_fewest_numbers_is_first_and_what_holds_it_no_rival() {
    let frees = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect::<Vec<_>>();
    let flicker = Truth { directions: 5, frees: frees(&["photo.1.gain", "photo.2.gain"]), ..Truth::even(499.0) };
    let exposure = Truth { frees: frees(&["photo.2.gain"]), ..Truth::even(490.0) };
    assert_eq!(World::new(1.5, &[("flicker", flicker.clone()), ("exposure", exposure)]).names(), [["exposure"]]);
    let other = Truth { frees: frees(&["sensor.gamma"]), ..Truth::even(490.0) };
    assert_eq!(World::new(1.5, &[("flicker", flicker), ("gamma", other)]).names(), [["gamma", "flicker"]]);
}

#[test]
fn noise_is_no_misfit() {
    let mut world = World::new(4.0, &[("gamma", Truth::even(0.0))]);
    assert_eq!(world.run().0.verdict, Verdict::Unexplained);
    world.noise = Some([ChannelNoise { variance: 4.0, error: 0.02 }; 3]);
    let (decision, _) = world.run();
    assert_eq!((decision.verdict, decision.noise), (Verdict::None, world.noise));
    assert_eq!(world.noise.unwrap()[0].factor().0, 2.0);
    // Not known well enough, or as stated.
    world.noise = Some([ChannelNoise { variance: 1.3, error: 0.2 }; 3]);
    assert_eq!(world.run().0.noise, None);
}
