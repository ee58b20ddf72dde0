//! The plan: every frame of a sweep, in the order of its table.

use crate::digest::Hasher;
use crate::fitted::Fitted;
use crate::listed::Listed;
use crate::outputs::Output;
use crate::points::Points;
use crate::resolution;
use crate::sweep::{Combine, Seeds, Sweep};
use crate::{MOST_FRAMES, MOST_PHOTOS};
use gonio_scene::capture::Photo;
use gonio_scene::files::Files;
use gonio_scene::{Capture, Result, SceneError};

/// Everything that a sweep of a capture renders.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The capture with its cameras scaled and the views as further photos, whose files do not exist.
    pub capture: Capture,
    /// What a BOP dataset of the frames lists.
    pub models: Vec<Listed>,
    /// For each photo of the capture, which image of another dataset it repeats.
    pub labels: Vec<Option<Label>>,
    /// Dotted names of the numbers that vary.
    pub names: Vec<String>,
    /// Values of `names` at every point.
    pub points: Vec<Vec<f64>>,
    /// The frames: point by point, and for each point view by view.
    pub frames: Vec<Frame>,
    /// Samples per pixel, both halves together.
    pub samples: u32,
    /// What is written of each frame; at least one.
    pub outputs: Vec<Output>,
    /// Stops by which PNGs are brighter than their photo values.
    pub png_stops: f64,
}

/// An image of a BOP dataset.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Label {
    /// Number of the scene.
    pub scene: u32,
    /// Number of the image.
    pub image: u32,
}

/// One render.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame {
    /// Index of the point.
    pub point: usize,
    /// Index of the photo in the extended capture.
    pub photo: usize,
    /// Seed of its random numbers.
    pub seed: u64,
}

/// Frames that one evaluation renders: of one point, with one seed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Batch {
    /// Indices of the frames, at least one.
    pub frames: Vec<usize>,
}

impl Sweep {
    /// Every frame of this sweep of `capture`; `files` reads from the folder of the sweep's file.
    ///
    /// # Errors
    /// Names, photos and lights that the capture does not have; values out of bounds or that contradict each other; a
    /// broken list; more frames or photos than there may be.
    pub fn plan(&self, capture: &Capture, files: &dyn Files) -> Result<Plan> {
        self.plan_with(capture, files, &[])
    }

    /// As [`Sweep::plan`], with `numbers` set last: after what a fit says, before what designs vary.
    ///
    /// # Errors
    /// As there, and numbers that the capture does not have.
    pub fn plan_with(&self, capture: &Capture, files: &dyn Files, numbers: &[(String, f64)]) -> Result<Plan> {
        let refuse = |key: &str, problem: String, mend: &str| SceneError::new(&self.file, problem, mend).at(key);
        let mut extended = capture.clone();
        extended.reflectance.clear();
        extended.fit = gonio_scene::capture::Freed::default();
        if let Some(fit) = &self.fit {
            extended.set_numbers(&Fitted::read(fit, &extended, files)?.numbers())?;
        }
        extended.set_numbers(numbers)?;
        let views = self.views.iter().map(|view| view.resolved(&extended, files)).collect::<Result<Vec<_>>>()?;
        let mut labels: Vec<Option<Label>> = vec![None; extended.photos.len()];
        let count: u64 = views.iter().map(crate::view::View::count).sum();
        if count + extended.photos.len() as u64 > MOST_PHOTOS {
            let problem = format!("has {count} views besides {} photos", extended.photos.len());
            return Err(refuse("view", problem, &format!("keep to {MOST_PHOTOS} in all")));
        }
        let own = extended.photos.len();
        views.iter().for_each(|view| view.extend(&mut extended, &mut labels));
        resolution::scale(&mut extended, self.resolution, &self.file)?;
        // What the views add is held against the whole, by the capture's own rules.
        let text = extended.to_toml().map_err(|e| self.reworded(e, "view"))?;
        let extended = Capture::parse(&text).map_err(|e| self.reworded(e, "view"))?;
        let photos = self.photos(&extended, own)?;

        let mut points = Points::one();
        for design in &self.designs {
            points = points.times(&design.points(&extended, &self.file, files)?, &self.file)?;
        }
        self.check(&extended, &points)?;
        let (n, seeds) = (photos.len(), self.point_seeds(&points));
        let frame = |point: usize, photo: usize| Frame { point, photo, seed: seeds[point] };
        let frames: Vec<Frame> = match self.combine {
            Combine::Product if (points.rows.len() as u64).saturating_mul(n as u64) > MOST_FRAMES => {
                let problem = format!("has {} points and {n} views", points.rows.len());
                return Err(refuse("design", problem, &format!("keep to {MOST_FRAMES} frames")));
            }
            Combine::Product => (0..points.rows.len())
                .flat_map(|i| photos.iter().map(move |p| (i, *p)))
                .map(|(i, p)| frame(i, p))
                .collect(),
            Combine::Pairs if points.rows.len() != n => {
                let problem = format!("is \"pairs\", but there are {} points and {n} views", points.rows.len());
                return Err(refuse("combine", problem, "write as many points as views, or combine = \"product\""));
            }
            Combine::Pairs => photos.iter().enumerate().map(|(i, photo)| frame(i, *photo)).collect(),
        };
        let models = self.models.iter().map(|model| model.resolved(&extended, &self.file)).collect::<Result<_>>()?;
        Ok(Plan {
            models,
            labels,
            capture: extended,
            names: points.names,
            points: points.rows,
            frames,
            samples: self.samples,
            outputs: self.outputs.clone(),
            png_stops: self.png_stops,
        })
    }

