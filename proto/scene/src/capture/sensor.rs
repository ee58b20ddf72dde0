//! The sensor: noise, saturation, and how a photo value was made from exposed light; [`crate::SensorStage`] makes it.

use super::curve::ResponseCurve;
use super::visit::{CROSSTALK, Numbers, Range, Section, VIGNETTING, Visitor};
use crate::Result;
use std::sync::Arc;

/// How a file's value follows from exposed light.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Response {
    /// The value is the light.
    #[default]
    Linear,
    /// The sRGB transfer function (IEC 61966-2-1), as cameras write JPEG and PNG.
    Srgb,
    /// A measured curve, another in every channel.
    Curve(Arc<ResponseCurve>),
}

/// What lies between the lens and the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// Standard deviation of a photo value without light.
    pub read_noise: f64,
    /// Variance of a photo value per value.
    pub shot_noise: f64,
    /// At and above this value a pixel is clipped.
    pub saturation: Option<f64>,
    /// How a file's value follows from exposed light.
    pub response: Response,
    /// k1 and k2: the light that arrives is 1 + k1 r^2 + k2 r^4 of the exposed light, with r the distance from the
    /// principal point in half image diagonals.
    pub vignetting: [f64; 2],
    /// Shares of another channel's light that are added to a channel's own: red of green, red of blue, green of red,
    /// green of blue, blue of red, blue of green.
    pub crosstalk: [f64; 6],
    /// Added to every photo value, whatever the exposure.
    pub black_level: f64,
    /// Exponent of the value that the response gives; 1 leaves it.
    pub gamma: f64,
    /// No photo value is larger; at [`Sensor::NO_CLIP`], its upper bound, there is no limit.
    pub clip_level: f64,
}

impl Default for Sensor {
    fn default() -> Self {
        Self {
            read_noise: Self::DEFAULT_READ_NOISE,
            shot_noise: 0.0,
            saturation: None,
            response: Response::Linear,
            vignetting: [0.0; 2],
            crosstalk: [0.0; 6],
            black_level: 0.0,
            gamma: 1.0,
            clip_level: Self::NO_CLIP,
        }
    }
}

impl Sensor {
    /// The read noise of a capture that states none: 1 % of a value of one, about that of an 8-bit file.
    pub const DEFAULT_READ_NOISE: f64 = 0.01;

    /// The clip level that clips nothing, not even what is brighter.
    pub const NO_CLIP: f64 = 1e6;

    /// The numbers that say how sure a value is, not what it is: no residual determines them.
    pub const NOISE: [&str; 3] = ["sensor.read_noise", "sensor.shot_noise", "sensor.saturation"];

    /// Variance of a photo whose noiseless value is `value`: `read_noise^2 + shot_noise * value`.
    #[must_use]
    pub fn variance(&self, value: f64) -> f64 {
        self.read_noise * self.read_noise + self.shot_noise * value.max(0.0)
    }

    /// Whether a photo's value is clipped.
    #[must_use]
    pub fn is_clipped(&self, value: f64) -> bool {
        self.saturation.is_some_and(|level| value >= level)
    }
}

impl Response {
    /// The file's value for exposed light `x` in a channel (0 red, 1 green, 2 blue), and its slope there.
    #[must_use]
    pub fn apply(&self, channel: usize, x: f64) -> (f64, f64) {
        match self {
            Self::Linear => (x, 1.0),
            Self::Srgb => srgb(x),
            Self::Curve(curve) => curve.apply(channel, x),
        }
    }

    /// Whether values are light: what is to be looked at still needs a curve.
    #[must_use]
    pub fn is_linear(&self) -> bool {
        *self == Self::Linear
    }

    fn describe(&mut self, v: &mut dyn Visitor) -> Result<()> {
        let word = match self {
            Self::Linear => "linear",
            Self::Srgb => "srgb",
            Self::Curve(_) => "curve",
        };
        let mut word = word.to_owned();
        v.text("response", &mut word, Some("linear"))?;
        *self = match word.as_str() {
            "linear" => Self::Linear,
            "srgb" => Self::Srgb,
            "curve" => {
                let mut curve =
                    if let Self::Curve(curve) = self { (**curve).clone() } else { ResponseCurve::default() };
                v.section("curve", &mut curve)?;
                Self::Curve(Arc::new(curve))
            }
            _ => {
                let mend = "write \"linear\", \"srgb\", or the path of a .json file beside capture.toml that `gonio hdr` wrote";
                return Err(v.refuse("response", format!("is \"{word}\""), mend));
            }
        };
        Ok(())
    }
}

/// The sRGB transfer function (IEC 61966-2-1) and its slope.
#[must_use]
pub fn srgb(x: f64) -> (f64, f64) {
    if x <= 0.003_130_8 {
        return (12.92 * x, 12.92);
    }
    let root = libm::pow(x, 1.0 / 2.4);
    (1.055 * root - 0.055, 1.055 / 2.4 * root / x)
}

impl Section for Sensor {
    fn describe(&mut self, v: &mut dyn Visitor) -> Result<()> {
        let noise = Range { min: 0.0, max: 1e6 };
        v.number("read_noise", &mut self.read_noise, noise, Some(Self::DEFAULT_READ_NOISE))?;
        v.number("shot_noise", &mut self.shot_noise, noise, Some(0.0))?;
        if self.read_noise == 0.0 && self.shot_noise == 0.0 {
            return Err(v.refuse(
                "read_noise",
                "and shot_noise are both 0, so no pixel has a variance".to_owned(),
                "write the standard deviation of a photo value without light",
            ));
        }
        v.optional_number("saturation", &mut self.saturation, Range::POSITIVE)?;
        self.response.describe(v)?;
        list(v, "vignetting", &mut self.vignetting, &VIGNETTING)?;
        list(v, "crosstalk", &mut self.crosstalk, &CROSSTALK)?;
        v.number("black_level", &mut self.black_level, Range::ANY, Some(0.0))?;
        v.number("gamma", &mut self.gamma, Range { min: 0.1, max: 10.0 }, Some(1.0))?;
        let clip = Range { max: Self::NO_CLIP, ..Range::POSITIVE };
        v.number("clip_level", &mut self.clip_level, clip, Some(Self::NO_CLIP))
    }

    fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// Numbers of any size that are zero where the key is absent.
fn list(v: &mut dyn Visitor, key: &str, values: &mut [f64], suffixes: &[&str]) -> Result<()> {
    let zeros = vec![0.0; values.len()];
    v.numbers(key, Numbers { values, suffixes, range: Range::ANY, default: Some(&zeros), may_end_early: false })
}
