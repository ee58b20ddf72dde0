//! Files by the crate `flashraw`.

use super::colour::Matrices;
use super::{Notes, Sensor, refuse};
use flashraw::{ColorMatrix, CorruptionPolicy, DecodeOptions, FlashRaw, OutputFormat, RawFrame};
use gonio_scene::{SceneError, shielded};
use nalgebra::{Matrix3, Vector3};

/// Most samples of a file: 100 million, so that nothing here takes more than some 3 GB.
const SAMPLES: u64 = 100_000_000;
/// No sensor's values are stored in less than this part of a byte: a header that announces more pixels is damaged.
const PER_BYTE: u64 = 64;

/// The sensor's values and what they mean.
///
/// # Errors
/// Bytes that are no RAW file of a known kind, or a damaged one.
pub(super) fn read(file: &str, bytes: &[u8]) -> Result<Sensor, SceneError> {
    shielded(file, || decode(file, bytes))
}

fn decode(file: &str, bytes: &[u8]) -> Result<Sensor, SceneError> {
    let broken = |error: flashraw::Error| {
        refuse(
            file,
            format!("is a RAW file that cannot be read here: {}", error.to_string().lines().next().unwrap_or_default()),
        )
    };
    let limits = flashraw::Limits::default().with_max_samples(SAMPLES).with_max_dimension(gonio_scene::MAX_SIDE);
    let raw = FlashRaw::open_with(bytes, limits).map_err(broken)?;
    let info = raw.frame_info();
    let samples = u64::from(info.width) * u64::from(info.height) * u64::from(info.cpp.max(1));
    if samples > SAMPLES.min(PER_BYTE * bytes.len() as u64) {
        return Err(refuse(
            file,
            format!("announces {} x {} pixels, which its bytes cannot hold", info.width, info.height),
        ));
    }
    let mut options = DecodeOptions::default();
    // Corrections of the stored values that belong to reading them (a lossy DNG's tones, a gain map) are in the second list.
    let corrected = info.opcodes.as_ref().is_some_and(|opcodes| !opcodes.lists[1].is_empty());
    options.output = if corrected { OutputFormat::NormalizedF32 } else { OutputFormat::RawF32 };
    options.corruption_policy = CorruptionPolicy::Strict;
    options.limits = limits;
    let frame = raw.decode(options).map_err(broken)?;
    sensor(file, &frame, corrected, info.pixel_aspect)
}

fn sensor(file: &str, frame: &RawFrame, corrected: bool, aspect: f32) -> Result<Sensor, SceneError> {
    let channels = frame.cpp as usize;
    let values = frame.data.as_f32().ok_or_else(|| refuse(file, "holds its values in a way that is not known here"))?;
    let mut crop = frame.crop;
    if crop.is_empty() {
        crop = frame.active_area;
    }
    let whole = (frame.width as usize, frame.height as usize);
    let [x0, y0, width, height] = [crop.x, crop.y, crop.width, crop.height].map(|side| side as usize);
    let inside = x0 + width <= whole.0 && y0 + height <= whole.1 && width > 1 && height > 1;
    if !inside || !matches!(channels, 1 | 3) || values.len() < whole.0 * whole.1 * channels {
        return Err(refuse(file, "has no picture of one or three values a pixel"));
    }
    let mosaic = match &frame.cfa {
        Some(pattern) if channels == 1 => {
            let (columns, rows) = (pattern.width(), pattern.height());
            let colours: Vec<u8> =
                (0..rows * columns).map(|k| pattern.color_at(x0 + k % columns, y0 + k / columns) as u8).collect();
            if colours.iter().any(|colour| *colour > 2) || [0, 1, 2].iter().any(|c| !colours.contains(c)) {
                return Err(refuse(file, "has a mosaic of other colours than red, green and blue"));
            }
            Some((colours, columns))
        }
        _ => None,
    };
    let black = &frame.black_level;
    let white =
        |colour: usize| frame.white_level.at(if frame.white_level.values.len() > 1 { colour } else { 0 }) as f32;
    let mut cut = Vec::with_capacity(width * height * 3);
    for y in y0..y0 + height {
        for x in x0..x0 + width {
            for c in 0..channels {
                let value = values[(y * whole.0 + x) * channels + c];
                let colour = frame.cfa.as_ref().map_or(c, |pattern| pattern.color_at(x, y) as usize);
                let dark = black.at(x, y, c);
                let light = if corrected { value } else { (value - dark) / (white(colour) - dark) };
                // A sensor without colours has three equal channels.
                let copies = if channels == 1 && mosaic.is_none() { 3 } else { 1 };
                cut.extend(std::iter::repeat_n(light, copies));
            }
        }
    }
    if cut.iter().any(|value| !value.is_finite()) {
        return Err(refuse(file, "states a black level that is not below its white level"));
    }
    Ok(Sensor {
        width,
        height,
        values: cut,
        mosaic,
        neutral: neutral(frame),
        matrices: matrices(frame),
        noise: noise(frame),
        orientation: u16::try_from(frame.orientation.exif()).unwrap_or(1),
        notes: notes(frame, black.mean(), white(1), aspect),
    })
}

