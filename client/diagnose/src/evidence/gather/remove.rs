//! A model without one of its parts: what was added first may be needless once the rest is there.

use super::model::Model;
use crate::DiagnoseError;
use crate::DiagnoseEvent;
use crate::workshop::{Observer, Workshop, tell};
use gonio_fit::Options;

/// The model fitted again with part `k` at its null.
///
/// # Errors
/// A fit that fails, a cancellation.
pub fn without(
    model: &Model,
    k: usize,
    options: &Options,
    workshop: &dyn Workshop,
    observer: &mut Observer<'_>,
) -> Result<Model, DiagnoseError> {
    let mut capture = model.capture.clone();
    let mut parts = model.parts.clone();
    let part = parts.remove(k);
    tell(observer, &DiagnoseEvent::Stage { text: format!("fitting without {}", part.effect.name) })?;
    let variant = part.variant;
    let mut nulls: Vec<(String, f64)> = variant.directions.iter().map(|d| (d.moves().to_owned(), d.null)).collect();
    nulls.extend(variant.finer.iter().flatten().map(|name| (name.clone(), 0.0)));
    capture.set_numbers(&nulls)?;
    let kept = |name: &String| parts.iter().any(|p| p.variant.free.contains(name));
    capture.fit.parameters.retain(|name| !variant.free.contains(name) || kept(name));
    capture.fit.gray.retain(|name| !variant.gray.contains(name) || kept(name));
    Model::fit(&capture, model.files.clone(), parts, options, workshop, observer)
}
