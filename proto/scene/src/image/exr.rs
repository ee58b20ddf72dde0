//! OpenEXR.

use std::io::Cursor;

use exr::image::FlatSamples;
use exr::meta::MetaData;
use exr::meta::header::Header;
use exr::prelude::{IntegerBounds, ReadChannels, ReadLayers, SampleType, read as reader};

use super::colour::{Primaries, convert};
use super::{Image, limit, mask};
use crate::decoder::one_line;
use crate::error::{Result, SceneError};

const MEND: &str = "save the image again, as OpenEXR with the channels R, G, B and ZIP compression";

/// The part and the names of the channels that are red, green and blue.
struct Choice {
    part: usize,
    names: [String; 3],
}

/// Reads the colour in the display window of an OpenEXR file, in Rec. 709, and which pixels count by its alpha.
pub(super) fn read(path: &str, bytes: &[u8]) -> Result<(Image, Option<Vec<bool>>)> {
    let headers = headers(path, bytes)?;
    let Choice { part, names } = choose(path, &headers)?;
    let display = headers.first().map(|header| header.shared_attributes.display_window).unwrap_or_default();
    if let Some(header) = headers.get(part) {
        check_window(path, header.data_window(), display)?;
    }
    let decoded = reader()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| SceneError::new(path, one_line(&error), MEND))?;

    let layer = decoded.layer_data.get(part).ok_or_else(|| SceneError::new(path, "has lost a part", MEND))?;
    let channel = |name: &String| {
        let found = layer.channel_data.list.iter().find(|channel| channel.name.to_string() == *name);
        found
            .map(|channel| &channel.sample_data)
            .ok_or_else(|| SceneError::new(path, "has lost a channel", MEND).at(name))
    };
    let [r, g, b] = &names;
    let channels = [channel(r)?, channel(g)?, channel(b)?];
    // The alpha of a layer has its prefix; that of gray has none.
    let prefix = if r == b { "" } else { r.strip_suffix('R').unwrap_or_default() };
    let alpha = channel(&format!("{prefix}A")).ok();

    let first = display.position - layer.attributes.layer_position;
    let offset = |value: i32| usize::try_from(value).unwrap_or(0);
    let (left, top) = (offset(first.x()), offset(first.y()));
    let (width, height) = (display.size.width(), display.size.height());
    let mut pixels = Vec::with_capacity(width * height);
    let mut counts = Vec::new();
    for row in top..top + height {
        let start = row * layer.size.width() + left;
        pixels.extend((start..start + width).map(|index| channels.map(|samples| sample(samples, index))));
        if let Some(alpha) = alpha {
            counts.extend((start..start + width).map(|index| sample(alpha, index) > mask::THRESHOLD));
        }
    }
    let (width, height) = size(path, display)?;
    let mut image = Image { width, height, pixels };
    let primaries = headers.get(part).and_then(primaries).filter(|primaries| r != b && !primaries.is_rec709());
    if let Some(primaries) = primaries {
        let mend = "save the image again, in Rec. 709";
        let matrix =
            primaries.to_rec709().ok_or_else(|| SceneError::new(path, "span no colours", mend).at("chromaticities"))?;
        convert(&mut image, matrix);
    }
    Ok((image, alpha.map(|_| counts)))
}

fn primaries(header: &Header) -> Option<Primaries> {
    let stated = header.shared_attributes.chromaticities?;
    let place = |point: exr::math::Vec2<f32>| [f64::from(point.x()), f64::from(point.y())];
    Some(Primaries([place(stated.red), place(stated.green), place(stated.blue), place(stated.white)]))
}

/// The luminance in cd/m^2 that the file gives to the value 1, where it does.
pub(super) fn white_luminance(path: &str, bytes: &[u8]) -> Result<Option<f32>> {
    Ok(headers(path, bytes)?.iter().find_map(|header| header.own_attributes.white_luminance))
}

/// The size of the display window in pixels.
pub(super) fn dimensions(path: &str, bytes: &[u8]) -> Result<(u32, u32)> {
    let headers = headers(path, bytes)?;
    size(path, headers.first().map(|header| header.shared_attributes.display_window).unwrap_or_default())
}

/// The headers of all parts, when decoding them keeps within the limits.
fn headers(path: &str, bytes: &[u8]) -> Result<Vec<Header>> {
    let broken = |error: exr::error::Error| SceneError::new(path, one_line(&error), MEND);
    let headers = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(broken)?.headers;
    let mut total: u64 = 0;
    for header in &headers {
        if header.deep {
            return Err(SceneError::new(path, "has deep pixels, which are not supported", MEND));
        }
        let pixels = (header.layer_size.width() as u64).saturating_mul(header.layer_size.height() as u64);
        let sample_bytes = |sample| match sample {
            SampleType::F16 => 2,
            SampleType::F32 | SampleType::U32 => 4,
        };
        let pixel_bytes = header.channels.list.iter().map(|channel| sample_bytes(channel.sample_type)).sum();
        total = total.saturating_add(pixels.saturating_mul(pixel_bytes));
        limit::check(path, size(path, header.data_window())?, total, bytes.len())?;
    }
    if let Some(header) = headers.first() {
        limit::check(path, size(path, header.shared_attributes.display_window)?, total, bytes.len())?;
    }
    Ok(headers.into_iter().collect())
}

