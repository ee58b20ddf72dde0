//! Every file predicted by a fit to the others.

use crate::DiagnoseError;
use crate::evidence::gather::model::{Model, fitted};
use crate::workshop::{Observer, Workshop};
use gonio_fit::{FitError, Options};
use gonio_scene::capture::Role;

/// Each file's deviance (see [`crate::evidence::gather::cross::left_out`]) when the model, already fitted to all, is fitted to the other files.
/// The quadratic at the common optimum that serves for photos would not do: files are few, and one that is left out, such as
/// the only grazing incidence, moves the others' optimum far. A single file has no others: it counts as fitted to.
pub(crate) fn left_out(
    model: &Model,
    options: &Options,
    workshop: &dyn Workshop,
    observer: &mut Observer<'_>,
) -> Result<Vec<f64>, DiagnoseError> {
    let photos = &model.fit.photos;
    if photos.len() < 2 {
        return Ok(photos.iter().map(gonio_scene::PhotoStatistics::loss).collect());
    }
    let mut farm = workshop.open(&model.capture, &model.files)?;
    let mut all = Vec::new();
    for photo in photos {
        let mut fold = model.capture.clone();
        for (i, file) in fold.reflectance.iter_mut().enumerate() {
            file.role = if i == photo.photo { Role::HeldOut } else { Role::Fit };
        }
        let score = fitted(&fold, options, farm.as_mut(), observer)?.held_out.ok_or(FitError::NoFitPhotos)?;
        all.push(score.reduced_chi_square * score.observations as f64);
    }
    Ok(all)
}