    /// Indices of the photos that are rendered: those that are named, then the views.
    fn photos(&self, extended: &Capture, own: usize) -> Result<Vec<usize>> {
        let refuse = |problem: String, mend: String| SceneError::new(&self.file, problem, mend).at("photos");
        let mut photos = Vec::new();
        match &self.photos {
            None if self.views.is_empty() => photos.extend(0..own),
            None => {}
            Some(names) => {
                for name in names {
                    let Some(index) = extended.photo_index(name).filter(|index| *index < own) else {
                        let known: Vec<&str> = extended.photos.iter().take(own.min(20)).map(Photo::name).collect();
                        let problem = format!("names {name:?}, which is no photo");
                        return Err(refuse(problem, format!("the photos are: {}", known.join(", "))));
                    };
                    if photos.contains(&index) {
                        return Err(refuse(format!("names {name:?} twice"), "name it once".to_owned()));
                    }
                    photos.push(index);
                }
            }
        }
        photos.extend(own..extended.photos.len());
        if photos.is_empty() {
            let problem = "is absent, and the capture has no photo".to_owned();
            return Err(refuse(problem, "add a [[view]]".to_owned()));
        }
        Ok(photos)
    }

    /// That the capture takes every point: bounds were checked by axis, but values may contradict each other.
    fn check(&self, extended: &Capture, points: &Points) -> Result<()> {
        for row in &points.rows {
            let mut at = extended.clone();
            let numbers: Vec<_> = points.names.iter().cloned().zip(row.iter().copied()).collect();
            at.set_numbers(&numbers).and_then(|()| at.partly_present().map(|_| ())).map_err(|error| {
                let list: Vec<String> =
                    numbers.iter().take(6).map(|(name, value)| format!("{name} = {value}")).collect();
                let key = error.key.map(|key| format!("{key} ")).unwrap_or_default();
                let problem = format!("has a point at which {key}{}, with {}", error.problem, list.join(", "));
                SceneError::new(&self.file, problem, error.mend).at("design")
            })?;
        }
        Ok(())
    }

    /// The seed of every point: of its values alone, so that points may be added and moved about.
    fn point_seeds(&self, points: &Points) -> Vec<u64> {
        let own = |row: &Vec<f64>| {
            let mut hasher = Hasher::default();
            hasher.number(self.seed);
            for (name, value) in points.names.iter().zip(row) {
                hasher.field(name.as_bytes());
                hasher.number(value.to_bits());
            }
            let digest = hasher.finish();
            // 63 bits: what a Parquet reader and TOML's integers hold.
            u64::from_le_bytes(std::array::from_fn(|i| digest[i])) >> 1
        };
        match self.seeds {
            Seeds::Shared => vec![self.seed; points.rows.len()],
            Seeds::Independent => points.rows.iter().map(own).collect(),
        }
    }

    /// An error of the extended capture as one of this file.
    fn reworded(&self, error: SceneError, key: &str) -> SceneError {
        let at = error.key.map(|key| format!("{key} ")).unwrap_or_default();
        SceneError::new(&self.file, format!("{at}{}", error.problem), error.mend).at(key)
    }
}

impl Plan {
    /// The numbers that an evaluation of `frame` sets.
    #[must_use]
    pub fn numbers(&self, frame: &Frame) -> Vec<(String, f64)> {
        self.names.iter().cloned().zip(self.points[frame.point].iter().copied()).collect()
    }

    /// Pixels of a frame.
    #[must_use]
    pub fn pixels(&self, frame: &Frame) -> u64 {
        let camera = self.capture.camera_of(&self.capture.photos[frame.photo]);
        u64::from(camera.width) * u64::from(camera.height)
    }

    /// The frames of `wanted`, which ascend, in batches of consecutive ones with the same point and seed. No batch has
    /// more camera samples than `most`, unless it is a single frame.
    #[must_use]
    pub fn batches(&self, wanted: &[usize], most: u64) -> Vec<Batch> {
        let mut batches: Vec<Batch> = Vec::new();
        let mut samples = 0_u64;
        for &index in wanted {
            let frame = &self.frames[index];
            let cost = self.pixels(frame).saturating_mul(u64::from(self.samples));
            samples = samples.saturating_add(cost);
            let first = batches.last().and_then(|batch| batch.frames.first()).map(|first| self.frames[*first]);
            match batches.last_mut() {
                Some(batch)
                    if samples <= most && first.is_some_and(|f| f.point == frame.point && f.seed == frame.seed) =>
                {
                    batch.frames.push(index);
                }
                _ => {
                    samples = cost;
                    batches.push(Batch { frames: vec![index] });
                }
            }
        }
        batches
    }
}