fn size(path: &str, window: IntegerBounds) -> Result<(u32, u32)> {
    match (u32::try_from(window.size.width()), u32::try_from(window.size.height())) {
        (Ok(width), Ok(height)) => Ok((width, height)),
        _ => Err(SceneError::new(path, "has a window of an impossible size", MEND).at("size")),
    }
}

/// Pixels outside of the data window have no value, and a photo has no pixel without.
fn check_window(path: &str, data: IntegerBounds, display: IntegerBounds) -> Result<()> {
    let edges = |window: IntegerBounds, axis: fn(IntegerBounds) -> (i32, usize)| {
        let (start, length) = axis(window);
        (i64::from(start), i64::from(start).saturating_add(i64::try_from(length).unwrap_or(i64::MAX)))
    };
    let axes: [fn(IntegerBounds) -> (i32, usize); 2] =
        [|window| (window.position.x(), window.size.width()), |window| (window.position.y(), window.size.height())];
    let covered = axes.into_iter().all(|axis| {
        let ((data_start, data_end), (start, end)) = (edges(data, axis), edges(display, axis));
        data_start <= start && end <= data_end
    });
    if covered {
        return Ok(());
    }
    let describe = |window: IntegerBounds| {
        format!(
            "{} x {} at {}, {}",
            window.size.width(),
            window.size.height(),
            window.position.x(),
            window.position.y()
        )
    };
    Err(SceneError::new(
        path,
        format!("has pixels only in {}, and its display window is {}", describe(data), describe(display)),
        "save the image without cropping it to a data window",
    )
    .at("dataWindow"))
}

/// Finds the colour: `R`, `G`, `B` of the first part that has them, or of the one layer that has them; or else the
/// luminance `Y`; or else the only channel of the file.
fn choose(path: &str, headers: &[Header]) -> Result<Choice> {
    let mut all: Vec<(usize, String)> = Vec::new();
    for (part, header) in headers.iter().enumerate() {
        all.extend(header.channels.list.iter().map(|channel| (part, channel.name.to_string())));
    }
    let has = |part: usize, name: &str| all.iter().any(|(other, channel)| *other == part && channel == name);
    let mut layers = Vec::new();
    for (part, name) in &all {
        // A layer's prefix ends at the last point: "diffuse.R".
        if let Some(prefix) = name.strip_suffix('R')
            && (prefix.is_empty() || prefix.ends_with('.'))
        {
            let names = ["R", "G", "B"].map(|channel| format!("{prefix}{channel}"));
            if names.iter().all(|name| has(*part, name)) {
                layers.push((prefix.is_empty(), Choice { part: *part, names }));
            }
        }
    }
    let gray = |part: usize, name: &str| Choice { part, names: [name, name, name].map(str::to_owned) };
    let chosen = if let Some(main) = layers.iter().position(|(main, _)| *main) {
        Some(layers.swap_remove(main).1)
    } else if layers.len() == 1 {
        layers.pop().map(|(_, choice)| choice)
    } else if let (0, [(part, name)]) = (layers.len(), all.as_slice()) {
        Some(gray(*part, name))
    } else if let Some(part) = (0..headers.len()).find(|&part| has(part, "Y") && !has(part, "RY")) {
        layers.is_empty().then(|| gray(part, "Y"))
    } else {
        None
    };
    let chosen = chosen.ok_or_else(|| {
        let names: Vec<_> = all.iter().take(12).map(|(_, name)| name.as_str()).collect();
        SceneError::new(path, format!("has no unambiguous colour among its channels {}", names.join(", ")), MEND)
    })?;
    let channels = headers.get(chosen.part).map(|header| header.channels.list.as_slice()).unwrap_or_default();
    let subsampled = channels.iter().find(|channel| {
        chosen.names.contains(&channel.name.to_string()) && (channel.sampling.x() != 1 || channel.sampling.y() != 1)
    });
    match subsampled {
        Some(channel) => {
            Err(SceneError::new(path, "is subsampled, which is not supported", MEND).at(channel.name.to_string()))
        }
        None => Ok(chosen),
    }
}

#[allow(clippy::cast_precision_loss)]
fn sample(samples: &FlatSamples, index: usize) -> f32 {
    let value = match samples {
        FlatSamples::F16(values) => values.get(index).map(|value| value.to_f32()),
        FlatSamples::F32(values) => values.get(index).copied(),
        FlatSamples::U32(values) => values.get(index).map(|&value| value as f32),
    };
    // No such index: the windows were compared before. Not a number is refused, where a zero would pass unseen.
    value.unwrap_or(f32::NAN)
}
