//! What is written of each frame.

use crate::keys::Keys;
use gonio_scene::Result;

/// The kinds of file that a frame has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Output {
    /// Photo values, 32-bit float RGB.
    Exr,
    /// Photo values for the eye, 8 bits.
    Png,
    /// What a camera would save: photo values with the sensor's noise, 8 bits.
    Rgb,
    /// First hits: depth, normal, object, position and angles, 32-bit float.
    Buffers,
}

impl Output {
    /// All of them, by the words that a sweep uses.
    pub const ALL: [(&'static str, Self); 4] =
        [("exr", Self::Exr), ("png", Self::Png), ("rgb", Self::Rgb), ("buffers", Self::Buffers)];

    /// The word that a sweep and its table use.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Exr => "exr",
            Self::Png => "png",
            Self::Rgb => "rgb",
            Self::Buffers => "buffers",
        }
    }

    /// What its files' names end with.
    #[must_use]
    pub fn ending(self) -> &'static str {
        match self {
            Self::Exr => "exr",
            Self::Png => "png",
            Self::Rgb => "rgb.png",
            Self::Buffers => "buffers.exr",
        }
    }

    /// Bytes for each pixel before compression.
    #[must_use]
    pub fn pixel_bytes(self) -> u64 {
        match self {
            Self::Exr => 12,
            Self::Png | Self::Rgb => 3,
            Self::Buffers => 4 * gonio_scene::film::FIRST_HIT_CHANNELS.len() as u64,
        }
    }

    /// Reads the key `outputs`; EXR alone where it is absent.
    pub(crate) fn read(keys: &mut Keys<'_>) -> Result<Vec<Self>> {
        let Some(words) = keys.texts("outputs")? else { return Ok(vec![Self::Exr]) };
        let mut outputs = Vec::new();
        for word in words {
            let Some((_, output)) = Self::ALL.iter().find(|(known, _)| *known == word) else {
                return Err(keys.refuse("outputs", format!("has \"{word}\""), "list some of: exr, png, rgb, buffers"));
            };
            outputs.push(*output);
        }
        outputs.sort_unstable();
        outputs.dedup();
        Ok(outputs)
    }
}
