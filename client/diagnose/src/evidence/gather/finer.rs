//! How fine a pattern the photos support: a variation's finer coefficients, judged from one evaluation at the coarse optimum.

use crate::decide::accept::believed;
use crate::effects::Variant;
use crate::evidence::gather::model::{Model, all, statistics};
use crate::evidence::gather::quadratic::Quadratic;
use crate::policy::Policy;
use crate::workshop::{Observer, Workshop, tell};
use crate::{DiagnoseError, DiagnoseEvent};
use gonio_fit::{Options, Space};

/// Deviance that a coefficient must gain for its group to be tried (Akaike 1974): what left-out photos gain is an estimate, and
/// the best of several is one that is too large.
const PRICE: f64 = 2.0;

/// A model whose last part is `variant` without its finer coefficients, with as many groups of them as predict photos left
/// out better than fewer do: by the quadratic of one evaluation, then by a fit, which has to gain what would matter of an
/// effect. The logarithm of a colour is nearly linear in them, so that one quadratic tells.
///
/// # Errors
/// An evaluation or fit that fails, a cancellation.
pub fn refined(
    coarse: Model,
    variant: &Variant,
    policy: &Policy,
    options: &Options,
    workshop: &dyn Workshop,
    observer: &mut Observer<'_>,
) -> Result<Model, DiagnoseError> {
    let (groups, numbers) = supported(&coarse, variant, options, workshop, observer)?;
    if groups == 0 {
        return Ok(coarse);
    }
    let variant = variant.as_fine_as(groups);
    let mut capture = coarse.capture.clone();
    capture.set_numbers(&numbers)?;
    capture.fit.parameters.extend(variant.finer.iter().flatten().cloned());
    let mut parts = coarse.parts.clone();
    if let Some(part) = parts.last_mut() {
        part.variant = variant;
    }
    // From where the quadratic has its minimum: few samples would lead so many coefficients astray.
    let options =
        Options { min_samples: options.max_samples, max_iterations: Some(3), tolerance: 0.1, ..options.clone() };
    let fine = Model::fit(&capture, coarse.files.clone(), parts, &options, workshop, observer)?;
    let gains: Vec<f64> = coarse.left_out.iter().zip(&fine.left_out).map(|(before, after)| before - after).collect();
    let gain = gains.iter().sum::<f64>() / (fine.observations() as f64).max(1.0);
    Ok(if gain >= policy.floor && believed(&gains, policy.accident) { fine } else { coarse })
}

/// How many groups of finer coefficients photos left out gain by, and where all numbers are then best.
fn supported(
    coarse: &Model,
    variant: &Variant,
    options: &Options,
    workshop: &dyn Workshop,
    observer: &mut Observer<'_>,
) -> Result<(usize, Vec<(String, f64)>), DiagnoseError> {
    tell(observer, &DiagnoseEvent::Stage { text: format!("looking for finer patterns in {}", variant.label) })?;
    let mut capture = coarse.capture.clone();
    capture.fit.parameters.extend(variant.finer.iter().flatten().cloned());
    let space = Space::new(&capture, &[])?;
    let columns = space.columns(space.start());
    let mut farm = workshop.open(&capture, &coarse.files)?;
    let found = statistics(&capture, &all(&capture), true, options, farm.as_mut(), observer)?;
    let deviance = |further| coarse.left_out_with(&found, further).iter().sum::<f64>();
    let own = columns.len() - variant.finer.iter().map(Vec::len).sum::<usize>();
    let (mut further, mut best, mut groups, mut fitted) = (0, deviance(0), 0, own);
    for (i, group) in variant.finer.iter().enumerate() {
        further += group.len();
        let here = deviance(further) + PRICE * further as f64;
        if here < best {
            (best, groups, fitted) = (here, i + 1, own + further);
        }
    }
    let used: Vec<(usize, f64)> = (0..fitted).map(|i| (i, 1.0)).collect();
    let each: Vec<Quadratic> = found.iter().map(|p| Quadratic::new(p, &used)).collect();
    let step = Quadratic::sum(&each).map(|q| q.solve());
    let moved = step.iter().flat_map(|step| columns.iter().zip(step));
    Ok((groups, moved.flat_map(|(c, x)| c.numbers((c.value + x).clamp(c.range.min, c.range.max))).collect()))
}
