//! How many pixels an accuracy needs, by a fit to fewer.

use gonio_fit::FitResult;

/// Fits to ever more pixels, at most: the first says how many, the second may still be off by its own error.
pub(super) const ROUNDS: usize = 3;

/// Pixels of the first round.
pub(super) const PILOT: u64 = 1 << 17;

/// More than is needed by the errors, which are estimates themselves.
const MARGIN: f64 = 1.1;

/// The scatter between photos so many times the error by the model is taken for their disagreement, which no pixel mends.
const DISAGREE: f64 = 2.0;

/// What a fit to `pixels` pixels says about an accuracy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Verdict {
    /// It is reached.
    Reached,
    /// So many pixels are needed.
    Needs(u64),
    /// Photos disagree by more than it: the largest relative error.
    Disagree(f64),
}

/// Holds every freed number's error against `wanted`, relative to its value; a number that is 0 has no relative error and is passed
/// over, one that the data say nothing about cannot be reached by any number of pixels.
pub(super) fn judge(result: &FitResult, wanted: f64, pixels: u64) -> Verdict {
    let (mut scatter, mut model) = (0.0_f64, 0.0_f64);
    for p in result.parameters.iter().filter(|p| p.value != 0.0) {
        let (Some(error), Some(by_model)) = (p.standard_error, p.model_error) else { continue };
        if error > DISAGREE * by_model {
            scatter = scatter.max(error / p.value.abs());
        }
        model = model.max(by_model / p.value.abs());
    }
    if model > wanted {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)]
        return Verdict::Needs((pixels as f64 * MARGIN * (model / wanted) * (model / wanted)).ceil() as u64);
    }
    if scatter > wanted { Verdict::Disagree(scatter) } else { Verdict::Reached }
}
