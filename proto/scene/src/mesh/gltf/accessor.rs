//! glTF accessors: typed views into buffers.
//!
//! The library's own accessor iterators add and multiply offsets without checks, and end early without a word where a
//! buffer is too short: here every element is known to lie in its buffer before the first is read.

use std::sync::Arc;

use gltf::Accessor;
use gltf::accessor::{DataType, Dimensions};

use crate::error::{Result, SceneError};

const MEND: &str = "export it again, as GLB or PLY";

/// The elements of an accessor of f32 vectors: positions, normals.
pub(super) fn vectors(file: &str, accessor: &Accessor<'_>, buffers: &[Arc<[u8]>]) -> Result<Vec<[f32; 3]>> {
    if (accessor.data_type(), accessor.dimensions()) != (DataType::F32, Dimensions::Vec3) {
        let problem =
            format!("is {:?} of {:?}, not a vector of three floats", accessor.dimensions(), accessor.data_type());
        return Err(SceneError::new(file, problem, "export without quantization").at(place(accessor)));
    }
    let vector = |bytes: &[u8]| {
        let (values, _) = bytes.as_chunks();
        std::array::from_fn(|axis| values.get(axis).map_or(f32::NAN, |&value| f32::from_le_bytes(value)))
    };
    Ok(elements(file, accessor, buffers)?.map(vector).collect())
}

/// The elements of an accessor of vertex indices.
pub(super) fn indices(file: &str, accessor: &Accessor<'_>, buffers: &[Arc<[u8]>]) -> Result<Vec<u32>> {
    let unsigned = matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::U32);
    if !unsigned || accessor.dimensions() != Dimensions::Scalar {
        let problem = format!("is {:?} of {:?}, which is no index", accessor.dimensions(), accessor.data_type());
        return Err(SceneError::new(file, problem, MEND).at(place(accessor)));
    }
    let index = |bytes: &[u8]| bytes.iter().rev().fold(0, |index, &byte| index << 8 | u32::from(byte));
    Ok(elements(file, accessor, buffers)?.map(index).collect())
}

/// The elements of an accessor of vectors of two to four numbers, padded with ones: floats, or integers as a fraction of
/// their largest (glTF 2.0, section 3.6.2.2). Colours and texture coordinates.
pub(super) fn fractions(file: &str, accessor: &Accessor<'_>, buffers: &[Arc<[u8]>]) -> Result<Vec<[f32; 4]>> {
    let known = matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::F32);
    let vector = matches!(accessor.dimensions(), Dimensions::Vec2 | Dimensions::Vec3 | Dimensions::Vec4);
    if !known || !vector {
        let problem =
            format!("is {:?} of {:?}, not a vector of fractions", accessor.dimensions(), accessor.data_type());
        return Err(SceneError::new(file, problem, MEND).at(place(accessor)));
    }
    let bytes_each = accessor.data_type().size();
    let number = |bytes: &[u8]| match *bytes {
        [value] => f32::from(value) / 255.0,
        [low, high] => f32::from(u16::from_le_bytes([low, high])) / 65535.0,
        [a, b, c, d] => f32::from_le_bytes([a, b, c, d]),
        _ => f32::NAN,
    };
    let vector = |bytes: &[u8]| {
        let mut values = bytes.chunks(bytes_each).map(number);
        std::array::from_fn(|_| values.next().unwrap_or(1.0))
    };
    Ok(elements(file, accessor, buffers)?.map(vector).collect())
}

fn place(accessor: &Accessor<'_>) -> String {
    format!("accessors[{}]", accessor.index())
}

/// The bytes of each element, all of them checked to exist.
fn elements<'a>(
    file: &str,
    accessor: &Accessor<'_>,
    buffers: &'a [Arc<[u8]>],
) -> Result<impl Iterator<Item = &'a [u8]> + use<'a>> {
    let refuse = |problem: &str, mend: &str| SceneError::new(file, problem, mend).at(place(accessor));
    if accessor.sparse().is_some() {
        return Err(refuse("is sparse, which is not supported", "export without sparse accessors, or as PLY"));
    }
    let view = accessor.view().ok_or_else(|| refuse("has no buffer view", MEND))?;
    let size = accessor.size();
    let stride = view.stride().unwrap_or(size);
    if stride < size {
        return Err(refuse("has elements that overlap (byteStride)", MEND));
    }
    let content = (|| {
        let buffer = buffers.get(view.buffer().index())?;
        let content = buffer.get(view.offset()..view.offset().checked_add(view.length())?)?.get(accessor.offset()..)?;
        let gaps = accessor.count().checked_sub(1)?.checked_mul(stride)?;
        content.get(..gaps.checked_add(size)?)
    })();
    let content = content.ok_or_else(|| {
        refuse(
            &format!("has {} elements, which do not lie in its buffer", accessor.count()),
            "the file is damaged: export it again",
        )
    })?;
    Ok(content.chunks(stride).filter_map(move |element| element.get(..size)))
}
