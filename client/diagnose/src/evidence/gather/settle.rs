//! The last fit of an extended model: all of its numbers free, with all samples.

use super::model::Model;
use crate::workshop::{Observer, Workshop, tell};
use crate::{DiagnoseError, DiagnoseEvent, Options};

/// The model fitted for good.
///
/// # Errors
/// A fit that fails, a cancellation.
pub fn settled(
    model: &Model,
    options: &Options,
    workshop: &dyn Workshop,
    observer: &mut Observer<'_>,
) -> Result<Model, DiagnoseError> {
    tell(observer, &DiagnoseEvent::Stage { text: "fitting the extended model".to_owned() })?;
    let mut capture = model.capture.clone();
    for name in model.parts.iter().flat_map(|part| &part.variant.free) {
        if !capture.fit.parameters.contains(name) {
            capture.fit.parameters.push(name.clone());
        }
    }
    let last = options.last_fit(model.parts.iter().any(|part| !part.variant.search.is_empty()));
    Model::fit(&capture, model.files.clone(), model.parts.clone(), &last, workshop, observer)
}
