//! COLMAP's binary model: `cameras.bin` and `images.bin`, little-endian, as its `src/colmap/scene/reconstruction_io` writes
//! them. The points of `points3D.bin` are no part of a capture.

use super::{WORLD, camera, view};
use crate::view::Imported;
use gonio_scene::capture::Camera;
use gonio_scene::{Result, SceneError};
use std::collections::BTreeMap;

const CAMERAS: &str = "cameras.bin";
const IMAGES: &str = "images.bin";

/// Name and number of parameters of the models, by their number in the file.
const MODELS: [(&str, usize); 12] = [
    ("SIMPLE_PINHOLE", 3),
    ("PINHOLE", 4),
    ("SIMPLE_RADIAL", 4),
    ("RADIAL", 5),
    ("OPENCV", 8),
    ("OPENCV_FISHEYE", 8),
    ("FULL_OPENCV", 12),
    ("FOV", 5),
    ("SIMPLE_RADIAL_FISHEYE", 4),
    ("RADIAL_FISHEYE", 5),
    ("THIN_PRISM_FISHEYE", 12),
    ("RAD_TAN_THIN_PRISM_FISHEYE", 16),
];

/// Bytes of a point that an image saw: x, y and the number of the point in space.
const POINT_BYTES: u64 = 24;

/// Reads the bytes of both files of a model; conventions as for [`super::colmap`].
///
/// # Errors
/// A file that ends early or late, an unknown or fisheye camera model, an image of a camera that is not listed, no image
/// at all. A count larger than its file is refused without room being made for it.
pub fn colmap_binary(cameras: &[u8], images: &[u8]) -> Result<Imported> {
    let cameras = read_cameras(cameras)?;
    let mut reader = Reader::new(IMAGES, images);
    let count = reader.u64("the number of images")?;
    let mut views = Vec::new();
    for index in 0..count {
        reader.entry = format!("image {index}");
        reader.u32("its number")?;
        let mut pose = [0.0; 7];
        for number in &mut pose {
            *number = reader.f64("its pose")?;
        }
        let id = reader.u32("its camera")?;
        let name = reader.name()?;
        let points = reader.u64("the number of its points")?;
        reader.skip(points.checked_mul(POINT_BYTES), "its points")?;
        let mend = "copy the model's folder anew: cameras.bin and images.bin belong together";
        let found = cameras.get(&id).ok_or_else(|| reader.wrong(format!("has camera {id}, not in {CAMERAS}"), mend))?;
        views.push(view(name, found, pose).map_err(|problem| reader.wrong(problem.to_owned(), "reconstruct anew"))?);
    }
    reader.end()?;
    if views.is_empty() {
        return Err(SceneError::new(IMAGES, "lists no image", "name the folder of a reconstruction that holds images"));
    }
    Ok(Imported { views, objects: Vec::new(), world: WORLD })
}

fn read_cameras(bytes: &[u8]) -> Result<BTreeMap<u32, Camera>> {
    let mut reader = Reader::new(CAMERAS, bytes);
    let count = reader.u64("the number of cameras")?;
    let mut cameras = BTreeMap::new();
    for index in 0..count {
        reader.entry = format!("camera {index}");
        let id = reader.u32("its number")?;
        let model = reader.u32("its model")?;
        let mut side = || -> Result<u32> {
            let side = reader.u64("its size")?;
            u32::try_from(side).ok().filter(|side| (1..=gonio_scene::MAX_SIDE).contains(side)).ok_or_else(|| {
                let mend = "undistort or scale the images to a size that a capture can have";
                reader.wrong(format!("is {side} pixels wide or high, not 1..={}", gonio_scene::MAX_SIDE), mend)
            })
        };
        let size = [side()?, side()?];
        let Some(&(name, parameters)) = MODELS.get(model as usize) else {
            let mend = "undistort the images by `colmap image_undistorter`, which gives a PINHOLE model";
            return Err(reader.wrong(format!("is of model {model}, which is unknown here"), mend));
        };
        let mut numbers = Vec::with_capacity(parameters);
        for _ in 0..parameters {
            numbers.push(reader.f64("its parameters")?);
        }
        let found = camera(name, size, &numbers).map_err(|(problem, mend)| reader.wrong(problem, mend))?;
        cameras.insert(id, found);
    }
    reader.end()?;
    Ok(cameras)
}

/// The rest of a file, and which of its entries is being read.
struct Reader<'b> {
    file: &'static str,
    entry: String,
    rest: &'b [u8],
}

impl<'b> Reader<'b> {
    fn new(file: &'static str, rest: &'b [u8]) -> Self {
        Self { file, entry: "header".to_owned(), rest }
    }

    fn wrong(&self, problem: String, mend: &str) -> SceneError {
        SceneError::new(self.file, problem, mend).at(&self.entry)
    }

    fn short(&self, what: &str) -> SceneError {
        self.wrong(format!("ends before {what}"), "copy the file anew: it is cut, or no binary model of COLMAP")
    }

    fn take<const N: usize>(&mut self, what: &str) -> Result<[u8; N]> {
        let (bytes, rest) = self.rest.split_first_chunk::<N>().ok_or_else(|| self.short(what))?;
        self.rest = rest;
        Ok(*bytes)
    }

    fn u32(&mut self, what: &str) -> Result<u32> {
        Ok(u32::from_le_bytes(self.take(what)?))
    }

    fn u64(&mut self, what: &str) -> Result<u64> {
        Ok(u64::from_le_bytes(self.take(what)?))
    }

    fn f64(&mut self, what: &str) -> Result<f64> {
        Ok(f64::from_le_bytes(self.take(what)?))
    }

    /// A file's name, which a zero ends.
    fn name(&mut self) -> Result<String> {
        let end = self.rest.iter().position(|&byte| byte == 0).ok_or_else(|| self.short("the end of its name"))?;
        let (name, rest) = self.rest.split_at(end);
        let name = std::str::from_utf8(name).ok().filter(|name| !name.is_empty());
        let name = name.ok_or_else(|| self.wrong("has no name in UTF-8".to_owned(), "rename the image file"))?;
        self.rest = &rest[1..];
        Ok(name.to_owned())
    }

    /// Passes over so many bytes; none are more than a number holds.
    fn skip(&mut self, bytes: Option<u64>, what: &str) -> Result<()> {
        let bytes = bytes.and_then(|bytes| usize::try_from(bytes).ok());
        self.rest = bytes.and_then(|bytes| self.rest.get(bytes..)).ok_or_else(|| self.short(&format!("{what} do")))?;
        Ok(())
    }

    fn end(&self) -> Result<()> {
        if self.rest.is_empty() {
            return Ok(());
        }
        let problem = format!("has {} bytes more than it lists", self.rest.len());
        Err(SceneError::new(self.file, problem, "copy the file anew: it is damaged, or no binary model of COLMAP"))
    }
}
