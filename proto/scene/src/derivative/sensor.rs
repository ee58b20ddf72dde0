//! Columns of the sensor's numbers: a difference of the sensor stage, which needs no image.

use super::Contribution;
use crate::capture::{Capture, Sensor};
use crate::{Parameter, Result};

/// The two sensors whose photo values a parameter's column is the difference of: central, or one-sided where a bound is
/// nearer than the step.
///
/// # Errors
/// A number that the sensor does not have.
pub(super) fn difference(capture: &Capture, parameter: &Parameter) -> Result<Contribution> {
    let alone = Capture { sensor: capture.sensor.clone(), ..Capture::default() };
    let numbers = alone.numbers();
    let moved = |by: f64| -> Result<Sensor> {
        let value = |name: &str| numbers.get(name).map_or(0.0, |(value, _)| *value);
        let values: Vec<_> =
            parameter.terms.iter().map(|t| (t.number.clone(), value(&t.number) + t.ratio * by)).collect();
        let mut capture = alone.clone();
        capture.set_numbers(&values)?;
        Ok(capture.sensor)
    };
    let step = parameter.step.unwrap_or_else(|| step(parameter));
    let here = || capture.sensor.clone();
    let (from, to, distance) = match (moved(-step), moved(step)) {
        (Ok(from), Ok(to)) => (from, to, 2.0 * step),
        (Err(_), Ok(to)) => (here(), to, step),
        (Ok(from), Err(_)) => (from, here(), step),
        (Err(error), Err(_)) => return Err(error),
    };
    Ok(Contribution::Sensor { from: Box::new(from), to: Box::new(to), distance })
}

/// Half the distance of a central difference. Most numbers enter linearly; gamma's third derivative is negligible at
/// this step, and a clip level's step is a thousandth of itself, so that it counts the pixels near it.
fn step(parameter: &Parameter) -> f64 {
    let span = parameter.terms.iter().map(|t| t.ratio.abs()).fold(0.0, f64::max).max(1e-12);
    let own = if parameter.name.ends_with("clip_level") { 1e-3 * parameter.value.abs() } else { 1e-4 };
    own / span
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::derivative::Plan;

    fn plan(capture: &Capture, names: &[&str]) -> Result<Plan> {
        let names: Vec<String> = names.iter().map(|name| format!("sensor.{name}")).collect();
        Plan::new(capture, &capture.parameters(&names, &[])?)
    }

    #[test]
    fn differences_are_central_inside_the_bounds_and_one_sided_at_them() {
        let mut capture = Capture::default();
        for (gamma, ends, expected) in [(2.0, (2.0 - 1e-4, 2.0 + 1e-4), 2e-4), (10.0, (10.0 - 1e-4, 10.0), 1e-4)] {
            capture.sensor.gamma = gamma;
            let plan = plan(&capture, &["gamma"]).unwrap();
            assert!(plan.planes.is_empty());
            let [Contribution::Sensor { from, to, distance }] = &plan.columns[0][..] else { panic!("{plan:?}") };
            assert_eq!(((from.gamma, to.gamma), *distance), (ends, expected));
        }
        // The effect of clipping at 0.75, asked for at the null, which is the upper bound.
        let mut column = capture.parameters(&["sensor.clip_level".to_owned()], &[]).unwrap();
        column[0].step = Some(Sensor::NO_CLIP - 0.75);
        let plan = Plan::new(&capture, &column).unwrap();
        let [Contribution::Sensor { from, to, distance }] = &plan.columns[0][..] else { panic!("{plan:?}") };
        assert_eq!((from.clip_level, to.clip_level, *distance), (0.75, Sensor::NO_CLIP, Sensor::NO_CLIP - 0.75));
    }

    #[test]
    fn names_expand_in_order_and_noise_is_refused() {
        let capture = Capture::default();
        let names = ["sensor.vignetting".to_owned(), "sensor.crosstalk".to_owned()];
        let found: Vec<_> = capture.parameters(&names, &[]).unwrap().into_iter().map(|p| p.name).collect();
        let expected = ["vignetting.k1", "vignetting.k2", "crosstalk.rg", "crosstalk.rb", "crosstalk.gr"];
        assert_eq!(found[..5], expected.map(|key| format!("sensor.{key}")));
        assert_eq!(found[5..], ["gb", "br", "bg"].map(|pair| format!("sensor.crosstalk.{pair}")));
        for key in ["read_noise", "shot_noise", "saturation"] {
            assert!(plan(&capture, &[key]).unwrap_err().to_string().contains("no residual determines"), "{key}");
        }
    }

    #[test]
    fn sensor_and_scene_do_not_share_a_parameter() {
        let capture = Capture::default();
        let mut column = capture.parameters(&["sensor.gamma".to_owned()], &[]).unwrap();
        column[0].terms.push(crate::Term { number: "camera.fx".into(), ratio: 1.0 });
        assert!(Plan::new(&capture, &column).unwrap_err().to_string().contains("separate them"));
    }
}
