//! Measured reflectance: a file of samples of a material's BRDF, in place of a photograph or beside some.

use super::photo::{Role, role, stem};
use super::visit::{Range, Section, Visitor};
use crate::Result;

/// One file of BRDF samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Reflectance {
    /// The file's path, relative to the capture; see [`crate::reflectance`] for its format.
    pub file: String,
    /// The name of the material that was measured.
    pub material: String,
    /// Standard deviation of a value relative to the value.
    pub relative_noise: f64,
    /// Standard deviation of a value of zero, 1/sr.
    pub noise: f64,
    /// What it is used for.
    pub role: Role,
}

impl Default for Reflectance {
    fn default() -> Self {
        Self {
            file: String::new(),
            material: String::new(),
            relative_noise: Self::RELATIVE_NOISE,
            noise: Self::NOISE,
            role: Role::Fit,
        }
    }
}

impl Reflectance {
    /// The relative noise of a file that states none: what a good gonioreflectometer repeats to.
    pub const RELATIVE_NOISE: f64 = 0.05;
    /// The noise of a file that states none: 0.3 % of a white surface's value.
    pub const NOISE: f64 = 1e-3;

    /// The name in dotted names and in reports: the file's name without folder and extension.
    #[must_use]
    pub fn name(&self) -> &str {
        stem(&self.file)
    }

    /// What stands for the BRDF `value` where values are compared, and its slope.
    ///
    /// With s = noise / relative_noise it is s asinh(value / s): as it is where it is small, its logarithm times s where it
    /// is large. A measured value's standard deviation, root of noise^2 + (relative_noise value)^2, is `noise` of it
    /// everywhere: so no weight depends on a value, whose errors would pull at the estimates, and a model that is far off
    /// is judged by ratios, too high as harshly as too low.
    #[must_use]
    pub fn value(&self, value: f64) -> (f64, f64) {
        if self.relative_noise == 0.0 {
            return (value, 1.0);
        }
        let scale = self.noise / self.relative_noise;
        let x = value / scale;
        (scale * libm::asinh(x), 1.0 / libm::sqrt(1.0 + x * x))
    }
}

impl Section for Reflectance {
    fn describe(&mut self, v: &mut dyn Visitor) -> Result<()> {
        v.text("file", &mut self.file, None)?;
        v.text("material", &mut self.material, None)?;
        let relative = Range { min: 0.0, max: 10.0 };
        v.number("relative_noise", &mut self.relative_noise, relative, Some(Self::RELATIVE_NOISE))?;
        v.number("noise", &mut self.noise, Range { min: 1e-9, max: 1e6 }, Some(Self::NOISE))?;
        role(v, &mut self.role)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::{Capture, Target};

    const TOML: &str = "format = 1\nname = \"paint\"\n\
        [[material]]\nname = \"paint\"\nmodel = \"lambert\"\nbase_color = [0.5, 0.5, 0.5]\n\
        [[reflectance]]\nfile = \"s/a.csv\"\nmaterial = \"paint\"\n\
        [[reflectance]]\nfile = \"s/b.csv\"\nmaterial = \"paint\"\nrole = \"held-out\"\nrelative_noise = 0.25\n";

    #[test]
    fn a_capture_of_reflectance_alone_needs_no_camera_and_comes_back_from_its_text() {
        let capture = Capture::parse(TOML).unwrap();
        let expected = Reflectance { file: "s/a.csv".into(), material: "paint".into(), ..Reflectance::default() };
        assert_eq!(capture.reflectance[0], expected);
        let targets: Vec<_> = capture.targets().map(|t| (t.name(), t.role())).collect();
        assert_eq!(targets, [("a", Role::Fit), ("b", Role::HeldOut)]);
        assert_eq!(capture.target(1), Some(Target::Reflectance(&capture.reflectance[1])));
        assert_eq!(capture.target(2), None);
        assert_eq!(capture.numbers()["reflectance.b.relative_noise"].0, 0.25);
        let text = capture.to_toml().unwrap();
        assert!(!text.contains("camera") && !text.contains("noise = 0.001"), "{text}");
        assert_eq!(Capture::parse(&text).unwrap(), capture);
    }

    #[test]
    fn what_does_not_resolve_is_refused() {
        let refused = |from: &str, to: &str, expected: &str| {
            let error = Capture::parse(&TOML.replace(from, to)).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        };
        refused("material = \"paint\"\nrole", "material = \"pain\"\nrole", "reflectance.b.material: names \"pain\"");
        refused("s/b.csv", "t/a.csv", "reflectance.a: is a name given twice");
        refused("held-out", "kept", "role: is \"kept\"");
        refused("0.25", "-0.25", "relative_noise: is -0.25");
        refused("relative_noise", "relativ_noise", "did you mean `relative_noise`?");
        let free = format!("{TOML}[fit]\nparameters = [\"reflectance.a.noise\"]");
        assert!(Capture::parse(&free).unwrap_err().to_string().contains("no residual determines"));
        let none = &TOML[..TOML.find("[[reflectance]]").unwrap()];
        let none = format!("{none}[camera]\nwidth = 1\nheight = 1\nfx = 1\nfy = 1\ncx = 0\ncy = 0\n");
        assert!(Capture::parse(&none).unwrap_err().to_string().contains("[[reflectance]]"));
    }

    #[test]
    fn compared_values_have_the_stated_noise_everywhere() {
        let reflectance = Reflectance { relative_noise: 0.1, noise: 0.02, ..Reflectance::default() };
        for value in [-3.0, -0.1, 0.0, 1e-4, 0.2, 5.0, 600.0_f64] {
            let slope = reflectance.value(value).1;
            let deviation = (0.02 * 0.02 + 0.01 * value * value).sqrt();
            assert!((slope * deviation / 0.02 - 1.0).abs() < 1e-12, "{value}");
            let step = 1e-6 * value.abs().max(1.0);
            let difference = (reflectance.value(value + step).0 - reflectance.value(value - step).0) / (2.0 * step);
            assert!((difference / slope - 1.0).abs() < 1e-6, "{value}: {difference} {slope}");
        }
        // Twice too much and half too little are as bad.
        let [half, one, two] = [50.0, 100.0, 200.0].map(|v| reflectance.value(v).0);
        assert!(((two - one) / (one - half) - 1.0).abs() < 1e-4);
        let plain = Reflectance { relative_noise: 0.0, ..reflectance };
        assert_eq!(plain.value(0.7), (0.7, 1.0));
    }
}
