//! Which derivative images an evaluation needs, and how a parameter's column is put together from them.
//!
//! Worker and coordinator derive the same [`Plan`] from the capture and the columns, so a task's result carries no
//! description of itself. Three sources, cheapest first:
//!
//! - sensor: the column follows from the film alone (`photo.03.gain`, `sensor.gamma`); it needs no image;
//! - forward: carried along every path (materials, light intensities); a colour's three channels share one RGB image,
//!   because a path's red radiance depends on no other channel's parameter;
//! - difference: one or two more renders with the same random numbers (geometry), also wherever a column gives its step.

mod sensor;

use crate::capture::{Capture, LONGEST_SCATTER, Sensor};
use crate::parameter::{Parameter, Term};
use crate::{Result, SceneError};

/// One derivative image, RGB per pixel.
#[derive(Debug, Clone, PartialEq)]
pub enum Plane {
    /// Channel c holds d radiance_c / d `prefix`.c.
    Colour {
        /// Dotted name of the colour.
        prefix: String,
    },
    /// d radiance / d `number`.
    Scalar {
        /// Dotted name of the number.
        number: String,
    },
    /// A finite difference along a parameter, with the same random numbers: (radiance(+step) - radiance(-step)) / (2 step)
    /// where both lie in the numbers' ranges; else one-sided into the range, against the radiance itself.
    Difference {
        /// The numbers that move, and how far for a parameter's move by one.
        terms: Vec<Term>,
        /// The move of the parameter to either side, in its unit.
        step: f64,
    },
}

/// What adds to a parameter's column.
#[derive(Debug, Clone, PartialEq)]
pub enum Contribution {
    /// `factor` times a plane, in all channels or in one.
    Plane {
        /// Index into [`Plan::planes`].
        plane: usize,
        /// The only channel it adds to, where the plane is a colour's.
        channel: Option<usize>,
        /// d number / d parameter.
        factor: f64,
    },
    /// `factor` times d value / d gain (or exposure, or balance) of one photo.
    Factor {
        /// Index of the photo.
        photo: usize,
        /// The only channel whose light it moves, where it is a balance.
        channel: Option<usize>,
        /// d (exposure * gain) / d parameter.
        factor: f64,
    },
    /// The difference of the sensor stage between two sensors, pixel by pixel; alone in its column.
    Sensor {
        /// The sensor with the smaller parameter.
        from: Box<Sensor>,
        /// The sensor with the larger parameter.
        to: Box<Sensor>,
        /// The parameter's distance between them.
        distance: f64,
    },
}

impl Contribution {
    /// The part of it that lies in one channel.
    ///
    /// # Errors
    /// A contribution of another channel alone, or of the film's, which has no channels of its own.
    fn in_channel(self, wanted: usize, parameter: &Parameter) -> Result<Self> {
        match self {
            Self::Plane { plane, channel, factor } if channel.is_none_or(|c| c == wanted) => {
                Ok(Self::Plane { plane, channel: Some(wanted), factor })
            }
            _ => Err(SceneError::new(
                "request",
                format!("has no part in channel {wanted} alone"),
                "ask for all channels",
            )
            .at(parameter.name.as_str())),
        }
    }
}

/// The derivative images of an evaluation and the recipe of every column.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Plan {
    /// Images to render, after the radiance itself.
    pub planes: Vec<Plane>,
    /// Per parameter, what adds up to its column.
    pub columns: Vec<Vec<Contribution>>,
}

enum Source {
    Colour { prefix: String, channel: usize },
    Scalar,
    Difference,
    Photo { index: usize, channel: Option<usize>, rate: f64 },
    Sensor,
}

impl Source {
    /// The source where a difference is asked for: the film alone knows of no step.
    fn by_difference(self) -> Self {
        match self {
            Self::Colour { .. } | Self::Scalar | Self::Difference => Self::Difference,
            film => film,
        }
    }
}

