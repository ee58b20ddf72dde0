//! The formats that a capture is exported to.

use std::fmt;
use std::str::FromStr;

/// A format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    /// Mitsuba 3: an XML scene for every photo, and a Python module that loads them as objects.
    Mitsuba,
    /// Blender 4 and 5: a Python script that builds a photo's scene, and its data.
    Blender,
    /// OpenUSD: one stage of `UsdPreviewSurface` and OpenPBR materials, `UsdLux` lights, `UsdGeom` cameras.
    Usd,
    /// glTF 2.0: one GLB with a scene for every photo.
    Gltf,
    /// pbrt-v4: a scene file for every photo.
    Pbrt,
}

impl Format {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Mitsuba, Self::Blender, Self::Usd, Self::Gltf, Self::Pbrt];

    /// The word that the command line and `export.json` use.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Mitsuba => "mitsuba",
            Self::Blender => "blender",
            Self::Usd => "usd",
            Self::Gltf => "gltf",
            Self::Pbrt => "pbrt",
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}

impl FromStr for Format {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|format| format.word() == text)
            .ok_or_else(|| format!("write one of: {}", Self::ALL.map(Self::word).join(", ")))
    }
}
