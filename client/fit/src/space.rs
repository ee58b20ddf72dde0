//! The space of the free parameters: physical values on one side, unbounded coordinates on the other.

use crate::{FitError, Transform};
use gonio_scene::capture::CAPTURE_FILE;
use gonio_scene::{Capture, Parameter, SceneError};

/// The free parameters of a capture with their transforms.
#[derive(Debug, Clone)]
pub struct Space {
    parameters: Vec<Parameter>,
    transforms: Vec<Transform>,
    start: Vec<f64>,
}

/// A value is at its bound where its curvature is less than this. Without unit; derived: one unit of a coordinate moves the value by about its
/// distance from the bound, and the curvature is that distance over the value's standard error, squared. This is a hundredth of an error.
const UNFELT: f64 = 1e-4;

impl Space {
    /// The parameters that the capture frees, starting from its values where `start` names no other.
    ///
    /// # Errors
    /// A freed name that is none; a start that is not freed, or out of bounds.
    pub fn new(capture: &Capture, start: &[(String, f64)]) -> Result<Self, FitError> {
        let parameters = capture.free_parameters()?;
        let transforms = parameters.iter().map(|p| Transform::of(&p.name, p.range)).collect();
        let mut values: Vec<f64> = parameters.iter().map(|p| p.value).collect();
        for (name, value) in start {
            let mut known = false;
            for (p, v) in parameters.iter().zip(&mut values) {
                let below = p.name.strip_prefix(name.as_str());
                if below.is_some_and(|rest| rest.is_empty() || rest.starts_with('.')) {
                    if !p.range.holds(*value) {
                        let mend = format!("it must be {}", p.range);
                        return Err(SceneError::new(CAPTURE_FILE, format!("starts from {value}"), mend)
                            .at(&p.name)
                            .into());
                    }
                    (known, *v) = (true, *value);
                }
            }
            if !known {
                let names: Vec<&str> = parameters.iter().map(|p| p.name.as_str()).collect();
                let mend = format!("the freed names are: {}", names.join(", "));
                return Err(SceneError::new(CAPTURE_FILE, "is given a start but not freed", mend).at(name).into());
            }
        }
        Ok(Self { parameters, transforms, start: values })
    }

    /// Number of parameters.
    #[must_use]
    pub fn len(&self) -> usize {
        self.parameters.len()
    }

    /// Whether nothing is free.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.parameters.is_empty()
    }

    /// The parameters' dotted names.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        self.parameters.iter().map(|p| p.name.clone()).collect()
    }

    /// The parameters' transforms.
    #[must_use]
    pub fn transforms(&self) -> &[Transform] {
        &self.transforms
    }

    /// Starting values as given, physical units; may lie on a bound.
    #[must_use]
    pub fn start(&self) -> &[f64] {
        &self.start
    }

    /// Starting coordinates, strictly inside the bounds.
    #[must_use]
    pub fn start_coordinates(&self) -> Vec<f64> {
        self.transforms.iter().zip(&self.start).map(|(t, x)| t.coordinate(*x)).collect()
    }

    /// Physical values at coordinates `u`.
    #[must_use]
    pub fn values(&self, u: &[f64]) -> Vec<f64> {
        self.transforms.iter().zip(u).map(|(t, u)| t.value(*u)).collect()
    }

    /// d value / d coordinate at `u`.
    #[must_use]
    pub fn slopes(&self, u: &[f64]) -> Vec<f64> {
        self.transforms.iter().zip(u).map(|(t, u)| t.slope(*u)).collect()
    }

    /// The coordinates after a step, see [`Transform::retract`].
    #[must_use]
    pub fn retract(&self, u: &[f64], step: &[f64]) -> Vec<f64> {
        self.transforms.iter().zip(u.iter().zip(step)).map(|(t, (u, du))| t.retract(*u, *du)).collect()
    }

    /// The capture's numbers at physical `values`.
    #[must_use]
    pub fn numbers(&self, values: &[f64]) -> Vec<(String, f64)> {
        self.parameters.iter().zip(values).flat_map(|(p, v)| p.numbers(*v)).collect()
    }

    /// The parameters with `values` in place of the capture's, as derivative columns of a request.
    #[must_use]
    pub fn columns(&self, values: &[f64]) -> Vec<Parameter> {
        self.parameters.iter().zip(values).map(|(p, v)| Parameter { value: *v, ..p.clone() }).collect()
    }

    /// Whether each parameter multiplies light: photo values are linear in it, so that one normal-equation step finds
    /// it from any distance (variable projection; Golub and Pereyra 1973).
    #[must_use]
    pub fn linear(&self) -> Vec<bool> {
        self.parameters.iter().map(|p| p.terms.iter().all(|t| multiplies_light(&t.number))).collect()
    }

    /// Indices of the parameters all of whose numbers have this key: `roughness`, `ior`...
    #[must_use]
    pub fn of_key(&self, key: &str) -> Vec<usize> {
        let has = |number: &str| number.rsplit_once('.').is_some_and(|(_, last)| last == key);
        let all = self.parameters.iter().enumerate();
        all.filter(|(_, p)| p.terms.iter().all(|t| has(&t.number))).map(|(i, _)| i).collect()
    }

    /// Which parameters can move: all but those at a bound whose loss falls towards it, where the descent is over
    /// although the gradient is not zero. `gradient` and `curvature` (the diagonal of J'WJ) are in coordinates. A parameter that is
    /// less than a hundredth of its own error away from a bound is at it: its coordinate may run on for ever, and nothing changes.
    #[must_use]
    pub fn movable(&self, u: &[f64], gradient: &[f64], curvature: &[f64]) -> Vec<bool> {
        let held = |(i, t): (usize, &Transform)| {
            let value = t.value(u[i]);
            let unfelt = (curvature[i] < UNFELT).then(|| t.nearest_bound(value)).flatten();
            let outward = |bound: f64| if bound > value { gradient[i] < 0.0 } else { gradient[i] > 0.0 };
            t.bound(value).or(unfelt).is_some_and(outward)
        };
        self.transforms.iter().enumerate().map(|each| !held(each)).collect()
    }

    /// Names and values for an error message.
    #[must_use]
    pub fn describe(&self, values: &[f64]) -> String {
        let list: Vec<String> = self.parameters.iter().zip(values).map(|(p, v)| format!("{} = {v}", p.name)).collect();
        if list.is_empty() { "the capture's values".to_owned() } else { list.join(", ") }
    }
}