impl Plan {
    /// The plan for `columns` of a capture.
    ///
    /// # Errors
    /// A number that has no derivative (the sensor's noise), a parameter that moves the sensor or a photo's gain
    /// together with what needs an image.
    pub fn new(capture: &Capture, columns: &[Parameter]) -> Result<Self> {
        let mut plan = Self::default();
        let scale = Scale::new(capture);
        for parameter in columns {
            let found = parameter.terms.iter().map(|t| source(capture, &t.number));
            let usual = found.collect::<Result<Vec<_>>>()?.into_iter();
            let sources: Vec<_> = usual.map(|s| if parameter.step.is_some() { s.by_difference() } else { s }).collect();
            let column = if sources.iter().any(|s| matches!(s, Source::Sensor)) {
                if !sources.iter().all(|s| matches!(s, Source::Sensor)) {
                    return Err(SceneError::new("request", "moves the sensor and the scene together", "separate them")
                        .at(parameter.name.as_str()));
                }
                vec![sensor::difference(capture, parameter)?]
            } else if sources.iter().any(|s| matches!(s, Source::Difference)) {
                if sources.iter().any(|s| matches!(s, Source::Photo { .. })) {
                    return Err(SceneError::new(
                        "request",
                        "moves geometry and a photo's gain together",
                        "separate them",
                    )
                    .at(parameter.name.as_str()));
                }
                let plane = plan.plane(Plane::Difference {
                    terms: parameter.terms.clone(),
                    step: parameter.step.unwrap_or_else(|| scale.step(parameter)),
                });
                vec![Contribution::Plane { plane, channel: None, factor: 1.0 }]
            } else {
                parameter.terms.iter().zip(sources).map(|(t, s)| plan.contribution(t, s)).collect()
            };
            plan.columns.push(match parameter.channel {
                Some(channel) => column.into_iter().map(|c| c.in_channel(channel, parameter)).collect::<Result<_>>()?,
                None => column,
            });
        }
        Ok(plan)
    }

    fn contribution(&mut self, term: &Term, source: Source) -> Contribution {
        match source {
            Source::Colour { prefix, channel } => Contribution::Plane {
                plane: self.plane(Plane::Colour { prefix }),
                channel: Some(channel),
                factor: term.ratio,
            },
            Source::Photo { index, channel, rate } => {
                Contribution::Factor { photo: index, channel, factor: term.ratio * rate }
            }
            Source::Scalar | Source::Difference | Source::Sensor => Contribution::Plane {
                plane: self.plane(Plane::Scalar { number: term.number.clone() }),
                channel: None,
                factor: term.ratio,
            },
        }
    }

    /// Index of a plane, added where it is new.
    fn plane(&mut self, plane: Plane) -> usize {
        self.planes.iter().position(|p| *p == plane).unwrap_or_else(|| {
            self.planes.push(plane);
            self.planes.len() - 1
        })
    }
}

/// How the radiance's dependence on a number is found, by the number's name.
fn source(capture: &Capture, number: &str) -> Result<Source> {
    if number.starts_with("sensor.") && !Sensor::NOISE.contains(&number) {
        return Ok(Source::Sensor);
    }
    let (owner, key) = match split(capture, number) {
        Some(found) => found,
        None => {
            return Err(SceneError::new("request", "is no number that radiance depends on", "free another").at(number));
        }
    };
    let (base, channel) = match key.rsplit_once('.') {
        Some((base, suffix)) => (base, crate::capture::visit::RGB.iter().position(|c| *c == suffix)),
        None => (key, None),
    };
    Ok(match (owner, base, channel) {
        // Where light enters moves with it.
        (Owner::Material, "scatter_distance", None) => Source::Difference,
        (Owner::Material, _, Some(channel))
        | (Owner::Light, "intensity" | "irradiance" | "radiance", Some(channel)) => {
            Source::Colour { prefix: number[..number.len() - 2].to_owned(), channel }
        }
        (Owner::Material, ..) | (Owner::Light, "scale", None) => Source::Scalar,
        (Owner::Photo(index), "gain", None) => {
            Source::Photo { index, channel: None, rate: capture.photos[index].exposure }
        }
        (Owner::Photo(index), "exposure", None) => {
            Source::Photo { index, channel: None, rate: capture.photos[index].gain }
        }
        (Owner::Photo(index), "balance", Some(channel)) => {
            let photo = &capture.photos[index];
            Source::Photo { index, channel: Some(channel), rate: photo.factor() / photo.balance[channel] }
        }
        _ => Source::Difference,
    })
}

enum Owner {
    Camera,
    Tracing,
    Material,
    Object,
    Light,
    Photo(usize),
}

