//! Finds out what a decision lacks: fits, scores, folds, looks, and writes down what it learnt.

pub mod covariates;
mod cross;
mod finer;
mod folds;
pub mod judge;
pub(crate) mod measured;
pub mod model;
mod noise;
mod pass;
pub mod probe;
mod quadratic;
mod reduced;
mod refit;
mod remove;
pub mod score;
mod search;
mod settle;
pub mod structure;

use super::{
    Attempt, EVIDENCE_FORMAT, Evidence, FittedModel, Folds, HeldOutUnit, Judged, Number, Outcome, PartName, Remains,
    Removal, Unit, UnitKind,
};
use crate::decide::accept::{Comparison, Deviances};
use crate::decide::{Action, BASE, noise_level};
use crate::effects::Effect;
use crate::workshop::{Observer, Workshop, tell};
use crate::{DiagnoseError, DiagnoseEvent, Options};
use gonio_scene::capture::Role;
use gonio_scene::{Capture, PhotoStatistics};
use judge::Judgement;
use model::Model;
use pass::Pass;
use structure::Look;

/// A diagnosis' memory: the evidence, and the models and passes that it came from.
pub struct Gatherer<'a> {
    /// What is known.
    pub evidence: Evidence,
    /// The models, in the evidence's order.
    pub models: Vec<Model>,
    /// What was seen of models, by index.
    pub looks: Vec<(usize, Look)>,
    /// The judgement of the last model.
    pub judgement: Option<Judgement>,
    /// Why held-out photos could not be judged, if so.
    pub unjudged: Option<String>,
    whole: &'a Capture,
    effects: Vec<&'static Effect>,
    options: Options,
    workshop: &'a dyn Workshop,
    passes: Vec<Pass>,
}

impl<'a> Gatherer<'a> {
    /// Of a capture, of which nothing is known yet.
    ///
    /// # Errors
    /// Options that make no diagnosis.
    pub fn new(whole: &'a Capture, options: Options, workshop: &'a dyn Workshop) -> Result<Self, DiagnoseError> {
        let effects = options.effects()?;
        let evidence = Evidence {
            format: EVIDENCE_FORMAT,
            capture: whole.name.clone(),
            effects: effects.iter().map(|e| e.name.to_owned()).collect(),
            holds_out: whole.targets().any(|t| t.role() == Role::HeldOut),
            ..Evidence::default()
        };
        let (models, looks, passes) = (Vec::new(), Vec::new(), Vec::new());
        let (judgement, unjudged) = (None, None);
        Ok(Self { evidence, models, looks, judgement, unjudged, whole, effects, options, workshop, passes })
    }

    /// Does what a decision asks for, and writes down what it learns.
    ///
    /// # Errors
    /// An evaluation or fit that fails where no other can take its place, a cancellation.
    pub fn perform(&mut self, action: &Action, observer: &mut Observer<'_>) -> Result<(), DiagnoseError> {
        match action {
            Action::FitBase => self.fit_base(observer),
            Action::Look { model } => self.look(*model, observer),
            Action::Score { model, effects } => self.score(*model, effects, observer),
            Action::Fit { model, candidate } => self.fit(*model, *candidate, observer),
            Action::Fold { model } => self.fold(*model, observer),
            Action::Remove { model, part } => self.remove(*model, *part, observer),
            Action::Settle { model } => self.settle(*model, observer),
            Action::Judge { model } => self.judge(*model, observer),
            Action::Finish(_) => Ok(()),
        }
    }

    fn fit_base(&mut self, observer: &mut Observer<'_>) -> Result<(), DiagnoseError> {
        tell(observer, &DiagnoseEvent::Stage { text: "fitting the base model".to_owned() })?;
        let mut fitted = self.whole.clone();
        fitted.photos.retain(|p| p.role == Role::Fit);
        fitted.reflectance.retain(|r| r.role == Role::Fit);
        let options = self.options.base_fit();
        let base = Model::fit(&fitted, Vec::new(), Vec::new(), &options, self.workshop, observer)?;
        let photos = fitted.photos.iter().map(|p| (p.name(), UnitKind::Photo));
        let named = photos.chain(fitted.reflectance.iter().map(|r| (r.name(), UnitKind::File)));
        let unit = |((name, kind), p): ((&str, UnitKind), &PhotoStatistics)| Unit {
            name: name.to_owned(),
            kind,
            observations: p.observations as f64,
            floor: p.noise_floor,
        };
        self.evidence.units = named.zip(&base.fit.photos).map(unit).collect();
        self.keep(base);
        Ok(())
    }

    fn look(&mut self, model: usize, observer: &mut Observer<'_>) -> Result<(), DiagnoseError> {
        let look = structure::structure(&self.models[model], &self.options, self.workshop, observer)?;
        let (cut_chi_square, structures, noise) = (look.cut_chi_square, look.structures.clone(), look.noise);
        self.evidence.remains.push(Remains { model, cut_chi_square, structures, noise });
        self.looks.push((model, look));
        Ok(())
    }

    fn score(&mut self, model: usize, names: &[String], observer: &mut Observer<'_>) -> Result<(), DiagnoseError> {
        tell(observer, &DiagnoseEvent::Stage { text: format!("scoring {} effects", names.len()) })?;
        let effects: Vec<&'static Effect> =
            self.effects.iter().filter(|e| names.iter().any(|n| n == e.name)).copied().collect();
        let noise = noise_level(&self.evidence, &self.options.policy);
        let pass = Pass::of(&self.models[model], &effects, noise, &self.options, self.workshop, observer)?;
        tell(observer, &pass.event())?;
        self.evidence.passes.push(pass.record(model));
        self.passes.push(pass);
        Ok(())
    }

