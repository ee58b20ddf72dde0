//! What is kept of a finished frame beside its files. A frame is finished once its record is there: it is written last.

use crate::sheet::thumbnail::Thumbnail;
use gonio_scene::Film;
use gonio_scene::capture::Response;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// What is known of a finished frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// The frame's digest, to tell a record that was moved.
    pub digest: String,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Mean photo value per channel.
    pub mean: [f64; 3],
    /// SHA-256 of the photo values: 32-bit floats, little-endian, channel by channel.
    pub film_sha256: String,
    /// Samples that were NaN or infinite and count as black.
    pub invalid_samples: u64,
    /// From the request to the answer, as measured when it was rendered. Of frames that were asked for together, each
    /// has the share of its pixels; frames of other evaluations were rendered at the same time.
    pub seconds: f64,
    /// For the contact sheet.
    pub thumbnail: Thumbnail,
}

impl Record {
    /// The record of a frame whose photo values are `film`.
    #[must_use]
    pub fn of(digest: String, film: &Film, response: &Response, invalid_samples: u64, seconds: f64) -> Self {
        let mut sha = Sha256::new();
        let mut mean = [0.0; 3];
        for (mean, channel) in mean.iter_mut().zip(&film.channels) {
            channel.iter().for_each(|value| sha.update(value.to_le_bytes()));
            #[allow(clippy::cast_precision_loss)]
            let count = channel.len().max(1) as f64;
            *mean = channel.iter().map(|value| f64::from(*value)).sum::<f64>() / count;
        }
        let film_sha256 = sha.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        let thumbnail = Thumbnail::of(film, response);
        let (width, height) = (film.width, film.height);
        Self { digest, width, height, mean, film_sha256, invalid_samples, seconds, thumbnail }
    }

    /// The bytes of its file.
    ///
    /// # Errors
    /// A mean that is no number.
    pub fn to_json(&self) -> Result<Vec<u8>, serde_json::Error> {
        serde_json::to_vec(self)
    }

    /// Reads a record's file; `None` where it is none of the frame `digest`, such as one that was cut off.
    #[must_use]
    pub fn from_json(bytes: &[u8], digest: &str) -> Option<Self> {
        serde_json::from_slice::<Self>(bytes).ok().filter(|record| record.digest == digest)
    }
}