/// A number's owner and the rest of its name. Names of owners may hold dots, so known names are compared whole.
fn split<'n>(capture: &Capture, number: &'n str) -> Option<(Owner, &'n str)> {
    let (section, rest) = number.split_once('.')?;
    let strip = |name: &str| rest.strip_prefix(name).and_then(|r| r.strip_prefix('.'));
    match section {
        "camera" => Some((Owner::Camera, rest)),
        "tracing" => Some((Owner::Tracing, rest)),
        "material" => capture.materials.iter().find_map(|m| strip(&m.name)).map(|k| (Owner::Material, k)),
        "object" => capture.objects.iter().find_map(|o| strip(&o.name)).map(|k| (Owner::Object, k)),
        "light" => capture.lights.iter().find_map(|l| strip(&l.name)).map(|k| (Owner::Light, k)),
        "photo" => capture.photos.iter().enumerate().find_map(|(i, p)| strip(p.name()).map(|k| (Owner::Photo(i), k))),
        _ => None,
    }
}

/// What a pixel is in the scene, which finite differences of geometry are measured by.
///
/// The derivative of an image's edges lives in the samples that a step carries across them: with a step much below a pixel
/// hardly any sample does, and its estimate is all noise; much above, the image is no longer linear over it.
struct Scale {
    /// Width of a pixel at the objects' mean distance from the cameras, in metres.
    pixel: f64,
    /// Focal length in pixels.
    focal: f64,
    /// Tangent of the angle between the axis and the image's corner.
    corner: f64,
}

/// A step's displacement in the image, in pixels.
const DISPLACEMENT: f64 = 0.4;
/// An object's size in pixels, by which turning it is measured.
const OBJECT: f64 = 50.0;

impl Scale {
    fn new(capture: &Capture) -> Self {
        let (mut sum, mut count) = (0.0, 0.0);
        for photo in &capture.photos {
            for object in &capture.objects {
                let eye = photo.pose();
                let apart = |i: usize| eye[i][3] - object.object_to_world[i][3];
                sum += (apart(0).powi(2) + apart(1).powi(2) + apart(2).powi(2)).sqrt();
                count += 1.0;
            }
        }
        let camera = &capture.camera;
        let focal = 0.5 * (camera.fx + camera.fy);
        let distance = if count > 0.0 && sum > 0.0 { sum / count } else { 1.0 };
        let (width, height) = (f64::from(camera.width), f64::from(camera.height));
        Self { pixel: distance / focal, focal, corner: 0.5 * (width * width + height * height).sqrt() / focal }
    }

    fn step(&self, parameter: &Parameter) -> f64 {
        let name = parameter.name.as_str();
        let last = name.rsplit('.').next().unwrap_or(name);
        let second = name.rsplit('.').nth(1).unwrap_or("");
        let span = parameter.terms.iter().map(|t| t.ratio.abs()).fold(0.0, f64::max).max(1e-12);
        let shift = DISPLACEMENT * self.pixel;
        let own = match (second, last) {
            (_, "fx" | "fy") => DISPLACEMENT * 0.01 * parameter.value.abs(),
            (_, "cx" | "cy") => DISPLACEMENT,
            (_, "radius") if parameter.value == 0.0 => 5.0 * shift,
            (_, "radius") => 0.05 * parameter.value.abs(),
            // Light spreads about twice as far as its mean free path.
            (_, "scatter_distance") => {
                let least = self.pixel * if parameter.value == 0.0 { 1.0 } else { 0.2 };
                (0.1 * parameter.value.abs()).max(least).min(0.4 * LONGEST_SCATTER)
            }
            (_, "lobe_exponent") => 0.1 + 0.05 * parameter.value.abs(),
            ("lobe_axis", _) => 5e-3,
            ("scale", _) => 0.02 * parameter.value.abs(),
            ("translation", _) => shift,
            ("rotation", _) => DISPLACEMENT / OBJECT,
            // Radiance is linear in these two: as far as their range goes.
            (_, "presence") => parameter.value.max(1.0 - parameter.value),
            (_, "ray_offset") => parameter.value.max(5e-5),
            (_, "glare_fraction") => 0.25,
            (_, "glare_width") => 0.1 * parameter.value.abs(),
            (_, "aperture_radius") => 2e-3,
            (_, "focus_distance") => 0.02 * parameter.value.abs(),
            // A shadow moves less than the light that casts it.
            ("position", _) => 3.0 * shift,
            ("direction", _) | (_, "azimuth") => 2e-2,
            ("distortion", _) => {
                let power = match last {
                    "k1" => 3,
                    "k2" => 5,
                    "k3" => 7,
                    _ => 2,
                };
                DISPLACEMENT / (self.focal * self.corner.powi(power))
            }
            // A matrix entry: column 3 is a translation in metres, the others turn.
            ("0" | "1" | "2", "3") => shift,
            ("0" | "1" | "2", "0" | "1" | "2") => DISPLACEMENT / OBJECT,
            _ => 1e-3,
        };
        own / span
    }
}
