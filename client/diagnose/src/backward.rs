//! The backward check: what was added first may be needless once the rest is there, as when one effect stood in for another.

use crate::advance::Advance;
use crate::model::Model;
use crate::select::Addition;
use crate::workshop::{Observer, Workshop, tell};
use crate::{DiagnoseError, DiagnoseEvent, Options};

/// Tries to drop each part but the last, and drops what does not matter by the rule that added it; returns the model and the
/// names of what it dropped.
///
/// # Errors
/// A fit that fails, a cancellation.
pub fn backward(
    mut model: Model,
    additions: &mut Vec<Addition>,
    least: f64,
    options: &Options,
    workshop: &dyn Workshop,
    observer: &mut Observer<'_>,
) -> Result<(Model, Vec<&'static str>), DiagnoseError> {
    let mut dropped = Vec::new();
    let mut k = 0;
    while k + 1 < model.parts.len() {
        let name = model.parts[k].effect.name;
        tell(observer, &DiagnoseEvent::Stage { text: format!("fitting without {name}") })?;
        let smaller = without(&model, k, options, workshop, observer)?;
        let advances = Advance::of(&smaller, &[&model], least, options, workshop, observer)?;
        if !advances.iter().any(|advance| advance.matters(least)) {
            model = smaller;
            additions.remove(k);
            dropped.push(name);
        } else {
            k += 1;
        }
    }
    Ok((model, dropped))
}

/// The model fitted again with part `k` at its null.
fn without(
    model: &Model,
    k: usize,
    options: &Options,
    workshop: &dyn Workshop,
    observer: &mut Observer<'_>,
) -> Result<Model, DiagnoseError> {
    let mut capture = model.capture.clone();
    let mut parts = model.parts.clone();
    let variant = parts.remove(k).variant;
    let mut nulls: Vec<(String, f64)> = variant.directions.iter().map(|d| (d.name.clone(), d.null)).collect();
    nulls.extend(variant.finer.iter().flatten().map(|name| (name.clone(), 0.0)));
    capture.set_numbers(&nulls)?;
    let kept = |name: &String| parts.iter().any(|p| p.variant.free.contains(name));
    capture.fit.parameters.retain(|name| !variant.free.contains(name) || kept(name));
    capture.fit.gray.retain(|name| !variant.gray.contains(name) || kept(name));
    Model::fit(&capture, model.files.clone(), parts, &options.refit(), workshop, observer)
}
