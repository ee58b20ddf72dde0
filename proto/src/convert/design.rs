//! A design of observations as a blob.

use super::{Digest, Result, WireError, at_most};
use crate::{limits, wire};
use bytes::Bytes;
use gonio_scene::MAX_SIDE;
use gonio_scene::design::{Design, Rates};
use prost::Message;

/// The digest of the design that a request names, where it names one.
///
/// # Errors
/// It is no digest, or the request wants more than statistics: films have every pixel.
pub fn design_of(request: &wire::EvaluationRequest) -> Result<Option<Digest>> {
    let field = "EvaluationRequest.design_digest";
    if request.design_digest.is_empty() {
        return Ok(None);
    }
    if request.output != i32::from(wire::Output::Statistics) {
        return Err(WireError::new(field, "goes with OUTPUT_STATISTICS alone: films have every pixel"));
    }
    Digest::from_wire(field, &request.design_digest).map(Some)
}

/// The blob that [`design_from_blob`] reads; equal designs have equal blobs.
#[must_use]
pub fn design_to_blob(design: &Design) -> Bytes {
    let photo = |(photo, rates): &(usize, Rates)| wire::PixelRates {
        // An index beyond 32 bits is beyond any capture's photos, and is refused as such.
        photo: u32::try_from(*photo).unwrap_or(u32::MAX),
        cell_pixels: rates.cell,
        columns: rates.columns,
        codes: Bytes::copy_from_slice(&rates.codes),
    };
    wire::PixelDesign { seed: design.seed, photos: design.photos.iter().map(photo).collect() }.encode_to_vec().into()
}

/// Reads a design's blob.
///
/// # Errors
/// It is none, is too large, names a photo twice or not in order, or has cells that are no grid. Whether they cover the photos is for
/// who has the capture.
pub fn design_from_blob(blob: Bytes) -> Result<Design> {
    if blob.len() as u64 > limits::DESIGN_BYTES {
        let problem = format!("has {} bytes, the limit is {}", blob.len(), limits::DESIGN_BYTES);
        return Err(WireError::new("PixelDesign", problem));
    }
    let design = wire::PixelDesign::decode(blob);
    let design = design.map_err(|error| WireError::new("PixelDesign", format!("is none: {error}")))?;
    let field = "PixelDesign.photos";
    at_most(field, design.photos.len(), limits::PHOTOS)?;
    let mut photos: Vec<(usize, Rates)> = Vec::with_capacity(design.photos.len());
    for wire::PixelRates { photo, cell_pixels: cell, columns, codes } in design.photos {
        let index = photo as usize;
        if photos.last().is_some_and(|(before, _)| *before >= index) {
            return Err(WireError::new(field, format!("names photo {photo} twice or not in ascending order")));
        }
        let sides = [cell, columns].iter().all(|side| (1..=MAX_SIDE).contains(side));
        if !sides || codes.is_empty() || !codes.len().is_multiple_of(columns as usize) {
            let problem = format!(
                "has {} codes in {columns} columns of {cell} pixels for photo {photo}, which is no grid",
                codes.len()
            );
            return Err(WireError::new(field, problem));
        }
        photos.push((index, Rates { cell, columns, codes: codes.to_vec() }));
    }
    Ok(Design { seed: design.seed, photos })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn design() -> Design {
        let rates = |codes: &[u8]| Rates { cell: 25, columns: 2, codes: codes.to_vec() };
        Design { seed: u64::MAX, photos: vec![(0, rates(&[0, 8])), (3, rates(&[255, 1, 2, 3]))] }
    }

    #[test]
    fn a_design_survives_its_blob() {
        assert_eq!(design_from_blob(design_to_blob(&design())).unwrap(), design());
        assert_eq!(design_from_blob(Bytes::new()).unwrap(), Design::default());
    }

    #[test]
    fn broken_designs_are_refused() {
        let broken = |change: &dyn Fn(&mut wire::PixelDesign), expected: &str| {
            let mut message = wire::PixelDesign::decode(design_to_blob(&design())).unwrap();
            change(&mut message);
            let error = design_from_blob(message.encode_to_vec().into()).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        };
        broken(&|d| d.photos[1].photo = 0, "twice or not in ascending order");
        broken(&|d| d.photos[0].photo = 4, "twice or not in ascending order");
        broken(&|d| d.photos[0].cell_pixels = 0, "no grid");
        broken(&|d| d.photos[0].cell_pixels = u32::MAX, "no grid");
        broken(&|d| d.photos[0].columns = 0, "no grid");
        broken(&|d| d.photos[1].columns = 3, "no grid");
        broken(&|d| d.photos[0].codes = Bytes::new(), "no grid");
        broken(&|d| d.photos = vec![d.photos[0].clone(); limits::PHOTOS + 1], "the limit is 10000");
        let blob = design_to_blob(&design());
        assert!(design_from_blob(blob.slice(..blob.len() - 1)).unwrap_err().to_string().contains("is none"));
        let large = Bytes::from(vec![0; limits::DESIGN_BYTES as usize + 1]);
        assert!(design_from_blob(large).unwrap_err().to_string().contains("the limit is"));
    }

    #[test]
    fn films_take_no_design() {
        let digest = Digest::of(b"design");
        let request = |output: wire::Output, design: Bytes| {
            design_of(&wire::EvaluationRequest { output: output.into(), design_digest: design, ..Default::default() })
        };
        assert_eq!(request(wire::Output::Statistics, digest.to_wire()).unwrap(), Some(digest));
        assert_eq!(request(wire::Output::Films, Bytes::new()).unwrap(), None);
        for output in [wire::Output::StatisticsAndFilms, wire::Output::Films, wire::Output::FirstHit] {
            assert!(request(output, digest.to_wire()).unwrap_err().to_string().contains("OUTPUT_STATISTICS alone"));
        }
        assert!(request(wire::Output::Statistics, Bytes::from_static(b"x")).unwrap_err().to_string().contains("32"));
    }
}