fn multiplies_light(number: &str) -> bool {
    let key = number.trim_end_matches(".r").trim_end_matches(".g").trim_end_matches(".b");
    let last = key.rsplit('.').next().unwrap_or(key);
    match number.split('.').next() {
        Some("light") => matches!(last, "intensity" | "irradiance" | "radiance" | "scale"),
        Some("photo") => matches!(last, "gain" | "exposure"),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn capture() -> Capture {
        Capture::parse(
            r#"
            format = 1
            name = "t"
            camera = { width = 4, height = 3, fx = 5.0, fy = 5.0, cx = 2.0, cy = 1.5 }
            [[material]]
            name = "a"
            model = "plastic"
            base_color = [1.0, 0.5, 0.0]
            roughness = 0.3
            ior = 1.5
            [[light]]
            name = "led"
            kind = "point"
            position = [0.0, 0.0, 1.0]
            intensity = [1.0, 2.0, 3.0]
            [[photo]]
            file = "p.exr"
            camera_to_world = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
            [fit]
            parameters = ["material.a.base_color", "material.a.roughness", "light.led.intensity"]
            gray = ["light.led.intensity"]
            "#,
        )
        .unwrap()
    }

    #[test]
    fn knows_what_multiplies_light_and_what_shapes_highlights() {
        let space = Space::new(&capture(), &[]).unwrap();
        assert_eq!(space.linear(), [false, false, false, false, true]);
        assert_eq!(space.of_key("roughness"), [3]);
    }

    #[test]
    fn a_gray_colour_keeps_its_ratio() {
        let space = Space::new(&capture(), &[]).unwrap();
        let numbers = space.numbers(&[0.1, 0.2, 0.3, 0.4, 5.0]);
        let intensity: Vec<f64> = numbers.iter().skip(4).map(|n| n.1).collect();
        assert_eq!(intensity, [2.5, 5.0, 7.5]);
    }

    #[test]
    fn a_parameter_is_held_only_against_its_bound() {
        let space = Space::new(&capture(), &[]).unwrap();
        let u = [11.0, 11.0, -11.0, 0.0, 0.0];
        assert_eq!(space.movable(&u, &[-1.0, 1.0, 1.0, -1.0, 1.0], &[1.0; 5]), [false, true, false, true, true]);
    }

    /// An intensity of 2.5e-7 whose error is 200 times as large, and whose loss falls towards 0, is at 0; with a tenth of that
    /// error it is not.
    #[test]
    fn what_is_small_beside_its_error_is_at_its_bound() {
        let space = Space::new(&capture(), &[]).unwrap();
        let u = [0.0, 0.0, 0.0, 0.0, -15.2];
        let at = |gradient: f64, curvature: f64| {
            space.movable(&u, &[0.0, 0.0, 0.0, 0.0, gradient], &[1.0, 1.0, 1.0, 1.0, curvature])[4]
        };
        assert!(!at(1e-2, 2.5e-5) && at(-1e-2, 2.5e-5) && at(1e-2, 2.5e-3));
    }

    #[test]
    fn every_coordinate_makes_numbers_that_the_capture_takes() {
        let space = Space::new(&capture(), &[]).unwrap();
        for u in [-1e3, -3.0, 0.0, 3.0, 1e3] {
            capture().set_numbers(&space.numbers(&space.values(&[u; 5]))).unwrap();
        }
    }

    #[test]
    fn a_start_reaches_a_colours_channels_and_is_checked() {
        let start = |name: &str, value| Space::new(&capture(), &[(name.to_owned(), value)]);
        assert_eq!(start("material.a.base_color", 0.2).unwrap().start()[..3], [0.2; 3]);
        assert!(start("material.a.base_color", 1.5).unwrap_err().to_string().contains("must be 0..=1"));
        assert!(start("material.a.ior", 1.5).unwrap_err().to_string().contains("not freed"));
    }
}