/// What gray has in the channels: the inverse of the multipliers that make it gray.
fn neutral(frame: &RawFrame) -> Option<[f64; 3]> {
    if frame.white_balance_applied {
        return Some([1.0; 3]);
    }
    let multipliers = frame.white_balance?.coeffs;
    let values = [0, 1, 2].map(|c| 1.0 / f64::from(multipliers[c]));
    let most = values.iter().fold(0.0, |a: f64, b| a.max(*b));
    let values = values.map(|value| value / most);
    values.iter().all(|value| value.is_finite() && *value > 1e-3).then_some(values)
}

fn matrices(frame: &RawFrame) -> Matrices {
    let stated = &frame.color_matrices;
    let all = |list: &[ColorMatrix]| {
        let usable = list.iter().filter(|matrix| matrix.rows == 3 && matrix.values.len() >= 9);
        let each = |matrix: &ColorMatrix| {
            let values = matrix.values.iter().take(9).map(|value| f64::from(*value));
            (matrix.illuminant.temperature().map(f64::from), Matrix3::from_row_iterator(values))
        };
        usable.map(each).collect::<Vec<_>>()
    };
    let analog = match stated.analog_balance[..] {
        [r, g, b, ..] => Matrix3::from_diagonal(&Vector3::new(r, g, b).map(f64::from)),
        _ => Matrix3::identity(),
    };
    Matrices {
        colour: all(&stated.color),
        forward: all(&stated.forward),
        calibration: all(&stated.calibration),
        analog,
    }
}

/// `NoiseProfile`: one pair for all channels, or one for each.
fn noise(frame: &RawFrame) -> Option<[[f64; 2]; 3]> {
    let stated = frame.metadata.dng.as_ref()?.noise_profile.as_ref()?;
    let pair = |k: usize| Some([*stated.get(2 * k)?, *stated.get(2 * k + 1)?]);
    let found = match stated.len() {
        2 => [pair(0)?; 3],
        6 => [pair(0)?, pair(1)?, pair(2)?],
        _ => return None,
    };
    found.iter().flatten().all(|value| value.is_finite() && *value >= 0.0).then_some(found)
}

fn notes(frame: &RawFrame, black: f32, white: f32, aspect: f32) -> Notes {
    let exposure = &frame.metadata.exposure;
    let positive = |value: f64| (value.is_finite() && value > 0.0).then_some(value);
    Notes {
        camera: frame.metadata.camera().trim().to_owned(),
        format: frame.metadata.format.map_or_else(String::new, |format| format.name().to_owned()),
        levels: [f64::from(black), f64::from(white)],
        seconds: exposure.exposure_time.and_then(positive),
        f_number: exposure.f_number.map(f64::from).and_then(positive),
        iso: exposure.iso.map(f64::from).and_then(positive),
        aspect: f64::from(aspect),
        matrices: match frame.color_matrices.source {
            flashraw::ColorSource::File => "the file",
            flashraw::ColorSource::CameraDb => "a table of cameras",
            _ => "nowhere",
        },
        left: frame.stats.opcodes.clone(),
    }
}
