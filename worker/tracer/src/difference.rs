//! Derivatives by finite differences: the same paths through one or two scenes beside the one in the middle.

use crate::scene::{Loaded, Scene, Variant};
use gonio_scene::capture::{CAPTURE_FILE, Range};
use gonio_scene::parameter::Term;
use gonio_scene::{Capture, Result, SceneError};
use std::collections::BTreeMap;

/// A derivative plane that is a difference of renders.
pub(crate) struct Difference {
    /// Index of the plane.
    pub(crate) plane: usize,
    /// The scene after a step up; the one in the middle where that leaves a number's range.
    pub(crate) above: Option<Box<Variant>>,
    /// As `above`, after a step down.
    pub(crate) below: Option<Box<Variant>>,
    /// 1 / the distance between the two.
    pub(crate) scale: f32,
}

/// The scene in the middle, which differences start from.
pub(crate) struct Middle<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) capture: &'a Capture,
    /// The capture's numbers with their bounds.
    pub(crate) numbers: BTreeMap<String, (f64, Range)>,
    pub(crate) loaded: &'a Loaded,
}

impl Middle<'_> {
    /// The difference of plane `plane` for a move of `step` along `terms`.
    ///
    /// # Errors
    /// An unknown number; bounds so narrow that the step leaves them to both sides; what a moved scene refuses.
    pub(crate) fn difference(&self, plane: usize, terms: &[Term], step: f64) -> Result<Difference> {
        let (above, below) = (self.moved(terms, step)?, self.moved(terms, -step)?);
        let steps = match (&above, &below) {
            (Some(_), Some(_)) => 2.0,
            (None, None) => {
                let first = terms.first().map_or("", |term| term.number.as_str());
                return Err(SceneError::new(
                    CAPTURE_FILE,
                    format!("has no room for a difference of {step} to either side"),
                    "ask for a smaller step",
                )
                .at(first));
            }
            _ => 1.0,
        };
        Ok(Difference { plane, above, below, scale: (1.0 / (steps * step)) as f32 })
    }

    /// The scene after a move; `None` where a number would leave its range.
    fn moved(&self, terms: &[Term], by: f64) -> Result<Option<Box<Variant>>> {
        let mut values = Vec::with_capacity(terms.len());
        for term in terms {
            let (value, range) = self.numbers.get(&term.number).copied().ok_or_else(|| {
                SceneError::new(CAPTURE_FILE, "is no number of this capture", "name another").at(term.number.as_str())
            })?;
            let target = value + term.ratio * by;
            if !range.holds(target) {
                return Ok(None);
            }
            values.push((term.number.clone(), target));
        }
        let mut capture = self.capture.clone();
        capture.set_numbers(&values)?;
        self.scene.vary(self.capture, &capture, self.loaded).map(|variant| Some(Box::new(variant)))
    }
}

impl Difference {
    /// Whether it can be other than zero in a photo.
    pub(crate) fn matters(&self, photo: usize) -> bool {
        let differs =
            |v: &Option<Box<Variant>>| v.as_ref().is_some_and(|v| v.differs.get(photo).copied().unwrap_or_default());
        differs(&self.above) || differs(&self.below)
    }
}
