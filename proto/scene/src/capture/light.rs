//! Lights: what illuminates a capture.

use super::visit::{Range, Section, Visitor, colour, vector, vector_or};
use crate::Result;

/// The frame in which a light's position and direction are given.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Frame {
    /// Fixed in the world.
    #[default]
    World,
    /// Moves with the photo's camera (OpenCV axes).
    Camera,
}

/// A named light.
#[derive(Debug, Clone, PartialEq)]
pub struct Light {
    /// The name that photos and dotted parameter names use.
    pub name: String,
    /// Where its numbers are measured.
    pub frame: Frame,
    /// What shines.
    pub kind: LightKind,
    /// Where a point or a ball sends its light.
    pub lobe: Lobe,
}

/// The factor max(0, cos a)^exponent on a lamp's intensity, a being the angle between an axis and the way the light
/// leaves. At exponent 0 the factor is 1 everywhere, behind the lamp too.
#[derive(Debug, Clone, PartialEq)]
pub struct Lobe {
    /// 0: the same to all sides; 1: a flat lamp that is not focused.
    pub exponent: f64,
    /// In the light's frame; need not be of unit length.
    pub axis: [f64; 3],
}

impl Default for Lobe {
    fn default() -> Self {
        Self { exponent: 0.0, axis: AXIS }
    }
}

const AXIS: [f64; 3] = [0.0, 0.0, 1.0];

impl Lobe {
    const EXPONENT: Range = Range { min: 0.0, max: 1e6 };

    fn describe(&mut self, v: &mut dyn Visitor) -> Result<()> {
        v.number("lobe_exponent", &mut self.exponent, Self::EXPONENT, Some(0.0))?;
        vector_or(v, "lobe_axis", &mut self.axis, &AXIS)?;
        if self.axis.iter().map(|x| x * x).sum::<f64>() < 1e-24 {
            return Err(v.refuse("lobe_axis", "has no length".to_owned(), "write the way the lamp points"));
        }
        Ok(())
    }
}

/// The kinds of light of the capture format.
#[derive(Debug, Clone, PartialEq)]
pub enum LightKind {
    /// A point: irradiance intensity / r^2 on a plane that faces it at distance r.
    Point {
        /// Metres.
        position: [f64; 3],
        /// Power per solid angle, linear RGB.
        intensity: [f64; 3],
    },
    /// A Lambertian ball of radiance intensity / (pi radius^2).
    Sphere {
        /// Centre, metres.
        position: [f64; 3],
        /// Metres; at 0 it acts as a point.
        radius: f64,
        /// Power per solid angle far away, linear RGB.
        intensity: [f64; 3],
    },
    /// Parallel light.
    Directional {
        /// The way the light travels; need not be of unit length.
        direction: [f64; 3],
        /// On a plane that faces it, linear RGB.
        irradiance: [f64; 3],
    },
    /// An equirectangular map around everything.
    Map {
        /// The image's path.
        map: String,
        /// Factor on the map's values.
        scale: f64,
        /// Radians by which the map is turned about the z axis of its frame, from x towards y.
        azimuth: f64,
    },
    /// The same radiance from every direction.
    Constant {
        /// Linear RGB.
        radiance: [f64; 3],
    },
}

impl LightKind {
    /// The word that `kind = "..."` uses.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::Point { .. } => "point",
            Self::Sphere { .. } => "sphere",
            Self::Directional { .. } => "directional",
            Self::Map { .. } | Self::Constant { .. } => "environment",
        }
    }

    fn blank(word: &str) -> Option<Self> {
        let (position, one) = ([0.0; 3], [1.0; 3]);
        match word {
            "point" => Some(Self::Point { position, intensity: one }),
            "sphere" => Some(Self::Sphere { position, radius: 1.0, intensity: one }),
            "directional" => Some(Self::Directional { direction: [0.0, 0.0, -1.0], irradiance: one }),
            "environment" => Some(Self::Map { map: String::new(), scale: 1.0, azimuth: 0.0 }),
            _ => None,
        }
    }
}

