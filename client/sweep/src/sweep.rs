//! The sweep: what a `SWEEP.toml` says.

use crate::design::Design;
use crate::keys::Keys;
use crate::listed::Listed;
use crate::outputs::Output;
use crate::view::View;
use gonio_scene::capture::Range;
use gonio_scene::{Result, SceneError};
use toml::Table;

/// The keys of a sweep, as its file has them; nothing that it names has been opened.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// The file, as errors name it.
    pub file: String,
    /// The capture's folder or its `capture.toml`, relative to the sweep's file.
    pub capture: String,
    /// Samples per pixel, both halves together; even.
    pub samples: u32,
    /// Seed of every random number of a render.
    pub seed: u64,
    /// Whether points share the seed.
    pub seeds: Seeds,
    /// What is written of each frame; at least one.
    pub outputs: Vec<Output>,
    /// Stops by which PNGs are brighter than their photo values.
    pub png_stops: f64,
    /// Width and height of every camera, as a factor on the capture's.
    pub resolution: f64,
    /// Names of the capture's photos that are rendered; absent, all of them, or none where there are views.
    pub photos: Option<Vec<String>>,
    /// How points and views meet.
    pub combine: Combine,
    /// A fit whose estimates the capture takes over.
    pub fit: Option<String>,
    pub(crate) models: Vec<Listed>,
    pub(crate) designs: Vec<Design>,
    pub(crate) views: Vec<View>,
}

/// Which random numbers the points of a sweep are rendered with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Seeds {
    /// The same: differences between frames are less noisy than the frames.
    Shared,
    /// Each its own, which follows from the seed and the point's values: the noise of frames is independent.
    Independent,
}

/// How points and views meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Combine {
    /// Every point from every view.
    Product,
    /// The first point from the first view, the second from the second...
    Pairs,
}

impl Sweep {
    /// Reads the text of a sweep; `file` is what errors call it, `most_samples` the farm's limit.
    ///
    /// # Errors
    /// Anything that is not the format: unknown keys, wrong types, values out of range.
    pub fn parse(file: &str, text: &str, most_samples: u32) -> Result<Self> {
        let top: Table = text.parse().map_err(|e: toml::de::Error| {
            let text = e.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
            SceneError::new(file, format!("is not TOML: {text}"), "mend the syntax there")
        })?;
        let mut keys = Keys::new(file, String::new(), &top);
        let format = keys.whole("format", 0..=u64::MAX)?;
        if keys.needed("format", format, "format = 1")? != 1 {
            return Err(keys.refuse("format", "is not 1", "write format = 1, which this version reads"));
        }
        let capture = keys.text("capture")?;
        let capture = keys.needed("capture", capture, "the path of a capture, relative to this file")?.to_owned();
        let samples = keys.whole("samples", 2..=u64::from(most_samples))?.unwrap_or(64) as u32;
        if !samples.is_multiple_of(2) {
            let mend = "write an even number: each of two halves takes as many";
            return Err(keys.refuse("samples", format!("is {samples}"), mend));
        }
        let seeds = keys.word("seeds", &[("shared", Seeds::Shared), ("independent", Seeds::Independent)])?;
        let combine = keys.word("combine", &[("product", Combine::Product), ("pairs", Combine::Pairs)])?;
        let photos = keys.texts("photos")?.map(|names| names.into_iter().map(str::to_owned).collect());
        let designs = keys.tables("design")?.into_iter().map(Design::read).collect::<Result<_>>()?;
        let views = keys.tables("view")?.into_iter().map(View::read).collect::<Result<_>>()?;
        let models = keys.tables("model")?.into_iter().map(Listed::read).collect::<Result<_>>()?;
        let sweep = Self {
            file: file.to_owned(),
            capture,
            samples,
            seed: keys.whole("seed", 0..=i64::MAX as u64)?.unwrap_or(0),
            seeds: seeds.unwrap_or(Seeds::Shared),
            outputs: Output::read(&mut keys)?,
            png_stops: keys.number("png_stops", Range { min: -60.0, max: 60.0 })?.unwrap_or(0.0),
            resolution: keys.number("resolution", Range { min: 1e-6, max: 1e6 })?.unwrap_or(1.0),
            photos,
            combine: combine.unwrap_or(Combine::Product),
            fit: keys.text("fit")?.map(str::to_owned),
            models,
            designs,
            views,
        };
        keys.finish()?;
        Ok(sweep)
    }
}
