//! A tile that is reduced, as one coordinator leaves it to the next.

use super::event::{statistics, statistics_to_wire};
use super::film::{append_floats, floats_to_wire};
use super::{Result, WireError};
use crate::wire;
use gonio_scene::PhotoStatistics;

/// What all tasks of a tile have come to.
#[derive(Debug, Clone, PartialEq)]
pub struct Reduced {
    /// Sums against the photograph, where the evaluation compares.
    pub statistics: Option<PhotoStatistics>,
    /// `[pixel][channel]` over the wanted pixels, where the evaluation has films.
    pub film: Option<Vec<f32>>,
    /// Samples that were NaN or infinite and count as zero.
    pub invalid_samples: u64,
}

impl Reduced {
    /// The record of the tile with this index; every number keeps its bits.
    #[must_use]
    pub fn to_wire(&self, tile: u64) -> wire::ReducedTile {
        wire::ReducedTile {
            tile,
            statistics: self.statistics.clone().map(statistics_to_wire),
            film: self.film.as_ref().map(|film| floats_to_wire([film.as_slice()])),
            invalid_samples: self.invalid_samples,
        }
    }

    /// A tile's index, and what it was reduced to.
    ///
    /// # Errors
    /// Numbers that are not finite, a matrix that is not square, a film that ends within a number.
    pub fn from_wire(record: wire::ReducedTile) -> Result<(u64, Self)> {
        let film = record.film.map(|bytes| {
            let mut film = Vec::new();
            append_floats("ReducedTile.film", &bytes, &mut film).map(|()| film)
        });
        let statistics = record.statistics.map(statistics).transpose()?;
        let reduced = Self { statistics, film: film.transpose()?, invalid_samples: record.invalid_samples };
        if reduced.statistics.is_none() && reduced.film.is_none() {
            return Err(WireError::new("ReducedTile", "holds nothing"));
        }
        Ok((record.tile, reduced))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reduced_tiles_keep_their_bits() {
        let statistics = PhotoStatistics {
            photo: 2,
            gram: vec![0.1 + 0.2, 1.0 / 3.0, 5e-324, -0.0],
            noise: vec![0.1; 4],
            ..Default::default()
        };
        let tile = Reduced { statistics: Some(statistics), film: Some(vec![0.1, -0.0, 1e-45]), invalid_samples: 7 };
        assert_eq!(Reduced::from_wire(tile.to_wire(9)).unwrap(), (9, tile.clone()));
        let mut broken = tile.to_wire(9);
        broken.film = Some(vec![0; 7].into());
        assert!(Reduced::from_wire(broken).is_err());
        assert!(Reduced::from_wire(wire::ReducedTile::default()).unwrap_err().to_string().contains("holds nothing"));
    }
}