impl Default for Light {
    fn default() -> Self {
        Self {
            name: String::new(),
            frame: Frame::World,
            kind: LightKind::Point { position: [0.0; 3], intensity: [1.0; 3] },
            lobe: Lobe::default(),
        }
    }
}

impl Section for Light {
    fn describe(&mut self, v: &mut dyn Visitor) -> Result<()> {
        v.text("name", &mut self.name, None)?;
        let mut word = self.kind.word().to_owned();
        v.text("kind", &mut word, None)?;
        if word != self.kind.word() {
            self.kind = LightKind::blank(&word).ok_or_else(|| {
                v.refuse("kind", format!("is \"{word}\""), "write one of: point, sphere, directional, environment")
            })?;
        }
        let mut frame = if self.frame == Frame::Camera { "camera" } else { "world" }.to_owned();
        v.text("frame", &mut frame, Some("world"))?;
        self.frame = match frame.as_str() {
            "world" => Frame::World,
            "camera" => Frame::Camera,
            _ => return Err(v.refuse("frame", format!("is \"{frame}\""), "write \"world\" or \"camera\"")),
        };
        match &mut self.kind {
            LightKind::Point { position, intensity } => {
                vector(v, "position", position)?;
                colour(v, "intensity", intensity, Range::NON_NEGATIVE, None)?;
                self.lobe.describe(v)
            }
            LightKind::Sphere { position, radius, intensity } => {
                vector(v, "position", position)?;
                v.number("radius", radius, Range::NON_NEGATIVE, None)?;
                colour(v, "intensity", intensity, Range::NON_NEGATIVE, None)?;
                self.lobe.describe(v)
            }
            LightKind::Directional { direction, irradiance } => {
                vector(v, "direction", direction)?;
                if direction.iter().map(|x| x * x).sum::<f64>() < 1e-24 {
                    return Err(v.refuse("direction", "has no length".to_owned(), "write the way the light travels"));
                }
                colour(v, "irradiance", irradiance, Range::NON_NEGATIVE, None)
            }
            LightKind::Map { .. } | LightKind::Constant { .. } => self.describe_environment(v),
        }
    }
}

impl Light {
    /// Whether it is a lamp (or parallel light) of intensity 0.
    #[must_use]
    pub fn is_dark(&self) -> bool {
        match &self.kind {
            LightKind::Point { intensity: light, .. }
            | LightKind::Sphere { intensity: light, .. }
            | LightKind::Directional { irradiance: light, .. } => *light == [0.0; 3],
            LightKind::Map { .. } | LightKind::Constant { .. } => false,
        }
    }

    fn describe_environment(&mut self, v: &mut dyn Visitor) -> Result<()> {
        let (mut map, mut radiance) = match &self.kind {
            LightKind::Map { map, .. } => (Some(map.clone()).filter(|m| !m.is_empty()), None),
            LightKind::Constant { radiance } => (None, Some(radiance.to_vec())),
            _ => (None, None),
        };
        v.optional_text("map", &mut map)?;
        v.optional_numbers("radiance", &mut radiance, &super::visit::RGB, Range::NON_NEGATIVE)?;
        match (map, radiance.as_deref()) {
            (Some(map), None) => {
                let (mut scale, mut azimuth) =
                    if let LightKind::Map { scale, azimuth, .. } = self.kind { (scale, azimuth) } else { (1.0, 0.0) };
                v.number("scale", &mut scale, Range::NON_NEGATIVE, Some(1.0))?;
                v.number("azimuth", &mut azimuth, Range::ANY, Some(0.0))?;
                self.kind = LightKind::Map { map, scale, azimuth };
                Ok(())
            }
            (None, Some(&[r, g, b])) => {
                self.kind = LightKind::Constant { radiance: [r, g, b] };
                Ok(())
            }
            _ => Err(v.refuse(
                "map",
                "an environment light needs either `map` or `radiance`".to_owned(),
                "write one of the two keys",
            )),
        }
    }
}
