//! From a file's value to light.

use std::str::FromStr;

/// How a file's value follows from light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Curve {
    /// The value is the light.
    Linear,
    /// The sRGB transfer function (IEC 61966-2-1).
    Srgb,
    /// The value to this power is the light, such as 2.2.
    Gamma(f64),
}

impl Curve {
    /// The light of a file's value.
    #[must_use]
    pub fn light(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Srgb if value <= 0.040_45 => value / 12.92,
            Self::Srgb => libm::pow((value + 0.055) / 1.055, 2.4),
            Self::Gamma(exponent) => libm::pow(value.max(0.0), exponent),
        }
    }

    /// Light per value, there.
    #[must_use]
    pub fn slope(self, value: f64) -> f64 {
        match self {
            Self::Linear => 1.0,
            Self::Srgb if value <= 0.040_45 => 1.0 / 12.92,
            Self::Srgb => 2.4 / 1.055 * libm::pow((value + 0.055) / 1.055, 1.4),
            Self::Gamma(exponent) => exponent * libm::pow(value.max(1e-6), exponent - 1.0),
        }
    }

    /// The lines of a capture's `[sensor]` that say so; empty for linear values, which are the default.
    #[must_use]
    pub fn keys(self) -> String {
        match self {
            Self::Linear => String::new(),
            Self::Srgb => "response = \"srgb\"\n".to_owned(),
            Self::Gamma(exponent) => format!("gamma = {:.5}\n", 1.0 / exponent),
        }
    }
}

impl FromStr for Curve {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "linear" => Ok(Self::Linear),
            "srgb" => Ok(Self::Srgb),
            _ => {
                let number = text.strip_prefix("gamma:").and_then(|number| number.parse::<f64>().ok());
                let exponent = number.filter(|exponent| (0.2..=5.0).contains(exponent));
                exponent.map(Self::Gamma).ok_or_else(|| {
                    "write linear, srgb, or gamma:EXPONENT with an exponent of 0.2 to 5, such as gamma:2.2".to_owned()
                })
            }
        }
    }
}

impl std::fmt::Display for Curve {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Linear => f.write_str("linear"),
            Self::Srgb => f.write_str("srgb"),
            Self::Gamma(exponent) => write!(f, "gamma:{exponent}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_undoes_the_format_s_srgb_and_slopes_are_its_differences() {
        for light in [0.0005, 0.01, 0.2, 0.9] {
            let (value, slope) = gonio_scene::capture::Response::Srgb.apply(0, light);
            assert!((Curve::Srgb.light(value) - light).abs() < 1e-6, "{light}");
            assert!((Curve::Srgb.slope(value) * slope - 1.0).abs() < 1e-3, "{light}");
        }
        for curve in [Curve::Linear, Curve::Srgb, Curve::Gamma(2.2)] {
            let difference = (curve.light(0.3001) - curve.light(0.2999)) / 0.0002;
            assert!((difference - curve.slope(0.3)).abs() < 1e-4, "{curve}");
            assert_eq!(curve.to_string().parse(), Ok(curve));
        }
        assert!("gamma:0".parse::<Curve>().is_err() && "log".parse::<Curve>().is_err());
    }
}
