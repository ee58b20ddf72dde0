//! Designs: which values the numbers of a capture take together.

mod axis;
mod latin_hypercube;
mod list;

pub(crate) use axis::Axis;

use crate::fitted::Fitted;
use crate::keys::Keys;
use crate::points::Points;
use crate::{MOST_FRAMES, design_unit};
use gonio_scene::files::Files;
use gonio_scene::{Capture, Result, SceneError};

/// Most points of a Sobol design: the length of the tables behind it.
const MOST_SOBOL: u64 = 1 << 16;

/// One `[[design]]` of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Design {
    /// Where it stands in the sweep's file.
    place: String,
    kind: Kind,
}

#[derive(Debug, Clone, PartialEq)]
enum Kind {
    /// Every combination, the last axis fastest.
    Grid(Vec<Axis>),
    /// `count` points of which each axis sees one in each of `count` equal parts.
    LatinHypercube { axes: Vec<Axis>, count: u64, seed: u64 },
    /// The first `count` points of an Owen-scrambled Sobol sequence.
    Sobol { axes: Vec<Axis>, count: u64, seed: u64 },
    /// The rows of a CSV file.
    List(String),
    /// Draws from the uncertainty of a fit.
    Posterior { fit: String, count: u64, seed: u64 },
}

impl Design {
    /// Reads one `[[design]]`.
    pub fn read(mut keys: Keys<'_>) -> Result<Self> {
        let place = keys.path().to_owned();
        let kinds = [("grid", 0), ("latin-hypercube", 1), ("sobol", 2), ("csv", 3), ("posterior", 4)];
        let kind = keys.word("kind", &kinds)?;
        let what = "one of: \"grid\", \"latin-hypercube\", \"sobol\", \"csv\", \"posterior\"";
        let kind = match keys.needed("kind", kind, what)? {
            0 => Kind::Grid(axes(&mut keys, true)?),
            1 => {
                let (count, seed) = count_and_seed(&mut keys, MOST_FRAMES, u64::MAX >> 1)?;
                Kind::LatinHypercube { axes: axes(&mut keys, false)?, count, seed }
            }
            2 => {
                let (count, seed) = count_and_seed(&mut keys, MOST_SOBOL, u64::from(u32::MAX))?;
                let axes = axes(&mut keys, false)?;
                if axes.len() > sobol_burley::NUM_DIMENSIONS as usize {
                    let problem = format!("has {} entries", axes.len());
                    let mend = format!("list at most {}", sobol_burley::NUM_DIMENSIONS);
                    return Err(keys.refuse("axes", problem, mend));
                }
                Kind::Sobol { axes, count, seed }
            }
            3 => {
                let file = keys.text("file")?;
                Kind::List(keys.needed("file", file, "the path of a CSV file, relative to this one")?.to_owned())
            }
            _ => {
                let (count, seed) = count_and_seed(&mut keys, MOST_SOBOL, u64::from(u32::MAX))?;
                let fit = keys.text("fit")?;
                let fit = keys.needed("fit", fit, "the path of a fit.json, relative to this file")?.to_owned();
                Kind::Posterior { fit, count, seed }
            }
        };
        keys.finish()?;
        Ok(Self { place, kind })
    }

    /// The points of this design for a capture. `file` is the sweep's, whose folder `files` reads.
    ///
    /// # Errors
    /// A name that the capture does not have, a value out of bounds, a broken list, too many points.
    pub fn points(&self, capture: &Capture, file: &str, files: &dyn Files) -> Result<Points> {
        let resolved = |axes: &[Axis]| {
            let mut axes = axes.to_vec();
            axes.iter_mut().try_for_each(|axis| axis.resolve(capture, file))?;
            Ok::<_, SceneError>(axes)
        };
        let points = match &self.kind {
            Kind::Grid(axes) => grid(&resolved(axes)?, file, &self.place)?,
            Kind::LatinHypercube { axes, count, seed } => {
                let columns = latin_hypercube::columns(axes.len(), *count as usize, *seed);
                of_unit(&resolved(axes)?, *count, |i, axis| columns[axis][i as usize])
            }
            Kind::Sobol { axes, count, seed } => {
                of_unit(&resolved(axes)?, *count, |i, axis| design_unit(i, axis as u32, *seed as u32))
            }
            Kind::List(path) => list::read(path, capture, files)?,
            Kind::Posterior { fit, count, seed } => Fitted::read(fit, capture, files)?.draws(*count, *seed as u32)?,
        };
        points.named_once(file, &self.place)
    }
}

fn axes(keys: &mut Keys<'_>, grid: bool) -> Result<Vec<Axis>> {
    let tables = keys.tables("axes")?;
    if tables.is_empty() {
        let mend = "list at least one: axes = [{ name = \"material.shell.roughness\", values = [0.2, 0.4] }]";
        return Err(keys.refuse("axes", "is missing or empty", mend));
    }
    tables.into_iter().map(|table| Axis::read(table, grid, MOST_FRAMES)).collect()
}

fn count_and_seed(keys: &mut Keys<'_>, most: u64, most_seed: u64) -> Result<(u64, u64)> {
    let count = keys.whole("count", 1..=most)?;
    let count = keys.needed("count", count, "the number of points")?;
    Ok((count, keys.whole("seed", 0..=most_seed)?.unwrap_or(0)))
}

fn names(axes: &[Axis]) -> Vec<String> {
    axes.iter().flat_map(|axis| axis.numbers.iter().cloned()).collect()
}

fn grid(axes: &[Axis], file: &str, place: &str) -> Result<Points> {
    let total = axes.iter().try_fold(1_u64, |product, axis| product.checked_mul(axis.grid_count()));
    let Some(total) = total.filter(|total| *total <= MOST_FRAMES) else {
        let problem = format!("has more than {MOST_FRAMES} points");
        return Err(SceneError::new(file, problem, "take fewer values, or a Sobol design").at(format!("{place}.axes")));
    };
    let mut rows = Vec::with_capacity(total as usize);
    for point in 0..total {
        let mut left = point;
        let mut indices = vec![0; axes.len()];
        for (index, axis) in indices.iter_mut().zip(axes).rev() {
            *index = left % axis.grid_count();
            left /= axis.grid_count();
        }
        let mut row = Vec::new();
        axes.iter().zip(indices).for_each(|(axis, index)| axis.at_index(index, &mut row));
        rows.push(row);
    }
    Ok(Points { names: names(axes), rows })
}

/// Points from numbers in 0..1, one for each point and axis.
fn of_unit(axes: &[Axis], count: u64, unit: impl Fn(u64, usize) -> f64) -> Points {
    let row = |i| {
        let mut row = Vec::new();
        axes.iter().enumerate().for_each(|(a, axis)| axis.at(unit(i, a), &mut row));
        row
    };
    Points { names: names(axes), rows: (0..count).map(row).collect() }
}
