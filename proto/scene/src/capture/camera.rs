//! The pinhole camera with Brown-Conrady distortion, in OpenCV's conventions.

use super::visit::{DISTORTION, Numbers, Range, Section, Visitor};
use crate::Result;

/// Intrinsics, in pixels. Camera axes: x right, y down, z forward.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// Width of a photo in pixels.
    pub width: u32,
    /// Height of a photo in pixels.
    pub height: u32,
    /// Focal length along x, pixels.
    pub fx: f64,
    /// Focal length along y, pixels.
    pub fy: f64,
    /// Principal point, pixels from the image's left edge.
    pub cx: f64,
    /// Principal point, pixels from the image's top edge.
    pub cy: f64,
    /// Brown-Conrady coefficients k1 k2 p1 p2 k3.
    pub distortion: [f64; 5],
    /// Radius of a thin lens, metres; 0 is a pinhole.
    pub aperture_radius: f64,
    /// Depth along z at which a thin lens is sharp, metres.
    pub focus_distance: f64,
    /// Share of a pixel's light that comes from around it instead, 0..=1.
    pub glare_fraction: f64,
    /// Standard deviation, along x and along y, of where that share comes from, pixels.
    pub glare_width: f64,
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            width: 1,
            height: 1,
            fx: 1.0,
            fy: 1.0,
            cx: 0.5,
            cy: 0.5,
            distortion: [0.0; 5],
            aperture_radius: 0.0,
            focus_distance: 1.0,
            glare_fraction: 0.0,
            glare_width: 20.0,
        }
    }
}

impl Section for Camera {
    fn describe(&mut self, v: &mut dyn Visitor) -> Result<()> {
        v.size("width", &mut self.width)?;
        v.size("height", &mut self.height)?;
        v.number("fx", &mut self.fx, Range::POSITIVE, None)?;
        v.number("fy", &mut self.fy, Range::POSITIVE, None)?;
        v.number("cx", &mut self.cx, Range::ANY, None)?;
        v.number("cy", &mut self.cy, Range::ANY, None)?;
        v.numbers(
            "distortion",
            Numbers {
                values: &mut self.distortion,
                suffixes: &DISTORTION,
                range: Range::ANY,
                default: Some(&[0.0; 5]),
                may_end_early: false,
            },
        )?;
        v.number("aperture_radius", &mut self.aperture_radius, Range::NON_NEGATIVE, Some(0.0))?;
        v.number("focus_distance", &mut self.focus_distance, Range::POSITIVE, Some(1.0))?;
        v.number("glare_fraction", &mut self.glare_fraction, Range::UNIT, Some(0.0))?;
        v.number("glare_width", &mut self.glare_width, Range::POSITIVE, Some(20.0))
    }
}

/// The keys of `[camera]` that one photo has otherwise.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CameraOverride {
    /// See [`Camera::width`].
    pub width: Option<u32>,
    /// See [`Camera::height`].
    pub height: Option<u32>,
    /// See [`Camera::fx`].
    pub fx: Option<f64>,
    /// See [`Camera::fy`].
    pub fy: Option<f64>,
    /// See [`Camera::cx`].
    pub cx: Option<f64>,
    /// See [`Camera::cy`].
    pub cy: Option<f64>,
    /// See [`Camera::distortion`].
    pub distortion: Option<Vec<f64>>,
    /// See [`Camera::aperture_radius`].
    pub aperture_radius: Option<f64>,
    /// See [`Camera::focus_distance`].
    pub focus_distance: Option<f64>,
    /// See [`Camera::glare_fraction`].
    pub glare_fraction: Option<f64>,
    /// See [`Camera::glare_width`].
    pub glare_width: Option<f64>,
}

impl CameraOverride {
    /// `base` with this override's keys in place of its own.
    #[must_use]
    pub fn over(&self, base: &Camera) -> Camera {
        let mut distortion = base.distortion;
        if let Some(own) = &self.distortion {
            for (d, o) in distortion.iter_mut().zip(own) {
                *d = *o;
            }
        }
        Camera {
            width: self.width.unwrap_or(base.width),
            height: self.height.unwrap_or(base.height),
            fx: self.fx.unwrap_or(base.fx),
            fy: self.fy.unwrap_or(base.fy),
            cx: self.cx.unwrap_or(base.cx),
            cy: self.cy.unwrap_or(base.cy),
            distortion,
            aperture_radius: self.aperture_radius.unwrap_or(base.aperture_radius),
            focus_distance: self.focus_distance.unwrap_or(base.focus_distance),
            glare_fraction: self.glare_fraction.unwrap_or(base.glare_fraction),
            glare_width: self.glare_width.unwrap_or(base.glare_width),
        }
    }
}

impl Section for CameraOverride {
    fn describe(&mut self, v: &mut dyn Visitor) -> Result<()> {
        v.optional_size("width", &mut self.width)?;
        v.optional_size("height", &mut self.height)?;
        v.optional_number("fx", &mut self.fx, Range::POSITIVE)?;
        v.optional_number("fy", &mut self.fy, Range::POSITIVE)?;
        v.optional_number("cx", &mut self.cx, Range::ANY)?;
        v.optional_number("cy", &mut self.cy, Range::ANY)?;
        v.optional_numbers("distortion", &mut self.distortion, &DISTORTION, Range::ANY)?;
        v.optional_number("aperture_radius", &mut self.aperture_radius, Range::NON_NEGATIVE)?;
        v.optional_number("focus_distance", &mut self.focus_distance, Range::POSITIVE)?;
        v.optional_number("glare_fraction", &mut self.glare_fraction, Range::UNIT)?;
        v.optional_number("glare_width", &mut self.glare_width, Range::POSITIVE)
    }

    fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}
