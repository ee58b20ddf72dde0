//! The score pass: one capture that holds every candidate at its null, and one evaluation of all their columns.

use crate::context::Context;
use crate::effects::{Direction, Effect, Variant};
use crate::evidence::gather::measured;
use crate::overlay::AddedFile;
use gonio_fit::Space;
use gonio_scene::capture::Range;
use gonio_scene::parameter::{Parameter, Term};
use gonio_scene::{Capture, Result, SceneError};
use std::collections::BTreeMap;

/// An effect's variant with its columns in the score pass.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// The effect.
    pub effect: &'static Effect,
    /// How it may be present.
    pub variant: Variant,
    /// Its columns, counted from the first after the model's own.
    pub columns: Vec<usize>,
    /// d direction (in the power that is scored) / d column, per column.
    pub scales: Vec<f64>,
}

/// Everything that one score pass asks.
#[derive(Debug)]
pub struct Probe {
    /// The capture with every candidate at its null: it means what the model's does.
    pub capture: Capture,
    /// Files that candidates add: path and contents.
    pub files: Vec<AddedFile>,
    /// The model's own columns, then the candidates'.
    pub columns: Vec<Parameter>,
    /// How many of them are the model's own.
    pub own: usize,
    /// The candidates.
    pub candidates: Vec<Candidate>,
}

impl Probe {
    /// The probe of `effects` in a context, whose capture frees the model's own parameters.
    ///
    /// # Errors
    /// A patch that the capture format refuses.
    pub fn new(context: &Context<'_>, effects: &[&'static Effect]) -> Result<Self> {
        let mut capture = context.capture.clone();
        let mut files: Vec<AddedFile> = Vec::new();
        let mut found: Vec<(&'static Effect, Variant)> = Vec::new();
        for effect in effects {
            for variant in (effect.variants)(context) {
                if measured::alone(&capture) && !measured::shows(&capture, &variant) {
                    continue;
                }
                variant.add_to(&mut capture, &mut files);
                found.push((*effect, variant));
            }
        }
        let space = Space::new(context.capture, &[])
            .map_err(|e| SceneError::new("capture.toml", e.to_string(), "mend its [fit]"))?;
        let mut columns = space.columns(space.start());
        let own = columns.len();
        let numbers = capture.numbers();
        let freed: Vec<String> = columns.iter().flat_map(|c| c.terms.iter().map(|t| t.number.clone())).collect();
        let mut candidates = Vec::new();
        for (effect, mut variant) in found {
            // What the model has freed already is no news.
            variant.directions.retain(|d| !freed.iter().any(|f| f == d.moves()));
            if variant.directions.is_empty() {
                continue;
            }
            let mut places = Vec::new();
            let mut scales = Vec::new();
            for direction in &variant.directions {
                let wanted = column(direction, &numbers)?;
                // Variants may share a direction.
                let place = columns[own..].iter().position(|c| *c == wanted).unwrap_or_else(|| {
                    columns.push(wanted);
                    columns.len() - own - 1
                });
                places.push(place);
                scales.push(scale(direction));
            }
            candidates.push(Candidate { effect, variant, columns: places, scales });
        }
        Ok(Self { capture, files, columns, own, candidates })
    }
}

fn column(direction: &Direction, numbers: &BTreeMap<String, (f64, Range)>) -> Result<Parameter> {
    let unknown =
        |name: &str| SceneError::new("capture.toml", "is no number of the extended capture", "report this").at(name);
    let (value, range) = *numbers.get(&direction.name).ok_or_else(|| unknown(&direction.name))?;
    let mut terms = vec![Term { number: direction.name.clone(), ratio: 1.0 }];
    for (number, ratio) in &direction.along {
        if !numbers.contains_key(number) {
            return Err(unknown(number));
        }
        terms.push(Term { number: number.clone(), ratio: *ratio });
    }
    // Several variants may share a number: a column's name tells them apart in messages.
    let (name, step, channel) = (direction.name.clone(), direction.step, direction.channel);
    Ok(Parameter { name, value, range, terms, step, channel })
}

/// A column holds (L(null + h) - L(null)) / h; where the size enters squared, its derivative by the square at null 0 is
/// that over h again.
fn scale(direction: &Direction) -> f64 {
    match (direction.power, direction.step.or(direction.step_at_null)) {
        (2, Some(step)) => 1.0 / step,
        _ => 1.0,
    }
}
