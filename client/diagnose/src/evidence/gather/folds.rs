//! Cross-validation by fits: dear, but true where the quadratic that [`crate::evidence::gather::cross`] makes of one fit does not hold, as when
//! one photo alone knows a number, or few samples see most of a derivative.

use crate::evidence::gather::model::{Model, statistics};
use crate::workshop::{Observer, Workshop, tell};
use crate::{DiagnoseError, DiagnoseEvent};
use gonio_fit::Options;

/// Parts that the photos are dealt into; each is predicted by a fit to the others.
const FOLDS: usize = 3;
/// Iterations of such a fit, which starts where the fit to all has ended.
const ITERATIONS: u32 = 4;

/// Each photo's deviance under `model` fitted to the photos of other folds; none where
/// a number of a photo is freed, which no other photo predicts, or where there are too few photos.
///
/// # Errors
/// A fit that fails, a cancellation.
pub fn left_out(
    model: &Model,
    options: &Options,
    workshop: &dyn Workshop,
    observer: &mut Observer<'_>,
) -> Result<Option<Vec<f64>>, DiagnoseError> {
    let photos = model.capture.photos.len();
    let of_photos = model.capture.fit.parameters.iter().any(|name| name.starts_with("photo."));
    if of_photos || photos < 2 || photos != model.capture.targets().count() {
        return Ok(None);
    }
    tell(observer, &DiagnoseEvent::Stage { text: "predicting photos by fits to the others".to_owned() })?;
    let options = Options { min_samples: options.max_samples, max_iterations: Some(ITERATIONS), ..options.clone() };
    let mut deviances = vec![0.0; photos];
    for fold in 0..FOLDS.min(photos) {
        let of_fold = |photo: usize| photo % FOLDS == fold;
        let mut capture = model.capture.clone();
        let kept = capture.photos.iter().enumerate().filter(|(photo, _)| !of_fold(*photo));
        capture.photos = kept.map(|(_, photo)| photo.clone()).collect();
        let parts = model.parts.clone();
        let fitted = Model::fit(&capture, model.files.clone(), parts, &options, workshop, observer)?;
        let whole = fitted.fit.apply(&model.capture)?;
        let mut farm = workshop.open(&whole, &model.files)?;
        let out: Vec<usize> = (0..photos).filter(|photo| of_fold(*photo)).collect();
        let found = statistics(&whole, &out, false, &options, farm.as_mut(), observer)?;
        for (photo, p) in out.iter().zip(&found) {
            deviances[*photo] = p.loss();
        }
    }
    Ok(Some(deviances))
}