    fn fit(&mut self, model: usize, index: usize, observer: &mut Observer<'_>) -> Result<(), DiagnoseError> {
        let place = self.evidence.passes.iter().position(|p| p.model == model);
        let known = place.and_then(|p| Some((&self.passes[p], self.passes[p].score_of(index)?)));
        let Some((pass, score)) = known else { return Ok(()) };
        let candidate = &pass.probe.candidates[index];
        let (effect, variant) = (candidate.effect.name, &candidate.variant);
        tell(observer, &DiagnoseEvent::Stage { text: format!("fitting {effect} {}", variant.label) })?;
        let (policy, options) = (&self.options.policy, self.options.refit());
        let start = &self.models[model];
        let done = refit::refit(start, (candidate, score), policy, &options, self.workshop, observer);
        let outcome = match done {
            Err(DiagnoseError::Cancelled) => return Err(DiagnoseError::Cancelled),
            Err(error) => Outcome::Failed(error.to_string()),
            Ok(None) => Outcome::Nowhere,
            Ok(Some(there)) => match variant.strayed(&there.capture.numbers()) {
                Some((name, value, least)) => Outcome::Strayed { name: name.to_owned(), value, least },
                None => {
                    let mut record = record(&there);
                    if !measured::alone(&there.capture) {
                        record.beside = pass.beside(candidate);
                    }
                    Outcome::Model(self.keep_as(there, record))
                }
            },
        };
        if let Outcome::Model(then) = outcome {
            let (start, there) = (&self.evidence.models[model], &self.evidence.models[then]);
            if let Some(pass) = self.evidence.pass(model) {
                let comparison = Comparison::between(Deviances::by(pass, start), Deviances::of(there));
                let (gain, standard_error) = (comparison.gain(&self.evidence), comparison.error(&self.evidence));
                let reduced_chi_square = there.reduced_chi_square;
                let effect = effect.to_owned();
                tell(observer, &DiagnoseEvent::Refitted { effect, gain, standard_error, reduced_chi_square })?;
            }
        }
        self.evidence.attempts.push(Attempt { model, candidate: index, outcome });
        Ok(())
    }

    fn fold(&mut self, index: usize, observer: &mut Observer<'_>) -> Result<(), DiagnoseError> {
        let (model, options) = (&self.models[index], self.options.refit());
        let known = match measured::alone(&model.capture) {
            true => Some(measured::left_out(model, &options, self.workshop, observer)?),
            false => folds::left_out(model, &options, self.workshop, observer)?,
        };
        self.evidence.models[index].folds = known.map_or(Folds::Impossible, Folds::Known);
        Ok(())
    }

    fn remove(&mut self, model: usize, part: usize, observer: &mut Observer<'_>) -> Result<(), DiagnoseError> {
        let smaller = remove::without(&self.models[model], part, &self.options.refit(), self.workshop, observer)?;
        let then = self.keep(smaller);
        self.evidence.removals.push(Removal { model, part, then });
        Ok(())
    }

    fn settle(&mut self, model: usize, observer: &mut Observer<'_>) -> Result<(), DiagnoseError> {
        let settled = settle::settled(&self.models[model], &self.options, self.workshop, observer)?;
        let then = self.keep(settled);
        self.evidence.settled.push((model, then));
        Ok(())
    }

    fn judge(&mut self, model: usize, observer: &mut Observer<'_>) -> Result<(), DiagnoseError> {
        let (base, last) = (&self.models[BASE], &self.models[model]);
        match judge::judge(base, last, self.whole, &self.options, self.workshop, observer) {
            Ok(judgement) => self.judgement = Some(judgement),
            Err(DiagnoseError::Cancelled) => return Err(DiagnoseError::Cancelled),
            Err(error) => self.unjudged = Some(error.to_string()),
        }
        let pair = |(before, after): (&PhotoStatistics, &PhotoStatistics)| HeldOutUnit {
            observations: before.observations as f64,
            floor: before.noise_floor,
            before: before.loss(),
            after: after.loss(),
        };
        let units = self.judgement.iter().flat_map(|j| j.photos[0].iter().zip(&j.photos[1]).map(pair)).collect();
        self.evidence.judged.push(Judged { model, units });
        Ok(())
    }

    fn keep(&mut self, model: Model) -> usize {
        let record = record(&model);
        self.keep_as(model, record)
    }

    fn keep_as(&mut self, model: Model, record: FittedModel) -> usize {
        self.models.push(model);
        self.evidence.models.push(record);
        self.models.len() - 1
    }
}

/// What is written down of a model.
fn record(model: &Model) -> FittedModel {
    let part = |p: &model::Part| PartName {
        effect: p.effect.name.to_owned(),
        label: p.variant.label.clone(),
        suspect: p.variant.suspect,
    };
    let number =
        |e: &gonio_fit::Estimate| Number { name: e.name.clone(), value: e.value, standard_error: e.standard_error };
    FittedModel {
        parts: model.parts.iter().map(part).collect(),
        loss: model.fit.photos.iter().map(PhotoStatistics::loss).collect(),
        left_out: model.left_out.clone(),
        folds: Folds::Untried,
        reduced_chi_square: model.reduced_chi_square(),
        dispersion: model.dispersion(),
        numbers: model.fit.parameters.iter().map(number).collect(),
        beside: Vec::new(),
    }
}
