//! What a client asks for.

use super::{Digest, Result, WireError, at_most, finite, named, text};
use crate::{limits, wire};
use bytes::Bytes;
use gonio_scene::capture::Range;
use gonio_scene::{EvaluationRequest, Output, Parameter, Term};
use std::collections::BTreeSet;

/// Who asks: the farm is shared between requesters by the weight of their class.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Requester {
    /// A name that others do not use; empty where every evaluation is to count as a client of its own.
    pub client: String,
    /// How urgent it is.
    pub class: Class,
}

impl Requester {
    /// Who sends a message.
    ///
    /// # Errors
    /// A name that is too long, a class that is unknown here.
    pub fn of(message: &wire::EvaluationRequest) -> Result<Self> {
        if message.client.len() > limits::NAME_BYTES {
            let problem = format!("has {} bytes, the limit is {}", message.client.len(), limits::NAME_BYTES);
            return Err(WireError::new("EvaluationRequest.client", problem));
        }
        Ok(Self { client: text(&message.client), class: Class::from_wire("EvaluationRequest.class", message.class)? })
    }

    /// Signs a message.
    pub fn sign(&self, message: &mut wire::EvaluationRequest) {
        message.client.clone_from(&self.client);
        message.class = self.class.to_wire();
    }
}

/// Who waits for an evaluation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum Class {
    /// A person, or a fit.
    #[default]
    Interactive,
    /// Nobody: a sweep of thousands.
    Batch,
}

impl Class {
    pub(super) fn to_wire(self) -> i32 {
        match self {
            Self::Interactive => wire::Class::Interactive,
            Self::Batch => wire::Class::Batch,
        }
        .into()
    }

    pub(super) fn from_wire(field: &str, class: i32) -> Result<Self> {
        match wire::Class::try_from(class) {
            Ok(wire::Class::Interactive) => Ok(Self::Interactive),
            Ok(wire::Class::Batch) => Ok(Self::Batch),
            Err(_) => Err(WireError::new(field, format!("is {class}, unknown here"))),
        }
    }
}

/// The message for `request` about the capture `digest`; it is signed with [`Requester::sign`].
#[must_use]
pub fn request_to_wire(digest: Digest, request: &EvaluationRequest) -> wire::EvaluationRequest {
    wire::EvaluationRequest {
        capture_digest: digest.to_wire(),
        numbers: numbers_to_wire(&request.numbers),
        columns: columns_to_wire(&request.columns),
        // An index beyond 32 bits is beyond any capture's photos, and is refused as such.
        photos: request.photos.iter().map(|p| u32::try_from(*p).unwrap_or(u32::MAX)).collect(),
        samples: request.samples,
        difference_samples: request.difference_samples,
        forward_samples: request.forward_samples,
        seed: request.seed,
        output: match request.output {
            Output::Statistics => wire::Output::Statistics,
            Output::StatisticsAndFilms => wire::Output::StatisticsAndFilms,
            Output::Films => wire::Output::Films,
            Output::FirstHit => wire::Output::FirstHit,
        }
        .into(),
        client: String::new(),
        class: wire::Class::Interactive.into(),
        key: Bytes::new(),
        design_digest: Bytes::new(),
    }
}

