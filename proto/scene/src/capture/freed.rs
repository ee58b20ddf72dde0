//! The `[fit]` section: which numbers a fit frees.

use super::visit::{Section, Visitor};
use crate::Result;

/// What to estimate, by dotted name.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Freed {
    /// Names of numbers, or of colours (then all three channels).
    pub parameters: Vec<String>,
    /// The colours among them that keep their ratio and vary by one common factor.
    pub gray: Vec<String>,
}

impl Section for Freed {
    fn describe(&mut self, v: &mut dyn Visitor) -> Result<()> {
        v.texts("parameters", &mut self.parameters)?;
        v.texts("gray", &mut self.gray)
    }

    fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}
