//! Exposure from a photograph's own EXIF block.

use exif::{In, Reader, Tag, Value};
use gonio_scene::SceneError;
use std::io::Cursor;

/// The exposure that a file's EXIF block states, seconds at f/1 and ISO 100: time * ISO / 100 / N^2. An aperture or a speed
/// that is not stated counts as f/1 or ISO 100, which only a stack that states it in some files would notice.
///
/// # Errors
/// There is no EXIF block, or no exposure time in it.
pub fn exposure(file: &str, bytes: &[u8]) -> Result<f64, SceneError> {
    let mend = "write its time into a list `file,seconds`, and name the list by --times";
    let block = Reader::new().read_from_container(&mut Cursor::new(bytes)).map_err(|error| {
        SceneError::new(file, format!("has no EXIF block to take its exposure time from ({error})"), mend)
            .at("ExposureTime")
    })?;
    let number = |tag: Tag| {
        let field = block.get_field(tag, In::PRIMARY)?;
        let value = match &field.value {
            Value::Rational(values) => values.first()?.to_f64(),
            value => f64::from(value.get_uint(0)?),
        };
        (value.is_finite() && value > 0.0).then_some(value)
    };
    let apex = |tag: Tag| match &block.get_field(tag, In::PRIMARY)?.value {
        Value::SRational(values) => Some(values.first()?.to_f64()).filter(|value| value.is_finite()),
        Value::Rational(values) => Some(values.first()?.to_f64()).filter(|value| value.is_finite()),
        _ => None,
    };
    // APEX values (Exif 2.32, annex C): the time is 2^-Tv seconds, the aperture 2^(Av / 2).
    let time = number(Tag::ExposureTime)
        .or_else(|| apex(Tag::ShutterSpeedValue).map(|tv| libm::exp2(-tv)))
        .filter(|time| time.is_finite() && *time > 0.0)
        .ok_or_else(|| SceneError::new(file, "states no exposure time in its EXIF block", mend).at("ExposureTime"))?;
    let aperture = number(Tag::FNumber)
        .or_else(|| apex(Tag::ApertureValue).map(|av| libm::exp2(av / 2.0)))
        .filter(|aperture| aperture.is_finite() && *aperture > 0.0)
        .unwrap_or(1.0);
    let speed = number(Tag::PhotographicSensitivity).unwrap_or(100.0);
    Ok(time * speed / 100.0 / (aperture * aperture))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_gives_time_aperture_and_speed() {
        // A little-endian TIFF with one directory that points at the EXIF directory: 1/50 s, f/2, ISO 400.
        let mut bytes = b"II*\0\x08\0\0\0".to_vec();
        let entry = |tag: u16, kind: u16, count: u32, value: u32| {
            [&tag.to_le_bytes()[..], &kind.to_le_bytes(), &count.to_le_bytes(), &value.to_le_bytes()].concat()
        };
        bytes.extend([&1_u16.to_le_bytes()[..], &entry(0x8769, 4, 1, 26), &0_u32.to_le_bytes()].concat());
        bytes.extend(3_u16.to_le_bytes());
        bytes.extend(entry(0x829a, 5, 1, 68));
        bytes.extend(entry(0x829d, 5, 1, 76));
        bytes.extend(entry(0x8827, 3, 1, 400));
        bytes.extend(0_u32.to_le_bytes());
        bytes.extend([1_u32, 50, 2, 1].iter().flat_map(|n| n.to_le_bytes()));
        let found = exposure("a.tif", &bytes);
        assert!(found.is_ok_and(|found| (found - 0.02).abs() < 1e-9));
        // The same by APEX: Tv = 5.64386 for 1/50 s, Av = 2 for f/2.
        let mut apex = b"II*\0\x08\0\0\0".to_vec();
        apex.extend([&1_u16.to_le_bytes()[..], &entry(0x8769, 4, 1, 26), &0_u32.to_le_bytes()].concat());
        apex.extend(3_u16.to_le_bytes());
        apex.extend(entry(0x8827, 3, 1, 400));
        apex.extend(entry(0x9201, 10, 1, 68));
        apex.extend(entry(0x9202, 5, 1, 76));
        apex.extend(0_u32.to_le_bytes());
        apex.extend([564_386_u32, 100_000, 2, 1].iter().flat_map(|n| n.to_le_bytes()));
        let found = exposure("a.tif", &apex).unwrap();
        assert!((found - 0.02).abs() < 1e-6, "{found}");
        let missing = exposure("a.png", b"no photograph").map_err(|error| error.to_string());
        assert!(missing.is_err_and(|text| text.contains("a.png") && text.contains("--times")));
    }
}