/// The capture's digest and the request of a message.
///
/// # Errors
/// Anything outside the limits of [`limits`] or what the message's comments demand. Whether names and photos exist
/// is for who has the capture.
pub fn request_from_wire(message: wire::EvaluationRequest) -> Result<(Digest, EvaluationRequest)> {
    let digest = Digest::from_wire("EvaluationRequest.capture_digest", &message.capture_digest)?;
    let field = "EvaluationRequest.photos";
    at_most(field, message.photos.len(), limits::PHOTOS)?;
    if message.photos.is_empty() {
        return Err(WireError::new(field, "is empty: name at least one photo"));
    }
    let mut seen = BTreeSet::new();
    if let Some(twice) = message.photos.iter().find(|p| !seen.insert(**p)) {
        return Err(WireError::new(field, format!("names photo {twice} twice")));
    }
    if message.samples < 2 || !message.samples.is_multiple_of(2) || message.samples > limits::SAMPLES {
        let problem = format!("is {}, must be even and 2 to {}", message.samples, limits::SAMPLES);
        return Err(WireError::new("EvaluationRequest.samples", problem));
    }
    for (field, samples) in [
        ("EvaluationRequest.difference_samples", message.difference_samples),
        ("EvaluationRequest.forward_samples", message.forward_samples),
    ] {
        if samples > message.samples {
            return Err(WireError::new(field, format!("is {samples}, more than the {} samples", message.samples)));
        }
    }
    let output = match wire::Output::try_from(message.output) {
        Ok(wire::Output::Statistics) => Output::Statistics,
        Ok(wire::Output::StatisticsAndFilms) => Output::StatisticsAndFilms,
        Ok(wire::Output::Films) => Output::Films,
        Ok(wire::Output::FirstHit) => Output::FirstHit,
        Err(_) => {
            return Err(WireError::new("EvaluationRequest.output", format!("is {}, unknown here", message.output)));
        }
    };
    let request = EvaluationRequest {
        numbers: numbers_from_wire("EvaluationRequest.numbers", message.numbers)?,
        columns: columns_from_wire("EvaluationRequest.columns", message.columns)?,
        photos: message.photos.into_iter().map(|p| p as usize).collect(),
        samples: message.samples,
        difference_samples: message.difference_samples,
        forward_samples: message.forward_samples,
        seed: message.seed,
        output,
    };
    Ok((digest, request))
}

pub(super) fn numbers_to_wire(numbers: &[(String, f64)]) -> Vec<wire::Number> {
    numbers.iter().map(|(name, value)| wire::Number { name: name.clone(), value: *value }).collect()
}

pub(super) fn numbers_from_wire(field: &str, numbers: Vec<wire::Number>) -> Result<Vec<(String, f64)>> {
    at_most(field, numbers.len(), limits::NUMBERS)?;
    numbers
        .into_iter()
        .map(|n| {
            let name = named(field, n.name, limits::NAME_BYTES)?;
            let value = finite(&format!("{field}.{name}"), n.value)?;
            Ok((name, value))
        })
        .collect()
}

pub(super) fn columns_to_wire(columns: &[Parameter]) -> Vec<wire::Parameter> {
    let term = |t: &Term| wire::Term { number: t.number.clone(), ratio: t.ratio };
    columns
        .iter()
        .map(|p| wire::Parameter {
            name: p.name.clone(),
            value: p.value,
            minimum: p.range.min,
            maximum: p.range.max,
            terms: p.terms.iter().map(term).collect(),
            step: p.step,
            channel: p.channel.map(|c| c as u32),
        })
        .collect()
}

pub(super) fn columns_from_wire(field: &str, columns: Vec<wire::Parameter>) -> Result<Vec<Parameter>> {
    at_most(field, columns.len(), limits::COLUMNS)?;
    columns
        .into_iter()
        .map(|column| {
            let name = named(field, column.name, limits::NAME_BYTES)?;
            let field = format!("{field}.{name}");
            let range = Range { min: finite(&field, column.minimum)?, max: finite(&field, column.maximum)? };
            if range.min > range.max {
                return Err(WireError::new(field, format!("has the bounds {} to {}", range.min, range.max)));
            }
            at_most(&field, column.terms.len(), limits::TERMS)?;
            if column.terms.is_empty() {
                return Err(WireError::new(field, "moves no number"));
            }
            let terms = column.terms.into_iter().map(|term| {
                let number = named(&field, term.number, limits::NAME_BYTES)?;
                Ok(Term { number, ratio: finite(&field, term.ratio)? })
            });
            let terms = terms.collect::<Result<_>>()?;
            let step = column.step.map(|step| finite(&field, step)).transpose()?;
            if step.is_some_and(|step| step <= 0.0) {
                return Err(WireError::new(field, "has a step that is not above zero"));
            }
            let channel = column.channel.map(|c| c as usize);
            if channel.is_some_and(|channel| channel > 2) {
                return Err(WireError::new(field, "names a channel that is none of 0, 1, 2"));
            }
            Ok(Parameter { value: finite(&field, column.value)?, range, terms, name, step, channel })
        })
        .collect()
}
