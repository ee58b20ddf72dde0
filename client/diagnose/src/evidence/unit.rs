//! What is predicted from the others: a photo, or a file of measured reflectance.

use serde::{Deserialize, Serialize};

/// Which kind of measurement a unit is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum UnitKind {
    /// A photo.
    Photo,
    /// A file of measured reflectance.
    File,
}

/// A photo or a file that is fitted to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Unit {
    /// Its name in the capture.
    pub name: String,
    /// Which kind it is.
    pub kind: UnitKind,
    /// Channels of pixels, or of samples, that count.
    pub observations: f64,
    /// Loss that noise alone is expected to leave.
    pub floor: f64,
}
